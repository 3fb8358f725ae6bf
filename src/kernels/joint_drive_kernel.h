// A row with two ends and a motor (`Drive`): the angle of a pin, the way along a slide's axis. The kind
// of joint says how fast the row moves and what an impulse in it does.
#pragma once

#include "joint_kernel_common.h"

namespace psim::kernels {
namespace {

/// Where the impulse of a row with two ends goes: as near to 0 as keeps lower <= x <= upper at the
/// substep's end; an end that is passed pushes back.
template <class L>
[[gnu::always_inline]] inline F<L> limited(const Drive& d, std::uint32_t k, F<L> x, F<L> v,
                                           F<L> mass, F<L> inv_h) {
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
[[gnu::always_inline]] inline F<L> limited_rigid(const Drive& d, std::uint32_t k, F<L> v,
                                                 F<L> mass) {
  const auto zero = L::set1(0), l = L::load(d.limit_l + k);
  const auto next = L::sub(l, L::mul(mass, v));
  const auto locked = L::less_equal(L::load(d.upper + k), L::load(d.lower + k));
  const auto pushed = L::select(L::less(zero, l), L::max(next, zero), L::min(next, zero));
  return L::select(locked, next, L::both(L::differ(l, zero), pushed));
}

template <class L>
[[gnu::always_inline]] inline F<L> motored(const Drive& d, std::uint32_t k, F<L> v, F<L> mass) {
  const auto most = L::load(d.most + k);
  const auto next = L::sub(L::load(d.motor_l + k), L::mul(mass, L::sub(v, L::load(d.speed + k))));
  return L::max(L::min(next, most), L::negate(most));
}

/// The motor, then the ends, of a row at x[k]: speed() is its velocity, push(dl) adds an impulse.
template <class L, bool kRelax, class Speed, class Push>
[[gnu::always_inline]] inline void drive_row(Drive& d, std::uint32_t k, const float* x, F<L> mass,
                                             F<L> inv_h, const Speed& speed, const Push& push) {
  const auto motor = motored<L>(d, k, speed(), mass);
  push(L::sub(motor, L::load(d.motor_l + k)));
  L::store(d.motor_l + k, motor);
  const auto limit = kRelax ? limited_rigid<L>(d, k, speed(), mass)
                            : limited<L>(d, k, L::load(x + k), speed(), mass, inv_h);
  push(L::sub(limit, L::load(d.limit_l + k)));
  L::store(d.limit_l + k, limit);
}

/// Sum of the impulses.
template <class L>
[[gnu::always_inline]] inline F<L> driven_impulse(const Drive& d, std::uint32_t k) {
  return L::add(L::load(d.limit_l + k), L::load(d.motor_l + k));
}

/// And of the stored ones times a factor, which are kept.
template <class L>
[[gnu::always_inline]] inline F<L> warm_drive(Drive& d, std::uint32_t k, F<L> warm) {
  L::store(d.limit_l + k, L::mul(warm, L::load(d.limit_l + k)));
  L::store(d.motor_l + k, L::mul(warm, L::load(d.motor_l + k)));
  return driven_impulse<L>(d, k);
}

/// Impulse of the push pass, for a row at x with velocity v: only beyond the ends.
template <class L>
[[gnu::always_inline]] inline F<L> push_back(const Drive& d, std::uint32_t k, F<L> x, F<L> v,
                                             F<L> mass, F<L> rate) {
  const auto zero = L::set1(0);
  const auto under = L::min(L::sub(x, L::load(d.lower + k)), zero);
  const auto beyond = L::add(under, L::max(L::sub(x, L::load(d.upper + k)), zero));
  const auto wish = L::mul(mass, L::add(v, L::mul(rate, beyond)));
  return L::negate(L::both(L::differ(beyond, zero), wish));
}

}  // namespace
}  // namespace psim::kernels
