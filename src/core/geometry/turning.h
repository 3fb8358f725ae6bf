// When two shapes that go and turn come to touch, by conservative advancement (Mirtich 1996; the bound along one direction
// as in Box2D's b2TimeOfImpact).
//
// Two outlines are apart by their gap along the normal n between them. Along this fixed n, corner r of the first one comes
// nearer by
//   -n.way t - n.(w x r) t + |r| w^2 t^2 / 2    at most,
// where the last term bounds what the turning bends, and the corners of the second one likewise. The least t at which two
// corners could close the gap is safe: up to it the outlines do not touch. Some ten looks come to the time of touch from
// below.
#pragma once

#include "geometry/convex.h"

namespace psim {

/// rad: a shape that turns by more on its way is not followed.
inline constexpr double kMostRotation = 1000;

/// The outline of a shape that starts at `from`, turned by `angle`, goes `way` and turns by `rotation` about the origin of
/// its own frame meanwhile, evenly.
struct Turning {
  const Outline& shape;            ///< in its own frame
  double angle = 0, rotation = 0;  ///< rad
  Vec2 from = {}, way = {};        ///< m

  Vec2 place_at(double share) const { return from + share * way; }
  Outline outline_at(double share) const {
    return outline_of(shape, sine_cosine(angle + share * rotation), place_at(share));
  }
  /// Whether the rotation moves it at all.
  bool turns() const { return rotation != 0 && (shape.count > 1 || shape.v[0] != Vec2{}); }
};

/// Where the two first touch, as a share of their ways; < 0: they do not within `limit`. The normal is that of `b` there;
/// zero where the two overlap at the start. Good to 1e-7 m of the gap.
RayEntry touch_turning(const Turning& a, const Turning& b, double limit);

}  // namespace psim
