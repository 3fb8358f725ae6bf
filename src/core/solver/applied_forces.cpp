#include "solver/applied_forces.h"

#include "base/elementary.h"
#include "views.h"

namespace psim {

namespace {

// What the forces of the host come to in a step.
class HostForces {
 public:
  HostForces(const BodyStore& bodies, const Lattice& lattice, double frame, double dt)
      : bodies_(bodies), frame_(frame), dt_(dt), most_(speed_limit(lattice, dt) / 2 / dt) {}

  Push push(const AppliedForce& of) const {
    const BodyProperties& properties = bodies_.properties(of.id);
    const Vec2 force = (1 / dt_) * (frame_ * of.force + of.impulse);
    const double torque = (frame_ * of.torque + of.spin) / dt_;
    // With the rim speed u = omega R and the gain g = R^2 / I of a body, du/dt = g torque / R.
    return capped({bodies_.info[of.id].slot, static_cast<double>(properties.inv_mass) * force,
                   static_cast<double>(properties.rim_gain) * torque / static_cast<double>(properties.radius)});
  }
  Push capped(Push p) const {
    const double size = length_of(p.acceleration);
    if (size > most_) p.acceleration = (most_ / size) * p.acceleration;
    p.rim_acceleration = greater(-most_, lesser(p.rim_acceleration, most_));
    return p;
  }

 private:
  const BodyStore& bodies_;
  double frame_, dt_, most_;
};

}  // namespace

ForcesOfStep::ForcesOfStep(const Population& population, const Lattice& lattice, double frame, double dt,
                           const Media& media, std::vector<Push>& room)
    : pushes_(room) {
  const HostForces forces(population.bodies, lattice, frame, dt);
  pushes_.clear();
  if (!population.applied.empty()) population.bodies.find_slots();
  for (const AppliedForce& of : population.applied) pushes_.push_back(forces.push(of));
  media.each([&](const Push& push) { pushes_.push_back(forces.capped(push)); });
}

void ForcesOfStep::add(BodyStore& b) const {
  for (const Push& of : pushes_) {
    const std::size_t i = of.slot;
    b.acc[2 * i] = kernels::snapped(static_cast<double>(b.acc[2 * i]) + of.acceleration.x);
    b.acc[2 * i + 1] = kernels::snapped(static_cast<double>(b.acc[2 * i + 1]) + of.acceleration.y);
  }
}

void ForcesOfStep::put_back(BodyStore& b, Vec2 gravity) const {
  for (const Push& of : pushes_) {
    const std::size_t i = of.slot;
    const auto scale = static_cast<double>(b.pull[i]);
    b.acc[2 * i] = kernels::snapped(gravity.x * scale);
    b.acc[2 * i + 1] = kernels::snapped(gravity.y * scale);
  }
}

void ForcesOfStep::kick(BodyStore& b, double h) const {
  for (const Push& of : pushes_) {
    const std::size_t i = of.slot;
    const Vec2 rest{b.vel_remainder[2 * i], b.vel_remainder[2 * i + 1]};
    b.put_velocity(i, b.velocity(i) + rest + h * of.acceleration);
  }
}

void ForcesOfStep::spin(BodyStore& b, double h, bool linked) const {
  if (b.rim_speed.empty()) return;
  for (const Push& of : pushes_) {
    const std::size_t i = of.slot;
    if ((b.linked[i] != 0) != linked) continue;
    b.rim_speed[i] = kernels::snapped(static_cast<double>(b.rim_speed[i]) + h * of.rim_acceleration);
  }
}

LentSpeeds::LentSpeeds(Population& population, const Lattice& lattice, double frame, double dt)
    : population_(population) {
  if (population.applied.empty()) return;
  BodyStore& b = population.bodies;
  const HostForces forces(b, lattice, frame, dt);
  b.find_slots();
  for (AppliedForce& of : population.applied.entries()) {
    const std::size_t i = b.info[of.id].slot;
    of.before = {b.vel[2 * i], b.vel[2 * i + 1], b.rim_speed_of(i)};
    const Push push = forces.push(of);
    const Vec2 dv = dt * push.acceleration;
    b.vel[2 * i] = kernels::snapped(of.before.vx + dv.x);
    b.vel[2 * i + 1] = kernels::snapped(of.before.vy + dv.y);
    b.put_rim_speed(i, of.before.rim_speed + dt * push.rim_acceleration);
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
