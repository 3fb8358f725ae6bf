// Rounded convex shapes as the engine holds them: one, two or three to eight vertices about the
// centre of mass, with a radius around all of it. A disc is one vertex, a capsule or a segment two.
//
// In: shapes of the public API. Out: hulls, mass and inertia, or one line of what is wrong; the same shapes in double
// precision as outlines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/rotor.h"
#include "psim/desc.h"

namespace psim {

struct Hull {
  static constexpr int kMost = kMostPolygonVertices;
  float x[kMost] = {}, y[kMost] = {};    ///< m, counter-clockwise
  float nx[kMost] = {}, ny[kMost] = {};  ///< outward normal of the edge from vertex k to the next
  float radius = 0;                      ///< m, around the vertices
  float reach = 0;                       ///< m: farthest point from the centre, radius included
  /// m: from the centre to the nearest point of the surface, at least `radius`. Of a part of a body: half its least width.
  float inner = 0;
  float middle_x = 0, middle_y = 0;  ///< m: of a part of a body: among its vertices; else the centre, 0
  std::int32_t count = 0;

  int next(int k) const { return k + 1 < count ? k + 1 : 0; }
  Vec2 vertex(int k) const { return {x[k], y[k]}; }
  /// The hull of a moving body belongs on that side of a thin shape on which its middle lies.
  Vec2 middle() const { return {middle_x, middle_y}; }
  /// The same in world axes, of a body that is turned by `angle`.
  Vec2 middle_at(double angle) const {
    return middle_x == 0 && middle_y == 0 ? Vec2{} : turned(sine_cosine(angle), middle());
  }
  void set_vertex(int k, Vec2 v) {
    x[k] = static_cast<float>(v.x);
    y[k] = static_cast<float>(v.y);
  }
  friend bool operator==(const Hull&, const Hull&) = default;
};

/// All points within `radius` of the convex core that the vertices span. There are one, two, or three to eight of them,
/// counter-clockwise.
struct ConvexOutline {
  Vec2 v[Hull::kMost];  ///< m
  std::int32_t count = 0;
  double radius = 0;  ///< m
};

/// The mass of a shape per density, its centre of mass and its inertia.
struct MassProperties {
  double area = 0;     ///< m^2 (m for segments): mass = density x area; denser parts count for more
  Vec2 centre;         ///< m, in the body's frame
  double inertia = 0;  ///< m^2: moment of inertia about the centre / mass
};

/// The hulls of a shape and its mass properties. A chain has one hull for each segment, a compound those of its parts.
struct HullSet {
  std::vector<Hull> parts;
  std::vector<std::uint32_t> part;  ///< of a compound: the number of the part that each hull is of
  /// The number of the part that a hull is of, among so many: 1, or one for each hull, where this is no compound.
  std::size_t part_of(std::size_t hull, std::size_t parts) const {
    return !part.empty() ? part[hull] : (parts > 1 ? hull : 0);
  }
  MassProperties mass;
};

/// A part as a shape of its own, in the part's frame.
inline Shape shape_of(const ShapePart& part) {
  return std::visit([](const auto& shape) -> Shape { return shape; }, part.shape);
}

/// Makes the hulls of a shape: about the centre of mass with `about_centre`, else about the place of the body. Harmless
/// faults (clockwise order, repeated or collinear vertices) are put right. False, with a line in `error`, for a shape
/// that is not convex, has no area, is not finite or too large. `density`, kg/m^2, is that of parts that have none of
/// their own.
bool make_hulls(const Shape& shape, bool about_centre, HullSet& out, std::string& error, double density = 1);

/// Makes the outlines of a shape in its own frame, of a chain one for each segment. Harmless faults are put right and
/// others refused as by make_hulls.
bool make_outlines(const Shape& shape, std::vector<ConvexOutline>& out, std::string& error);

/// Whether the points of a segment or chain are near enough and their box is neither too small nor too large. If not, a
/// line in `error`.
bool is_line(const std::vector<Vec2>& points, std::string& error);

/// The hull of a disc: one vertex with a radius.
inline Hull disc_hull(float radius) {
  Hull h;
  h.count = 1;
  h.radius = h.reach = h.inner = radius;
  return h;
}

/// Sets normals, reach and inner of a hull whose vertices, radius and count are given.
void finish_hull(Hull& hull);

}  // namespace psim
