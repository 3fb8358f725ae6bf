// Pictures: shapes cover the area that they have, wherever their edges fall between pixels.
#include "../src/psim/canvas.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace psim::cli {
namespace {

constexpr int kSide = 64;

// The light on a black canvas, in pixels of full white.
template <class Paint>
double light(const Paint& paint) {
  Canvas canvas(kSide, kSide, Colour{});
  paint(canvas);
  double sum = 0;
  const auto bytes = canvas.to_srgb();
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const double s = bytes[k] / 255.0;
    sum += s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
  }
  return sum;
}

double convex_light(const std::vector<Point>& points, float radius) {
  return light([&](Canvas& canvas) { canvas.convex(points, radius, {1, 1, 1}); });
}

// A square of this side about (x, y), turned by `angle`.
std::vector<Point> square(double side, double x, double y, double angle) {
  std::vector<Point> points;
  for (int k = 0; k < 4; ++k) {
    const double at = angle + std::numbers::pi / 4 * (2 * k + 1), r = side / std::numbers::sqrt2;
    points.push_back(
        {static_cast<float>(x + r * std::cos(at)), static_cast<float>(y + r * std::sin(at))});
  }
  return points;
}

TEST(Canvas, ConvexShapesCoverTheirArea) {
  for (const double angle : {0.0, 0.2, 0.7}) {
    for (const double shift : {0.0, 0.3, 0.5}) {
      const double area = convex_light(square(5, 30 + shift, 31, angle), 0);
      EXPECT_NEAR(area, 25, 1.3) << angle << ' ' << shift;
    }
  }
  const double pi = std::numbers::pi;
  EXPECT_NEAR(convex_light({{20, 30}, {40, 33}}, 2.5f), pi * 6.25 + 5 * std::hypot(20, 3), 2);
  EXPECT_NEAR(convex_light({{30.3f, 30}}, 2.9f), light([](Canvas& canvas) {
                canvas.disc(30.3f, 30, 2.9f, {1, 1, 1});
              }),
              1e-6);
  EXPECT_NEAR(convex_light(square(4, 30, 30, 0.3), 0.75f), 16 + 16 * 0.75 + pi * 0.5625, 1.5);
}

TEST(Canvas, OrderOfTheCornersDoesNotMatter) {
  std::vector<Point> points = square(20, 31, 33, 0.4);
  const double forwards = convex_light(points, 1);
  std::swap(points[1], points[3]);
  EXPECT_NEAR(convex_light(points, 1), forwards, 1e-6);
}

TEST(Canvas, ShapesOutsideAndWithoutAreaPaintNothing) {
  EXPECT_EQ(convex_light(square(10, -50, 30, 0), 0), 0);
  EXPECT_EQ(convex_light(square(10, 1e9, 30, 0), 0), 0);
  EXPECT_EQ(convex_light({{10, 10}, {50, 50}}, 0), 0);
  EXPECT_EQ(convex_light({}, 5), 0);
}

TEST(Canvas, TinyShapesKeepTheirBrightness) {
  for (const double side : {0.25, 0.5, 1.0}) {
    const std::vector<Point> thin = {{10, 20},
                                     {40, 22},
                                     {40, 22 + static_cast<float>(side)},
                                     {10, 20 + static_cast<float>(side)}};
    EXPECT_NEAR(convex_light(thin, 0), 30 * side, 6 * side + 0.5) << side;
    EXPECT_NEAR(convex_light(square(side, 30.2, 30.6, 0.3), 0), side * side,
                0.35 * side * side + 0.02);
  }
}

}  // namespace
}  // namespace psim::cli
