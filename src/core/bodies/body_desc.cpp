#include "bodies/body_desc.h"

#include <cmath>
#include <numbers>
#include <span>

#include "base/elementary.h"
#include "base/range_text.h"

namespace psim {
namespace {

// kg: of a disc.
double disc_mass(double radius, double mass, const Material& m) {
  return mass > 0 ? mass : m.density * std::numbers::pi * radius * radius;
}

void check_material(const Material& m, RangeCheck& check) {
  check("restitution", m.restitution, limits::kRestitution)("friction", m.friction, limits::kFriction);
  check("density", m.density, limits::kDensity);
}

// A mass as it is given, 0 for none, and the one that results.
void check_mass(double given, double mass, RangeCheck& check) {
  if (given != 0) check("mass", given, limits::kMass);
  check("the mass of density and shape", mass, limits::kMassOfShape);
}

}  // namespace

std::string check(const BodyDesc& d, const Bounds& bounds) {
  RangeCheck check;
  check_material(d.material, check);
  check("position", d.position, limits::kCoordinate)("angle", d.angle, limits::kAngle);
  check("velocity", d.velocity, limits::kVelocity);
  check("angular velocity", d.angular_velocity, limits::kAngularVelocity);
  check("gravity scale", d.gravity_scale, limits::kGravityScale);
  const Range radius{limits::kRadius.min,
                     lesser(limits::kRadius.max, greater(bounds.xmax - bounds.xmin, bounds.ymax - bounds.ymin))};
  if (const auto* capsule = std::get_if<CapsuleShape>(&d.shape)) check("radius", capsule->radius, radius);
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    check("radius", disc->radius, radius);
    check_mass(d.mass, disc_mass(disc->radius, d.mass, d.material), check);
  }
  if (!check.error.empty()) return check.error;
  if (!contains(bounds, d.position)) return "position must lie inside the world's bounds";
  if (d.sensor && d.type == BodyType::dynamic_body) return "a sensor is static or kinematic";
  return {};
}

std::string check(const DiscBatch& batch, const Bounds& bounds) {
  const std::size_t n = batch.x.size();
  const auto fits = [n](std::span<const double> s) { return s.empty() || s.size() == n; };
  RangeCheck common;
  check_material(batch.material, common);
  common("gravity scale", batch.gravity_scale, limits::kGravityScale);
  if (!common.error.empty()) return common.error;
  if (batch.y.size() != n) return "x and y must have the same length";
  if (batch.radius.size() != 1 && batch.radius.size() != n) return "radius must have one value or one a disc";
  if (!(fits(batch.angle) && fits(batch.vx) && fits(batch.vy) && fits(batch.angular_velocity))) {
    return "angle, vx, vy and angular_velocity must be empty or have one value a disc";
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::string error = check(disc_of(batch, i), bounds);
    if (!error.empty()) return "disc " + std::to_string(i) + " of the batch: " + error;
  }
  return {};
}

BodyDesc disc_of(const DiscBatch& batch, std::size_t i) {
  const auto value = [i](std::span<const double> s) { return s.empty() ? 0.0 : s[i]; };
  return {.type = batch.type,
          .shape = DiscShape{batch.radius[batch.radius.size() == 1 ? 0 : i]},
          .position = {batch.x[i], batch.y[i]},
          .angle = value(batch.angle),
          .velocity = {value(batch.vx), value(batch.vy)},
          .angular_velocity = value(batch.angular_velocity),
          .material = batch.material,
          .mass = batch.mass,
          .gravity_scale = batch.gravity_scale,
          .fixed_rotation = batch.fixed_rotation,
          .bullet = batch.bullet,
          .sensor = false,
          .filter = batch.filter};
}

BodyProperties properties_of(const BodyDesc& d, double radius, double mass) {
  BodyProperties properties;
  properties.type_bits = static_cast<std::uint32_t>(d.type);
  properties.radius = static_cast<float>(radius);
  properties.restitution = coefficient(d.material.restitution);
  properties.friction = coefficient(d.material.friction);
  if (d.type == BodyType::dynamic_body) {
    properties.mass = static_cast<float>(mass);
    properties.inv_mass = static_cast<float>(1 / mass);
    properties.rim_gain = d.fixed_rotation ? 0.0f : static_cast<float>(2 / mass);
    properties.gravity_scale = static_cast<float>(d.gravity_scale);
  }
  return properties;
}

bool moving_properties(const BodyDesc& d, HullSet& hulls, BodyProperties& properties, BodyKind& kind,
                       std::string& error) {
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    properties = properties_of(d, disc->radius, disc_mass(disc->radius, d.mass, d.material));
    return true;
  }
  const bool dynamic = d.type == BodyType::dynamic_body;
  if (dynamic && std::holds_alternative<ChainShape>(d.shape)) {
    error = "a chain is static or kinematic";
    return false;
  }
  if (!make_hulls(d.shape, true, hulls, error)) return false;
  const double mass = d.mass > 0 ? d.mass : d.material.density * hulls.mass.area;
  RangeCheck check;
  check_mass(d.mass, dynamic ? mass : 1, check);
  error = check.error;
  if (!error.empty()) return false;
  float reach = 0;
  for (const Hull& hull : hulls.parts) {
    reach = greater(hull.reach, reach);
    kind.inner = greater(hull.inner, kind.inner);
  }
  kind.centre_x = static_cast<float>(hulls.mass.centre.x);
  kind.centre_y = static_cast<float>(hulls.mass.centre.y);
  properties = properties_of(d, reach, mass);
  if (!dynamic || d.fixed_rotation) return true;
  const double r = reach, inertia = mass * hulls.mass.inertia;
  properties.rim_gain = static_cast<float>(r * r / inertia);
  return true;
}

}  // namespace psim
