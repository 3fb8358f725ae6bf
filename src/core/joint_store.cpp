#include "joint_store.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rotor.h"
#include "tasks.h"

namespace psim {

using kernels::JointBodies;
using kernels::JointKind;
using kernels::JointParams;
using kernels::kBlock;

namespace {

// Share of a position error that a substep takes back.
constexpr double kBias = 0.5;
constexpr std::uint32_t kJobBlocks = 64;     // 512 joints: a job of some microseconds
constexpr std::uint32_t kShareBlocks = 512;  // body blocks
// Sweeps a pass: as many as a frame can afford.
constexpr int kMostSweeps = 8, kLeastSweeps = 2;
constexpr std::uint32_t kFew = 32, kMany = 256;  // blocks
constexpr std::uint32_t kSmallGap = 8;           // body blocks that a range may reach over

float narrow(double v) { return static_cast<float>(v); }

// exp alone would be the library's: sinh from its series, doubled.
double sinh_of(double x) {
  int doublings = 0;
  while (x > 0.5) {
    x /= 2;
    ++doublings;
  }
  const double z = x * x;
  double s = x + x * z * (1.0 / 6 + z * (1.0 / 120 + z * (1.0 / 5040 + z / 362880)));
  for (; doublings > 0; --doublings) s = 2 * s * std::sqrt(1 + s * s);
  return s;
}

struct SpringRow {
  double push = 0, drag = 0;
};

// The implicit midpoint rule moves an oscillator of stiffness k', damping c' exactly as one of
// frequency w and damping rate r moves in reality, if the roots s' = (2/h) tanh(s h/2) belong to
// them (bilinear transform, frequencies warped beforehand; Tustin 1947). With q^2 = w^2 - r^2,
//   k'/m = 4/h^2 (S + Q)/(1 + S - Q),  c'/m = 4/h sinh(a) cosh(a)/(1 + S - Q)
//   a = r h/2,  S = sinh^2 a,  Q = sin^2(q h/2)
// What h does not resolve (w h > 1) is damped, critically from w h = 2 on: undamped it would gain energy
// from whatever turns or joins it.
SpringRow spring_row(double stiffness, double damping, double mass, double h) {
  SpringRow out;
  if (!(mass > 0) || !(stiffness > 0 || damping > 0)) return out;
  const double w = std::sqrt(stiffness / mass);
  const double r = std::fmax(damping / (2 * mass), w * std::fmin(std::fmax(w * h - 1, 0), 1));
  const double a = r * h / 2;
  double k = 0, c = 0;  // h^2/4 k'/m, h/4 c'/m
  if (w > r) {
    const double s = sinh_of(a), q = sine_cosine(std::sqrt(w * w - r * r) * h / 2).sine;
    const double below = 1 + s * s - q * q;
    k = (s * s + q * q) / below;
    c = s * std::sqrt(1 + s * s) / below;
  } else {  // overdamped: Q = -sinh^2 b
    const double b = std::sqrt(r * r - w * w) * h / 2;
    const double less = a + b > 0 ? w * w * h * h / 4 / (a + b) : 0;  // a - b
    const double t = sinh_of(std::fmin(less, 30.0));
    if (a < 15) {
      const double s = sinh_of(a), sb = sinh_of(b);
      const double below = 1 + s * s + sb * sb;
      k = sinh_of(a + b) * t / below;
      c = s * std::sqrt(1 + s * s) / below;
    } else {
      k = t / std::sqrt(1 + t * t);
      c = (1 + k) / 2;
    }
  }
  out.push = 4 * mass * k / h;
  out.drag = mass * (k + 2 * c);
  return out;
}

Vec2 turned(double c, double s, Vec2 p) { return {c * p.x - s * p.y, s * p.x + c * p.y}; }

}  // namespace

// ---- by id ------------------------------------------------------------------------------------------

void JointStore::exclude(const JointDesc& d, int sign) {
  if (d.collide) return;
  const std::uint32_t most = std::max(d.a.index, d.b.index);
  if (exclusive_.size() <= most) exclusive_.resize(std::size_t{most} + 1);
  const std::uint64_t key = pair_key(d.a.index, d.b.index);
  if (sign > 0) {
    ++exclusions_[key];
    ++exclusive_[d.a.index];
    ++exclusive_[d.b.index];
    return;
  }
  const auto found = exclusions_.find(key);
  if (--found->second == 0) exclusions_.erase(found);
  --exclusive_[d.a.index];
  --exclusive_[d.b.index];
}

JointId JointStore::add(const JointDesc& d, const BodyStore& bodies) {
  std::uint32_t index;
  if (free_.empty()) {
    index = static_cast<std::uint32_t>(joints_.size());
    joints_.emplace_back();
  } else {
    index = free_.back();
    free_.pop_back();
  }
  Joint& j = joints_[index];
  const std::uint32_t generation = j.generation;
  j = Joint{};
  j.generation = generation;
  j.desc = d;
  j.alive = true;
  const auto dynamic = [&](BodyId id) { return bodies.surface(id.index).inv_mass > 0; };
  j.swapped = !dynamic(d.b);
  const bool held = j.swapped || !dynamic(d.a);
  switch (d.type) {
    case JointType::distance:
    case JointType::rope:
      j.kind = JointKind::rod;
      break;
    case JointType::spring:
      j.kind = JointKind::spring;
      break;
    case JointType::revolute:
      j.kind = d.lower || d.upper || d.motor_limit > 0 ? JointKind::driven : JointKind::pin;
      break;
    case JointType::prismatic:
      j.kind = JointKind::slide;
      break;
    case JointType::weld:
      j.kind = JointKind::weld;
      break;
  }
  j.list = 2 * static_cast<std::uint32_t>(j.kind) + (held ? 1 : 0);
  j.lane = kNoSlot;
  tie(index);
  exclude(d, +1);
  ++count_;
  stale_ = bodies_stale_ = true;
  return {index, generation};
}

bool JointStore::remove(JointId id) {
  if (!is_valid(id)) return false;
  Joint& j = joints_[id.index];
  exclude(j.desc, -1);
  untie(id.index);
  if (j.lane != kNoSlot) lanes_[j.list][j.lane] = kNoSlot;
  j.alive = false;
  ++j.generation;
  free_.push_back(id.index);
  --count_;
  stale_ = bodies_stale_ = true;
  return true;
}

void JointStore::remove_of_body(std::uint32_t body) {
  while (body < first_.size() && first_[body] != kNoSlot) {
    const std::uint32_t index = first_[body];
    remove({index, joints_[index].generation});
  }
}

// The joints of a body are a list: first_, then next of the joint's side.
void JointStore::tie(std::uint32_t index) {
  Joint& j = joints_[index];
  const std::uint32_t ends[2] = {j.desc.a.index, j.desc.b.index};
  const std::size_t most = std::max(ends[0], ends[1]);
  if (first_.size() <= most) first_.resize(most + 1, kNoSlot);
  for (int side = 0; side < 2; ++side) {
    j.next[side] = first_[ends[side]];
    first_[ends[side]] = index;
  }
}

void JointStore::untie(std::uint32_t index) {
  const Joint& j = joints_[index];
  const std::uint32_t ends[2] = {j.desc.a.index, j.desc.b.index};
  for (int side = 0; side < 2; ++side) {
    std::uint32_t* link = &first_[ends[side]];
    while (*link != index) {
      Joint& other = joints_[*link];
      link = &other.next[other.desc.a.index == ends[side] ? 0 : 1];
    }
    *link = j.next[side];
  }
}

bool JointStore::set_motor(JointId id, double speed, double limit) {
  if (!is_valid(id)) return false;
  Joint& j = joints_[id.index];
  if (j.desc.type != JointType::revolute && j.desc.type != JointType::prismatic) return false;
  j.desc.motor_speed = speed;
  j.desc.motor_limit = limit;
  if (j.kind == JointKind::pin && limit > 0) {  // it gets blocks with a motor
    save_impulses();
    if (j.lane != kNoSlot) lanes_[j.list][j.lane] = kNoSlot;
    j.lane = kNoSlot;
    j.kind = JointKind::driven;
    j.list = 2 * static_cast<std::uint32_t>(j.kind) + (j.list & 1u);
    stale_ = true;
  }
  return true;
}

const std::vector<std::uint32_t>& JointStore::bodies() {
  if (!bodies_stale_) return bodies_;
  bodies_stale_ = false;
  bodies_.clear();
  for (const Joint& j : joints_) {
    if (!j.alive) continue;
    bodies_.push_back(j.desc.a.index);
    bodies_.push_back(j.desc.b.index);
  }
  std::sort(bodies_.begin(), bodies_.end());
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
  return bodies_;
}

// ---- blocks -----------------------------------------------------------------------------------------

kernels::JointBlocks JointStore::blocks(std::uint32_t list) {
  const std::uint32_t held = list & 1u;
  switch (static_cast<JointKind>(list / 2)) {
    case JointKind::rod:
      return rods_[held].data();
    case JointKind::spring:
      return springs_[held].data();
    case JointKind::pin:
      return pins_[held].data();
    case JointKind::driven:
      return driven_[held].data();
    case JointKind::slide:
      return slides_[held].data();
    default:
      return welds_[held].data();
  }
}

JointBodies& JointStore::block(std::uint32_t list, std::uint32_t i) {
  const std::uint32_t held = list & 1u;
  switch (static_cast<JointKind>(list / 2)) {
    case JointKind::rod:
      return rods_[held][i];
    case JointKind::spring:
      return springs_[held][i];
    case JointKind::pin:
      return pins_[held][i];
    case JointKind::driven:
      return driven_[held][i];
    case JointKind::slide:
      return slides_[held][i];
    default:
      return welds_[held][i];
  }
}

namespace {

// Places of the stored impulses in a lane: up to five.
template <class Each>
void for_impulses(JointKind kind, JointBodies& b, std::uint32_t lane, const Each& each) {
  switch (kind) {
    case JointKind::rod:
    case JointKind::spring:
      each(0, static_cast<kernels::LineBlock&>(b).l[lane]);
      break;
    case JointKind::pin:
    case JointKind::driven:
    case JointKind::weld: {
      auto& pin = static_cast<kernels::PinBlock&>(b);
      each(0, pin.px[lane]);
      each(1, pin.py[lane]);
      if (kind == JointKind::weld) each(2, static_cast<kernels::WeldBlock&>(b).l[lane]);
      if (kind != JointKind::driven) break;
      auto& drive = static_cast<kernels::DrivenBlock&>(b).drive;
      each(2, drive.limit_l[lane]);
      each(3, drive.motor_l[lane]);
      break;
    }
    case JointKind::slide: {
      auto& slide = static_cast<kernels::SlideBlock&>(b);
      each(0, slide.l[lane]);
      each(1, slide.turn_l[lane]);
      each(2, slide.drive.limit_l[lane]);
      each(3, slide.drive.motor_l[lane]);
    }
  }
}

}  // namespace

// Impulses live in the blocks; while those are made anew, with the joints.
void JointStore::save_impulses() {
  for (std::uint32_t list = 0; list < kLists; ++list) {
    for (std::uint32_t lane = 0; lane < lanes_[list].size(); ++lane) {
      if (lanes_[list][lane] == kNoSlot) continue;
      Joint& j = joints_[lanes_[list][lane]];
      for_impulses(j.kind, block(list, lane / kBlock), lane % kBlock,
                   [&](int i, float& l) { j.impulse[i] = l; });
    }
  }
}

// Greedy colours in the order of ids; by colour, then by kind. Within a colour no two lanes share a
// dynamic body; after the last colour blocks hold one lane each.
void JointStore::lay_out(const BodyStore& b) {
  save_impulses();
  const std::vector<std::uint32_t>& ids = bodies();
  const auto member = [&](std::uint32_t id) {
    return static_cast<std::uint32_t>(std::lower_bound(ids.begin(), ids.end(), id) - ids.begin());
  };
  std::vector<std::uint32_t> used(ids.size(), 0);
  std::vector<std::uint32_t> of_class[kColours + 1];
  for (std::uint32_t i = 0; i < joints_.size(); ++i) {
    Joint& j = joints_[i];
    if (!j.alive) continue;
    j.body[0] = member(j.swapped ? j.desc.b.index : j.desc.a.index);
    j.body[1] = member(j.swapped ? j.desc.a.index : j.desc.b.index);
    const bool held = (j.list & 1u) != 0;
    const std::uint32_t taken = used[j.body[1]] | (held ? 0 : used[j.body[0]]);
    const std::uint32_t colour = std::min(static_cast<std::uint32_t>(std::countr_one(taken)), kColours);
    if (colour < kColours) {
      used[j.body[1]] |= 1u << colour;
      if (!held) used[j.body[0]] |= 1u << colour;
    }
    of_class[colour].push_back(i);
  }
  for (auto& lanes : lanes_) lanes.clear();
  std::vector<std::uint32_t> begin_of_colour;
  for (std::uint32_t colour = 0; colour <= kColours; ++colour) {
    for (std::uint32_t list = 0; list < kLists; ++list) {
      begin_of_colour.push_back(static_cast<std::uint32_t>(lanes_[list].size() / kBlock));
    }
    for (const std::uint32_t i : of_class[colour]) {
      auto& lanes = lanes_[joints_[i].list];
      if (colour == kColours) lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
      joints_[i].lane = static_cast<std::uint32_t>(lanes.size());
      lanes.push_back(i);
    }
    for (auto& lanes : lanes_) lanes.resize(kernels::round_up_block(lanes.size()), kNoSlot);
  }
  for (std::uint32_t list = 0; list < kLists; ++list) {
    begin_of_colour.push_back(static_cast<std::uint32_t>(lanes_[list].size() / kBlock));
  }
  const auto size = [&](JointKind kind, std::uint32_t held) {
    return lanes_[2 * static_cast<std::uint32_t>(kind) + held].size() / kBlock;
  };
  for (std::uint32_t held = 0; held < 2; ++held) {
    rods_[held].assign(size(JointKind::rod, held), {});
    springs_[held].assign(size(JointKind::spring, held), {});
    pins_[held].assign(size(JointKind::pin, held), {});
    driven_[held].assign(size(JointKind::driven, held), {});
    slides_[held].assign(size(JointKind::slide, held), {});
    welds_[held].assign(size(JointKind::weld, held), {});
  }
  for (std::uint32_t list = 0; list < kLists; ++list) {
    for (std::uint32_t lane = 0; lane < lanes_[list].size(); ++lane) {
      if (lanes_[list][lane] == kNoSlot) continue;
      Joint& j = joints_[lanes_[list][lane]];
      JointBodies& at = block(list, lane / kBlock);
      const std::uint32_t k = lane % kBlock;
      for_impulses(j.kind, at, k, [&](int i, float& l) { l = j.impulse[i]; });
      const Surface& sa = b.surface(ids[j.body[0]]);
      const Surface& sb = b.surface(ids[j.body[1]]);
      at.wa[k] = sa.inv_mass;
      at.wb[k] = sb.inv_mass;
    }
  }
  make_jobs(begin_of_colour);
}

// Jobs of a colour run side by side. Blocks with empty lanes are in one job, for those share a record.
void JointStore::make_jobs(const std::vector<std::uint32_t>& begin_of_colour) {
  ranges_.clear();
  jobs_.clear();
  phases_.clear();
  total_blocks_ = 0;
  for (std::uint32_t colour = 0; colour <= kColours; ++colour) {
    const std::uint32_t* begin = &begin_of_colour[std::size_t{colour} * kLists];
    const std::uint32_t* end = begin + kLists;
    std::uint32_t blocks_here = 0;
    for (std::uint32_t list = 0; list < kLists; ++list) blocks_here += end[list] - begin[list];
    if (blocks_here == 0) continue;
    total_blocks_ += blocks_here;
    const auto first = static_cast<std::uint32_t>(jobs_.size());
    std::vector<BlockRange> rest;
    const bool whole = blocks_here <= kJobBlocks || colour == kColours;
    for (std::uint32_t list = 0; list < kLists; ++list) {
      std::uint32_t at = begin[list], last = end[list];
      if (at == last) continue;
      if (whole) {
        rest.push_back({list, at, last});
        continue;
      }
      if (lanes_[list][std::size_t{last} * kBlock - 1] == kNoSlot)
        rest.push_back({list, --last, last + 1});
      for (; at < last; at += kJobBlocks) {
        const auto place = static_cast<std::uint32_t>(ranges_.size());
        ranges_.push_back({list, at, std::min(last, at + kJobBlocks)});
        jobs_.push_back({place, place + 1});
      }
    }
    if (!rest.empty()) {
      const auto place = static_cast<std::uint32_t>(ranges_.size());
      ranges_.insert(ranges_.end(), rest.begin(), rest.end());
      jobs_.push_back({place, static_cast<std::uint32_t>(ranges_.size())});
    }
    phases_.push_back({first, static_cast<std::uint32_t>(jobs_.size())});
  }
}

// ---- once a frame -----------------------------------------------------------------------------------

void JointStore::find_members(const BodyStore& b, const std::vector<FixedBody>& fixed,
                              const SolverBodies& numbers, const Lattice& lattice,
                              WorkerPool& pool) {
  members_.resize(bodies_.size());
  constexpr std::size_t kEach = 512;
  pool.run((members_.size() + kEach - 1) / kEach, [&](std::size_t job) {
    for (std::size_t n = job * kEach; n < std::min(members_.size(), (job + 1) * kEach); ++n) {
      Member& m = members_[n];
      const std::uint32_t id = bodies_[n];
      const BodyInfo& info = b.info[id];
      const Make& make = b.make(id);
      m.spin_gain = static_cast<double>(b.surface(id).spin_gain);
      m.centre_x = static_cast<double>(make.centre_x);
      m.centre_y = static_cast<double>(make.centre_y);
      m.fixed = info.place != Place::moving;
      if (m.fixed) {
        const FixedBody& f = fixed[info.slot];
        const LatticePoint p = lattice.to_lattice({f.x, f.y});
        m.x = p.x;
        m.y = p.y;
        m.rest_x = static_cast<double>(p.dx);
        m.rest_y = static_cast<double>(p.dy);
        m.angle = f.angle;
        m.centre_x = m.centre_y = 0;
        m.inverse_radius = 1;
        m.number = static_record_;
      } else {
        const std::size_t slot = info.slot;
        m.x = b.pos[2 * slot];
        m.y = b.pos[2 * slot + 1];
        m.rest_x = m.rest_y = 0;
        m.angle = b.angle[slot];
        m.inverse_radius = 1 / static_cast<double>(b.radius[slot]);
        m.number = numbers.number(info.slot);
      }
      const SineCosine turn = sine_cosine(m.angle);
      m.c = turn.cosine;
      m.s = turn.sine;
    }
  });
}

// Which blocks of bodies have joints: what they did is summed there.
void JointStore::find_shares(const SolverBodies& numbers) {
  const std::uint32_t body_blocks = numbers.blocks();
  marks_.assign(body_blocks, 0);
  for (const Member& m : members_) {
    if (!m.fixed) marks_[m.number / kBlock] = 1;
  }
  share_ranges_.clear();
  for (std::uint32_t i = 0; i < body_blocks; ++i) {
    if (marks_[i] == 0) continue;
    if (!share_ranges_.empty() && i - share_ranges_.back().end <= kSmallGap &&
        i + 1 - share_ranges_.back().begin <= kShareBlocks) {
      share_ranges_.back().end = i + 1;
    } else {
      share_ranges_.push_back({0, i, i + 1});
    }
  }
  share_jobs_.clear();
  std::uint32_t sum = kShareBlocks;
  for (std::uint32_t r = 0; r < share_ranges_.size(); ++r) {
    if (sum >= kShareBlocks) {
      share_jobs_.push_back({r, r});
      sum = 0;
    }
    sum += share_ranges_[r].end - share_ranges_[r].begin;
    share_jobs_.back().end = r + 1;
  }
  const std::size_t all = std::size_t{body_blocks} * kBlock;
  share_vel_.reserve(2 * all);
  share_spin_.reserve(all);
  push_vel_.reserve(2 * (all + kBlock));
  push_spin_.reserve(all + kBlock);
  std::fill_n(push_vel_.data() + 2 * all, 2 * kBlock, 0.0f);  // static bodies, empty lanes
  std::fill_n(push_spin_.data() + all, kBlock, 0.0f);
}

// Of turning B against A while their anchors stay together, kg m^2: the angle's share of the inverse of
// the matrix of three rows.
double JointStore::pinned_inertia(const JointBodies& b, std::uint32_t k, const Member& ma,
                                  const Member& mb, Vec2 a, Vec2 c) const {
  const double ia = ma.spin_gain * ma.inverse_radius * ma.inverse_radius;
  const double ib = mb.spin_gain * mb.inverse_radius * mb.inverse_radius;
  const double w = static_cast<double>(b.wa[k]) + static_cast<double>(b.wb[k]);
  const double k11 = w + ia * a.y * a.y + ib * c.y * c.y, k22 = w + ia * a.x * a.x + ib * c.x * c.x;
  const double k12 = -ia * a.x * a.y - ib * c.x * c.y;
  const double cx = -ia * a.y - ib * c.y, cy = ia * a.x + ib * c.x;
  const double below = k11 * k22 - k12 * k12;
  const double left = ia + ib - (k22 * cx * cx - 2 * k12 * cx * cy + k11 * cy * cy) / below;
  return left > 1e-9 * (ia + ib) ? 1 / left : 0;
}

void JointStore::fill_lane(std::uint32_t list, JointBodies& b, std::uint32_t k, Joint* j) {
  if (j == nullptr) {
    b.body[2 * k] = b.body[2 * k + 1] = padding_;
    return;
  }
  const Member& ma = members_[j->body[0]];
  const Member& mb = members_[j->body[1]];
  b.body[2 * k] = ma.number;
  b.body[2 * k + 1] = mb.number;
  b.ra[k] = narrow(ma.inverse_radius);
  b.rb[k] = narrow(mb.inverse_radius);
  b.ga[k] = b.ga0[k] = narrow(ma.spin_gain);
  b.gb[k] = b.gb0[k] = narrow(mb.spin_gain);
  const JointDesc& d = j->desc;
  const Vec2 anchor_a = j->swapped ? d.anchor_b : d.anchor_a;
  const Vec2 anchor_b = j->swapped ? d.anchor_a : d.anchor_b;
  const Vec2 arm_a = turned(ma.c, ma.s, {anchor_a.x - ma.centre_x, anchor_a.y - ma.centre_y});
  const Vec2 arm_b = turned(mb.c, mb.s, {anchor_b.x - mb.centre_x, anchor_b.y - mb.centre_y});
  b.ax0[k] = narrow(arm_a.x * ma.inverse_radius);
  b.ay0[k] = narrow(arm_a.y * ma.inverse_radius);
  b.bx0[k] = narrow(arm_b.x * mb.inverse_radius);
  b.by0[k] = narrow(arm_b.y * mb.inverse_radius);
  // From A's anchor to B's, without what lies in `disp`. Differences of lattice points are exact.
  const double x = wrap_sub(mb.x, ma.x) * pitch_x_ + (mb.rest_x - ma.rest_x) + (arm_b.x - arm_a.x);
  const double y = wrap_sub(mb.y, ma.y) * pitch_y_ + (mb.rest_y - ma.rest_y) + (arm_b.y - arm_a.y);
  const double sign = j->swapped ? -1 : 1;
  const double angle = (mb.angle - ma.angle) - sign * d.reference.value_or(0);
  const auto drive = [&](kernels::Drive& at, double way) {
    const double none = 1e30;
    const double lower = d.lower.value_or(-none), upper = d.upper.value_or(none);
    at.lower[k] = narrow(way > 0 ? lower : -upper);
    at.upper[k] = narrow(way > 0 ? upper : -lower);
    at.speed[k] = narrow(way * d.motor_speed);
    at.most[k] = narrow(std::fmin(d.motor_limit * h_, 1e30));
  };
  const auto line = [&](kernels::LineBlock& at) {
    const double far = std::sqrt(x * x + y * y);
    at.dx0[k] = narrow(x);
    at.dy0[k] = narrow(y);
    at.far0[k] = narrow(far);
    at.c0[k] = narrow(far - *d.length);
    at.top[k] = d.type == JointType::rope ? 0.0f : 1e30f;
    if (at.nx[k] == 0 && at.ny[k] == 0) at.ny[k] = 1;
    if (j->kind != JointKind::spring) return;
    const double nx = far > 0 ? x / far : 0, ny = far > 0 ? y / far : 1;
    const double sa = arm_a.x * ny - arm_a.y * nx, sb = arm_b.x * ny - arm_b.y * nx;
    const auto part = [&](float w, float g, double s, double inverse) {
      return static_cast<double>(w) + static_cast<double>(g) * s * s * inverse * inverse;
    };
    const double mass = 1 / (part(b.wa[k], b.ga[k], sa, ma.inverse_radius) +
                             part(b.wb[k], b.gb[k], sb, mb.inverse_radius));
    const SpringRow row = spring_row(d.stiffness, d.damping, mass, h_);
    at.push[k] = narrow(std::fmin(row.push, 1e30));
    at.drag[k] = narrow(std::fmin(row.drag, 1e30));
  };
  const auto pin = [&](kernels::PinBlock& at) {
    at.cx0[k] = narrow(x);
    at.cy0[k] = narrow(y);
  };
  switch (static_cast<JointKind>(list / 2)) {
    case JointKind::rod:
    case JointKind::spring:
      line(static_cast<kernels::LineBlock&>(b));
      break;
    case JointKind::pin:
      pin(static_cast<kernels::PinBlock&>(b));
      break;
    case JointKind::driven: {
      auto& at = static_cast<kernels::DrivenBlock&>(b);
      pin(at);
      at.angle0[k] = narrow(angle);
      drive(at.drive, sign);
      break;
    }
    case JointKind::weld: {
      auto& at = static_cast<kernels::WeldBlock&>(b);
      pin(at);
      at.angle0[k] = narrow(angle);
      if (!(d.stiffness > 0)) break;
      const SpringRow row =
          spring_row(d.stiffness, d.damping, pinned_inertia(b, k, ma, mb, arm_a, arm_b), h_);
      at.push[k] = narrow(std::fmin(row.push, 1e30));
      at.drag[k] = narrow(std::fmin(row.drag, 1e30));
      break;
    }
    case JointKind::slide: {
      auto& at = static_cast<kernels::SlideBlock&>(b);
      // The axis in side A's frame: seen from b it points the other way, and turned by the reference.
      const double size = std::sqrt(d.axis.x * d.axis.x + d.axis.y * d.axis.y);
      Vec2 axis{d.axis.x / size, d.axis.y / size};
      if (j->swapped) {
        const SineCosine back = sine_cosine(-d.reference.value_or(0));
        const Vec2 seen = turned(back.cosine, back.sine, axis);
        axis = {-seen.x, -seen.y};
      }
      const Vec2 u = turned(ma.c, ma.s, axis);
      at.ux0[k] = narrow(u.x);
      at.uy0[k] = narrow(u.y);
      at.along0[k] = narrow(u.x * x + u.y * y);
      at.off0[k] = narrow(u.x * y - u.y * x);
      at.angle0[k] = narrow(angle);
      drive(at.drive, 1);
    }
  }
}

void JointStore::fill(std::uint32_t list, std::uint32_t index) {
  JointBodies& b = block(list, index);
  for (std::uint32_t k = 0; k < kBlock; ++k) {
    const std::uint32_t i = lanes_[list][std::size_t{index} * kBlock + k];
    fill_lane(list, b, k, i == kNoSlot ? nullptr : &joints_[i]);
  }
}

void JointStore::prepare(const BodyStore& b, const std::vector<FixedBody>& fixed,
                         const SolverBodies& numbers, const Lattice& lattice, double h,
                         WorkerPool& pool) {
  if (empty()) return;
  b.find_slots();
  bodies();
  if (stale_) lay_out(b);
  stale_ = false;
  static_record_ = numbers.dummies();
  padding_ = static_record_ + 1;
  pitch_x_ = lattice.pitch_x();
  pitch_y_ = lattice.pitch_y();
  h_ = h;
  params_.h = narrow(h);
  params_.inv_h = narrow(1 / h);
  params_.rate = narrow(kBias / h);
  sweeps_ = total_blocks_ <= kFew    ? kMostSweeps
            : total_blocks_ <= kMany ? kMostSweeps / 2
                                     : kLeastSweeps;
  find_members(b, fixed, numbers, lattice, pool);
  find_shares(numbers);
  pool.run(jobs_.size(), [&](std::size_t n) {
    for (std::uint32_t r = jobs_[n].begin; r < jobs_[n].end; ++r) {
      for (std::uint32_t i = ranges_[r].begin; i < ranges_[r].end; ++i) fill(ranges_[r].list, i);
    }
  });
}

// ---- in every substep -------------------------------------------------------------------------------

template <class Pass>
void JointStore::sweep(const kernels::BodyView& view, const Pass& pass, const JointParams& p,
                       bool backwards, WorkerPool& pool) {
  for (std::size_t n = 0; n < phases_.size(); ++n) {
    const Phase& phase = phases_[backwards ? phases_.size() - 1 - n : n];
    pool.run(phase.end - phase.begin, [&](std::size_t i) {
      const Job& job = jobs_[phase.begin + i];
      for (std::uint32_t at = job.begin; at < job.end; ++at) {
        const BlockRange& r = ranges_[at];
        pass[r.list / 2][r.list & 1u](view, blocks(r.list), p, r.begin, r.end);
      }
    });
  }
}

template <class Each>
void JointStore::for_shares(const Each& each, WorkerPool& pool) {
  pool.run(share_jobs_.size(), [&](std::size_t n) {
    for (std::uint32_t r = share_jobs_[n].begin; r < share_jobs_[n].end; ++r) {
      each(share_ranges_[r].begin, share_ranges_[r].end);
    }
  });
}

void JointStore::warm(const kernels::BodyView& view, const kernels::KernelTable& k, float factor,
                      WorkerPool& pool) {
  if (empty()) return;
  for_shares(
      [&](std::uint32_t begin, std::uint32_t end) {
        const std::size_t from = std::size_t{begin} * kBlock, to = std::size_t{end} * kBlock;
        std::fill(share_vel_.data() + 2 * from, share_vel_.data() + 2 * to, 0.0f);
        std::fill(share_spin_.data() + from, share_spin_.data() + to, 0.0f);
        k.part_joints(view, share(), begin, end);
      },
      pool);
  parted_ = true;
  params_.warm = factor;
  sweep(view, k.warm_joints, params_, false, pool);
}

void JointStore::solve(const kernels::BodyView& view, const kernels::KernelTable& k,
                       WorkerPool& pool) {
  if (empty()) return;
  const auto part = [&](std::uint32_t begin, std::uint32_t end) {
    k.part_joints(view, share(), begin, end);
  };
  if (!parted_) for_shares(part, pool);
  JointParams p = params_;
  for (int n = 0; n < sweeps_; ++n) {
    p.again = n != 0;
    sweep(view, k.solve_joints, p, (n & 1) != 0, pool);
  }
  for_shares(
      [&](std::uint32_t begin, std::uint32_t end) {
        part(begin, end);
        const std::size_t from = std::size_t{begin} * kBlock, to = std::size_t{end} * kBlock;
        std::fill(push_vel_.data() + 2 * from, push_vel_.data() + 2 * to, 0.0f);
        std::fill(push_spin_.data() + from, push_spin_.data() + to, 0.0f);
      },
      pool);
  parted_ = false;
  kernels::BodyView pushed = view;
  pushed.vel = push_vel_.data();
  pushed.spin = push_spin_.data();
  for (int n = 0; n < sweeps_ / 2; ++n) sweep(pushed, k.push_joints, params_, (n & 1) != 0, pool);
}

void JointStore::hold(const kernels::BodyView& view, const kernels::KernelTable& k,
                      WorkerPool& pool) {
  if (empty()) return;
  for_shares(
      [&](std::uint32_t begin, std::uint32_t end) { k.hold_joints(view, share(), 1, begin, end); },
      pool);
}

void JointStore::release(const kernels::BodyView& view, const kernels::KernelTable& k,
                         WorkerPool& pool) {
  if (empty()) return;
  for_shares(
      [&](std::uint32_t begin, std::uint32_t end) { k.hold_joints(view, share(), -1, begin, end); },
      pool);
}

void JointStore::relax(const kernels::BodyView& view, const kernels::KernelTable& k,
                       WorkerPool& pool) {
  if (empty()) return;
  const auto part = [&](std::uint32_t begin, std::uint32_t end) {
    k.part_joints(view, share(), begin, end);
  };
  for_shares(part, pool);
  JointParams p = params_;
  for (int n = 0; n < sweeps_; ++n) {
    p.again = n != 0;
    sweep(view, k.relax_joints, p, (n & 1) == 0, pool);
  }
  for_shares(part, pool);
}

// ---- what a joint does ------------------------------------------------------------------------------

void JointStore::load_of(JointId id, Vec2& force, double& torque) const {
  const Joint& j = joints_[id.index];
  force = {};
  torque = 0;
  if (j.lane == kNoSlot || !(h_ > 0)) return;
  const std::uint32_t k = j.lane % kBlock, held = j.list & 1u;
  const std::size_t at = j.lane / kBlock;
  const double per_h = (j.swapped ? -1 : 1) / h_;
  const auto wide = [&](float v) { return static_cast<double>(v); };
  const auto line = [&](const kernels::LineBlock& b) {
    force = {wide(b.l[k]) * wide(b.nx[k]), wide(b.l[k]) * wide(b.ny[k])};
  };
  const auto pin = [&](const kernels::PinBlock& b) { force = {wide(b.px[k]), wide(b.py[k])}; };
  switch (j.kind) {
    case JointKind::rod:
      line(rods_[held][at]);
      break;
    case JointKind::spring:
      line(springs_[held][at]);
      break;
    case JointKind::pin:
      pin(pins_[held][at]);
      break;
    case JointKind::driven: {
      const auto& b = driven_[held][at];
      pin(b);
      torque = wide(b.drive.limit_l[k]) + wide(b.drive.motor_l[k]);
      break;
    }
    case JointKind::weld: {
      const auto& b = welds_[held][at];
      pin(b);
      torque = wide(b.l[k]);
      break;
    }
    case JointKind::slide: {
      const auto& b = slides_[held][at];
      const double l = wide(b.l[k]), t = wide(b.drive.limit_l[k]) + wide(b.drive.motor_l[k]);
      const double ux = wide(b.ux[k]), uy = wide(b.uy[k]);
      force = {t * ux - l * uy, t * uy + l * ux};
      torque = wide(b.turn_l[k]);
    }
  }
  force = {force.x * per_h, force.y * per_h};
  torque *= per_h;
}

}  // namespace psim
