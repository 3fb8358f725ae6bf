// Polygons whose vertices the engine puts right: clockwise ones, and those that say nothing.
#include <cstddef>
#include <string>
#include <variant>

#include "bodies/hull.h"
#include "check/rules.h"

namespace psim {
namespace {

double twice_area(const std::vector<Vec2>& p) {
  double sum = 0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec2 a = p[k], b = p[(k + 1) % p.size()];
    sum += a.x * b.y - a.y * b.x;
  }
  return sum;
}

void check_shape(const Shape& shape, const std::string& name, Lines& lines) {
  const auto* polygon = std::get_if<PolygonShape>(&shape);
  if (!polygon) return;
  HullSet hulls;
  std::string error;
  if (!make_hulls(shape, true, hulls, error)) {
    lines.push_back(name + ": " + error);
    return;
  }
  const std::size_t given = polygon->vertices.size();
  const auto kept = static_cast<std::size_t>(hulls.parts.front().count);
  if (kept < given) {
    lines.push_back(name + ": " + std::to_string(given - kept) + " of the polygon's " + std::to_string(given) +
                    " vertices repeat their neighbour or lie on a line with both: left out; take "
                    "them out of shape.polygon.vertices");
  }
  if (twice_area(polygon->vertices) < 0) {
    lines.push_back(name +
                    ": the polygon's vertices stand clockwise: turned round; list "
                    "shape.polygon.vertices counter-clockwise");
  }
}

}  // namespace

void check_polygons(const Scene& scene, Lines& lines) {
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    check_shape(scene.bodies[k].shape, body_name(scene, k), lines);
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    check_shape(scene.groups[k].body.shape, "groups[" + std::to_string(k) + "]", lines);
  }
}

}  // namespace psim
