#include "outlines.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reference {
namespace {

double cross(Vec o, Vec a, Vec b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); }

/// The convex hull of some points (Andrew's monotone chain).
std::vector<Vec> convex_hull(std::vector<Vec> p) {
  std::sort(p.begin(), p.end(), [](Vec a, Vec b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  if (p.size() < 3) return p;
  std::vector<Vec> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t base = hull.size();
    for (const Vec v : p) {
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

}  // namespace

double distance(const Outline& o, Vec point) {
  const std::size_t n = o.points.size();
  double least = std::hypot(point.x - o.points[0].x, point.y - o.points[0].y);
  bool inside = n > 2;
  for (std::size_t k = 0; n > 1 && k < n; ++k) {
    const Vec p = o.points[k], q = o.points[(k + 1) % n];
    if (cross(p, q, point) < 0) inside = false;
    const double ex = q.x - p.x, ey = q.y - p.y, square = ex * ex + ey * ey;
    double t = square > 0 ? ((point.x - p.x) * ex + (point.y - p.y) * ey) / square : 0;
    t = std::min(std::max(t, 0.0), 1.0);
    least = std::min(least, std::hypot(point.x - p.x - t * ex, point.y - p.y - t * ey));
  }
  return inside ? 0 : std::max(least - o.radius, 0.0);
}

double distance(const Outline& a, const Outline& b) {
  std::vector<Vec> differences;
  for (const Vec p : a.points) {
    for (const Vec q : b.points) differences.push_back({p.x - q.x, p.y - q.y});
  }
  return distance(Outline{convex_hull(differences), a.radius + b.radius}, Vec{});
}

double depth(const Outline& a, const Outline& b) {
  std::vector<Vec> differences;
  for (const Vec p : a.points) {
    for (const Vec q : b.points) differences.push_back({p.x - q.x, p.y - q.y});
  }
  const std::vector<Vec> hull = convex_hull(differences);
  const double apart = distance(Outline{hull, 0}, Vec{});
  if (apart > 0) return a.radius + b.radius - apart;
  double inside = 0;  // shortest way to a side
  for (std::size_t k = 0; hull.size() > 2 && k < hull.size(); ++k) {
    const Vec p = hull[k], q = hull[(k + 1) % hull.size()];
    const double way = cross(p, q, Vec{}) / std::hypot(q.x - p.x, q.y - p.y);
    inside = k == 0 ? way : std::min(inside, way);
  }
  return a.radius + b.radius + inside;
}

double march(const Outline& o, Vec p, Vec q, double& least) {
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

}  // namespace reference
