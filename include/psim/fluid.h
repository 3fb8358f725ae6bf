// Fluids: water or another liquid as particles that carry mass and momentum. What a host describes and is told.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "psim/types.h"

namespace psim {

/// The number of a fluid of a world: 0 for the first that was added.
using FluidId = std::uint32_t;

/// No fluid.
inline constexpr FluidId kNoFluid = 0xFFFFFFFFu;

/// The number of an emitter of a world. They count from 0 in the order in which they were added, and are never used again.
using EmitterId = std::uint32_t;
/// The number of a drain, likewise.
using DrainId = std::uint32_t;

/// No emitter.
inline constexpr EmitterId kNoEmitter = 0xFFFFFFFFu;
/// No drain.
inline constexpr DrainId kNoDrain = 0xFFFFFFFFu;

/// So many emitters can be in a world.
inline constexpr std::size_t kMostEmitters = 1000;
/// So many drains can be in a world.
inline constexpr std::size_t kMostDrains = 1000;

/// So many particles can be in a world at once.
inline constexpr std::size_t kMostParticles = 10'000'000;

/// This says what a fluid is made of. A particle has the mass density * spacing^2.
struct FluidDesc {
  double spacing = 0;     ///< metres, 1e-3 to 1e3: particles of a full region are so far apart
  double density = 1000;  ///< kg/m^2, > 0
  double viscosity = 0;   ///< m^2/s, >= 0: kinematic
  /// N/m, 0 to 1e6. Where it meets nothing, a fluid draws together; at walls its surface stands at a right angle.
  double surface_tension = 0;
};

/// A particle as the outside sees it.
struct FluidParticleState {
  std::uint32_t id = 0;  ///< particles count from 0 in the order in which they were added
  FluidId fluid = 0;     ///< what it is a particle of
  Vec2 position;         ///< metres
  Vec2 velocity;         ///< m/s
  double density = 0;    ///< kg/m^2, where the particle is, as of the last step
  double pressure = 0;   ///< N/m, likewise; 0 before the first step
};

/// A fluid flows out of a segment at right angles to it: |to - from| * speed m^2/s of it, whatever the steps are.
struct EmitterDesc {
  FluidId fluid = 0;  ///< what flows
  Vec2 from;          ///< metres, inside the world's bounds
  Vec2 to;            ///< metres, inside the bounds, elsewhere than `from`
  /// m/s: to the left of who looks from `from` to `to`; below 0 to the right
  double speed = 0;
  double start = 0;                                      ///< seconds after it was added, >= 0: it opens
  double end = std::numeric_limits<double>::infinity();  ///< seconds after it was added, >= start: it closes
  /// It closes after so many particles.
  std::uint64_t limit = std::numeric_limits<std::uint64_t>::max();
};

/// This says how much of a fluid is within an area.
struct FluidAmount {
  std::size_t particles = 0;  ///< whose middles are in it
  double mass = 0;            ///< kg
  Vec2 mean_velocity;         ///< m/s: momentum over mass; 0 where there is nothing
};

/// This says what fluids did to a body in the last step.
struct FluidLoad {
  Vec2 force;         ///< N, mean of the step
  double torque = 0;  ///< N m, about the centre of mass, likewise
};

/// Sums over all particles of a world, and how well the last step went.
struct FluidReport {
  std::size_t particles = 0;      ///< of all fluids
  double kinetic = 0;             ///< J
  double density_error_mean = 0;  ///< of the cells within the fluid, relative to the density that they should have
  double density_error_max = 0;   ///< likewise, the largest
  std::uint32_t iterations = 0;   ///< of the last step's solvers for pressure and density together
  std::uint64_t emitted = 0;      ///< particles that emitters have let out since the world was made
  std::uint64_t drained = 0;      ///< particles that drains have removed since then
  /// Particles that emitters could not let out, since the world had kMostParticles or there was no memory for more.
  std::uint64_t withheld = 0;
};

}  // namespace psim
