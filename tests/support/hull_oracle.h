// Distances of two hulls in double precision: the Minkowski difference of the two cores as a convex polygon, and the
// origin's signed distance from its outline. Random hulls to hold the engine against it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "collide/collide.h"

namespace psim::hull_oracle {

inline constexpr double kPi = std::numbers::pi;
inline constexpr float kAll = std::numeric_limits<float>::infinity();

struct P {
  double x = 0, y = 0;
};
inline P operator-(P a, P b) { return {a.x - b.x, a.y - b.y}; }
inline double cross(P a, P b) { return a.x * b.y - a.y * b.x; }
inline double norm(P a) { return std::hypot(a.x, a.y); }

inline Rotor rotor(double angle) { return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))}; }

inline P turned(Rotor q, P v) { return {q.c * v.x - q.s * v.y, q.s * v.x + q.c * v.y}; }

inline std::vector<P> corners(const Hull& h, Rotor q, P at) {
  std::vector<P> out;
  for (int k = 0; k < h.count; ++k) {
    const P v = turned(q, {h.x[k], h.y[k]});
    out.push_back({v.x + at.x, v.y + at.y});
  }
  return out;
}

inline double distance_to_line(P from, P a, P b) {
  const P e = b - a;
  const double span2 = e.x * e.x + e.y * e.y;
  const P u = from - a;
  const double t = span2 > 0 ? std::clamp((u.x * e.x + u.y * e.y) / span2, 0.0, 1.0) : 0;
  return norm({u.x - t * e.x, u.y - t * e.y});
}

/// Convex outline of points, counter-clockwise (Andrew's monotone chain).
inline std::vector<P> outline(std::vector<P> p) {
  std::sort(p.begin(), p.end(), [](P a, P b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<P> out;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = out.size();
    for (const P v : p) {
      while (out.size() >= base + 2 && cross(out.back() - out[out.size() - 2], v - out[out.size() - 2]) <= 0) {
        out.pop_back();
      }
      out.push_back(v);
    }
    out.pop_back();
    std::reverse(p.begin(), p.end());
  }
  return out;
}

/// Distance of two hulls, radii included; minus the least depth where the cores overlap.
inline double oracle(const Hull& a, Rotor qa, const Hull& b, Rotor qb, P d) {
  std::vector<P> difference;
  for (const P u : corners(b, qb, d)) {
    for (const P v : corners(a, qa, {})) difference.push_back(u - v);
  }
  double core = 0;
  if (difference.size() == 1) {
    core = norm(difference[0]);
  } else {
    const std::vector<P> hull = outline(difference);
    double least = 1e300;
    bool inside = hull.size() > 2;
    for (std::size_t k = 0; k < hull.size(); ++k) {
      const P u = hull[k], v = hull[(k + 1) % hull.size()];
      least = std::min(least, distance_to_line({}, u, v));
      inside = inside && cross(v - u, P{} - u) > 0;
    }
    core = inside ? -least : least;
  }
  return core - a.radius - b.radius;
}

inline double uniform(std::mt19937_64& g, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(g);
}

/// A hull of `count` vertices on an ellipse, its centre within it, sized about 1.
inline Hull random_hull(std::mt19937_64& g, int count, bool round) {
  Hull h;
  h.count = count;
  if (round || count == 1) h.radius = static_cast<float>(uniform(g, 0.05, 0.7));
  const double flat = uniform(g, 0.2, 1), size = uniform(g, 0.4, 2), start = uniform(g, 0, 7);
  for (int k = 0; k < count; ++k) {
    const double at = start + 2 * kPi * (k + uniform(g, -0.35, 0.35)) / count;
    if (count == 1) break;
    h.x[k] = static_cast<float>(size * std::cos(at));
    h.y[k] = static_cast<float>(size * flat * std::sin(at));
  }
  finish_hull(h);
  return h;
}

inline Hull box(double w, double h, double radius = 0) {
  HullSet out;
  std::string error;
  EXPECT_TRUE(make_hulls(BoxShape{w, h, radius}, true, out, error)) << error;
  return out.parts.at(0);
}

inline Hull capsule(double length, double radius) {
  HullSet out;
  std::string error;
  EXPECT_TRUE(make_hulls(CapsuleShape{{-length / 2, 0}, {length / 2, 0}, radius}, true, out, error));
  return out.parts.at(0);
}

inline Hull disc(double radius) {
  Hull h;
  h.count = 1;
  h.radius = static_cast<float>(radius);
  finish_hull(h);
  return h;
}

struct Scene {
  Hull a, b;
  double angle_a = 0, angle_b = 0;
  Rotor qa, qb;
  float dx = 0, dy = 0;
  double size() const { return double{a.reach} + b.reach; }
  double truth() const { return oracle(a, qa, b, qb, {dx, dy}); }
  Manifold manifold(float margin = kAll) const { return collide(a, qa, b, qb, dx, dy, margin); }
  Nearest near() const { return nearest(a, qa, b, qb, dx, dy); }
};

/// Places from well apart to the same centre.
inline Scene random_scene(std::mt19937_64& g, int na, int nb) {
  Scene s;
  s.a = random_hull(g, na, g() % 2);
  s.b = random_hull(g, nb, g() % 2);
  s.angle_a = uniform(g, -4, 4);
  s.angle_b = g() % 4 == 0 ? s.angle_a : uniform(g, -4, 4);
  s.qa = rotor(s.angle_a);
  s.qb = rotor(s.angle_b);
  const double r = uniform(g, 0, 1.2) * s.size(), at = uniform(g, 0, 7);
  s.dx = static_cast<float>(r * std::cos(at));
  s.dy = static_cast<float>(r * std::sin(at));
  return s;
}

inline double least_gap(const Manifold& m) {
  double least = m.point[0].gap;
  for (int k = 1; k < m.count; ++k) least = std::min<double>(least, m.point[k].gap);
  return least;
}

/// Calls `check` with pairs of all counts of vertices.
template <class Check>
void for_random_pairs(int each, Check check) {
  std::mt19937_64 g(7);
  for (int na = 1; na <= 8; ++na) {
    for (int nb = 1; nb <= 8; ++nb) {
      for (int k = 0; k < each; ++k) {
        SCOPED_TRACE(testing::Message() << na << " against " << nb << ", case " << k);
        check(random_scene(g, na, nb), g);
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

}  // namespace psim::hull_oracle
