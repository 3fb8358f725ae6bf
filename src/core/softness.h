// How soft contacts with fixed geometry are against those of two moving bodies.
#pragma once

namespace psim {

/// Times the frequency of a contact of two moving bodies.
inline constexpr double kFixedStiffness = 2;

/// A body that sleeps is fixed geometry, but its overlaps were made by soft contacts: where the same load
/// balances an overlap s between two moving bodies of inverse masses wa and wb, it balances yield(wa, wb) s
/// with a fixed A. From l = -h omega^2 s / (wa + wb), h the substep.
inline float yield_of_sleeper(float wa, float wb) {
  return wb / (wa + wb) / static_cast<float>(kFixedStiffness * kFixedStiffness);
}

}  // namespace psim
