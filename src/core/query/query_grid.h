// Finds the items near a place or a line. An item has a centre and a reach and lies in one cell of a uniform
// grid. Items whose sizes differ by less than a factor of four share a grid, so that a query looks at few
// cells whatever the sizes are.
//
// The grids are made once, O(items); a query costs the cells that its box or its ray passes. Cells lie side by
// side by row: 32 bytes an item, 4 a cell, about one cell an item. Far outliers share the outermost cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/column.h"
#include "base/elementary.h"
#include "base/rotor.h"

namespace psim {

/// An item. Coordinates are metres from the centre of the lattice.
struct QueryItem {
  Vec2 at{};
  float radius = 0;         ///< m: no part of the item is further from its place
  std::uint32_t body = 0;   ///< id
  std::uint32_t piece = 0;  ///< the owner's number for it
  std::uint32_t part = 0;   ///< of the body

  /// From a point to the centre of a copy of the item.
  Vec2 seen_from(Vec2 point, Vec2 shift) const { return at + shift - point; }
};

/// In a periodic world: the copy of a point that is nearest to the middle.
Vec2 nearest_copy(Vec2 at, Vec2 period);

class QueryGrid {
 public:
  /// Starts new grids for about `room` items. `period` is that of the two axes, m; 0: not periodic.
  void begin(Vec2 period, std::size_t room);
  void add(QueryItem item);
  void build();

  const std::vector<QueryItem>& items() const { return sorted_; }
  std::size_t bytes() const { return bytes_of(items_, sorted_, levels_, start_, key_, sample_); }

  /// Calls each(item, shift) for all items that may reach into the box, and for others. In a periodic world an item has
  /// copies; `shift` leads from the item to the copy that is meant.
  template <class Each>
  void in_box(Vec2 low, Vec2 high, const Each& each) const {
    for (const Level& g : levels_) {
      visit(g, g.x.cells(low.x - g.most, high.x + g.most), g.y.cells(low.y - g.most, high.y + g.most), each);
    }
  }

  /// Calls each(item, shift) for all items within `reach` of a point, grid by grid, in squares that grow up to `reach`,
  /// which `each` may lower. Items may come more than once.
  template <class Each>
  void around(Vec2 at, const double& reach, const Each& each) const {
    for (const Level& g : levels_) {
      // The first square reaches as far as a cell, from a point outside of the grid as far as the grid and a cell.
      double half = greater(g.x.distance(at.x), g.y.distance(at.y)) + lesser(g.x.edge, g.y.edge);
      for (;; half *= 2) {
        const double side = lesser(half, reach);
        const Range x = g.x.cells(at.x - side - g.most, at.x + side + g.most);
        const Range y = g.y.cells(at.y - side - g.most, at.y + side + g.most);
        visit(g, x, y, each);
        if (half >= reach || (g.x.covers(x) && g.y.covers(y))) break;
      }
    }
  }

  /// Calls each(item, shift) for all items that a disc of radius `wide`, m, about the head of a ray may meet on its first
  /// `limit` metres, and for others, roughly in the order of the way. `each` may lower `limit`. `u` has length 1.
  template <class Each>
  void along(Vec2 from, Vec2 u, const double& limit, const Each& each, double wide = 0) const {
    for (const Level& g : levels_) {
      // Slab by slab along the axis on which the ray passes more cells.
      const bool flat = std::fabs(u.x) * g.y.edge >= std::fabs(u.y) * g.x.edge;
      const Axis &axis = flat ? g.x : g.y, &across = flat ? g.y : g.x;
      const double way = flat ? u.x : u.y, origin = flat ? from.x : from.y, r = g.most + wide;
      const double side_way = flat ? u.y : u.x, side = flat ? from.y : from.x;
      const bool ahead = way > 0;
      const double end = origin + limit * way;
      const Range slabs = ahead ? axis.cells(origin - r, end + r) : axis.cells(end - r, origin + r);
      for (std::int64_t n = 0; n <= slabs.last - slabs.first; ++n) {
        const std::int64_t slab = ahead ? slabs.first + n : slabs.last - n;
        double near = axis.low + axis.edge * static_cast<double>(slab) - r;
        double far = near + axis.edge + 2 * r;
        if (axis.ends() && slab == 0) near = -1e300;
        if (axis.ends() && slab == axis.count - 1) far = 1e300;
        const double t0 = std::max(((ahead ? near : far) - origin) / way, 0.0);
        const double t1 = std::min(((ahead ? far : near) - origin) / way, limit);
        if (t0 > limit) break;
        if (t0 > t1) continue;
        const double s0 = side + t0 * side_way, s1 = side + t1 * side_way;
        const Range sides = across.cells(std::min(s0, s1) - r, std::max(s0, s1) + r), one{slab, slab};
        visit(g, flat ? one : sides, flat ? sides : one, each);
      }
    }
  }

 private:
  struct Range {
    std::int64_t first = 0, last = -1;
  };

  // The cells of a grid along an axis.
  struct Axis {
    double low = 0;     // m: the side of the first cell
    double edge = 0;    // m
    double per = 0;     // 1/m: 1 / edge
    double period = 0;  // m; 0: not periodic
    std::int64_t count = 0;

    bool ends() const { return !(period > 0); }
    std::int64_t cell(double at) const {
      const double k = (at - low) * per, last = static_cast<double>(count - 1);
      return static_cast<std::int64_t>(k > 0 ? (k < last ? k : last) : 0.0);
    }
    // The cells between two coordinates. In a world that is not periodic the outermost cells have no end.
    Range cells(double from, double to) const {
      if (ends()) return {cell(from), cell(to)};
      const double a = (from - low) * per, b = (to - low) * per;
      const auto n = static_cast<double>(count);
      if (b - a < 3 * n) return {whole(a), whole(b)};
      // These copies suffice for a box no larger than the world. One without ends has no middle.
      const double middle = std::isnan(a + b) ? n / 2 : (a + b) / 2;
      return {whole(middle - 1.5 * n), whole(middle + 1.5 * n)};
    }
    bool covers(const Range& r) const {
      return ends() ? r.first == 0 && r.last + 1 == count : r.last - r.first + 1 >= 2 * count;
    }
    // How far a point lies outside of the cells, m.
    double distance(double at) const {
      const double high = low + edge * static_cast<double>(count);
      return ends() ? greater(0.0, greater(low - at, at - high)) : 0;
    }
    // In a periodic world: takes a cell of any copy to the first one. `shift` leads from there to the copy, m.
    std::int64_t first_copy(std::int64_t at, double& shift) const {
      if (ends()) return at;
      const std::int64_t turns = at >= 0 ? at / count : -((count - 1 - at) / count);
      shift = static_cast<double>(turns) * period;
      return at - turns * count;
    }
    static std::int64_t whole(double at) {  // std::floor, which is a call without SSE4.1
      constexpr double kFar = 0x1p53;       // beyond it, a double tells no cell from the next one
      at = lesser(greater(at, -kFar), kFar);
      const auto cut = static_cast<std::int64_t>(at);
      return static_cast<double>(cut) > at ? cut - 1 : cut;
    }
  };

  struct Level {
    double most = 0;  // m: largest radius
    Axis x, y;
    std::size_t first = 0;  // the first of its cells in start_
  };

  // Visits the items of some columns and rows. In a periodic world these may be cells of any copy.
  template <class Each>
  void visit(const Level& g, const Range& columns, const Range& rows, const Each& each) const {
    for (std::int64_t row = rows.first; row <= rows.last; ++row) {
      Vec2 shift;
      const std::int64_t line = g.y.first_copy(row, shift.y) * g.x.count;
      const std::uint32_t* const start = start_.data() + g.first + static_cast<std::size_t>(line);
      for (std::int64_t c = columns.first; c <= columns.last;) {
        const std::int64_t from = g.x.first_copy(c, shift.x), to = std::min(from + columns.last - c, g.x.count - 1);
        for (std::uint32_t k = start[from]; k < start[to + 1]; ++k) each(sorted_[k], shift);
        c += to - from + 1;
      }
    }
  }

  void choose(Level& g, std::span<const QueryItem> members);

  Vec2 period_;
  std::vector<QueryItem> items_, sorted_;
  std::vector<Level> levels_;
  std::vector<std::uint32_t> start_;
  std::vector<std::uint32_t> key_;
  std::vector<double> sample_;
};

}  // namespace psim
