// Distances between rounded convex outlines by brute force, in double precision, straight from the
// shapes of the public API. The oracle for queries and sensors; nothing here includes engine code.
#pragma once

#include <psim/desc.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace reference {

using psim::Vec2;

/// Convex, counter-clockwise; one or two points are a point or a line. `radius` all around it.
struct Outline {
  std::vector<Vec2> points;
  double radius = 0;
};

inline double cross(Vec2 o, Vec2 a, Vec2 b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

/// The convex hull of some points (Andrew's monotone chain).
inline std::vector<Vec2> convex_hull(std::vector<Vec2> p) {
  std::sort(p.begin(), p.end(), [](Vec2 a, Vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  if (p.size() < 3) return p;
  std::vector<Vec2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t base = hull.size();
    for (const Vec2 v : p) {
      while (hull.size() >= base + 2 && cross(hull[hull.size() - 2], hull.back(), v) <= 0) {
        hull.pop_back();
      }
      hull.push_back(v);
    }
    hull.pop_back();
    std::reverse(p.begin(), p.end());
  }
  return hull;
}

/// Distance of a point from an outline's surface; 0 inside.
inline double distance(const Outline& o, Vec2 point) {
  const std::size_t n = o.points.size();
  double least = std::hypot(point.x - o.points[0].x, point.y - o.points[0].y);
  bool inside = n > 2;
  for (std::size_t k = 0; n > 1 && k < n; ++k) {
    const Vec2 p = o.points[k], q = o.points[(k + 1) % n];
    if (cross(p, q, point) < 0) inside = false;
    const double ex = q.x - p.x, ey = q.y - p.y, square = ex * ex + ey * ey;
    double t = square > 0 ? ((point.x - p.x) * ex + (point.y - p.y) * ey) / square : 0;
    t = std::min(std::max(t, 0.0), 1.0);
    least = std::min(least, std::hypot(point.x - p.x - t * ex, point.y - p.y - t * ey));
  }
  return inside ? 0 : std::max(least - o.radius, 0.0);
}

/// Distance of two outlines; 0 where they overlap: of the origin from their Minkowski difference.
inline double distance(const Outline& a, const Outline& b) {
  std::vector<Vec2> differences;
  for (const Vec2 p : a.points) {
    for (const Vec2 q : b.points) differences.push_back({p.x - q.x, p.y - q.y});
  }
  return distance(Outline{convex_hull(differences), a.radius + b.radius}, Vec2{});
}

/// How deep two outlines overlap, the shortest way out; negative: how far they are apart.
inline double depth(const Outline& a, const Outline& b) {
  std::vector<Vec2> differences;
  for (const Vec2 p : a.points) {
    for (const Vec2 q : b.points) differences.push_back({p.x - q.x, p.y - q.y});
  }
  const std::vector<Vec2> hull = convex_hull(differences);
  const double apart = distance(Outline{hull, 0}, Vec2{});
  if (apart > 0) return a.radius + b.radius - apart;
  double inside = 0;  // shortest way to a side
  for (std::size_t k = 0; hull.size() > 2 && k < hull.size(); ++k) {
    const Vec2 p = hull[k], q = hull[(k + 1) % hull.size()];
    const double way = cross(p, q, Vec2{}) / std::hypot(q.x - p.x, q.y - p.y);
    inside = k == 0 ? way : std::min(inside, way);
  }
  return a.radius + b.radius + inside;
}

/// How far a ray from p to q gets before it enters, as a share of the way; 2: it does not. `least` is
/// how near it comes at most. By steps as long as the distance.
inline double march(const Outline& o, Vec2 p, Vec2 q, double& least) {
  const double way = std::hypot(q.x - p.x, q.y - p.y);
  least = distance(o, p);
  if (least == 0) return 0;
  for (double t = least; t <= way;) {
    const double far = distance(o, {p.x + t / way * (q.x - p.x), p.y + t / way * (q.y - p.y)});
    least = std::min(least, far);
    if (far < 1e-10) return t / way;
    t += far;
  }
  least = std::min(least, distance(o, q));
  return 2;
}

/// A body's outlines, as it stands.
inline std::vector<Outline> outlines(const psim::Shape& shape, Vec2 at, double angle) {
  std::vector<Outline> parts;
  const double c = std::cos(angle), s = std::sin(angle);
  const auto place = [&](Vec2 p) {
    return Vec2{at.x + c * p.x - s * p.y, at.y + s * p.x + c * p.y};
  };
  if (const auto* disc = std::get_if<psim::DiscShape>(&shape)) {
    parts.push_back({{at}, disc->radius});
  } else if (const auto* line = std::get_if<psim::SegmentShape>(&shape)) {
    parts.push_back({{place(line->p1), place(line->p2)}, 0});
  } else if (const auto* capsule = std::get_if<psim::CapsuleShape>(&shape)) {
    parts.push_back({{place(capsule->p1), place(capsule->p2)}, capsule->radius});
  } else if (const auto* chain = std::get_if<psim::ChainShape>(&shape)) {
    const std::size_t n = chain->vertices.size();
    for (std::size_t k = 0; k + (chain->loop ? 0 : 1) < n; ++k) {
      parts.push_back({{place(chain->vertices[k]), place(chain->vertices[(k + 1) % n])}, 0});
    }
  } else if (const auto* box = std::get_if<psim::BoxShape>(&shape)) {
    const double x = box->width / 2, y = box->height / 2;
    parts.push_back(
        {{place({-x, -y}), place({x, -y}), place({x, y}), place({-x, y})}, box->radius});
  } else if (const auto* polygon = std::get_if<psim::PolygonShape>(&shape)) {
    parts.push_back({{}, polygon->radius});
    for (const Vec2 v : polygon->vertices) parts.back().points.push_back(place(v));
  }
  return parts;
}

}  // namespace reference
