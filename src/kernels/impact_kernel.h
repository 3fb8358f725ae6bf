// Time-of-impact sweeps: contacts with restitution whose bodies rest on nothing collide at their
// exact time within the substep, with the exact normal and velocities of that moment.
//
// Every body has a virtual start of the substep (x, v) from which it moves freely, and the time of
// its last event tl. For a pair, d = xB - xA, u = vB - vA (common gravity cancels), R = rA + rB,
// from t0 = max(tlA, tlB):
//   dd = d + t0 u,  q = dd.u (parting if q >= 0),  c = dd.dd - R^2,
//   t = t0 + c / (-q + sqrt(q^2 - u.u c))        (t0 if c <= 0)
// If t < h: n at t, J = -(1 + e) n.u m, v +- w J n, x -+ t w J n (so that x + v h is right), tl = t.
// Friction: Jt = clamp(-mt vt, +- mu J) with rim speeds u = omega r, -q Jt each. Rims turned as before until then: their
// ways in the substep are h u + t q Jt, of which the last term is kept in rim_way.
// A pair apart with no hit ahead is settled too: no speculative impulse. A pair that overlaps by more than p.refresh is
// left to the solver, which pushes it apart, unless it is fully elastic: an impulse would leave the overlap as it is, and
// among bodies that fall together it would stay and grow. Impacts slower than the
// floor are left to the solver (impact mark stays clear), and so are, in the last sweep (least_e = 1), impacts
// that are not fully elastic. Impacts from p.due on are left to a later sweep: a body that has several
// takes them nearly in their order. Returns true if any lane collided or has yet to; `virial` receives
// J |d| of every collision.
#pragma once

#include "lane_vec.h"
#include "views.h"

namespace psim::kernels {
namespace {

/// m/s: what is slower along an axis does not meet; the products of the root below are no denormals then.
constexpr float kSlow = 1e-12f;

/// -(1 + e) vn m / |n|^2. A float normal is not quite of length 1, for R = 1 m on average 2e-8 too
/// long, and an elastic impact along it would gain as much energy each time.
template <class L>
PSIM_INLINE inline F<L> impulse_along(F<L> nx, F<L> ny, F<L> e, F<L> vn, F<L> m) {
  const F<L> half = 0.5f;
  const auto excess = nx * nx - half + (ny * ny - half);
  const auto j = (1 + e) * vn * m;
  return j * excess - j;
}

template <class L, Model kModel, Sweep kSweep>
bool sweep_contacts(const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t begin,
                    std::uint32_t end, double* virial) {
  const F<L> zero = 0, one = 1, half = 0.5f;
  const F<L> h = p.h, set = -0.0f;
  const F<L> floor = p.bounce_floor, due = p.due, least_e = p.least_e;
  const F<L> deepest = -2 * p.refresh;  // R (|d| - R) is close to (d.d - R^2) / 2
  bool busy = false;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const auto e = L::load(c.e + k);
    // `impact` holds +1: not for sweeps; +0: pending; -0: settled.
    auto mark = L::load(c.impact + k);
    const auto eligible = mark <= zero;
    if constexpr (kSweep == Sweep::first) mark = select(eligible, zero, mark);
    if (!any(eligible)) continue;
    const std::uint32_t* slot = c.body + 2 * k;
    const auto ta = L::template gather1<2>(b.event_time, slot);
    const auto tb = L::template gather1<2>(b.event_time, slot + 1);
    if constexpr (kSweep != Sweep::first) {  // is an impact left to this sweep, or had a body an event since?
      auto asked = zero < max(ta, tb);
      if constexpr (kSweep == Sweep::sliced) asked = asked | select(negative(mark), L::none(), eligible);
      if (!any(asked)) continue;
    }
    I<L> iax, iay, ibx, iby;
    L::template gather_int<2>(b.pos, slot, iax, iay);
    L::template gather_int<2>(b.pos, slot + 1, ibx, iby);
    F<L> dax, day, dbx, dby, vax, vay, vbx, vby;
    L::template gather<2>(b.disp, slot, dax, day);
    L::template gather<2>(b.disp, slot + 1, dbx, dby);
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    const auto dx = to_float(ibx - iax) * p.pitch_x + (dbx - dax);
    const auto dy = to_float(iby - iay) * p.pitch_y + (dby - day);
    const auto ux = snapped<L>(vbx - vax, kSlow), uy = snapped<L>(vby - vay, kSlow);
    const auto t0 = max(ta, tb);
    const auto x0 = dx + t0 * ux, y0 = dy + t0 * uy;
    const auto q = x0 * ux + y0 * uy;
    const auto radius = L::load(c.rsum + k);
    const auto gap2 = x0 * x0 + y0 * y0 - radius * radius;
    const auto uu = ux * ux + uy * uy;
    const auto size = squarable<L>(q), root2 = size * size - uu * gap2;
    const auto closing = eligible & ((q < zero) & (zero <= root2));
    const auto root = sqrt(max(root2, zero));
    const auto speed = select(closing, root - q, one);
    const auto t = t0 + max(gap2 / speed, zero);
    const auto deep = (gap2 < deepest * radius) & (e < one);
    const auto soon = but_not(closing & (t < h), deep);
    // Apart with no hit ahead, or parting after an earlier hit: settled without an impulse. Pairs
    // that overlap otherwise are the solver's.
    const auto clear = select(negative(mark), eligible, zero < gap2);
    auto settled = but_not(clear & but_not(eligible, soon), deep);
    auto hit = soon;
    F<L> nx = zero, ny = zero, far = one, vn = zero;
    if (any(soon)) {
      const auto x = dx + t * ux, y = dy + t * uy;
      const auto length = sqrt(x * x + y * y);
      const auto apart = zero < length;
      far = select(apart, length, one);
      nx = snapped<L>(x / far), ny = select(apart, snapped<L>(y / far), one);
      vn = nx * ux + ny * uy;
      const auto bounce = e * abs(vn);
      const auto elastic = one <= e;
      const auto keen = elastic | (floor <= bounce);
      hit = (soon & (least_e <= e)) & (keen & (vn < zero));
      const auto later = but_not(hit, t < due);
      if (any(later)) busy = true;
      hit = but_not(hit, later);
      settled = settled | hit;
    }
    L::store(c.impact + k, select(settled, set, select(eligible, zero, mark)));
    if (!any(hit)) continue;
    busy = true;
    const auto m = kModel == Model::plain ? half : L::load(c.mass + k);
    const auto j = keep(hit, impulse_along<L>(nx, ny, e, vn, m));
    auto px = j * nx, py = j * ny;
    auto wa = one, wb = one;
    if constexpr (kModel != Model::plain) wa = L::load(c.wa + k), wb = L::load(c.wb + k);
    if constexpr (kModel == Model::rough) {
      const auto ua = L::template gather1<2>(b.rim_speed, slot);
      const auto ub = L::template gather1<2>(b.rim_speed, slot + 1);
      const auto vt = nx * uy - ny * ux - ub - ua;
      const auto cap = L::load(c.mu + k) * j;
      const auto wish = -(L::load(c.tmass + k) * vt);
      const auto jt = keep(hit, max(min(wish, cap), -cap));
      px = px - jt * ny;
      py = py + jt * nx;
      const auto sa = L::load(c.qa + k) * jt, sb = L::load(c.qb + k) * jt;
      L::template scatter1<2>(b.rim_speed, slot, ua - sa);
      L::template scatter1<2>(b.rim_speed, slot + 1, ub - sb);
      const auto ua0 = L::template gather1<2>(b.rim_speed0, slot);
      const auto ub0 = L::template gather1<2>(b.rim_speed0, slot + 1);
      L::template scatter1<2>(b.rim_speed0, slot, ua0 - sa);
      L::template scatter1<2>(b.rim_speed0, slot + 1, ub0 - sb);
      const auto way_a = L::template gather1<2>(b.rim_way, slot);
      const auto way_b = L::template gather1<2>(b.rim_way, slot + 1);
      L::template scatter1<2>(b.rim_way, slot, way_a + keep(hit, t * sa));
      L::template scatter1<2>(b.rim_way, slot + 1, way_b + keep(hit, t * sb));
    }
    const auto ax = wa * px, ay = wa * py;
    const auto bx = wb * px, by = wb * py;
    const auto put = [&](float* rec, const std::uint32_t* at, F<L> ox, F<L> oy, F<L> x, F<L> y) {
      L::template scatter<2>(rec, at, select(hit, x, ox), select(hit, y, oy));
    };
    put(b.vel, slot, vax, vay, vax - ax, vay - ay);
    put(b.vel, slot + 1, vbx, vby, vbx + bx, vby + by);
    put(b.disp, slot, dax, day, dax + t * ax, day + t * ay);
    put(b.disp, slot + 1, dbx, dby, dbx - t * bx, dby - t * by);
    F<L> x, y;
    L::template gather<2>(b.vel0, slot, x, y);
    put(b.vel0, slot, x, y, x - ax, y - ay);
    L::template gather<2>(b.vel0, slot + 1, x, y);
    put(b.vel0, slot + 1, x, y, x + bx, y + by);
    const auto when = max(t, kLeastTime);  // 0 means: no event
    L::template scatter1<2>(b.event_time, slot, select(hit, when, ta));
    L::template scatter1<2>(b.event_time, slot + 1, select(hit, when, tb));
    float work[L::width];
    L::store(work, keep(hit, j * far));  // 0 times infinity is not 0
    for (const float one_hit : work) *virial += static_cast<double>(one_hit);
  }
  return busy;
}

/// The same for fixed shapes. Flat faces (refresh infinite) follow the parabola
/// s + un t + gn t^2/2 = 0; round ones the chord at the mean velocity, refined twice.
template <class L, Model kModel, Sweep kSweep>
bool sweep_statics(const BodyView& b, const StaticContactView& c, const ContactParams& p, std::uint32_t begin,
                   std::uint32_t end, double* virial) {
  const F<L> zero = 0, one = 1, half = 0.5f, two = 2;
  const F<L> h = p.h, set = -0.0f;
  const F<L> floor = p.bounce_floor, due = p.due, least_e = p.least_e;
  const F<L> deepest = -2 * p.refresh;  // R (|d| - R) is close to (d.d - R^2) / 2
  bool busy = false;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const auto e = L::load(c.e + k);
    auto mark = L::load(c.impact + k);
    const auto eligible = mark <= zero;
    if constexpr (kSweep == Sweep::first) mark = select(eligible, zero, mark);
    if (!any(eligible)) continue;
    const std::uint32_t* slot = c.body + k;
    F<L> dx, dy, vx, vy;
    L::template gather<1>(b.disp, slot, dx, dy);
    L::template gather<1>(b.vel, slot, vx, vy);
    F<L> gx = p.gravity_x, gy = p.gravity_y;
    if (b.acc) L::template gather<1>(b.acc, slot, gx, gy);
    const auto t0 = L::template gather1<1>(b.event_time, slot);
    const auto flat = 1e30f < L::load(c.refresh + k);
    auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    // Flat: along the normal, from t0.
    const auto gn = nx * gx + ny * gy;
    const auto s = L::load(c.gap + k) + (nx * dx + ny * dy);
    const auto un = nx * vx + ny * vy;
    const auto s0 = s + t0 * (un + half * gn * t0);
    const auto un0 = un + gn * t0;
    const auto flat_root2 = un0 * un0 - two * gn * s0;
    const auto flat_speed = sqrt(max(flat_root2, zero)) - un0;
    const auto flat_under = (s0 <= zero) & (un0 < zero);
    const auto flat_ahead = ((zero < s0) & (zero <= flat_root2)) & (zero < flat_speed);
    const auto flat_t = t0 + select(flat_ahead, two * s0 / select(flat_ahead, flat_speed, one), zero);
    const auto flat_soon = (flat_under | flat_ahead) & (flat_t < h);
    // Round: the chord at the mean velocity up to the hit, two rounds.
    const auto x = L::load(c.base_x + k) + dx, y = L::load(c.base_y + k) + dy;
    const auto radius = L::load(c.rsum + k);
    auto t = half * h;
    auto soon = L::none();
    auto gap0 = zero;
    for (int round = 0; round < 2; ++round) {
      const auto mean = half * max(t, t0);
      const auto ux = snapped<L>(vx + gx * mean, kSlow), uy = snapped<L>(vy + gy * mean, kSlow);
      const auto x0 = x + t0 * ux, y0 = y + t0 * uy;
      const auto q = x0 * ux + y0 * uy;
      const auto gap2 = x0 * x0 + y0 * y0 - radius * radius;
      gap0 = gap2;
      const auto uu = ux * ux + uy * uy;
      const auto size = squarable<L>(q), root2 = size * size - uu * gap2;
      const auto closing = (q < zero) & (zero <= root2);
      const auto speed = select(closing, sqrt(max(root2, zero)) - q, one);
      const auto hit_t = t0 + max(gap2 / speed, zero);
      soon = closing & (hit_t < h);
      t = select(soon, hit_t, t);
    }
    t = snapped<L>(select(flat, flat_t, t), kLeastTime);
    const auto deep = select(flat, s0 < half * deepest, gap0 < deepest * radius) & (e < one);
    soon = but_not(eligible & select(flat, flat_soon, soon), deep);
    const auto clear = select(negative(mark), eligible, zero < select(flat, s0, gap0));
    auto settled = but_not(clear & but_not(eligible, soon), deep);
    auto hit = soon;
    F<L> vn = zero;
    if (any(soon)) {
      const auto fall = half * t * t;
      const auto wx = snapped<L>(vx), wy = snapped<L>(vy);
      const auto xt = snapped<L>(x + t * wx + fall * gx, kLeastOffset);
      const auto yt = snapped<L>(y + t * wy + fall * gy, kLeastOffset);
      const auto length = sqrt(xt * xt + yt * yt);
      const auto inverse = one / select(zero < length, length, one);
      nx = select(flat, nx, snapped<L>(xt * inverse));
      ny = select(flat, ny, snapped<L>(yt * inverse));
      vn = nx * (wx + gx * t) + ny * (wy + gy * t);
      const auto keen = floor <= e * abs(vn);
      hit = (soon & (least_e <= e)) & (keen & (vn < zero));
      const auto later = but_not(hit, t < due);
      if (any(later)) busy = true;
      hit = but_not(hit, later);
      settled = settled | hit;
    }
    L::store(c.impact + k, select(settled, set, select(eligible, zero, mark)));
    if (!any(hit)) continue;
    busy = true;
    const auto m = kModel == Model::plain ? one : L::load(c.mass + k);
    const auto j = keep(hit, impulse_along<L>(nx, ny, e, vn, m));
    auto px = j * nx, py = j * ny;
    if constexpr (kModel == Model::rough) {
      const auto u = L::template gather1<1>(b.rim_speed, slot);
      const auto vt = nx * (vy + gy * t) - ny * (vx + gx * t) - u;
      const auto cap = L::load(c.mu + k) * j;
      const auto wish = -(L::load(c.tmass + k) * vt);
      const auto jt = keep(hit, max(min(wish, cap), -cap));
      px = px - jt * ny;
      py = py + jt * nx;
      const auto su = L::load(c.qb + k) * jt;
      L::template scatter1<1>(b.rim_speed, slot, u - su);
      L::template scatter1<1>(b.rim_speed0, slot, L::template gather1<1>(b.rim_speed0, slot) - su);
      L::template scatter1<1>(b.rim_way, slot, L::template gather1<1>(b.rim_way, slot) + keep(hit, t * su));
    }
    if constexpr (kModel != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = w * px, py = w * py;
    }
    const auto put = [&](float* rec, F<L> ox, F<L> oy, F<L> nxt, F<L> nyt) {
      L::template scatter<1>(rec, slot, select(hit, nxt, ox), select(hit, nyt, oy));
    };
    put(b.vel, vx, vy, vx + px, vy + py);
    put(b.disp, dx, dy, dx - t * px, dy - t * py);
    F<L> v0x, v0y;
    L::template gather<1>(b.vel0, slot, v0x, v0y);
    put(b.vel0, v0x, v0y, v0x + px, v0y + py);
    L::template scatter1<1>(b.event_time, slot, select(hit, max(t, kLeastTime), t0));
    float work[L::width];
    L::store(work, select(flat, zero, j * radius));
    for (const float one_hit : work) *virial += static_cast<double>(one_hit);
  }
  return busy;
}

}  // namespace
}  // namespace psim::kernels
