// The start of a flow, as every method gets it, and a particle as every method shows it. The density is 1000 kg/m^2.
#pragma once

#include <functional>
#include <vector>

#include "psim/types.h"

namespace psim::fluids {

inline constexpr double kDensity = 1000;

struct Flow {
  Bounds bounds;
  Boundary boundary = Boundary::walls;  ///< walls let fluid slip along them
  Vec2 gravity;
  double spacing = 0;
  double viscosity = 0;  ///< m^2/s, kinematic
  std::vector<Vec2> places;
  std::vector<Vec2> velocities;  ///< empty: all particles are at rest
  /// m/s, the fastest that the fluid will be. A weakly compressible method makes sound ten times as fast.
  double speed = 1;
  /// N/m at the start, for methods whose pressure is a state. Without it the pressure is zero.
  std::function<double(Vec2)> pressure;
};

struct Particle {
  Vec2 place;
  Vec2 velocity;
  double pressure = 0;
};

/// Fills a rectangle, whose lower left corner is given, with rows of particles from the bottom.
inline void fill(Flow& flow, Vec2 corner, int columns, int rows) {
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      flow.places.push_back({corner.x + (i + 0.5) * flow.spacing, corner.y + (j + 0.5) * flow.spacing});
    }
  }
}

}  // namespace psim::fluids
