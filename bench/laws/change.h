// Scenes changed in ways that must not matter, and what a state of the changed scene says of the scene as it was.
#pragma once

#include "draw.h"
#include "psim/scene.h"

namespace psim::laws {

/// A map of the plane, turned or mirrored, scaled and moved: (x, y) -> scale turn (x, y) + shift; times grow by
/// `slower`. Velocities gain `boost`.
struct Change {
  bool mirror = false;  ///< x changes its sign, before the turn
  int quarters = 0;     ///< turns to the left
  double scale = 1;
  double slower = 1;
  double heavier = 1;  ///< factor on masses
  Vec2 shift;          ///< m
  Vec2 boost;          ///< m/s: all move by it, fixed bodies become kinematic

  Vec2 direction(Vec2 v) const;
  Scene of(const Scene& scene) const;
  /// A state of the changed scene `time` seconds (its own) after the start, as one of the scene as it was.
  BodyState back(const BodyState& state, double time) const;
};

/// Vertices of chains, segments and polygons in another order; bodies in the same.
Scene relisted(const Scene& scene, Draw& draw);
/// Straight parts of segments and chains cut into several.
Scene cut_finer(const Scene& scene, Draw& draw);
/// Chains as segments, a body each. Ids of the bodies before stay; the new ones come last.
Scene apart(const Scene& scene);
/// Static bodies as kinematic ones at rest.
Scene kinematic(const Scene& scene);

}  // namespace psim::laws
