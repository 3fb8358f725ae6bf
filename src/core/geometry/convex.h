// Convex outlines in double precision, relative to the place of a question: where a ray enters one, how far away it
// is, whether two overlap. Pure functions with the same bits everywhere.
#pragma once

#include <cmath>
#include <cstdint>

#include "base/rotor.h"
#include "bodies/hull.h"

namespace psim {

using Outline = ConvexOutline;

/// The difference of two outlines: all vectors from a point of `a` to a point of `b`. The outlines have a point in common
/// where it holds the origin.
struct Difference {
  Vec2 v[2 * Hull::kMost];  ///< m, counter-clockwise
  std::int32_t count = 0;
  double radius = 0;  ///< m
};
Difference difference(const Outline& a, const Outline& b);

/// The smallest box about the core of an outline.
struct Box {
  Vec2 low, high;
  Vec2 middle() const { return {low.x / 2 + high.x / 2, low.y / 2 + high.y / 2}; }
};
Box box_of(const Outline& outline);

/// A box that grows around what it is given.
struct Grown {
  Bounds box{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void add(Vec2 at, double radius);
  void add(const Outline& outline);
};

/// A hull, turned and moved to `at`.
Outline outline_of(const Hull& hull, SineCosine turn, Vec2 at);
/// An outline that is turned and moved to `at`.
Outline outline_of(const Outline& outline, SineCosine turn, Vec2 at);

/// Where a ray from the origin enters an outline.
struct RayEntry {
  double at = -1;  ///< m along the ray; < 0: it does not enter within the limit
  Vec2 normal;     ///< zero where it starts inside
};

/// `u` has length 1. A line without thickness can be entered from either side.
RayEntry enter(const Outline& outline, Vec2 u, double length);
RayEntry enter(const Difference& outline, Vec2 u, double length);
/// Where a ray from the origin enters a disc about `centre`.
RayEntry enter(Vec2 centre, double radius, Vec2 u, double length);

/// The point of an outline nearest to the origin. If the origin lies inside, it is the origin itself at distance 0.
struct NearPoint {
  double distance = 0;  ///< m
  Vec2 point;
};
NearPoint near_point(const Outline& outline);
NearPoint near_point(Vec2 centre, double radius);

/// How far two outlines are apart.
struct Gap {
  double distance = 0;  ///< m; negative: how deep they overlap
  Vec2 normal;          ///< of length 1, from b to a: the shortest way out if they overlap
};
Gap gap_between(const Outline& a, const Outline& b);
/// The point of the surface of b that is nearest to a, seen along a normal of length 1 from b to a: the middle of all
/// nearest points.
Vec2 nearest_point(const Outline& a, const Outline& b, Vec2 normal);

/// Whether two outlines have a point in common.
bool overlap(const Outline& a, const Outline& b);

}  // namespace psim
