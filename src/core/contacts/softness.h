// How soft contacts with fixed geometry are, compared with contacts of two moving bodies.
#pragma once

namespace psim {

/// The frequency of a contact with fixed geometry over that of a contact of two moving bodies.
inline constexpr double kFixedStiffness = 2;

/// A body that sleeps is fixed geometry, but its overlaps come from the softer contacts of moving bodies. A load that
/// balances an overlap s between two moving bodies of inverse masses wa and wb balances the overlap yield(wa, wb) s if
/// A is fixed. This follows from l = -h omega^2 s / (wa + wb), where h is the substep.
inline float yield_of_sleeper(float wa, float wb) {
  return wb / (wa + wb) / static_cast<float>(kFixedStiffness * kFixedStiffness);
}

}  // namespace psim
