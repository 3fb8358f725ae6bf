#include "place/shape_size.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/rotor.h"

namespace psim {
namespace {

struct OutlineOf {
  Outline operator()(const DiscShape& s) const { return {{{0, 0}}, s.radius}; }
  Outline operator()(const SegmentShape& s) const { return {{s.p1, s.p2}, 0, true}; }
  Outline operator()(const ChainShape& s) const { return {s.vertices, 0, true, s.loop}; }
  Outline operator()(const BoxShape& s) const {
    const double x = s.width / 2, y = s.height / 2;
    return {{{-x, -y}, {x, -y}, {x, y}, {-x, y}}, s.radius};
  }
  Outline operator()(const PolygonShape& s) const { return {s.vertices, s.radius}; }
  Outline operator()(const CapsuleShape& s) const { return {{s.p1, s.p2}, s.radius}; }
};

}  // namespace

std::vector<Outline> outlines(const Shape& shape) {
  std::vector<Outline> all;
  const auto add = [&all](const auto& s) {
    if constexpr (!std::is_same_v<std::decay_t<decltype(s)>, CompoundShape>) all.push_back(OutlineOf{}(s));
  };
  const auto* compound = std::get_if<CompoundShape>(&shape);
  if (compound == nullptr) {
    std::visit(add, shape);
    return all;
  }
  for (const ShapePart& part : compound->parts) {
    std::visit(add, part.shape);
    for (Vec2& v : all.back().points) v = to_world(v, part.position, part.angle);
  }
  return all;
}

double bounding_radius(const Shape& shape) {
  double most = 0;
  for (const Outline& line : outlines(shape)) {
    for (const Vec2 v : line.points) most = std::max(most, std::sqrt(v.x * v.x + v.y * v.y) + line.radius);
  }
  return most;
}

Vec2 to_world(Vec2 point, Vec2 position, double angle) { return position + turned(sine_cosine(angle), point); }

Bounds extent(const Shape& shape, Vec2 position, double angle) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Bounds box{kFar, kFar, -kFar, -kFar};
  for (const Outline& line : outlines(shape)) {
    for (const Vec2 v : line.points) {
      const Vec2 p = to_world(v, position, angle);
      box = {std::min(box.xmin, p.x - line.radius), std::min(box.ymin, p.y - line.radius),
             std::max(box.xmax, p.x + line.radius), std::max(box.ymax, p.y + line.radius)};
    }
  }
  return box;
}

}  // namespace psim
