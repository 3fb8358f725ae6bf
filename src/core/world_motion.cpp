// The host places, moves and pushes bodies, and asks where one is. What was made ahead for the next step is
// thrown away where it no longer serves; what a number that is not finite would do waits for the step, which
// freezes the body.
#include <cmath>

#include "world_impl.h"

namespace psim {
namespace {

bool finite(double v) { return std::isfinite(v); }

}  // namespace

float surface_speed(double omega, float radius) {
  constexpr double kMost = 1e15;
  return static_cast<float>(std::fmin(std::fmax(omega * static_cast<double>(radius), -kMost), kMost));
}

// The centre of a kinematic body that turns about another place has a velocity of its own.
void World::Impl::go_round(std::uint32_t id, Vec2 velocity) {
  const Make& make = bodies.make(id);
  if (make.centre_x == 0 && make.centre_y == 0) return;
  const std::size_t i = bodies.info[id].slot;
  const Vec2 arm = arm_of(make, bodies.angle.empty() ? 0 : bodies.angle[i]);
  const double omega = bodies.spin.empty() ? 0 : static_cast<double>(bodies.spin[i]) / static_cast<double>(bodies.radius[i]);
  bodies.put_velocity(i, {velocity.x - omega * arm.y, velocity.y + omega * arm.x});
}

// Whether the host may move or push a body: awake from now on, its slot known.
bool World::Impl::can_move(const World& world, BodyId id) {
  settle_lists();
  bodies.find_slots();
  if (!world.is_valid(id)) return false;
  const Place place = bodies.info[id.index].place;
  if (place != Place::moving && place != Place::asleep) return false;
  rouse(id.index);
  return true;
}

bool World::set_transform(BodyId id, Vec2 position, double angle) {
  Impl& w = *impl_;
  if (!w.can_move(*this, id)) return false;
  if (!finite(position.x) || !finite(position.y) || !finite(angle)) {
    w.doubtful.push_back(id);
    return true;
  }
  w.rouse_around(w.bodies.info[id.index], id.index);  // what leaned on it there
  const std::size_t i = w.bodies.info[id.index].slot;
  if (w.desc.boundary == Boundary::walls) {
    const Bounds& b = w.desc.bounds;
    position.x = std::fmin(std::fmax(position.x, b.xmin), b.xmax);
    position.y = std::fmin(std::fmax(position.y, b.ymin), b.ymax);
  }
  const LatticePoint p = w.lattice_centre(w.bodies.make(id.index), position, angle);
  w.bodies.pos[2 * i] = p.x;
  w.bodies.pos[2 * i + 1] = p.y;
  w.bodies.disp[2 * i] = p.dx;
  w.bodies.disp[2 * i + 1] = p.dy;
  if (angle != 0 && w.bodies.angle.empty()) {
    w.traits.turning = w.plan_stale = true;
    w.bodies.add_rotation();
  }
  if (!w.bodies.angle.empty()) w.bodies.angle[i] = angle;
  w.bodies.clear_rests(i);
  w.spoil_lists();
  w.forces_stale = w.placed = true;
  w.queries.forget_moving();
  return true;
}

bool World::set_velocity(BodyId id, Vec2 velocity, double angular_velocity) {
  Impl& w = *impl_;
  if (!w.can_move(*this, id)) return false;
  if (!finite(velocity.x) || !finite(velocity.y) || !finite(angular_velocity)) {
    w.doubtful.push_back(id);
    return true;
  }
  const BodyInfo& info = w.bodies.info[id.index];
  const std::size_t i = info.slot;
  velocity = w.capped(velocity);
  const Impl::Motion before = w.motion_of(i);
  if (angular_velocity != 0 && w.bodies.spin.empty()) {
    w.traits.turning = w.plan_stale = true;
    w.bodies.add_rotation();
  }
  if (!w.bodies.spin.empty()) w.bodies.spin[i] = surface_speed(angular_velocity, w.bodies.radius[i]);
  w.bodies.clear_rests(i);
  w.bodies.put_velocity(i, velocity);
  if (w.bodies.surface(id.index).type == BodyType::kinematic_body) {
    for (auto& [held_id, v] : w.held) {
      if (held_id == id.index) v = velocity;
    }
    w.go_round(id.index, velocity);
  }
  w.pushed(id.index, before);
  w.forces_stale = true;
  return true;
}

bool World::apply_impulse(BodyId id, Vec2 impulse) {
  Impl& w = *impl_;
  if (!w.can_move(*this, id)) return false;
  const BodyInfo& info = w.bodies.info[id.index];
  const std::size_t i = info.slot;
  const double wm = static_cast<double>(w.bodies.surface(id.index).inv_mass);
  const BodyState now = w.state_of(id.index);
  Vec2 v{now.vx + wm * impulse.x, now.vy + wm * impulse.y};
  if (!finite(v.x) || !finite(v.y)) {
    w.doubtful.push_back(id);
    return true;
  }
  v = w.capped(v);
  const Impl::Motion before = w.motion_of(i);
  w.bodies.put_velocity(i, v);
  w.pushed(id.index, before);
  w.forces_stale = true;
  return true;
}

bool World::apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point) {
  Impl& w = *impl_;
  if (!apply_impulse(id, impulse)) return false;
  const std::size_t i = w.bodies.info[id.index].slot;
  const Vec2 centre = w.lattice.to_world(w.bodies.pos[2 * i], w.bodies.pos[2 * i + 1],
                                         w.bodies.disp[2 * i], w.bodies.disp[2 * i + 1]);
  Vec2 arm{point.x - centre.x, point.y - centre.y};
  if (w.desc.boundary == Boundary::periodic) {  // of the nearest image
    const double width = w.desc.bounds.xmax - w.desc.bounds.xmin;
    const double height = w.desc.bounds.ymax - w.desc.bounds.ymin;
    arm.x -= width * std::nearbyint(arm.x / width);
    arm.y -= height * std::nearbyint(arm.y / height);
  }
  return apply_angular_impulse(id, arm.x * impulse.y - arm.y * impulse.x);
}

// d omega = impulse / I, and with u = omega R and the gain R^2 / I: du = gain impulse / R.
bool World::apply_angular_impulse(BodyId id, double impulse) {
  Impl& w = *impl_;
  if (!w.can_move(*this, id)) return false;
  const Surface& surface = w.bodies.surface(id.index);
  if (surface.spin_gain == 0 || impulse == 0) return true;
  const std::size_t i = w.bodies.info[id.index].slot;
  const double change = static_cast<double>(surface.spin_gain) * impulse /
                        static_cast<double>(surface.radius);
  const Impl::Motion before = w.motion_of(i);
  const auto spin = static_cast<float>(static_cast<double>(before.spin) + change);
  if (!finite(static_cast<double>(spin))) {
    w.doubtful.push_back(id);
    return true;
  }
  if (w.bodies.spin.empty()) {
    w.traits.turning = w.plan_stale = true;
    w.bodies.add_rotation();
  }
  w.bodies.spin[i] = spin;
  w.pushed(id.index, before);
  return true;
}

BodyState World::Impl::state_of(std::uint32_t id) const {
  bodies.find_slots();
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::frozen) return frozen[info.slot];
  BodyState s;
  s.id = {id, info.generation};
  s.radius = static_cast<double>(bodies.surface(id).radius);
  s.type = bodies.surface(id).type;
  if (info.place == Place::fixed) {
    s.x = fixed[info.slot].x;
    s.y = fixed[info.slot].y;
    s.angle = fixed[info.slot].angle;
    return s;
  }
  const Make& make = bodies.make(id);
  if (info.place == Place::asleep) {
    const Sleeper& bed = sleepers.list[info.slot];
    const Vec2 centre = lattice.to_world(bed.at.x, bed.at.y, bed.at.dx, bed.at.dy);
    const Vec2 to_centre = arm_of(make, bed.angle);
    s.x = centre.x - to_centre.x;
    s.y = centre.y - to_centre.y;
    s.angle = bed.angle;
    return s;
  }
  const std::size_t i = info.slot;
  Vec2 arm;
  Vec2 p = lattice.to_world(bodies.pos[2 * i], bodies.pos[2 * i + 1], bodies.disp[2 * i],
                                  bodies.disp[2 * i + 1]);
  if (make.centre_x != 0 || make.centre_y != 0) {
    arm = arm_of(make, bodies.angle.empty() ? 0 : bodies.angle[i]);
    p = {p.x - arm.x, p.y - arm.y};
  }
  s.x = p.x;
  s.y = p.y;
  s.vx = static_cast<double>(bodies.vel[2 * i]);
  s.vy = static_cast<double>(bodies.vel[2 * i + 1]);
  if (!bodies.vel_rest.empty()) {
    s.vx += static_cast<double>(bodies.vel_rest[2 * i]);
    s.vy += static_cast<double>(bodies.vel_rest[2 * i + 1]);
  }
  if (!bodies.disp_rest.empty()) {
    s.x += static_cast<double>(bodies.disp_rest[2 * i]);
    s.y += static_cast<double>(bodies.disp_rest[2 * i + 1]);
  }
  if (!bodies.spin.empty()) {
    s.angle = bodies.angle[i];
    s.omega = static_cast<double>(bodies.spin[i]) / static_cast<double>(bodies.radius[i]);
    if (s.type == BodyType::kinematic_body) {  // of its place
      s.vx += s.omega * arm.y;
      s.vy -= s.omega * arm.x;
    }
  }
  return s;
}

std::optional<BodyState> World::body(BodyId id) const {
  if (!is_valid(id)) return std::nullopt;
  return impl_->state_of(id.index);
}

}  // namespace psim
