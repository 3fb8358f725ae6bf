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

#include "psim/types.h"

namespace psim {

/// An item. Coordinates are metres from the centre of the lattice.
struct QueryItem {
  double x = 0, y = 0;
  float radius = 0;         ///< m: no part of the item is further from (x, y)
  std::uint32_t body = 0;   ///< id
  std::uint32_t piece = 0;  ///< the owner's number for it
};

class QueryGrid {
 public:
  /// Starts new grids for about `room` items. `period` is that of the two axes, m; 0: not periodic.
  void begin(Vec2 period, std::size_t room);
  void add(QueryItem item);
  void build();

  const std::vector<QueryItem>& items() const { return sorted_; }
  std::size_t bytes() const;

  /// Calls each(item, shift) for all items that may reach into the box, and for others. In a periodic world an item has
  /// copies; `shift` leads from the item to the copy that is meant.
  template <class Each>
  void in_box(Vec2 low, Vec2 high, const Each& each) const {
    for (const Level& g : levels_) {
      Range x = cells(g, 0, low.x - g.most, high.x + g.most);
      Range y = cells(g, 1, low.y - g.most, high.y + g.most);
      for (std::int64_t row = y.first; row <= y.last; ++row) run(g, row, x.first, x.last, each);
    }
  }

  /// Calls each(item, shift) for all items within `reach` of a point, grid by grid, in squares that grow up to `reach`,
  /// which `each` may lower. Items may come more than once.
  template <class Each>
  void around(Vec2 at, const double& reach, const Each& each) const {
    for (const Level& g : levels_) {
      for (double half = first_half(g, at);; half *= 2) {
        const double side = std::fmin(half, reach);
        const Range x = cells(g, 0, at.x - side - g.most, at.x + side + g.most);
        const Range y = cells(g, 1, at.y - side - g.most, at.y + side + g.most);
        for (std::int64_t row = y.first; row <= y.last; ++row) run(g, row, x.first, x.last, each);
        if (half >= reach || (covers(g, 0, x) && covers(g, 1, y))) break;
      }
    }
  }

  /// Calls each(item, shift) for all items that a ray may meet on its first `limit` metres, and for others, roughly in
  /// the order of the way. `each` may lower `limit`. `u` has length 1.
  template <class Each>
  void along(Vec2 from, Vec2 u, const double& limit, const Each& each) const {
    for (const Level& g : levels_) walk(g, from, u, limit, each);
  }

 private:
  struct Level {
    double most = 0;      // m: largest radius
    double low[2] = {};   // m: corner of the first cell
    double edge[2] = {};  // m
    double per[2] = {};   // 1/m: 1 / edge
    std::int64_t cells[2] = {};
    std::size_t first = 0;  // the first of its cells in start_
  };
  struct Range {
    std::int64_t first = 0, last = -1;
  };

  // The cells of an axis between two coordinates. In a world that is not periodic the outermost cells have no end.
  Range cells(const Level& g, int axis, double low, double high) const {
    const double a = (low - g.low[axis]) * g.per[axis], b = (high - g.low[axis]) * g.per[axis];
    const auto n = static_cast<double>(g.cells[axis]);
    if (!(period_[axis] > 0)) return {cell(a, n - 1), cell(b, n - 1)};
    if (b - a < 3 * n) return {whole(a), whole(b)};
    const double middle = (a + b) / 2;  // these copies suffice for a box no larger than the world
    return {whole(middle - 1.5 * n), whole(middle + 1.5 * n)};
  }

  static std::int64_t cell(double at, double last) {
    return static_cast<std::int64_t>(at > 0 ? (at < last ? at : last) : 0.0);
  }
  static std::int64_t whole(double at) {  // std::floor, which is a call without SSE4.1
    const auto cut = static_cast<std::int64_t>(at);
    return static_cast<double>(cut) > at ? cut - 1 : cut;
  }

  bool covers(const Level& g, int axis, const Range& r) const {
    if (period_[axis] > 0) return r.last - r.first + 1 >= 2 * g.cells[axis];
    return r.first == 0 && r.last + 1 == g.cells[axis];
  }

  // Half the side of the first square: the edge of a cell, or the distance to the grid from a point outside of it.
  double first_half(const Level& g, Vec2 at) const {
    double far = 0;
    const double point[2] = {at.x, at.y};
    for (int axis = 0; axis < 2; ++axis) {
      if (period_[axis] > 0) continue;
      const double high = g.low[axis] + g.edge[axis] * static_cast<double>(g.cells[axis]);
      far = std::fmax(far, std::fmax(g.low[axis] - point[axis], point[axis] - high));
    }
    return far + std::fmin(g.edge[0], g.edge[1]);
  }

  // Visits the items of the cells first..last of a row. In a periodic world these may be cells of any copy.
  template <class Each>
  void run(const Level& g, std::int64_t row, std::int64_t first, std::int64_t last, const Each& each) const {
    Vec2 shift;
    if (period_[1] > 0) row -= g.cells[1] * turns(row, g.cells[1], period_[1], shift.y);
    const std::uint32_t* const start = start_.data() + g.first + static_cast<std::size_t>(row * g.cells[0]);
    for (std::int64_t c = first; c <= last;) {
      std::int64_t base = 0, end = last;
      if (period_[0] > 0) {
        base = g.cells[0] * turns(c, g.cells[0], period_[0], shift.x);
        if (end > base + g.cells[0] - 1) end = base + g.cells[0] - 1;
      }
      const std::uint32_t stop = start[end - base + 1];
      for (std::uint32_t k = start[c - base]; k < stop; ++k) each(sorted_[k], shift);
      c = end + 1;
    }
  }

  static std::int64_t turns(std::int64_t cell, std::int64_t n, double period, double& shift) {
    const std::int64_t k = cell >= 0 ? cell / n : -((n - 1 - cell) / n);
    shift = static_cast<double>(k) * period;
    return k;
  }

  // Goes slab by slab along the axis on which the ray passes more cells.
  template <class Each>
  void walk(const Level& g, Vec2 from, Vec2 u, const double& limit, const Each& each) const {
    const double way[2] = {u.x, u.y}, origin[2] = {from.x, from.y};
    const int a = std::fabs(u.x) * g.edge[1] >= std::fabs(u.y) * g.edge[0] ? 0 : 1, b = 1 - a;
    const double r = g.most, edge = g.edge[a];
    const bool ahead = way[a] > 0, endless = !(period_[a] > 0);
    const double low = ahead ? origin[a] - r : origin[a] + limit * way[a] - r;
    const double high = ahead ? origin[a] + limit * way[a] + r : origin[a] + r;
    const Range slabs = cells(g, a, low, high);
    const std::int64_t count = slabs.last - slabs.first + 1;
    for (std::int64_t n = 0; n < count; ++n) {
      const std::int64_t slab = ahead ? slabs.first + n : slabs.last - n;
      double near = g.low[a] + edge * static_cast<double>(slab) - r;
      double far = near + edge + 2 * r;
      if (endless && slab == 0) near = -1e300;
      if (endless && slab == g.cells[a] - 1) far = 1e300;
      const double t0 = std::max(((ahead ? near : far) - origin[a]) / way[a], 0.0);
      const double t1 = std::min(((ahead ? far : near) - origin[a]) / way[a], limit);
      if (t0 > limit) return;
      if (t0 > t1) continue;
      const double s0 = origin[b] + t0 * way[b], s1 = origin[b] + t1 * way[b];
      const Range side = cells(g, b, std::min(s0, s1) - r, std::max(s0, s1) + r);
      if (a == 1) {
        run(g, slab, side.first, side.last, each);
      } else {
        for (std::int64_t row = side.first; row <= side.last; ++row) run(g, row, slab, slab, each);
      }
    }
  }

  void choose(Level& g, std::span<const std::uint32_t> members);

  double period_[2] = {};
  std::vector<QueryItem> items_, sorted_;
  std::vector<Level> levels_;
  std::vector<std::uint32_t> start_;
  std::vector<std::uint32_t> key_, order_;
  std::vector<double> sample_;
};

}  // namespace psim
