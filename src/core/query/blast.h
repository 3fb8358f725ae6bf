// What an explosion does to the bodies around it. The push on each convex part is the impulse per length times the width
// that the part shows to the point, and fades with the distance of its nearest point.
//
// In: places of bodies. Out: pushes in the order of ids. O(bodies that are near).
#pragma once

#include <vector>

#include "psim/desc.h"
#include "query/observed.h"

namespace psim {

/// A push on a body, N s, at a point of the world, m.
struct Blow {
  BodyId body;
  Vec2 impulse, point;
};

/// The pushes on dynamic bodies among `near`, which are those with something within radius and falloff.
std::vector<Blow> blows_of(const Explosion& explosion, const Observed& world, const std::vector<BodyId>& near);

}  // namespace psim
