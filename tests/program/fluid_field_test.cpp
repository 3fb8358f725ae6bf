// The grids that surfaces of fluids are drawn from.
#include "surface/fluid_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace psim::cli {
namespace {

constexpr double kSpacing = 0.1;

// Particles of the region 0 to `width`, 0 to `height`, each somewhere in a square of its own.
std::vector<Vec2> pool(double width, double height, double jitter = 1) {
  std::mt19937 random(3);
  const auto shift = [&] { return jitter * (static_cast<double>(random() % 1000) / 1000 - 0.5); };
  std::vector<Vec2> places;
  for (int j = 0; j < std::lround(height / kSpacing); ++j) {
    for (int i = 0; i < std::lround(width / kSpacing); ++i) {
      places.push_back({kSpacing * (i + 0.5 + shift()), kSpacing * (j + 0.5 + shift())});
    }
  }
  return places;
}

FluidGrid grid_of(Bounds world, Boundary boundary, double pixel = 0.02) {
  return {kSpacing, pixel, world, world, boundary};
}

FluidField make(const std::vector<Vec2>& places, const FluidGrid& grid, const std::vector<float>& values = {}) {
  FluidField field;
  make_fluid_field(places, values, grid, field);
  return field;
}

// As between the nodes of a picture.
double fullness(const FluidField& f, Vec2 at) {
  const double x = (at.x - f.origin.x) / f.cell, y = (at.y - f.origin.y) / f.cell;
  const auto i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  if (i < 0 || j < 0 || i + 1 >= f.columns || j + 1 >= f.rows) return 0;
  const auto node = [&](int di, int dj) {
    return static_cast<double>(f.fullness[static_cast<std::size_t>((j + dj) * f.columns + i + di)]);
  };
  const double fx = x - i, fy = y - j;
  return (1 - fy) * ((1 - fx) * node(0, 0) + fx * node(1, 0)) + fy * ((1 - fx) * node(0, 1) + fx * node(1, 1));
}
bool is_wet(const FluidField& f, Vec2 at) { return fullness(f, at) >= static_cast<double>(kFluidEdge); }

// The area within the outline, from points 1 cm apart.
double wet_area(const FluidField& f, const Bounds& part) {
  constexpr double kStep = 0.01;
  double area = 0;
  for (double y = part.ymin + kStep / 2; y < part.ymax; y += kStep) {
    for (double x = part.xmin + kStep / 2; x < part.xmax; x += kStep) area += is_wet(f, {x, y}) ? kStep * kStep : 0;
  }
  return area;
}

TEST(FluidField, APoolIsFullAndHasNearlyItsArea) {
  const Bounds world{-2, -2, 5, 4};
  for (const double jitter : {0.0, 1.0}) {
    const FluidField f = make(pool(3, 2, jitter), grid_of(world, Boundary::open));
    EXPECT_NEAR(wet_area(f, world), 6 + 10 * 0.25 * kSpacing, 0.25) << jitter;
    for (double y = 0.15; y < 1.85; y += 0.03) {
      for (double x = 0.15; x < 2.85; x += 0.03) EXPECT_TRUE(is_wet(f, {x, y})) << jitter << " " << x << " " << y;
    }
    EXPECT_FALSE(is_wet(f, {3.15, 1}));
    EXPECT_FALSE(is_wet(f, {1, -0.15}));
  }
}

// Strings of particles two and a half spacings apart, as a flow that is drawn out has them.
TEST(FluidField, GapsBetweenStringsAreClosed) {
  std::vector<Vec2> places;
  for (int j = 0; j < 12; ++j) {
    for (int i = 0; i < 75; ++i) places.push_back({0.04 * i, 0.25 * j});
  }
  const FluidField f = make(places, grid_of({-2, -2, 5, 5}, Boundary::open));
  for (double y = 0.3; y < 2.5; y += 0.02) EXPECT_TRUE(is_wet(f, {1.5, y})) << y;
}

TEST(FluidField, AnAirPocketStaysOpen) {
  std::vector<Vec2> places = pool(3, 3);
  std::erase_if(places, [](Vec2 at) { return std::hypot(at.x - 1.5, at.y - 1.5) < 0.4; });
  const FluidField f = make(places, grid_of({0, 0, 3, 3}, Boundary::walls));
  EXPECT_FALSE(is_wet(f, {1.5, 1.5}));
  EXPECT_FALSE(is_wet(f, {1.7, 1.5}));
  EXPECT_TRUE(is_wet(f, {2.1, 1.5}));
}

TEST(FluidField, ItTouchesWallsAndTheSeam) {
  const Bounds world{0, 0, 3, 3};
  for (const Boundary boundary : {Boundary::walls, Boundary::periodic}) {
    const FluidField f = make(pool(3, 2), grid_of(world, boundary));
    for (double y = 0.2; y < 1.8; y += 0.05) {
      EXPECT_TRUE(is_wet(f, {0, y})) << y;
      EXPECT_TRUE(is_wet(f, {3, y})) << y;
    }
    EXPECT_TRUE(is_wet(f, {0.001, 0.001}) && is_wet(f, {2.999, 0.001}));
    EXPECT_EQ(is_wet(f, {1.5, 2.99}), boundary == Boundary::periodic);  // half a spacing over the upper side
  }
  const FluidField f = make(pool(3, 2), grid_of(world, Boundary::periodic));
  for (double y = 0.1; y < 2.9; y += 0.1) EXPECT_NEAR(fullness(f, {0, y}), fullness(f, {3, y}), 1e-3) << y;
}

// Only a fluid that comes near the seam needs a grid over all of a periodic world.
TEST(FluidField, APoolAwayFromTheSeamHasASmallGrid) {
  const Bounds world{-5, -5, 15, 15};
  FluidField f = make(pool(3, 2), grid_of(world, Boundary::periodic));
  EXPECT_LT(f.columns * f.cell, 5);
  std::vector<Vec2> places = pool(3, 2);
  places.push_back({14.98, 1});
  f = make(places, grid_of(world, Boundary::periodic));
  EXPECT_GT(f.columns * f.cell, 20);
  EXPECT_LT(f.rows * f.cell, 4);
  EXPECT_TRUE(is_wet(f, {-5, 1}) && is_wet(f, {14.98, 1}));
}

TEST(FluidField, ADropOfOneParticleIsSeenWhereverItIs) {
  for (const double pixel : {0.002, 0.01, 0.03}) {
    for (int k = 0; k < 25; ++k) {
      const Vec2 at{1 + 0.013 * k, 1 + 0.007 * k};
      const FluidField f = make({at}, grid_of({0, 0, 3, 3}, Boundary::open, pixel));
      ASSERT_LE(f.cell, kSpacing / 2);
      EXPECT_TRUE(f.lone.empty());
      const double area = wet_area(f, {0.5, 0.5, 2, 2});
      EXPECT_GT(area, 0.3 * kSpacing * kSpacing) << pixel << " " << k;
      EXPECT_LT(area, 1.5 * kSpacing * kSpacing) << pixel << " " << k;
    }
  }
}

// Where a pixel is wider than a particle, those that the grid loses are named.
TEST(FluidField, FarAwayLoneParticlesAreNamed) {
  std::vector<Vec2> places = pool(10, 10);
  const auto alone = static_cast<std::uint32_t>(places.size());
  places.push_back({15, 15});
  const FluidField f = make(places, grid_of({0, 0, 20, 20}, Boundary::walls, 0.2));
  EXPECT_GE(f.cell, 0.2);
  EXPECT_EQ(f.lone, std::vector<std::uint32_t>{alone});
  EXPECT_TRUE(is_wet(f, {5, 5}));
}

TEST(FluidField, TheGridKeepsToWhatIsShown) {
  const std::vector<Vec2> places = pool(10, 10);
  FluidGrid grid = grid_of({-1e6, -1e6, 1e6, 1e6}, Boundary::open);
  const FluidField all = make(places, grid);
  EXPECT_LT(all.columns, 240);
  grid.shown = {4, 4, 5, 5};
  const FluidField part = make(places, grid);
  EXPECT_LT(part.columns, 45);
  for (double x = 4; x < 5; x += 0.01) EXPECT_NEAR(fullness(part, {x, 4.5}), fullness(all, {x, 4.5}), 1e-5) << x;
  grid.shown = {20, 20, 21, 21};
  EXPECT_TRUE(make(places, grid).is_empty());
  EXPECT_TRUE(make({}, grid).is_empty());
}

TEST(FluidField, ValuesAreMeansOfWhatIsNear) {
  const std::vector<Vec2> places = pool(3, 2);
  std::vector<float> values;
  for (const Vec2& at : places) values.push_back(static_cast<float>(at.x));
  const FluidField f = make(places, grid_of({0, 0, 3, 3}, Boundary::walls), values);
  ASSERT_EQ(f.value.size(), f.fullness.size());
  for (int j = 0; j < f.rows; ++j) {
    for (int i = 0; i < f.columns; ++i) {
      const Vec2 at{f.origin.x + f.cell * i, f.origin.y + f.cell * j};
      if (at.x < 0.4 || at.x > 2.6 || at.y < 0 || at.y > 1.9) continue;
      EXPECT_NEAR(f.value[static_cast<std::size_t>(j * f.columns + i)], at.x, 0.1);
    }
  }
}

TEST(FluidField, BrokenPlacesAreLeftOut) {
  std::vector<Vec2> places = pool(1, 1);
  const FluidField whole = make(places, grid_of({-2, -2, 3, 3}, Boundary::open));
  places.push_back({std::nan(""), 0});
  places.push_back({0, INFINITY});
  const FluidField f = make(places, grid_of({-2, -2, 3, 3}, Boundary::open));
  EXPECT_EQ(f.fullness, whole.fullness);
}

}  // namespace
}  // namespace psim::cli
