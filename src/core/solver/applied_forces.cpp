#include "solver/applied_forces.h"

#include "base/elementary.h"
#include "views.h"

namespace psim {

ForcesOfStep::ForcesOfStep(const Population& population, const Lattice& lattice, double frame, double dt)
    : population_(population), frame_(frame), dt_(dt), most_(speed_limit(lattice, dt) / 2 / dt) {}

Vec2 ForcesOfStep::acceleration_of(const AppliedForce& of) const {
  const Vec2 force = (1 / dt_) * (frame_ * of.force + of.impulse);
  const Vec2 a = static_cast<double>(population_.bodies.properties(of.id).inv_mass) * force;
  const double size = length_of(a);
  return size > most_ ? (most_ / size) * a : a;
}

// With the rim speed u = omega R and the gain g = R^2 / I of a body, du/dt = g torque / R.
double ForcesOfStep::rim_acceleration_of(const AppliedForce& of) const {
  const BodyProperties& properties = population_.bodies.properties(of.id);
  const double torque = (frame_ * of.torque + of.spin) / dt_;
  const double a = static_cast<double>(properties.rim_gain) * torque / static_cast<double>(properties.radius);
  return greater(-most_, lesser(a, most_));
}

void ForcesOfStep::add(BodyStore& b) const {
  for (const AppliedForce& of : population_.applied) {
    const std::size_t i = b.info[of.id].slot;
    const Vec2 a = acceleration_of(of);
    b.acc[2 * i] = kernels::snapped(static_cast<double>(b.acc[2 * i]) + a.x);
    b.acc[2 * i + 1] = kernels::snapped(static_cast<double>(b.acc[2 * i + 1]) + a.y);
  }
}

void ForcesOfStep::put_back(BodyStore& b, Vec2 gravity) const {
  for (const AppliedForce& of : population_.applied) {
    const std::size_t i = b.info[of.id].slot;
    const auto scale = static_cast<double>(b.pull[i]);
    b.acc[2 * i] = kernels::snapped(gravity.x * scale);
    b.acc[2 * i + 1] = kernels::snapped(gravity.y * scale);
  }
}

void ForcesOfStep::kick(BodyStore& b, double h) const {
  for (const AppliedForce& of : population_.applied) {
    const std::size_t i = b.info[of.id].slot;
    const Vec2 rest{b.vel_remainder[2 * i], b.vel_remainder[2 * i + 1]};
    b.put_velocity(i, b.velocity(i) + rest + h * acceleration_of(of));
  }
}

void ForcesOfStep::spin(BodyStore& b, double h, bool linked) const {
  if (b.rim_speed.empty()) return;
  for (const AppliedForce& of : population_.applied) {
    const std::size_t i = b.info[of.id].slot;
    if ((b.linked[i] != 0) != linked) continue;
    b.rim_speed[i] = kernels::snapped(static_cast<double>(b.rim_speed[i]) + h * rim_acceleration_of(of));
  }
}

LentSpeeds::LentSpeeds(Population& population, const Lattice& lattice, double frame, double dt)
    : population_(population) {
  if (population.applied.empty()) return;
  BodyStore& b = population.bodies;
  const ForcesOfStep forces(population, lattice, frame, dt);
  b.find_slots();
  for (AppliedForce& of : population.applied.entries()) {
    const std::size_t i = b.info[of.id].slot;
    of.before = {b.vel[2 * i], b.vel[2 * i + 1], b.rim_speed_of(i)};
    const Vec2 dv = dt * forces.acceleration_of(of);
    b.vel[2 * i] = kernels::snapped(of.before.vx + dv.x);
    b.vel[2 * i + 1] = kernels::snapped(of.before.vy + dv.y);
    b.put_rim_speed(i, of.before.rim_speed + dt * forces.rim_acceleration_of(of));
  }
}

LentSpeeds::~LentSpeeds() {
  if (population_.applied.empty()) return;
  BodyStore& b = population_.bodies;
  b.find_slots();
  for (const AppliedForce& of : population_.applied) {
    const std::size_t i = b.info[of.id].slot;
    b.vel[2 * i] = of.before.vx, b.vel[2 * i + 1] = of.before.vy;
    if (!b.rim_speed.empty()) b.rim_speed[i] = of.before.rim_speed;
  }
}

}  // namespace psim
