#include "place/fluid_overlaps.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "base/rotor.h"

namespace psim {
namespace {

// So many places are looked at for each particle; then the rest stays where it is.
constexpr std::size_t kMostTries = 16, kFirstTries = 100'000;

// Bodies that fluids meet: not sensors, nor what collides with nothing.
QueryFilter solids() {
  QueryFilter filter;
  filter.category = 0x7FFFFFFF;
  return filter;
}

// Whether a particle there would be within a body. Places on its surface are, on all of its sides.
bool in_body(const World& world, Vec2 place, double spacing) {
  return world.closest(place, spacing / 1000, solids()).has_value();
}

// Parts places into those outside all bodies and those within one. Most are far from any, so that a few are asked about
// at a time first.
void part(const World& world, std::span<const Vec2> places, double spacing, std::vector<Vec2>& outside,
          std::vector<Vec2>& within) {
  constexpr std::size_t kAtATime = 64;
  for (std::size_t first = 0; first < places.size(); first += kAtATime) {
    const std::span<const Vec2> some = places.subspan(first, std::min(kAtATime, places.size() - first));
    Bounds box{some[0].x, some[0].y, some[0].x, some[0].y};
    for (const Vec2& p : some) {
      box = {std::min(box.xmin, p.x), std::min(box.ymin, p.y), std::max(box.xmax, p.x), std::max(box.ymax, p.y)};
    }
    const bool alone =
        world.in_region({box.xmin - spacing, box.ymin - spacing, box.xmax + spacing, box.ymax + spacing}, solids())
            .empty();
    for (const Vec2& p : some) (!alone && in_body(world, p, spacing) ? within : outside).push_back(p);
  }
}

bool is_inside(const Bounds& area, Vec2 p) {
  return p.x >= area.xmin && p.x <= area.xmax && p.y >= area.ymin && p.y <= area.ymax;
}
bool is_inside(const FluidDisc& area, Vec2 p) {
  const Vec2 d = p - area.position;
  return d.x * d.x + d.y * d.y <= area.radius * area.radius;
}
bool is_inside(const FluidPolygon& area, Vec2 p) {
  bool inside = false;
  for (std::size_t k = 0; k < area.vertices.size(); ++k) {
    const Vec2 a = area.vertices[k], b = area.vertices[(k + 1) % area.vertices.size()];
    if ((a.y <= p.y) != (b.y <= p.y) && crossing(a, b, p.y) > p.x) inside = !inside;
  }
  return inside;
}
bool is_inside(const FluidList& /*area*/, Vec2 /*p*/) { return false; }

// Directions by gravity: lines of a lattice go up, along the axis that is nearest to it.
struct Upward {
  bool along_x;
  double sign;

  explicit Upward(Vec2 gravity)
      : along_x(std::fabs(gravity.x) > std::fabs(gravity.y)), sign((along_x ? gravity.x : gravity.y) > 0 ? -1 : 1) {}
  double line(Vec2 p) const { return along_x ? p.y : p.x; }
  double height(Vec2 p) const { return sign * (along_x ? p.x : p.y); }
  Vec2 place(double line, double height) const {
    return along_x ? Vec2{sign * height, line} : Vec2{line, sign * height};
  }
};

// The highest place of each line.
std::vector<std::pair<double, double>> tops_of(const std::vector<Vec2>& places, const Upward& up) {
  std::vector<std::pair<double, double>> tops;
  tops.reserve(places.size());
  for (const Vec2& p : places) tops.emplace_back(up.line(p), up.height(p));
  std::ranges::sort(tops);  // Total order: these are pairs of numbers, and equal ones are the same.
  std::size_t lines = 0;
  for (std::size_t k = 0; k < tops.size(); ++k) {
    if (k + 1 < tops.size() && tops[k + 1].first == tops[k].first) continue;
    tops[lines++] = tops[k];
  }
  tops.resize(lines);
  return tops;
}

// Finds places row by row above an area.
class RowsAbove {
 public:
  RowsAbove(const World& world, const Scene& scene, std::size_t fluid, const std::vector<Vec2>& area)
      : world_(world), scene_(scene), fluid_(fluid), up_(scene.world.gravity), tops_(tops_of(area, up_)) {
    const Bounds& b = scene.world.bounds;
    ceiling_ = std::max(up_.height({b.xmin, b.ymin}), up_.height({b.xmax, b.ymax})) - spacing() / 2;
    tries_ = kMostTries * area.size() + kFirstTries;
  }

  // The free places of the next row; false if there is no room for more rows.
  bool next(std::vector<Vec2>& row) {
    row.clear();
    ++level_;
    bool room = false;
    for (const auto& [line, top] : tops_) {
      const double height = top + level_ * spacing();
      if (scene_.world.boundary != Boundary::open && !(height <= ceiling_ + kRounding * spacing())) continue;
      if (tries_ == 0) return false;
      --tries_;
      room = true;
      const Vec2 place = up_.place(line, height);
      if (!in_other(place) && !in_body(world_, place, spacing())) row.push_back(place);
    }
    return room;
  }

 private:
  static constexpr double kRounding = 1e-6;

  double spacing() const { return scene_.fluids[fluid_].fluid.spacing; }
  bool in_other(Vec2 place) const {
    for (std::size_t k = 0; k < scene_.fluids.size(); ++k) {
      if (k == fluid_) continue;
      if (std::visit([&](const auto& area) { return is_inside(area, place); }, scene_.fluids[k].place)) return true;
    }
    return false;
  }

  const World& world_;
  const Scene& scene_;
  std::size_t fluid_;
  Upward up_;
  std::vector<std::pair<double, double>> tops_;
  double ceiling_ = 0, level_ = 0;
  std::size_t tries_ = 0;
};

}  // namespace

void lay_above_bodies(const World& world, const Scene& scene, std::size_t k, PlacedParticles& placed) {
  if (world.body_count() == 0 || std::holds_alternative<FluidList>(scene.fluids[k].place)) return;
  std::vector<Vec2> kept, within;
  part(world, placed.positions, scene.fluids[k].fluid.spacing, kept, within);
  if (within.empty()) return;
  RowsAbove rows(world, scene, k, placed.positions);
  std::vector<Vec2> row;
  std::size_t left = within.size();
  while (left > 0 && rows.next(row)) {
    const std::size_t taken = std::min(left, row.size());
    for (std::size_t i = 0; i < taken; ++i) kept.push_back(row[(2 * i + 1) * row.size() / (2 * taken)]);
    left -= taken;
  }
  kept.insert(kept.end(), within.end() - static_cast<std::ptrdiff_t>(left), within.end());
  placed.positions = std::move(kept);
}

}  // namespace psim
