// Fluids: water or another liquid as particles that carry mass and momentum. What a host describes and is told.
#pragma once

#include <cstddef>
#include <cstdint>

#include "psim/types.h"

namespace psim {

/// The number of a fluid of a world: 0 for the first that was added.
using FluidId = std::uint32_t;

/// No fluid.
inline constexpr FluidId kNoFluid = 0xFFFFFFFFu;

/// So many particles can be in a world.
inline constexpr std::size_t kMostParticles = 10'000'000;

/// This says what a fluid is made of. A particle has the mass density * spacing^2.
struct FluidDesc {
  double spacing = 0;     ///< metres, 1e-3 to 1e3: particles of a full region are so far apart
  double density = 1000;  ///< kg/m^2, > 0
  double viscosity = 0;   ///< m^2/s, >= 0: kinematic
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

/// Sums over all particles of a world, and how well the last step went.
struct FluidReport {
  std::size_t particles = 0;      ///< of all fluids
  double kinetic = 0;             ///< J
  double density_error_mean = 0;  ///< of the cells within the fluid, relative to the density that they should have
  double density_error_max = 0;   ///< likewise, the largest
  std::uint32_t iterations = 0;   ///< of the last step's solvers for pressure and density together
};

}  // namespace psim
