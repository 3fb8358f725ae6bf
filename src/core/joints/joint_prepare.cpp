// Prepares the joints once a frame: every lane at the present places of its bodies, in double precision, and the bodies
// that have joints. O(joints).
#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/rotor.h"
#include "joints/joint_store.h"
#include "least.h"

namespace psim {

using kernels::JointBodies;
using kernels::JointKind;
using kernels::kBlock;

namespace {

// The share of a position error that a substep corrects.
constexpr double kBias = 0.5;
constexpr double kStiffest = 4;  // w^2 h^2 of springs in sweeps
constexpr int kMostSweeps = 8, kLeastSweeps = 2;
constexpr std::uint32_t kFew = 32, kMany = 256, kManyOfNets = 1024;  // blocks
constexpr std::uint32_t kShareBlocks = 512;                          // blocks of bodies in a job
constexpr std::uint32_t kSmallGap = 8;                               // blocks without joints that a range may contain

float narrow(double v) { return static_cast<float>(v); }
// The same for what may be next to nothing.
float narrow_small(double v) { return kernels::snapped(v, kernels::kLeastOffset); }

// The effective mass of pulling the anchors apart, kg, along the line `apart` from one to the other.
double line_mass(const JointMember& ma, const JointMember& mb, Vec2 arm_a, Vec2 arm_b, Vec2 apart) {
  const double far = length_of(apart);
  const Vec2 n = far > 0 ? Vec2{apart.x / far, apart.y / far} : Vec2{0, 1};
  const auto part = [](const JointMember& m, double s) {
    return m.inverse_mass + m.rim_gain * s * s * m.inverse_radius * m.inverse_radius;
  };
  return 1 / (part(ma, cross(arm_a, n)) + part(mb, cross(arm_b, n)));
}

// The effective mass of turning B against A while their anchors stay together, kg m^2: the entry of the angle in the
// inverse of the matrix of three rows.
double pinned_inertia(const JointMember& ma, const JointMember& mb, Vec2 a, Vec2 c) {
  const double ia = ma.rim_gain * ma.inverse_radius * ma.inverse_radius;
  const double ib = mb.rim_gain * mb.inverse_radius * mb.inverse_radius;
  const double w = ma.inverse_mass + mb.inverse_mass;
  const double k11 = w + ia * a.y * a.y + ib * c.y * c.y, k22 = w + ia * a.x * a.x + ib * c.x * c.x;
  const double k12 = -ia * a.x * a.y - ib * c.x * c.y;
  const double cx = -ia * a.y - ib * c.y, cy = ia * a.x + ib * c.x;
  const double below = k11 * k22 - k12 * k12;
  const double left = ia + ib - (k22 * cx * cx - 2 * k12 * cx * cy + k11 * cy * cy) / below;
  return left > 1e-9 * (ia + ib) ? 1 / left : 0;
}

void fill_line(kernels::LineBlock& at, std::uint32_t k, double length, bool rope, Vec2 apart) {
  const double far = length_of(apart);
  at.dx0[k] = narrow_small(apart.x);
  at.dy0[k] = narrow_small(apart.y);
  at.far0[k] = narrow(far);
  at.c0[k] = narrow_small(far - length);
  at.top[k] = rope ? 0.0f : 1e30f;
  if (at.nx[k] == 0 && at.ny[k] == 0) at.ny[k] = 1;
}

// Finds out whether the anchors of all lanes that have a joint are the centres of the bodies.
void find_central(kernels::LineBlock& at, const std::uint32_t* joints) {
  bool central = true;
  for (std::uint32_t k = 0; k < kBlock; ++k) {
    const bool here = at.ax0[k] == 0 && at.ay0[k] == 0 && at.bx0[k] == 0 && at.by0[k] == 0;
    central = central && (here || joints[k] == kNoSlot);
  }
  at.central = central ? 1 : 0;
}

// `way` is -1 if the row runs from b to a.
template <class Desc>
void fill_drive(kernels::Drive& at, std::uint32_t k, const Desc& d, double way, double h) {
  const double none = 1e30;
  const double lower = d.lower.value_or(-none), upper = d.upper.value_or(none);
  at.lower[k] = narrow(way > 0 ? lower : -upper);
  at.upper[k] = narrow(way > 0 ? upper : -lower);
  at.speed[k] = narrow(way * d.motor_speed);
  at.most[k] = narrow(lesser(d.motor_limit * h, 1e30));
}

template <class Block>
void fill_spring(Block& at, std::uint32_t k, const SpringRow& row) {
  at.push[k] = narrow_small(lesser(row.push, 1e30));
  at.drag[k] = narrow_small(lesser(row.drag, 1e30));
  at.lag[k] = narrow_small(greater(row.lag, -1e30));
}

// The axis in the frame of side A. If A is body b, it points the other way and is turned by the reference angle.
template <class Desc>
Vec2 axis_of(const Desc& d, bool swapped) {
  const double size = length_of(d.axis);
  const Vec2 axis{d.axis.x / size, d.axis.y / size};
  return swapped ? -1.0 * turned(sine_cosine(-d.reference.value_or(0)), axis) : axis;
}

}  // namespace

void JointStore::find_members(const std::vector<FixedBody>& fixed, const SolverBodies& solved) {
  const BodyStore& b = s_.bodies;
  members_.resize(bodies_.size());
  const bool holds = !bodies_.empty() && is_world(bodies_.back());
  world_ = holds ? static_cast<std::uint32_t>(bodies_.size() - 1) : kNoSlot;
  constexpr std::size_t kEach = 512;
  run_each(members_.size(), kEach, s_.pool, [&](std::size_t n, std::size_t) {
    const std::uint32_t id = bodies_[n];
    JointMember& m = members_[n];  // in place: a copy would wait for what was just written
    m = {};
    m.number = solved.dummies();
    m.rests = true;
    if (is_world(id)) return;
    const std::uint32_t slot = b.info[id].slot;
    const BodyKind& kind = b.kind(id);
    m.rim_gain = static_cast<double>(b.properties(id).rim_gain);
    m.inverse_mass = static_cast<double>(b.inv_mass_in_joints(id));
    if (b.info[id].place == Place::moving) {
      m.at = {b.pos[2 * slot], b.pos[2 * slot + 1], 0, 0};
      m.angle = b.angle[slot];
      m.centre = {kind.centre_x, kind.centre_y};
      m.inverse_radius = 1 / static_cast<double>(b.radius[slot]);
      m.number = solved.number(slot);
      m.rests = false;
    } else {
      const FixedBody& f = fixed[slot];
      m.at = s_.lattice.to_lattice({f.x, f.y});
      m.angle = f.angle;
    }
    m.turn = sine_cosine(m.angle);
  });
}

// Finds the blocks of bodies that have joints. What the joints did is summed for these alone.
void JointStore::find_shares(std::uint32_t body_blocks) {
  marks_.assign(body_blocks, 0);
  for (std::size_t n = 0; n < members_.size(); ++n) {
    const std::uint32_t number = members_[n].swept;
    if (swept_[n] != 0 && !members_[n].rests) marks_[number / kBlock] = 1;
  }
  shares_.clear();
  std::vector<ListRange>& ranges = shares_.ranges;
  std::uint32_t in_job = kShareBlocks;  // blocks in the last job
  for (std::uint32_t i = 0; i < body_blocks; ++i) {
    if (marks_[i] == 0) continue;
    const bool full = in_job >= kShareBlocks;
    if (full) {
      shares_.add({});
      in_job = 0;
    }
    if (full || i - ranges.back().end > kSmallGap) ranges.push_back({0, i, i});
    in_job += i + 1 - ranges.back().end;
    ranges.back().end = i + 1;
    shares_.jobs.back().end = static_cast<std::uint32_t>(ranges.size());
  }
  const std::size_t all = std::size_t{body_blocks} * kBlock;
  share_vel_.reserve(2 * all);
  share_rim_speed_.reserve(all);
  push_vel_.reserve(2 * (all + kBlock));
  push_rim_speed_.reserve(all + kBlock);
  push0_vel_.reserve(2 * all);
  push0_rim_speed_.reserve(all);
  std::fill_n(push_vel_.data() + 2 * all, 2 * kBlock, 0.0f);  // the record of static bodies and empty lanes
  std::fill_n(push_rim_speed_.data() + all, kBlock, 0.0f);
}

// Sweeps do not follow springs that are stiffer: of nets they would gain energy.
SpringRow JointStore::spring_of(double stiffness, double damping, double mass, std::uint32_t crowd) const {
  const double h = h_ / cycles_.count, most = kStiffest * mass / h;
  return spring_row(lesser(acting_ * stiffness, most / h), lesser(acting_ * damping, most), mass, h, crowd);
}

// Fills the bodies of a lane and the arms to its anchors. Returns the vector from the anchor of A to that of B, without
// the offsets in `disp`.
template <class Block>
inline Vec2 JointStore::fill_arms(Block& at, std::uint32_t k, const Ends& ends) const {
  std::optional<JointMember> world;
  const JointMember& ma = side_at(ends.body[0], ends.anchor[0], world);
  const JointMember& mb = members_[ends.body[1]];
  at.body[2 * k] = ma.swept;
  at.body[2 * k + 1] = mb.swept;
  at.ra[k] = narrow(ma.inverse_radius);
  at.rb[k] = narrow(mb.inverse_radius);
  at.ga[k] = at.ga0[k] = narrow(ma.rim_gain);
  at.gb[k] = at.gb0[k] = narrow(mb.rim_gain);
  const Vec2 arm_a = turned(ma.turn, ends.anchor[0] - ma.centre);
  const Vec2 arm_b = turned(mb.turn, ends.anchor[1] - mb.centre);
  at.ax0[k] = narrow_small(arm_a.x * ma.inverse_radius);
  at.ay0[k] = narrow_small(arm_a.y * ma.inverse_radius);
  at.bx0[k] = narrow_small(arm_b.x * mb.inverse_radius);
  at.by0[k] = narrow_small(arm_b.y * mb.inverse_radius);
  return s_.lattice.way(ma.at, mb.at) + (arm_b - arm_a);
}

// Fills the arms of a lane and the rows of its kind, which is no rod.
template <class Block>
void JointStore::fill_rows(Block& at, std::uint32_t k, const Joint& joint, const Ends& ends) const {
  const Basics& d = joint.desc;
  std::optional<JointMember> world;
  const JointMember& ma = side_at(ends.body[0], ends.anchor[0], world);
  const JointMember& mb = members_[ends.body[1]];
  const Vec2 apart = fill_arms(at, k, ends);
  const auto arm = [&](const JointMember& m, int side) { return turned(m.turn, ends.anchor[side] - m.centre); };
  const double sign = joint.swapped ? -1 : 1;
  if constexpr (requires { at.angle0; })
    at.angle0[k] = narrow_small((mb.angle - ma.angle) - sign * d.reference.value_or(0));
  if constexpr (std::is_same_v<Block, kernels::LineBlock>) {
    fill_line(at, k, *d.length, false, apart);
    const double mass = line_mass(ma, mb, arm(ma, 0), arm(mb, 1), apart);
    fill_spring(at, k, spring_of(d.stiffness, d.damping, mass, crowd_of(joint)));
  } else if constexpr (std::is_same_v<Block, kernels::SlideBlock>) {
    const Vec2 u = turned(ma.turn, axis_of(d, joint.swapped));
    at.ux0[k] = narrow_small(u.x);
    at.uy0[k] = narrow_small(u.y);
    at.along0[k] = narrow_small(dot(u, apart));
    at.off0[k] = narrow_small(cross(u, apart));
    fill_drive(at.drive, k, d, 1, h_);
  } else {
    at.cx0[k] = narrow_small(apart.x);
    at.cy0[k] = narrow_small(apart.y);
  }
  if constexpr (std::is_same_v<Block, kernels::DrivenBlock>) fill_drive(at.drive, k, d, sign, h_);
  if constexpr (std::is_same_v<Block, kernels::WeldBlock>) {
    if (d.stiffness > 0) {
      const double mass = pinned_inertia(ma, mb, arm(ma, 0), arm(mb, 1));
      fill_spring(at, k, spring_of(d.stiffness, d.damping, mass, crowd_of(joint)));
    }
  }
}

// The same for a rod, rope or tether: the ends say all, so that its joint, which lies elsewhere, is not looked at.
template <class Block>
void JointStore::fill_rod(Block& at, std::uint32_t k, const Ends& ends) const {
  const Vec2 apart = fill_arms(at, k, ends);
  if constexpr (std::is_same_v<Block, kernels::LineBlock>) fill_line(at, k, ends.length, ends.rope, apart);
}

// Masses, anchors, springs and motors of the articulations.
void JointStore::set_articulations(bool calm) {
  for (Articulations::Body& b : articulations_.bodies()) {
    const JointMember& m = members_[b.id];
    b.number = m.number;
    b.slot = is_world(bodies_[b.id]) ? 0 : s_.bodies.info[bodies_[b.id]].slot;
    b.inverse_mass = m.inverse_mass;
    b.inverse_inertia = 0;
    b.radius = 1 / m.inverse_radius;
    b.angle = m.angle;
  }
  for (Articulations::Joint& to : articulations_.joints()) {
    Joint& joint = joints_[to.joint];
    const Basics& d = joint.desc;
    std::optional<JointMember> world;
    const JointMember &ma = side_at(joint.body[0], joint.anchor(0), world), &mb = members_[joint.body[1]];
    const double sign = joint.swapped ? -1 : 1;
    to.geometry = {.kind = joint.kind,
                   .base = s_.lattice.way(ma.at, mb.at),
                   .anchor = {(joint.swapped ? d.anchor_b : d.anchor_a) - ma.centre,
                              (joint.swapped ? d.anchor_a : d.anchor_b) - mb.centre},
                   .axis = axis_of(d, joint.swapped),
                   .length = joint.kind == JointKind::slide ? 0 : d.length.value_or(0),
                   .reference = sign * d.reference.value_or(0)};
    // Bodies that joints hold at their centres alone do not turn with them.
    const bool angle = joint.kind != JointKind::rod && joint.kind != JointKind::spring && joint.kind != JointKind::pin;
    for (const int side : {0, 1}) {
      const JointMember& m = side == 0 ? ma : mb;
      const Vec2 anchor = to.geometry.anchor[side];
      if (m.inverse_mass == 0 || (!angle && anchor.x == 0 && anchor.y == 0)) continue;
      articulations_.bodies()[to.body[side]].inverse_inertia = m.rim_gain * m.inverse_radius * m.inverse_radius;
    }
    to.impulse = joint.impulse;
    to.gain = &joint.gain;
    to.rope = d.type == JointType::rope;
    const double none = 1e30, lower = d.lower.value_or(-none), upper = d.upper.value_or(none);
    const bool flipped = joint.kind == JointKind::driven && joint.swapped;
    to.lower = flipped ? -upper : lower;
    to.upper = flipped ? -lower : upper;
    if (lower == upper) (joint.kind == JointKind::slide ? to.geometry.length : to.geometry.reference) += to.lower;
    to.motor_speed = (flipped ? -1 : 1) * d.motor_speed;
    to.motor_most = lesser(d.motor_limit * h_, 1e30);
    to.stiffness = acting_ * d.stiffness;
    to.damping = acting_ * d.damping;
    to.mass = 0;
    const Vec2 arm_a = turned(ma.turn, to.geometry.anchor[0]), arm_b = turned(mb.turn, to.geometry.anchor[1]);
    if (joint.kind == JointKind::spring) to.mass = line_mass(ma, mb, arm_a, arm_b, to.geometry.base + (arm_b - arm_a));
    if (joint.kind == JointKind::weld && d.stiffness > 0) to.mass = pinned_inertia(ma, mb, arm_a, arm_b);
    to.crowd = crowd_of(joint);
    to.set_spring(h_);
  }
  articulations_.prepare(h_, calm);
}

// Ends of the membranes. A membrane does half of its push to each of its ends.
void JointStore::set_membranes(const std::vector<Field>& fields) {
  for (Membrane& m : membranes_.all()) {
    const Joint& joint = joints_[m.joint];
    const JointDesc& d = extras_[joint.extra].desc;
    m.pressure = joint.swapped ? -d.pressure : d.pressure;
    m.drag = d.wind_drag;
    m.lift = d.wind_lift;
    m.area = d.area;
    std::optional<JointMember> world;
    LatticePoint at[2];
    for (const std::uint32_t side : {0u, 1u}) {
      const JointMember& of = side_at(joint.body[side], joint.anchor(side), world);
      MembraneEnd& end = m.end[side];
      // The anchors of a weld coincide, so it is pushed at the centres of mass.
      const bool of_world = world && &of == &*world;
      const Vec2 arm =
          d.type == JointType::weld && !of_world ? Vec2() : turned(of.turn, joint.anchor(side) - of.centre);
      const double inverse_inertia = of.rim_gain * of.inverse_radius * of.inverse_radius;
      at[side] = of.at;
      end.body = of.number;
      end.at = s_.lattice.to_world(of.at);
      end.arm = arm;
      end.inverse_mass = of.inverse_mass;
      end.inverse_inertia = inverse_inertia;
      end.inverse_radius = of.inverse_radius;
      end.rate = m.crowd[side] * (of.inverse_mass + inverse_inertia * dot(arm, arm));
    }
    m.base = s_.lattice.way(at[0], at[1]);
  }
  membranes_.set_wind(fields);
}

// A pass sweeps as often as a frame can afford. More cycles do more than more sweeps.
int JointStore::sweeps() const {
  if (cycles_.on()) return kLeastSweeps;
  const std::uint32_t blocks = work_blocks();
  const std::uint32_t many = tethers_.empty() ? kMany : kManyOfNets;
  return blocks <= kFew ? kMostSweeps : blocks <= many ? kMostSweeps / 2 : kLeastSweeps;
}

void JointStore::prepare(const std::vector<FixedBody>& fixed, const SolverBodies& solved, double h, int substeps,
                         double coast, bool calm, const std::vector<Field>& fields) {
  in_step_ = substeps;
  if (empty()) return;
  s_.bodies.find_slots();
  const bool fresh = stale_;
  if (stale_) lay_out();
  stale_ = false;
  find_members(fixed, solved);
  set_cycles(h, fresh, solved);
  h_ = h;
  acting_ = coast / h;
  const double cycle = h / cycles_.count;
  params_.h = narrow(cycle);
  params_.inv_h = narrow(1 / cycle);
  params_.rate = narrow(kBias / cycle);
  find_shares(cycles_.on() ? cycles_.blocks : solved.blocks());
  if (!articulations_.empty()) set_articulations(calm);
  set_linkages();
  if (membranes_.any()) set_membranes(fields);
  substeps_ = 0;
  for (const std::uint32_t i : fragile_) {
    Extra& extra = extras_[joints_[i].extra];
    extra.force = {};
    extra.torque = 0;
  }
  const std::uint32_t padding = (cycles_.on() ? cycles_.blocks * kBlock : solved.dummies()) + 1;
  jobs_.run(s_.pool, [&](const ListRange& r) {
    const std::vector<std::uint32_t>& lanes = lanes_[r.list];
    const std::vector<Ends>& ends = ends_[r.list];
    const bool rods = r.list == JointLists::list_of(JointKind::rod, true) ||  // tethers are among them
                      r.list == JointLists::list_of(JointKind::rod, false);
    JointLists::visit(lists_, r.list, [&](auto& blocks) {
      for (std::uint32_t lane = r.begin * kBlock; lane < r.end * kBlock; ++lane) {
        auto& block = blocks[lane / kBlock];
        const std::uint32_t joint = lanes[lane], k = lane % kBlock;
        if (joint == kNoSlot) {
          block.body[2 * k] = block.body[2 * k + 1] = padding;
        } else if (rods) {
          fill_rod(block, k, ends[lane]);
        } else {
          fill_rows(block, k, joints_[joint], ends[lane]);
        }
        if constexpr (requires { block.central; }) {
          if (k == kBlock - 1) find_central(block, lanes.data() + lane - k);
        }
      }
    });
  });
}

}  // namespace psim
