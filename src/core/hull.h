// Rounded convex shapes as the engine holds them: one, two or three to eight vertices about the
// centre of mass, with a radius around all of it. A disc is one vertex, a capsule or a segment two.
//
// In: shapes of the public API. Out: hulls, mass and inertia, or one line of what is wrong.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "psim/desc.h"

namespace psim {

struct Hull {
  static constexpr int kMost = kMostPolygonVertices;
  float x[kMost] = {}, y[kMost] = {};    ///< m, counter-clockwise
  float nx[kMost] = {}, ny[kMost] = {};  ///< outward normal of the edge from vertex k to the next
  float radius = 0;                      ///< m, around the vertices
  float reach = 0;                       ///< m: farthest point from the centre, radius included
  float inner = 0;  ///< m: from the centre to the nearest point of the surface, at least `radius`
  std::int32_t count = 0;
  friend bool operator==(const Hull&, const Hull&) = default;
};

/// What a shape weighs and where its centre of mass is.
struct MassProperties {
  double area = 0;     ///< m^2 (m for segments): mass = density x area
  Vec2 centre;         ///< m, in the body's frame
  double inertia = 0;  ///< m^2: moment of inertia about the centre / mass
};

/// A shape made ready: hulls about `origin` and its mass properties. Chains give a hull a segment.
struct HullSet {
  std::vector<Hull> parts;
  MassProperties mass;
};

/// Hulls of a shape. With `about_centre` they are about the centre of mass, else about the body's
/// place. Harmless faults (clockwise order, repeated or collinear vertices) are put right; else
/// nothing comes back and `error` says what is wrong (not convex, no area, not finite, too large).
bool make_hulls(const Shape& shape, bool about_centre, HullSet& out, std::string& error);

/// A hull of one vertex.
inline Hull disc_hull(float radius) {
  Hull h;
  h.count = 1;
  h.radius = h.reach = h.inner = radius;
  return h;
}

/// Sets normals, reach and inner of a hull whose vertices, radius and count are given.
void finish_hull(Hull& hull);

}  // namespace psim
