// Passes over contacts between two bodies: prepare, warm start, solve, relax, spend. Blocks of 8 contacts;
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

#include "contact_row.h"

namespace psim::kernels {
namespace {

/// Geometry from lattice positions: n = d/|d|, gap = |d| - rsum, d = (XB - XA) pitch. Coincident
/// centres get n = (0, 1).
template <class L>
void prepare_contacts(const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t begin,
                      std::uint32_t end) {
  const F<L> pitch_x = p.pitch_x, pitch_y = p.pitch_y;
  const F<L> zero = 0, one = 1;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    I<L> ax, ay, bx, by;
    L::template gather_int<2>(b.pos, slot, ax, ay);
    L::template gather_int<2>(b.pos, slot + 1, bx, by);
    const auto dx = to_float(bx - ax) * pitch_x;
    const auto dy = to_float(by - ay) * pitch_y;
    const auto far = sqrt(dx * dx + dy * dy);
    const auto apart = zero < far;
    const auto inverse = one / select(apart, far, one);
    L::store(c.nx + k, dx * inverse);
    L::store(c.ny + k, select(apart, dy * inverse, one));
    L::store(c.gap + k, far - L::load(c.rsum + k));
  }
}

/// vA -= wA (px, py), vB += wB (px, py) in the lanes of `moved`. Subtractions only: adding a zero
/// would turn a velocity of -0 into +0.
template <class L, Model kModel>
PSIM_INLINE inline void push_apart(const BodyView& b, const ContactView& c, std::size_t k, M<L> moved, F<L> px, F<L> py,
                                   F<L> vax, F<L> vay, F<L> vbx, F<L> vby) {
  const std::uint32_t* slot = c.body + 2 * k;
  auto ax = px, ay = py, bx = -px, by = -py;
  if constexpr (kModel != Model::plain) {
    const auto wa = L::load(c.wa + k), wb = L::load(c.wb + k);
    ax = wa * ax, ay = wa * ay;
    bx = wb * bx, by = wb * by;
  }
  L::template scatter<2>(b.vel, slot, vax - keep(moved, ax), vay - keep(moved, ay));
  L::template scatter<2>(b.vel, slot + 1, vbx - keep(moved, bx), vby - keep(moved, by));
}

/// Contact geometry anew where the bodies moved sideways by more than p.refresh since `prepare`:
/// the lanes in `stale` get the normal at their present displacement and a gap that gives the exact
/// separation there. Impulses that the velocities hold along the old normal are turned with it.
template <class L, Model kModel>
PSIM_COLD void refresh_normals(const BodyView& b, const ContactView& c, const ContactParams& p, std::size_t k,
                               M<L> stale, F<L> ddx, F<L> ddy, F<L>& nx, F<L>& ny, F<L>& gap) {
  const std::uint32_t* slot = c.body + 2 * k;
  I<L> ax, ay, bx, by;
  L::template gather_int<2>(b.pos, slot, ax, ay);
  L::template gather_int<2>(b.pos, slot + 1, bx, by);
  const Vec<L> d{to_float(bx - ax) * p.pitch_x + ddx, to_float(by - ay) * p.pitch_y + ddy};
  const auto turned = turn_normal<L, kModel>(c, k, stale, d, {ddx, ddy}, nx, ny, gap);
  F<L> vax, vay, vbx, vby;
  L::template gather<2>(b.vel, slot, vax, vay);
  L::template gather<2>(b.vel, slot + 1, vbx, vby);
  push_apart<L, kModel>(b, c, k, turned.lanes, turned.impulse.x, turned.impulse.y, vax, vay, vbx, vby);
}

/// The rim speeds alike: uA -= qA dt, uB -= qB dt.
template <class L>
PSIM_INLINE inline void turn_apart(const BodyView& b, const ContactView& c, std::size_t k, F<L> dt, F<L> ua, F<L> ub) {
  const std::uint32_t* slot = c.body + 2 * k;
  const auto turned = dt != 0;
  const auto da = L::load(c.qa + k) * dt, db = L::load(c.qb + k) * dt;
  L::template scatter1<2>(b.rim_speed, slot, ua - keep(turned, da));
  L::template scatter1<2>(b.rim_speed, slot + 1, ub - keep(turned, db));
}

/// v += w l n for the impulses of the last substep, scaled by p.warm.
template <class L, Model kModel>
void warm_contacts(const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t begin,
                   std::uint32_t end) {
  const F<L> warm = p.warm;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto l = L::load(c.impulse + k) * warm;
    L::store(c.impulse + k, l);
    auto px = l * nx, py = l * ny;
    auto moved = l != 0;
    F<L> t{};
    if constexpr (kModel == Model::rough) {
      t = L::load(c.friction + k) * warm;
      L::store(c.friction + k, t);
      px = px - t * ny;
      py = py + t * nx;
      moved = moved | (t != 0);
    }
    if (!any(moved)) continue;
    F<L> vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    if constexpr (kModel == Model::rough) {
      const auto ua = L::template gather1<2>(b.rim_speed, slot);
      const auto ub = L::template gather1<2>(b.rim_speed, slot + 1);
      turn_apart<L>(b, c, k, t, ua, ub);
    }
    push_apart<L, kModel>(b, c, k, moved, px, py, vax, vay, vbx, vby);
  }
}

/// The approach of the two bodies before the kick.
template <class L>
PSIM_INLINE inline F<L> approach_before(const BodyView& b, const ContactView& c, std::size_t k, F<L> nx, F<L> ny) {
  const std::uint32_t* slot = c.body + 2 * k;
  F<L> ax, ay, bx, by;
  L::template gather<2>(b.vel0, slot, ax, ay);
  L::template gather<2>(b.vel0, slot + 1, bx, by);
  return nx * (bx - ax) + ny * (by - ay);
}

/// The solve pass: push out softly, or stop the approach of a gap that would close.
template <class L, Model kModel, Bounce kBounce>
void solve_contacts(const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t begin,
                    std::uint32_t end) {
  const F<L> zero = 0, half = 0.5f;
  const Softness<L> soft(p);
  const F<L> refresh = p.refresh, open = -0.0f;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    const auto l = L::load(c.impulse + k);
    typename L::Signs settled{};
    if constexpr (kBounce != Bounce::none) {
      settled = negative(L::load(c.impact + k));
      if (all(settled) && !any(l != zero)) {  // settled, nothing to take back
        if constexpr (kBounce == Bounce::edge) L::store(c.start + k, open);
        L::store(c.impulse + k, open);
        continue;
      }
    }
    F<L> dax, day, dbx, dby;
    L::template gather<2>(b.disp, slot, dax, day);
    L::template gather<2>(b.disp, slot + 1, dbx, dby);
    auto nx = L::load(c.nx + k), ny = L::load(c.ny + k), gap = L::load(c.gap + k);
    const auto ddx = dbx - dax, ddy = dby - day;
    const auto sideways = abs(nx * ddy - ny * ddx);
    auto stale = refresh < sideways;
    if constexpr (kBounce != Bounce::none) stale = select(settled, L::none(), stale);
    if (any(stale)) refresh_normals<L, kModel>(b, c, p, k, stale, ddx, ddy, nx, ny, gap);
    const auto s = gap + (nx * ddx + ny * ddy);
    auto aim = aim_of<L>(soft, s);
    F<L> vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    const auto vn = nx * (vbx - vax) + ny * (vby - vay);
    if constexpr (kBounce != Bounce::none) {
      const auto impacts = impacts_of<L>(L::load(c.e + k), approach_before<L>(b, c, k, nx, ny), s, p);
      aim_at_bounce<L>(aim, impacts);
      if constexpr (kBounce == Bounce::edge) {
        L::store(c.start + k, start_of<L>(l, select(settled, L::none(), impacts.may)));
      }
    }
    const auto m = kModel == Model::plain ? half : L::load(c.mass + k);
    const auto dl = m * (aim.mass * vn + aim.bias) + aim.impulse * l;
    auto next = max(l - dl, zero);
    if (any(aim.apart & (zero < next))) {
      const auto vt = nx * (vby - vay) - ny * (vbx - vax);
      const auto past = aim.apart & passing<L>(s, L::load(c.rsum + k), vn, vt);
      next = select(past, zero, next);
    }
    if constexpr (kBounce != Bounce::none) next = select(settled, zero, next);
    const auto change = next - l;
    next = select(aim.apart & (next <= zero), open, next);
    if constexpr (kBounce != Bounce::none) next = select(settled, open, next);
    L::store(c.impulse + k, next);
    const auto moved = change != zero;
    if (!any(moved)) continue;
    push_apart<L, kModel>(b, c, k, moved, change * nx, change * ny, vax, vay, vbx, vby);
  }
}

/// The relax pass: takes the push-out velocity away again (rigid, no bias) and applies friction,
///   vt = t.(vB - vA) - uB - uA,  dt = -mt vt,  |t'| <= mu l',  t = (-ny, nx), u = omega r.
/// What an impact with restitution adds is not carried into the next substep: it is left in `start`
/// for spend_contacts.
template <class L, Model kModel, Bounce kBounce>
void relax_contacts(const BodyView& b, const ContactView& c, const ContactParams&, std::uint32_t begin,
                    std::uint32_t end) {
  const F<L> zero = 0, half = 0.5f;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + 2 * k;
    const auto l = L::load(c.impulse + k);
    F<L> t{};
    if constexpr (kModel == Model::rough) t = L::load(c.friction + k);
    if (all(negative(l))) {  // all open, and nothing to take back
      auto left = l != zero;
      if constexpr (kModel == Model::rough) left = left | (t != zero);
      if (!any(left)) {
        if constexpr (kModel == Model::rough) L::store(c.friction + k, zero);
        if constexpr (kBounce == Bounce::edge) L::store(c.start + k, zero);
        continue;
      }
    }
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    F<L> vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    const auto rx = vbx - vax, ry = vby - vay;
    auto vn = nx * rx + ny * ry;
    M<L> was{};
    if constexpr (kBounce != Bounce::none) {
      was = struck<L>(L::load(c.start + k), l);
      if (any(was)) vn = vn + keep(was, rebound<L>(L::load(c.e + k), approach_before<L>(b, c, k, nx, ny)));
    }
    const auto m = kModel == Model::plain ? half : L::load(c.mass + k);
    const auto next = select(negative(l), l, max(l - m * vn, zero));
    L::store(c.impulse + k, next);
    const auto change = next - l;
    auto px = change * nx, py = change * ny;
    auto moved = change != zero;
    if constexpr (kModel == Model::rough) {
      const auto ua = L::template gather1<2>(b.rim_speed, slot);
      const auto ub = L::template gather1<2>(b.rim_speed, slot + 1);
      const auto vt = nx * ry - ny * rx - ub - ua;
      const auto wish = t - L::load(c.tmass + k) * vt;
      const auto kept = select(negative(l), zero, within_cone<L>(wish, L::load(c.mu + k), next));
      const auto dt = kept - t;
      L::store(c.friction + k, kept);
      px = px - dt * ny;
      py = py + dt * nx;
      moved = moved | (dt != zero);
      turn_apart<L>(b, c, k, dt, ua, ub);
    }
    push_apart<L, kModel>(b, c, k, moved, px, py, vax, vay, vbx, vby);
    if constexpr (kBounce == Bounce::edge) part_impact<L>(c, k, was, next);
  }
}

/// Moves what impacts added to the impulses out of what the next substep repeats, after the relax
/// pass left it in `start`: v0 += w dl n, and friction beyond mu times the lasting impulse likewise.
template <class L, Model kModel>
void spend_contacts(const BodyView& b, const ContactView& c, const ContactParams& p, std::uint32_t begin,
                    std::uint32_t end) {
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const auto spent = L::load(c.start + k);
    if (!any(0 < spent)) continue;
    const std::uint32_t* slot = c.body + 2 * k;
    F<L> vax, vay, vbx, vby;
    L::template gather<2>(b.vel, slot, vax, vay);
    L::template gather<2>(b.vel, slot + 1, vbx, vby);
    F<L> dax, day, dbx, dby;
    L::template gather<2>(b.disp, slot, dax, day);
    L::template gather<2>(b.disp, slot + 1, dbx, dby);
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto vn = nx * (vbx - vax) + ny * (vby - vay);
    const auto s = L::load(c.gap + k) + (nx * (dbx - dax) + ny * (dby - day));
    const auto hit = parted<L>(c.impulse + k, p, spent, vn, s);
    F<L> rest{};
    const auto [px, py] = spent_impulse<L, kModel>(c, k, spent, hit, rest);
    if constexpr (kModel == Model::rough) {
      const auto ua = L::template gather1<2>(b.rim_speed0, slot);
      L::template scatter1<2>(b.rim_speed0, slot, ua - L::load(c.qa + k) * rest);
      const auto ub = L::template gather1<2>(b.rim_speed0, slot + 1);
      L::template scatter1<2>(b.rim_speed0, slot + 1, ub - L::load(c.qb + k) * rest);
    }
    auto ax = px, ay = py, bx = px, by = py;
    if constexpr (kModel != Model::plain) {
      const auto wa = L::load(c.wa + k), wb = L::load(c.wb + k);
      ax = wa * px, ay = wa * py;
      bx = wb * px, by = wb * py;
    }
    F<L> vx, vy;
    L::template gather<2>(b.vel0, slot, vx, vy);
    L::template scatter<2>(b.vel0, slot, select(hit, vx - ax, vx), select(hit, vy - ay, vy));
    L::template gather<2>(b.vel0, slot + 1, vx, vy);
    L::template scatter<2>(b.vel0, slot + 1, select(hit, vx + bx, vx), select(hit, vy + by, vy));
  }
}

}  // namespace
}  // namespace psim::kernels
