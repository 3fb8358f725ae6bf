#include "place/shape_size.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rotor.h"

namespace psim {
namespace {

struct OutlineOf {
  Outline operator()(const DiscShape& s) const { return {{{0, 0}}, s.radius}; }
  Outline operator()(const SegmentShape& s) const { return {{s.p1, s.p2}, 0}; }
  Outline operator()(const ChainShape& s) const { return {s.vertices, 0}; }
  Outline operator()(const BoxShape& s) const {
    const double x = s.width / 2, y = s.height / 2;
    return {{{-x, -y}, {x, -y}, {x, y}, {-x, y}}, s.radius};
  }
  Outline operator()(const PolygonShape& s) const { return {s.vertices, s.radius}; }
  Outline operator()(const CapsuleShape& s) const { return {{s.p1, s.p2}, s.radius}; }
};

}  // namespace

Outline outline(const Shape& shape) { return std::visit(OutlineOf{}, shape); }

double bounding_radius(const Shape& shape) {
  const Outline line = outline(shape);
  double most = 0;
  for (const Vec2 v : line.points) most = std::max(most, std::sqrt(v.x * v.x + v.y * v.y));
  return most + line.radius;
}

Vec2 to_world(Vec2 point, Vec2 position, double angle) { return position + turned(sine_cosine(angle), point); }

Bounds extent(const Shape& shape, Vec2 position, double angle) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const Outline line = outline(shape);
  Bounds box{kFar, kFar, -kFar, -kFar};
  for (const Vec2 v : line.points) {
    const Vec2 p = to_world(v, position, angle);
    box = {std::min(box.xmin, p.x - line.radius), std::min(box.ymin, p.y - line.radius),
           std::max(box.xmax, p.x + line.radius), std::max(box.ymax, p.y + line.radius)};
  }
  return box;
}

}  // namespace psim
