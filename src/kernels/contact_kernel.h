// Passes over contacts between two bodies: prepare, warm start, solve, relax. Blocks of 8 contacts;
// within a colour no body occurs twice, so lanes never meet.
//
// Notation (A, B bodies, n from A to B, w inverse mass, m = 1/(wA+wB), l stored impulse, h substep):
//   separation   s = gap + n.(dB - dA)
//   solve        s > 0: dl = -m (vn + s/h);  s <= 0: dl = -m (ms vn + max(ms rate s, -push)) - is l
//   relax        dl = -m vn for contacts that are closed
//   both         l' = max(l + dl, 0);  vA -= wA (l'-l) n;  vB += wB (l'-l) n
// Soft contact after Catto (Solver2D, 2024), stiffness tied to the substep (docs/solver.md). In the
// plain model all masses are 1 and m = 1/2. An open contact (s > 0, l = 0) is marked by storing -0
// so that relax leaves it alone.
//
// A contact whose impulses do not change leaves its bodies' velocities alone, bit for bit. A vector
// of such contacts, most of those of a scene in flight, skips its stores.
#pragma once

#include "views.h"

namespace psim::kernels {
namespace {

/// Geometry from lattice positions: n = d/|d|, gap = |d| - rsum, d = (XB - XA) pitch. Coincident
/// centres get n = (0, 1).
template <class L>
void prepare_contacts(const BodyView& b, const ContactView& c, const ContactParams& p,
                      std::uint32_t begin, std::uint32_t end) {
  const auto pitch_x = L::set1(p.pitch_x), pitch_y = L::set1(p.pitch_y);
  const auto zero = L::set1(0), one = L::set1(1);
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    typename L::I ax, ay, bx, by;
    L::template gather_int<2>(b.pos, slot, ax, ay);
    L::template gather_int<2>(b.pos, slot + 1, bx, by);
    const auto dx = L::mul(L::to_float(L::sub(bx, ax)), pitch_x);
    const auto dy = L::mul(L::to_float(L::sub(by, ay)), pitch_y);
    const auto far = L::sqrt(L::add(L::mul(dx, dx), L::mul(dy, dy)));
    const auto apart = L::less(zero, far);
    const auto inverse = L::div(one, L::select(apart, far, one));
    L::store(c.nx + k, L::mul(dx, inverse));
    L::store(c.ny + k, L::select(apart, L::mul(dy, inverse), one));
    L::store(c.gap + k, L::sub(far, L::load(c.rsum + k)));
  }
}

/// vA -= wA (px, py), vB += wB (px, py) in the lanes of `moved`. Subtractions only: adding a zero
/// would turn a velocity of -0 into +0.
template <class L, Model M>
[[gnu::always_inline]] inline void push_apart(const BodyView& b, const ContactView& c, std::size_t k,
                                              typename L::F moved, typename L::F px,
                                              typename L::F py, typename L::F vax, typename L::F vay,
                                              typename L::F vbx, typename L::F vby) {
  const std::uint32_t* slot = c.body + 2 * k;
  auto ax = px, ay = py, bx = L::negate(px), by = L::negate(py);
  if constexpr (M != Model::plain) {
    const auto wa = L::load(c.wa + k), wb = L::load(c.wb + k);
    ax = L::mul(wa, ax), ay = L::mul(wa, ay);
    bx = L::mul(wb, bx), by = L::mul(wb, by);
  }
  L::template scatter<2>(b.vel, slot, L::sub(vax, L::both(moved, ax)), L::sub(vay, L::both(moved, ay)));
  L::template scatter<2>(b.vel, slot + 1, L::sub(vbx, L::both(moved, bx)),
                         L::sub(vby, L::both(moved, by)));
}

/// Contact geometry anew where the bodies moved sideways by more than p.refresh since `prepare`:
/// the lanes in `stale` get the normal at their present displacement and a gap that gives the exact
/// separation there. Impulses that the velocities hold along the old normal are turned with it.
template <class L, Model M>
[[gnu::cold, gnu::noinline]] void refresh_normals(const BodyView& b, const ContactView& c, const ContactParams& p,
                     std::size_t k, typename L::F stale, typename L::F ddx, typename L::F ddy,
                     typename L::F& nx, typename L::F& ny, typename L::F& gap) {
  const std::uint32_t* slot = c.body + 2 * k;
  typename L::I ax, ay, bx, by;
  L::template gather_int<2>(b.pos, slot, ax, ay);
  L::template gather_int<2>(b.pos, slot + 1, bx, by);
  const auto dx = L::add(L::mul(L::to_float(L::sub(bx, ax)), L::set1(p.pitch_x)), ddx);
  const auto dy = L::add(L::mul(L::to_float(L::sub(by, ay)), L::set1(p.pitch_y)), ddy);
  const auto far = L::sqrt(L::add(L::mul(dx, dx), L::mul(dy, dy)));
  const auto use = L::both(stale, L::less(L::set1(0), far));
  const auto inverse = L::div(L::set1(1), L::select(use, far, L::set1(1)));
  const auto was_x = nx, was_y = ny;
  nx = L::select(use, L::mul(dx, inverse), nx);
  ny = L::select(use, L::mul(dy, inverse), ny);
  const auto along = L::add(L::mul(nx, ddx), L::mul(ny, ddy));
  gap = L::select(use, L::sub(L::sub(far, L::load(c.rsum + k)), along), gap);
  L::store(c.nx + k, nx);
  L::store(c.ny + k, ny);
  L::store(c.gap + k, gap);
  const auto l = L::load(c.impulse + k);
  const auto turn_x = L::sub(nx, was_x), turn_y = L::sub(ny, was_y);
  auto px = L::mul(l, turn_x), py = L::mul(l, turn_y);
  auto held = L::differ(l, L::set1(0));
  if constexpr (M == Model::rough) {
    const auto t = L::load(c.friction + k);
    px = L::sub(px, L::mul(t, turn_y));
    py = L::add(py, L::mul(t, turn_x));
    held = L::either(held, L::differ(t, L::set1(0)));
  }
  typename L::F vax, vay, vbx, vby;
  L::template gather<2>(b.vel, slot, vax, vay);
  L::template gather<2>(b.vel, slot + 1, vbx, vby);
  push_apart<L, M>(b, c, k, L::both(use, held), px, py, vax, vay, vbx, vby);
}

/// Spins alike: uA -= qA dt, uB -= qB dt.
template <class L>
[[gnu::always_inline]] inline void turn_apart(const BodyView& b, const ContactView& c, std::size_t k,
                                              typename L::F dt, typename L::F ua, typename L::F ub) {
  const std::uint32_t* slot = c.body + 2 * k;
  const auto turned = L::differ(dt, L::set1(0));
  const auto da = L::mul(L::load(c.qa + k), dt), db = L::mul(L::load(c.qb + k), dt);
  L::template scatter1<2>(b.spin, slot, L::sub(ua, L::both(turned, da)));
  L::template scatter1<2>(b.spin, slot + 1, L::sub(ub, L::both(turned, db)));
}

/// v += w l n for the impulses of the last substep, scaled by p.warm.
template <class L, Model M>
void warm_contacts(const BodyView& b, const ContactView& c, const ContactParams& p,
                   std::uint32_t begin, std::uint32_t end) {
  const auto warm = L::set1(p.warm);
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto l = L::mul(L::load(c.impulse + k), warm);
    L::store(c.impulse + k, l);
    auto px = L::mul(l, nx), py = L::mul(l, ny);
    auto moved = L::differ(l, L::set1(0));
    typename L::F t{};
    if constexpr (M == Model::rough) {
      t = L::mul(L::load(c.friction + k), warm);
      L::store(c.friction + k, t);
      px = L::sub(px, L::mul(t, ny));
      py = L::add(py, L::mul(t, nx));
      moved = L::either(moved, L::differ(t, L::set1(0)));
    }
    if (!L::bits(moved)) continue;
    typename L::F vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    if constexpr (M == Model::rough) {
      const auto ua = L::template gather1<2>(b.spin, slot);
      const auto ub = L::template gather1<2>(b.spin, slot + 1);
      turn_apart<L>(b, c, k, t, ua, ub);
    }
    push_apart<L, M>(b, c, k, moved, px, py, vax, vay, vbx, vby);
  }
}

/// Where touching bodies meet with restitution: the velocity they should part with, e vn0 (vn0 the
/// approach before the kick, negative), for approaches faster than the floor that close the gap
/// within the substep. Returns the lanes; `target` is what to add to vn.
template <class L>
[[gnu::always_inline]] inline typename L::F bouncing(const BodyView& b, const ContactView& c, const ContactParams& p,
                       std::size_t k, typename L::F nx, typename L::F ny, typename L::F s,
                       typename L::F& target) {
  const std::uint32_t* slot = c.body + 2 * k;
  typename L::F ax, ay, bx, by;
  L::template gather<2>(b.vel0, slot, ax, ay);
  L::template gather<2>(b.vel0, slot + 1, bx, by);
  const auto vn0 = L::add(L::mul(nx, L::sub(bx, ax)), L::mul(ny, L::sub(by, ay)));
  target = L::mul(L::load(c.e + k), vn0);
  const auto fast = L::less(vn0, L::set1(-p.impact_floor));
  const auto near = L::less(L::add(s, L::mul(vn0, L::set1(p.h))), L::set1(0));
  return L::both(L::both(fast, near), L::less(L::set1(0), L::load(c.e + k)));
}

/// Of pairs apart by s, those that pass each other at their present velocities: the closest point of
/// the path of D = n (s + R) along u stays outside R,
///   (D x u)^2 > R^2 u^2,  that is  vt^2 s (s + 2 R) > R^2 vn^2.
/// A contact stops what crosses its tangent line within the substep; these never touch.
template <class L>
[[gnu::always_inline]] inline typename L::F passing(typename L::F s, typename L::F radius,
                                                    typename L::F vn, typename L::F vt) {
  const auto miss = L::mul(L::mul(vt, vt), L::mul(s, L::add(s, L::add(radius, radius))));
  const auto reach = L::mul(radius, vn);
  return L::less(L::mul(reach, reach), miss);
}

/// The solve pass: push out softly, or stop the approach of a gap that would close.
template <class L, Model M, bool Bounce>
void solve_contacts(const BodyView& b, const ContactView& c, const ContactParams& p,
                    std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1(0), one = L::set1(1), half = L::set1(0.5f);
  const auto inv_h = L::set1(p.inv_h), rate = L::set1(p.soft_rate), push = L::set1(-p.push);
  const auto soft_mass = L::set1(p.soft_mass), soft_impulse = L::set1(p.soft_impulse);
  const auto refresh = L::set1(p.refresh), open = L::set1(-0.0f);
  constexpr std::uint32_t kAll = (1u << L::width) - 1;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    const auto l = L::load(c.impulse + k);
    typename L::F settled{};
    if constexpr (Bounce) {
      settled = L::load(c.impact + k);
      if (!p.again) L::store(c.start + k, l);
      if (L::bits(settled) == kAll && !L::bits(L::differ(l, zero))) {  // settled, nothing to take back
        L::store(c.impulse + k, open);
        continue;
      }
    }
    typename L::F dax, day, dbx, dby;
    L::template gather<2>(b.disp, slot, dax, day);
    L::template gather<2>(b.disp, slot + 1, dbx, dby);
    auto nx = L::load(c.nx + k), ny = L::load(c.ny + k), gap = L::load(c.gap + k);
    const auto ddx = L::sub(dbx, dax), ddy = L::sub(dby, day);
    const auto sideways = L::abs(L::sub(L::mul(nx, ddy), L::mul(ny, ddx)));
    auto stale = L::less(refresh, sideways);
    if constexpr (Bounce) stale = L::select_sign(settled, zero, stale);
    if (L::bits(stale)) refresh_normals<L, M>(b, c, p, k, stale, ddx, ddy, nx, ny, gap);
    const auto s = L::add(gap, L::add(L::mul(nx, ddx), L::mul(ny, ddy)));
    const auto apart = L::less(zero, s);
    auto bias = L::select(apart, L::mul(s, inv_h), L::max(L::mul(s, rate), push));
    auto mass_scale = L::select(apart, one, soft_mass);
    auto impulse_scale = L::select(apart, zero, soft_impulse);
    typename L::F vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    const auto vn = L::add(L::mul(nx, L::sub(vbx, vax)), L::mul(ny, L::sub(vby, vay)));
    if constexpr (Bounce) {
      typename L::F target;
      const auto hit = bouncing<L>(b, c, p, k, nx, ny, s, target);
      bias = L::select(hit, L::min(target, bias), bias);
      mass_scale = L::select(hit, one, mass_scale);
      impulse_scale = L::select(hit, zero, impulse_scale);
    }
    const auto m = M == Model::plain ? half : L::load(c.mass + k);
    const auto dl = L::add(L::mul(m, L::add(L::mul(mass_scale, vn), bias)),
                           L::mul(impulse_scale, l));
    auto next = L::max(L::sub(l, dl), zero);
    if (L::bits(L::both(apart, L::less(zero, next)))) {
      const auto vt = L::sub(L::mul(nx, L::sub(vby, vay)), L::mul(ny, L::sub(vbx, vax)));
      const auto past = L::both(apart, passing<L>(s, L::load(c.rsum + k), vn, vt));
      next = L::select(past, zero, next);
    }
    if constexpr (Bounce) next = L::select_sign(settled, zero, next);
    const auto change = L::sub(next, l);
    next = L::select(L::both(apart, L::less_equal(next, zero)), open, next);
    if constexpr (Bounce) next = L::select_sign(settled, open, next);
    L::store(c.impulse + k, next);
    const auto moved = L::differ(change, zero);
    if (!L::bits(moved)) continue;
    push_apart<L, M>(b, c, k, moved, L::mul(change, nx), L::mul(change, ny), vax, vay, vbx, vby);
  }
}

/// The relax pass: takes the push-out velocity away again (rigid, no bias) and applies friction,
///   vt = t.(vB - vA) - uB - uA,  dt = -mt vt,  |t'| <= mu l',  t = (-ny, nx), u = omega r.
/// What an impact with restitution adds is not carried into the next substep: it is left in `start`
/// for spend_contacts.
template <class L, Model M, bool Bounce>
void relax_contacts(const BodyView& b, const ContactView& c, const ContactParams& p,
                    std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1(0), half = L::set1(0.5f);
  constexpr std::uint32_t kAll = (1u << L::width) - 1;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    const auto l = L::load(c.impulse + k);
    typename L::F t{};
    if constexpr (M == Model::rough) t = L::load(c.friction + k);
    if (L::bits(l) == kAll) {  // all open, and nothing to take back
      auto left = L::differ(l, zero);
      if constexpr (M == Model::rough) left = L::either(left, L::differ(t, zero));
      if (!L::bits(left)) {
        if constexpr (M == Model::rough) L::store(c.friction + k, zero);
        if constexpr (Bounce) L::store(c.start + k, zero);
        continue;
      }
    }
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    typename L::F vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    const auto rx = L::sub(vbx, vax), ry = L::sub(vby, vay);
    auto vn = L::add(L::mul(nx, rx), L::mul(ny, ry));
    typename L::F was{};
    if constexpr (Bounce) {
      typename L::F target;
      const auto hit = bouncing<L>(b, c, p, k, nx, ny, L::set1(-1e30f), target);
      was = L::both(hit, L::less(zero, l));
      vn = L::add(vn, L::select(was, target, zero));
    }
    const auto m = M == Model::plain ? half : L::load(c.mass + k);
    const auto next = L::select_sign(l, l, L::max(L::sub(l, L::mul(m, vn)), zero));
    L::store(c.impulse + k, next);
    const auto change = L::sub(next, l);
    auto px = L::mul(change, nx), py = L::mul(change, ny);
    auto moved = L::differ(change, zero);
    if constexpr (M == Model::rough) {
      const auto ua = L::template gather1<2>(b.spin, slot);
      const auto ub = L::template gather1<2>(b.spin, slot + 1);
      const auto vt = L::sub(L::sub(L::sub(L::mul(nx, ry), L::mul(ny, rx)), ub), ua);
      const auto cap = L::mul(L::load(c.mu + k), L::max(next, zero));
      const auto wish = L::sub(t, L::mul(L::load(c.tmass + k), vt));
      const auto kept = L::select_sign(l, zero, L::max(L::min(wish, cap), L::negate(cap)));
      const auto dt = L::sub(kept, t);
      L::store(c.friction + k, kept);
      px = L::sub(px, L::mul(dt, ny));
      py = L::add(py, L::mul(dt, nx));
      moved = L::either(moved, L::differ(dt, zero));
      turn_apart<L>(b, c, k, dt, ua, ub);
    }
    push_apart<L, M>(b, c, k, moved, px, py, vax, vay, vbx, vby);
    if (Bounce && !p.more) {  // with l0 the impulse at the substep's start, min(l, l0) lasts
      const auto lasts = L::min(next, L::max(L::load(c.start + k), zero));
      L::store(c.start + k, L::both(was, L::sub(next, lasts)));
      L::store(c.impulse + k, L::select(was, lasts, next));
    }
  }
}

/// Moves what impacts added to the impulses out of what the next substep repeats, after the relax
/// pass left it in `start`: v0 += w dl n, and friction beyond mu times the lasting impulse likewise.
template <class L, Model M>
void spend_contacts(const BodyView& b, const ContactView& c, const ContactParams&,
                    std::uint32_t begin, std::uint32_t end) {
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const auto spent = L::load(c.start + k);
    const auto hit = L::less(L::set1(0), spent);
    if (!L::bits(hit)) continue;
    const std::uint32_t* slot = c.body + 2 * k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    auto px = L::mul(spent, nx), py = L::mul(spent, ny);
    if constexpr (M == Model::rough) {
      const auto t = L::load(c.friction + k);
      const auto cap = L::mul(L::load(c.mu + k), L::max(L::load(c.impulse + k), L::set1(0)));
      const auto held = L::max(L::min(t, cap), L::negate(cap));
      const auto rest = L::both(hit, L::sub(t, held));
      L::store(c.friction + k, L::select(hit, held, t));
      px = L::sub(px, L::mul(rest, ny));
      py = L::add(py, L::mul(rest, nx));
      const auto ua = L::template gather1<2>(b.spin0, slot);
      L::template scatter1<2>(b.spin0, slot, L::sub(ua, L::mul(L::load(c.qa + k), rest)));
      const auto ub = L::template gather1<2>(b.spin0, slot + 1);
      L::template scatter1<2>(b.spin0, slot + 1, L::sub(ub, L::mul(L::load(c.qb + k), rest)));
    }
    auto ax = px, ay = py, bx = px, by = py;
    if constexpr (M != Model::plain) {
      const auto wa = L::load(c.wa + k), wb = L::load(c.wb + k);
      ax = L::mul(wa, px), ay = L::mul(wa, py);
      bx = L::mul(wb, px), by = L::mul(wb, py);
    }
    typename L::F vx, vy;
    L::template gather<2>(b.vel0, slot, vx, vy);
    L::template scatter<2>(b.vel0, slot, L::select(hit, L::sub(vx, ax), vx),
                           L::select(hit, L::sub(vy, ay), vy));
    L::template gather<2>(b.vel0, slot + 1, vx, vy);
    L::template scatter<2>(b.vel0, slot + 1, L::select(hit, L::add(vx, bx), vx),
                           L::select(hit, L::add(vy, by), vy));
  }
}

}  // namespace
}  // namespace psim::kernels
