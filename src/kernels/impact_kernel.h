// Time-of-impact sweeps: contacts with restitution whose bodies rest on nothing collide at their
// exact time within the substep, with the exact normal and velocities of that moment.
//
// Every body has a virtual start of the substep (x, v) from which it moves freely, and the time of
// its last event tl. For a pair, d = xB - xA, u = vB - vA (common gravity cancels), R = rA + rB,
// from t0 = max(tlA, tlB):
//   dd = d + t0 u,  q = dd.u (parting if q >= 0),  c = dd.dd - R^2,
//   t = t0 + c / (-q + sqrt(q^2 - u.u c))        (t0 if c <= 0)
// If t < h: n at t, J = -(1 + e) n.u m, v +- w J n, x -+ t w J n (so that x + v h is right), tl = t.
// Friction: Jt = clamp(-mt vt, +- mu J) with spin u = omega r, -q Jt each.
// A pair apart with no hit ahead is settled too: no speculative impulse. Impacts slower than the
// floor are left to the solver (impact mark stays clear), and so are, in the last sweep, impacts
// that are not fully elastic. Impacts from p.due on are left to a later sweep: a body that has several
// takes them nearly in their order. Returns true if any lane collided or has yet to; `virial` receives
// J |d| of every collision.
#pragma once

#include "views.h"

namespace psim::kernels {
namespace {

/// -(1 + e) vn m / |n|^2. A float normal is not quite of length 1, for R = 1 m on average 2e-8 too
/// long, and an elastic impact along it would gain as much energy each time.
template <class L>
[[gnu::always_inline]] inline typename L::F impulse_along(typename L::F nx, typename L::F ny,
                                                          typename L::F e, typename L::F vn,
                                                          typename L::F m) {
  const auto half = L::set1(0.5f);
  const auto excess = L::add(L::sub(L::mul(nx, nx), half), L::sub(L::mul(ny, ny), half));
  const auto j = L::mul(L::mul(L::add(L::set1(1), e), vn), m);
  return L::sub(L::mul(j, excess), j);
}

template <class L, Model M>
bool sweep_contacts(const BodyView& b, const ContactView& c, const ContactParams& p,
                    std::uint32_t begin, std::uint32_t end, double* virial) {
  const auto zero = L::set1(0), one = L::set1(1), half = L::set1(0.5f);
  const auto h = L::set1(p.h), set = L::set1(-0.0f);
  const auto floor = L::set1(p.bounce_floor), due = L::set1(p.due);
  bool any = false;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const auto e = L::load(c.e + k);
    // `impact` holds +1: not for sweeps; +0: pending; -0: settled.
    auto mark = L::load(c.impact + k);
    const auto eligible = L::less_equal(mark, zero);
    if (p.first_sweep) mark = L::select(eligible, zero, mark);
    if (!L::bits(eligible)) continue;
    const std::uint32_t* slot = c.body + 2 * k;
    const auto ta = L::template gather1<2>(b.event_time, slot);
    const auto tb = L::template gather1<2>(b.event_time, slot + 1);
    // No impact left to this sweep, and no body had an event since: the one before said all.
    auto asked = L::less(zero, L::max(ta, tb));
    if (p.sliced) asked = L::either(asked, L::select_sign(mark, zero, eligible));
    if (!p.first_sweep && !L::bits(asked)) continue;
    typename L::I iax, iay, ibx, iby;
    L::template gather_int<2>(b.pos, slot, iax, iay);
    L::template gather_int<2>(b.pos, slot + 1, ibx, iby);
    typename L::F dax, day, dbx, dby, vax, vay, vbx, vby;
    L::template gather<2>(b.disp, slot, dax, day);
    L::template gather<2>(b.disp, slot + 1, dbx, dby);
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    const auto dx = L::add(L::mul(L::to_float(L::sub(ibx, iax)), L::set1(p.pitch_x)),
                           L::sub(dbx, dax));
    const auto dy = L::add(L::mul(L::to_float(L::sub(iby, iay)), L::set1(p.pitch_y)),
                           L::sub(dby, day));
    const auto ux = L::sub(vbx, vax), uy = L::sub(vby, vay);
    const auto t0 = L::max(ta, tb);
    const auto x0 = L::add(dx, L::mul(t0, ux)), y0 = L::add(dy, L::mul(t0, uy));
    const auto q = L::add(L::mul(x0, ux), L::mul(y0, uy));
    const auto radius = L::load(c.rsum + k);
    const auto gap2 = L::sub(L::add(L::mul(x0, x0), L::mul(y0, y0)), L::mul(radius, radius));
    const auto uu = L::add(L::mul(ux, ux), L::mul(uy, uy));
    const auto root2 = L::sub(L::mul(q, q), L::mul(uu, gap2));
    const auto closing = L::both(eligible, L::both(L::less(q, zero), L::less_equal(zero, root2)));
    const auto root = L::sqrt(L::max(root2, zero));
    const auto speed = L::select(closing, L::sub(root, q), one);
    const auto t = L::add(t0, L::max(L::div(gap2, speed), zero));
    const auto soon = L::both(closing, L::less(t, h));
    // Apart with no hit ahead, or parting after an earlier hit: settled without an impulse. Pairs
    // that overlap otherwise are the solver's.
    const auto clear = L::select_sign(mark, eligible, L::less(zero, gap2));
    auto settled = L::both(clear, L::but_not(eligible, soon));
    auto hit = soon;
    typename L::F nx = zero, ny = zero, far = one, vn = zero;
    if (L::bits(soon)) {
      const auto x = L::add(dx, L::mul(t, ux)), y = L::add(dy, L::mul(t, uy));
      const auto length = L::sqrt(L::add(L::mul(x, x), L::mul(y, y)));
      const auto apart = L::less(zero, length);
      far = L::select(apart, length, one);
      nx = L::div(x, far), ny = L::select(apart, L::div(y, far), one);
      vn = L::add(L::mul(nx, ux), L::mul(ny, uy));
      const auto bounce = L::mul(e, L::abs(vn));
      const auto elastic = L::less_equal(one, e);
      const auto keen = L::either(elastic, L::less_equal(floor, bounce));
      hit = L::both(soon, L::both(keen, L::less(vn, zero)));
      if (p.last_sweep) hit = L::both(hit, elastic);
      const auto later = L::but_not(hit, L::less(t, due));
      if (L::bits(later)) any = true;
      hit = L::but_not(hit, later);
      settled = L::either(settled, hit);
    }
    L::store(c.impact + k, L::select(settled, set, L::select(eligible, zero, mark)));
    if (!L::bits(hit)) continue;
    any = true;
    const auto m = M == Model::plain ? half : L::load(c.mass + k);
    const auto j = L::both(hit, impulse_along<L>(nx, ny, e, vn, m));
    auto px = L::mul(j, nx), py = L::mul(j, ny);
    auto wa = one, wb = one;
    if constexpr (M != Model::plain) wa = L::load(c.wa + k), wb = L::load(c.wb + k);
    if constexpr (M == Model::rough) {
      const auto ua = L::template gather1<2>(b.spin, slot);
      const auto ub = L::template gather1<2>(b.spin, slot + 1);
      const auto vt = L::sub(L::sub(L::sub(L::mul(nx, uy), L::mul(ny, ux)), ub), ua);
      const auto cap = L::mul(L::load(c.mu + k), j);
      const auto wish = L::negate(L::mul(L::load(c.tmass + k), vt));
      const auto jt = L::both(hit, L::max(L::min(wish, cap), L::negate(cap)));
      px = L::sub(px, L::mul(jt, ny));
      py = L::add(py, L::mul(jt, nx));
      const auto sa = L::mul(L::load(c.qa + k), jt), sb = L::mul(L::load(c.qb + k), jt);
      L::template scatter1<2>(b.spin, slot, L::sub(ua, sa));
      L::template scatter1<2>(b.spin, slot + 1, L::sub(ub, sb));
      const auto ua0 = L::template gather1<2>(b.spin0, slot);
      const auto ub0 = L::template gather1<2>(b.spin0, slot + 1);
      L::template scatter1<2>(b.spin0, slot, L::sub(ua0, sa));
      L::template scatter1<2>(b.spin0, slot + 1, L::sub(ub0, sb));
    }
    const auto ax = L::mul(wa, px), ay = L::mul(wa, py);
    const auto bx = L::mul(wb, px), by = L::mul(wb, py);
    const auto put = [&](float* rec, const std::uint32_t* at, typename L::F ox, typename L::F oy,
                         typename L::F x, typename L::F y) {
      L::template scatter<2>(rec, at, L::select(hit, x, ox), L::select(hit, y, oy));
    };
    put(b.vel, slot, vax, vay, L::sub(vax, ax), L::sub(vay, ay));
    put(b.vel, slot + 1, vbx, vby, L::add(vbx, bx), L::add(vby, by));
    put(b.disp, slot, dax, day, L::add(dax, L::mul(t, ax)), L::add(day, L::mul(t, ay)));
    put(b.disp, slot + 1, dbx, dby, L::sub(dbx, L::mul(t, bx)), L::sub(dby, L::mul(t, by)));
    typename L::F x, y;
    L::template gather<2>(b.vel0, slot, x, y);
    put(b.vel0, slot, x, y, L::sub(x, ax), L::sub(y, ay));
    L::template gather<2>(b.vel0, slot + 1, x, y);
    put(b.vel0, slot + 1, x, y, L::add(x, bx), L::add(y, by));
    const auto when = L::max(t, L::set1(1e-30f));  // 0 means: no event
    L::template scatter1<2>(b.event_time, slot, L::select(hit, when, ta));
    L::template scatter1<2>(b.event_time, slot + 1, L::select(hit, when, tb));
    float work[L::width];
    L::store(work, L::both(hit, L::mul(j, far)));  // 0 times infinity is not 0
    for (const float one_hit : work) *virial += static_cast<double>(one_hit);
  }
  return any;
}

/// The same for fixed shapes. Flat faces (refresh infinite) follow the parabola
/// s + un t + gn t^2/2 = 0; round ones the chord at the mean velocity, refined twice.
template <class L, Model M>
bool sweep_singles(const BodyView& b, const SingleView& c, const ContactParams& p,
                   std::uint32_t begin, std::uint32_t end, double* virial) {
  const auto zero = L::set1(0), one = L::set1(1), half = L::set1(0.5f), two = L::set1(2);
  const auto h = L::set1(p.h), set = L::set1(-0.0f);
  const auto floor = L::set1(p.bounce_floor), due = L::set1(p.due);
  bool any = false;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const auto e = L::load(c.e + k);
    auto mark = L::load(c.impact + k);
    const auto eligible = L::less_equal(mark, zero);
    if (p.first_sweep) mark = L::select(eligible, zero, mark);
    if (!L::bits(eligible)) continue;
    const std::uint32_t* slot = c.body + k;
    typename L::F dx, dy, vx, vy;
    L::template gather<1>(b.disp, slot, dx, dy);
    L::template gather<1>(b.vel, slot, vx, vy);
    auto gx = L::set1(p.gravity_x), gy = L::set1(p.gravity_y);
    if (b.acc) L::template gather<1>(b.acc, slot, gx, gy);
    const auto t0 = L::template gather1<1>(b.event_time, slot);
    const auto flat = L::less(L::set1(1e30f), L::load(c.refresh + k));
    auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    // Flat: along the normal, from t0.
    const auto gn = L::add(L::mul(nx, gx), L::mul(ny, gy));
    const auto s = L::add(L::load(c.gap + k), L::add(L::mul(nx, dx), L::mul(ny, dy)));
    const auto un = L::add(L::mul(nx, vx), L::mul(ny, vy));
    const auto s0 = L::add(s, L::mul(t0, L::add(un, L::mul(L::mul(half, gn), t0))));
    const auto un0 = L::add(un, L::mul(gn, t0));
    const auto flat_root2 = L::sub(L::mul(un0, un0), L::mul(L::mul(two, gn), s0));
    const auto flat_speed = L::sub(L::sqrt(L::max(flat_root2, zero)), un0);
    const auto flat_under = L::both(L::less_equal(s0, zero), L::less(un0, zero));
    const auto flat_ahead = L::both(L::both(L::less(zero, s0), L::less_equal(zero, flat_root2)),
                                    L::less(zero, flat_speed));
    const auto flat_t = L::add(
        t0, L::select(flat_ahead,
                      L::div(L::mul(two, s0), L::select(flat_ahead, flat_speed, one)), zero));
    const auto flat_soon = L::both(L::either(flat_under, flat_ahead), L::less(flat_t, h));
    // Round: the chord at the mean velocity up to the hit, two rounds.
    const auto x = L::add(L::load(c.base_x + k), dx), y = L::add(L::load(c.base_y + k), dy);
    const auto radius = L::load(c.rsum + k);
    auto t = L::mul(half, h);
    auto soon = zero, gap0 = zero;
    for (int round = 0; round < 2; ++round) {
      const auto mean = L::mul(half, L::max(t, t0));
      const auto ux = L::add(vx, L::mul(gx, mean)), uy = L::add(vy, L::mul(gy, mean));
      const auto x0 = L::add(x, L::mul(t0, ux)), y0 = L::add(y, L::mul(t0, uy));
      const auto q = L::add(L::mul(x0, ux), L::mul(y0, uy));
      const auto gap2 = L::sub(L::add(L::mul(x0, x0), L::mul(y0, y0)), L::mul(radius, radius));
      gap0 = gap2;
      const auto uu = L::add(L::mul(ux, ux), L::mul(uy, uy));
      const auto root2 = L::sub(L::mul(q, q), L::mul(uu, gap2));
      const auto closing = L::both(L::less(q, zero), L::less_equal(zero, root2));
      const auto speed = L::select(closing, L::sub(L::sqrt(L::max(root2, zero)), q), one);
      const auto hit_t = L::add(t0, L::max(L::div(gap2, speed), zero));
      soon = L::both(closing, L::less(hit_t, h));
      t = L::select(soon, hit_t, t);
    }
    t = L::select(flat, flat_t, t);
    soon = L::both(eligible, L::select(flat, flat_soon, soon));
    const auto clear = L::select_sign(mark, eligible, L::less(zero, L::select(flat, s0, gap0)));
    auto settled = L::both(clear, L::but_not(eligible, soon));
    auto hit = soon;
    typename L::F vn = zero;
    if (L::bits(soon)) {
      const auto fall = L::mul(L::mul(half, t), t);
      const auto xt = L::add(L::add(x, L::mul(t, vx)), L::mul(fall, gx));
      const auto yt = L::add(L::add(y, L::mul(t, vy)), L::mul(fall, gy));
      const auto length = L::sqrt(L::add(L::mul(xt, xt), L::mul(yt, yt)));
      const auto inverse = L::div(one, L::select(L::less(zero, length), length, one));
      nx = L::select(flat, nx, L::mul(xt, inverse));
      ny = L::select(flat, ny, L::mul(yt, inverse));
      vn = L::add(L::mul(nx, L::add(vx, L::mul(gx, t))), L::mul(ny, L::add(vy, L::mul(gy, t))));
      const auto keen = L::less_equal(floor, L::mul(e, L::abs(vn)));
      hit = L::both(soon, L::both(keen, L::less(vn, zero)));
      if (p.last_sweep) hit = L::both(hit, L::less_equal(one, e));
      const auto later = L::but_not(hit, L::less(t, due));
      if (L::bits(later)) any = true;
      hit = L::but_not(hit, later);
      settled = L::either(settled, hit);
    }
    L::store(c.impact + k, L::select(settled, set, L::select(eligible, zero, mark)));
    if (!L::bits(hit)) continue;
    any = true;
    const auto m = M == Model::plain ? one : L::load(c.mass + k);
    const auto j = L::both(hit, impulse_along<L>(nx, ny, e, vn, m));
    auto px = L::mul(j, nx), py = L::mul(j, ny);
    if constexpr (M == Model::rough) {
      const auto u = L::template gather1<1>(b.spin, slot);
      const auto vt = L::sub(L::sub(L::mul(nx, L::add(vy, L::mul(gy, t))),
                                    L::mul(ny, L::add(vx, L::mul(gx, t)))), u);
      const auto cap = L::mul(L::load(c.mu + k), j);
      const auto wish = L::negate(L::mul(L::load(c.tmass + k), vt));
      const auto jt = L::both(hit, L::max(L::min(wish, cap), L::negate(cap)));
      px = L::sub(px, L::mul(jt, ny));
      py = L::add(py, L::mul(jt, nx));
      const auto su = L::mul(L::load(c.qb + k), jt);
      L::template scatter1<1>(b.spin, slot, L::sub(u, su));
      L::template scatter1<1>(b.spin0, slot, L::sub(L::template gather1<1>(b.spin0, slot), su));
    }
    if constexpr (M != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = L::mul(w, px), py = L::mul(w, py);
    }
    const auto put = [&](float* rec, typename L::F ox, typename L::F oy, typename L::F nxt,
                         typename L::F nyt) {
      L::template scatter<1>(rec, slot, L::select(hit, nxt, ox), L::select(hit, nyt, oy));
    };
    put(b.vel, vx, vy, L::add(vx, px), L::add(vy, py));
    put(b.disp, dx, dy, L::sub(dx, L::mul(t, px)), L::sub(dy, L::mul(t, py)));
    typename L::F v0x, v0y;
    L::template gather<1>(b.vel0, slot, v0x, v0y);
    put(b.vel0, v0x, v0y, L::add(v0x, px), L::add(v0y, py));
    L::template scatter1<1>(b.event_time, slot, L::select(hit, L::max(t, L::set1(1e-30f)), t0));
    float work[L::width];
    L::store(work, L::but_not(L::mul(j, radius), flat));
    for (const float one_hit : work) *virial += static_cast<double>(one_hit);
  }
  return any;
}

}  // namespace
}  // namespace psim::kernels
