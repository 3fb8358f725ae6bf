// Slides: across the axis and of the angle two rows solved together, that never let go, and on top one
// along the axis with ends and a motor. An impulse in that one takes along what keeps the other two.
#pragma once

#include "joint_drive_kernel.h"

namespace psim::kernels {
namespace {

/// A's arm reaches to B's anchor. Filled member by member: g++ copies whole rows by way of the stack.
template <class L>
struct SlideRows {
  Row<L> along, across;
  Vec<L> g;  // what 1 N s along takes along across, and of the angle
};

template <class L>
PSIM_INLINE inline SlideRows<L> load_slide(const SlideBlock& j, std::uint32_t k) {
  SlideRows<L> r;
  r.along.n = load_vec<L>(j.ux, j.uy, k);
  r.along.sa = L::load(j.pull_a + k);
  r.along.sb = L::load(j.pull_b + k);
  r.across.n = left_of(r.along.n);
  r.across.sa = L::load(j.lean_a + k);
  r.across.sb = L::load(j.lean_b + k);
  r.g = load_vec<L>(j.gl, j.gt, k);
  return r;
}

/// Rows, errors and masses at the bodies' present places.
template <class L>
PSIM_INLINE inline SlideRows<L> find_slide(const BodyView& b, SlideBlock& j, std::uint32_t k, Arms<L>& arms) {
  const F<L> one = 1;
  const auto moved = turn_arms<L>(b, j, k, arms);
  const auto u0 = load_vec<L>(j.ux0, j.uy0, k);
  Vec<L> t;
  L::template gather<2>(b.arm_change, j.body + 2 * k, t.x, t.y);
  t = arms.ra * t;  // cos d - 1, sin d
  SlideRows<L> r;
  auto& u = r.along.n;
  auto& n = r.across.n;
  u = u0 + (t.x * u0 + t.y * left_of(u0));
  n = left_of(u);
  // d = d0 + moved; d0 in the axes at the start is (along0, off0).
  const auto along0 = L::load(j.along0 + k), off0 = L::load(j.off0 + k);
  const auto c = one + t.x;
  const auto along = along0 * c + off0 * t.y + dot(u, moved);
  const auto off = off0 * c - along0 * t.y + dot(n, moved);
  const auto reach = arms.a + arms.ra * (along * u + off * n);
  r.along.sa = cross(reach, u);
  r.along.sb = cross(arms.b, u);
  r.across.sa = cross(reach, n);
  r.across.sb = cross(arms.b, n);
  const auto w = arms.wa + arms.wb;
  const auto fa = arms.ga * r.across.sa, fb = arms.gb * r.across.sb;
  const auto k11 = w + (fa * r.across.sa + fb * r.across.sb);
  const auto k12 = fa * arms.ra + fb * arms.rb;
  const auto k22 = arms.ga * (arms.ra * arms.ra) + arms.gb * (arms.rb * arms.rb);
  // Bodies that cannot turn: the angle holds by itself.
  const auto stiff = k22 <= 0;
  const auto inverse = safe_inverse<L>(k11 * select(stiff, one, k22) - k12 * k12);
  const auto m11 = select(stiff, one, k22) * inverse;
  const auto m12 = -(k12 * inverse);
  const auto m22 = select(stiff, 0, k11 * inverse);
  // What 1 N s along does across and to the angle, and what undoes it.
  const Vec<L> does{fa * r.along.sa + fb * r.along.sb, arms.ga * arms.ra * r.along.sa + arms.gb * arms.rb * r.along.sb};
  r.g = {-(m11 * does.x + m12 * does.y), -(m12 * does.x + m22 * does.y)};
  const auto alone = w + (arms.ga * r.along.sa * r.along.sa + arms.gb * r.along.sb * r.along.sb);
  const auto left = alone + dot(r.g, does);
  L::store(j.m11 + k, m11);
  L::store(j.m12 + k, m12);
  L::store(j.m22 + k, m22);
  store_vec<L>(j.gl, j.gt, k, r.g);
  L::store(j.mass + k, safe_inverse<L>(max(left, w)));
  store_vec<L>(j.ux, j.uy, k, u);
  L::store(j.along + k, along);
  L::store(j.off + k, off);
  L::store(j.angle + k, present_angle<L>(b, j, k));
  store_vec<L>(j.lean_a, j.lean_b, k, {r.across.sa, r.across.sb});
  store_vec<L>(j.pull_a, j.pull_b, k, {r.along.sa, r.along.sb});
  return r;
}

template <class L>
PSIM_INLINE inline F<L> slide_speed(const TwoBodies<L>& m, const Row<L>& r) {
  const Vec<L> v{m.vbx - m.vax, m.vby - m.vay};
  return dot(r.n, v) + (m.ub * r.sb - m.ua * r.sa);
}

/// Speed along once the other rows are held, that miss their aim by v.
template <class L>
PSIM_INLINE inline F<L> held_speed(const TwoBodies<L>& m, const SlideRows<L>& r, Vec<L> v) {
  return slide_speed<L>(m, r.along) + dot(r.g, v);
}

/// Impulses across (i.x) and of the angle (i.y).
template <class L, bool kFixedA>
PSIM_INLINE inline void push_across(TwoBodies<L>& m, const Arms<L>& arms, const SlideRows<L>& r, Vec<L> i) {
  push<L, kFixedA>(m, arms, i.x * r.across.n, i.x * r.across.sa + i.y * arms.ra, i.x * r.across.sb + i.y * arms.rb);
}

/// Along, with what that takes along in the other rows, which is added to i.
template <class L, bool kFixedA>
PSIM_INLINE inline void push_held(TwoBodies<L>& m, const Arms<L>& arms, const SlideRows<L>& r, F<L> dl, Vec<L>& i) {
  push_row<L, kFixedA>(m, arms, r.along, dl);
  const auto taken = dl * r.g;
  i = i + taken;
  push_across<L, kFixedA>(m, arms, r, taken);
}

template <class L, bool kFixedA>
void warm_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> warm = p.warm;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto r = find_slide<L>(b, j, k, arms);
    const auto i = warm * load_vec<L>(j.l, j.turn_l, k);
    store_vec<L>(j.l, j.turn_l, k, i);
    push_across<L, kFixedA>(m, arms, r, i);
    push_row<L, kFixedA>(m, arms, r.along, warm_drive<L>(j.drive, k, warm));
    forget_turn<L>(j, k);
  };
  by_lane<L, kFixedA, SlideBlock>(b, blocks, begin, end, each);
}

/// Impulses that take the velocities v across and of the angle away, in solve and in relax: along first.
template <class L, bool kFixedA, bool kRelax>
PSIM_INLINE inline void hold_slide(const JointParams& p, SlideBlock& j, std::uint32_t k, const Arms<L>& arms,
                                   TwoBodies<L>& m, const SlideRows<L>& r, Vec<L> v) {
  auto i = load_vec<L>(j.l, j.turn_l, k);
  drive_row<L, kRelax>(
      j.drive, k, j.along, L::load(j.mass + k), p.inv_h, [&] { return held_speed<L>(m, r, v); },
      [&](F<L> dl) { push_held<L, kFixedA>(m, arms, r, dl, i); });
  const auto d = stop_both<L>(j, k, v);
  store_vec<L>(j.l, j.turn_l, k, i + d);
  push_across<L, kFixedA>(m, arms, r, d);
}

template <class L, bool kFixedA>
void solve_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> h = p.h, two = 2;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto r = load_slide<L>(j, k);
    if (!p.again) turn_on<L, kFixedA>(m, arms, j, k);
    // d^2/dt^2 of n.d, where n turns with A: n.d'' - 2 w u.d' - w^2 n.d
    const auto w = m.ua * arms.ra;
    const auto v = anchor_velocity<L>(m, arms);
    const auto turn = max(min(h * w, 0.5f), -0.5f);
    const auto curve =
        dot(r.across.n, anchor_pull<L>(m, arms, h)) - turn * (two * dot(r.along.n, v) + w * L::load(j.off + k));
    hold_slide<L, kFixedA, false>(p, j, k, arms, m, r, {slide_speed<L>(m, r.across) + curve, turning<L>(m, arms)});
  };
  by_lane<L, kFixedA, SlideBlock>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA>
void push_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> rate = p.rate;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto r = load_slide<L>(j, k);
    const auto error = load_vec<L>(j.off, j.angle, k);
    const auto v = Vec<L>{slide_speed<L>(m, r.across), turning<L>(m, arms)} + rate * error;
    const auto dl = push_back<L>(j.drive, k, L::load(j.along + k), held_speed<L>(m, r, v), L::load(j.mass + k), rate);
    Vec<L> unused{};
    push_held<L, kFixedA>(m, arms, r, dl, unused);
    push_across<L, kFixedA>(m, arms, r, stop_both<L>(j, k, v));
  };
  by_lane<L, kFixedA, SlideBlock>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA>
void relax_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> half = 0.5f;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    auto r = load_slide<L>(j, k);
    if (!p.again) {
      const auto old = r;
      r = find_slide<L>(b, j, k, arms);
      const auto l = half * L::load(j.l + k);
      const auto t = half * driven_impulse<L>(j.drive, k);
      const auto turned = [&](auto across, auto across0, auto along, auto along0) {
        return l * (across - across0) + t * (along - along0);
      };
      turn_half<L, kFixedA>(m, arms, j, k,
                            {{turned(r.across.n.x, old.across.n.x, r.along.n.x, old.along.n.x),
                              turned(r.across.n.y, old.across.n.y, r.along.n.y, old.along.n.y)},
                             turned(r.across.sa, old.across.sa, r.along.sa, old.along.sa),
                             turned(r.across.sb, old.across.sb, r.along.sb, old.along.sb)});
    }
    hold_slide<L, kFixedA, true>(p, j, k, arms, m, r, {slide_speed<L>(m, r.across), turning<L>(m, arms)});
  };
  by_lane<L, kFixedA, SlideBlock>(b, blocks, begin, end, each);
}

}  // namespace
}  // namespace psim::kernels
