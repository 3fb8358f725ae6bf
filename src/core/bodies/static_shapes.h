// Geometry that does not move: discs, segments (also those of chains), polygons, the four walls, and the
// pieces of bodies that sleep. Pieces of static bodies are found through a grid that is made once per
// change, those of sleeping bodies through a hashed grid that they enter and leave. A moving body looks at
// the cells that its reach covers. If most of the grid's box is empty, so that its cells would be crowded,
// the pieces of static bodies are hashed, too.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "base/column.h"
#include "base/elementary.h"
#include "base/lattice.h"
#include "bodies/hash_grid.h"
#include "bodies/hull.h"
#include "psim/desc.h"

namespace psim {

class BodyStore;
struct PartProperties;

/// A piece of a static body: a disc (one point), a segment (two points) with a radius around it, or
/// a whole polygon. A polygon comes twice: as its edges, which discs collide with, and whole, for all other shapes.
struct StaticShape {
  LatticePoint p, q;
  float radius = 0;
  float restitution = 0;
  float friction = 0;
  std::uint32_t owner = 0;  ///< body id
  std::uint32_t hull = 0;   ///< of a whole polygon: the number of its hull, see StaticShapes::hull
  std::uint32_t part = 0;   ///< of the body
  bool segment : 1 = false;
  bool face : 1 = false;   ///< an edge of a polygon, whose inside is left of p->q: discs alone collide with it
  bool whole : 1 = false;  ///< a whole polygon about p: shapes with corners alone collide with it
  bool alive : 1 = true;
  bool asleep : 1 = false;   ///< a piece of a body that sleeps: it may leave at any time
  bool lone : 1 = false;     ///< a plain disc that sleeps: its Sleeper and its BodyProperties hold the rest
  bool special : 1 = false;  ///< PartProperties::is_special: its contacts with discs are manifolds, too
  bool hidden : 1 = false;   ///< not alive, but kept until its body is enabled again
};
static_assert(sizeof(StaticShape) == 60);

/// A shape on its way into the grids.
struct Piece {
  StaticShape shape;
  Hull hull = {};  ///< of a whole polygon: in world axes, about its place
};

/// Shape numbers of the walls in contact lists.
inline constexpr std::uint32_t kWallLeft = 0xFFFFFFF0u;
inline constexpr std::uint32_t kWallRight = 0xFFFFFFF1u;
inline constexpr std::uint32_t kWallBottom = 0xFFFFFFF2u;
inline constexpr std::uint32_t kWallTop = 0xFFFFFFF3u;

/// The four walls as lattice coordinates.
struct Walls {
  LatticePoint low, high;

  struct Face {
    float nx = 0, ny = 0;  ///< into the world
    double height = 0;     ///< m: of the place over the wall
  };
  /// A wall as it is seen from a place.
  Face face(std::uint32_t wall, const LatticePoint& at, const Lattice& lattice) const {
    const bool far = wall == kWallRight || wall == kWallTop, upright = wall == kWallLeft || wall == kWallRight;
    const Vec2 way = lattice.way(far ? high : low, at);
    const float sign = far ? -1 : 1;
    return {upright ? sign : 0, upright ? 0 : sign, sign * (upright ? way.x : way.y)};
  }
};

/// A static body. Its shapes lie in StaticShapes, in a run that starts with `first_shape`.
struct FixedBody {
  double x = 0, y = 0, angle = 0;  ///< m, m, rad: as the host placed it
  float radius = 0;                ///< m: of a disc, else 0
  std::uint32_t id = 0;
  std::uint32_t first_shape = 0;
};

class StaticShapes {
 public:
  StaticShapes(MemoryMeter& meter, const Lattice& lattice);

  /// For saved states (describe_bodies.cpp); behind the bodies. Those that are read wait for the sleepers.
  void describe(class Archive& a, const BodyStore& bodies);
  /// Used when a saved state is read: returns whether these pieces are those of a sleeping body. The piece of a plain
  /// disc, `lone`, is not in the state and is put in place here.
  bool lay_sleeper(std::uint32_t owner, std::uint32_t first, std::uint32_t pieces, const StaticShape* lone);
  /// The grids, once all are there. False if not as many pieces sleep.
  bool make_grids(std::size_t asleep);

  /// Adds the pieces of a static body. Returns the number of the first one; the others follow.
  std::uint32_t add(const std::vector<Piece>& pieces);
  /// Removes them. No number that a list may name is given to others before the next build_grid().
  void remove(std::uint32_t first, std::uint32_t owner);

  /// Adds the pieces of a body that falls asleep. Returns the number of the first one; the others follow. O(count).
  std::uint32_t add_sleeping(const std::vector<Piece>& pieces);
  /// Takes the pieces of a static body out of the way, and returns how many. They keep their numbers.
  std::uint32_t hide(std::uint32_t first, std::uint32_t owner);
  void show(std::uint32_t first, std::uint32_t count);
  /// Used when a saved state is read: whether all these pieces are hidden ones of the body; and how many are hidden.
  bool hides(std::uint32_t first, std::uint32_t count, std::uint32_t owner) const;
  std::size_t hidden() const;
  /// Lets hidden pieces go.
  void remove_hidden(std::uint32_t first, std::uint32_t count);
  /// How many parts the pieces of a static body are of, at least 1.
  std::uint32_t parts_from(std::uint32_t first, std::uint32_t owner) const;
  /// Another surface for the pieces of a part of a static body, or of all its parts.
  void set_surface(std::uint32_t first, std::uint32_t owner,
                   const std::function<PartProperties(std::uint32_t)>& of_part);
  /// Makes room for so many pieces of sleeping bodies, `hulls` of them with hulls: adding them allocates nothing.
  void make_room(std::uint32_t pieces, std::uint32_t hulls);
  /// Makes room for so many pieces more, which then are added without an allocation.
  void reserve(std::size_t pieces);
  /// Forgets all pieces.
  void lose_all() {
    count_ = listed_ = 0;
    alive_ = 0;
  }
  /// Makes room for the places of so many bodies that wake, or that are `fixed` and go, which need no memory then.
  void make_room_to_leave(std::size_t bodies, bool fixed);
  /// Removes the pieces of a body that wakes. Their numbers are given to others only after the next build_grid().
  void remove_sleeping(std::uint32_t first, std::uint32_t count) {
    lift_sleeping(first, count);
    drop_lifted(first, count);
  }
  /// The same in two steps: near() does not find the pieces any more, and either they go or lay_back() puts them back.
  void lift_sleeping(std::uint32_t first, std::uint32_t count);
  void lift_all_sleeping() { sleepers_.clear(); }
  void drop_lifted(std::uint32_t first, std::uint32_t count);
  void lay_back(std::uint32_t first, std::uint32_t count);

  std::size_t size() const { return count_; }
  const StaticShape& operator[](std::uint32_t i) const { return statics_[i]; }
  const Hull& hull(const StaticShape& whole) const { return hulls_[whole.hull]; }
  /// A piece as seen from the place of a body. Lines far longer than `size`, m, are cut to the part around the body, so
  /// that the numbers are precise there.
  Hull seen_from(std::uint32_t i, const LatticePoint& from, double size) const;
  bool any() const { return alive_ != 0; }
  /// Whether near() finds whole polygons. Nothing needs them while no moving body has corners.
  void find_whole(bool wanted) { whole_wanted_ = wanted; }

  /// Makes the grid anew if shapes of static bodies changed. O(shapes + cells).
  void build_grid();

  /// Appends the numbers of shapes whose box a square of half width `reach` (m) at (x, y) meets,
  /// each once, ascending.
  void near(std::int32_t x, std::int32_t y, float reach, std::vector<std::uint32_t>& out) const;
  /// The same for a way that begins at an offset from a place, m, and for what lies within `radius` of it.
  void near_way(const LatticePoint& place, Vec2 offset, Vec2 way, float radius, std::vector<std::uint32_t>& out) const;
  /// Appends the numbers of sleeping pieces whose box the box of a piece meets that is wider by `far`, m, on each side; in
  /// no order.
  void sleepers_near(std::uint32_t number, double far, std::vector<std::uint32_t>& out) const;
  /// Whether a look at cells says already that near() would find nothing for any square within a box (m).
  bool surely_none(const Bounds& box) const;

 private:
  void check_runs(Archive& a) const;
  void set_free(std::uint32_t first, std::uint32_t count);
  void join_gaps();
  std::uint32_t take_numbers(std::uint32_t count);
  void make_grid();
  bool fill_cells(const std::vector<std::uint32_t>& standing);
  struct Cells {
    std::int64_t first_col, last_col, first_row, last_row;
  };
  Cells cells_of(const Bounds& box) const;
  Cells cells_of(const StaticShape& s, std::int64_t row) const;
  bool meets_grid(const Bounds& box) const;
  void put(std::uint32_t number, const Piece& piece);
  void drop(std::uint32_t number);
  struct LatticeBox {
    std::int32_t x, y;
    std::uint32_t half_x, half_y;
  };
  LatticeBox around(std::uint32_t number, double far) const;
  void enter(HashGrid& grid, std::uint32_t number) const;
  // How far a piece reaches beyond its place, or beyond both ends of a segment, m, with some room for rounding.
  Bounds extent_of(const StaticShape& s) const {
    const double room = 2 * lattice_->pitch_x() + 2 * lattice_->pitch_y();
    const double r = static_cast<double>(s.whole ? hulls_[s.hull].radius : s.radius) + room;
    if (!s.whole) return {-r, -r, r, r};
    const Hull& hull = hulls_[s.hull];
    Bounds e{hull.vertex(0).x, hull.vertex(0).y, hull.vertex(0).x, hull.vertex(0).y};
    for (int k = 1; k < hull.count; ++k) {
      const Vec2 v = hull.vertex(k);
      e = {lesser(v.x, e.xmin), lesser(v.y, e.ymin), greater(v.x, e.xmax), greater(v.y, e.ymax)};
    }
    return {e.xmin - r, e.ymin - r, e.xmax + r, e.ymax + r};
  }
  Vec2 metres(const LatticePoint& p) const { return lattice_->metres(p.x, p.y); }
  // Here, for near() asks it of every shape that a cell names.
  Bounds box_of(const StaticShape& s) const {
    const Vec2 p = metres(s.p), q = s.segment ? metres(s.q) : p;
    const Bounds e = extent_of(s);
    return {lesser(p.x, q.x) + e.xmin, lesser(p.y, q.y) + e.ymin, greater(p.x, q.x) + e.xmax,
            greater(p.y, q.y) + e.ymax};
  }
  bool beside(const StaticShape& s, Vec2 at, double reach) const;
  bool is_inside(const StaticShape& whole, const LatticePoint& at) const;

  Column<std::uint32_t> cell_start_, cell_shape_;
  Column<StaticShape> statics_;
  HashGrid sleepers_, standing_;
  // Free runs of numbers, by length; longer ones as (first, length), ascending; and those that become free with the next
  // build_grid(): of bodies that slept, and of static ones, which become free with the next static body if no list names
  // them.
  using Run = std::pair<std::uint32_t, std::uint32_t>;
  static constexpr std::uint32_t kLongestRun = kMostPolygonVertices + 1;  // of a body that sleeps
  std::vector<std::uint32_t> runs_[kLongestRun + 1];
  std::vector<Run> gaps_, left_, gone_;
  std::vector<Hull> hulls_;
  std::vector<std::uint32_t> free_hulls_;
  bool whole_wanted_ = false;
  const Lattice* lattice_;
  std::uint32_t count_ = 0;
  std::uint32_t listed_ = 0;  // numbers since the last build_grid(): lists may name them, and none behind them
  std::size_t alive_ = 0;
  bool dirty_ = false;
  // The grid, in metres from the centre of the lattice.
  double origin_x_ = 0, origin_y_ = 0, cell_ = 1;
  std::int64_t cols_ = 0, rows_ = 0;
};

}  // namespace psim
