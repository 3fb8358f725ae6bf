// A row with two ends and a motor (`Drive`): the angle of a pin, the way along a slide's axis. The kind
// of joint says how fast the row moves and what an impulse in it does.
#pragma once

#include "joint_kernel_common.h"

namespace psim::kernels {
namespace {

/// The new impulse of a row with two ends: the one nearest to 0 that keeps lower <= x <= upper at the
/// substep's end. An end that is passed pushes back.
template <class L>
PSIM_INLINE inline F<L> limited(const Drive& d, std::uint32_t k, F<L> x, F<L> v, F<L> mass, F<L> inv_h) {
  const F<L> zero = 0, l = L::load(d.limit_l + k);
  const auto over = x - L::load(d.lower + k), under = L::load(d.upper + k) - x;
  const auto low_bias = max(over, zero) * inv_h;
  const auto high_bias = max(under, zero) * inv_h;
  const auto low = l - mass * (v + low_bias);
  const auto high = l - mass * (v - high_bias);
  return max(low, min(zero, high));
}

/// The same for the relax pass, where an end keeps the velocity at 0 as long as it pushes.
template <class L>
PSIM_INLINE inline F<L> limited_rigid(const Drive& d, std::uint32_t k, F<L> v, F<L> mass) {
  const F<L> zero = 0, l = L::load(d.limit_l + k);
  const auto next = l - mass * v;
  const auto locked = L::load(d.upper + k) <= L::load(d.lower + k);
  const auto pushed = select(zero < l, max(next, zero), min(next, zero));
  return select(locked, next, keep(l != zero, pushed));
}

template <class L>
PSIM_INLINE inline F<L> motored(const Drive& d, std::uint32_t k, F<L> v, F<L> mass) {
  const auto most = L::load(d.most + k);
  const auto next = L::load(d.motor_l + k) - mass * (v - L::load(d.speed + k));
  return max(min(next, most), -most);
}

/// The motor, then the ends, of a row at x[k]: speed() is its velocity, push(dl) adds an impulse.
template <class L, bool kRelax, class Speed, class Push>
PSIM_INLINE inline void drive_row(Drive& d, std::uint32_t k, const float* x, F<L> mass, F<L> inv_h, const Speed& speed,
                                  const Push& push) {
  const auto motor = motored<L>(d, k, speed(), mass);
  push(motor - L::load(d.motor_l + k));
  L::store(d.motor_l + k, motor);
  const auto limit =
      kRelax ? limited_rigid<L>(d, k, speed(), mass) : limited<L>(d, k, L::load(x + k), speed(), mass, inv_h);
  push(limit - L::load(d.limit_l + k));
  L::store(d.limit_l + k, limit);
}

/// The sum of the impulses of the ends and of the motor.
template <class L>
PSIM_INLINE inline F<L> driven_impulse(const Drive& d, std::uint32_t k) {
  return L::load(d.limit_l + k) + L::load(d.motor_l + k);
}

/// Scales the stored impulses by a factor and returns their sum.
template <class L>
PSIM_INLINE inline F<L> warm_drive(Drive& d, std::uint32_t k, F<L> warm) {
  L::store(d.limit_l + k, warm * L::load(d.limit_l + k));
  L::store(d.motor_l + k, warm * L::load(d.motor_l + k));
  return driven_impulse<L>(d, k);
}

/// The impulse of the push pass for a row at x with velocity v. It is 0 between the ends.
template <class L>
PSIM_INLINE inline F<L> push_back(const Drive& d, std::uint32_t k, F<L> x, F<L> v, F<L> mass, F<L> rate) {
  const F<L> zero = 0;
  const auto under = min(x - L::load(d.lower + k), zero);
  const auto beyond = under + max(x - L::load(d.upper + k), zero);
  const auto wish = mass * (v + rate * beyond);
  return -keep(beyond != zero, wish);
}

}  // namespace
}  // namespace psim::kernels
