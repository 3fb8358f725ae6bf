// Smooth forces: gravity, wells and drag, in double precision, and what the integrators make of
// them over a substep of h seconds. One lane a body, 1, 2 or 4 to a register.
//
//   a(x, v) = pull (g + sum of k d / (d^2 + e^2)^((n+1)/2)) - (c + q |v|) v,  d from x to the well
//
// accelerate   the mean acceleration of leapfrog (drift-kick-drift), for the kick of stream_kernel.h
// advance      another method's whole kick: (x, v) -> (x + way, v + dv) as if no contact acted
// drift_corrected   x += way, or what contacts made of it
//
// Velocities and offsets are float records, each with a record of what rounding took from it, so
// a body's state has about 48 bits. Cost by body, well and evaluation: a square root and a division.
#pragma once

#include "lane_vec.h"
#include "stream_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

template <class L>
PSIM_INLINE inline VecD<L> load_pair(const float* records) {
  VecD<L> a;
  L::load_rec_d(records, a.x, a.y);
  return a;
}
template <class L>
PSIM_INLINE inline void store_pair(float* records, VecD<L> a) {
  L::store_rec_d(records, a.x, a.y);
}
/// The nearest floats.
template <class L>
PSIM_INLINE inline VecD<L> rounded(VecD<L> a) {
  return {round_to_float(a.x), round_to_float(a.y)};
}

/// Zero for |a| <= kLeast, in x and in y; a NaN stays one.
template <class L>
PSIM_INLINE inline VecD<L> snapped(VecD<L> a) {
  const D<L> zero = 0, least = double{kLeast}, under = -double{kLeast};
  return {select(but_not(a.x <= least, a.x < under), zero, a.x), select(but_not(a.y <= least, a.y < under), zero, a.y)};
}

/// s^((n+1)/2): whole powers by squaring, the fraction's bits by square roots.
template <class L>
PSIM_INLINE inline D<L> power(D<L> s, const WellTerms& w) {
  D<L> result = 1, square = s, root = s;
  for (std::uint32_t n = w.whole; n != 0; n >>= 1) {
    if ((n & 1u) != 0) result = result * square;
    square = square * square;
  }
  for (std::uint32_t f = w.fraction; f != 0; f <<= 1) {
    root = sqrt(root);
    if ((f >> 31) != 0) result = result * root;
  }
  return result;
}

/// The way to the nearest copy of a well. Adding and taking away 1.5 x 2^52 rounds to a whole number.
template <class L>
PSIM_INLINE inline D<L> to_nearest(D<L> way, double period) {
  const D<L> whole = 0x1.8p52;
  return way - period * ((way * (1 / period) + whole) - whole);
}

/// Gravity and wells at a place.
template <class L>
PSIM_INLINE inline VecD<L> pull_at(const FieldParams& p, D<L> pull, VecD<L> at) {
  const D<L> zero = 0, one = 1;
  VecD<L> a = {p.gravity_x * pull, p.gravity_y * pull};
  for (std::uint32_t n = 0; n < p.well_count; ++n) {
    const WellTerms& w = p.wells[n];
    VecD<L> d = VecD<L>{w.x, w.y} - at;
    if (p.period_x > 0) d = {to_nearest<L>(d.x, p.period_x), to_nearest<L>(d.y, p.period_y)};
    const auto d2 = norm2(d);
    const auto s = d2 + w.softening2;
    const auto acts = but_not(zero < s, w.range2 < d2);
    const D<L> f = w.strength * pull / power<L>(select(acts, s, one), w);
    a = select(acts, a + f * d, a);
  }
  return a;
}

/// Bodies of a register, as `advance` finds and leaves them.
template <class L>
struct Flight {
  D<L> pull;  // gravity scale
  VecD<L> x, v;
};
template <class L>
struct Change {
  VecD<L> way, dv;
};

template <class L>
PSIM_INLINE inline D<L> pull_of(const BodyView& b, std::size_t body) {
  return b.pull ? L::load_d(b.pull + body) : 1;
}

template <class L>
PSIM_INLINE inline VecD<L> place_of(const BodyView& b, const FieldParams& p, std::size_t body) {
  VecD<L> x;
  L::load_rec_int_d(b.pos + 2 * body, x.x, x.y);
  x = {x.x * p.pitch_x, x.y * p.pitch_y};
  return x + load_pair<L>(b.disp + 2 * body);
}

/// acc = mean acceleration over the substep: wells at x + v h/2; quadratic drag split off as Strang
/// does, half a kick, drag, half a kick, its part exact,
///   dv/dt = -q |v| v:  v(h) = v(0) / (1 + q |v(0)| h),
/// and so stable however strong it is. Linear drag is the kick's; here it has acted for half of h.
template <class L, bool kDrag>
void accelerate(const BodyView& b, const FieldParams& p, std::uint32_t begin, std::uint32_t end) {
  const D<L> half = p.h / 2, h = p.h, one = 1;
  const D<L> zero = 0;
  for (std::uint32_t block = begin; block < end; ++block) {
    for (std::uint32_t r = 0; r < kBlock; r += L::doubles) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_d(b.linked + body);
      const VecD<L> v = load_pair<L>(b.vel + 2 * body);
      const VecD<L> mid = place_of<L>(b, p, body) + half * v;
      VecD<L> a = pull_at<L>(p, pull_of<L>(b, body), mid);
      if constexpr (kDrag) {
        const VecD<L> u = p.half_fade * v + half * a;
        const D<L> rate = p.quadratic * norm(u);
        const auto lost = rate / (one + rate * h);  // (u(0) - u(h)) / (h u(0))
        a = a - lost * u;
      }
      store_pair<L>(b.acc + 2 * body, select(mine, snapped<L>(a), {zero, zero}));
    }
  }
}

/// c + q |v|, 1/s.
template <class L>
PSIM_INLINE inline D<L> drag_rate(const FieldParams& p, VecD<L> v) {
  return p.linear + p.quadratic * norm(v);
}

/// f - (c + q |v|) v.
template <class L, bool kDrag>
PSIM_INLINE inline VecD<L> with_drag(const FieldParams& p, VecD<L> f, VecD<L> v) {
  if constexpr (!kDrag) return f;
  return f - drag_rate<L>(p, v) * v;
}

/// Semi-implicit Euler, order 1, implicit in the drag: v' = (v + h f(x)) / (1 + h (c + q |v|)),
/// x' = x + h v'. Stable however strong the drag is.
template <class L, bool kDrag>
PSIM_INLINE inline Change<L> euler(const FieldParams& p, const Flight<L>& s) {
  VecD<L> v = s.v + p.h * pull_at<L>(p, s.pull, s.x);
  if constexpr (kDrag) {
    const D<L> one = 1;
    const auto slower = one + p.h * drag_rate<L>(p, s.v);
    v = {v.x / slower, v.y / slower};
  }
  return {p.h * v, v - s.v};
}

/// The classical Runge-Kutta method (Kutta 1901), order 4, four evaluations.
template <class L, bool kDrag>
PSIM_INLINE inline Change<L> rk4(const FieldParams& p, const Flight<L>& s) {
  const D<L> half = p.h / 2, h = p.h, two = 2;
  const D<L> sixth = p.h / 6;
  const auto a = [&](VecD<L> x, VecD<L> v) { return with_drag<L, kDrag>(p, pull_at<L>(p, s.pull, x), v); };
  const VecD<L> a1 = a(s.x, s.v), v2 = s.v + half * a1;
  const VecD<L> a2 = a(s.x + half * s.v, v2), v3 = s.v + half * a2;
  const VecD<L> a3 = a(s.x + half * v2, v3), v4 = s.v + h * a3;
  const VecD<L> a4 = a(s.x + h * v3, v4);
  return {sixth * (s.v + v4 + two * (v2 + v3)), sixth * (a1 + a4 + two * (a2 + a3))};
}

/// A kick of t seconds at one place: dv/dt = f - (c + q |v|) v, the drag by a Runge-Kutta step in v.
template <class L, bool kDrag>
PSIM_INLINE inline VecD<L> kicked(const FieldParams& p, double t, VecD<L> f, VecD<L> v) {
  if constexpr (!kDrag) return v + t * f;
  const D<L> half = t / 2, whole = t, two = 2;
  const auto a = [&](VecD<L> at) { return with_drag<L, true>(p, f, at); };
  const VecD<L> a1 = a(v), a2 = a(v + half * a1);
  const VecD<L> a3 = a(v + half * a2), a4 = a(v + whole * a3);
  const VecD<L> sum = a1 + a4 + two * (a2 + a3);
  return v + t / 6 * sum;
}

/// Optimised Forest-Ruth (Omelyan, Mryglod, Folk 2002, "PEFRL"), order 4, four evaluations:
/// drifts and kicks in turn, symmetric in time; symplectic where there is no drag.
template <class L, bool kDrag>
PSIM_INLINE inline Change<L> symplectic4(const FieldParams& p, const Flight<L>& s) {
  constexpr double kXi = 0.1786178958448091, kLambda = -0.2123418310626054, kChi = -0.06626458266981849;
  const double outer = (1 - 2 * kLambda) / 2 * p.h, inner = kLambda * p.h;
  VecD<L> v = s.v, way = kXi * p.h * v;
  const auto kick = [&](double t)
                        PSIM_INLINE_LAMBDA { v = kicked<L, kDrag>(p, t, pull_at<L>(p, s.pull, s.x + way), v); };
  const auto drift = [&](double share) { way = way + share * p.h * v; };
  kick(outer);
  drift(kChi);
  kick(inner);
  drift(1 - 2 * (kChi + kXi));
  kick(inner);
  drift(kChi);
  kick(outer);
  drift(kXi);
  return {way, v - s.v};
}

/// Leapfrog with all drag exact, v(h) = v(0) E / (1 + q |v(0)| S), E = e^(-c h), S = (1 - E)/c:
/// what a body takes whose drag is too strong for a method. `calm`: it is not,
/// (c + q (|v| + h |f|)) h <= 1/2.
template <class L>
PSIM_INLINE inline Change<L> leap(const FieldParams& p, const Flight<L>& s, typename L::MD& calm) {
  const D<L> half = p.h / 2, one = 1, q = p.quadratic;
  const VecD<L> out = half * s.v;
  const VecD<L> f = pull_at<L>(p, s.pull, s.x + out);
  const auto fast = norm(s.v) + p.h * norm(f);
  const D<L> rate = p.linear + q * fast;
  calm = rate * p.h < 0.5;
  const VecD<L> u = s.v + half * f;
  const D<L> left = p.fade / (one + q * norm(u) * p.fade_span);
  const VecD<L> v = left * u + half * f;
  return {out + half * v, v - s.v};
}

template <class L, Method kMethod, bool kDrag>
PSIM_INLINE inline Change<L> change_of(const FieldParams& p, const Flight<L>& s) {
  if constexpr (kMethod == Method::euler) return euler<L, kDrag>(p, s);
  const Change<L> c = kMethod == Method::rk4 ? rk4<L, kDrag>(p, s) : symplectic4<L, kDrag>(p, s);
  if constexpr (!kDrag) return c;
  typename L::MD calm;
  const Change<L> slow = leap<L>(p, s, calm);
  return {select(calm, c.way, slow.way), select(calm, c.dv, slow.dv)};
}

/// The kick of a method, and how its way differs from the mean of old and new velocity:
///   v0 = v,  v = v0 + dv,  acc = dv / h,  correction = way - h (v0 + v)/2.
template <class L, Method kMethod, bool kDrag>
void advance(const BodyView& b, const FieldParams& p, std::uint32_t begin, std::uint32_t end) {
  const D<L> zero = 0, half = p.h / 2, per_h = 1 / p.h;
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::doubles) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_d(b.linked + body);
      const VecD<L> v0 = load_pair<L>(b.vel + 2 * body);
      const VecD<L> rest = load_pair<L>(b.vel_remainder + 2 * body);
      Flight<L> s;
      s.pull = pull_of<L>(b, body);
      s.x = place_of<L>(b, p, body) + load_pair<L>(b.disp_remainder + 2 * body);
      s.v = v0 + rest;
      const Change<L> c = change_of<L, kMethod, kDrag>(p, s);
      const VecD<L> exact = s.v + c.dv, v = rounded<L>(exact);
      const VecD<L> correction = c.way - half * (v0 + v);
      const VecD<L> none = {zero, zero};
      store_pair<L>(b.vel0 + 2 * body, v0);
      store_pair<L>(b.vel + 2 * body, select(mine, v, v0));
      store_pair<L>(b.vel_remainder + 2 * body, select(mine, exact - v, rest));
      store_pair<L>(b.acc + 2 * body, select(mine, snapped<L>(per_h * (v - v0)), none));
      store_pair<L>(b.drift_correction + 2 * body, select(mine, correction, none));
    }
  }
}

/// x += h (v0 + v)/2 + correction where what contacts added is smooth, |v - v0|^2 <= smooth |acc|^2: the
/// method's way, and resting impulses act over the whole substep; else x += h v. Euler: always h v.
template <class L>
void drift_corrected(const BodyView& b, const FieldParams& p, std::uint32_t begin, std::uint32_t end) {
  const D<L> h = p.h, half = p.h / 2, limit = p.smooth;
  for (std::uint32_t block = begin; block < end; ++block) {
    if (!any_linked<L>(b.linked, block)) continue;
    for (std::uint32_t r = 0; r < kBlock; r += L::doubles) {
      const std::size_t body = static_cast<std::size_t>(block) * kBlock + r;
      const auto mine = L::mask_d(b.linked + body);
      const VecD<L> v = load_pair<L>(b.vel + 2 * body), v0 = load_pair<L>(b.vel0 + 2 * body);
      const VecD<L> correction = load_pair<L>(b.drift_correction + 2 * body);
      const auto bound = limit * norm2(load_pair<L>(b.acc + 2 * body));
      const auto smooth = norm2(v - v0) <= bound;
      const VecD<L> way = select(smooth, half * (v0 + v) + correction, h * v);
      const VecD<L> d = load_pair<L>(b.disp + 2 * body), rest = load_pair<L>(b.disp_remainder + 2 * body);
      const VecD<L> exact = d + rest + way, to = rounded<L>(exact);
      store_pair<L>(b.disp + 2 * body, select(mine, to, d));
      store_pair<L>(b.disp_remainder + 2 * body, select(mine, exact - to, rest));
    }
  }
}

}  // namespace
}  // namespace psim::kernels
