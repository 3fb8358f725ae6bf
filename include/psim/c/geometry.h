/// @file
/// C API: geometry of shapes without a world: bounds, points, rays, distances, casts, convex hulls
/// (docs/queries-events.md).
///
/// Shapes are those of bodies: discs, boxes, polygons and capsules are solid, segments and chains have no inside. Of a chain
/// the nearest or first segment answers. A shape that a body could not have and a number out of its range (<psim/limits.h>)
/// give PSIM_NOTHING; NULL and a shape type that there is not are PSIM_ERROR_ARGUMENT. Any number of threads may ask at once.
#pragma once

#include "psim/c/desc.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Where the frame of a shape is.
typedef struct psim_pose {
  psim_vec2 position;  ///< metres
  double angle;        ///< radians
} psim_pose;

/// The way of a shape: straight, while it turns evenly about the origin of its frame.
typedef struct psim_shape_move {
  psim_pose from;         ///< where it starts
  psim_vec2 translation;  ///< metres: how far it goes
  double rotation;        ///< radians: how far it turns meanwhile, at most 1,000 either way
} psim_shape_move;

/// Where a ray, or a shape that moves, meets a shape.
typedef struct psim_shape_hit {
  psim_vec2 point;   ///< metres, on the surface of the shape: the middle of what touches
  psim_vec2 normal;  ///< of length 1, of the surface there; zero if the two overlap at the start
  double fraction;   ///< 0 to 1 of the way
} psim_shape_hit;

/// How far two shapes are apart.
typedef struct psim_shape_gap {
  double distance;    ///< metres; negative: how deep they overlap
  psim_vec2 point_a;  ///< metres, on the surface of a: the nearest to b, or the middle of what is nearest
  psim_vec2 point_b;  ///< metres, likewise
  psim_vec2 normal;   ///< of length 1, from a to b: the shortest way out for b if they overlap
} psim_shape_gap;

/// The smallest box about a shape, metres. PSIM_NOTHING.
PSIM_API psim_result psim_shape_bounds(const psim_shape* shape, psim_pose at, psim_bounds* bounds);

/// PSIM_OK if a point, metres, lies in a shape or on its surface, else PSIM_NOTHING.
PSIM_API psim_result psim_shape_holds(const psim_shape* shape, psim_pose at, psim_vec2 point);

/// Where the way from `from` to `to`, metres, enters a shape. Segments and chains are met from either side, but not by a
/// ray along them. The point is `from` where the ray starts inside. PSIM_NOTHING.
PSIM_API psim_result psim_shape_ray_cast(const psim_shape* shape, psim_pose at, psim_vec2 from, psim_vec2 to,
                                         psim_shape_hit* hit);

/// The distance of two shapes and the nearest points. PSIM_NOTHING.
PSIM_API psim_result psim_shape_distance(const psim_shape* a, psim_pose at_a, const psim_shape* b, psim_pose at_b,
                                         psim_shape_gap* gap);

/// The time of impact: where two shapes that both move and turn first touch. The hit is on b, where b is then, and
/// `fraction` that of both ways. If they overlap at the start the point is the place of a. Exact to 1e-6 m. PSIM_NOTHING.
PSIM_API psim_result psim_shape_cast(const psim_shape* a, psim_shape_move move_a, const psim_shape* b,
                                     psim_shape_move move_b, psim_shape_hit* hit);

/// The corners of the convex hull of points, metres, counter-clockwise from the leftmost on. Flat corners are left out: no
/// point lies farther outside of the hull than `tolerance`, metres, 0 to 1e9, or than 1e-6 of the points' extent. `*hull_count`
/// is how many there are; as many as fit go into `hull`, which has room for `capacity` and may be NULL if that is 0.
/// PSIM_NOTHING, and none, if the points span no area.
PSIM_API psim_result psim_convex_hull(const psim_vec2* points, size_t count, double tolerance, psim_vec2* hull,
                                      size_t capacity, size_t* hull_count);

#ifdef __cplusplus
}
#endif
