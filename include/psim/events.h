// What happened in a step, as arrays to read after it.
#pragma once

#include <cstdint>
#include <span>

#include "psim/types.h"

namespace psim {

/// Two bodies began or ceased to touch; a.index < b.index.
struct TouchEvent {
  BodyId a, b;
};

/// Two bodies hit each other.
struct HitEvent {
  BodyId a, b;       ///< a.index < b.index; b is kNoBody for a wall of the world
  Vec2 point;        ///< metres
  Vec2 normal;       ///< from a to b
  double speed = 0;  ///< m/s, of approach along the normal
};

/// What is collected.
struct EventOptions {
  bool contacts = false;  ///< begin and end
  bool hits = false;
  double hit_speed = 1;   ///< m/s: slower ones are not told
  bool sensors = false;
};

/// Of the last step, each ordered by a, then b. Valid until the next call that changes the world.
struct Events {
  std::span<const TouchEvent> begin, end;
  std::span<const HitEvent> hits;
  std::span<const TouchEvent> sensor_begin, sensor_end;  ///< a is the sensor
};

}  // namespace psim
