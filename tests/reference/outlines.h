// Distances between rounded convex outlines by brute force, in double precision. The oracle for queries and sensors;
// it sees no engine code.
#pragma once

#include <vector>

#include "closed_forms.h"

namespace reference {

/// Convex, counter-clockwise; one or two points are a point or a line. `radius` all around it.
struct Outline {
  std::vector<Vec> points;
  double radius = 0;
};

/// Distance of a point from an outline's surface; 0 inside.
double distance(const Outline& o, Vec point);

/// Distance of two outlines; 0 where they overlap: of the origin from their Minkowski difference.
double distance(const Outline& a, const Outline& b);

/// How deep two outlines overlap, the shortest way out; negative: how far they are apart.
double depth(const Outline& a, const Outline& b);

/// How far a ray from p to q gets before it enters, as a share of the way; 2: it does not. `least` is
/// how near it comes at most. By steps as long as the distance.
double march(const Outline& o, Vec p, Vec q, double& least);

}  // namespace reference
