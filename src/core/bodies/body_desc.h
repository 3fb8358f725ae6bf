// Descriptions of bodies as the host gives them: what is refused, and the properties that a body gets.
#pragma once

#include <cmath>
#include <cstddef>
#include <string>

#include "bodies/body_properties.h"
#include "bodies/hull.h"
#include "psim/desc.h"

namespace psim {

inline bool finite(double v) { return std::isfinite(v); }
inline bool finite(Vec2 v) { return finite(v.x) && finite(v.y); }

/// One line that says what is wrong with a description, or nothing. Shapes other than discs are checked when their
/// hulls are made (make_hulls).
std::string check(const BodyDesc& desc, const Bounds& bounds);
std::string check(const DiscBatch& batch, const Bounds& bounds);

/// One disc of a batch.
BodyDesc disc_of(const DiscBatch& batch, std::size_t i);

/// The properties of a body of this radius and mass that turns as a disc does.
BodyProperties properties_of(const BodyDesc& desc, double radius, double mass);

/// The properties of a moving body. Of one that is no disc it makes the hulls, about its centre of mass. A kinematic
/// body turns about its place, but the engine also finds and meets it by its centre, which goes round
/// (Population::go_round). False, with a line in `error`, if the shape is refused.
bool moving_properties(const BodyDesc& desc, HullSet& hulls, BodyProperties& properties, BodyKind& kind,
                       std::string& error);

}  // namespace psim
