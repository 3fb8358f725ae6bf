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
  /// What the question itself is: bodies whose own mask (Filter::mask) has one of these bits. All bits: every body,
  /// whatever its mask.
  std::uint32_t category = 0xFFFFFFFFu;
  BodyId ignore = {};  ///< this body is not found
  /// Rays, casts and nearby meet shapes with a one_way direction (BodyDesc) on their solid side alone; else all around.
  bool one_way = false;
  bool enter_only = false;  ///< rays and casts pass through what they overlap where they start
};

/// Where a ray enters a body.
struct RayHit {
  BodyId body = {};     ///< that it enters
  Vec2 point = {};      ///< metres
  Vec2 normal = {};     ///< of the body's surface there; zero where the ray starts inside
  double fraction = 0;  ///< 0..1 of the way
  /// Which part of the body, as in World::part_traits; which segment of a chain with surfaces of its own; else 0.
  std::uint32_t part = 0;
};

/// A ray of World::ray_cast_batch.
struct RayInput {
  Vec2 from = {};  ///< metres
  Vec2 to = {};    ///< metres
};

/// Where a shape that moves meets a body.
struct ShapeCastHit {
  BodyId body = {};  ///< that it meets
  Vec2 point = {};   ///< metres, on the body's surface: the middle of what touches; `from` if it overlaps at the start
  Vec2 normal = {};  ///< of the body's surface there; zero if it overlaps at the start
  double fraction = 0;     ///< 0..1 of the way and of the rotation
  std::uint32_t part = 0;  ///< which part of the body, as in RayHit
};

/// Part of a body near a shape.
struct NearHit {
  BodyId body = {};        ///< whose part it is
  Vec2 point = {};         ///< metres, on its surface: the nearest, or the middle of what is nearest
  Vec2 normal = {};        ///< of length 1, from there to the shape: the shortest way out if they overlap
  double distance = 0;     ///< metres; negative: how deep they overlap
  bool one_way = false;    ///< the part is solid from one side alone
  std::uint32_t part = 0;  ///< which part of the body, as in RayHit
};

/// The nearest point of a body.
struct ClosestHit {
  BodyId body = {};        ///< the nearest
  Vec2 point = {};         ///< metres, on the surface; the question's own point where it is inside
  double distance = 0;     ///< metres, 0 inside
  std::uint32_t part = 0;  ///< which part of the body, as in RayHit
};

}  // namespace psim
