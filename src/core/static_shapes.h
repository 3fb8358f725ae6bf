// Geometry that never moves: discs, segments (also those of chains), and the four walls. Found
// through a grid of its own, made once per change; a body looks at the cells that its reach covers.
#pragma once

#include <cstdint>
#include <vector>

#include "column.h"
#include "hull.h"
#include "lattice.h"
#include "psim/desc.h"

namespace psim {

/// A piece of a static body: a disc (one point), a segment (two points) with a radius around it, or
/// a whole polygon. Polygons come twice: as their edges, which discs meet, and whole, for all else.
struct StaticShape {
  LatticePoint p, q;
  float radius = 0;
  float restitution = 0;
  float friction = 0;
  std::uint32_t owner = 0;   ///< body id
  std::uint32_t hull = 0;    ///< whole: its number, see StaticShapes::hull
  bool segment = false;
  bool face = false;         ///< a polygon's edge: its inside is left of p->q; discs only
  bool whole = false;        ///< a polygon about p: shapes with corners only
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

  /// `hull`, of a whole polygon, is in world axes about p.
  std::uint32_t add(const StaticShape& shape, const Hull* hull = nullptr);
  void remove(std::uint32_t first, std::uint32_t owner);

  std::size_t size() const { return count_; }
  const StaticShape& operator[](std::uint32_t i) const { return shapes_[i]; }
  const Hull& hull(const StaticShape& whole) const { return hulls_[whole.hull]; }
  /// A piece as seen from a body's place, precise where it is near: lines far longer than `size`, m,
  /// are cut to what lies around the body.
  Hull seen_from(std::uint32_t i, std::int32_t x, std::int32_t y, double size, float rest_x = 0,
                 float rest_y = 0) const;
  /// Of a chain's segment, the one that goes on from its end q (`forward`) or ends in its p; or null.
  const StaticShape* chain_neighbour(std::uint32_t i, bool forward) const;
  bool any() const { return alive_ != 0; }
  /// Whether questions find whole polygons: where no moving body has corners they are in the way.
  void find_whole(bool wanted) { whole_wanted_ = wanted; }
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
  std::vector<Hull> hulls_;
  std::vector<std::uint32_t> free_hulls_;
  bool whole_wanted_ = false;
  const Lattice* lattice_;
  std::uint32_t count_ = 0;
  std::size_t alive_ = 0;
  bool dirty_ = false;
  // Grid, in metres from the lattice centre.
  double origin_x_ = 0, origin_y_ = 0, cell_ = 1;
  std::int64_t cols_ = 0, rows_ = 0;
};

}  // namespace psim
