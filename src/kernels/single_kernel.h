// Passes over contacts of one body with fixed geometry (walls, segments, static discs): the same
// equations as contact_kernel.h with A fixed; the normal points to the body.
//   s = gap + n.d,  vn = n.v,  v += w l n,  vt = t.v - u,  t = (-ny, nx)
#pragma once

#include <limits>

#include "contact_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

template <class L, Model M>
void warm_singles(const BodyView& b, const SingleView& c, const ContactParams& p,
                  std::uint32_t begin, std::uint32_t end) {
  const auto warm = L::set1(p.warm);
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto l = L::mul(L::load(c.impulse + k), warm);
    L::store(c.impulse + k, l);
    auto px = L::mul(l, nx), py = L::mul(l, ny);
    if constexpr (M == Model::rough) {
      const auto t = L::mul(L::load(c.friction + k), warm);
      L::store(c.friction + k, t);
      px = L::sub(px, L::mul(t, ny));
      py = L::add(py, L::mul(t, nx));
      const auto u = L::template gather1<1>(b.spin, slot);
      L::template scatter1<1>(b.spin, slot, L::sub(u, L::mul(L::load(c.qb + k), t)));
    }
    if constexpr (M != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = L::mul(w, px), py = L::mul(w, py);
    }
    typename L::F vx, vy;
    L::template gather<1>(b.vel, slot, vx, vy);
    L::template scatter<1>(b.vel, slot, L::add(vx, px), L::add(vy, py));
  }
}

/// As refresh_normals of contact_kernel.h, for round fixed shapes; (vx, vy) are the body's velocity.
template <class L, Model M>
[[gnu::cold, gnu::noinline]] void refresh_single(const SingleView& c, std::size_t k, typename L::F stale, typename L::F dx,
                    typename L::F dy, typename L::F& nx, typename L::F& ny, typename L::F& gap,
                    typename L::F& vx, typename L::F& vy) {
  const auto x = L::add(L::load(c.base_x + k), dx), y = L::add(L::load(c.base_y + k), dy);
  const auto far = L::sqrt(L::add(L::mul(x, x), L::mul(y, y)));
  const auto use = L::both(stale, L::less(L::set1(0), far));
  const auto inverse = L::div(L::set1(1), L::select(use, far, L::set1(1)));
  const auto was_x = nx, was_y = ny;
  nx = L::select(use, L::mul(x, inverse), nx);
  ny = L::select(use, L::mul(y, inverse), ny);
  const auto along = L::add(L::mul(nx, dx), L::mul(ny, dy));
  gap = L::select(use, L::sub(L::sub(far, L::load(c.rsum + k)), along), gap);
  L::store(c.nx + k, nx);
  L::store(c.ny + k, ny);
  L::store(c.gap + k, gap);
  const auto l = L::load(c.impulse + k);
  const auto turn_x = L::sub(was_x, nx), turn_y = L::sub(was_y, ny);
  auto px = L::mul(l, turn_x), py = L::mul(l, turn_y);
  auto held = L::differ(l, L::set1(0));
  if constexpr (M == Model::rough) {
    const auto t = L::load(c.friction + k);
    px = L::sub(px, L::mul(t, turn_y));
    py = L::add(py, L::mul(t, turn_x));
    held = L::either(held, L::differ(t, L::set1(0)));
  }
  if constexpr (M != Model::plain) {
    const auto w = L::load(c.wb + k);
    px = L::mul(w, px), py = L::mul(w, py);
  }
  const auto turned = L::both(use, held);
  vx = L::sub(vx, L::both(turned, px));
  vy = L::sub(vy, L::both(turned, py));
}

template <class L>
[[gnu::always_inline]] inline typename L::F bouncing_single(const BodyView& b, const SingleView& c, const ContactParams& p,
                              std::size_t k, typename L::F nx, typename L::F ny, typename L::F s,
                              typename L::F& target) {
  typename L::F x, y;
  L::template gather<1>(b.vel0, c.body + k, x, y);
  const auto vn0 = L::add(L::mul(nx, x), L::mul(ny, y));
  target = L::mul(L::load(c.e + k), vn0);
  const auto fast = L::less(vn0, L::set1(-p.impact_floor));
  const auto near = L::less(L::add(s, L::mul(vn0, L::set1(p.h))), L::set1(0));
  return L::both(L::both(fast, near), L::less(L::set1(0), L::load(c.e + k)));
}

template <class L, Model M, bool Bounce>
void solve_singles(const BodyView& b, const SingleView& c, const ContactParams& p,
                   std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1(0), one = L::set1(1);
  const auto inv_h = L::set1(p.inv_h), rate = L::set1(p.soft_rate), push = L::set1(-p.push);
  const auto soft_mass = L::set1(p.soft_mass), soft_impulse = L::set1(p.soft_impulse);
  const auto open = L::set1(-0.0f);
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + k;
    typename L::F dx, dy, vx, vy;
    L::template gather<1>(b.disp, slot, dx, dy);
    L::template gather<1>(b.vel, slot, vx, vy);
    auto nx = L::load(c.nx + k), ny = L::load(c.ny + k), gap = L::load(c.gap + k);
    const auto sideways = L::abs(L::sub(L::mul(nx, dy), L::mul(ny, dx)));
    const auto stale = L::less(L::load(c.refresh + k), sideways);
    if (L::bits(stale)) refresh_single<L, M>(c, k, stale, dx, dy, nx, ny, gap, vx, vy);
    const auto s = L::add(gap, L::add(L::mul(nx, dx), L::mul(ny, dy)));
    const auto apart = L::less(zero, s);
    auto bias = L::select(apart, L::mul(s, inv_h), L::max(L::mul(s, rate), push));
    auto mass_scale = L::select(apart, one, soft_mass);
    auto impulse_scale = L::select(apart, zero, soft_impulse);
    const auto l = L::load(c.impulse + k);
    const auto vn = L::add(L::mul(nx, vx), L::mul(ny, vy));
    typename L::F settled{};
    if constexpr (Bounce) {
      typename L::F target;
      const auto hit = bouncing_single<L>(b, c, p, k, nx, ny, s, target);
      bias = L::select(hit, L::min(target, bias), bias);
      mass_scale = L::select(hit, one, mass_scale);
      impulse_scale = L::select(hit, zero, impulse_scale);
      settled = L::load(c.impact + k);
      if (!p.again) L::store(c.start + k, l);
    }
    const auto m = M == Model::plain ? one : L::load(c.mass + k);
    const auto dl = L::add(L::mul(m, L::add(L::mul(mass_scale, vn), bias)),
                           L::mul(impulse_scale, l));
    auto next = L::max(L::sub(l, dl), zero);
    if (L::bits(L::both(apart, L::less(zero, next)))) {
      const auto vt = L::sub(L::mul(nx, vy), L::mul(ny, vx));
      const auto round = L::less(L::load(c.refresh + k), L::set1(std::numeric_limits<float>::infinity()));
      const auto past = L::both(apart, passing<L>(s, L::load(c.rsum + k), vn, vt));
      next = L::select(L::both(round, past), zero, next);
    }
    if constexpr (Bounce) next = L::select_sign(settled, zero, next);
    const auto change = L::sub(next, l);
    next = L::select(L::both(apart, L::less_equal(next, zero)), open, next);
    if constexpr (Bounce) next = L::select_sign(settled, open, next);
    L::store(c.impulse + k, next);
    auto px = L::mul(change, nx), py = L::mul(change, ny);
    if constexpr (M != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = L::mul(w, px), py = L::mul(w, py);
    }
    L::template scatter<1>(b.vel, slot, L::add(vx, px), L::add(vy, py));
  }
}

template <class L, Model M, bool Bounce>
void relax_singles(const BodyView& b, const SingleView& c, const ContactParams& p,
                   std::uint32_t begin, std::uint32_t end) {
  const auto zero = L::set1(0), one = L::set1(1);
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const std::uint32_t* slot = c.body + k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto l = L::load(c.impulse + k);
    typename L::F vx, vy;
    L::template gather<1>(b.vel, slot, vx, vy);
    auto vn = L::add(L::mul(nx, vx), L::mul(ny, vy));
    typename L::F was{};
    if constexpr (Bounce) {
      typename L::F target;
      const auto hit = bouncing_single<L>(b, c, p, k, nx, ny, L::set1(-1e30f), target);
      was = L::both(hit, L::less(zero, l));
      vn = L::add(vn, L::select(was, target, zero));
    }
    const auto m = M == Model::plain ? one : L::load(c.mass + k);
    const auto next = L::select_sign(l, l, L::max(L::sub(l, L::mul(m, vn)), zero));
    L::store(c.impulse + k, next);
    const auto change = L::sub(next, l);
    auto px = L::mul(change, nx), py = L::mul(change, ny);
    if constexpr (M == Model::rough) {
      const auto u = L::template gather1<1>(b.spin, slot);
      const auto vt = L::sub(L::sub(L::mul(nx, vy), L::mul(ny, vx)), u);
      const auto cap = L::mul(L::load(c.mu + k), L::max(next, zero));
      const auto t = L::load(c.friction + k);
      const auto wish = L::sub(t, L::mul(L::load(c.tmass + k), vt));
      const auto kept = L::max(L::min(wish, cap), L::negate(cap));
      const auto dt = L::sub(kept, t);
      L::store(c.friction + k, kept);
      px = L::sub(px, L::mul(dt, ny));
      py = L::add(py, L::mul(dt, nx));
      L::template scatter1<1>(b.spin, slot, L::sub(u, L::mul(L::load(c.qb + k), dt)));
    }
    if constexpr (M != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = L::mul(w, px), py = L::mul(w, py);
    }
    L::template scatter<1>(b.vel, slot, L::add(vx, px), L::add(vy, py));
    if (Bounce && !p.more) {  // with l0 the impulse at the substep's start, min(l, l0) lasts
      const auto lasts = L::min(next, L::max(L::load(c.start + k), zero));
      L::store(c.start + k, L::both(was, L::sub(next, lasts)));
      L::store(c.impulse + k, L::select(was, lasts, next));
    }
  }
}

/// As spend_contacts.
template <class L, Model M>
void spend_singles(const BodyView& b, const SingleView& c, const ContactParams&,
                   std::uint32_t begin, std::uint32_t end) {
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock;
       k < static_cast<std::size_t>(end) * kBlock; k += L::width) {
    const auto spent = L::load(c.start + k);
    const auto hit = L::less(L::set1(0), spent);
    if (!L::bits(hit)) continue;
    const std::uint32_t* slot = c.body + k;
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
      const auto u = L::template gather1<1>(b.spin0, slot);
      L::template scatter1<1>(b.spin0, slot, L::sub(u, L::mul(L::load(c.qb + k), rest)));
    }
    if constexpr (M != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = L::mul(w, px), py = L::mul(w, py);
    }
    typename L::F vx, vy;
    L::template gather<1>(b.vel0, slot, vx, vy);
    L::template scatter<1>(b.vel0, slot, L::select(hit, L::add(vx, px), vx),
                           L::select(hit, L::add(vy, py), vy));
  }
}

}  // namespace
}  // namespace psim::kernels
