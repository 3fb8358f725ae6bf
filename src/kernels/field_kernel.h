// Smooth forces: gravity, wells and drag, in double precision, and what the integrators make of
// them over a substep of h seconds. One lane a body, 1, 2 or 4 to a register.
//
//   a(x, v) = pull (g + sum of k d / (d^2 + e^2)^((n+1)/2)) - (c + q |v|) v,  d from x to the well
//
// accelerate   the mean acceleration of leapfrog (drift-kick-drift), for the kick of stream_kernel.h
// advance      another method's whole kick: (x, v) -> (x + way, v + dv) as if no contact acted
// drift_bent   x += way, or what contacts made of it
//
// Velocities and offsets are float records, each with a record of what rounding took from it, so
// a body's state has about 48 bits. Cost by body, well and evaluation: a square root and a division.
#pragma once

#include "stream_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

/// {x, y} of as many bodies as a register of doubles holds.
template <class L>
struct Pair {
  typename L::D x, y;
};

template <class L>
[[gnu::always_inline]] inline Pair<L> add(Pair<L> a, Pair<L> b) {
  return {L::add(a.x, b.x), L::add(a.y, b.y)};
}
template <class L>
[[gnu::always_inline]] inline Pair<L> sub(Pair<L> a, Pair<L> b) {
  return {L::sub(a.x, b.x), L::sub(a.y, b.y)};
}
template <class L>
[[gnu::always_inline]] inline Pair<L> scale(typename L::D s, Pair<L> a) {
  return {L::mul(s, a.x), L::mul(s, a.y)};
}
template <class L>
[[gnu::always_inline]] inline Pair<L> scale(double s, Pair<L> a) {
  return scale<L>(L::set1_d(s), a);
}
template <class L>
[[gnu::always_inline]] inline Pair<L> select(typename L::D mask, Pair<L> yes, Pair<L> no) {
  return {L::select(mask, yes.x, no.x), L::select(mask, yes.y, no.y)};
}
template <class L>
[[gnu::always_inline]] inline typename L::D norm2(Pair<L> a) {
  return L::add(L::mul(a.x, a.x), L::mul(a.y, a.y));
}
template <class L>
[[gnu::always_inline]] inline typename L::D norm(Pair<L> a) {
  return L::sqrt(norm2<L>(a));
}
template <class L>
[[gnu::always_inline]] inline Pair<L> load_pair(const float* records) {
  Pair<L> a;
  L::load_rec_d(records, a.x, a.y);
  return a;
}
template <class L>
[[gnu::always_inline]] inline void store_pair(float* records, Pair<L> a) {
  L::store_rec_d(records, a.x, a.y);
}
/// The nearest floats.
template <class L>
[[gnu::always_inline]] inline Pair<L> rounded(Pair<L> a) {
  return {L::round_to_float(a.x), L::round_to_float(a.y)};
}

/// s^((n+1)/2): whole powers by squaring, the fraction's bits by square roots.
template <class L>
[[gnu::always_inline]] inline typename L::D power(typename L::D s, const WellTerms& w) {
  auto result = L::set1_d(1), square = s, root = s;
  for (std::uint32_t n = w.whole; n != 0; n >>= 1) {
    if ((n & 1u) != 0) result = L::mul(result, square);
    square = L::mul(square, square);
  }
  for (std::uint32_t f = w.fraction; f != 0; f <<= 1) {
    root = L::sqrt(root);
    if ((f >> 31) != 0) result = L::mul(result, root);
  }
  return result;
}

/// Gravity and wells at a place.
template <class L>
[[gnu::always_inline]] inline Pair<L> pull_at(const FieldParams& p, typename L::D pull,
                                              Pair<L> at) {
  const auto zero = L::set1_d(0), one = L::set1_d(1);
  Pair<L> a = {L::mul(L::set1_d(p.gravity_x), pull), L::mul(L::set1_d(p.gravity_y), pull)};
  for (std::uint32_t n = 0; n < p.well_count; ++n) {
    const WellTerms& w = p.wells[n];
    const Pair<L> d = sub<L>({L::set1_d(w.x), L::set1_d(w.y)}, at);
    const auto d2 = norm2<L>(d);
    const auto s = L::add(d2, L::set1_d(w.softening2));
    const auto acts = L::but_not(L::less(zero, s), L::less(L::set1_d(w.range2), d2));
    const auto f =
        L::div(L::mul(L::set1_d(w.strength), pull), power<L>(L::select(acts, s, one), w));
    a = select<L>(acts, add<L>(a, scale<L>(f, d)), a);
  }
  return a;
}

/// Bodies of a register, as `advance` finds and leaves them.
template <class L>
struct Flight {
  typename L::D pull;  // gravity scale
  Pair<L> x, v;
};
template <class L>
struct Change {
  Pair<L> way, dv;
};

template <class L>
[[gnu::always_inline]] inline typename L::D pull_of(const BodyView& b, std::size_t body) {
  return b.pull ? L::load_d(b.pull + body) : L::set1_d(1);
}

template <class L>
[[gnu::always_inline]] inline Pair<L> place_of(const BodyView& b, const FieldParams& p,
                                               std::size_t body) {
  Pair<L> x;
  L::load_rec_int_d(b.pos + 2 * body, x.x, x.y);
  x = {L::mul(x.x, L::set1_d(p.pitch_x)), L::mul(x.y, L::set1_d(p.pitch_y))};
  return add<L>(x, load_pair<L>(b.disp + 2 * body));
}

/// acc = mean acceleration over the substep: wells at x + v h/2; quadratic drag split off as Strang
/// does, half a kick, drag, half a kick, its part exact,
///   dv/dt = -q |v| v:  v(h) = v(0) / (1 + q |v(0)| h),
/// and so stable however strong it is. Linear drag is the kick's; here it has acted for half of h.
template <class L, bool kDrag>
void accelerate(const BodyView& b, const FieldParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto half = L::set1_d(p.h / 2), h = L::set1_d(p.h), one = L::set1_d(1);
  const auto zero = L::set1_d(0);
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::doubles) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_d(b.linked + body);
      const Pair<L> v = load_pair<L>(b.vel + 2 * body);
      const Pair<L> mid = add<L>(place_of<L>(b, p, body), scale<L>(half, v));
      Pair<L> a = pull_at<L>(p, pull_of<L>(b, body), mid);
      if constexpr (kDrag) {
        const Pair<L> u = add<L>(scale<L>(p.half_fade, v), scale<L>(half, a));
        const auto rate = L::mul(L::set1_d(p.quadratic), norm<L>(u));
        const auto lost = L::div(rate, L::add(one, L::mul(rate, h)));  // (u(0) - u(h)) / (h u(0))
        a = sub<L>(a, scale<L>(lost, u));
      }
      store_pair<L>(b.acc + 2 * body, select<L>(mine, a, {zero, zero}));
    }
  }
}

/// c + q |v|, 1/s.
template <class L>
[[gnu::always_inline]] inline typename L::D drag_rate(const FieldParams& p, Pair<L> v) {
  return L::add(L::set1_d(p.linear), L::mul(L::set1_d(p.quadratic), norm<L>(v)));
}

/// f - (c + q |v|) v.
template <class L, bool kDrag>
[[gnu::always_inline]] inline Pair<L> with_drag(const FieldParams& p, Pair<L> f, Pair<L> v) {
  if constexpr (!kDrag) return f;
  return sub<L>(f, scale<L>(drag_rate<L>(p, v), v));
}

/// Semi-implicit Euler, order 1, implicit in the drag: v' = (v + h f(x)) / (1 + h (c + q |v|)),
/// x' = x + h v'. Stable however strong the drag is.
template <class L, bool kDrag>
[[gnu::always_inline]] inline Change<L> euler(const FieldParams& p, const Flight<L>& s) {
  Pair<L> v = add<L>(s.v, scale<L>(p.h, pull_at<L>(p, s.pull, s.x)));
  if constexpr (kDrag) {
    const auto one = L::set1_d(1);
    const auto slower = L::add(one, L::mul(L::set1_d(p.h), drag_rate<L>(p, s.v)));
    v = {L::div(v.x, slower), L::div(v.y, slower)};
  }
  return {scale<L>(p.h, v), sub<L>(v, s.v)};
}

/// The classical Runge-Kutta method (Kutta 1901), order 4, four evaluations.
template <class L, bool kDrag>
[[gnu::always_inline]] inline Change<L> rk4(const FieldParams& p, const Flight<L>& s) {
  const auto half = L::set1_d(p.h / 2), h = L::set1_d(p.h), two = L::set1_d(2);
  const auto sixth = L::set1_d(p.h / 6);
  const auto a = [&](Pair<L> x, Pair<L> v) {
    return with_drag<L, kDrag>(p, pull_at<L>(p, s.pull, x), v);
  };
  const Pair<L> a1 = a(s.x, s.v), v2 = add<L>(s.v, scale<L>(half, a1));
  const Pair<L> a2 = a(add<L>(s.x, scale<L>(half, s.v)), v2), v3 = add<L>(s.v, scale<L>(half, a2));
  const Pair<L> a3 = a(add<L>(s.x, scale<L>(half, v2)), v3), v4 = add<L>(s.v, scale<L>(h, a3));
  const Pair<L> a4 = a(add<L>(s.x, scale<L>(h, v3)), v4);
  return {scale<L>(sixth, add<L>(add<L>(s.v, v4), scale<L>(two, add<L>(v2, v3)))),
          scale<L>(sixth, add<L>(add<L>(a1, a4), scale<L>(two, add<L>(a2, a3))))};
}

/// A kick of t seconds at one place: dv/dt = f - (c + q |v|) v, the drag by a Runge-Kutta step in v.
template <class L, bool kDrag>
[[gnu::always_inline]] inline Pair<L> kicked(const FieldParams& p, double t, Pair<L> f, Pair<L> v) {
  if constexpr (!kDrag) return add<L>(v, scale<L>(t, f));
  const auto half = L::set1_d(t / 2), whole = L::set1_d(t), two = L::set1_d(2);
  const auto a = [&](Pair<L> at) { return with_drag<L, true>(p, f, at); };
  const Pair<L> a1 = a(v), a2 = a(add<L>(v, scale<L>(half, a1)));
  const Pair<L> a3 = a(add<L>(v, scale<L>(half, a2))), a4 = a(add<L>(v, scale<L>(whole, a3)));
  const Pair<L> sum = add<L>(add<L>(a1, a4), scale<L>(two, add<L>(a2, a3)));
  return add<L>(v, scale<L>(t / 6, sum));
}

/// Optimised Forest-Ruth (Omelyan, Mryglod, Folk 2002, "PEFRL"), order 4, four evaluations:
/// drifts and kicks in turn, symmetric in time; symplectic where there is no drag.
template <class L, bool kDrag>
[[gnu::always_inline]] inline Change<L> symplectic4(const FieldParams& p, const Flight<L>& s) {
  constexpr double kXi = 0.1786178958448091, kLambda = -0.2123418310626054,
                   kChi = -0.06626458266981849;
  const double outer = (1 - 2 * kLambda) / 2 * p.h, inner = kLambda * p.h;
  Pair<L> v = s.v, way = scale<L>(kXi * p.h, v);
  const auto kick = [&](double t) {
    v = kicked<L, kDrag>(p, t, pull_at<L>(p, s.pull, add<L>(s.x, way)), v);
  };
  const auto drift = [&](double share) { way = add<L>(way, scale<L>(share * p.h, v)); };
  kick(outer);
  drift(kChi);
  kick(inner);
  drift(1 - 2 * (kChi + kXi));
  kick(inner);
  drift(kChi);
  kick(outer);
  drift(kXi);
  return {way, sub<L>(v, s.v)};
}

/// Leapfrog with all drag exact, v(h) = v(0) E / (1 + q |v(0)| S), E = e^(-c h), S = (1 - E)/c:
/// what a body takes whose drag is too strong for a method. `calm`: it is not,
/// (c + q (|v| + h |f|)) h <= 1/2.
template <class L>
[[gnu::always_inline]] inline Change<L> leap(const FieldParams& p, const Flight<L>& s,
                                             typename L::D& calm) {
  const auto half = L::set1_d(p.h / 2), one = L::set1_d(1), q = L::set1_d(p.quadratic);
  const Pair<L> out = scale<L>(half, s.v);
  const Pair<L> f = pull_at<L>(p, s.pull, add<L>(s.x, out));
  const auto fast = L::add(norm<L>(s.v), L::mul(L::set1_d(p.h), norm<L>(f)));
  const auto rate = L::add(L::set1_d(p.linear), L::mul(q, fast));
  calm = L::less(L::mul(rate, L::set1_d(p.h)), L::set1_d(0.5));
  const Pair<L> u = add<L>(s.v, scale<L>(half, f));
  const auto left =
      L::div(L::set1_d(p.fade), L::add(one, L::mul(L::mul(q, norm<L>(u)), L::set1_d(p.fade_span))));
  const Pair<L> v = add<L>(scale<L>(left, u), scale<L>(half, f));
  return {add<L>(out, scale<L>(half, v)), sub<L>(v, s.v)};
}

template <class L, Method kMethod, bool kDrag>
[[gnu::always_inline]] inline Change<L> change_of(const FieldParams& p, const Flight<L>& s) {
  if constexpr (kMethod == Method::euler) return euler<L, kDrag>(p, s);
  const Change<L> c = kMethod == Method::rk4 ? rk4<L, kDrag>(p, s) : symplectic4<L, kDrag>(p, s);
  if constexpr (!kDrag) return c;
  typename L::D calm;
  const Change<L> slow = leap<L>(p, s, calm);
  return {select<L>(calm, c.way, slow.way), select<L>(calm, c.dv, slow.dv)};
}

/// The kick of a method, and how its way differs from the mean of old and new velocity:
///   v0 = v,  v = v0 + dv,  acc = dv / h,  bend = way - h (v0 + v)/2.
template <class L, Method kMethod, bool kDrag>
void advance(const BodyView& b, const FieldParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1_d(0), half = L::set1_d(p.h / 2), per_h = L::set1_d(1 / p.h);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::doubles) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_d(b.linked + body);
      const Pair<L> v0 = load_pair<L>(b.vel + 2 * body);
      const Pair<L> rest = load_pair<L>(b.vel_rest + 2 * body);
      Flight<L> s;
      s.pull = pull_of<L>(b, body);
      s.x = add<L>(place_of<L>(b, p, body), load_pair<L>(b.disp_rest + 2 * body));
      s.v = add<L>(v0, rest);
      const Change<L> c = change_of<L, kMethod, kDrag>(p, s);
      const Pair<L> exact = add<L>(s.v, c.dv), v = rounded<L>(exact);
      const Pair<L> bend = sub<L>(c.way, scale<L>(half, add<L>(v0, v)));
      const Pair<L> none = {zero, zero};
      store_pair<L>(b.vel0 + 2 * body, v0);
      store_pair<L>(b.vel + 2 * body, select<L>(mine, v, v0));
      store_pair<L>(b.vel_rest + 2 * body, select<L>(mine, sub<L>(exact, v), rest));
      store_pair<L>(b.acc + 2 * body, select<L>(mine, scale<L>(per_h, sub<L>(v, v0)), none));
      store_pair<L>(b.bend + 2 * body, select<L>(mine, bend, none));
    }
  }
}

/// x += h (v0 + v)/2 + bend where what contacts added is smooth, |v - v0|^2 <= smooth |acc|^2: the
/// method's way, and resting impulses act over the whole substep; else x += h v. Euler: always h v.
template <class L>
void drift_bent(const BodyView& b, const FieldParams& p, std::uint32_t begin, std::uint32_t end) {
  const auto h = L::set1_d(p.h), half = L::set1_d(p.h / 2), limit = L::set1_d(p.smooth);
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::doubles) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_d(b.linked + body);
      const Pair<L> v = load_pair<L>(b.vel + 2 * body), v0 = load_pair<L>(b.vel0 + 2 * body);
      const Pair<L> bend = load_pair<L>(b.bend + 2 * body);
      const auto bound = L::mul(limit, norm2<L>(load_pair<L>(b.acc + 2 * body)));
      const auto smooth = L::less_equal(norm2<L>(sub<L>(v, v0)), bound);
      const Pair<L> way =
          select<L>(smooth, add<L>(scale<L>(half, add<L>(v0, v)), bend), scale<L>(h, v));
      const Pair<L> d = load_pair<L>(b.disp + 2 * body),
                    rest = load_pair<L>(b.disp_rest + 2 * body);
      const Pair<L> exact = add<L>(add<L>(d, rest), way), to = rounded<L>(exact);
      store_pair<L>(b.disp + 2 * body, select<L>(mine, to, d));
      store_pair<L>(b.disp_rest + 2 * body, select<L>(mine, sub<L>(exact, to), rest));
    }
  }
}

}  // namespace
}  // namespace psim::kernels
