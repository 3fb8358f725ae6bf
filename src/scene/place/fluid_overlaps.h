// Fluids of a scene whose areas overlap bodies. In: a world with its bodies, the particles of a fluid; out: the same
// number of particles, outside the bodies. O(particles), with a question to the world for each that is near a body.
#pragma once

#include <cstddef>

#include "place/fluid_places.h"
#include "psim/world.h"

namespace psim {

/// Lays the particles of the area of fluid k that would lie in bodies in rows above it, against gravity, of which the last
/// is spread evenly. So no water is lost, and none is pressed out of a body. Rows pass over bodies and over areas of
/// other fluids. What has no room within the world's bounds stays in the bodies.
void lay_above_bodies(const World& world, const Scene& scene, std::size_t k, PlacedParticles& placed);

}  // namespace psim
