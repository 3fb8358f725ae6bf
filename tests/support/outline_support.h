// Outlines for the tests, and what they are cut into.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "psim/outline.h"
#include "support.h"

namespace psim::test {

using Points = std::vector<Vec2>;

inline double cross_at(Vec2 a, Vec2 b, Vec2 c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); }

/// From 0 to 1, alike on all platforms.
inline double drawn(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

/// Area and centroid, counter-clockwise: about the first vertex.
struct AreaCentre {
  double area = 0;
  Vec2 first;  ///< area times centroid
};
inline AreaCentre area_of(const Points& p) {
  AreaCentre sum;
  for (std::size_t k = 1; k + 1 < p.size(); ++k) {
    const double area = 0.5 * cross_at(p[0], p[k], p[k + 1]);
    sum.area += area;
    sum.first.x += area * ((p[k].x - p[0].x) + (p[k + 1].x - p[0].x)) / 3;
    sum.first.y += area * ((p[k].y - p[0].y) + (p[k + 1].y - p[0].y)) / 3;
  }
  sum.first.x += sum.area * p[0].x;
  sum.first.y += sum.area * p[0].y;
  return sum;
}

inline std::size_t inward_corners(const Points& p) {
  const double way = area_of(p).area;
  std::size_t count = 0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    count += way * cross_at(p[k], p[(k + 1) % p.size()], p[(k + 2) % p.size()]) < 0;
  }
  return count;
}

/// Vertices in all directions from (0, 0), `rough` of the radius apart.
inline Points star(std::size_t n, double rough, std::mt19937& random) {
  Points p;
  for (std::size_t k = 0; k < n; ++k) {
    const double angle = 2 * kPi * static_cast<double>(k) / static_cast<double>(n);
    const double radius = 1 - rough * drawn(random);
    p.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return p;
}

/// Random points, joined in any order, and then turned round between two edges that cross until none do.
inline Points untangled(std::size_t n, std::mt19937& random) {
  Points p;
  for (std::size_t k = 0; k < n; ++k) p.push_back({drawn(random), drawn(random)});
  for (bool crossed = true; crossed;) {
    crossed = false;
    for (std::size_t i = 0; i + 2 < n; ++i) {
      for (std::size_t j = i + 2; j < n; ++j) {
        const Vec2 a = p[i], b = p[i + 1], c = p[j], d = p[(j + 1) % n];
        if ((cross_at(a, b, c) > 0) == (cross_at(a, b, d) > 0) || (cross_at(c, d, a) > 0) == (cross_at(c, d, b) > 0)) {
          continue;
        }
        if (j + 1 == n && i == 0) continue;
        std::reverse(p.begin() + static_cast<std::ptrdiff_t>(i) + 1, p.begin() + static_cast<std::ptrdiff_t>(j) + 1);
        crossed = true;
      }
    }
  }
  return p;
}

/// A band that winds around (0, 0) from inside to outside and back.
inline Points spiral(std::size_t half) {
  Points p;
  for (std::size_t k = 0; k < 2 * half; ++k) {
    const double angle = 0.1 * static_cast<double>(k < half ? k : 2 * half - 1 - k);
    const double radius = angle + (k < half ? 1 : 3);
    p.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return p;
}

/// A bar with teeth upwards.
inline Points comb(std::size_t teeth) {
  Points p{{0, -1}, {2.0 * static_cast<double>(teeth) - 1, -1}};
  for (std::size_t k = teeth; k-- > 0;) {
    const double x = 2.0 * static_cast<double>(k);
    p.insert(p.end(), {{x + 1, 0}, {x + 1, 10}, {x, 10}, {x, 0}});
  }
  return p;
}

inline std::vector<ShapePart> cut(const Points& outline, double radius = 0) {
  std::string error;
  std::vector<ShapePart> parts = cut_outline(outline, radius, error);
  EXPECT_EQ(error, "");
  return parts;
}

/// The vertices of parts in the frame of the outline.
inline std::vector<Points> pieces_of(const std::vector<ShapePart>& parts) {
  std::vector<Points> pieces;
  for (const ShapePart& part : parts) {
    Points& piece = pieces.emplace_back();
    for (const Vec2 v : std::get<PolygonShape>(part.shape).vertices) {
      piece.push_back({part.position.x + v.x, part.position.y + v.y});
    }
  }
  return pieces;
}

inline Points l_shape() { return {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}; }

}  // namespace psim::test
