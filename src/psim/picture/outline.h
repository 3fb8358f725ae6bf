// Outlines of figures as polygons, in pixels. Round ones are fine enough that no corner shows (0.04
// pixels at most) and have the area of what they stand for.
#pragma once

#include <span>
#include <vector>

#include "picture/coverage.h"

namespace psim::cli {

/// Corners of a polygon of the area of the unit disc, for a disc of `radius` pixels: 4 (a square with
/// upright sides) below 0.35, else about 11 sqrt(radius). A look-up.
std::span<const Point> unit_circle(double radius);

/// The corners of what lies within `radius` of a convex polygon, given in either order; two points are
/// a capsule, points that are all one are a disc. Empty without points.
void round_outline(std::span<const Point> core, double radius, std::vector<Point>& out);

/// The convex polygon with its sides moved inwards by `distance`; empty if nothing is left.
void shrink(std::span<const Point> polygon, double distance, std::vector<Point>& out);

/// Twice the area, positive if the corners go from the x axis to the y axis.
double twice_area(std::span<const Point> polygon);

}  // namespace psim::cli
