// Elastic gases of discs of radius 0.5 m, on a jittered lattice at the start.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "engines/model.h"
#include "run.h"

namespace psim::accuracy {

/// Of the square that so many discs fill to that packing, m.
inline double side_of(int count, double packing) { return std::sqrt(count * std::numbers::pi * 0.25 / packing); }

/// Over the square from (margin, margin); velocities uniform in +-speed on each axis, m/s.
inline GroupDesc lattice(int count, double side, double margin, double speed, std::uint64_t seed) {
  GroupDesc group;
  group.count = static_cast<std::uint64_t>(count);
  group.region = {margin, margin, side - margin, side - margin};
  group.jitter = 0.5;
  group.velocity_spread = speed;
  group.seed = seed;
  group.body.material = material(1);
  return group;
}

inline Scene gas_in_walls(int count, double side, double speed, std::uint64_t seed) {
  Scene scene = walled_scene(side, side, material(1));
  scene.groups = {lattice(count, side, 0.5, speed, seed)};
  return scene;
}

inline Scene gas_in_period(int count, double packing, double speed, std::uint64_t seed) {
  const double side = side_of(count, packing);
  Scene scene = periodic_scene(side, side);
  scene.groups = {lattice(count, side, 0, speed, seed)};
  return scene;
}

/// Z = pA / NkT over so many seconds of an elastic gas of equal discs in a periodic world.
double compressibility(Run& run, double seconds);

}  // namespace psim::accuracy
