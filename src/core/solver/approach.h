// When two convex hulls that move and turn come within a distance of each other: conservative advancement
// (Mirtich 1996) in the frame of the first one. Nothing is missed, however fast they are.
#pragma once

#include "base/rotor.h"
#include "collide/closing.h"
#include "collide/collide.h"

namespace psim {

/// How a body goes through a part of a step: evenly, from share 0 to share 1.
struct Course {
  Vec2 at, way;                ///< m: the point about which it turns, and how far that goes
  double angle = 0, turn = 0;  ///< rad: at the start, and how far it turns
  Vec2 arm = {};               ///< m: from that point to the centre of the hull, in the frame of the body

  Vec2 place(double share) const { return at + share * way; }
  double facing(double share) const { return angle + share * turn; }
};

/// Two hulls on their courses. B turns about its centre.
class Approach {
 public:
  Approach(const Hull& a, const Course& of_a, const Hull& b, const Course& of_b)
      : a_(a), b_(b), of_a_(of_a), of_b_(of_b), way_(of_b.way - of_a.way), turn_(of_b.turn - of_a.turn) {}

  /// How the hulls stand at a share of their courses.
  struct Stand {
    double distance = 0;  ///< m; negative: the depth along the axis of least overlap
    double advance = 0;   ///< share in which the distance cannot have fallen to the limit that was asked for
  };
  Stand stand(double share, double limit) const;

  static constexpr double kNever = 2;
  /// The share, not below `from`, at which the distance falls to `limit`, or kNever. It is found to `tolerance`, and is
  /// never too late.
  double falls_to(double limit, double tolerance, double from) const;

  /// The manifold of the hulls at a share, in world axes. Its arms are from the centre of A's hull and from that of B.
  Manifold touch(double share, double margin) const;
  /// The normal, in world axes, of the surface through which the middle of B goes into A from outside, up to a share; 0:
  /// it does not.
  Vec2 entry(double share = 1) const;

 private:
  struct Frame {
    SineCosine back;  // into the frame of A
    Vec2 pivot, way;  // from the point about which A turns to B's centre, and how that moves, in this frame
    double angle;     // of B
  };
  Frame frame(double share) const;

  const Hull &a_, &b_;
  const Course &of_a_, &of_b_;
  const Vec2 way_;     // of B against A, m
  const double turn_;  // rad
};

}  // namespace psim
