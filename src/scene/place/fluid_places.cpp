#include "place/fluid_places.h"

#include <algorithm>
#include <cmath>

#include "base/range_text.h"

namespace psim {
namespace {

constexpr std::uint64_t kTooMany = kMostParticles + 1;

// A lattice over a rectangle: it begins half a spacing from the lower left corner.
struct ParticleLattice {
  Bounds box;
  double spacing = 0, columns = 0, rows = 0;

  ParticleLattice(const Bounds& b, double s)
      : box(b), spacing(s), columns(std::round((b.xmax - b.xmin) / s)), rows(std::round((b.ymax - b.ymin) / s)) {}
  // The last place may be rounded out of the rectangle.
  double x(double column) const { return std::min(box.xmin + (column + 0.5) * spacing, box.xmax); }
  double y(double row) const { return std::min(box.ymin + (row + 0.5) * spacing, box.ymax); }
  bool has_few_rows() const { return std::max(columns, rows) <= static_cast<double>(kMostFluidRows); }
};

Bounds box_of(const FluidPolygon& polygon) {
  Bounds b{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const Vec2& v : polygon.vertices) {
    b.xmin = std::min(b.xmin, v.x);
    b.ymin = std::min(b.ymin, v.y);
    b.xmax = std::max(b.xmax, v.x);
    b.ymax = std::max(b.ymax, v.y);
  }
  return b;
}

// Where the sides of a polygon cross the height y, from left to right. What lies between the first and the second, the
// third and the fourth and so on is inside.
void crossings(const FluidPolygon& polygon, double y, std::vector<double>& out) {
  out.clear();
  for (std::size_t k = 0; k < polygon.vertices.size(); ++k) {
    const Vec2 p = polygon.vertices[k], q = polygon.vertices[(k + 1) % polygon.vertices.size()];
    if ((p.y <= y) != (q.y <= y)) out.push_back(crossing(p, q, y));
  }
  std::ranges::sort(out);  // Total order: these are numbers, and equal ones are the same.
}

// Calls row(y, first column, one beyond the last) for every run of lattice places within the shape, rows from the bottom.
// False if it has too many.
struct EachRun {
  double spacing;

  template <class Row>
  bool operator()(const Bounds& region, const Row& row) const {
    const ParticleLattice l(region, spacing);
    if (!(l.columns * l.rows <= static_cast<double>(kMostParticles))) return false;
    for (double j = 0; j < l.rows; ++j) row(l, j, 0.0, l.columns);
    return true;
  }
  template <class Row>
  bool operator()(const FluidDisc& disc, const Row& row) const {
    const Vec2 c = disc.position;
    const double r = disc.radius;
    const ParticleLattice l({c.x - r, c.y - r, c.x + r, c.y + r}, spacing);
    if (!l.has_few_rows()) return false;
    for (double j = 0; j < l.rows; ++j) {
      const double up = l.y(j) - c.y, half = std::sqrt(std::max(r * r - up * up, 0.0));
      if (std::fabs(up) <= r) between(l, j, c.x - half, c.x + half, row);
    }
    return true;
  }
  template <class Row>
  bool operator()(const FluidPolygon& polygon, const Row& row) const {
    const ParticleLattice l(box_of(polygon), spacing);
    if (!l.has_few_rows()) return false;
    std::vector<double> at;
    for (double j = 0; j < l.rows; ++j) {
      crossings(polygon, l.y(j), at);
      for (std::size_t k = 0; k + 1 < at.size(); k += 2) between(l, j, at[k], at[k + 1], row);
    }
    return true;
  }
  template <class Row>
  bool operator()(const FluidList& /*list*/, const Row& /*row*/) const {
    return true;
  }

 private:
  // The places of a row from `left` to `right`.
  template <class Row>
  static void between(const ParticleLattice& l, double j, double left, double right, const Row& row) {
    const double first = std::max(std::ceil((left - l.box.xmin) / l.spacing - 0.5), 0.0);
    const double end = std::min(std::floor((right - l.box.xmin) / l.spacing - 0.5) + 1, l.columns);
    if (first < end) row(l, j, first, end);
  }
};

template <class Row>
bool each_run(const SceneFluid& fluid, const Row& row) {
  return std::visit([&](const auto& place) { return EachRun{fluid.fluid.spacing}(place, row); }, fluid.place);
}

void take_list(const SceneFluid& fluid, const FluidList& list, PlacedParticles& out) {
  const std::size_t n = list.x.size();
  out.positions.resize(n);
  for (std::size_t k = 0; k < n; ++k) out.positions[k] = {list.x[k], list.y[k]};
  if (list.vx.empty() && list.vy.empty()) return;
  out.velocities.assign(n, fluid.velocity);
  for (std::size_t k = 0; k < list.vx.size(); ++k) out.velocities[k].x = list.vx[k];
  for (std::size_t k = 0; k < list.vy.size(); ++k) out.velocities[k].y = list.vy[k];
}

// Columns of a list have one length, or are left out.
bool fits(const FluidList& list) {
  const std::size_t n = list.x.size();
  return list.y.size() == n && (list.vx.empty() || list.vx.size() == n) && (list.vy.empty() || list.vy.size() == n);
}

}  // namespace

std::uint64_t count_particles(const SceneFluid& fluid) {
  if (const auto* list = std::get_if<FluidList>(&fluid.place)) return list->x.size();
  if (!(fluid.fluid.spacing > 0)) return 0;
  std::uint64_t count = 0;
  const auto add = [&](const ParticleLattice&, double, double first, double end) {
    count = std::min(count + static_cast<std::uint64_t>(end - first), kTooMany);
  };
  return each_run(fluid, add) ? count : kTooMany;
}

bool place_particles(const SceneFluid& fluid, PlacedParticles& out, std::string& error) {
  const std::uint64_t count = count_particles(fluid);
  if (count > kMostParticles) {
    error = "more than " + std::to_string(kMostParticles) + " particles: a larger spacing or a smaller region";
    return false;
  }
  const auto* list = std::get_if<FluidList>(&fluid.place);
  if (list != nullptr && !fits(*list)) {
    error = "x, y, vx and vy have different lengths: one number for each particle";
    return false;
  }
  out = {};
  if (list != nullptr) {
    take_list(fluid, *list, out);
  } else {
    out.positions.reserve(static_cast<std::size_t>(count));
    each_run(fluid, [&](const ParticleLattice& l, double row, double first, double end) {
      for (double column = first; column < end; ++column) out.positions.push_back({l.x(column), l.y(row)});
    });
  }
  if (out.positions.empty() && list == nullptr) {
    error = "has no room for a particle: spacing " + exact_text(fluid.fluid.spacing) + " m";
    return false;
  }
  const bool moves = fluid.velocity.x != 0 || fluid.velocity.y != 0;
  if (out.velocities.empty() && moves) out.velocities.assign(out.positions.size(), fluid.velocity);
  return true;
}

}  // namespace psim
