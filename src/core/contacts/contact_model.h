// What all contacts have in common: the variant of the kernels that a scene needs, and how soft contacts with fixed
// geometry are. The plan chooses the variant; the contact store lays its columns out by it.
#pragma once

#include "views.h"

namespace psim {

/// m: the gap of a contact in place of which another one counts, and of a point that a manifold does not have.
constexpr float kNoGap = 1e6f;

/// The columns that contacts have. A column that the model does not read owns no memory.
struct ContactModel {
  kernels::Model model = kernels::Model::plain;
  bool bounce = false;
  bool massed() const { return model != kernels::Model::plain; }
  bool rough() const { return model == kernels::Model::rough; }
  friend bool operator==(const ContactModel&, const ContactModel&) = default;
};

/// The frequency of a contact with fixed geometry over that of a contact of two moving bodies.
inline constexpr double kFixedStiffness = 2;

/// A body that sleeps is fixed geometry, but its overlaps come from the softer contacts of moving bodies. A load that
/// balances an overlap s between two moving bodies of inverse masses wa and wb balances the overlap yield(wa, wb) s if
/// A is fixed. This follows from l = -h omega^2 s / (wa + wb), where h is the substep.
inline float yield_of_sleeper(float wa, float wb) {
  return wb / (wa + wb) / static_cast<float>(kFixedStiffness * kFixedStiffness);
}

}  // namespace psim
