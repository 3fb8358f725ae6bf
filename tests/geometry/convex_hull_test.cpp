// Convex hulls against their definition: no point lies farther out in any direction than the hull does.
#include "support.h"

namespace psim::test {
namespace {

double turn_at(const std::vector<Vec2>& p, std::size_t k) {
  const Vec2 a = p[k], b = p[(k + 1) % p.size()], c = p[(k + 2) % p.size()];
  return (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
}

// m: how far the points reach beyond the hull in the worst of many directions.
double beyond(const std::vector<Vec2>& points, const std::vector<Vec2>& hull) {
  double worst = -1e300;
  for (int k = 0; k < 720; ++k) {
    const double x = std::cos(kPi * k / 360), y = std::sin(kPi * k / 360);
    const auto reach = [&](const std::vector<Vec2>& of) {
      double most = -1e300;
      for (const Vec2 p : of) most = std::max(most, p.x * x + p.y * y);
      return most;
    };
    worst = std::max(worst, reach(points) - reach(hull));
  }
  return worst;
}

void expect_hull(const std::vector<Vec2>& points, const std::vector<Vec2>& hull, double tolerance) {
  ASSERT_GE(hull.size(), 3u);
  for (std::size_t k = 0; k < hull.size(); ++k) {
    EXPECT_GT(turn_at(hull, k), 0) << "counter-clockwise and convex";
    EXPECT_NE(std::find(points.begin(), points.end(), hull[k]), points.end()) << "a corner is one of the points";
    EXPECT_TRUE(k == 0 || hull[0].x < hull[k].x || (hull[0].x == hull[k].x && hull[0].y < hull[k].y));
  }
  EXPECT_LE(beyond(points, hull), tolerance);
}

TEST(ConvexHull, HoldsAllPoints) {
  Random r(1);
  for (int n = 0; n < 600; ++n) {
    std::vector<Vec2> points;
    const std::size_t count = 3 + r.below(40);
    const double size = std::exp(r.uniform(-10, 10));
    const Vec2 off{size * r.uniform(-100, 100), size * r.uniform(-100, 100)};
    for (std::size_t k = 0; k < count; ++k) {
      points.push_back({off.x + size * r.uniform(-1, 1), off.y + size * r.uniform(-1, 1)});
      if (r.chance(0.2)) points.push_back(points.back());
    }
    const std::vector<Vec2> hull = convex_hull(points);
    expect_hull(points, hull, 3e-6 * size);
    if (hull.size() > kMostPolygonVertices) continue;
    EXPECT_TRUE(shape_bounds(PolygonShape{hull, 0})) << n;
    // Whatever the order of the points.
    std::reverse(points.begin(), points.end());
    EXPECT_EQ(convex_hull(points), hull);
    EXPECT_EQ(convex_hull(hull), hull);
  }
}

TEST(ConvexHull, LeavesOutWhatLiesOnItsSides) {
  std::vector<Vec2> grid;
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) grid.push_back({0.1 * x, 0.1 * y});
  }
  EXPECT_EQ(convex_hull(grid), (std::vector<Vec2>{{0, 0}, {0.1 * 19, 0}, {0.1 * 19, 0.1 * 19}, {0, 0.1 * 19}}));
}

TEST(ConvexHull, KeepsToTheTolerance) {
  Random r(2);
  for (int n = 0; n < 200; ++n) {
    std::vector<Vec2> points;
    for (int k = 0; k < 300; ++k) points.push_back({3 * r.normal(), r.normal()});
    const double tolerance = r.uniform(0, 0.5);
    const std::vector<Vec2> hull = convex_hull(points, tolerance), whole = convex_hull(points);
    expect_hull(points, hull, tolerance);
    EXPECT_LE(hull.size(), whole.size());
  }
  // A circle of many points: few remain, and none lies farther outside than was allowed.
  std::vector<Vec2> circle;
  for (int k = 0; k < 100000; ++k) circle.push_back({std::cos(2e-5 * kPi * k), std::sin(2e-5 * kPi * k)});
  const std::vector<Vec2> fine = convex_hull(circle), coarse = convex_hull(circle, 0.01);
  expect_hull(circle, fine, 2e-6);
  expect_hull(circle, coarse, 0.01);
  EXPECT_LT(fine.size(), 4000u);
  EXPECT_LT(coarse.size(), 50u);
  EXPECT_EQ(convex_hull(circle, 100).size(), 3u) << "a hull keeps three corners";
}

TEST(ConvexHull, IsNoneOfPointsThatSpanNoArea) {
  EXPECT_TRUE(convex_hull({}).empty());
  const auto none = [](const std::vector<Vec2>& points, double tolerance = 0) {
    return convex_hull(points, tolerance).empty();
  };
  EXPECT_TRUE(none({{1, 1}}));
  EXPECT_TRUE(none({{1, 1}, {2, 2}}));
  EXPECT_TRUE(none({{1, 1}, {2, 2}, {3, 3}, {-4, -4}}));
  EXPECT_TRUE(none({{1, 1}, {1, 1}, {1, 1}}));
  EXPECT_TRUE(none({{0, 0}, {1, 0}, {0.5, 1e-7}}));
  EXPECT_FALSE(none({{0, 0}, {1, 0}, {0.5, 1e-5}}));
  EXPECT_TRUE(none({{0, 0}, {1e-10, 0}, {0, 1e-10}})) << "too small";
  EXPECT_TRUE(none({{0, 0}, {1, 0}, {0, kNan}}));
  EXPECT_TRUE(none({{0, 0}, {1, 0}, {0, kInf}}));
  EXPECT_TRUE(none({{0, 0}, {1, 0}, {0, 2e9}}));
  EXPECT_TRUE(none({{0, 0}, {1, 0}, {0, 1}}, -1));
  EXPECT_TRUE(none({{0, 0}, {1, 0}, {0, 1}}, kNan));
  EXPECT_FALSE(none({{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_FALSE(out_of_memory());
}

}  // namespace
}  // namespace psim::test
