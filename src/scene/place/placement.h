// Where the bodies of a group stand. In: a GroupDesc; out: columns x, y, radius, vx, vy.
// Lattice, hex and ring: O(n), about 25 ns a body. Random: dart throwing over a grid, O(n) while less than
// half of the region is covered.
#pragma once

#include <cstdint>
#include <string>

#include "psim/scene.h"

namespace psim {

/// A lattice over a group's region: `columns` cells a row, rows from the bottom.
struct LatticePlan {
  std::uint64_t columns = 0;
  std::uint64_t rows = 0;
  double cell_x = 0, cell_y = 0;  ///< metres
};

/// columns = ceil(sqrt(count width / height)), rows = ceil(count / columns). In `hex` the odd rows
/// are shifted by half a cell, so a row is half a cell longer than its bodies. count >= 1.
LatticePlan plan_lattice(std::uint64_t count, const Bounds& region, bool hex);

/// The group with the scene's seed mixed in: what build_world places.
GroupDesc seeded_group(const Scene& scene, std::size_t k);

}  // namespace psim
