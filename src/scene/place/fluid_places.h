// Where the particles of a fluid stand. In: a SceneFluid; out: places and velocities, ready for World::add_particles.
// O(particles + rows x corners of a polygon).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "psim/scene.h"

namespace psim {

/// So many columns or rows of a lattice may a disc or polygon have.
inline constexpr std::uint64_t kMostFluidRows = 100'000;

/// The particles that a fluid begins with; more than kMostParticles if there are too many to count.
std::uint64_t count_particles(const SceneFluid& fluid);

/// Returns the x at which a side of a polygon, from p to q, is at the height y. The side is not level.
inline double crossing(Vec2 p, Vec2 q, double y) { return p.x + (y - p.y) / (q.y - p.y) * (q.x - p.x); }

struct PlacedParticles {
  std::vector<Vec2> positions, velocities;  ///< no velocities: all are at rest
};
/// False and one line in `error` if there is no particle, or more than kMostParticles: then no memory is taken.
bool place_particles(const SceneFluid& fluid, PlacedParticles& out, std::string& error);

}  // namespace psim
