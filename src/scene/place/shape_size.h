// How large a shape is.
#pragma once

#include <variant>
#include <vector>

#include "psim/desc.h"

namespace psim {

/// Radius of the circle about the body's origin that holds the shape, metres.
double bounding_radius(const Shape& shape);

/// The rectangle around the shape of a body, metres, world coordinates.
Bounds extent(const Shape& shape, Vec2 position, double angle);

/// A point of a body's frame in world coordinates.
Vec2 to_world(Vec2 point, Vec2 position, double angle);

/// The points that span a shape in the body's frame, and the radius around them: a disc has one, a
/// capsule two, a box four.
struct Outline {
  std::vector<Vec2> points;
  double radius = 0;
  bool line = false;    ///< a line from point to point that encloses nothing
  bool closed = false;  ///< of a line: the last point is joined to the first
};
/// Those of all parts of a shape. A shape that is no compound has one.
std::vector<Outline> outlines(const Shape& shape);

inline bool is_disc(const Shape& shape) { return std::holds_alternative<DiscShape>(shape); }

}  // namespace psim
