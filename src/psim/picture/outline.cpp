#include "picture/outline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace psim::cli {
namespace {

constexpr double kFlat = 0.04;  // pixels between an arc and its chord

constexpr std::array kCorners = {4, 8, 12, 16, 20, 24, 32, 40, 48, 64, 96, 128, 192, 256, 384, 512};

// The circle through the corners of a polygon with chords of this angle that has the area of the unit disc.
double wider(double angle) { return std::sqrt(angle / std::sin(angle)); }

using Circles = std::array<std::vector<Point>, kCorners.size()>;

Circles make_circles() {
  Circles circles;
  for (std::size_t k = 0; k < kCorners.size(); ++k) {
    const double angle = 2 * std::numbers::pi / kCorners[k], r = wider(angle);
    for (int i = 0; i < kCorners[k]; ++i) {
      const double at = (i + 0.5) * angle;
      circles[k].push_back({r * std::cos(at), r * std::sin(at)});
    }
  }
  return circles;
}

// An arc from the normal of one side to that of the next, around `centre`. Its ends lie on the sides; the
// points between them lie further out by the factor k, so that the area is that of the sector:
//   (m - 2) k^2 + 2 k = m a / sin a    for m chords of the angle a.
void add_arc(Point centre, Point from, Point to, double radius, std::vector<Point>& out) {
  const double angle = std::fabs(std::atan2(from.x * to.y - from.y * to.x, from.x * to.x + from.y * to.y));
  const double widest = std::min(std::sqrt(8 * kFlat / radius), std::numbers::pi / 4);
  const int chords = std::clamp(static_cast<int>(std::ceil(angle / widest)), 2, 512);
  const double step = angle / chords, c = std::cos(step), s = std::sin(step);
  const double area = step > 1e-3 ? chords * step / s : chords;
  const double inner = chords - 2;
  const double wide = radius * (chords == 2 ? area / 2 : (std::sqrt(1 + inner * area) - 1) / inner);
  Point n = from;
  for (int k = 0; k <= chords; ++k) {
    const double r = k == 0 || k == chords ? radius : wide;
    out.push_back({centre.x + r * n.x, centre.y + r * n.y});
    n = {c * n.x - s * n.y, s * n.x + c * n.y};
  }
}

}  // namespace

std::span<const Point> unit_circle(double radius) {
  static const Circles kCircles = make_circles();
  constexpr double kSquareBelow = 0.35;
  if (radius < kSquareBelow) return kCircles[0];
  // The sagitta of a chord of angle a is r a^2 / 8; half of it is outside of the circle.
  const double wanted = 2 * std::numbers::pi * std::sqrt(radius / (8 * 2 * kFlat));
  const auto at = std::lower_bound(kCorners.begin() + 1, kCorners.end() - 1, wanted);
  return kCircles[static_cast<std::size_t>(at - kCorners.begin())];
}

double twice_area(std::span<const Point> polygon) {
  double area = 0;
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    const Point &o = polygon[0], &p = polygon[k - 1], &q = polygon[k];
    area += (p.x - o.x) * (q.y - o.y) - (p.y - o.y) * (q.x - o.x);
  }
  return area;
}

void round_outline(std::span<const Point> core, double radius, std::vector<Point>& out) {
  out.clear();
  const std::size_t n = core.size();
  if (n == 0) return;
  const bool backwards = twice_area(core) < 0;
  const auto corner = [&](std::size_t k) { return core[backwards ? n - 1 - k % n : k % n]; };
  if (!(radius > 0)) {
    for (std::size_t k = 0; k < n; ++k) out.push_back(corner(k));
    return;
  }
  // The outward normal of the side from corner k on; false if it has no length.
  const auto normal = [&](std::size_t k, Point& into) {
    const Point p = corner(k), q = corner(k + 1);
    const double dx = q.x - p.x, dy = q.y - p.y, length = std::hypot(dx, dy);
    if (!(length > 1e-9)) return false;
    into = {dy / length, -dx / length};
    return true;
  };
  Point before{}, after{};
  std::size_t last = n;
  while (last > 0 && !normal(last - 1, before)) --last;
  if (last == 0) {
    for (const Point& p : unit_circle(radius)) {
      out.push_back({core[0].x + radius * p.x, core[0].y + radius * p.y});
    }
    return;
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!normal(k, after)) continue;
    add_arc(corner(k), before, after, radius, out);
    before = after;
  }
}

void shrink(std::span<const Point> polygon, double distance, std::vector<Point>& out) {
  const std::size_t n = polygon.size();
  const double side = twice_area(polygon) < 0 ? -1 : 1;
  out.assign(polygon.begin(), polygon.end());
  std::vector<Point> kept;
  for (std::size_t k = 0; k < n && !out.empty(); ++k) {
    const Point p = polygon[k], q = polygon[(k + 1) % n];
    const double length = std::hypot(q.x - p.x, q.y - p.y);
    if (!(length > 1e-9)) continue;
    const double nx = side * (q.y - p.y) / length, ny = -side * (q.x - p.x) / length;
    const auto beyond = [&](const Point& v) { return (v.x - p.x) * nx + (v.y - p.y) * ny + distance; };
    kept.clear();
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Point a = out[i], b = out[(i + 1) % out.size()];
      const double da = beyond(a), db = beyond(b);
      if (da <= 0) kept.push_back(a);
      if ((da <= 0) != (db <= 0)) {
        const double t = da / (da - db);
        kept.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
      }
    }
    out.swap(kept);
  }
}

}  // namespace psim::cli
