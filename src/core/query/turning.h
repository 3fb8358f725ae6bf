// When a shape that goes and turns comes to touch another one, by conservative advancement (Mirtich 1996; the bound along
// one direction as in Box2D's b2TimeOfImpact).
//
// Two outlines are apart by their gap along the normal n between them. Along this fixed n, corner r of the one that moves
// comes nearer by
//   -n.way t - n.(w x r) t + |r| w^2 t^2 / 2    at most,
// where the last term bounds what the turning bends. The least t at which a corner could close the gap is safe: up to it
// the two do not touch. Some ten looks come to the time of touch from below.
#pragma once

#include "query/query_shapes.h"

namespace psim {

/// A hull that starts at the origin, turned by `angle`, goes `way` and turns by `rotation` about the origin of its own frame
/// meanwhile, evenly.
struct Turning {
  const Hull& hull;
  double angle = 0, rotation = 0;  ///< rad
  Vec2 way;                        ///< m

  Outline outline_at(double share) const {
    return outline_of(hull, sine_cosine(angle + share * rotation), share * way);
  }
};

/// Where the hull first touches the outline, as a share of its way; < 0: it does not within `limit`. The normal is that of
/// the outline there; zero where the two overlap at the start. Good to 1e-7 m of the gap.
RayEntry touch_turning(const Turning& turning, const Outline& other, double limit);

}  // namespace psim
