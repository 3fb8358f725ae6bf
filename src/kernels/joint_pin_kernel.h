// Pins, with or without limits and motor, and welds: two rows that keep the anchors together, solved
// together, and a row of angles on top. An impulse in that one takes along what keeps the anchors
// together, so that all rows of a joint are solved exactly.
#pragma once

#include "joint_drive_kernel.h"

namespace psim::kernels {
namespace {

template <class Block>
inline constexpr bool kPlainPin = false;
template <>
inline constexpr bool kPlainPin<PinBlock> = true;
template <class Block>
inline constexpr bool kIsWeld = false;
template <>
inline constexpr bool kIsWeld<WeldBlock> = true;

/// A load P on an arm a R turns the body back like a spring: in a substep by chi = g |a| |P| h / R of
/// its angle. What h cannot resolve (leapfrog: chi > 4, of all joints together) would gain energy, so
/// such bodies turn as slowly as h can follow.
template <class L>
PSIM_INLINE inline void slow_turns(JointBodies& b, std::uint32_t k, Arms<L>& j, Vec<L> p, F<L> h) {
  const F<L> one = 1;
  const auto size = h * (abs(p.x) + abs(p.y));
  const auto ga = L::load(b.ga0 + k), gb = L::load(b.gb0 + k);
  const auto a = ga * j.ra * (abs(j.a.x) + abs(j.a.y));
  const auto c = gb * j.rb * (abs(j.b.x) + abs(j.b.y));
  j.ga = ga / max(size * a, one);
  j.gb = gb / max(size * c, one);
  L::store(b.ga + k, j.ga);
  L::store(b.gb + k, j.gb);
}

/// Errors and masses at the bodies' present places.
template <class L, class Block>
PSIM_INLINE inline void find_pin(const BodyView& b, Block& j, std::uint32_t k, Arms<L>& arms, F<L> h) {
  const auto moved = turn_arms<L>(b, j, k, arms);
  slow_turns<L>(j, k, arms, load_vec<L>(j.px, j.py, k), h);
  store_vec<L>(j.cx, j.cy, k, load_vec<L>(j.cx0, j.cy0, k) + moved);
  const auto w = arms.wa + arms.wb;
  const auto fa = arms.ga * arms.a, fb = arms.gb * arms.b;
  const auto k11 = w + (fa.y * arms.a.y + fb.y * arms.b.y);
  const auto k22 = w + (fa.x * arms.a.x + fb.x * arms.b.x);
  const auto k12 = -(fa.x * arms.a.y + fb.x * arms.b.y);
  const auto inverse = safe_inverse<L>(k11 * k22 - k12 * k12);
  L::store(j.m11 + k, k22 * inverse);
  L::store(j.m12 + k, -(k12 * inverse));
  L::store(j.m22 + k, k11 * inverse);
  if constexpr (!kPlainPin<Block>) {
    L::store(j.angle + k, present_angle<L>(b, j, k));
    // What a twist of 1 does to the anchors' velocity, and the impulse g = -K^-1 c that undoes it.
    const auto ta = arms.ga * arms.ra, tb = arms.gb * arms.rb;
    const Vec<L> c{-(ta * arms.a.y + tb * arms.b.y), ta * arms.a.x + tb * arms.b.x};
    const Vec<L> g{inverse * (k12 * c.y - k22 * c.x), inverse * (k12 * c.x - k11 * c.y)};
    const auto alone = ta * arms.ra + tb * arms.rb;
    const auto left = alone + dot(g, c);
    // Of a body that can turn something is always left; a rest of rounding is none.
    const auto sound = alone * 1e-5f < left;
    store_vec<L>(j.gx, j.gy, k, g);
    L::store(j.mass + k, keep(sound, safe_inverse<L>(left)));
  }
}

/// Impulse p at the anchors.
template <class L, bool kFixedA>
PSIM_INLINE inline void push_anchors(TwoBodies<L>& m, const Arms<L>& j, Vec<L> p) {
  push<L, kFixedA>(m, j, p, cross(j.a, p), cross(j.b, p));
}

/// Change of a row of angles by dl, N m s, alone.
template <class L, bool kFixedA>
PSIM_INLINE inline void twist(TwoBodies<L>& m, const Arms<L>& j, F<L> dl) {
  if constexpr (!kFixedA) m.ua = m.ua - j.ga * (j.ra * dl);
  m.ub = m.ub + j.gb * (j.rb * dl);
}

/// And with what it takes along in the pin, which is added to i.
template <class L, bool kFixedA>
PSIM_INLINE inline void twist_pinned(TwoBodies<L>& m, const Arms<L>& j, Vec<L> g, F<L> dl, Vec<L>& i) {
  const auto p = dl * g;
  i = i + p;
  push<L, kFixedA>(m, j, p, cross(j.a, p) + j.ra * dl, cross(j.b, p) + j.rb * dl);
}

template <class L, bool kFixedA, class Block>
void warm_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> warm = p.warm;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    find_pin<L>(b, j, k, arms, p.h);
    const auto i = warm * load_vec<L>(j.px, j.py, k);
    store_vec<L>(j.px, j.py, k, i);
    push_anchors<L, kFixedA>(m, arms, i);
    if constexpr (kIsWeld<Block>) {
      const auto l = warm * L::load(j.l + k);
      L::store(j.l + k, l);
      twist<L, kFixedA>(m, arms, l);
    } else if constexpr (!kPlainPin<Block>) {
      twist<L, kFixedA>(m, arms, warm_drive<L>(j.drive, k, warm));
    }
    forget_turn<L>(j, k);
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

/// Adds to i what takes the anchors' velocity v away, in solve and in relax: the angle first.
template <class L, bool kFixedA, bool kRelax, class Block>
PSIM_INLINE inline void hold_pin(const BodyView& b, const JointParams& p, Block& j, std::uint32_t k,
                                 const Arms<L>& arms, TwoBodies<L>& m, Vec<L> v, Vec<L> i) {
  if constexpr (!kPlainPin<Block>) {
    const auto g = load_vec<L>(j.gx, j.gy, k);
    const auto mass = L::load(j.mass + k), along = dot(g, v);
    const auto speed = [&] { return turning<L>(m, arms) + along; };
    const auto push = [&](F<L> dl) { twist_pinned<L, kFixedA>(m, arms, g, dl, i); };
    if constexpr (kIsWeld<Block>) {
      const auto l = L::load(j.l + k), stiff = L::load(j.push + k), rim_speed = speed();
      auto soft = l;
      if constexpr (!kRelax) {
        const auto before = gather_motion<L>(b.vel0, b.rim_speed0, j.body + 2 * k);
        soft = spring_impulse<L>(j, k, l, mass, L::load(j.angle + k), turning<L>(before, arms), rim_speed);
      }
      const auto rigid = l - mass * rim_speed;
      const auto next = select(0 < stiff, soft, rigid);
      L::store(j.l + k, next);
      push(next - l);
    } else {
      drive_row<L, kRelax>(j.drive, k, j.angle, mass, p.inv_h, speed, push);
    }
  }
  const auto d = stop_both<L>(j, k, v);
  store_vec<L>(j.px, j.py, k, i + d);
  push_anchors<L, kFixedA>(m, arms, d);
}

template <class L, bool kFixedA, class Block>
void solve_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> h = p.h;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    if (!p.again) turn_on<L, kFixedA>(m, arms, j, k);
    const auto v = anchor_velocity<L>(m, arms) + anchor_pull<L>(m, arms, h);
    hold_pin<L, kFixedA, false>(b, p, j, k, arms, m, v, load_vec<L>(j.px, j.py, k));
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA, class Block>
void push_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> rate = p.rate;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto v = anchor_velocity<L>(m, arms) + rate * load_vec<L>(j.cx, j.cy, k);
    if constexpr (!kPlainPin<Block>) {
      const auto g = load_vec<L>(j.gx, j.gy, k);
      const auto rim_speed = turning<L>(m, arms) + dot(g, v);
      const auto angle = L::load(j.angle + k), mass = L::load(j.mass + k);
      F<L> dl;
      if constexpr (kIsWeld<Block>) {
        const auto rigid = L::load(j.push + k) <= 0;
        dl = keep(rigid, -(mass * (rim_speed + rate * angle)));
      } else {
        dl = push_back<L>(j.drive, k, angle, rim_speed, mass, rate);
      }
      Vec<L> unused{};
      twist_pinned<L, kFixedA>(m, arms, g, dl, unused);
    }
    push_anchors<L, kFixedA>(m, arms, stop_both<L>(j, k, v));
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA, class Block>
void relax_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin, std::uint32_t end) {
  const F<L> half = 0.5f, zero = 0;
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) PSIM_INLINE_LAMBDA {
    const auto i = load_vec<L>(j.px, j.py, k);
    if (!p.again) {
      const auto a = arms.a, c = arms.b;
      find_pin<L>(b, j, k, arms, p.h);
      const auto part = half * i;
      turn_half<L, kFixedA>(m, arms, j, k, {{zero, zero}, cross(arms.a - a, part), cross(arms.b - c, part)});
    }
    hold_pin<L, kFixedA, true>(b, p, j, k, arms, m, anchor_velocity<L>(m, arms), i);
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

}  // namespace
}  // namespace psim::kernels
