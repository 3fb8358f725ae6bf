// Geometry that never moves: discs, segments (also those of chains), and the four walls. Found
// through a grid of its own, made once per change; a body looks at the cells that its reach covers.
#pragma once

#include <cstdint>
#include <vector>

#include "column.h"
#include "lattice.h"
#include "psim/desc.h"

namespace psim {

/// A static disc (radius > 0, one point) or segment (radius 0, two points).
struct StaticShape {
  LatticePoint p, q;
  float radius = 0;
  float restitution = 0;
  float friction = 0;
  std::uint32_t owner = 0;   ///< body id
  bool segment = false;
  bool alive = true;
};

/// Shape numbers of the walls in contact lists.
inline constexpr std::uint32_t kWallLeft = 0xFFFFFFF0u;
inline constexpr std::uint32_t kWallRight = 0xFFFFFFF1u;
inline constexpr std::uint32_t kWallBottom = 0xFFFFFFF2u;
inline constexpr std::uint32_t kWallTop = 0xFFFFFFF3u;

class StaticShapes {
 public:
  StaticShapes(MemoryMeter& meter, const Lattice& lattice)
      : cell_start_(meter), cell_shape_(meter), shapes_(meter), lattice_(&lattice) {}

  std::uint32_t add(const StaticShape& shape);
  void remove(std::uint32_t first, std::uint32_t owner);

  std::size_t size() const { return count_; }
  const StaticShape& operator[](std::uint32_t i) const { return shapes_[i]; }
  bool any() const { return alive_ != 0; }
  bool changed() const { return dirty_; }

  /// Makes the grid if shapes changed. O(shapes + cells).
  void build_grid();

  /// Appends the numbers of shapes whose box a square of half width `reach` (m) at (x, y) meets,
  /// each once, ascending.
  void near(std::int32_t x, std::int32_t y, float reach, std::vector<std::uint32_t>& out) const;

 private:
  void cells_of(double xmin, double xmax, double ymin, double ymax, std::int64_t range[4]) const;
  void box_of(const StaticShape& s, double box[4]) const;

  Column<std::uint32_t> cell_start_, cell_shape_;
  Column<StaticShape> shapes_;
  const Lattice* lattice_;
  std::uint32_t count_ = 0;
  std::size_t alive_ = 0;
  bool dirty_ = false;
  // Grid, in metres from the lattice centre.
  double origin_x_ = 0, origin_y_ = 0, cell_ = 1;
  std::int64_t cols_ = 0, rows_ = 0;
};

}  // namespace psim
