// Passes over joints: warm, solve, push, relax (docs/joints.md derives them). Together with the drift
// they are RATTLE (Andersen 1983): the impulse of a substep acts half along the normal at its start and
// half along that at its end, and the drift goes with the first half,
//   x' = x + h (v0 + (kick + w l n) / 2),    v' = v0 + kick + w (l/2 n + (l/2 + dl) n')
// Solve finds l so that the position error stays what it is at x', to second order:
//   vn + curve = 0,   curve = h x (centripetal acceleration of the error)
// push takes a share of the error back, in velocities for the drift alone. Relax finds n', turns half of
// the impulse (adds l/2 (n' - n), kept in `ex`, `spin_a` ...) and makes the velocities agree with the
// joint, vn' = 0. The next kick repeats what the substep did, so that the next solve turns the other
// half, adding the same again.
//
// kFixedA: A is static or kinematic; it is read and never written.
#pragma once

#include "joint_views.h"
#include "manifold_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

template <class L>
struct Vec {
  typename L::F x, y;
};

template <class L>
[[gnu::always_inline]] inline typename L::F dot(Vec<L> a, Vec<L> b) {
  return L::add(L::mul(a.x, b.x), L::mul(a.y, b.y));
}
template <class L>
[[gnu::always_inline]] inline typename L::F cross(Vec<L> a, Vec<L> b) {
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
[[gnu::always_inline]] inline Vec<L> times(typename L::F s, Vec<L> a) {
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

/// Masses and arms of some lanes.
template <class L>
struct Arms {
  Vec<L> a, b;  // over R
  typename L::F wa, wb, ga, gb, ra, rb;
};

template <class L>
[[gnu::always_inline]] inline Arms<L> load_arms(const JointBodies& j, std::uint32_t k) {
  return {load_vec<L>(j.ax, j.ay, k), load_vec<L>(j.bx, j.by, k), L::load(j.wa + k),
          L::load(j.wb + k),          L::load(j.ga + k),          L::load(j.gb + k),
          L::load(j.ra + k),          L::load(j.rb + k)};
}

/// Impulse (px, py) on B, and spin impulses qa, qb (arm / R x impulse).
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void push(TwoBodies<L>& m, const Arms<L>& j, Vec<L> p,
                                        typename L::F qa, typename L::F qb) {
  apply_impulse<L, kFixedA>(m, p.x, p.y, qa, qb, j.wa, j.wb, j.ga, j.gb);
}

/// Velocity of B's anchor against A's.
template <class L>
[[gnu::always_inline]] inline Vec<L> anchor_velocity(const TwoBodies<L>& m, const Arms<L>& j) {
  return {L::sub(L::sub(m.vbx, L::mul(m.ub, j.b.y)), L::sub(m.vax, L::mul(m.ua, j.a.y))),
          L::sub(L::add(m.vby, L::mul(m.ub, j.b.x)), L::add(m.vay, L::mul(m.ua, j.a.x)))};
}

/// h x centripetal acceleration of B's anchor against A's, -rB wB^2 + rA wA^2; of turns that h resolves.
template <class L>
[[gnu::always_inline]] inline Vec<L> anchor_pull(const TwoBodies<L>& m, const Arms<L>& j,
                                                 typename L::F h) {
  const auto most = L::set1(0.05f);
  const auto ta = L::min(L::mul(h, L::mul(L::abs(m.ua), j.ra)), most);
  const auto tb = L::min(L::mul(h, L::mul(L::abs(m.ub), j.rb)), most);
  return minus<L>(times<L>(L::mul(ta, L::abs(m.ua)), j.a), times<L>(L::mul(tb, L::abs(m.ub)), j.b));
}

template <class L>
[[gnu::always_inline]] inline typename L::F turning(const TwoBodies<L>& m, const Arms<L>& j) {
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

template <class L>
[[gnu::always_inline]] inline typename L::F safe_inverse(typename L::F a) {
  const auto sound = L::less(L::set1(0), a);
  return L::both(sound, L::div(L::set1(1), L::select(sound, a, L::set1(1))));
}

/// 1 / (wA + wB + gA sA^2 + gB sB^2)
template <class L>
[[gnu::always_inline]] inline typename L::F row_mass(const Arms<L>& j, typename L::F w,
                                                     typename L::F sa, typename L::F sb) {
  return safe_inverse<L>(
      L::add(w, L::add(L::mul(j.ga, L::mul(sa, sa)), L::mul(j.gb, L::mul(sb, sb)))));
}

/// A load P on an arm a R turns the body back like a spring: in a substep by chi = g |a| |P| h / R of
/// its angle. What h cannot resolve (leapfrog: chi > 4, of all joints together) would gain energy, so
/// such bodies turn as slowly as h can follow.
template <class L>
[[gnu::always_inline]] inline void slow_turns(JointBodies& b, std::uint32_t k, Arms<L>& j, Vec<L> p,
                                              typename L::F h) {
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

/// How far B has turned against A since the frame's start, rad.
template <class L>
[[gnu::always_inline]] inline typename L::F swung(const BodyView& b, const JointBodies& j,
                                                  std::uint32_t k) {
  const std::uint32_t* slot = j.body + 2 * k;
  return L::sub(L::template gather1<2>(b.swing, slot + 1), L::template gather1<2>(b.swing, slot));
}

/// An impulse after a pass over a row with a spring, from `l`: implicit midpoint rule,
///   l' = -push (C + h curve/4) - drag (vn0 + vn'),  vn' = vn + (l' - l) / mass
template <class L>
[[gnu::always_inline]] inline typename L::F spring_impulse(typename L::F l, typename L::F push,
                                                           typename L::F drag, typename L::F mass,
                                                           typename L::F stretch, typename L::F vn0,
                                                           typename L::F vn) {
  const auto pull = L::add(L::mul(push, stretch), L::mul(drag, L::add(vn0, vn)));
  const auto sum = L::sub(L::mul(drag, l), L::mul(mass, pull));
  const auto both = L::add(mass, drag);
  return L::div(sum, L::select(L::less(L::set1(0), both), both, L::set1(1)));
}

// ---- rods, ropes and springs ----------------------------------------------------------------------

/// Normal, error and mass at the bodies' present places.
template <class L>
[[gnu::always_inline]] inline Vec<L> find_line(const BodyView& b, LineBlock& j, std::uint32_t k,
                                               Arms<L>& arms, typename L::F& sa, typename L::F& sb,
                                               typename L::F& mass) {
  const auto dd = turn_arms<L>(b, j, k, arms);
  const auto d0 = load_vec<L>(j.dx0, j.dy0, k);
  const auto far0 = L::load(j.far0 + k);
  const auto d = plus<L>(d0, dd);
  const auto far = L::sqrt(dot<L>(d, d));
  const auto apart = L::less(L::set1(1e-12f), far);
  const auto bend = L::div(L::set1(1), L::select(apart, far, L::set1(1)));
  // |d| - |d0| = dd.(d0 + d) / (|d| + |d0|), so that nothing cancels
  const auto both = L::add(far, far0);
  const auto grown = L::div(dot<L>(dd, plus<L>(d0, d)), L::select(apart, both, L::set1(1)));
  const auto c = L::add(L::load(j.c0 + k), L::select(apart, grown, L::sub(far, far0)));
  const Vec<L> n{L::select(apart, L::mul(d.x, bend), L::load(j.nx + k)),
                 L::select(apart, L::mul(d.y, bend), L::load(j.ny + k))};
  sa = cross<L>(arms.a, n);
  sb = cross<L>(arms.b, n);
  mass = row_mass<L>(arms, L::add(arms.wa, arms.wb), sa, sb);
  store_vec<L>(j.nx, j.ny, k, n);
  L::store(j.c + k, c);
  L::store(j.bend + k, bend);
  L::store(j.mass + k, mass);
  return n;
}

template <class L, bool kFixedA>
void warm_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                std::uint32_t end) {
  const auto warm = L::set1(p.warm), zero = L::set1(0);
  auto* all = static_cast<LineBlock*>(blocks);
  for (LineBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      typename L::F sa, sb, mass;
      const auto n = find_line<L>(b, *j, k, arms, sa, sb, mass);
      const auto l = L::mul(L::load(j->l + k), warm);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      push<L, kFixedA>(m, arms, times<L>(l, n), L::mul(l, sa), L::mul(l, sb));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
      L::store(j->l + k, l);
      store_vec<L>(j->ex, j->ey, k, {zero, zero});
      store_vec<L>(j->spin_a, j->spin_b, k, {zero, zero});
    }
  }
}

/// The other half of the turn of the last substep's impulses.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void turn_on(TwoBodies<L>& m, const Arms<L>& arms,
                                           const JointBodies& j, std::uint32_t k, Vec<L> e) {
  push<L, kFixedA>(m, arms, e, L::load(j.spin_a + k), L::load(j.spin_b + k));
}

/// h x acceleration at which the distance of the anchors grows by itself.
template <class L>
[[gnu::always_inline]] inline typename L::F line_curve(const TwoBodies<L>& m, const Arms<L>& arms,
                                                       Vec<L> n, Vec<L> v, typename L::F bend,
                                                       typename L::F h) {
  const auto sideways = L::abs(cross<L>(n, v));
  const auto share = L::min(L::mul(L::mul(sideways, bend), h), L::set1(1));
  return L::add(L::mul(sideways, share), dot<L>(n, anchor_pull<L>(m, arms, h)));
}

template <class L, bool kFixedA, bool kSpring>
void solve_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                 std::uint32_t end) {
  const auto zero = L::set1(0), h = L::set1(p.h), inv_h = L::set1(p.inv_h);
  const auto half_h = L::set1(0.5f * p.h), quarter_h = L::set1(0.25f * p.h);
  auto* all = static_cast<LineBlock*>(blocks);
  for (LineBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      const auto arms = load_arms<L>(*j, k);
      const auto n = load_vec<L>(j->nx, j->ny, k);
      const auto sa = cross<L>(arms.a, n), sb = cross<L>(arms.b, n);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      if (!p.again) turn_on<L, kFixedA>(m, arms, *j, k, load_vec<L>(j->ex, j->ey, k));
      const auto v = anchor_velocity<L>(m, arms);
      const auto vn = dot<L>(n, v), c = L::load(j->c + k), l = L::load(j->l + k);
      const auto mass = L::load(j->mass + k);
      const auto curve = line_curve<L>(m, arms, n, v, L::load(j->bend + k), h);
      typename L::F next;
      if constexpr (kSpring) {
        const auto before = gather_motion<L>(b.vel0, b.spin0, slot);
        const auto vn0 = dot<L>(n, anchor_velocity<L>(before, arms));
        next = spring_impulse<L>(l, L::load(j->push + k), L::load(j->drag + k), mass,
                                 L::add(c, L::mul(quarter_h, curve)), vn0, vn);
      } else {
        const auto top = L::load(j->top + k);
        const auto ahead = L::add(c, L::mul(half_h, curve));
        const auto slack = L::both(L::less_equal(top, zero), L::less(ahead, zero));
        const auto bias = L::select(slack, L::mul(ahead, inv_h), curve);
        next = L::min(L::sub(l, L::mul(mass, L::add(vn, bias))), top);
      }
      const auto dl = L::sub(next, l);
      push<L, kFixedA>(m, arms, times<L>(dl, n), L::mul(dl, sa), L::mul(dl, sb));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
      L::store(j->l + k, next);
    }
  }
}

template <class L, bool kFixedA, bool kSpring>
void relax_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                 std::uint32_t end) {
  const auto zero = L::set1(0), half = L::set1(0.5f);
  auto* all = static_cast<LineBlock*>(blocks);
  for (LineBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      auto n = load_vec<L>(j->nx, j->ny, k);
      auto sa = cross<L>(arms.a, n), sb = cross<L>(arms.b, n), mass = L::load(j->mass + k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      const auto l = L::load(j->l + k);
      if (!p.again) {
        const auto n0 = n;
        const auto sa0 = sa, sb0 = sb;
        n = find_line<L>(b, *j, k, arms, sa, sb, mass);
        const auto part = L::mul(half, l);
        const auto e = times<L>(part, minus<L>(n, n0));
        store_vec<L>(j->ex, j->ey, k, e);
        store_vec<L>(j->spin_a, j->spin_b, k,
                     {L::mul(part, L::sub(sa, sa0)), L::mul(part, L::sub(sb, sb0))});
        turn_on<L, kFixedA>(m, arms, *j, k, e);
      }
      if constexpr (!kSpring) {
        const auto vn = dot<L>(n, anchor_velocity<L>(m, arms));
        const auto top = L::load(j->top + k);
        const auto open = L::both(L::less_equal(top, zero), L::less_equal(zero, l));
        const auto next = L::select(open, l, L::min(L::sub(l, L::mul(mass, vn)), top));
        const auto dl = L::sub(next, l);
        push<L, kFixedA>(m, arms, times<L>(dl, n), L::mul(dl, sa), L::mul(dl, sb));
        L::store(j->l + k, next);
      }
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

/// The push pass, of all kinds: b.vel and b.spin are velocities for this substep's drift alone, from 0,
/// that take a share of the position errors back: vn = -rate C.
template <class L, bool kFixedA>
void push_lines(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                std::uint32_t end) {
  const auto zero = L::set1(0), rate = L::set1(p.rate);
  auto* all = static_cast<LineBlock*>(blocks);
  for (LineBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      const auto arms = load_arms<L>(*j, k);
      const auto n = load_vec<L>(j->nx, j->ny, k);
      const auto c = L::load(j->c + k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      const auto vn = dot<L>(n, anchor_velocity<L>(m, arms));
      const auto slack = L::both(L::less_equal(L::load(j->top + k), zero), L::less(c, zero));
      const auto wish = L::mul(L::load(j->mass + k), L::add(vn, L::mul(rate, c)));
      const auto dl = L::negate(L::select(slack, zero, wish));
      push<L, kFixedA>(m, arms, times<L>(dl, n), L::mul(dl, cross<L>(arms.a, n)),
                       L::mul(dl, cross<L>(arms.b, n)));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

template <class L>
void push_nothing(const BodyView&, JointBlocks, const JointParams&, std::uint32_t, std::uint32_t) {}

// ---- pins, with or without limits and motor, and welds --------------------------------------------

template <class Block>
inline constexpr bool kPlainPin = false;
template <>
inline constexpr bool kPlainPin<PinBlock> = true;
template <class Block>
inline constexpr bool kIsWeld = false;
template <>
inline constexpr bool kIsWeld<WeldBlock> = true;

template <class L, class Block>
[[gnu::always_inline]] inline void find_pin(const BodyView& b, Block& j, std::uint32_t k,
                                            Arms<L>& arms, typename L::F h) {
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
    L::store(j.angle + k, L::add(L::load(j.angle0 + k), swung<L>(b, j, k)));
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

/// Change of a row of angles by dl, N m s, alone.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void twist(TwoBodies<L>& m, const Arms<L>& j, typename L::F dl) {
  if constexpr (!kFixedA) m.ua = L::sub(m.ua, L::mul(j.ga, L::mul(j.ra, dl)));
  m.ub = L::add(m.ub, L::mul(j.gb, L::mul(j.rb, dl)));
}

/// And with what it takes along in the pin, which is added to i.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void twist_pinned(TwoBodies<L>& m, const Arms<L>& j, Vec<L> g,
                                                typename L::F dl, Vec<L>& i) {
  const auto p = times<L>(dl, g);
  i = plus<L>(i, p);
  push<L, kFixedA>(m, j, p, L::add(cross<L>(j.a, p), L::mul(j.ra, dl)),
                   L::add(cross<L>(j.b, p), L::mul(j.rb, dl)));
}

/// Where the impulse of a row with two ends goes: as near to 0 as keeps lower <= x <= upper at the
/// substep's end; an end that is passed pushes back.
template <class L>
[[gnu::always_inline]] inline typename L::F limited(const Drive& d, std::uint32_t k,
                                                    typename L::F x, typename L::F v,
                                                    typename L::F mass, typename L::F inv_h) {
  const auto zero = L::set1(0), l = L::load(d.limit_l + k);
  const auto over = L::sub(x, L::load(d.lower + k)), under = L::sub(L::load(d.upper + k), x);
  const auto low_bias = L::mul(L::max(over, zero), inv_h);
  const auto high_bias = L::mul(L::max(under, zero), inv_h);
  const auto low = L::sub(l, L::mul(mass, L::add(v, low_bias)));
  const auto high = L::sub(l, L::mul(mass, L::sub(v, high_bias)));
  return L::max(low, L::min(zero, high));
}

/// In relax: an end that pushes keeps the velocity at 0, as long as it pushes.
template <class L>
[[gnu::always_inline]] inline typename L::F limited_rigid(const Drive& d, std::uint32_t k,
                                                          typename L::F v, typename L::F mass) {
  const auto zero = L::set1(0), l = L::load(d.limit_l + k);
  const auto next = L::sub(l, L::mul(mass, v));
  const auto locked = L::less_equal(L::load(d.upper + k), L::load(d.lower + k));
  const auto pushed = L::select(L::less(zero, l), L::max(next, zero), L::min(next, zero));
  return L::select(locked, next, L::both(L::differ(l, zero), pushed));
}

template <class L>
[[gnu::always_inline]] inline typename L::F motored(const Drive& d, std::uint32_t k,
                                                    typename L::F v, typename L::F mass) {
  const auto most = L::load(d.most + k);
  const auto next = L::sub(L::load(d.motor_l + k), L::mul(mass, L::sub(v, L::load(d.speed + k))));
  return L::max(L::min(next, most), L::negate(most));
}

template <class L, bool kFixedA, class Block>
void warm_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
               std::uint32_t end) {
  const auto warm = L::set1(p.warm), zero = L::set1(0);
  auto* all = static_cast<Block*>(blocks);
  for (Block* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      find_pin<L>(b, *j, k, arms, L::set1(p.h));
      const auto i = times<L>(warm, load_vec<L>(j->px, j->py, k));
      store_vec<L>(j->px, j->py, k, i);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      push<L, kFixedA>(m, arms, i, cross<L>(arms.a, i), cross<L>(arms.b, i));
      if constexpr (kIsWeld<Block>) {
        const auto l = L::mul(warm, L::load(j->l + k));
        L::store(j->l + k, l);
        twist<L, kFixedA>(m, arms, l);
      } else if constexpr (!kPlainPin<Block>) {
        const auto limit = L::mul(warm, L::load(j->drive.limit_l + k));
        const auto motor = L::mul(warm, L::load(j->drive.motor_l + k));
        L::store(j->drive.limit_l + k, limit);
        L::store(j->drive.motor_l + k, motor);
        twist<L, kFixedA>(m, arms, L::add(limit, motor));
      }
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
      store_vec<L>(j->spin_a, j->spin_b, k, {zero, zero});
    }
  }
}

template <class L, bool kFixedA, class Block>
void solve_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                std::uint32_t end) {
  const auto h = L::set1(p.h);
  auto* all = static_cast<Block*>(blocks);
  for (Block* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      const auto arms = load_arms<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      if (!p.again) {
        turn_on<L, kFixedA>(m, arms, *j, k, {L::set1(0), L::set1(0)});
      }
      const auto v = plus<L>(anchor_velocity<L>(m, arms), anchor_pull<L>(m, arms, h));
      auto i = load_vec<L>(j->px, j->py, k);
      if constexpr (kIsWeld<Block>) {
        const auto g = load_vec<L>(j->gx, j->gy, k);
        const auto mass = L::load(j->mass + k), l = L::load(j->l + k), stiff = L::load(j->push + k);
        const auto spin = L::add(turning<L>(m, arms), dot<L>(g, v));
        const auto before = gather_motion<L>(b.vel0, b.spin0, slot);
        const auto soft = spring_impulse<L>(l, stiff, L::load(j->drag + k), mass,
                                            L::load(j->angle + k), turning<L>(before, arms), spin);
        const auto rigid = L::sub(l, L::mul(mass, spin));
        const auto next = L::select(L::less(L::set1(0), stiff), soft, rigid);
        L::store(j->l + k, next);
        twist_pinned<L, kFixedA>(m, arms, g, L::sub(next, l), i);
      } else if constexpr (!kPlainPin<Block>) {
        const auto g = load_vec<L>(j->gx, j->gy, k);
        const auto mass = L::load(j->mass + k), along = dot<L>(g, v);
        const auto motor = motored<L>(j->drive, k, L::add(turning<L>(m, arms), along), mass);
        twist_pinned<L, kFixedA>(m, arms, g, L::sub(motor, L::load(j->drive.motor_l + k)), i);
        L::store(j->drive.motor_l + k, motor);
        const auto limit = limited<L>(j->drive, k, L::load(j->angle + k),
                                      L::add(turning<L>(m, arms), along), mass, L::set1(p.inv_h));
        twist_pinned<L, kFixedA>(m, arms, g, L::sub(limit, L::load(j->drive.limit_l + k)), i);
        L::store(j->drive.limit_l + k, limit);
      }
      const auto m12 = L::load(j->m12 + k);
      const Vec<L> d{L::negate(L::add(L::mul(L::load(j->m11 + k), v.x), L::mul(m12, v.y))),
                     L::negate(L::add(L::mul(m12, v.x), L::mul(L::load(j->m22 + k), v.y)))};
      store_vec<L>(j->px, j->py, k, plus<L>(i, d));
      push<L, kFixedA>(m, arms, d, cross<L>(arms.a, d), cross<L>(arms.b, d));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

/// How far x is beyond its ends.
template <class L>
[[gnu::always_inline]] inline typename L::F beyond(const Drive& d, std::uint32_t k,
                                                   typename L::F x) {
  const auto zero = L::set1(0);
  const auto under = L::min(L::sub(x, L::load(d.lower + k)), zero);
  return L::add(under, L::max(L::sub(x, L::load(d.upper + k)), zero));
}

/// Impulse of the push pass for a row with ends.
template <class L>
[[gnu::always_inline]] inline typename L::F push_back(typename L::F c, typename L::F v,
                                                      typename L::F mass, typename L::F rate) {
  const auto wish = L::mul(mass, L::add(v, L::mul(rate, c)));
  return L::negate(L::both(L::differ(c, L::set1(0)), wish));
}

template <class L, bool kFixedA, class Block>
void push_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
               std::uint32_t end) {
  const auto rate = L::set1(p.rate);
  auto* all = static_cast<Block*>(blocks);
  for (Block* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      const auto arms = load_arms<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      const auto v =
          plus<L>(anchor_velocity<L>(m, arms), times<L>(rate, load_vec<L>(j->cx, j->cy, k)));
      if constexpr (!kPlainPin<Block>) {
        const auto g = load_vec<L>(j->gx, j->gy, k);
        const auto spin = L::add(turning<L>(m, arms), dot<L>(g, v));
        const auto angle = L::load(j->angle + k);
        Vec<L> i{};
        if constexpr (kIsWeld<Block>) {
          const auto rigid = L::less_equal(L::load(j->push + k), L::set1(0));
          const auto wish = L::mul(L::load(j->mass + k), L::add(spin, L::mul(rate, angle)));
          twist_pinned<L, kFixedA>(m, arms, g, L::both(rigid, L::negate(wish)), i);
        } else {
          const auto dl =
              push_back<L>(beyond<L>(j->drive, k, angle), spin, L::load(j->mass + k), rate);
          twist_pinned<L, kFixedA>(m, arms, g, dl, i);
        }
      }
      const auto m12 = L::load(j->m12 + k);
      const Vec<L> d{L::negate(L::add(L::mul(L::load(j->m11 + k), v.x), L::mul(m12, v.y))),
                     L::negate(L::add(L::mul(m12, v.x), L::mul(L::load(j->m22 + k), v.y)))};
      push<L, kFixedA>(m, arms, d, cross<L>(arms.a, d), cross<L>(arms.b, d));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

template <class L, bool kFixedA, class Block>
void relax_pins(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                std::uint32_t end) {
  const auto half = L::set1(0.5f), zero = L::set1(0);
  auto* all = static_cast<Block*>(blocks);
  for (Block* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      auto i = load_vec<L>(j->px, j->py, k);
      if (!p.again) {
        const auto a = arms.a, c = arms.b;
        find_pin<L>(b, *j, k, arms, L::set1(p.h));
        const auto part = times<L>(half, i);
        store_vec<L>(j->spin_a, j->spin_b, k,
                     {cross<L>(minus<L>(arms.a, a), part), cross<L>(minus<L>(arms.b, c), part)});
        turn_on<L, kFixedA>(m, arms, *j, k, {zero, zero});
      }
      const auto v = anchor_velocity<L>(m, arms);
      if constexpr (kIsWeld<Block>) {
        const auto g = load_vec<L>(j->gx, j->gy, k);
        const auto l = L::load(j->l + k);
        const auto spin = L::add(turning<L>(m, arms), dot<L>(g, v));
        const auto rigid = L::sub(l, L::mul(L::load(j->mass + k), spin));
        const auto next = L::select(L::less(zero, L::load(j->push + k)), l, rigid);
        L::store(j->l + k, next);
        twist_pinned<L, kFixedA>(m, arms, g, L::sub(next, l), i);
      } else if constexpr (!kPlainPin<Block>) {
        const auto g = load_vec<L>(j->gx, j->gy, k);
        const auto mass = L::load(j->mass + k), along = dot<L>(g, v);
        const auto motor = motored<L>(j->drive, k, L::add(turning<L>(m, arms), along), mass);
        twist_pinned<L, kFixedA>(m, arms, g, L::sub(motor, L::load(j->drive.motor_l + k)), i);
        L::store(j->drive.motor_l + k, motor);
        const auto limit = limited_rigid<L>(j->drive, k, L::add(turning<L>(m, arms), along), mass);
        twist_pinned<L, kFixedA>(m, arms, g, L::sub(limit, L::load(j->drive.limit_l + k)), i);
        L::store(j->drive.limit_l + k, limit);
      }
      const auto m12 = L::load(j->m12 + k);
      const Vec<L> d{L::negate(L::add(L::mul(L::load(j->m11 + k), v.x), L::mul(m12, v.y))),
                     L::negate(L::add(L::mul(m12, v.x), L::mul(L::load(j->m22 + k), v.y)))};
      store_vec<L>(j->px, j->py, k, plus<L>(i, d));
      push<L, kFixedA>(m, arms, d, cross<L>(arms.a, d), cross<L>(arms.b, d));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

// ---- slides ---------------------------------------------------------------------------------------

template <class L>
struct SlideRows {
  Vec<L> u, n;  // along and across
  typename L::F lean_a, lean_b, pull_a, pull_b;
  typename L::F gl, gt;
};

template <class L>
[[gnu::always_inline]] inline SlideRows<L> load_slide(const SlideBlock& j, std::uint32_t k) {
  SlideRows<L> r;
  r.u = load_vec<L>(j.ux, j.uy, k);
  r.n = {L::negate(r.u.y), r.u.x};
  r.lean_a = L::load(j.lean_a + k);
  r.lean_b = L::load(j.lean_b + k);
  r.pull_a = L::load(j.pull_a + k);
  r.pull_b = L::load(j.pull_b + k);
  r.gl = L::load(j.gl + k);
  r.gt = L::load(j.gt + k);
  return r;
}

template <class L>
[[gnu::always_inline]] inline SlideRows<L> find_slide(const BodyView& b, SlideBlock& j,
                                                      std::uint32_t k, Arms<L>& arms) {
  const auto one = L::set1(1);
  const auto moved = turn_arms<L>(b, j, k, arms);
  const auto u0 = load_vec<L>(j.ux0, j.uy0, k);
  const Vec<L> n0{L::negate(u0.y), u0.x};
  Vec<L> t;
  L::template gather<2>(b.turn, j.body + 2 * k, t.x, t.y);
  t = times<L>(arms.ra, t);  // cos d - 1, sin d
  SlideRows<L> r;
  r.u = plus<L>(u0, plus<L>(times<L>(t.x, u0), times<L>(t.y, n0)));
  r.n = {L::negate(r.u.y), r.u.x};
  // d = d0 + moved; d0 in the axes at the start is (along0, off0).
  const auto along0 = L::load(j.along0 + k), off0 = L::load(j.off0 + k);
  const auto c = L::add(one, t.x);
  const auto along = L::add(L::add(L::mul(along0, c), L::mul(off0, t.y)), dot<L>(r.u, moved));
  const auto off = L::add(L::sub(L::mul(off0, c), L::mul(along0, t.y)), dot<L>(r.n, moved));
  const auto angle = L::add(L::load(j.angle0 + k), swung<L>(b, j, k));
  // A's arm reaches to B's anchor.
  const auto reach =
      plus<L>(arms.a, times<L>(arms.ra, plus<L>(times<L>(along, r.u), times<L>(off, r.n))));
  r.lean_a = cross<L>(reach, r.n);
  r.lean_b = cross<L>(arms.b, r.n);
  r.pull_a = cross<L>(reach, r.u);
  r.pull_b = cross<L>(arms.b, r.u);
  const auto w = L::add(arms.wa, arms.wb);
  const auto fa = L::mul(arms.ga, r.lean_a), fb = L::mul(arms.gb, r.lean_b);
  const auto k11 = L::add(w, L::add(L::mul(fa, r.lean_a), L::mul(fb, r.lean_b)));
  const auto k12 = L::add(L::mul(fa, arms.ra), L::mul(fb, arms.rb));
  const auto k22 =
      L::add(L::mul(arms.ga, L::mul(arms.ra, arms.ra)), L::mul(arms.gb, L::mul(arms.rb, arms.rb)));
  // Bodies that cannot turn: the angle holds by itself.
  const auto stiff = L::less_equal(k22, L::set1(0));
  const auto inverse =
      safe_inverse<L>(L::sub(L::mul(k11, L::select(stiff, one, k22)), L::mul(k12, k12)));
  const auto m11 = L::mul(L::select(stiff, one, k22), inverse);
  const auto m12 = L::negate(L::mul(k12, inverse));
  const auto m22 = L::select(stiff, L::set1(0), L::mul(k11, inverse));
  // What 1 N s along does across and to the angle, and what undoes it.
  const auto cl = L::add(L::mul(fa, r.pull_a), L::mul(fb, r.pull_b));
  const auto ct = L::add(L::mul(L::mul(arms.ga, arms.ra), r.pull_a),
                         L::mul(L::mul(arms.gb, arms.rb), r.pull_b));
  r.gl = L::negate(L::add(L::mul(m11, cl), L::mul(m12, ct)));
  r.gt = L::negate(L::add(L::mul(m12, cl), L::mul(m22, ct)));
  const auto alone = L::add(w, L::add(L::mul(L::mul(arms.ga, r.pull_a), r.pull_a),
                                      L::mul(L::mul(arms.gb, r.pull_b), r.pull_b)));
  const auto left = L::add(alone, L::add(L::mul(r.gl, cl), L::mul(r.gt, ct)));
  L::store(j.m11 + k, m11);
  L::store(j.m12 + k, m12);
  L::store(j.m22 + k, m22);
  store_vec<L>(j.gl, j.gt, k, {r.gl, r.gt});
  L::store(j.mass + k, safe_inverse<L>(L::max(left, w)));
  store_vec<L>(j.ux, j.uy, k, r.u);
  L::store(j.along + k, along);
  L::store(j.off + k, off);
  L::store(j.angle + k, angle);
  store_vec<L>(j.lean_a, j.lean_b, k, {r.lean_a, r.lean_b});
  store_vec<L>(j.pull_a, j.pull_b, k, {r.pull_a, r.pull_b});
  return r;
}

template <class L>
[[gnu::always_inline]] inline typename L::F slide_speed(const TwoBodies<L>& m, Vec<L> n,
                                                        typename L::F sa, typename L::F sb) {
  const Vec<L> v{L::sub(m.vbx, m.vax), L::sub(m.vby, m.vay)};
  return L::add(dot<L>(n, v), L::sub(L::mul(m.ub, sb), L::mul(m.ua, sa)));
}

template <class L, bool kFixedA>
[[gnu::always_inline]] inline void push_along(TwoBodies<L>& m, const Arms<L>& arms,
                                              const SlideRows<L>& r, typename L::F dl) {
  push<L, kFixedA>(m, arms, times<L>(dl, r.u), L::mul(dl, r.pull_a), L::mul(dl, r.pull_b));
}

/// Impulses l across and t of the angle.
template <class L, bool kFixedA>
[[gnu::always_inline]] inline void push_across(TwoBodies<L>& m, const Arms<L>& arms,
                                               const SlideRows<L>& r, typename L::F l,
                                               typename L::F t) {
  push<L, kFixedA>(m, arms, times<L>(l, r.n), L::add(L::mul(l, r.lean_a), L::mul(t, arms.ra)),
                   L::add(L::mul(l, r.lean_b), L::mul(t, arms.rb)));
}

/// Along, with what that takes along in the other rows.
template <class L, bool kFixedA, bool kKeep>
[[gnu::always_inline]] inline void push_held(TwoBodies<L>& m, const Arms<L>& arms,
                                             const SlideRows<L>& r, SlideBlock& j, std::uint32_t k,
                                             typename L::F dl) {
  push_along<L, kFixedA>(m, arms, r, dl);
  const auto l = L::mul(r.gl, dl), t = L::mul(r.gt, dl);
  if constexpr (kKeep) {
    L::store(j.l + k, L::add(L::load(j.l + k), l));
    L::store(j.turn_l + k, L::add(L::load(j.turn_l + k), t));
  }
  push_across<L, kFixedA>(m, arms, r, l, t);
}

/// Speed along once the other rows are held, that miss their aim by (v, spin).
template <class L>
[[gnu::always_inline]] inline typename L::F held_speed(const TwoBodies<L>& m, const SlideRows<L>& r,
                                                       typename L::F v, typename L::F spin) {
  return L::add(slide_speed<L>(m, r.u, r.pull_a, r.pull_b),
                L::add(L::mul(r.gl, v), L::mul(r.gt, spin)));
}

template <class L, bool kFixedA>
void warm_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                 std::uint32_t end) {
  const auto warm = L::set1(p.warm), zero = L::set1(0);
  auto* all = static_cast<SlideBlock*>(blocks);
  for (SlideBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      const auto r = find_slide<L>(b, *j, k, arms);
      const auto l = L::mul(warm, L::load(j->l + k)), t = L::mul(warm, L::load(j->turn_l + k));
      const auto limit = L::mul(warm, L::load(j->drive.limit_l + k));
      const auto motor = L::mul(warm, L::load(j->drive.motor_l + k));
      L::store(j->l + k, l);
      L::store(j->turn_l + k, t);
      L::store(j->drive.limit_l + k, limit);
      L::store(j->drive.motor_l + k, motor);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      push_across<L, kFixedA>(m, arms, r, l, t);
      push_along<L, kFixedA>(m, arms, r, L::add(limit, motor));
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
      store_vec<L>(j->ex, j->ey, k, {zero, zero});
      store_vec<L>(j->spin_a, j->spin_b, k, {zero, zero});
    }
  }
}

/// Both rows of a slide that never let go, for the velocities (v, spin) to vanish.
template <class L, bool kFixedA, bool kKeep>
[[gnu::always_inline]] inline void hold_slide(TwoBodies<L>& m, const Arms<L>& arms,
                                              const SlideRows<L>& r, SlideBlock& j, std::uint32_t k,
                                              typename L::F v, typename L::F spin) {
  const auto m12 = L::load(j.m12 + k);
  const auto dl = L::negate(L::add(L::mul(L::load(j.m11 + k), v), L::mul(m12, spin)));
  const auto dt = L::negate(L::add(L::mul(m12, v), L::mul(L::load(j.m22 + k), spin)));
  if constexpr (kKeep) {
    L::store(j.l + k, L::add(L::load(j.l + k), dl));
    L::store(j.turn_l + k, L::add(L::load(j.turn_l + k), dt));
  }
  push_across<L, kFixedA>(m, arms, r, dl, dt);
}

template <class L, bool kFixedA>
void push_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                 std::uint32_t end) {
  const auto rate = L::set1(p.rate);
  auto* all = static_cast<SlideBlock*>(blocks);
  for (SlideBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      const auto arms = load_arms<L>(*j, k);
      const auto r = load_slide<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      const auto across =
          L::add(slide_speed<L>(m, r.n, r.lean_a, r.lean_b), L::mul(rate, L::load(j->off + k)));
      const auto spin = L::add(turning<L>(m, arms), L::mul(rate, L::load(j->angle + k)));
      const auto c = beyond<L>(j->drive, k, L::load(j->along + k));
      const auto dl =
          push_back<L>(c, held_speed<L>(m, r, across, spin), L::load(j->mass + k), rate);
      push_held<L, kFixedA, false>(m, arms, r, *j, k, dl);
      hold_slide<L, kFixedA, false>(m, arms, r, *j, k, across, spin);
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

template <class L, bool kFixedA>
void solve_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                  std::uint32_t end) {
  const auto h = L::set1(p.h), two = L::set1(2);
  auto* all = static_cast<SlideBlock*>(blocks);
  for (SlideBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      const auto arms = load_arms<L>(*j, k);
      const auto r = load_slide<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      if (!p.again) turn_on<L, kFixedA>(m, arms, *j, k, load_vec<L>(j->ex, j->ey, k));
      // d^2/dt^2 of n.d, where n turns with A: n.d'' - 2 w u.d' - w^2 n.d
      const auto w = L::mul(m.ua, arms.ra);
      const auto v = anchor_velocity<L>(m, arms);
      const auto off = L::load(j->off + k);
      const auto share = L::mul(h, w);
      const auto turn = L::max(L::min(share, L::set1(0.5f)), L::set1(-0.5f));
      const auto bend = L::sub(dot<L>(r.n, anchor_pull<L>(m, arms, h)),
                               L::mul(turn, L::add(L::mul(two, dot<L>(r.u, v)), L::mul(w, off))));
      const auto across = L::add(slide_speed<L>(m, r.n, r.lean_a, r.lean_b), bend);
      const auto spin = turning<L>(m, arms);
      const auto mass = L::load(j->mass + k);
      const auto motor = motored<L>(j->drive, k, held_speed<L>(m, r, across, spin), mass);
      push_held<L, kFixedA, true>(m, arms, r, *j, k, L::sub(motor, L::load(j->drive.motor_l + k)));
      L::store(j->drive.motor_l + k, motor);
      const auto limit = limited<L>(j->drive, k, L::load(j->along + k),
                                    held_speed<L>(m, r, across, spin), mass, L::set1(p.inv_h));
      push_held<L, kFixedA, true>(m, arms, r, *j, k, L::sub(limit, L::load(j->drive.limit_l + k)));
      L::store(j->drive.limit_l + k, limit);
      hold_slide<L, kFixedA, true>(m, arms, r, *j, k, across, spin);
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

template <class L, bool kFixedA>
void relax_slides(const BodyView& b, JointBlocks blocks, const JointParams& p, std::uint32_t begin,
                  std::uint32_t end) {
  const auto half = L::set1(0.5f);
  auto* all = static_cast<SlideBlock*>(blocks);
  for (SlideBlock* j = all + begin; j != all + end; ++j) {
    for (std::uint32_t k = 0; k < kBlock; k += L::width) {
      const std::uint32_t* slot = j->body + 2 * k;
      auto arms = load_arms<L>(*j, k);
      auto r = load_slide<L>(*j, k);
      auto m = gather_motion<L>(b.vel, b.spin, slot);
      if (!p.again) {
        const auto r0 = r;
        r = find_slide<L>(b, *j, k, arms);
        const auto whole = L::add(L::load(j->drive.limit_l + k), L::load(j->drive.motor_l + k));
        const auto l = L::mul(half, L::load(j->l + k)), t = L::mul(half, whole);
        const auto e = plus<L>(times<L>(l, minus<L>(r.n, r0.n)), times<L>(t, minus<L>(r.u, r0.u)));
        store_vec<L>(j->ex, j->ey, k, e);
        store_vec<L>(
            j->spin_a, j->spin_b, k,
            {L::add(L::mul(l, L::sub(r.lean_a, r0.lean_a)), L::mul(t, L::sub(r.pull_a, r0.pull_a))),
             L::add(L::mul(l, L::sub(r.lean_b, r0.lean_b)),
                    L::mul(t, L::sub(r.pull_b, r0.pull_b)))});
        turn_on<L, kFixedA>(m, arms, *j, k, e);
      }
      const auto across = slide_speed<L>(m, r.n, r.lean_a, r.lean_b), spin = turning<L>(m, arms);
      const auto mass = L::load(j->mass + k);
      const auto motor = motored<L>(j->drive, k, held_speed<L>(m, r, across, spin), mass);
      push_held<L, kFixedA, true>(m, arms, r, *j, k, L::sub(motor, L::load(j->drive.motor_l + k)));
      L::store(j->drive.motor_l + k, motor);
      const auto limit = limited_rigid<L>(j->drive, k, held_speed<L>(m, r, across, spin), mass);
      push_held<L, kFixedA, true>(m, arms, r, *j, k, L::sub(limit, L::load(j->drive.limit_l + k)));
      L::store(j->drive.limit_l + k, limit);
      hold_slide<L, kFixedA, true>(m, arms, r, *j, k, across, spin);
      scatter_motion<L, kFixedA>(b.vel, b.spin, slot, m);
    }
  }
}

// ---- what joints did in a substep -----------------------------------------------------------------

/// Before and after a pass over joints: share = v - share. Twice, with joints alone in between, that
/// adds what they did.
template <class L>
void part_joints(const BodyView& b, const JointShare& s, std::uint32_t begin, std::uint32_t end) {
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock;
       i += L::records) {
    L::store_rec(s.vel + 2 * i, L::sub(L::load_rec(b.vel + 2 * i), L::load_rec(s.vel + 2 * i)));
  }
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::width) {
    L::store(s.spin + i, L::sub(L::load(b.spin + i), L::load(s.spin + i)));
  }
}

/// Around the drift (sign 1, then -1): half of the share out of the velocities, and the push in. v - v0
/// is then what gravity and contacts did.
template <class L>
void hold_joints(const BodyView& b, const JointShare& s, float sign, std::uint32_t begin,
                 std::uint32_t end) {
  const auto half = L::set_rec(0.5f * sign, 0.5f * sign), whole = L::set_rec(sign, sign);
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock;
       i += L::records) {
    const auto d = L::mul(half, L::load_rec(s.vel + 2 * i));
    const auto e = L::mul(whole, L::load_rec(s.push + 2 * i));
    L::store_rec(b.vel + 2 * i, L::add(L::load_rec(b.vel + 2 * i), L::sub(e, d)));
    L::store_rec(b.vel0 + 2 * i, L::add(L::load_rec(b.vel0 + 2 * i), L::add(e, d)));
  }
  const auto part = L::set1(0.5f * sign), one = L::set1(sign);
  for (std::size_t i = std::size_t{begin} * kBlock; i < std::size_t{end} * kBlock; i += L::width) {
    const auto d = L::sub(L::mul(one, L::load(s.push_spin + i)), L::mul(part, L::load(s.spin + i)));
    L::store(b.spin + i, L::add(L::load(b.spin + i), d));
  }
}

}  // namespace
}  // namespace psim::kernels
