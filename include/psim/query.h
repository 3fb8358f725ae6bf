// Questions about what is where. Answers are in a fixed order that depends on the bodies alone. Any number
// of threads may ask at once while nobody changes the world.
#pragma once

#include <cstdint>

#include "psim/types.h"

namespace psim {

/// Which bodies a question is about.
struct QueryFilter {
  std::uint32_t mask = 0xFFFFFFFFu;  ///< bodies whose category is in it
  bool dynamic = true;               ///< dynamic ones
  bool kinematic = true;             ///< kinematic ones
  bool fixed = true;                 ///< static ones
  bool sensors = false;              ///< sensors, of the kinds above
};

/// Where a ray enters a body.
struct RayHit {
  BodyId body = {};     ///< that it enters
  Vec2 point = {};      ///< metres
  Vec2 normal = {};     ///< of the body's surface there; zero where the ray starts inside
  double fraction = 0;  ///< 0..1 of the way
};

/// The nearest point of a body.
struct ClosestHit {
  BodyId body = {};     ///< the nearest
  Vec2 point = {};      ///< metres, on the surface; the question's own point where it is inside
  double distance = 0;  ///< metres, 0 inside
};

}  // namespace psim
