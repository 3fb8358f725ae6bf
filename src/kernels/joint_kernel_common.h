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
//   push   takes a share of the error back, vn = -rate C: b.vel and b.spin are velocities for this
//          substep's drift alone, from 0
//   relax  finds n', turns half of the impulse (adds l/2 (n' - n), kept in `ex`, `spin_a` ...) and makes
//          the velocities agree with the joint, vn' = 0. The next kick repeats what the substep did, so
//          that the next solve turns the other half, adding the same again.
//
// kFixedA: A is static or kinematic; it is read and never written.
#pragma once

#include "joint_views.h"
#include "manifold_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

template <class L>
using F = typename L::F;

template <class L>
struct Vec {
  F<L> x, y;
};

template <class L>
[[gnu::always_inline]] inline F<L> dot(Vec<L> a, Vec<L> b) {
  return L::add(L::mul(a.x, b.x), L::mul(a.y, b.y));
}
template <class L>
[[gnu::always_inline]] inline F<L> cross(Vec<L> a, Vec<L> b) {
  return L::sub(L::mul(a.x, b.y), L::mul(a.y, b.x));
}
template <class L>
[[gnu::always_inline]] inline Vec<L> plus(Vec<L> a, Vec<L> b) {
  return {L::add(a.x, b.x), L::add(a.y, b.y)};
}
template <class L>
[[gnu::always_inline]] inline Vec<L> minus(Vec<L> a, Vec<L> b) {
  return {L::sub(a.x, b.x), L::sub(a.y, b.y)};
}
template <class L>
[[gnu::always_inline]] inline Vec<L> times(F<L> s, Vec<L> a) {
  return {L::mul(s, a.x), L::mul(s, a.y)};
}
template <class L>
[[gnu::always_inline]] inline Vec<L> load_vec(const float* x, const float* y, std::uint32_t k) {
  return {L::load(x + k), L::load(y + k)};
}
template <class L>
[[gnu::always_inline]] inline void store_vec(float* x, float* y, std::uint32_t k, Vec<L> v) {
  L::store(x + k, v.x);
  L::store(y + k, v.y);
}

// ---- lanes ----------------------------------------------------------------------------------------

/// Masses and arms of some lanes.
template <class L>
struct Arms {
  Vec<L> a, b;  // over R
  F<L> wa, wb, ga, gb, ra, rb;
};

template <class L>
[[gnu::always_inline]] inline Arms<L> load_arms(const JointBodies& j, std::uint32_t k) {
  return {load_vec<L>(j.ax, j.ay, k), load_vec<L>(j.bx, j.by, k), L::load(j.wa + k),
          L::load(j.wb + k),          L::load(j.ga + k),          L::load(j.gb + k),
          L::load(j.ra + k),          L::load(j.rb + k)};
}

/// Calls each(block, first lane, arms, motion) for all lanes of some blocks. The motion is that of b.vel
/// and b.spin and goes back there.
template <class L, bool kFixedA, class Block, class Each>
[[gnu::always_inline]] inline void by_lane(const BodyView& b, JointBlocks blocks,
                                           std::uint32_t begin, std::uint32_t end,
                                           const Each& each) {
  auto* all = static_cast<Block*>(blocks);
  for (Block* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      each(*j, k, arms, m);
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

// ---- rows -----------------------------------------------------------------------------------------

/// Impulse p on B, and spin impulses qa, qb (arm / R x impulse).
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void push(TwoBodies<L>& m, const Arms<L>& j, Vec<L> p, F<L> qa,
                                        F<L> qb) {
  apply_impulse<L, kFixedA>(m, p.x, p.y, qa, qb, j.wa, j.wb, j.ga, j.gb);
}

/// Normal and levers.
template <class L>
struct Row {
  Vec<L> n;
  F<L> sa, sb;
};

/// That of the anchors along n.
template <class L>
[[gnu::always_inline]] inline Row<L> anchor_row(const Arms<L>& j, Vec<L> n) {
  return {n, cross<L>(j.a, n), cross<L>(j.b, n)};
}

template <class L, bool kFixedA>
[[gnu::always_inline]] inline void push_row(TwoBodies<L>& m, const Arms<L>& j, const Row<L>& row,
                                            F<L> l) {
  push<L, kFixedA>(m, j, times<L>(l, row.n), L::mul(l, row.sa), L::mul(l, row.sb));
}

template <class L>
[[gnu::always_inline]] inline F<L> safe_inverse(F<L> a) {
  const auto sound = L::less(L::set1(0), a);
  return L::both(sound, L::div(L::set1(1), L::select(sound, a, L::set1(1))));
}

/// The impulses of two rows solved together that take the velocities v away: -K^-1 v.
template <class L, class Block>
[[gnu::always_inline]] inline Vec<L> stop_both(const Block& j, std::uint32_t k, Vec<L> v) {
  const auto m12 = L::load(j.m12 + k);
  return {L::negate(L::add(L::mul(L::load(j.m11 + k), v.x), L::mul(m12, v.y))),
          L::negate(L::add(L::mul(m12, v.x), L::mul(L::load(j.m22 + k), v.y)))};
}

/// An impulse after a pass over a row with a spring, from `l`: implicit midpoint rule,
///   l' = -push (C + h curve/4) - drag (vn0 + vn'),  vn' = vn + (l' - l) / mass
template <class L>
[[gnu::always_inline]] inline F<L> spring_impulse(F<L> l, F<L> push, F<L> drag, F<L> mass,
                                                  F<L> stretch, F<L> vn0, F<L> vn) {
  const auto pull = L::add(L::mul(push, stretch), L::mul(drag, L::add(vn0, vn)));
  const auto sum = L::sub(L::mul(drag, l), L::mul(mass, pull));
  const auto both = L::add(mass, drag);
  return L::div(sum, L::select(L::less(L::set1(0), both), both, L::set1(1)));
}

// ---- motion of the anchors --------------------------------------------------------------------------

/// Velocity of B's anchor against A's.
template <class L>
[[gnu::always_inline]] inline Vec<L> anchor_velocity(const TwoBodies<L>& m, const Arms<L>& j) {
  return {L::sub(L::sub(m.vbx, L::mul(m.ub, j.b.y)), L::sub(m.vax, L::mul(m.ua, j.a.y))),
          L::sub(L::add(m.vby, L::mul(m.ub, j.b.x)), L::add(m.vay, L::mul(m.ua, j.a.x)))};
}

/// h x centripetal acceleration of B's anchor against A's, -rB wB^2 + rA wA^2; of turns that h resolves.
template <class L>
[[gnu::always_inline]] inline Vec<L> anchor_pull(const TwoBodies<L>& m, const Arms<L>& j, F<L> h) {
  const auto most = L::set1(0.05f);
  const auto ta = L::min(L::mul(h, L::mul(L::abs(m.ua), j.ra)), most);
  const auto tb = L::min(L::mul(h, L::mul(L::abs(m.ub), j.rb)), most);
  return minus<L>(times<L>(L::mul(ta, L::abs(m.ua)), j.a), times<L>(L::mul(tb, L::abs(m.ub)), j.b));
}

/// Angular velocity of B against A.
template <class L>
[[gnu::always_inline]] inline F<L> turning(const TwoBodies<L>& m, const Arms<L>& j) {
  return L::sub(L::mul(m.ub, j.rb), L::mul(m.ua, j.ra));
}

/// Arms as the bodies lie now, stored; and how far B's anchor has moved against A's since the frame's
/// start, m.
template <class L>
[[gnu::always_inline]] inline Vec<L> turn_arms(const BodyView& b, JointBodies& j, std::uint32_t k,
                                               Arms<L>& arms) {
  const std::uint32_t* slot = j.body + 2 * k;
  Vec<L> ta, tb, da, db;
  L::template gather<2>(b.turn, slot, ta.x, ta.y);
  L::template gather<2>(b.turn, slot + 1, tb.x, tb.y);
  L::template gather<2>(b.disp, slot, da.x, da.y);
  L::template gather<2>(b.disp, slot + 1, db.x, db.y);
  const auto a0 = load_vec<L>(j.ax0, j.ay0, k), b0 = load_vec<L>(j.bx0, j.by0, k);
  const Vec<L> moved_a{L::sub(L::mul(ta.x, a0.x), L::mul(ta.y, a0.y)),
                       L::add(L::mul(ta.x, a0.y), L::mul(ta.y, a0.x))};
  const Vec<L> moved_b{L::sub(L::mul(tb.x, b0.x), L::mul(tb.y, b0.y)),
                       L::add(L::mul(tb.x, b0.y), L::mul(tb.y, b0.x))};
  arms.a = plus<L>(a0, times<L>(arms.ra, moved_a));
  arms.b = plus<L>(b0, times<L>(arms.rb, moved_b));
  store_vec<L>(j.ax, j.ay, k, arms.a);
  store_vec<L>(j.bx, j.by, k, arms.b);
  return plus<L>(minus<L>(db, da), minus<L>(moved_b, moved_a));
}

/// Angle of B against A now, rad.
template <class L, class Block>
[[gnu::always_inline]] inline F<L> present_angle(const BodyView& b, const Block& j,
                                                 std::uint32_t k) {
  const std::uint32_t* slot = j.body + 2 * k;
  const auto swung =
      L::sub(L::template gather1<2>(b.swing, slot + 1), L::template gather1<2>(b.swing, slot));
  return L::add(L::load(j.angle0 + k), swung);
}

// ---- turning of impulses ----------------------------------------------------------------------------

/// Half of what turning the impulses adds: e to the impulse, sa and sb to those of the levers (the arms of a
/// pin turn and its axes do not: e = 0). Kept for the next solve.
template <class L, bool kFixedA, class Block>
[[gnu::always_inline]] inline void turn_half(TwoBodies<L>& m, const Arms<L>& arms, Block& j,
                                             std::uint32_t k, const Row<L>& e) {
  if constexpr (requires { j.ex; }) store_vec<L>(j.ex, j.ey, k, e.n);
  store_vec<L>(j.spin_a, j.spin_b, k, {e.sa, e.sb});
  push<L, kFixedA>(m, arms, e.n, e.sa, e.sb);
}

/// The other half, of the last substep's impulses.
template <class L, bool kFixedA, class Block>
[[gnu::always_inline]] inline void turn_on(TwoBodies<L>& m, const Arms<L>& arms, const Block& j,
                                           std::uint32_t k) {
  Vec<L> e{L::set1(0), L::set1(0)};
  if constexpr (requires { j.ex; }) e = load_vec<L>(j.ex, j.ey, k);
  push<L, kFixedA>(m, arms, e, L::load(j.spin_a + k), L::load(j.spin_b + k));
}

/// There was none.
template <class L, class Block>
[[gnu::always_inline]] inline void forget_turn(Block& j, std::uint32_t k) {
  const Vec<L> none{L::set1(0), L::set1(0)};
  if constexpr (requires { j.ex; }) store_vec<L>(j.ex, j.ey, k, none);
  store_vec<L>(j.spin_a, j.spin_b, k, none);
}

}  // namespace
}  // namespace psim::kernels
