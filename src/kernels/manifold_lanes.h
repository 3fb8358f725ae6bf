// The bodies of some manifolds in lanes, impulses on them, and the two-point problem: for the passes of
// manifold_kernel.h.
#pragma once

#include "lane_vec.h"
#include "manifold_views.h"

namespace psim::kernels {
namespace {

/// The velocities and rim speeds of the two bodies of some lanes.
template <class L>
struct TwoBodies {
  F<L> vax, vay, ua, vbx, vby, ub;
};

template <class L>
PSIM_INLINE inline TwoBodies<L> gather_motion(const float* vel, const float* rim_speed, const std::uint32_t* slot) {
  TwoBodies<L> m;
  L::template gather<2>(vel, slot, m.vax, m.vay);
  L::template gather<2>(vel, slot + 1, m.vbx, m.vby);
  m.ua = L::template gather1<2>(rim_speed, slot);
  m.ub = L::template gather1<2>(rim_speed, slot + 1);
  return m;
}

/// kSnap: between sweeps of the solve pass, by which velocities would decay into denormals. The relax pass leaves open
/// lanes alone, so that it may not change their velocities.
template <class L, bool kFixedA, bool kSnap = false>
PSIM_INLINE inline void scatter_motion(float* vel, float* rim_speed, const std::uint32_t* slot, TwoBodies<L> m) {
  if constexpr (kSnap) {
    m = {snapped<L>(m.vax), snapped<L>(m.vay), snapped<L>(m.ua),
         snapped<L>(m.vbx), snapped<L>(m.vby), snapped<L>(m.ub)};
  }
  if constexpr (!kFixedA) {
    L::template scatter<2>(vel, slot, m.vax, m.vay);
    L::template scatter1<2>(rim_speed, slot, m.ua);
  }
  L::template scatter<2>(vel, slot + 1, m.vbx, m.vby);
  L::template scatter1<2>(rim_speed, slot + 1, m.ub);
}

/// Impulses along n, which change the rim speeds by at and bt, or, with the arms exchanged, along t.
template <class L, bool kFixedA>
PSIM_INLINE inline void apply_impulse(TwoBodies<L>& m, F<L> px, F<L> py, F<L> turn_a, F<L> turn_b, F<L> wa, F<L> wb,
                                      F<L> ga, F<L> gb) {
  if constexpr (!kFixedA) {
    m.vax = m.vax - wa * px;
    m.vay = m.vay - wa * py;
    m.ua = m.ua - ga * turn_a;
  }
  m.vbx = m.vbx + wb * px;
  m.vby = m.vby + wb * py;
  m.ub = m.ub + gb * turn_b;
}

/// The smaller of l' that solve the two-point problem; q is without the stored impulses.
template <class L>
PSIM_INLINE inline void solve_two(F<L> a11, F<L> a12, F<L> a22, F<L> q1, F<L> q2, F<L>& l1, F<L>& l2) {
  const F<L> zero = 0, one = 1;
  const auto det = a11 * a22 - a12 * a12;
  // Points that all but coincide carry the load alone, one of them.
  const auto sound = 1e-4f * (a11 * a22) < det;
  const auto inverse = one / select(sound, det, one);
  const auto both1 = inverse * (a12 * q2 - a22 * q1);
  const auto both2 = inverse * (a12 * q1 - a11 * q2);
  const auto only1 = -q1 / a11, only2 = -q2 / a22;
  const auto both_hold = sound & ((zero <= both1) & (zero <= both2));
  // What is left at the other point: not less than nothing, or, of points that all but coincide, more than otherwise.
  const auto left2 = a12 * only1 + q2, left1 = a12 * only2 + q1;
  auto enough1 = zero, enough2 = zero;
  if (!all(sound)) [[unlikely]] {
    enough1 = select(sound, zero, min(left1, zero));
    enough2 = select(sound, zero, min(left2, zero));
  }
  const auto holds1 = (zero <= only1) & (enough1 <= left2);
  const auto holds2 = (zero <= only2) & (enough2 <= left1);
  l1 = select(both_hold, both1, select(holds1, only1, zero));
  l2 = select(both_hold, both2, select(holds1, zero, select(holds2, only2, zero)));
}

/// An impulse that turns B against A; it moves neither.
template <class L, bool kFixedA>
PSIM_INLINE inline void turn_against(TwoBodies<L>& m, const SurfaceBlock& s, std::uint32_t k, F<L> impulse, F<L> ga,
                                     F<L> gb) {
  if constexpr (!kFixedA) m.ua = m.ua - ga * (L::load(s.inv_size_a + k) * impulse);
  m.ub = m.ub + gb * (L::load(s.inv_size_b + k) * impulse);
}

}  // namespace
}  // namespace psim::kernels
