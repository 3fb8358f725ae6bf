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

// What take(measure of a part, so far) makes of the parts of a compound, from `start` on.
template <class Measure, class Take>
double over_parts(const CompoundShape& compound, double start, const Measure& measure, const Take& take) {
  double all = start;
  for (const ShapePart& part : compound.parts) {
    const Shape shape = std::visit([](const auto& s) -> Shape { return s; }, part.shape);
    all = take(measure(shape, part), all);
  }
  return all;
}

double reach_of(const Shape& shape) {
  return std::visit(Overloaded{[](const DiscShape& s) { return s.radius; },
                               [](const SegmentShape& s) { return std::max(length(s.p1), length(s.p2)); },
                               [](const ChainShape& s) { return farthest(s.vertices); },
                               [](const BoxShape& s) { return std::hypot(s.width, s.height) / 2 + s.radius; },
                               [](const PolygonShape& s) { return farthest(s.vertices) + s.radius; },
                               [](const CapsuleShape& s) { return std::max(length(s.p1), length(s.p2)) + s.radius; },
                               [](const CompoundShape& s) {
                                 const auto reach = [](const Shape& of, const ShapePart& part) {
                                   return length(part.position) + reach_of(of);
                                 };
                                 return over_parts(s, 0, reach, [](double a, double b) { return std::max(a, b); });
                               }},
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
                               [](const CapsuleShape& s) { return s.radius; },
                               [](const CompoundShape& s) {
                                 const auto inner = [](const Shape& of, const ShapePart&) { return inner_of(of); };
                                 return over_parts(s, 1e300, inner, [](double a, double b) { return std::min(a, b); });
                               }},
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
                 },
                 [](const CompoundShape& s) {
                   const auto area = [](const Shape& of, const ShapePart&) { return area_of(of); };
                   return over_parts(s, 0, area, [](double a, double b) { return a + b; });
                 }},
      shape);
}

std::vector<Vec2> places_of(const Shape& shape, const BodyState& state) {
  const auto* compound = std::get_if<CompoundShape>(&shape);
  if (compound == nullptr) return {{state.x, state.y}};
  std::vector<Vec2> places;
  const double c = std::cos(state.angle), s = std::sin(state.angle);
  for (const ShapePart& part : compound->parts) {
    const Vec2 p = part.position;
    places.push_back({state.x + c * p.x - s * p.y, state.y + s * p.x + c * p.y});
  }
  return places;
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

Shape draw_compound(Draw& draw, double r) {
  CompoundShape compound;
  const int parts = draw.from(2, 4);
  double at = draw.uniform(0, 2 * std::numbers::pi);
  for (int k = 0; k < parts; ++k) {
    const double size = r * draw.uniform(0.3, 0.55), far = r - size;
    const Shape shape = draw_shape(draw, size);
    ShapePart part;
    std::visit(Overloaded{[](const CompoundShape&) {}, [&](const auto& s) { part.shape = s; }}, shape);
    part.position = {far * std::cos(at), far * std::sin(at)};
    part.angle = draw.chance(0.5) ? 0 : draw.uniform(-std::numbers::pi, std::numbers::pi);
    compound.parts.push_back(part);
    at += 2 * std::numbers::pi / parts * draw.uniform(0.7, 1.3);
  }
  return compound;
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
