// Where two hulls touch or nearly touch: a normal and one or two points. Separating axes and
// clipping, pure functions, the same bits everywhere.
#pragma once

#include <cstdint>

#include "hull.h"

namespace psim {

/// A rotation: cosine and sine.
struct Rotor {
  float c = 1, s = 0;
};

struct ManifoldPoint {
  float ax = 0, ay = 0;  ///< m: from A's centre, world axes, midway between the surfaces
  float bx = 0, by = 0;  ///< m: the same point from B's centre
  float gap = 0;         ///< m: separation along the normal, negative in overlap
  std::uint16_t feature = 0;  ///< the same from frame to frame while the same corners meet
};

struct Manifold {
  float nx = 0, ny = 0;  ///< from A to B
  ManifoldPoint point[2];
  std::int32_t count = 0;
};

/// B's centre lies at (dx, dy) from A's, m, world axes. Points further apart than `margin` are left
/// out; count is 0 if none is left. Any counts of vertices. Points of two lie apart by more than a
/// thousandth of the smaller hull's size.
Manifold collide(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy,
                 float margin);

/// Distance between two hulls and the nearest points; negative distance (depth along the axis of
/// least overlap) where they overlap.
struct Nearest {
  float distance = 0;    ///< m
  float nx = 0, ny = 0;  ///< from A to B
  float ax = 0, ay = 0;  ///< m: A's nearest point from A's centre
};
Nearest nearest(const Hull& a, Rotor qa, const Hull& b, Rotor qb, float dx, float dy);

/// The share (0..1) of a motion after which two hulls come within `slack` of each other; 1: never.
/// B starts at (dx, dy) from A and moves by (mx, my) while it turns by `turn` rad, A stands.
/// Conservative advancement (Mirtich 1996): never late. If they are that close from the start, half
/// of B's inner radius deep counts instead; deeper than that from the start: before B's centre
/// passes into A.
float time_of_impact(const Hull& a, Rotor qa, const Hull& b, double angle_b, double turn, float dx,
                     float dy, float mx, float my, float slack);

/// Where the ray from (ox, oy) by (rx, ry), seen from the hull's centre, enters it: its share of the way, or 2 if it
/// misses. A ray that starts inside: 0 and a zero normal.
struct RayCast {
  float fraction = 2;
  float nx = 0, ny = 0;
};
RayCast cast_ray(const Hull& hull, Rotor q, double ox, double oy, double rx, double ry);

}  // namespace psim
