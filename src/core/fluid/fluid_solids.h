// The shapes of bodies as fluids meet them: how far a point is from one, how much of a small square it covers, and where
// a particle that went into it comes out. Lengths are metres from the corner of a tile.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/hull.h"
#include "psim/types.h"

namespace psim {

/// A point in floats, since a tile is small.
struct Place2 {
  float x = 0, y = 0;
};

/// A convex, rounded shape. A line is at least as wide as a cell, so that no pressure passes it.
struct FluidSolid {
  float x[Hull::kMost] = {}, y[Hull::kMost] = {};  ///< vertices, counter-clockwise
  std::int32_t count = 0;
  bool thin = false;                                   ///< a plate or a line, which separates what is on its two sides
  float radius = 0;                                    ///< around the vertices
  float low_x = 0, low_y = 0, high_x = 0, high_y = 0;  ///< its box
  float centre_x = 0, centre_y = 0;                    ///< centre of mass of its body
  float area = 0;                                      ///< m^2
  std::uint32_t body = 0;                              ///< id, then its number in FluidBodies
  std::uint32_t order = 0;                             ///< among the shapes of its body

  /// Returns how far a point is from the surface, negative within; `out` points out of the shape and has length 1.
  float distance(Place2 at, Place2& out) const;
  bool is_near(Place2 at, float reach) const {
    return at.x > low_x - reach && at.x < high_x + reach && at.y > low_y - reach && at.y < high_y + reach;
  }
};

/// The shape of an outline whose body has its centre of mass at `centre`. `cell`: width of a cell.
FluidSolid fluid_solid(const ConvexOutline& outline, Vec2 centre, float cell);

/// Returns the share of a box that lies within a straight edge `distance` from the middle of the box.
float share_within(float distance, Place2 out, float wide, float high);

/// Whether a straight way comes nearer to a shape than `apart`.
bool passes(const FluidSolid& solid, Place2 from, Place2 to, float apart);

/// Where a particle on its way from `from` to `to` is stopped by a shape.
struct Stop {
  bool stopped = false;
  Place2 at;   ///< where it ends
  Place2 out;  ///< the normal of the surface there
};
/// Particles keep `apart` from shapes. One that begins inside goes out by `most` at most.
Stop stop_at(const FluidSolid& solid, Place2 from, Place2 to, float apart, float most);

}  // namespace psim
