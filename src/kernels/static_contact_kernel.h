// Passes over contacts of one body with fixed geometry (walls, segments, static discs): the same
// equations as contact_kernel.h with A fixed; the normal points to the body.
//   s = gap + n.d,  vn = n.v,  v += w l n,  vt = t.v - u,  t = (-ny, nx)
#pragma once

#include <limits>

#include "contact_kernel.h"
#include "views.h"

namespace psim::kernels {
namespace {

template <class L, Model kModel>
void warm_statics(const BodyView& b, const StaticContactView& c, const ContactParams& p, std::uint32_t begin,
                  std::uint32_t end) {
  const F<L> warm = p.warm;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto l = L::load(c.impulse + k) * warm;
    L::store(c.impulse + k, l);
    auto px = l * nx, py = l * ny;
    if constexpr (kModel == Model::rough) {
      const auto t = L::load(c.friction + k) * warm;
      L::store(c.friction + k, t);
      px = px - t * ny;
      py = py + t * nx;
      const auto u = L::template gather1<1>(b.rim_speed, slot);
      L::template scatter1<1>(b.rim_speed, slot, u - L::load(c.qb + k) * t);
    }
    if constexpr (kModel != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = w * px, py = w * py;
    }
    F<L> vx, vy;
    L::template gather<1>(b.vel, slot, vx, vy);
    L::template scatter<1>(b.vel, slot, vx + px, vy + py);
  }
}

/// As refresh_normals of contact_kernel.h, for round fixed shapes; (vx, vy) are the body's velocity.
template <class L, Model kModel>
PSIM_COLD void refresh_static(const StaticContactView& c, std::size_t k, M<L> stale, F<L> dx, F<L> dy, F<L>& nx,
                              F<L>& ny, F<L>& gap, F<L>& vx, F<L>& vy) {
  const Vec<L> d{L::load(c.base_x + k) + dx, L::load(c.base_y + k) + dy};
  const auto turned = turn_normal<L, kModel>(c, k, stale, d, {dx, dy}, nx, ny, gap);
  auto change = -turned.impulse;
  if constexpr (kModel != Model::plain) change = L::load(c.wb + k) * change;
  vx = vx - keep(turned.lanes, change.x);
  vy = vy - keep(turned.lanes, change.y);
}

template <class L>
PSIM_INLINE inline F<L> approach_before(const BodyView& b, const StaticContactView& c, std::size_t k, F<L> nx,
                                        F<L> ny) {
  F<L> x, y;
  L::template gather<1>(b.vel0, c.body + k, x, y);
  return nx * x + ny * y;
}

template <class L, Model kModel, Bounce kBounce>
void solve_statics(const BodyView& b, const StaticContactView& c, const ContactParams& p, std::uint32_t begin,
                   std::uint32_t end) {
  const F<L> zero = 0, one = 1;
  const Softness<L> soft(p);
  const F<L> open = -0.0f;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + k;
    F<L> dx, dy, vx, vy;
    L::template gather<1>(b.disp, slot, dx, dy);
    L::template gather<1>(b.vel, slot, vx, vy);
    auto nx = L::load(c.nx + k), ny = L::load(c.ny + k), gap = L::load(c.gap + k);
    const auto sideways = abs(nx * dy - ny * dx);
    const auto stale = L::load(c.refresh + k) < sideways;
    if (any(stale)) refresh_static<L, kModel>(c, k, stale, dx, dy, nx, ny, gap, vx, vy);
    const auto s = gap + (nx * dx + ny * dy);
    auto aim = aim_of<L>(soft, s);
    const auto l = L::load(c.impulse + k);
    const auto vn = nx * vx + ny * vy;
    typename L::Signs settled{};
    if constexpr (kBounce != Bounce::none) {
      const auto impacts = impacts_of<L>(L::load(c.e + k), approach_before<L>(b, c, k, nx, ny), s, p);
      aim_at_bounce<L>(aim, impacts);
      settled = negative(L::load(c.impact + k));
      if constexpr (kBounce == Bounce::edge) L::store(c.start + k, start_of<L>(l, impacts.may));
    }
    const auto m = kModel == Model::plain ? one : L::load(c.mass + k);
    const auto dl = m * (aim.mass * vn + aim.bias) + aim.impulse * l;
    auto next = max(l - dl, zero);
    if (any(aim.apart & (zero < next))) {
      const auto vt = nx * vy - ny * vx;
      const auto round = L::load(c.refresh + k) < (std::numeric_limits<float>::infinity());
      const auto past = aim.apart & passing<L>(s, L::load(c.rsum + k), vn, vt);
      next = select(round & past, zero, next);
    }
    if constexpr (kBounce != Bounce::none) next = select(settled, zero, next);
    const auto change = next - l;
    next = select(aim.apart & (next <= zero), open, next);
    if constexpr (kBounce != Bounce::none) next = select(settled, open, next);
    L::store(c.impulse + k, next);
    auto px = change * nx, py = change * ny;
    if constexpr (kModel != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = w * px, py = w * py;
    }
    L::template scatter<1>(b.vel, slot, vx + px, vy + py);
  }
}

template <class L, Model kModel, Bounce kBounce>
void relax_statics(const BodyView& b, const StaticContactView& c, const ContactParams&, std::uint32_t begin,
                   std::uint32_t end) {
  const F<L> zero = 0, one = 1;
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const std::uint32_t* slot = c.body + k;
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto l = L::load(c.impulse + k);
    F<L> vx, vy;
    L::template gather<1>(b.vel, slot, vx, vy);
    auto vn = nx * vx + ny * vy;
    M<L> was{};
    if constexpr (kBounce != Bounce::none) {
      was = struck<L>(L::load(c.start + k), l);
      if (any(was)) vn = vn + keep(was, rebound<L>(L::load(c.e + k), approach_before<L>(b, c, k, nx, ny)));
    }
    const auto m = kModel == Model::plain ? one : L::load(c.mass + k);
    const auto next = select(negative(l), l, max(l - m * vn, zero));
    L::store(c.impulse + k, next);
    const auto change = next - l;
    auto px = change * nx, py = change * ny;
    if constexpr (kModel == Model::rough) {
      const auto u = L::template gather1<1>(b.rim_speed, slot);
      const auto vt = nx * vy - ny * vx - u;
      const auto t = L::load(c.friction + k);
      const auto wish = t - L::load(c.tmass + k) * vt;
      const auto kept = within_cone<L>(wish, L::load(c.mu + k), next);
      const auto dt = kept - t;
      L::store(c.friction + k, kept);
      px = px - dt * ny;
      py = py + dt * nx;
      L::template scatter1<1>(b.rim_speed, slot, u - L::load(c.qb + k) * dt);
    }
    if constexpr (kModel != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = w * px, py = w * py;
    }
    L::template scatter<1>(b.vel, slot, vx + px, vy + py);
    if constexpr (kBounce == Bounce::edge) part_impact<L>(c, k, was, next);
  }
}

/// Does what spend_contacts does, for fixed geometry.
template <class L, Model kModel>
void spend_statics(const BodyView& b, const StaticContactView& c, const ContactParams& p, std::uint32_t begin,
                   std::uint32_t end) {
  for (std::size_t k = static_cast<std::size_t>(begin) * kBlock; k < static_cast<std::size_t>(end) * kBlock;
       k += L::width) {
    const auto spent = L::load(c.start + k);
    if (!any(0 < spent)) continue;
    const std::uint32_t* slot = c.body + k;
    F<L> wx, wy;
    L::template gather<1>(b.vel, slot, wx, wy);
    F<L> dx, dy;
    L::template gather<1>(b.disp, slot, dx, dy);
    const auto nx = L::load(c.nx + k), ny = L::load(c.ny + k);
    const auto hit = parted<L>(c.impulse + k, p, spent, nx * wx + ny * wy, L::load(c.gap + k) + (nx * dx + ny * dy));
    F<L> rest{};
    auto [px, py] = spent_impulse<L, kModel>(c, k, spent, hit, rest);
    if constexpr (kModel == Model::rough) {
      const auto u = L::template gather1<1>(b.rim_speed0, slot);
      L::template scatter1<1>(b.rim_speed0, slot, u - L::load(c.qb + k) * rest);
    }
    if constexpr (kModel != Model::plain) {
      const auto w = L::load(c.wb + k);
      px = w * px, py = w * py;
    }
    F<L> vx, vy;
    L::template gather<1>(b.vel0, slot, vx, vy);
    L::template scatter<1>(b.vel0, slot, select(hit, vx + px, vx), select(hit, vy + py, vy));
  }
}

}  // namespace
}  // namespace psim::kernels
