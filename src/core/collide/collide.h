// Finds where two hulls touch or nearly touch: a normal and one or two points, by separating axes and clipping. Pure
// functions with the same bits everywhere.
#pragma once

#include <cstdint>

#include "base/rotor.h"
#include "bodies/hull.h"

namespace psim {

struct ManifoldPoint {
  float ax = 0, ay = 0;       ///< m: from A's centre, world axes, midway between the surfaces
  float bx = 0, by = 0;       ///< m: the same point from B's centre
  float gap = 0;              ///< m: separation along the normal, negative in overlap
  std::uint16_t feature = 0;  ///< names the corners that meet, so that a point is known again in the next frame
};

struct Manifold {
  float nx = 0, ny = 0;  ///< from A to B
  ManifoldPoint point[2];
  std::int32_t count = 0;
};

/// The manifold of two hulls with any numbers of vertices. The centre of B lies at (dx, dy) from that of A, m, world
/// axes. Points further apart than `margin` are left out; count is 0 if none is left, and then the gap of point[0] is a
/// bound: the hulls have no smaller gap, but for rounding. Two points lie apart by more than a thousandth of the size of
/// the smaller hull.
Manifold collide(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy, float margin);

/// The manifold of B and A, from that of a hull A and a disc B.
Manifold swapped(Manifold m);

/// A hull against the plane at distance `offset` from its centre along the inward normal. Without points as collide().
Manifold meet_plane(const Hull& hull, Rotor q, float nx, float ny, float offset, float margin);

/// The distance between two hulls, and the nearest points. Where the hulls overlap, the distance is negative: the depth
/// along the axis of least overlap.
struct Nearest {
  float distance = 0;    ///< m
  float nx = 0, ny = 0;  ///< from A to B
  float ax = 0, ay = 0;  ///< m: the nearest point of A, from the centre of A
};
Nearest nearest(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy);

/// The share (0..1) of a motion after which two hulls come within `slack` of each other; 1: never.
/// B starts at (dx, dy) from A and moves by (mx, my) while it turns by `turn` rad, A stands.
/// Conservative advancement (Mirtich 1996): the result is never too late. If the hulls are that close from the start,
/// B may come half its inner radius deep; if it is deeper from the start, it is stopped before its centre passes
/// into A.
float time_of_impact(const Hull& a, Rotor qa, const Hull& b, double angle_b, double turn, float dx, float dy, float mx,
                     float my, float slack);

/// Where the ray from (ox, oy) by (rx, ry), relative to the centre of a hull, enters the hull: the share of the way, or
/// 2 if the ray misses. A ray that starts inside gives 0 and a normal of zero.
struct RayCast {
  float fraction = 2;
  float nx = 0, ny = 0;
};
RayCast cast_ray(const Hull& hull, Rotor q, double ox, double oy, double rx, double ry);

}  // namespace psim
