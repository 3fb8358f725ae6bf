// Geometry of shapes without a world: bounds, points, rays, distances, casts, convex hulls. Shapes are those of bodies, in
// double precision, solid as in queries of a world: discs, boxes, polygons and capsules have an inside, segments and chains
// have none. Of a chain or compound the nearest or first part answers.
//
// A shape that a body could not have, a number out of its range (psim/limits.h) or NaN gives nothing, and so does want of
// memory (out_of_memory). The same bits on all platforms. Any number of threads may ask at once.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "psim/api.h"
#include "psim/desc.h"
#include "psim/types.h"

namespace psim {

/// Where the frame of a shape is.
struct Pose {
  Vec2 position = {};  ///< metres
  double angle = 0;    ///< radians
};

/// The way of a shape: straight, while it turns evenly about the origin of its frame.
struct ShapeMove {
  Pose from = {};         ///< where it starts
  Vec2 translation = {};  ///< metres: how far it goes
  double rotation = 0;    ///< radians: how far it turns meanwhile, at most 1,000 either way
};

/// Where a ray, or a shape that moves, meets a shape.
struct ShapeHit {
  Vec2 point = {};      ///< metres, on the surface of the shape: the middle of what touches
  Vec2 normal = {};     ///< of length 1, of the surface there; zero if the two overlap at the start
  double fraction = 0;  ///< 0..1 of the way
};

/// How far two shapes are apart.
struct ShapeGap {
  double distance = 0;  ///< metres; negative: how deep they overlap
  Vec2 point_a = {};    ///< metres, on the surface of a: the nearest to b, or the middle of what is nearest
  Vec2 point_b = {};    ///< metres, likewise
  Vec2 normal = {};     ///< of length 1, from a to b: the shortest way out for b if they overlap
};

/// The smallest box about a shape, metres.
PSIM_API std::optional<Bounds> shape_bounds(const Shape& shape, const Pose& at = {});

/// Whether a point, metres, lies in a shape. Its surface belongs to it; of a segment or chain that is all there is.
PSIM_API bool shape_holds(const Shape& shape, const Pose& at, Vec2 point);

/// Where the way from `from` to `to`, metres, enters a shape. Segments and chains are met from either side, but not by a
/// ray along them. The point is `from` where the ray starts inside.
PSIM_API std::optional<ShapeHit> shape_ray_cast(const Shape& shape, const Pose& at, Vec2 from, Vec2 to);

/// The distance of two shapes and the nearest points: those of the two parts that are nearest or overlap most.
/// point_b = point_a + distance x normal.
PSIM_API std::optional<ShapeGap> shape_distance(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b);

/// The time of impact: where two shapes that both move and turn first touch. The hit is on b, where b is then, and
/// `fraction` that of both ways. If they overlap at the start the point is the place of a. Shapes that touch at the start
/// meet there if they come nearer. Exact to 1e-6 m.
PSIM_API std::optional<ShapeHit> shape_cast(const Shape& a, const ShapeMove& move_a, const Shape& b,
                                            const ShapeMove& move_b = {});

/// The corners of the convex hull of points, metres, counter-clockwise from the leftmost on (of several the lowest). Flat
/// corners are left out: no point lies farther outside of the hull than `tolerance`, metres, 0 to 1e9, or than 1e-6 of the
/// points' extent, the larger side of their box, where that is more. No corners, if the points span no area (1e-6 of their
/// extent squared) or their extent is below 1e-9 m. Up to kMostPolygonVertices corners make a PolygonShape; cut_outline
/// makes parts of more.
PSIM_API std::vector<Vec2> convex_hull(std::span<const Vec2> points, double tolerance = 0);

}  // namespace psim
