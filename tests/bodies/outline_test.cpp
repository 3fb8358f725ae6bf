// Outlines are cut into convex pieces that are the outline together, and wrong ones are refused.
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "bodies/hull.h"
#include "outline_support.h"

namespace psim::test {
namespace {

// How far two convex polygons overlap, along the direction in which they overlap least.
double overlap_of(const Points& p, const Points& q) {
  double least = std::numeric_limits<double>::infinity();
  for (const Points* edges : {&p, &q}) {
    const Points& others = edges == &p ? q : p;
    for (std::size_t k = 0; k < edges->size(); ++k) {
      const Vec2 a = (*edges)[k], b = (*edges)[(k + 1) % edges->size()];
      double deepest = 0;
      for (const Vec2 v : others) deepest = std::max(deepest, cross_at(a, b, v) / std::hypot(b.x - a.x, b.y - a.y));
      least = std::min(least, deepest);
    }
  }
  return least;
}

// The fewest pieces that any cutting from vertex to vertex gives, or less.
std::size_t fewest(const Points& outline) {
  const std::size_t inward = inward_corners(outline);
  return std::max(inward == 0 ? std::size_t{1} : (inward + 1) / 2 + 1, (outline.size() - 2 + 5) / 6);
}

void expect_cut(const Points& outline, const char* what) {
  SCOPED_TRACE(std::string(what) + " of " + std::to_string(outline.size()));
  const std::vector<ShapePart> parts = cut(outline);
  const std::vector<Points> pieces = pieces_of(parts);
  const AreaCentre whole = area_of(outline);
  AreaCentre sum;
  for (const Points& piece : pieces) {
    EXPECT_GE(piece.size(), 3u);
    EXPECT_LE(piece.size(), 8u);
    for (std::size_t k = 0; k < piece.size(); ++k) {
      EXPECT_GT(cross_at(piece[k], piece[(k + 1) % piece.size()], piece[(k + 2) % piece.size()]), 0);
    }
    const AreaCentre part = area_of(piece);
    EXPECT_GT(part.area, 0);
    sum.area += part.area;
    sum.first = {sum.first.x + part.first.x, sum.first.y + part.first.y};
  }
  EXPECT_NEAR(sum.area, std::fabs(whole.area), 1e-12 * std::fabs(whole.area));
  double size = 0;
  for (const Vec2 v : outline) size = std::max({size, std::fabs(v.x), std::fabs(v.y)});
  EXPECT_NEAR(sum.first.x / sum.area, whole.first.x / whole.area, 1e-12 * size);
  EXPECT_NEAR(sum.first.y / sum.area, whole.first.y / whole.area, 1e-12 * size);
  if (pieces.size() < 400) {
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      for (std::size_t o = 0; o < k; ++o) ASSERT_LT(overlap_of(pieces[k], pieces[o]), 1e-13 * size) << k << ' ' << o;
    }
  }
  EXPECT_LE(pieces.size(), 4 * fewest(outline));
  EXPECT_LE(pieces.size(), outline.size() - 2);
  if (outline.size() <= 8) {
    EXPECT_LE(pieces.size(), 2 * inward_corners(outline) + 1);
  }
  HullSet hulls;
  std::string error;
  EXPECT_TRUE(make_hulls(CompoundShape{parts}, true, hulls, error)) << error;
  EXPECT_NEAR(hulls.mass.area, sum.area, 1e-5 * sum.area);
}

TEST(CutOutline, OfManyKindsIsTheSumOfItsPieces) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    expect_cut(untangled(4 + random() % 37, random), "untangled");
    expect_cut(star(4 + random() % 60, drawn(random), random), "star");
  }
  for (const std::size_t n : {1u, 2u, 3u, 10u, 60u}) {
    expect_cut(comb(n), "comb");
    expect_cut(spiral(2 + 3 * n), "spiral");
  }
  expect_cut(star(2000, 0.5, random), "star");
  expect_cut(star(2000, 1e-3, random), "star");
}

TEST(CutOutline, FarFromTheOriginIsCutToo) {
  std::mt19937 random(3);
  for (int round = 0; round < 100; ++round) {
    Points outline = untangled(4 + random() % 30, random);
    // Millimetres, a thousand kilometres away: rounded to what doubles are there.
    for (Vec2& v : outline) v = {1e6 + 1e-3 * v.x, -1e6 + 1e-3 * v.y};
    std::string error;
    const std::vector<ShapePart> parts = cut_outline(outline, 0, error);
    if (parts.empty()) {
      EXPECT_TRUE(error.find("cross or touch") != error.npos || error.find("piece of vertices") != error.npos) << error;
      continue;
    }
    double sum = 0;
    for (const Points& piece : pieces_of(parts)) sum += area_of(piece).area;
    // Where a long edge was given vertices of its own, they are as near to it as doubles are there.
    EXPECT_NEAR(sum, std::fabs(area_of(outline).area), 1e-6 * sum);
  }
}

TEST(CutOutline, ConvexStaysOnePiece) {
  std::mt19937 random(1);
  for (std::size_t n = 3; n <= 8; ++n) {
    const Points polygon = star(n, 0, random);
    const std::vector<ShapePart> parts = cut(polygon);
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].position.x, 0);
    const Points& vertices = std::get<PolygonShape>(parts[0].shape).vertices;
    ASSERT_EQ(vertices.size(), n);
    for (std::size_t k = 0; k < n; ++k) EXPECT_EQ(vertices[k].x, polygon[k].x);
  }
  EXPECT_EQ(cut(star(9, 0, random)).size(), 2u);
  EXPECT_EQ(cut(l_shape()).size(), 2u);
}

TEST(CutOutline, WhatChangesNothingIsLeftOut) {
  const std::vector<Points> plain = pieces_of(cut(l_shape()));
  Points clockwise = l_shape();
  std::ranges::reverse(clockwise);
  Points more{{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 1}, {1, 2.5}, {1, 3}, {0, 3}, {0, 1}, {0, 0}};
  for (const Points& outline : {clockwise, more}) {
    const std::vector<Points> pieces = pieces_of(cut(outline));
    ASSERT_EQ(pieces.size(), plain.size());
    double area = 0;
    for (const Points& piece : pieces) area += area_of(piece).area;
    EXPECT_EQ(area, 5);
  }
  // A turned square whose sides have vertices between: on their line but for rounding. It ends all but where it began.
  Points turned;
  const double c = std::cos(0.3), s = std::sin(0.3);
  for (int side = 0; side < 4; ++side) {
    for (int k = 0; k < 10; ++k) {
      const double x = 0.1 * k - 0.5, y = -0.5;
      const Vec2 v = side == 0 ? Vec2{x, y} : side == 1 ? Vec2{-y, x} : side == 2 ? Vec2{-x, -y} : Vec2{y, -x};
      turned.push_back({c * v.x - s * v.y, s * v.x + c * v.y});
    }
  }
  turned.push_back({turned[0].x + 1e-16, turned[0].y - 1e-16});
  const std::vector<ShapePart> parts = cut(turned);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(std::get<PolygonShape>(parts[0].shape).vertices.size(), 4u);
}

// A valley of many short edges above one long one, which gets vertices of its own: else pieces would be too thin.
TEST(CutOutline, LongEdgesAreCutWhereOtherwisePiecesWereTooThin) {
  Points valley;
  const int n = 2000;
  for (int k = n; k >= -n; --k) valley.push_back({1.0 * k, 5.0 * k * k / n / n});
  valley.push_back({-n, -1});
  valley.push_back({n, -1});
  const std::vector<ShapePart> parts = cut(valley);
  double area = 0;
  for (const Points& piece : pieces_of(parts)) area += area_of(piece).area;
  EXPECT_NEAR(area, area_of(valley).area, 1e-12 * area);
}

TEST(CutOutline, EachPieceIsRounded) {
  const std::vector<ShapePart> parts = cut(l_shape(), 0.25);
  for (const ShapePart& part : parts) EXPECT_EQ(std::get<PolygonShape>(part.shape).radius, 0.25);
}

TEST(CutOutline, WrongOnesAreRefusedInOneLine) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  struct Bad {
    Points vertices;
    double radius;
    const char* error;
  };
  const Bad all[] = {
      {{}, 0, "an outline has 3 to 10000 vertices, this one has 0"},
      {{{0, 0}, {1, 0}}, 0, "an outline has 3 to 10000 vertices, this one has 2"},
      {Points(10001), 0, "an outline has 3 to 10000 vertices, this one has 10001"},
      {{{0, 0}, {1, 0}, {0, nan}}, 0, "vertex 2 must be from -1e9 to 1e9, not nan"},
      {{{0, 0}, {2e9, 0}, {0, 1}}, 0, "vertex 1 must be from -1e9 to 1e9, not 2e9"},
      {{{-1e9, 0}, {1e9, 0}, {0, 1e9}}, 0, "an outline's extent must be from 1e-9 to 1e9, not 2e9"},
      {{{1, 1}, {1, 1}, {1, 1}}, 0, "an outline's extent must be from 1e-9 to 1e9, not 0"},
      {l_shape(), -1, "radius, where it is not 0, must be from 1e-9 to 1e6, not -1"},
      {l_shape(), nan, "radius, where it is not 0, must be from 1e-9 to 1e6, not nan"},
      {{{0, 0}, {1, 1}, {2, 2}}, 0, "an outline must have an area"},
      {{{0, 0}, {1, 1}, {0, 0}, {1, 1}},
       0,
       "an outline must not cross or touch itself; its edges from vertex 0 to vertex 1 and from vertex 3 to vertex 0 "
       "do"},
      // A bow tie.
      {{{0, 0}, {1, 1}, {1, 0}, {0, 1}},
       0,
       "an outline must not cross or touch itself; its edges from vertex 0 to vertex 1 and from vertex 2 to vertex 3 "
       "do"},
      // A vertex on an edge; vertex 1 is left out.
      {{{0, 0}, {2, 0}, {4, 0}, {4, 2}, {3, 0}, {0, 2}},
       0,
       "an outline must not cross or touch itself; its edges from vertex 0 to vertex 2 and from vertex 4 to vertex 5 "
       "do"},
      // Two vertices in one place.
      {{{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2}, {1, 1}},
       0,
       "an outline must not cross or touch itself; its edges from vertex 1 to vertex 2 and from vertex 4 to vertex 5 "
       "do"},
      // A spike.
      {{{0, 0}, {2, 0}, {2, 2}, {2, 3}, {2, 2}, {0, 2}},
       0,
       "an outline must not cross or touch itself; its edges from vertex 1 to vertex 3 and from vertex 3 to vertex 4 "
       "do"},
      {{{0, 0}, {1, 0}, {1, 1e-7}},
       0,
       "the outline's piece of vertices 0, 1 and 2: a polygon must have an area (above 1e-6 of its extent squared)"},
      {{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 1e7}, {0.99, 1}, {0, 1}},
       0,
       "the outline's piece of vertices 3, 4 and 5: a polygon must have an area (above 1e-6 of its extent squared)"}};
  for (const Bad& bad : all) {
    std::string error;
    EXPECT_TRUE(cut_outline(bad.vertices, bad.radius, error).empty());
    EXPECT_EQ(error, bad.error);
  }
}

// Outlines of few whole numbers touch, cross, and have vertices on lines: each is refused, or cut.
TEST(CutOutline, OnAGridIsCutOrRefused) {
  std::mt19937 random(11);
  std::size_t good = 0;
  for (int round = 0; round < 20000; ++round) {
    Points outline(3 + random() % 8);
    for (Vec2& v : outline) v = {static_cast<double>(random() % 5), static_cast<double>(random() % 5)};
    std::string error;
    const std::vector<ShapePart> parts = cut_outline(outline, 0, error);
    ASSERT_EQ(parts.empty(), !error.empty());
    if (parts.empty()) continue;
    ++good;
    double area = 0;
    for (const Points& piece : pieces_of(parts)) area += area_of(piece).area;
    ASSERT_EQ(area, std::fabs(area_of(outline).area));
  }
  EXPECT_GT(good, 1000u);
}

// The limit of vertices, and the same bits from every compiler.
TEST(CutOutline, OfTenThousandVerticesHasTheSameBitsEverywhere) {
  std::mt19937 random(5);
  Points terrain{{100, -1}};
  for (int k = 9998; k-- > 0;) terrain.push_back({0.01 * k, drawn(random)});
  terrain.push_back({0, -1});
  std::uint64_t hash = 0xCBF29CE484222325u;
  const auto add = [&](double v) { hash = (hash ^ std::bit_cast<std::uint64_t>(v)) * 0x100000001B3u; };
  for (const Points& piece : pieces_of(cut(terrain))) {
    for (const Vec2 v : piece) add(v.x), add(v.y);
  }
  EXPECT_EQ(hash, 11936052377148078730u);
}

TEST(CutOutline, OfAnLHasItsMass) {
  HullSet hulls;
  std::string error;
  ASSERT_TRUE(make_hulls(CompoundShape{cut(l_shape())}, true, hulls, error)) << error;
  EXPECT_NEAR(hulls.mass.area, 5, 1e-14);
  EXPECT_NEAR(hulls.mass.centre.x, 1.1, 1e-14);
  EXPECT_NEAR(hulls.mass.centre.y, 1.1, 1e-14);
  // Of a beam of 3 m x 1 m and one of 1 m x 2 m, and Steiner's share of each.
  const double inertia = 3 * (10.0 / 12 + 0.4 * 0.4 + 0.6 * 0.6) + 2 * (5.0 / 12 + 0.6 * 0.6 + 0.9 * 0.9);
  EXPECT_NEAR(hulls.mass.inertia, inertia / 5, 1e-14);
}

}  // namespace
}  // namespace psim::test
