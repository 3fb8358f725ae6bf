// The rasterizer: every pixel's share of a figure is its exact area there, for any size and place.
#include "picture/coverage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "picture/outline.h"

namespace psim::cli {
namespace {

constexpr int kPixels = 40;
using Shares = std::vector<double>;

Shares shares_of(const std::vector<std::vector<Point>>& loops) {
  Coverage coverage;
  coverage.begin({0, 0, kPixels, kPixels});
  for (const auto& loop : loops) coverage.polygon(loop);
  Shares shares(kPixels * kPixels);
  for (int y = 0; y < kPixels; ++y) {
    const Coverage::Row row = coverage.take_row(y);
    for (std::size_t i = 0; i < row.shares.size(); ++i) {
      shares[static_cast<std::size_t>(y * kPixels + row.left) + i] = static_cast<double>(row.shares[i]);
    }
  }
  return shares;
}

double sum(const Shares& shares) {
  double total = 0;
  for (const double share : shares) total += share;
  return total;
}

// The share of pixel (x, y) that is inside, by 32 x 32 samples.
template <class Inside>
double sampled(int x, int y, const Inside& inside) {
  constexpr int kSamples = 32;
  int hits = 0;
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      hits += inside(x + (i + 0.5) / kSamples, y + (j + 0.5) / kSamples);
    }
  }
  return hits / static_cast<double>(kSamples * kSamples);
}

// A figure's rows do not depend on which of them are made.
TEST(Coverage, SomeRowsAreThoseOfTheWhole) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> place(-12, kPixels + 12);
  Coverage whole, some;
  for (int figure = 0; figure < 200; ++figure) {
    std::vector<Point> loop;
    for (int k = 0; k < 3 + figure % 5; ++k) loop.push_back({place(random), place(random)});
    const PixelBox box{figure % 3, 2, kPixels - figure % 4, kPixels - 1};
    const int first = 2 + figure % 20, end = first + 1 + figure % 17;
    whole.begin(box);
    some.begin(box, first, end);
    whole.polygon(loop);
    some.polygon(loop);
    for (int y = box.top; y < box.bottom; ++y) {
      const Coverage::Row all = whole.take_row(y);
      if (y < first || y >= end) continue;
      const Coverage::Row row = some.take_row(y);
      EXPECT_EQ(row.left, all.left);
      EXPECT_TRUE(std::ranges::equal(row.shares, all.shares)) << figure << ' ' << y;
    }
  }
}

bool is_within(const std::vector<Point>& convex, double x, double y) {
  const double side = twice_area(convex) < 0 ? -1 : 1;
  for (std::size_t k = 0; k < convex.size(); ++k) {
    const Point &p = convex[k], &q = convex[(k + 1) % convex.size()];
    if (side * ((q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x)) < 0) return false;
  }
  return true;
}

std::vector<Point> regular(int corners, double x, double y, double radius, double angle) {
  std::vector<Point> points;
  for (int k = 0; k < corners; ++k) {
    const double at = angle + 2 * std::numbers::pi * k / corners;
    points.push_back({x + radius * std::cos(at), y + radius * std::sin(at)});
  }
  return points;
}

std::vector<Point> disc(double x, double y, double radius) {
  std::vector<Point> points;
  for (const Point& p : unit_circle(radius)) points.push_back({x + radius * p.x, y + radius * p.y});
  return points;
}

TEST(Coverage, EveryPixelOfAPolygonHasItsArea) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-5, kPixels + 5), size(0.3, 30), angle(0, 6.3);
  for (int k = 0; k < 40; ++k) {  // some of them reach out of the picture
    const auto polygon = regular(3 + k % 6, place(random), place(random), size(random), angle(random));
    const Shares shares = shares_of({polygon});
    for (int y = 0; y < kPixels; y += 3) {
      for (int x = 0; x < kPixels; ++x) {
        const double wanted = sampled(x, y, [&](double u, double v) { return is_within(polygon, u, v); });
        ASSERT_NEAR(shares[static_cast<std::size_t>(y * kPixels + x)], wanted, 0.03) << k << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(Coverage, HalfPlanesAreExact) {
  // x < 7.25; y < 3.5; x + y < 10 with the diagonal through pixels; all reach far out of the picture.
  const double far = 1e6;
  const Shares left = shares_of({{{-far, -far}, {7.25, -far}, {7.25, far}, {-far, far}}});
  const Shares top = shares_of({{{-far, -far}, {far, -far}, {far, 3.5}, {-far, 3.5}}});
  const Shares corner = shares_of({{{10 - far, far}, {-far, -far}, {far, 10 - far}}});
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      const auto at = static_cast<std::size_t>(y * kPixels + x);
      EXPECT_NEAR(left[at], x < 7 ? 1 : x == 7 ? 0.25 : 0, 1e-5);
      EXPECT_NEAR(top[at], y < 3 ? 1 : y == 3 ? 0.5 : 0, 1e-5);
      EXPECT_NEAR(corner[at], x + y < 9 ? 1 : x + y == 9 ? 0.5 : 0, 1e-3) << x << ' ' << y;
    }
  }
}

TEST(Coverage, DiscsOfEverySizeHaveTheirArea) {
  for (const double r : {0.02, 0.1, 0.3, 0.36, 0.5, 0.7, 1.0, 1.65, 3.0, 7.7, 18.0}) {
    for (const double shift : {0.0, 0.13, 0.5, 0.77}) {
      const double area = std::numbers::pi * r * r;
      EXPECT_NEAR(sum(shares_of({disc(20 + shift, 20 - shift / 2, r)})), area, 1e-3 * area + 1e-5) << r;
    }
  }
}

TEST(Coverage, EveryPixelOfADiscIsRight) {
  for (const double r : {0.5, 0.9, 1.65, 3.3, 12.0}) {
    const double cx = 20.37, cy = 19.81;
    const Shares shares = shares_of({disc(cx, cy, r)});
    for (int y = 0; y < kPixels; ++y) {
      for (int x = 0; x < kPixels; ++x) {
        const double wanted = sampled(x, y, [&](double u, double v) { return std::hypot(u - cx, v - cy) < r; });
        EXPECT_NEAR(shares[static_cast<std::size_t>(y * kPixels + x)], wanted, 0.04) << r;
      }
    }
  }
}

TEST(Coverage, ATurnedBoxHasItsArea) {
  for (const double angle : {0.0, 0.1, 0.5, 0.785, 1.2}) {
    EXPECT_NEAR(sum(shares_of({regular(4, 20.3, 20.6, 9, angle)})), 162, 0.01) << angle;
    EXPECT_NEAR(sum(shares_of({regular(4, 20.3, 20.6, 0.2, angle)})), 0.08, 1e-5) << angle;
  }
}

TEST(Coverage, ALoopTheOtherWayRoundIsAHole) {
  const auto outside = disc(20, 20, 10);
  std::vector<Point> inside = disc(20, 20, 6);
  std::reverse(inside.begin(), inside.end());
  EXPECT_NEAR(sum(shares_of({outside, inside})), std::numbers::pi * 64, 0.05);
}

TEST(Coverage, WhatIsOutsideLeavesNoTrace) {
  for (const Point at : {Point{-30, 20}, Point{80, 20}, Point{20, -30}, Point{20, 80}, Point{1e12, -1e12}}) {
    EXPECT_NEAR(sum(shares_of({disc(at.x, at.y, 9)})), 0, 1e-4);
  }
  EXPECT_NEAR(sum(shares_of({disc(0, 0, 10)})), 25 * std::numbers::pi, 0.05);  // a quarter
  EXPECT_NEAR(sum(shares_of({disc(20, 20, 1e7)})), kPixels * kPixels, 0.05);
}

TEST(Outline, RoundedPolygonsHaveTheAreaOfTheirDefinition) {
  const double pi = std::numbers::pi;
  std::vector<Point> out;
  const auto area = [&] { return std::fabs(twice_area(out)) / 2; };
  for (const double r : {0.2, 1.0, 2.5}) {
    const std::vector<Point> capsule = {{10, 10}, {25, 18}};
    round_outline(capsule, r, out);
    EXPECT_NEAR(area(), pi * r * r + 2 * r * 17, 0.01 * area()) << r;
    std::vector<Point> box = regular(4, 20, 20, 8, 0.3);
    round_outline(box, r, out);
    EXPECT_NEAR(area(), 128 + 4 * r * 8 * std::numbers::sqrt2 + pi * r * r, 0.005 * area()) << r;
    const double forwards = area();
    std::reverse(box.begin(), box.end());
    round_outline(box, r, out);
    EXPECT_NEAR(area(), forwards, 1e-9);
    round_outline(std::vector<Point>{{3, 3}, {3, 3}}, r, out);
    EXPECT_NEAR(area(), pi * r * r, 1e-9);
  }
}

TEST(Outline, ShrinkingMovesTheSidesInwards) {
  std::vector<Point> out;
  shrink(std::vector<Point>{{0, 0}, {10, 0}, {10, 4}, {0, 4}}, 1, out);
  EXPECT_NEAR(std::fabs(twice_area(out)) / 2, 16, 1e-12);
  shrink(std::vector<Point>{{0, 4}, {10, 4}, {10, 0}, {0, 0}}, 1.5, out);
  EXPECT_NEAR(std::fabs(twice_area(out)) / 2, 7, 1e-12);
  shrink(std::vector<Point>{{0, 0}, {10, 0}, {10, 4}, {0, 4}}, 2.5, out);
  EXPECT_NEAR(std::fabs(twice_area(out)), 0, 1e-12);
}

}  // namespace
}  // namespace psim::cli
