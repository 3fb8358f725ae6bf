// Who touches whom, where and how hard, as an array to read after a step.
#pragma once

#include "psim/types.h"

namespace psim {

/// One point in which two bodies touched at the end of the last step. Two shapes that touch along an
/// edge have two, one after the other.
struct Contact {
  BodyId a;               ///< a.index < b.index
  BodyId b;               ///< kNoBody for a wall of the world
  Vec2 point;             ///< metres: midway between the two surfaces; in periodic worlds near a
  Vec2 normal;            ///< of length 1, from a to b
  double separation = 0;  ///< metres: between the surfaces along the normal, negative in overlap
  /// N s, >= 0: that the step put on b along the normal, and its opposite on a. Over dt it is the force.
  double impulse = 0;
  /// N s: likewise along (-normal.y, normal.x); of friction, at most its coefficient x `impulse`.
  double friction = 0;
};

}  // namespace psim
