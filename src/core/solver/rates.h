// Impacts of two bodies, by their rates of motion: velocities, or ways in a step.
#pragma once

#include <cstddef>
#include <span>

#include "collide/collide.h"
#include "psim/types.h"

namespace psim {

/// How fast a body goes and turns: m/s and rad/s, or m and rad in a step.
struct Rates {
  Vec2 along;
  double turn = 0;
};

/// Two bodies in an impact: inverse masses and inertias, 0 for what does not give way, and what their surfaces are like.
struct ImpactSurface {
  double wa = 0, ia = 0, wb = 0, ib = 0;
  double restitution = 0, friction = 0;
  double belt = 0;   // what the surfaces run, B against A, to the left of the normal
  double least = 0;  // slower impacts do not bounce
};

/// A point of an impact, by its arms from the centres.
struct ImpactPoint {
  Vec2 a, b;
};

/// The outermost points along a surface at which a body touches it.
struct Touching {
  Vec2 along;
  ImpactPoint points[2];
  std::size_t count = 0;

  void add(const ImpactPoint& p) {
    const auto place = [&](const ImpactPoint& q) { return dot(along, q.b); };
    if (count == 0) {
      points[0] = points[1] = p;
      count = 1;
    } else if (place(p) < place(points[0])) {
      points[0] = p;
      count = 2;
    } else if (place(p) > place(points[1])) {
      points[1] = p;
      count = 2;
    }
  }
  void add(const Manifold& m, Vec2 apart, double most_gap) {
    for (int k = 0; k < m.count; ++k) {
      const Vec2 arm{m.point[k].bx, m.point[k].by};
      if (double{m.point[k].gap} <= most_gap) add({apart + arm, arm});
    }
  }
};

/// The impulses of an impact in one or two points at once (Newton's law at each of them), and then friction. Does nothing
/// if the bodies part already.
void collide_rates(Rates& a, Rates& b, const ImpactSurface& s, Vec2 n, std::span<const ImpactPoint> points);

}  // namespace psim
