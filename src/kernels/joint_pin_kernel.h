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
[[gnu::always_inline]] inline void slow_turns(JointBodies& b, std::uint32_t k, Arms<L>& j, Vec<L> p,
                                              F<L> h) {
  const auto one = L::set1(1);
  const auto size = L::mul(h, L::add(L::abs(p.x), L::abs(p.y)));
  const auto ga = L::load(b.ga0 + k), gb = L::load(b.gb0 + k);
  const auto a = L::mul(L::mul(ga, j.ra), L::add(L::abs(j.a.x), L::abs(j.a.y)));
  const auto c = L::mul(L::mul(gb, j.rb), L::add(L::abs(j.b.x), L::abs(j.b.y)));
  j.ga = L::div(ga, L::max(L::mul(size, a), one));
  j.gb = L::div(gb, L::max(L::mul(size, c), one));
  L::store(b.ga + k, j.ga);
  L::store(b.gb + k, j.gb);
}

/// Errors and masses at the bodies' present places.
template <class L, class Block>
[[gnu::always_inline]] inline void find_pin(const BodyView& b, Block& j, std::uint32_t k,
                                            Arms<L>& arms, F<L> h) {
  const auto moved = turn_arms<L>(b, j, k, arms);
  slow_turns<L>(j, k, arms, load_vec<L>(j.px, j.py, k), h);
  store_vec<L>(j.cx, j.cy, k, plus<L>(load_vec<L>(j.cx0, j.cy0, k), moved));
  const auto w = L::add(arms.wa, arms.wb);
  const auto fa = times<L>(arms.ga, arms.a), fb = times<L>(arms.gb, arms.b);
  const auto k11 = L::add(w, L::add(L::mul(fa.y, arms.a.y), L::mul(fb.y, arms.b.y)));
  const auto k22 = L::add(w, L::add(L::mul(fa.x, arms.a.x), L::mul(fb.x, arms.b.x)));
  const auto k12 = L::negate(L::add(L::mul(fa.x, arms.a.y), L::mul(fb.x, arms.b.y)));
  const auto inverse = safe_inverse<L>(L::sub(L::mul(k11, k22), L::mul(k12, k12)));
  L::store(j.m11 + k, L::mul(k22, inverse));
  L::store(j.m12 + k, L::negate(L::mul(k12, inverse)));
  L::store(j.m22 + k, L::mul(k11, inverse));
  if constexpr (!kPlainPin<Block>) {
    L::store(j.angle + k, present_angle<L>(b, j, k));
    // What a twist of 1 does to the anchors' velocity, and the impulse g = -K^-1 c that undoes it.
    const auto ta = L::mul(arms.ga, arms.ra), tb = L::mul(arms.gb, arms.rb);
    const Vec<L> c{L::negate(L::add(L::mul(ta, arms.a.y), L::mul(tb, arms.b.y))),
                   L::add(L::mul(ta, arms.a.x), L::mul(tb, arms.b.x))};
    const Vec<L> g{L::mul(inverse, L::sub(L::mul(k12, c.y), L::mul(k22, c.x))),
                   L::mul(inverse, L::sub(L::mul(k12, c.x), L::mul(k11, c.y)))};
    const auto alone = L::add(L::mul(ta, arms.ra), L::mul(tb, arms.rb));
    const auto left = L::add(alone, dot<L>(g, c));
    // Of a body that can turn something is always left; a rest of rounding is none.
    const auto sound = L::less(L::mul(alone, L::set1(1e-5f)), left);
    store_vec<L>(j.gx, j.gy, k, g);
    L::store(j.mass + k, L::both(sound, safe_inverse<L>(left)));
  }
}

/// Impulse p at the anchors.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void push_anchors(TwoBodies<L>& m, const Arms<L>& j, Vec<L> p) {
  push<L, kFixedA>(m, j, p, cross<L>(j.a, p), cross<L>(j.b, p));
}

/// Change of a row of angles by dl, N m s, alone.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void twist(TwoBodies<L>& m, const Arms<L>& j, F<L> dl) {
  if constexpr (!kFixedA) m.ua = L::sub(m.ua, L::mul(j.ga, L::mul(j.ra, dl)));
  m.ub = L::add(m.ub, L::mul(j.gb, L::mul(j.rb, dl)));
}

/// And with what it takes along in the pin, which is added to i.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void twist_pinned(TwoBodies<L>& m, const Arms<L>& j, Vec<L> g,
                                                F<L> dl, Vec<L>& i) {
  const auto p = times<L>(dl, g);
  i = plus<L>(i, p);
  push<L, kFixedA>(m, j, p, L::add(cross<L>(j.a, p), L::mul(j.ra, dl)),
                   L::add(cross<L>(j.b, p), L::mul(j.rb, dl)));
}

template <class L, bool kFixedA, class Block>
void warm_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
               std::uint32_t end) {
  const auto warm = L::set1(p.warm);
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) __attribute__((always_inline)) {
    find_pin<L>(b, j, k, arms, L::set1(p.h));
    const auto i = times<L>(warm, load_vec<L>(j.px, j.py, k));
    store_vec<L>(j.px, j.py, k, i);
    push_anchors<L, kFixedA>(m, arms, i);
    if constexpr (kIsWeld<Block>) {
      const auto l = L::mul(warm, L::load(j.l + k));
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
[[gnu::always_inline]] inline void hold_pin(const BodyView& b, const JointParams& p, Block& j,
                                            std::uint32_t k, const Arms<L>& arms, TwoBodies<L>& m,
                                            Vec<L> v, Vec<L> i) {
  if constexpr (!kPlainPin<Block>) {
    const auto g = load_vec<L>(j.gx, j.gy, k);
    const auto mass = L::load(j.mass + k), along = dot<L>(g, v);
    const auto speed = [&] { return L::add(turning<L>(m, arms), along); };
    const auto push = [&](F<L> dl) { twist_pinned<L, kFixedA>(m, arms, g, dl, i); };
    if constexpr (kIsWeld<Block>) {
      const auto l = L::load(j.l + k), stiff = L::load(j.push + k), spin = speed();
      auto soft = l;
      if constexpr (!kRelax) {
        const auto before = gather_motion<L>(b.vel0, b.spin0, j.body + 2 * k);
        soft = spring_impulse<L>(l, stiff, L::load(j.drag + k), mass, L::load(j.angle + k),
                                 turning<L>(before, arms), spin);
      }
      const auto rigid = L::sub(l, L::mul(mass, spin));
      const auto next = L::select(L::less(L::set1(0), stiff), soft, rigid);
      L::store(j.l + k, next);
      push(L::sub(next, l));
    } else {
      drive_row<L, kRelax>(j.drive, k, j.angle, mass, L::set1(p.inv_h), speed, push);
    }
  }
  const auto d = stop_both<L>(j, k, v);
  store_vec<L>(j.px, j.py, k, plus<L>(i, d));
  push_anchors<L, kFixedA>(m, arms, d);
}

template <class L, bool kFixedA, class Block>
void solve_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                std::uint32_t end) {
  const auto h = L::set1(p.h);
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) __attribute__((always_inline)) {
    if (!p.again) turn_on<L, kFixedA>(m, arms, j, k);
    const auto v = plus<L>(anchor_velocity<L>(m, arms), anchor_pull<L>(m, arms, h));
    hold_pin<L, kFixedA, false>(b, p, j, k, arms, m, v, load_vec<L>(j.px, j.py, k));
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA, class Block>
void push_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
               std::uint32_t end) {
  const auto rate = L::set1(p.rate);
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) __attribute__((always_inline)) {
    const auto v = plus<L>(anchor_velocity<L>(m, arms), times<L>(rate, load_vec<L>(j.cx, j.cy, k)));
    if constexpr (!kPlainPin<Block>) {
      const auto g = load_vec<L>(j.gx, j.gy, k);
      const auto spin = L::add(turning<L>(m, arms), dot<L>(g, v));
      const auto angle = L::load(j.angle + k), mass = L::load(j.mass + k);
      F<L> dl;
      if constexpr (kIsWeld<Block>) {
        const auto rigid = L::less_equal(L::load(j.push + k), L::set1(0));
        dl = L::both(rigid, L::negate(L::mul(mass, L::add(spin, L::mul(rate, angle)))));
      } else {
        dl = push_back<L>(j.drive, k, angle, spin, mass, rate);
      }
      Vec<L> unused{};
      twist_pinned<L, kFixedA>(m, arms, g, dl, unused);
    }
    push_anchors<L, kFixedA>(m, arms, stop_both<L>(j, k, v));
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

template <class L, bool kFixedA, class Block>
void relax_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                std::uint32_t end) {
  const auto half = L::set1(0.5f), zero = L::set1(0);
  const auto each = [&](auto& j, auto k, auto& arms, auto& m) __attribute__((always_inline)) {
    const auto i = load_vec<L>(j.px, j.py, k);
    if (!p.again) {
      const auto a = arms.a, c = arms.b;
      find_pin<L>(b, j, k, arms, L::set1(p.h));
      const auto part = times<L>(half, i);
      turn_half<L, kFixedA>(
          m, arms, j, k,
          {{zero, zero}, cross<L>(minus<L>(arms.a, a), part), cross<L>(minus<L>(arms.b, c), part)});
    }
    hold_pin<L, kFixedA, true>(b, p, j, k, arms, m, anchor_velocity<L>(m, arms), i);
  };
  by_lane<L, kFixedA, Block>(b, blocks, begin, end, each);
}

}  // namespace
}  // namespace psim::kernels
