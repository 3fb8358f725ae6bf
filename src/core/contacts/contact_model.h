// The variant of the contact kernels that a scene needs. The plan chooses it; the contact store lays its columns out
// by it.
#pragma once

#include "views.h"

namespace psim {

/// m: the gap of a contact in place of which another one counts, and of a point that a manifold does not have.
constexpr float kNoGap = 1e6f;

/// The columns that contacts have. A column that the model does not read owns no memory.
struct ContactModel {
  kernels::Model model = kernels::Model::plain;
  bool bounce = false;
  friend bool operator==(const ContactModel&, const ContactModel&) = default;
};

}  // namespace psim
