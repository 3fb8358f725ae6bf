// Descriptions of bodies as the host gives them: what is refused, and the properties that a body gets.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "bodies/body_properties.h"
#include "bodies/hull.h"
#include "psim/desc.h"

namespace psim {

inline bool finite(double v) { return std::isfinite(v); }
inline bool finite(Vec2 v) { return finite(v.x) && finite(v.y); }
inline bool finite(const std::optional<double>& v) { return !v || finite(*v); }
inline bool not_negative(double v) { return v >= 0 && finite(v); }

/// omega r, m/s, within what floats can square.
float rim_speed_of(double omega, float radius);

/// One line that says what is wrong with a description, or nothing. Shapes other than discs are checked when their
/// hulls are made (make_hulls).
std::string check(const BodyDesc& desc, const Bounds& bounds);
std::string check(const DiscBatch& batch, const Bounds& bounds);

/// The value of body i of a batch: 0 if the batch does not give it.
inline double value_or_zero(std::span<const double> s, std::size_t i) { return s.empty() ? 0.0 : s[i]; }

/// Mass of a disc, kg: `mass` if it is above 0, else from the density.
double disc_mass(double radius, double mass, const Material& material);

BodyProperties disc_properties(BodyType type, double radius, double mass, const Material& material,
                               double gravity_scale, bool fixed_rotation);

/// Makes the hulls of a moving body that is no disc, about its centre of mass. A kinematic body turns about its place,
/// but the engine also finds and meets it by its centre, which goes round (Population::go_round). False, with a line
/// in `error`, if the shape is refused.
bool shape_properties(const BodyDesc& desc, HullSet& hulls, BodyProperties& properties, BodyKind& kind,
                      std::string& error);

}  // namespace psim
