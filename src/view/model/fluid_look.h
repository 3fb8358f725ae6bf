// Particles of a world at one moment, as the viewer keeps and draws them.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"

namespace psim::view {

/// One fluid: a row for each particle, by id.
struct FluidRows {
  double spacing = 0;            ///< metres
  std::vector<Vec2> place;       ///< metres
  std::vector<Vec2> velocity;    ///< m/s
  std::vector<double> pressure;  ///< N/m
};

struct FluidLook {
  std::vector<FluidRows> fluids;  ///< by FluidId
  std::size_t particles = 0;
  static constexpr std::size_t kRowBytes = 40;
};

/// What there is of fluids, or nothing if the scene has none.
using FluidPlaces = std::shared_ptr<const FluidLook>;
FluidPlaces take_fluids(const World& world, const Scene& scene);

/// Puts the particles into the scene as a list for each fluid, so that a world of it goes on from there. They get new
/// ids.
void carry_fluids(const FluidLook& look, Scene& scene);

}  // namespace psim::view
