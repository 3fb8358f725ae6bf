#include "shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <variant>

namespace psim::laws {
namespace {

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};

double length(Vec2 v) { return std::hypot(v.x, v.y); }
double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

double farthest(const std::vector<Vec2>& points) {
  double most = 0;
  for (const Vec2& p : points) most = std::max(most, length(p));
  return most;
}

double twice_area(const std::vector<Vec2>& points) {
  double sum = 0;
  for (std::size_t k = 0; k < points.size(); ++k) sum += cross(points[k], points[(k + 1) % points.size()]);
  return sum;
}

// On an ellipse, in turn, so that the polygon is convex; gaps are even enough that no corner is all but straight.
PolygonShape draw_polygon(Draw& draw, double r) {
  PolygonShape polygon;
  const int n = draw.from(3, 8);
  const double flat = draw.uniform(0.5, 1), begin = draw.uniform(0, 2 * std::numbers::pi);
  for (int k = 0; k < n; ++k) {
    const double at = begin + 2 * std::numbers::pi * (k + draw.uniform(-0.2, 0.2)) / n;
    polygon.vertices.push_back({r * std::cos(at), r * flat * std::sin(at)});
  }
  return polygon;
}

BoxShape draw_box(Draw& draw, double r) {
  const double slim = draw.uniform(0.3, 1), half = r / std::sqrt(1 + slim * slim);
  return {2 * half, 2 * half * slim, 0};
}

CapsuleShape draw_capsule(Draw& draw, double r) {
  const double half = r * draw.uniform(0.3, 0.7);
  return {{-half, 0}, {half, 0}, r - half};
}

}  // namespace

double reach_of(const Shape& shape) {
  return std::visit(Overloaded{[](const DiscShape& s) { return s.radius; },
                               [](const SegmentShape& s) { return std::max(length(s.p1), length(s.p2)); },
                               [](const ChainShape& s) { return farthest(s.vertices); },
                               [](const BoxShape& s) { return std::hypot(s.width, s.height) / 2 + s.radius; },
                               [](const PolygonShape& s) { return farthest(s.vertices) + s.radius; },
                               [](const CapsuleShape& s) { return std::max(length(s.p1), length(s.p2)) + s.radius; }},
                    shape);
}

double inner_of(const Shape& shape) {
  return std::visit(Overloaded{[](const DiscShape& s) { return s.radius; }, [](const SegmentShape&) { return 0.0; },
                               [](const ChainShape&) { return 0.0; },
                               [](const BoxShape& s) { return std::min(s.width, s.height) / 2 + s.radius; },
                               [](const PolygonShape& s) {
                                 double around = 0;
                                 for (std::size_t k = 0; k < s.vertices.size(); ++k) {
                                   const Vec2 p = s.vertices[k], q = s.vertices[(k + 1) % s.vertices.size()];
                                   around += length({q.x - p.x, q.y - p.y});
                                 }
                                 return twice_area(s.vertices) / around + s.radius;  // of the inscribed circle, about
                               },
                               [](const CapsuleShape& s) { return s.radius; }},
                    shape);
}

double area_of(const Shape& shape) {
  const double pi = std::numbers::pi;
  return std::visit(
      Overloaded{[&](const DiscShape& s) { return pi * s.radius * s.radius; }, [](const SegmentShape&) { return 0.0; },
                 [](const ChainShape&) { return 0.0; },
                 [&](const BoxShape& s) {
                   return s.width * s.height + 2 * (s.width + s.height) * s.radius + pi * s.radius * s.radius;
                 },
                 [&](const PolygonShape& s) { return twice_area(s.vertices) / 2 + pi * s.radius * s.radius; },
                 [&](const CapsuleShape& s) {
                   return 2 * s.radius * length({s.p2.x - s.p1.x, s.p2.y - s.p1.y}) + pi * s.radius * s.radius;
                 }},
      shape);
}

Shape draw_cornered(Draw& draw, double r) {
  switch (draw.below(4)) {
    case 0:
      return draw_polygon(draw, r);
    case 1:
      return draw_capsule(draw, r);
    case 2: {
      BoxShape rounded = draw_box(draw, 0.8 * r);
      rounded.radius = 0.2 * r;
      return rounded;
    }
    default:
      return draw_box(draw, r);
  }
}

Shape draw_shape(Draw& draw, double r) {
  if (draw.chance(0.3)) return DiscShape{r};
  return draw_cornered(draw, r);
}

Material draw_material(Draw& draw) {
  Material m;
  m.density = draw.logarithmic(0.3, 3);
  m.restitution = draw.one_of(std::array{0.0, 0.0, 0.5, 0.9, 1.0, draw.uniform(0, 1)});
  m.friction = draw.one_of(std::array{0.0, 0.0, 0.3, 0.6, draw.uniform(0, 1.5)});
  return m;
}

Material elastic() { return {1, 1, 0}; }

Material draw_dull(Draw& draw) {
  Material m = draw_material(draw);
  m.restitution = 0;
  return m;
}

}  // namespace psim::laws
