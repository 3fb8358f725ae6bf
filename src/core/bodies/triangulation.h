// A simple polygon cut into triangles whose corners are its vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "psim/types.h"

namespace psim {

/// Half-edges 3t, 3t + 1 and 3t + 2 lead counter-clockwise around triangle t.
struct Triangulation {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  std::vector<std::uint32_t> from;  ///< of each half-edge: the vertex where it begins
  std::vector<std::uint32_t> twin;  ///< the same edge the other way, of the neighbour; kNone on the outline

  static std::uint32_t next(std::uint32_t edge) { return edge % 3 == 2 ? edge - 2 : edge + 1; }
  static std::uint32_t previous(std::uint32_t edge) { return edge % 3 == 0 ? edge + 2 : edge - 1; }

  /// Makes two half-edges twins. There may be no other.
  void join(std::uint32_t edge, std::uint32_t other) {
    twin[edge] = other;
    if (other != kNone) twin[other] = edge;
  }
};

/// The constrained Delaunay triangulation, whose least angles are as large as can be. The polygon is counter-clockwise,
/// does not touch itself, and no three vertices in a row lie on a line.
Triangulation triangulate(const std::vector<Vec2>& points);

/// The sine of the least angle of a triangle. The same bits in whatever order its vertices are given.
double sharpness(const std::vector<Vec2>& points, std::uint32_t a, std::uint32_t b, std::uint32_t c);

}  // namespace psim
