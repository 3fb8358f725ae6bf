// Random shapes of every kind, and their distances by the oracle of tests/reference.
#pragma once

#include "body_outlines.h"
#include "support.h"

namespace psim::test {

/// A convex shape about `size` metres large, somewhere about its origin.
inline PartShape any_part(Random& r, double size) {
  const auto point = [&] { return Vec2{r.uniform(-size, size), r.uniform(-size, size)}; };
  switch (r.below(5)) {
    case 0:
      return DiscShape{size * r.uniform(0.2, 1)};
    case 1:
      return CapsuleShape{point(), point(), size * r.uniform(0.1, 0.6)};
    case 2:
      return BoxShape{size * r.uniform(0.2, 2), size * r.uniform(0.2, 2), r.chance(0.5) ? 0.2 * size : 0};
    case 3:
      return SegmentShape{point(), point()};
    default: {
      PolygonShape polygon;
      const std::size_t n = 3 + r.below(6);
      const Vec2 off = point();
      const double start = r.uniform(-3, 3);
      for (std::size_t k = 0; k < n; ++k) {
        const double a = start + 2 * kPi * static_cast<double>(k) / static_cast<double>(n);
        polygon.vertices.push_back({off.x + size * std::cos(a), off.y + size * std::sin(a)});
      }
      if (r.chance(0.3)) polygon.radius = 0.3 * size;
      return polygon;
    }
  }
}

/// Chains and compounds among them.
inline Shape any_shape(Random& r, double size) {
  if (r.chance(0.1)) {
    ChainShape chain{{}, r.chance(0.5), {}};
    for (int k = 0; k < 5; ++k) chain.vertices.push_back({size * (k - 2), r.uniform(-size, size)});
    return chain;
  }
  if (r.chance(0.1)) {
    CompoundShape several;
    for (int k = 0; k < 3; ++k) {
      ShapePart part;
      part.shape = any_part(r, 0.6 * size);
      part.position = {r.uniform(-size, size), r.uniform(-size, size)};
      part.angle = r.uniform(-3, 3);
      several.parts.push_back(part);
    }
    return several;
  }
  return std::visit([](const auto& part) -> Shape { return part; }, any_part(r, size));
}

inline Pose any_pose(Random& r, double half) {
  return {{r.uniform(-half, half), r.uniform(-half, half)}, r.uniform(-4, 4)};
}

/// The distance of two placed shapes, negative: the depth of the deepest pair of parts; by the oracle.
inline double true_gap(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b) {
  double least = 1e300;
  for (const auto& one : outlines(a, at_a.position, at_a.angle)) {
    for (const auto& other : outlines(b, at_b.position, at_b.angle)) {
      const double apart = reference::distance(one, other);
      least = std::min(least, apart > 0 ? apart : -reference::depth(one, other));
    }
  }
  return least;
}

/// The distance of a point from a placed shape, 0 within.
inline double true_distance(const Shape& shape, const Pose& at, Vec2 point) {
  double least = 1e300;
  for (const auto& one : outlines(shape, at.position, at.angle)) {
    least = std::min(least, reference::distance(one, exact(point)));
  }
  return least;
}

}  // namespace psim::test
