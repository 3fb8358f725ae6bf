// Geometry that does not move: discs, segments (also those of chains), polygons, the four walls, and the
// pieces of bodies that are asleep. What stands for good is found through a grid made once per change, what
// sleeps through a hashed one that it enters and leaves; a body looks at the cells that its reach covers.
// Where a grid's cells would be crowded, since most of its box is empty, what stands is hashed, too.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "column.h"
#include "hash_grid.h"
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
  bool asleep = false;       ///< of a body that sleeps: it may leave at any time
  bool lone = false;         ///< a plain disc that sleeps: its Sleeper and its Surface say all else
};

/// A shape on its way into the grids.
struct Piece {
  StaticShape shape;
  Hull hull;  ///< of a whole one, in world axes about its place
};

/// Shape numbers of the walls in contact lists.
inline constexpr std::uint32_t kWallLeft = 0xFFFFFFF0u;
inline constexpr std::uint32_t kWallRight = 0xFFFFFFF1u;
inline constexpr std::uint32_t kWallBottom = 0xFFFFFFF2u;
inline constexpr std::uint32_t kWallTop = 0xFFFFFFF3u;

class StaticShapes {
  friend struct Image;

 public:
  StaticShapes(MemoryMeter& meter, const Lattice& lattice)
      : cell_start_(meter), cell_shape_(meter), shapes_(meter), sleepers_(meter), standing_(meter), lattice_(&lattice) {
    int shift = 0;
    for (double r = lattice.pitch_x() / lattice.pitch_y(); r >= 1.5; r /= 2) ++shift;
    for (double r = lattice.pitch_x() / lattice.pitch_y(); r <= 0.75; r *= 2) --shift;
    sleepers_.set_shape(shift);
    standing_.set_shape(shift);
  }

  /// `hull`, of a whole polygon, is in world axes about p.
  std::uint32_t add(const StaticShape& shape, const Hull* hull = nullptr);
  void remove(std::uint32_t first, std::uint32_t owner);

  /// Pieces of a body that falls asleep: `count` of them, numbered from the result on. O(count).
  std::uint32_t lay_down(const Piece* pieces, std::uint32_t count);
  /// For so many sleeping bodies' pieces, `hulls` of them with hulls: laying them down allocates nothing.
  void make_room(std::uint32_t pieces, std::uint32_t hulls);
  /// Takes them out again. Their numbers are not given to others before the next build_grid().
  void take_up(std::uint32_t first, std::uint32_t count);

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
  bool any_asleep() const { return !sleepers_.empty(); }
  /// Whether questions find whole polygons: where no moving body has corners they are in the way.
  void find_whole(bool wanted) { whole_wanted_ = wanted; }

  /// Makes the grid if shapes that stand for good changed. O(shapes + cells).
  void build_grid();

  /// Appends the numbers of shapes whose box a square of half width `reach` (m) at (x, y) meets,
  /// each once, ascending.
  void near(std::int32_t x, std::int32_t y, float reach, std::vector<std::uint32_t>& out) const;
  /// Whether a look at cells says already that near() would find nothing for any square within a box (m).
  bool surely_none(double xmin, double xmax, double ymin, double ymax) const;

 private:
  void make_grid();
  void cells_of(double xmin, double xmax, double ymin, double ymax, std::int64_t range[4]) const;
  void box_of(const StaticShape& s, double box[4]) const;
  void put(std::uint32_t number, const StaticShape& shape, const Hull* hull);
  void enter(HashGrid& grid, std::uint32_t number) const;
  bool beside(const StaticShape& s, double x, double y, double reach) const;

  Column<std::uint32_t> cell_start_, cell_shape_;
  Column<StaticShape> shapes_;
  HashGrid sleepers_, standing_;
  // Runs of numbers by length that nobody has: to be had, and from the next build_grid() on.
  static constexpr std::uint32_t kLongestRun = kMostPolygonVertices + 1;
  std::vector<std::uint32_t> runs_[kLongestRun + 1];
  std::vector<std::pair<std::uint32_t, std::uint32_t>> left_;
  std::vector<Hull> hulls_;
  std::vector<std::uint32_t> free_hulls_;
  bool whole_wanted_ = false;
  const Lattice* lattice_;
  std::uint32_t count_ = 0;
  std::size_t alive_ = 0;
  // All but lone pieces, as the last saved state has them.
  std::vector<std::byte> saved_;
  bool saved_stale_ = true;
  bool dirty_ = false;
  // Grid, in metres from the lattice centre.
  double origin_x_ = 0, origin_y_ = 0, cell_ = 1;
  std::int64_t cols_ = 0, rows_ = 0;
};

}  // namespace psim
