// What happened in a step, as arrays to read after it.
#pragma once

#include <cstdint>
#include <span>

#include "psim/fluid.h"
#include "psim/joint.h"
#include "psim/types.h"

namespace psim {

/// Two bodies began or ceased to touch; a.index < b.index.
struct TouchEvent {
  BodyId a = {};     ///< a.index < b.index
  BodyId b = {};     ///< the other; kNoBody for a wall of the world
  Vec2 point = {};   ///< metres: of two bodies that began, where they press or overlap most
  Vec2 normal = {};  ///< of length 1, from a to b: there, and of a wall always; else zero
  /// An event of a sensor says which part of a feels b: the number that World::part_traits takes, of a kinematic chain that
  /// of the segment. All other events have 0.
  std::uint32_t part = 0;
};

/// A body that moved in a step.
struct MoveEvent {
  BodyId body = {};          ///< dynamic or kinematic
  Vec2 position = {};        ///< metres: of its origin, as in BodyState
  double angle = 0;          ///< radians
  bool fell_asleep = false;  ///< after the step
};

/// A particle of a fluid entered or left a sensor.
struct FluidEvent {
  BodyId sensor = {};          ///< the body
  std::uint32_t part = 0;      ///< which part of it, as in TouchEvent
  FluidId fluid = 0;           ///< what the particle is of
  std::uint32_t particle = 0;  ///< FluidParticleState::id

  bool operator==(const FluidEvent&) const = default;  ///< whether all is the same
};

/// Two bodies hit each other.
struct HitEvent {
  BodyId a = {};     ///< a.index < b.index
  BodyId b = {};     ///< kNoBody for a wall of the world
  Vec2 point = {};   ///< metres
  Vec2 normal = {};  ///< from a to b
  double speed = 0;  ///< m/s, of approach along the normal
  /// N s: that changed the approach as it did, if nothing else acted on the two there. 0 if neither is dynamic.
  double impulse = 0;
  std::uint32_t part_a = 0;  ///< which part of a, as in Contact
  std::uint32_t part_b = 0;  ///< likewise; of a wall 0
};

/// What is collected.
struct EventOptions {
  bool contacts = false;  ///< begin and end
  bool hits = false;      ///< impacts
  double hit_speed = 1;   ///< m/s: slower ones are not told
  bool sensors = false;   ///< who enters and leaves them
  bool sleep = false;     ///< who falls asleep and who wakes
  bool moves = false;     ///< who moved, and whereto
  bool fluids = false;    ///< which particles enter and leave sensors
};

/// The lists say what happened in the last step. Each is ordered by a, then b; those of sensors then by part; those of fluids by
/// sensor, part and particle. The spans are valid until the next call that changes the world.
struct Events {
  std::span<const TouchEvent> begin = {};         ///< touch now and did not before
  std::span<const TouchEvent> end = {};           ///< touched and do no more
  std::span<const HitEvent> hits = {};            ///< faster than EventOptions::hit_speed
  std::span<const TouchEvent> sensor_begin = {};  ///< a is the sensor, b entered this part of it
  std::span<const TouchEvent> sensor_end = {};    ///< a is the sensor, b left this part of it
  std::span<const JointBreak> breaks = {};        ///< joints that broke, by JointId::index; always told
  std::span<const BodyId> fell_asleep = {};       ///< at the end of the step
  std::span<const BodyId> woke = {};              ///< since the end of the step before; also by what the host did
  std::span<const MoveEvent> moves = {};          ///< all that took part in the step and are there, asleep or not
  std::span<const FluidEvent> fluid_begin = {};   ///< particles whose middles are in a sensor and were not
  std::span<const FluidEvent> fluid_end = {};     ///< particles that were in a sensor and are not, or are gone
};

}  // namespace psim
