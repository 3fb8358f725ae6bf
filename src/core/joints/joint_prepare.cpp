// Prepares the joints once a frame: every lane at the present places of its bodies, in double precision, and the bodies
// that have joints. O(joints).
#include <algorithm>
#include <cmath>

#include "base/rotor.h"
#include "joints/joint_spring.h"
#include "joints/joint_store.h"

namespace psim {

using kernels::JointBodies;
using kernels::JointKind;
using kernels::kBlock;

namespace {

// The share of a position error that a substep corrects.
constexpr double kBias = 0.5;
// The number of sweeps in a pass is as large as a frame can afford.
constexpr int kMostSweeps = 8, kLeastSweeps = 2;
constexpr std::uint32_t kFew = 32, kMany = 256;  // blocks
constexpr std::uint32_t kShareBlocks = 512;      // blocks of bodies in a job
constexpr std::uint32_t kSmallGap = 8;           // blocks without joints that a range may contain

float narrow(double v) { return static_cast<float>(v); }

Vec2 turned(double c, double s, Vec2 p) { return {c * p.x - s * p.y, s * p.x + c * p.y}; }

// The effective mass of pulling the anchors apart, kg, along the line `apart` from one to the other.
double line_mass(const JointBodies& b, std::uint32_t k, const JointMember& ma, const JointMember& mb, Vec2 arm_a,
                 Vec2 arm_b, Vec2 apart) {
  const double far = std::sqrt(apart.x * apart.x + apart.y * apart.y);
  const double nx = far > 0 ? apart.x / far : 0, ny = far > 0 ? apart.y / far : 1;
  const double sa = arm_a.x * ny - arm_a.y * nx, sb = arm_b.x * ny - arm_b.y * nx;
  const auto part = [&](float w, float g, double s, double inverse) {
    return static_cast<double>(w) + static_cast<double>(g) * s * s * inverse * inverse;
  };
  return 1 / (part(b.wa[k], b.ga[k], sa, ma.inverse_radius) + part(b.wb[k], b.gb[k], sb, mb.inverse_radius));
}

// The effective mass of turning B against A while their anchors stay together, kg m^2: the entry of the angle in the
// inverse of the matrix of three rows.
double pinned_inertia(const JointBodies& b, std::uint32_t k, const JointMember& ma, const JointMember& mb, Vec2 a,
                      Vec2 c) {
  const double ia = ma.rim_gain * ma.inverse_radius * ma.inverse_radius;
  const double ib = mb.rim_gain * mb.inverse_radius * mb.inverse_radius;
  const double w = static_cast<double>(b.wa[k]) + static_cast<double>(b.wb[k]);
  const double k11 = w + ia * a.y * a.y + ib * c.y * c.y, k22 = w + ia * a.x * a.x + ib * c.x * c.x;
  const double k12 = -ia * a.x * a.y - ib * c.x * c.y;
  const double cx = -ia * a.y - ib * c.y, cy = ia * a.x + ib * c.x;
  const double below = k11 * k22 - k12 * k12;
  const double left = ia + ib - (k22 * cx * cx - 2 * k12 * cx * cy + k11 * cy * cy) / below;
  return left > 1e-9 * (ia + ib) ? 1 / left : 0;
}

void fill_line(kernels::LineBlock& at, std::uint32_t k, const JointDesc& d, Vec2 apart) {
  const double far = std::sqrt(apart.x * apart.x + apart.y * apart.y);
  at.dx0[k] = narrow(apart.x);
  at.dy0[k] = narrow(apart.y);
  at.far0[k] = narrow(far);
  at.c0[k] = narrow(far - *d.length);
  at.top[k] = d.type == JointType::rope ? 0.0f : 1e30f;
  if (at.nx[k] == 0 && at.ny[k] == 0) at.ny[k] = 1;
}

void fill_pin(kernels::PinBlock& at, std::uint32_t k, Vec2 apart) {
  at.cx0[k] = narrow(apart.x);
  at.cy0[k] = narrow(apart.y);
}

// `way` is -1 if the row runs from b to a.
void fill_drive(kernels::Drive& at, std::uint32_t k, const JointDesc& d, double way, double h) {
  const double none = 1e30;
  const double lower = d.lower.value_or(-none), upper = d.upper.value_or(none);
  at.lower[k] = narrow(way > 0 ? lower : -upper);
  at.upper[k] = narrow(way > 0 ? upper : -lower);
  at.speed[k] = narrow(way * d.motor_speed);
  at.most[k] = narrow(std::fmin(d.motor_limit * h, 1e30));
}

template <class Block>
void fill_spring(Block& at, std::uint32_t k, const JointDesc& d, double mass, double h) {
  const SpringRow row = spring_row(d.stiffness, d.damping, mass, h);
  at.push[k] = narrow(std::fmin(row.push, 1e30));
  at.drag[k] = narrow(std::fmin(row.drag, 1e30));
}

// The axis in the frame of side A. If A is body b, it points the other way and is turned by the reference angle.
Vec2 axis_of(const JointDesc& d, bool swapped) {
  const double size = std::sqrt(d.axis.x * d.axis.x + d.axis.y * d.axis.y);
  const Vec2 axis{d.axis.x / size, d.axis.y / size};
  if (!swapped) return axis;
  const SineCosine back = sine_cosine(-d.reference.value_or(0));
  const Vec2 seen = turned(back.cosine, back.sine, axis);
  return {-seen.x, -seen.y};
}

}  // namespace

void JointStore::find_members(const BodyStore& b, const std::vector<FixedBody>& fixed, const SolverBodies& numbers,
                              const Lattice& lattice, WorkerPool& pool) {
  members_.resize(bodies_.size());
  constexpr std::size_t kEach = 512;
  pool.run((members_.size() + kEach - 1) / kEach, [&](std::size_t job) {
    for (std::size_t n = job * kEach; n < std::min(members_.size(), (job + 1) * kEach); ++n) {
      JointMember& m = members_[n];
      const std::uint32_t id = bodies_[n];
      const BodyInfo& info = b.info[id];
      const BodyKind& kind = b.kind(id);
      m.rim_gain = static_cast<double>(b.properties(id).rim_gain);
      m.centre_x = static_cast<double>(kind.centre_x);
      m.centre_y = static_cast<double>(kind.centre_y);
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

// Finds the blocks of bodies that have joints. What the joints did is summed for these alone.
void JointStore::find_shares(const SolverBodies& numbers) {
  const std::uint32_t body_blocks = numbers.blocks();
  marks_.assign(body_blocks, 0);
  for (const JointMember& m : members_) {
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
  std::fill_n(push_vel_.data() + 2 * all, 2 * kBlock, 0.0f);  // the record of static bodies and empty lanes
  std::fill_n(push_spin_.data() + all, kBlock, 0.0f);
}

void JointStore::fill_lane(std::uint32_t list, JointBodies& b, std::uint32_t k, Joint* j) {
  if (j == nullptr) {
    b.body[2 * k] = b.body[2 * k + 1] = padding_;
    return;
  }
  const JointMember& ma = members_[j->body[0]];
  const JointMember& mb = members_[j->body[1]];
  b.body[2 * k] = ma.number;
  b.body[2 * k + 1] = mb.number;
  b.ra[k] = narrow(ma.inverse_radius);
  b.rb[k] = narrow(mb.inverse_radius);
  b.ga[k] = b.ga0[k] = narrow(ma.rim_gain);
  b.gb[k] = b.gb0[k] = narrow(mb.rim_gain);
  fill_kind(list, b, k, *j, ma, mb);
}

// Fills the arms of a lane and the rows of its kind.
void JointStore::fill_kind(std::uint32_t list, JointBodies& b, std::uint32_t k, const Joint& joint,
                           const JointMember& ma, const JointMember& mb) const {
  const JointDesc& d = joint.desc;
  const Vec2 anchor_a = joint.swapped ? d.anchor_b : d.anchor_a;
  const Vec2 anchor_b = joint.swapped ? d.anchor_a : d.anchor_b;
  const Vec2 arm_a = turned(ma.c, ma.s, {anchor_a.x - ma.centre_x, anchor_a.y - ma.centre_y});
  const Vec2 arm_b = turned(mb.c, mb.s, {anchor_b.x - mb.centre_x, anchor_b.y - mb.centre_y});
  b.ax0[k] = narrow(arm_a.x * ma.inverse_radius);
  b.ay0[k] = narrow(arm_a.y * ma.inverse_radius);
  b.bx0[k] = narrow(arm_b.x * mb.inverse_radius);
  b.by0[k] = narrow(arm_b.y * mb.inverse_radius);
  // The vector from the anchor of A to that of B, without the offsets in `disp`. Differences of lattice points are
  // exact.
  const Vec2 apart{wrap_sub(mb.x, ma.x) * pitch_x_ + (mb.rest_x - ma.rest_x) + (arm_b.x - arm_a.x),
                   wrap_sub(mb.y, ma.y) * pitch_y_ + (mb.rest_y - ma.rest_y) + (arm_b.y - arm_a.y)};
  const double sign = joint.swapped ? -1 : 1;
  const double angle = (mb.angle - ma.angle) - sign * d.reference.value_or(0);
  switch (JointLists::kind_of(list)) {
    case JointKind::rod:
      fill_line(static_cast<kernels::LineBlock&>(b), k, d, apart);
      break;
    case JointKind::spring: {
      auto& at = static_cast<kernels::LineBlock&>(b);
      fill_line(at, k, d, apart);
      fill_spring(at, k, d, line_mass(b, k, ma, mb, arm_a, arm_b, apart), h_);
      break;
    }
    case JointKind::pin:
      fill_pin(static_cast<kernels::PinBlock&>(b), k, apart);
      break;
    case JointKind::driven: {
      auto& at = static_cast<kernels::DrivenBlock&>(b);
      fill_pin(at, k, apart);
      at.angle0[k] = narrow(angle);
      fill_drive(at.drive, k, d, sign, h_);
      break;
    }
    case JointKind::weld: {
      auto& at = static_cast<kernels::WeldBlock&>(b);
      fill_pin(at, k, apart);
      at.angle0[k] = narrow(angle);
      if (!(d.stiffness > 0)) break;
      fill_spring(at, k, d, pinned_inertia(b, k, ma, mb, arm_a, arm_b), h_);
      break;
    }
    case JointKind::slide: {
      auto& at = static_cast<kernels::SlideBlock&>(b);
      const Vec2 u = turned(ma.c, ma.s, axis_of(d, joint.swapped));
      at.ux0[k] = narrow(u.x);
      at.uy0[k] = narrow(u.y);
      at.along0[k] = narrow(u.x * apart.x + u.y * apart.y);
      at.off0[k] = narrow(u.x * apart.y - u.y * apart.x);
      at.angle0[k] = narrow(angle);
      fill_drive(at.drive, k, d, 1, h_);
    }
  }
}

void JointStore::fill(std::uint32_t list, std::uint32_t index) {
  JointBodies& b = lists_.block(list, index);
  for (std::uint32_t k = 0; k < kBlock; ++k) {
    const std::uint32_t i = lanes_[list][std::size_t{index} * kBlock + k];
    fill_lane(list, b, k, i == kNoSlot ? nullptr : &joints_[i]);
  }
}

void JointStore::prepare(const BodyStore& b, const std::vector<FixedBody>& fixed, const SolverBodies& numbers,
                         const Lattice& lattice, double h, WorkerPool& pool) {
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
  sweeps_ = total_blocks_ <= kFew ? kMostSweeps : total_blocks_ <= kMany ? kMostSweeps / 2 : kLeastSweeps;
  find_members(b, fixed, numbers, lattice, pool);
  find_shares(numbers);
  pool.run(jobs_.size(), [&](std::size_t n) {
    for (std::uint32_t r = jobs_[n].begin; r < jobs_[n].end; ++r) {
      for (std::uint32_t i = ranges_[r].begin; i < ranges_[r].end; ++i) fill(ranges_[r].list, i);
    }
  });
}

}  // namespace psim
