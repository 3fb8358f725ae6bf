// Convex hulls of points: Andrew's monotone chain, then corners go, the flattest first, as long as no point comes to lie
// farther outside than the tolerance. O(n log n).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <new>
#include <queue>
#include <tuple>
#include <utility>

#include "base/elementary.h"
#include "base/machine.h"
#include "base/room.h"
#include "base/rotor.h"
#include "psim/geometry.h"
#include "psim/limits.h"

namespace psim {
namespace {

constexpr double kFlat = 1e-6;  // of the extent; of its square for areas

bool further_left(Vec2 a, Vec2 b) { return std::tie(a.x, a.y) < std::tie(b.x, b.y); }

// From the lowest of the leftmost points counter-clockwise.
std::vector<Vec2> wrap(std::vector<Vec2> points) {
  for (Vec2& p : points) p = p + Vec2{};                  // zeros have one sign
  std::sort(points.begin(), points.end(), further_left);  // Total order: equal points are alike.
  std::vector<Vec2> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Vec2 p : points) {
      while (hull.size() >= base + 2 && !(cross(hull.back() - hull[hull.size() - 2], p - hull[hull.size() - 2]) > 0)) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// m: from a point to the line between two others.
double distance_to(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 way = b - a;
  const double square = dot(way, way);
  const double share = square > 0 ? dot(p - a, way) / square : 0;
  return length_of(p - (a + lesser(greater(share, 0.0), 1.0) * way));
}

// A hull that loses corners. `outside[k]`: no point that was left out lies farther outside of the edge from corner k to the
// next one, m.
struct Thinning {
  explicit Thinning(std::vector<Vec2> hull)
      : corners(std::move(hull)), outside(corners.size(), 0), left(corners.size()) {
    for (std::size_t k = 0; k < corners.size(); ++k) {
      before.push_back(static_cast<std::uint32_t>(k == 0 ? corners.size() - 1 : k - 1));
      after.push_back(static_cast<std::uint32_t>(k + 1 < corners.size() ? k + 1 : 0));
    }
  }

  // m: how far a point may lie outside once corner k is gone.
  double cost(std::uint32_t k) const {
    return greater(outside[before[k]], outside[k]) + distance_to(corners[k], corners[before[k]], corners[after[k]]);
  }

  void drop(std::uint32_t k) {
    outside[before[k]] = cost(k);
    after[before[k]] = after[k];
    before[after[k]] = before[k];
    before[k] = after[k] = k;
    --left;
  }
  bool is_gone(std::uint32_t k) const { return after[k] == k; }

  std::vector<Vec2> corners;
  std::vector<double> outside;
  std::vector<std::uint32_t> before = {}, after = {};
  std::size_t left;
};

std::vector<Vec2> without_flat(std::vector<Vec2> hull, double tolerance) {
  using Entry = std::pair<double, std::uint32_t>;
  Thinning thin(std::move(hull));
  // Total order: pairs of a cost and a number. Costs that are out of date are passed over.
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> flattest;
  const auto enter = [&](std::uint32_t k) {
    if (const double cost = thin.cost(k); cost <= tolerance) flattest.emplace(cost, k);
  };
  for (std::uint32_t k = 0; k < thin.corners.size(); ++k) enter(k);
  while (!flattest.empty() && thin.left > 3) {
    const auto [cost, k] = flattest.top();
    flattest.pop();
    if (thin.is_gone(k) || thin.cost(k) != cost) continue;
    const std::uint32_t last = thin.before[k], next = thin.after[k];
    thin.drop(k);
    enter(last);
    enter(next);
  }
  std::vector<Vec2> out;
  for (std::uint32_t k = 0; k < thin.corners.size(); ++k) {
    if (!thin.is_gone(k)) out.push_back(thin.corners[k]);
  }
  std::rotate(out.begin(), std::min_element(out.begin(), out.end(), further_left), out.end());
  return out;
}

double area_of(const std::vector<Vec2>& polygon) {
  double twice = 0;
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    twice += cross(polygon[k] - polygon[0], polygon[k + 1] - polygon[0]);
  }
  return twice / 2;
}

}  // namespace

std::vector<Vec2> convex_hull(std::span<const Vec2> points, double tolerance) try {
  const FloatSettings settings;
  if (points.size() < 3 || points.size() > 0xFFFFFFFFu || !limits::kLength.contains(tolerance)) return {};
  Vec2 low = points[0], high = points[0];
  for (const Vec2 p : points) {
    if (!limits::kCoordinate.contains(p)) return {};
    low = {lesser(p.x, low.x), lesser(p.y, low.y)};
    high = {greater(p.x, high.x), greater(p.y, high.y)};
  }
  const double extent = greater(high.x - low.x, high.y - low.y);
  if (!limits::kExtent.contains(extent)) return {};
  std::vector<Vec2> hull = wrap({points.begin(), points.end()});
  if (hull.size() < 3) return {};
  hull = without_flat(std::move(hull), greater(tolerance, kFlat * extent));
  if (!(area_of(hull) > kFlat * extent * extent)) return {};
  return hull;
} catch (const std::bad_alloc&) {
  ran_out_of_memory() = true;
  return {};
}

}  // namespace psim
