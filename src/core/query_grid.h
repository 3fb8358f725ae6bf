// Finds what lies near a place or a line: things with a centre and a reach, each in one cell of a
// uniform grid. Things of like size share a grid (a factor of four), so that few cells need a look
// whatever the sizes are.
//
// Made once, O(things); a box or a ray costs the cells that it passes. Cells lie side by side by row:
// 32 bytes a thing, 4 a cell, about one cell a thing. Far outliers share the outermost cells.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "psim/types.h"

namespace psim {

/// One of the things. Metres from the lattice's centre.
struct QueryItem {
  double x = 0, y = 0;
  float radius = 0;         ///< nothing of it is further from (x, y)
  std::uint32_t body = 0;   ///< id
  std::uint32_t piece = 0;  ///< what it is: the owner's business
};

class QueryGrid {
 public:
  /// `period`: of the two axes, 0: not periodic.
  /// `room`: how many things to expect.
  void begin(Vec2 period, std::size_t room);
  void add(QueryItem item);
  void build();

  const std::vector<QueryItem>& items() const { return sorted_; }
  std::size_t bytes() const;

  /// each(item, shift): all that may reach into the box, and others. `shift` leads from the item to
  /// the image that is meant.
  template <class Each>
  void in_box(Vec2 low, Vec2 high, const Each& each) const {
    for (const Level& g : levels_) {
      Range x = cells(g, 0, low.x - g.most, high.x + g.most);
      Range y = cells(g, 1, low.y - g.most, high.y + g.most);
      for (std::int64_t row = y.first; row <= y.last; ++row) run(g, row, x.first, x.last, each);
    }
  }

  /// The same within `reach` of a point, grid by grid, by squares that grow until they reach as far as
  /// `reach`, which `each` may make less. Items come up more than once.
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

  /// each(item, shift): all that a ray may meet on its first `limit` metres, and others, about in the
  /// order of the way. `each` may make `limit` less. `u`: of length 1.
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
    std::size_t first = 0;  // of its cells in start_
  };
  struct Range {
    std::int64_t first = 0, last = -1;
  };

  // Cells of an axis between two coordinates. Where nothing is periodic the outermost ones have no end.
  Range cells(const Level& g, int axis, double low, double high) const {
    const double a = (low - g.low[axis]) * g.per[axis], b = (high - g.low[axis]) * g.per[axis];
    const auto n = static_cast<double>(g.cells[axis]);
    if (!(period_[axis] > 0)) return {cell(a, n - 1), cell(b, n - 1)};
    if (b - a < 3 * n) return {whole(a), whole(b)};
    const double middle =
        (a + b) / 2;  // all images that matter to what is no larger than the world
    return {whole(middle - 1.5 * n), whole(middle + 1.5 * n)};
  }

  static std::int64_t cell(double at, double last) {
    return static_cast<std::int64_t>(at > 0 ? (at < last ? at : last) : 0.0);
  }
  static std::int64_t whole(double at) {  // floor; a call without SSE4.1
    const auto cut = static_cast<std::int64_t>(at);
    return static_cast<double>(cut) > at ? cut - 1 : cut;
  }

  bool covers(const Level& g, int axis, const Range& r) const {
    if (period_[axis] > 0) return r.last - r.first + 1 >= 2 * g.cells[axis];
    return r.first == 0 && r.last + 1 == g.cells[axis];
  }

  // Half a side that a first look takes: an edge, or to the grid if the point is outside of it.
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

  // Items of the cells first..last of a row; in periodic worlds those are cells of any image.
  template <class Each>
  void run(const Level& g, std::int64_t row, std::int64_t first, std::int64_t last,
           const Each& each) const {
    Vec2 shift;
    if (period_[1] > 0) row -= g.cells[1] * turns(row, g.cells[1], period_[1], shift.y);
    const std::uint32_t* const start =
        start_.data() + g.first + static_cast<std::size_t>(row * g.cells[0]);
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

  // Slab by slab along the axis on which the ray passes more cells.
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
