// Rods, ropes and springs: one row along the line of the anchors.
#pragma once

#include "joint_kernel_common.h"

namespace psim::kernels {
namespace {

/// What belongs to a line with arms is written for both kinds of them, Arms and Centres.
template <class L, class A>
PSIM_INLINE inline auto load_line(const LineBlock& j, std::uint32_t k, const A& arms) {
  return anchor_row<L>(arms, load_vec<L>(j.nx, j.ny, k));
}

template <class L>
PSIM_INLINE inline Vec<L> normal_of(const Row<L>& row) {
  return row.n;
}
template <class L>
PSIM_INLINE inline Vec<L> normal_of(Vec<L> row) {
  return row;
}

/// 1/kg: by how much the velocity along a line grows by an impulse.
template <class L>
PSIM_INLINE inline F<L> line_gain(const Arms<L>& arms, const Row<L>& row) {
  const auto turns = arms.ga * (row.sa * row.sa) + arms.gb * (row.sb * row.sb);
  return arms.wa + arms.wb + turns;
}
template <class L>
PSIM_INLINE inline F<L> line_gain(const Centres<L>& centres, Vec<L>) {
  return centres.wa + centres.wb;
}

/// An impulse along the way from one row to another one.
template <class L>
PSIM_INLINE inline Row<L> part_of_turn(F<L> part, const Row<L>& to, const Row<L>& from) {
  return {part * (to.n - from.n), part * (to.sa - from.sa), part * (to.sb - from.sb)};
}
template <class L>
PSIM_INLINE inline Vec<L> part_of_turn(F<L> part, Vec<L> to, Vec<L> from) {
  return part * (to - from);
}

/// Row, error and mass at the bodies' present places.
template <class L, class A>
PSIM_INLINE inline auto find_line(const BodyView& b, LineBlock& j, std::uint32_t k, A& arms) {
  const auto dd = turn_arms<L>(b, j, k, arms);
  const auto d0 = load_vec<L>(j.dx0, j.dy0, k);
  const auto far0 = L::load(j.far0 + k);
  const auto d = d0 + dd;
  const auto far = sqrt(dot(d, d));
  const auto apart = 1e-12f < far;
  const F<L> curvature = 1 / select(apart, far, 1);
  // |d| - |d0| = dd.(d0 + d) / (|d| + |d0|), so that nothing cancels
  const auto both = far + far0;
  const auto grown = dot(dd, d0 + d) / select(apart, both, 1);
  const auto c = L::load(j.c0 + k) + select(apart, grown, far - far0);
  const Vec<L> n{snapped<L>(select(apart, d.x * curvature, L::load(j.nx + k))),
                 snapped<L>(select(apart, d.y * curvature, L::load(j.ny + k)))};
  const auto row = anchor_row<L>(arms, n);
  store_vec<L>(j.nx, j.ny, k, n);
  L::store(j.c + k, c);
  L::store(j.curvature + k, curvature);
  L::store(j.mass + k, safe_inverse<L>(line_gain<L>(arms, row)));
  return row;
}

/// h x acceleration at which the distance of the anchors grows by itself. It counts as far as h resolves the turn: `most`
/// is the largest h omega that counts in full.
template <class L>
PSIM_INLINE inline F<L> line_curve(const TwoBodies<L>&, const Centres<L>&, Vec<L> n, Vec<L> v, F<L> curvature, F<L> h,
                                   F<L> most) {
  const auto sideways = snapped<L>(abs(cross(n, v)));
  const auto share = min(sideways * curvature * h, most);
  return sideways * share;
}
template <class L>
PSIM_INLINE inline F<L> line_curve(const TwoBodies<L>& m, const Arms<L>& arms, Vec<L> n, Vec<L> v, F<L> curvature,
                                   F<L> h, F<L> most) {
  return line_curve<L>(m, Centres<L>{arms.wa, arms.wb}, n, v, curvature, h, most) + dot(n, anchor_pull<L>(m, arms, h));
}

template <class L, bool kFixedA>
void warm_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> warm = p.warm;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto row = find_line<L>(b, j, k, arms);
    const auto l = L::load(j.l + k) * warm;
    push_row<L, kFixedA>(m, arms, row, l);
    L::store(j.l + k, l);
    forget_turn<L>(j, k);
  };
  by_line<L, kFixedA, LineBlock>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA, bool kSpring>
void solve_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> zero = 0, h = p.h, inv_h = p.inv_h;
  const F<L> half_h = 0.5f * p.h, quarter_h = 0.25f * p.h, resolved = kSpring ? 1.0f : kResolvedTurn;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto row = load_line<L>(j, k, arms);
    const auto n = normal_of<L>(row);
    if (!p.again) turn_on<L, kFixedA>(m, arms, j, k);
    const auto v = anchor_velocity<L>(m, arms);
    const auto vn = dot(n, v), c = L::load(j.c + k), l = L::load(j.l + k);
    const auto mass = L::load(j.mass + k);
    const auto curve = line_curve<L>(m, arms, n, v, L::load(j.curvature + k), h, resolved);
    F<L> next;
    if constexpr (kSpring) {
      const auto before = gather_motion<L>(b.vel0, b.rim_speed0, j.body + 2 * k);
      const auto vn0 = dot(normal_of<L>(row), anchor_velocity<L>(before, arms));
      next = spring_impulse<L>(j, k, l, mass, c + quarter_h * curve, vn0, vn);
    } else {
      const auto top = L::load(j.top + k);
      const auto ahead = c + half_h * curve;
      const auto slack = (top <= zero) & (ahead < zero);
      const auto bias = select(slack, ahead * inv_h, curve);
      next = min(l - mass * (vn + bias), top);
    }
    next = snapped<L>(next, mass * kLeast);
    push_row<L, kFixedA>(m, arms, row, next - l);
    L::store(j.l + k, next);
  };
  by_line<L, kFixedA, LineBlock>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA>
void push_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> zero = 0, rate = p.rate;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto row = load_line<L>(j, k, arms);
    const auto c = L::load(j.c + k);
    const auto vn = dot(normal_of<L>(row), anchor_velocity<L>(m, arms));
    const auto slack = (L::load(j.top + k) <= zero) & (c < zero);
    const auto mass = L::load(j.mass + k);
    const auto wish = snapped<L>(mass * (vn + rate * c), mass * kLeast);
    push_row<L, kFixedA>(m, arms, row, -select(slack, zero, wish));
  };
  by_line<L, kFixedA, LineBlock>(b, blocks, begin, end, each);
}

/// Springs have no position error.
template <class L>
void push_nothing(const BodyView&, JointBlocks, const JointParams&, std::uint32_t, std::uint32_t) {}

template <class L, bool kFixedA, bool kSpring>
void relax_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> zero = 0, half = 0.5f, one = 1, h = p.h;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    auto row = load_line<L>(j, k, arms);
    const auto l = L::load(j.l + k);
    if (!p.again) {
      const auto old = row;
      row = find_line<L>(b, j, k, arms);
      const auto stiffness = abs(l) * h * L::load(j.curvature + k) * (arms.wa + arms.wb);  // x h^2
      const auto part = half * l / max(stiffness, one);
      turn_half<L, kFixedA>(m, arms, j, k, part_of_turn<L>(part, row, old));
    }
    if constexpr (!kSpring) {
      const auto vn = dot(normal_of<L>(row), anchor_velocity<L>(m, arms));
      const auto mass = L::load(j.mass + k), top = L::load(j.top + k);
      const auto open = (top <= zero) & (zero <= l);
      const auto next = select(open, l, snapped<L>(min(l - mass * vn, top), mass * kLeast));
      push_row<L, kFixedA>(m, arms, row, next - l);
      L::store(j.l + k, next);
    }
  };
  by_line<L, kFixedA, LineBlock>(b, blocks, begin, end, each);
}

}  // namespace
}  // namespace psim::kernels
