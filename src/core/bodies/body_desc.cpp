#include "bodies/body_desc.h"

#include <cmath>
#include <numbers>
#include <span>

namespace psim {
namespace {

bool inside(const Bounds& b, double x, double y) { return x >= b.xmin && x <= b.xmax && y >= b.ymin && y <= b.ymax; }

// One line that says what is wrong with a material, or nothing.
std::string check_material(const Material& m) {
  if (!(m.restitution >= 0 && m.restitution <= 1)) return "restitution must be 0 to 1";
  if (!(m.friction >= 0 && m.friction <= 1000)) return "friction must be 0 to 1000";
  if (!(m.density > 0 && finite(m.density))) return "density must be above 0 and finite";
  return {};
}

// One line that says what is wrong with the radius or the mass of a disc, or nothing. Floats square the radius.
std::string check_disc(double radius, double mass, const Material& m) {
  if (!(radius >= 1e-9 && radius <= 1e9)) return "radius must lie between 1e-9 and 1e9 m";
  if (mass < 0 || !finite(mass)) return "mass must be above 0 and finite (0: from the density)";
  const double result = disc_mass(radius, mass, m);
  if (!(result > 1e-30 && result < 1e30)) return "mass must lie between 1e-30 and 1e30 kg";
  return {};
}

}  // namespace

float rim_speed_of(double omega, float radius) {
  constexpr double kMost = 1e15;
  return static_cast<float>(std::fmin(std::fmax(omega * static_cast<double>(radius), -kMost), kMost));
}

std::string check(const BodyDesc& d, const Bounds& bounds) {
  if (std::string error = check_material(d.material); !error.empty()) return error;
  if (!finite(d.position.x) || !finite(d.position.y) || !finite(d.angle)) return "position and angle must be finite";
  if (!finite(d.velocity.x) || !finite(d.velocity.y) || !finite(d.angular_velocity)) {
    return "velocity and angular velocity must be finite";
  }
  if (!finite(d.gravity_scale)) return "gravity scale must be finite";
  if (!inside(bounds, d.position.x, d.position.y)) return "position must lie inside the world's bounds";
  if (d.sensor && d.type == BodyType::dynamic_body) return "a sensor is static or kinematic";
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) return check_disc(disc->radius, d.mass, d.material);
  return {};
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
  const auto check_one = [&](std::size_t i) -> std::string {
    if (!inside(bounds, batch.x[i], batch.y[i])) return "position must lie inside the world's bounds";
    if (!finite(value_or_zero(batch.vx, i)) || !finite(value_or_zero(batch.vy, i)) ||
        !finite(value_or_zero(batch.angle, i)) || !finite(value_or_zero(batch.angular_velocity, i))) {
      return "angle and velocities must be finite";
    }
    if (i != 0 && batch.radius.size() == 1) return {};
    return check_disc(batch.radius[batch.radius.size() == 1 ? 0 : i], batch.mass, batch.material);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const std::string error = check_one(i);
    if (!error.empty()) return "disc " + std::to_string(i) + " of the batch: " + error;
  }
  return {};
}

double disc_mass(double radius, double mass, const Material& m) {
  return mass > 0 ? mass : m.density * std::numbers::pi * radius * radius;
}

BodyProperties disc_properties(BodyType type, double radius, double mass, const Material& m, double gravity_scale,
                               bool fixed_rotation) {
  BodyProperties properties;
  properties.type = type;
  properties.radius = static_cast<float>(radius);
  properties.restitution = coefficient(m.restitution);
  properties.friction = coefficient(m.friction);
  if (type == BodyType::dynamic_body) {
    properties.mass = static_cast<float>(mass);
    properties.inv_mass = static_cast<float>(1 / mass);
    properties.rim_gain = fixed_rotation ? 0.0f : static_cast<float>(2 / mass);
    properties.gravity_scale = static_cast<float>(gravity_scale);
  }
  return properties;
}

bool shape_properties(const BodyDesc& d, HullSet& hulls, BodyProperties& properties, BodyKind& kind,
                      std::string& error) {
  const bool dynamic = d.type == BodyType::dynamic_body;
  if (dynamic && std::holds_alternative<ChainShape>(d.shape)) {
    error = "a chain is static or kinematic";
    return false;
  }
  if (!make_hulls(d.shape, true, hulls, error)) return false;
  if (d.mass < 0 || !finite(d.mass)) {
    error = "mass must be above 0 and finite (0: from the density)";
    return false;
  }
  const double mass = d.mass > 0 ? d.mass : d.material.density * hulls.mass.area;
  if (dynamic && !(mass > 1e-30 && mass < 1e30)) {
    error = "mass must lie between 1e-30 and 1e30 kg";
    return false;
  }
  float reach = 0, inner = 0;
  for (const Hull& hull : hulls.parts) {
    reach = std::fmax(reach, hull.reach);
    inner = std::fmax(inner, hull.inner);
  }
  kind.inner = inner;
  properties = disc_properties(d.type, static_cast<double>(reach), mass, d.material, d.gravity_scale, d.fixed_rotation);
  kind.centre_x = static_cast<float>(hulls.mass.centre.x);
  kind.centre_y = static_cast<float>(hulls.mass.centre.y);
  if (!dynamic) return true;
  const double r = static_cast<double>(properties.radius);
  const double inertia = mass * hulls.mass.inertia;
  if (!d.fixed_rotation) properties.rim_gain = static_cast<float>(r * r / inertia);
  return true;
}

}  // namespace psim
