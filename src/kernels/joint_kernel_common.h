// What passes over joints have in common (docs/joints.md derives it all): the loop over lanes, arms, a row
// of impulses, and the turning of impulses between a substep's start and its end.
//
// Together with the drift the passes are RATTLE (Andersen 1983): the impulse of a substep acts half along
// the normal at its start and half along that at its end, and the drift goes with the first half,
//   x' = x + h (v0 + (kick + w l n) / 2),    v' = v0 + kick + w (l/2 n + (l/2 + dl) n')
//
//   warm   stored impulses (first substep of a frame)
//   solve  finds l so that the position error stays what it is at x', to second order:
//            vn + curve = 0,   curve = h x (centripetal acceleration of the error)
//   push   takes a share of the error back, vn = -rate C: b.vel and b.rim_speed are velocities for this
//          substep's drift alone, from 0
//   relax  finds n', turns half of the impulse (adds l/2 (n' - n), kept in `ex`, `ea` ...) and makes
//          the velocities agree with the joint, vn' = 0. The next kick repeats what the substep did, so
//          that the next solve turns the other half, adding the same again.
//
// kFixedA: A is static or kinematic; it is read and never written.
#pragma once

#include "joint_views.h"
#include "lane_vec.h"
#include "manifold_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

// ---- lanes ----------------------------------------------------------------------------------------

/// A turn in a substep that still counts in full, rad.
constexpr float kResolvedTurn = 0.05f;

/// Masses and arms of some lanes.
template <class L>
struct Arms {
  Vec<L> a, b;  // over R
  F<L> wa, wb, ga, gb, ra, rb;
};

/// Masses alone, where anchors are the centres of the bodies: these do not turn, and rows have no levers.
template <class L>
struct Centres {
  F<L> wa, wb;
};

template <class L>
PSIM_INLINE inline Arms<L> load_arms(const JointBodies& j, std::uint32_t k) {
  return {load_vec<L>(j.ax, j.ay, k), load_vec<L>(j.bx, j.by, k), L::load(j.wa + k), L::load(j.wb + k),
          L::load(j.ga + k),          L::load(j.gb + k),          L::load(j.ra + k), L::load(j.rb + k)};
}

/// Calls each(block, first lane, arms, motion) for all lanes of some blocks. The motion is that of b.vel
/// and b.rim_speed and goes back there.
template <class L, bool kFixedA, class Block, class Each>
PSIM_INLINE inline void by_lane(const BodyView& b, JointBlocks blocks, std::uint32_t begin, std::uint32_t end,
                                const Each& each) {
  auto* all = static_cast<Block*>(blocks);
  for (Block* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.rim_speed, slot);
      each(*j, k, arms, m);
      scatter_motion<L, kFixedA>(b.vel, b.rim_speed, slot, m);
    }
  }
}

/// The same for the lanes of a block whose anchors are the bodies' centres.
template <class L, bool kFixedA, class Block, class Each>
PSIM_INLINE inline void by_central_lane(const BodyView& b, Block& j, const Each& each) {
  for (std::uint32_t k = 0; k < kBlock; k += L::width) {
    const std::uint32_t* slot = j.body + 2 * k;
    Centres<L> centres{L::load(j.wa + k), L::load(j.wb + k)};
    TwoBodies<L> m;
    L::template gather<2>(b.vel, slot, m.vax, m.vay);
    L::template gather<2>(b.vel, slot + 1, m.vbx, m.vby);
    each(j, k, centres, m);
    if constexpr (!kFixedA) L::template scatter<2>(b.vel, slot, m.vax, m.vay);
    L::template scatter<2>(b.vel, slot + 1, m.vbx, m.vby);
  }
}

/// Calls each(block, first lane, arms, motion) for all lanes of some blocks of lines; with Centres in place of Arms where
/// no body turns.
template <class L, bool kFixedA, class Block, class Each>
PSIM_INLINE inline void by_line(const BodyView& b, JointBlocks blocks, std::uint32_t begin, std::uint32_t end,
                                const Each& each) {
  auto* all = static_cast<Block*>(blocks);
  for (std::uint32_t at = begin; at != end; ++at) {
    if (all[at].central != 0) {
      by_central_lane<L, kFixedA>(b, all[at], each);
    } else {
      by_lane<L, kFixedA, Block>(b, blocks, at, at + 1, each);
    }
  }
}

// ---- rows -----------------------------------------------------------------------------------------

/// Adds the impulse p to B and takes it from A; qa and qb are arm / R x impulse, which change the rim speeds.
template <class L, bool kFixedA>
PSIM_INLINE inline void push(TwoBodies<L>& m, const Arms<L>& j, Vec<L> p, F<L> qa, F<L> qb) {
  apply_impulse<L, kFixedA>(m, p.x, p.y, qa, qb, j.wa, j.wb, j.ga, j.gb);
}

/// A row: its unit normal and its levers.
template <class L>
struct Row {
  Vec<L> n;
  F<L> sa, sb;
};

/// The row of the anchors along n.
template <class L>
PSIM_INLINE inline Row<L> anchor_row(const Arms<L>& j, Vec<L> n) {
  return {n, cross(j.a, n), cross(j.b, n)};
}

template <class L, bool kFixedA>
PSIM_INLINE inline void push_row(TwoBodies<L>& m, const Arms<L>& j, const Row<L>& row, F<L> l) {
  push<L, kFixedA>(m, j, l * row.n, l * row.sa, l * row.sb);
}

/// Adds the impulse p to B and takes it from A, at their centres.
template <class L, bool kFixedA>
PSIM_INLINE inline void push_centres(TwoBodies<L>& m, const Centres<L>& j, Vec<L> p) {
  if constexpr (!kFixedA) {
    m.vax = m.vax - j.wa * p.x;
    m.vay = m.vay - j.wa * p.y;
  }
  m.vbx = m.vbx + j.wb * p.x;
  m.vby = m.vby + j.wb * p.y;
}

/// The row of the centres along n has no levers: Vec is all of it.
template <class L>
PSIM_INLINE inline Vec<L> anchor_row(const Centres<L>&, Vec<L> n) {
  return n;
}

template <class L, bool kFixedA>
PSIM_INLINE inline void push_row(TwoBodies<L>& m, const Centres<L>& j, Vec<L> n, F<L> l) {
  push_centres<L, kFixedA>(m, j, l * n);
}

template <class L>
PSIM_INLINE inline F<L> safe_inverse(F<L> a) {
  const auto sound = 0 < a;
  return keep(sound, 1 / select(sound, a, 1));
}

/// The impulses of two rows solved together that take the velocities v away: -K^-1 v.
template <class L, class Block>
PSIM_INLINE inline Vec<L> stop_both(const Block& j, std::uint32_t k, Vec<L> v) {
  const auto m12 = L::load(j.m12 + k);
  return {-(L::load(j.m11 + k) * v.x + m12 * v.y), -(m12 * v.x + L::load(j.m22 + k) * v.y)};
}

/// An impulse after a pass over a row with a spring, from `l`:
///   l' = -push (C + h curve/4) - drag (vn0 + vn') - lag vn0,  vn' = vn + (l' - l) / mass
template <class L, class Block>
PSIM_INLINE inline F<L> spring_impulse(const Block& j, std::uint32_t k, F<L> l, F<L> mass, F<L> stretch, F<L> vn0,
                                       F<L> vn) {
  const auto drag = L::load(j.drag + k);
  const auto pull = L::load(j.push + k) * stretch + drag * (vn0 + vn) + L::load(j.lag + k) * vn0;
  const auto sum = drag * l - mass * pull;
  const auto both = mass + drag;
  return sum / select(0 < both, both, 1);
}

// ---- motion of the anchors --------------------------------------------------------------------------

/// Velocity of B's anchor against A's.
template <class L>
PSIM_INLINE inline Vec<L> anchor_velocity(const TwoBodies<L>& m, const Arms<L>& j) {
  return {m.vbx - m.ub * j.b.y - (m.vax - m.ua * j.a.y), m.vby + m.ub * j.b.x - (m.vay + m.ua * j.a.x)};
}

template <class L>
PSIM_INLINE inline Vec<L> anchor_velocity(const TwoBodies<L>& m, const Centres<L>&) {
  return {m.vbx - m.vax, m.vby - m.vay};
}

/// h x centripetal acceleration of B's anchor against A's, -rB wB^2 + rA wA^2. Turns are limited to what h resolves.
template <class L>
PSIM_INLINE inline Vec<L> anchor_pull(const TwoBodies<L>& m, const Arms<L>& j, F<L> h) {
  const F<L> most = kResolvedTurn;
  const auto ta = min(h * (abs(m.ua) * j.ra), most);
  const auto tb = min(h * (abs(m.ub) * j.rb), most);
  return ta * abs(m.ua) * j.a - tb * abs(m.ub) * j.b;
}

/// Angular velocity of B against A.
template <class L>
PSIM_INLINE inline F<L> turning(const TwoBodies<L>& m, const Arms<L>& j) {
  return m.ub * j.rb - m.ua * j.ra;
}

/// Arms as the bodies lie now, stored; and how far B's anchor has moved against A's since the frame's
/// start, m.
template <class L>
PSIM_INLINE inline Vec<L> turn_arms(const BodyView& b, JointBodies& j, std::uint32_t k, Arms<L>& arms) {
  const std::uint32_t* slot = j.body + 2 * k;
  Vec<L> ta, tb, da, db;
  L::template gather<2>(b.arm_change, slot, ta.x, ta.y);
  L::template gather<2>(b.arm_change, slot + 1, tb.x, tb.y);
  L::template gather<2>(b.disp, slot, da.x, da.y);
  L::template gather<2>(b.disp, slot + 1, db.x, db.y);
  const auto a0 = load_vec<L>(j.ax0, j.ay0, k), b0 = load_vec<L>(j.bx0, j.by0, k);
  const Vec<L> moved_a{ta.x * a0.x - ta.y * a0.y, ta.x * a0.y + ta.y * a0.x};
  const Vec<L> moved_b{tb.x * b0.x - tb.y * b0.y, tb.x * b0.y + tb.y * b0.x};
  arms.a = a0 + arms.ra * moved_a;
  arms.b = b0 + arms.rb * moved_b;
  store_vec<L>(j.ax, j.ay, k, arms.a);
  store_vec<L>(j.bx, j.by, k, arms.b);
  return db - da + (moved_b - moved_a);
}

template <class L>
PSIM_INLINE inline Vec<L> turn_arms(const BodyView& b, JointBodies& j, std::uint32_t k, const Centres<L>&) {
  const std::uint32_t* slot = j.body + 2 * k;
  Vec<L> da, db;
  L::template gather<2>(b.disp, slot, da.x, da.y);
  L::template gather<2>(b.disp, slot + 1, db.x, db.y);
  return db - da;
}

/// Angle of B against A now, rad.
template <class L, class Block>
PSIM_INLINE inline F<L> present_angle(const BodyView& b, const Block& j, std::uint32_t k) {
  const std::uint32_t* slot = j.body + 2 * k;
  const auto swung = L::template gather1<2>(b.angle_change, slot + 1) - L::template gather1<2>(b.angle_change, slot);
  return L::load(j.angle0 + k) + swung;
}

// ---- turning of impulses ----------------------------------------------------------------------------

/// Adds half of what turning the impulses adds: e to the impulse, sa and sb to those of the levers. The arms of a
/// pin turn and its axes do not, so that e = 0 there. The half is kept, since the next solve adds it again.
template <class L, bool kFixedA, class Block>
PSIM_INLINE inline void turn_half(TwoBodies<L>& m, const Arms<L>& arms, Block& j, std::uint32_t k, const Row<L>& e) {
  if constexpr (requires { j.ex; }) store_vec<L>(j.ex, j.ey, k, e.n);
  store_vec<L>(j.ea, j.eb, k, {e.sa, e.sb});
  push<L, kFixedA>(m, arms, e.n, e.sa, e.sb);
}

/// Adds the other half of what turning the impulses of the last substep adds.
template <class L, bool kFixedA, class Block>
PSIM_INLINE inline void turn_on(TwoBodies<L>& m, const Arms<L>& arms, const Block& j, std::uint32_t k) {
  Vec<L> e{0, 0};
  if constexpr (requires { j.ex; }) e = load_vec<L>(j.ex, j.ey, k);
  push<L, kFixedA>(m, arms, e, L::load(j.ea + k), L::load(j.eb + k));
}

/// The same two for rows without levers.
template <class L, bool kFixedA, class Block>
PSIM_INLINE inline void turn_half(TwoBodies<L>& m, const Centres<L>& centres, Block& j, std::uint32_t k, Vec<L> e) {
  store_vec<L>(j.ex, j.ey, k, e);
  push_centres<L, kFixedA>(m, centres, e);
}
template <class L, bool kFixedA, class Block>
PSIM_INLINE inline void turn_on(TwoBodies<L>& m, const Centres<L>& centres, const Block& j, std::uint32_t k) {
  push_centres<L, kFixedA>(m, centres, load_vec<L>(j.ex, j.ey, k));
}

/// Sets what turning adds to zero: the next solve has no half to add.
template <class L, class Block>
PSIM_INLINE inline void forget_turn(Block& j, std::uint32_t k) {
  const Vec<L> none{0, 0};
  if constexpr (requires { j.ex; }) store_vec<L>(j.ex, j.ey, k, none);
  store_vec<L>(j.ea, j.eb, k, none);
}

}  // namespace
}  // namespace psim::kernels
