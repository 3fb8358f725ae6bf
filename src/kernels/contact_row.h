// The row of one contact, which contacts of two bodies (contact_kernel.h) and contacts with fixed geometry
// (static_contact_kernel.h) share. A View is a ContactView or a StaticContactView: its columns have the same names.
// Notation and sources: contact_kernel.h.
#pragma once

#include "lane_vec.h"
#include "views.h"

namespace psim::kernels {
namespace {

/// The impulse vector l n + t (-ny, nx) of a normal and a tangent impulse.
template <class L>
PSIM_INLINE inline Vec<L> impulse_of(Vec<L> n, F<L> l, F<L> t) {
  return {l * n.x - t * n.y, l * n.y + t * n.x};
}

/// The lanes whose impulses turned with the normal, and the change l (n - n_old) + t (t - t_old) of their impulse.
template <class L>
struct Turned {
  M<L> lanes;
  Vec<L> impulse;
};

/// The normal and the gap anew in the lanes of `stale`. `d` leads from the first centre to the second now, `moved`
/// is the part of it that is displacement since `prepare`: the gap is such that n.moved + gap is exact.
template <class L, Model kModel, class View>
PSIM_INLINE inline Turned<L> turn_normal(const View& c, std::size_t k, M<L> stale, Vec<L> d, Vec<L> moved, F<L>& nx,
                                         F<L>& ny, F<L>& gap) {
  const auto far = sqrt(d.x * d.x + d.y * d.y);
  const auto use = stale & (0 < far);
  const F<L> inverse = 1 / select(use, far, 1);
  const auto was_x = nx, was_y = ny;
  nx = select(use, d.x * inverse, nx);
  ny = select(use, d.y * inverse, ny);
  const auto along = nx * moved.x + ny * moved.y;
  gap = select(use, far - L::load(c.rsum + k) - along, gap);
  L::store(c.nx + k, nx);
  L::store(c.ny + k, ny);
  L::store(c.gap + k, gap);
  const auto l = L::load(c.impulse + k);
  const Vec<L> turn{nx - was_x, ny - was_y};
  if constexpr (kModel == Model::rough) {
    const auto t = L::load(c.friction + k);
    return {use & ((l != 0) | (t != 0)), impulse_of<L>(turn, l, t)};
  }
  return {use & (l != 0), l * turn};
}

/// What to add to vn in an impact: bodies that approached before the kick part with e times that velocity. Bodies that
/// parted may come together again as fast: they would gain energy if they were held together while others fly apart.
template <class L>
PSIM_INLINE inline F<L> rebound(F<L> e, F<L> vn0) {
  return select(F<L>(0) < vn0, vn0, e * vn0);
}

/// Impacts with restitution of bodies that touch.
template <class L>
struct Impacts {
  M<L> may;     ///< before the kick the bodies approached faster than the floor, or parted as fast
  M<L> now;     ///< they parted, or their approach closes the gap within the substep
  F<L> target;  ///< m/s: what to add to vn there
};

/// `vn0`: with what velocity the bodies parted before the kick; `s`: the separation.
template <class L>
PSIM_INLINE inline Impacts<L> impacts_of(F<L> e, F<L> vn0, F<L> s, const ContactParams& p) {
  const F<L> zero = 0;
  const auto meet = (vn0 < -p.impact_floor) & (zero < e), part = p.impact_floor < vn0;
  return {meet | part, part | (meet & (s + vn0 * p.h < zero)), rebound<L>(e, vn0)};
}

/// The bias of a row where an impact is now, from that of the row without it.
template <class L>
PSIM_INLINE inline F<L> impact_bias(const Impacts<L>& impacts, F<L> bias) {
  return select(F<L>(0) < impacts.target, max(impacts.target, bias), min(impacts.target, bias));
}

/// What the solve pass leaves for the relax pass: the impulse at the substep's start, with its sign set where an approach
/// may be no impact.
template <class L>
PSIM_INLINE inline F<L> start_of(F<L> l, M<L> may) {
  const auto start = max(l, 0);
  return select(may, start, -start);
}

/// The lanes that the solve pass left as impacts and that press.
template <class L>
PSIM_INLINE inline M<L> struck(F<L> start, F<L> l) {
  return select(negative(start), L::none(), 0 < l);
}

/// Of pairs apart by s, those that pass each other at their present velocities: the closest point of
/// the path of D = n (s + R) along u stays outside R,
///   (D x u)^2 > R^2 u^2,  that is  vt^2 s (s + 2 R) > R^2 vn^2.
/// A contact stops what crosses its tangent line within the substep; these never touch.
template <class L>
PSIM_INLINE inline M<L> passing(F<L> s, F<L> radius, F<L> vn, F<L> vt) {
  const auto miss = vt * vt * (s * (s + (radius + radius)));
  const auto reach = radius * vn;
  return reach * reach < miss;
}

/// The constants of the soft contact, in registers.
template <class L>
struct Softness {
  explicit Softness(const ContactParams& p)
      : inv_h(p.inv_h), rate(p.soft_rate), push(-p.push), mass(p.soft_mass), impulse(p.soft_impulse) {}
  F<L> inv_h, rate, push, mass, impulse;
};

/// The impulse change of a row in the solve pass is m (mass vn + bias) + impulse l.
template <class L>
struct Aim {
  M<L> apart;
  F<L> bias, mass, impulse;
};

/// For the separation s: the approach of a gap that would close is stopped, an overlap is pushed out softly.
template <class L>
PSIM_INLINE inline Aim<L> aim_of(const Softness<L>& soft, F<L> s) {
  const auto apart = 0 < s;
  return {apart, select(apart, s * soft.inv_h, max(s * soft.rate, soft.push)), select(apart, 1, soft.mass),
          select(apart, 0, soft.impulse)};
}

/// Where an impact is now, the row parts with the velocity `target` instead, rigidly.
template <class L>
PSIM_INLINE inline void aim_at_bounce(Aim<L>& aim, const Impacts<L>& impacts) {
  aim.bias = select(impacts.now, impact_bias<L>(impacts, aim.bias), aim.bias);
  aim.mass = select(impacts.now, 1, aim.mass);
  aim.impulse = select(impacts.now, 0, aim.impulse);
}

/// A friction impulse within the cone: |t'| <= mu l.
template <class L>
PSIM_INLINE inline F<L> within_cone(F<L> t, F<L> mu, F<L> l) {
  const auto cap = mu * max(l, 0);
  return max(min(t, cap), -cap);
}

/// After the last relax pass of a substep: of an impact's impulse l only min(l, l0) lasts, where l0 is the impulse
/// at the substep's start. The rest is left in `start` for the spend pass.
template <class L, class View>
PSIM_INLINE inline void part_impact(const View& c, std::size_t k, M<L> was, F<L> l) {
  const auto lasts = min(l, abs(L::load(c.start + k)));
  L::store(c.start + k, keep(was, l - lasts));
  L::store(c.impulse + k, select(was, lasts, l));
}

/// The lanes with an impulse to be spent, at the end of a substep. Where bodies overlap deeply and still approach, at vn,
/// what was taken for an impact carries a load: it is given back to the impulse and lasts. Else a heap that lands would
/// bounce in each substep, its contacts would never carry, and its bodies would sink into one another.
template <class L>
PSIM_INLINE inline M<L> parted(float* impulse, const ContactParams& p, F<L> spent, F<L> vn, F<L> s) {
  const F<L> zero = 0;
  const auto hit = zero < spent, parts = (zero < vn) | (-F<L>(p.refresh) < s);
  const auto l = L::load(impulse);
  L::store(impulse, select(but_not(hit, parts), l + spent, l));
  return hit & parts;
}

/// The impulse to be spent in the lanes of `hit`, with the friction that is beyond the cone of what lasts; `rest` is
/// that friction.
template <class L, Model kModel, class View>
PSIM_INLINE inline Vec<L> spent_impulse(const View& c, std::size_t k, F<L> spent, M<L> hit, F<L>& rest) {
  const Vec<L> n = load_vec<L>(c.nx, c.ny, k);
  if constexpr (kModel == Model::rough) {
    const auto t = L::load(c.friction + k);
    const auto held = within_cone<L>(t, L::load(c.mu + k), L::load(c.impulse + k));
    rest = keep(hit, t - held);
    L::store(c.friction + k, select(hit, held, t));
    return impulse_of<L>(n, spent, rest);
  }
  return spent * n;
}

}  // namespace
}  // namespace psim::kernels
