// The least sizes of what lasts from one pass to the next. What is smaller is stored as zero, so that nothing decays into
// denormals, which take a CPU a hundred times as long as other numbers; nor are squares of what is left, and its products
// with arms and masses.
#pragma once

#include <math.h>

namespace psim::kernels {

inline constexpr float kLeast = 1e-15f;        ///< m/s of velocities and rims, rad of turns, shares of a radius
inline constexpr float kLeastOffset = 1e-18f;  ///< m of offsets from the lattice; its square is no denormal
inline constexpr float kLeastTime =
    1e-18f;  ///< s into a substep: the earliest impact, since 0 says that there was none

namespace {

/// Zero for |a| <= least, else a float; a NaN stays one.
inline float snapped(float a, float least = kLeast) { return ::fabsf(a) <= least ? 0.0f : a; }
inline float snapped(double a, float least = kLeast) {
  return static_cast<float>(::fabs(a) <= double{least} ? 0.0 : a);
}
/// |a|, or, if that is larger, a size whose square is no denormal.
inline float squarable(float a) {
  const float size = ::fabsf(a);
  return kLeastOffset > size ? kLeastOffset : size;
}

}  // namespace
}  // namespace psim::kernels
