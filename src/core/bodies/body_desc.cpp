#include "bodies/body_desc.h"

#include <cmath>
#include <numbers>
#include <span>

#include "base/elementary.h"

namespace psim {
namespace {

// kg: of a disc.
double disc_mass(double radius, double mass, const Material& m) {
  return mass > 0 ? mass : m.density * std::numbers::pi * radius * radius;
}

// One line that says what is wrong with a material, or nothing.
std::string check_material(const Material& m) {
  if (!(m.restitution >= 0 && m.restitution <= 1)) return "restitution must be 0 to 1";
  if (!(m.friction >= 0 && m.friction <= 1000)) return "friction must be 0 to 1000";
  if (!(m.density > 0 && finite(m.density))) return "density must be above 0 and finite";
  return {};
}

// The same of a mass as it is given, and of the one that results.
std::string check_mass(double given, double mass) {
  if (given < 0 || !finite(given)) return "mass must be above 0 and finite (0: from the density)";
  if (!(mass > 1e-30 && mass < 1e30)) return "mass must lie between 1e-30 and 1e30 kg";
  return {};
}

}  // namespace

std::string check(const BodyDesc& d, const Bounds& bounds) {
  if (std::string error = check_material(d.material); !error.empty()) return error;
  if (!finite(d.position) || !finite(d.angle)) return "position and angle must be finite";
  if (!finite(d.velocity) || !finite(d.angular_velocity)) return "velocity and angular velocity must be finite";
  if (!finite(d.gravity_scale)) return "gravity scale must be finite";
  if (!contains(bounds, d.position)) return "position must lie inside the world's bounds";
  if (d.sensor && d.type == BodyType::dynamic_body) return "a sensor is static or kinematic";
  const auto* disc = std::get_if<DiscShape>(&d.shape);
  if (disc == nullptr) return {};
  // Floats square the radius.
  if (!(disc->radius >= 1e-9 && disc->radius <= 1e9)) return "radius must lie between 1e-9 and 1e9 m";
  return check_mass(d.mass, disc_mass(disc->radius, d.mass, d.material));
}

std::string check(const DiscBatch& batch, const Bounds& bounds) {
  const std::size_t n = batch.x.size();
  const auto fits = [n](std::span<const double> s) { return s.empty() || s.size() == n; };
  if (std::string error = check_material(batch.material); !error.empty()) return error;
  if (batch.y.size() != n) return "x and y must have the same length";
  if (batch.radius.size() != 1 && batch.radius.size() != n) return "radius must have one value or one a disc";
  if (!(fits(batch.angle) && fits(batch.vx) && fits(batch.vy) && fits(batch.angular_velocity))) {
    return "angle, vx, vy and angular_velocity must be empty or have one value a disc";
  }
  if (!finite(batch.gravity_scale)) return "gravity scale must be finite";
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
  error = check_mass(d.mass, dynamic ? mass : 1);
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
