// Bodies come and go: ids, slots, traits. Every call leaves the lists stale; the next step makes
// them anew.
#include <cmath>
#include <cstdio>

#include "world_impl.h"

namespace psim {
namespace {

constexpr double kPi = 3.14159265358979323846;

bool finite(double v) { return std::isfinite(v); }

// One line of what is wrong with a material, or empty.
std::string check_material(const Material& m) {
  if (!(m.restitution >= 0 && m.restitution <= 1)) return "restitution must be 0 to 1";
  if (!(m.friction >= 0 && m.friction <= 1000)) return "friction must be 0 to 1000";
  if (!(m.density > 0 && finite(m.density))) return "density must be above 0 and finite";
  return {};
}

std::string check_motion(Vec2 velocity, double omega) {
  if (!finite(velocity.x) || !finite(velocity.y) || !finite(omega)) {
    return "velocity and angular velocity must be finite";
  }
  return {};
}

struct Inertia {
  double mass = 0;
  std::string error;
};

Inertia disc_mass(double radius, double mass, const Material& m) {
  if (!(radius > 0 && radius <= 1e9)) return {0, "radius must be above 0 and at most 1e9 m"};
  if (mass < 0 || !finite(mass)) return {0, "mass must be above 0 and finite (0: from the density)"};
  const double result = mass > 0 ? mass : m.density * kPi * radius * radius;
  if (!(result > 1e-30 && result < 1e30)) return {0, "mass must lie between 1e-30 and 1e30 kg"};
  return {result, {}};
}

bool inside(const Bounds& b, double x, double y) {
  return x >= b.xmin && x <= b.xmax && y >= b.ymin && y <= b.ymax;
}

Surface disc_surface(BodyType type, double radius, double mass, const Material& m,
                   double gravity_scale, bool fixed_rotation) {
  Surface info;
  info.type = type;
  info.radius = static_cast<float>(radius);
  info.restitution = static_cast<float>(m.restitution);
  info.friction = static_cast<float>(m.friction);
  if (type == BodyType::dynamic_body) {
    info.mass = static_cast<float>(mass);
    info.inv_mass = static_cast<float>(1 / mass);
    info.spin_gain = fixed_rotation ? 0.0f : static_cast<float>(2 / mass);
    info.gravity_scale = static_cast<float>(gravity_scale);
  }
  return info;
}

}  // namespace

void World::Impl::count_in(const Surface& info, int sign) {
  const auto add = [sign](std::uint64_t& counter, bool yes) {
    if (yes) counter += static_cast<std::uint64_t>(static_cast<std::int64_t>(sign));
  };
  if (sign > 0 && traits.moving == 0) {
    first_mass = info.mass;
    first_radius = info.radius;
    first_surface = info;
    least_radius = info.radius;
  }
  if (sign > 0) least_radius = std::fmin(least_radius, info.radius);
  add(traits.moving, true);
  add(traits.same_mass, info.mass == first_mass);
  add(traits.same_radius, info.radius == first_radius);
  add(traits.same_surface, info.mass == first_mass && info.restitution == first_surface.restitution &&
                               info.friction == first_surface.friction &&
                               info.spin_gain == first_surface.spin_gain);
  add(traits.moving_bounce, info.restitution > 0);
  add(traits.moving_rough, info.friction > 0);
  add(traits.kinematic, info.type == BodyType::kinematic_body);
  add(traits.odd_gravity, info.type == BodyType::dynamic_body && info.gravity_scale != 1);
  plan_stale = true;
}

// Velocities above the engine's cap would carry a body past the lattice: they are cut to it.
Vec2 World::Impl::capped(Vec2 v) const {
  const double speed = std::sqrt(v.x * v.x + v.y * v.y), limit = 0.999 * speed_limit(desc.dt);
  return speed > limit ? Vec2{v.x / speed * limit, v.y / speed * limit} : v;
}

// Gives a moving disc an id and a slot at the end of the columns.
std::uint32_t World::Impl::enter(const Surface& surface, Vec2 at, double angle, Vec2 velocity,
                                 double omega) {
  velocity = capped(velocity);
  bodies.find_slots();
  const std::uint32_t id = bodies.take_id();
  // Where bodies leave by themselves, steps give ids back: they must not allocate for that.
  if (desc.boundary == Boundary::open) bodies.free_ids.reserve(bodies.info.capacity());
  const std::uint32_t slot = bodies.count;
  BodyInfo& info = bodies.info[id];
  info.slot = slot;
  info.surface = bodies.surfaces.acquire(surface);
  info.place = Place::moving;
  if (angle != 0 || omega != 0) {
    traits.turning = true;
    if (bodies.spin.empty()) bodies.add_rotation();
  }
  const LatticePoint p = lattice.to_lattice(at);
  bodies.pos[2 * std::size_t{slot}] = p.x;
  bodies.pos[2 * std::size_t{slot} + 1] = p.y;
  bodies.disp[2 * std::size_t{slot}] = p.dx;
  bodies.disp[2 * std::size_t{slot} + 1] = p.dy;
  bodies.id[slot] = id;
  bodies.radius[slot] = surface.radius;
  bodies.linked[slot] = 0;
  if (traits.fields) bodies.add_rests(desc.integrator != Integrator::verlet);
  bodies.clear_rests(slot);
  bodies.put_velocity(slot, velocity);
  if (!bodies.spin.empty()) {
    bodies.spin[slot] = static_cast<float>(omega) * surface.radius;
    bodies.angle[slot] = angle;
  }
  ++bodies.count;
  ++bodies.moving;
  placed = true;
  if (surface.type == BodyType::kinematic_body) held.emplace_back(id, velocity);
  return id;
}

BodyId World::add_body(const BodyDesc& d, std::string& error) {
  Impl& w = *impl_;
  error = check_material(d.material);
  if (error.empty() && (!finite(d.position.x) || !finite(d.position.y) || !finite(d.angle))) {
    error = "position and angle must be finite";
  }
  if (error.empty()) error = check_motion(d.velocity, d.angular_velocity);
  if (error.empty() && !finite(d.gravity_scale)) error = "gravity scale must be finite";
  if (error.empty() && !inside(w.desc.bounds, d.position.x, d.position.y)) {
    error = "position must lie inside the world's bounds";
  }
  if (!error.empty()) return kNoBody;

  if (const auto* disc = std::get_if<DiscShape>(&d.shape); disc != nullptr) {
    const Inertia inertia = disc_mass(disc->radius, d.mass, d.material);
    if (!inertia.error.empty()) {
      error = inertia.error;
      return kNoBody;
    }
    if (d.type != BodyType::static_body) {
      w.bodies.reserve_slots(1);
      const Surface info = disc_surface(d.type, disc->radius, inertia.mass, d.material,
                                      d.gravity_scale, d.fixed_rotation);
      const std::uint32_t id = w.enter(info, d.position, d.angle, d.velocity, d.angular_velocity);
      w.count_in(info, +1);
      w.lists_stale = true;
      return {id, w.bodies.info[id].generation};
    }
  } else if (d.type != BodyType::static_body) {
    error = "segments and chains can only be static";
    return kNoBody;
  }

  // Static: shapes in world coordinates.
  std::vector<StaticShape> parts;
  const double c = std::cos(d.angle), s = std::sin(d.angle);
  const auto place = [&](Vec2 p) {
    return Vec2{d.position.x + c * p.x - s * p.y, d.position.y + s * p.x + c * p.y};
  };
  const auto segment = [&](Vec2 p, Vec2 q) {
    if (!finite(p.x) || !finite(p.y) || !finite(q.x) || !finite(q.y)) {
      error = "segment points must be finite";
    } else if (p.x == q.x && p.y == q.y) {
      error = "segment points must differ";
    }
    StaticShape part;
    part.segment = true;
    Vec2 from = place(p), to = place(q);
    w.lattice.clip(from, to);
    part.p = w.lattice.to_lattice(from);
    part.q = w.lattice.to_lattice(to);
    parts.push_back(part);
  };
  float radius = 0;
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    StaticShape part;
    part.p = w.lattice.to_lattice(d.position);
    part.radius = radius = static_cast<float>(disc->radius);
    parts.push_back(part);
  } else if (const auto* line = std::get_if<SegmentShape>(&d.shape)) {
    segment(line->p1, line->p2);
  } else {
    const auto& chain = std::get<ChainShape>(d.shape);
    const std::size_t n = chain.vertices.size();
    if (n < (chain.loop ? 3u : 2u)) {
      error = chain.loop ? "a chain loop needs at least 3 vertices"
                         : "a chain needs at least 2 vertices";
      return kNoBody;
    }
    for (std::size_t k = 0; k + 1 < n; ++k) segment(chain.vertices[k], chain.vertices[k + 1]);
    if (chain.loop) segment(chain.vertices[n - 1], chain.vertices[0]);
  }
  if (!error.empty()) return kNoBody;

  const std::uint32_t id = w.bodies.take_id();
  Surface surface;
  surface.type = BodyType::static_body;
  surface.radius = radius;
  surface.restitution = static_cast<float>(d.material.restitution);
  surface.friction = static_cast<float>(d.material.friction);
  BodyInfo& info = w.bodies.info[id];
  const std::uint32_t generation = info.generation;
  info.surface = w.bodies.surfaces.acquire(surface);
  info.place = Place::fixed;
  info.slot = static_cast<std::uint32_t>(w.fixed.size());
  FixedBody f;
  f.x = d.position.x;
  f.y = d.position.y;
  f.angle = d.angle;
  f.radius = radius;
  f.id = id;
  f.first_shape = static_cast<std::uint32_t>(w.shapes.size());
  for (StaticShape& part : parts) {
    part.owner = id;
    part.restitution = surface.restitution;
    part.friction = surface.friction;
    w.shapes.add(part);
  }
  w.fixed.push_back(f);
  ++w.bodies.fixed;
  ++w.traits.fixed;
  if (surface.restitution > 0) ++w.traits.fixed_bounce;
  if (surface.friction > 0) ++w.traits.fixed_rough;
  w.plan_stale = w.lists_stale = w.placed = true;
  return {id, generation};
}

std::size_t World::add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error) {
  Impl& w = *impl_;
  const std::size_t n = batch.x.size();
  const auto fits = [n](std::span<const double> s) { return s.empty() || s.size() == n; };
  error = check_material(batch.material);
  if (error.empty() && batch.y.size() != n) error = "x and y must have the same length";
  if (error.empty() && batch.radius.size() != 1 && batch.radius.size() != n) {
    error = "radius must have one value or one a disc";
  }
  if (error.empty() && !(fits(batch.angle) && fits(batch.vx) && fits(batch.vy) &&
                         fits(batch.angular_velocity))) {
    error = "angle, vx, vy and angular_velocity must be empty or have one value a disc";
  }
  if (error.empty() && !finite(batch.gravity_scale)) error = "gravity scale must be finite";
  if (!error.empty()) return 0;
  const auto value = [](std::span<const double> s, std::size_t i) { return s.empty() ? 0.0 : s[i]; };
  const auto radius_of = [&](std::size_t i) { return batch.radius[batch.radius.size() == 1 ? 0 : i]; };
  for (std::size_t i = 0; i < n; ++i) {
    const double vx = value(batch.vx, i), vy = value(batch.vy, i);
    if (!inside(w.desc.bounds, batch.x[i], batch.y[i])) {
      error = "position must lie inside the world's bounds";
    } else if (!finite(vx) || !finite(vy) || !finite(value(batch.angle, i)) ||
               !finite(value(batch.angular_velocity, i))) {
      error = "angle and velocities must be finite";
    } else if (i == 0 || batch.radius.size() != 1) {
      error = disc_mass(radius_of(i), batch.mass, batch.material).error;
    }
    if (!error.empty()) {
      error = "disc " + std::to_string(i) + " of the batch: " + error;
      return 0;
    }
  }
  first = w.bodies.free_ids.empty() ? w.bodies.id_count : w.bodies.free_ids.back();
  if (batch.type == BodyType::static_body) {
    BodyDesc d;
    d.type = BodyType::static_body;
    d.material = batch.material;
    w.fixed.reserve(w.fixed.size() + n);
    for (std::size_t i = 0; i < n; ++i) {
      d.shape = DiscShape{radius_of(i)};
      d.position = {batch.x[i], batch.y[i]};
      d.angle = value(batch.angle, i);
      add_body(d, error);
    }
    return n;
  }
  w.bodies.reserve_slots(n);
  w.bodies.info.reserve(w.bodies.id_count + n);
  for (std::size_t i = 0; i < n; ++i) {
    const double r = radius_of(i);
    const double mass = batch.mass > 0 ? batch.mass : batch.material.density * kPi * r * r;
    const Surface info = disc_surface(batch.type, r, mass, batch.material, batch.gravity_scale,
                                    batch.fixed_rotation);
    w.enter(info, {batch.x[i], batch.y[i]}, value(batch.angle, i),
            {value(batch.vx, i), value(batch.vy, i)}, value(batch.angular_velocity, i));
    w.count_in(info, +1);
  }
  w.lists_stale = true;
  return n;
}

// Takes a body out. Its slot stays as a dead one until the next sort.
void World::Impl::remove(std::uint32_t id) {
  bodies.find_slots();
  BodyInfo& info = bodies.info[id];
  const Surface surface = bodies.surface(id);
  bodies.surfaces.release(info.surface);
  if (info.place == Place::moving) {
    bodies.id[info.slot] = kNoSlot;
    ++bodies.dead;
    --bodies.moving;
    count_in(surface, -1);
    if (surface.type == BodyType::kinematic_body) {
      std::erase_if(held, [id](const auto& h) { return h.first == id; });
    }
  } else if (info.place == Place::fixed) {
    const std::uint32_t at = info.slot;
    shapes.remove(fixed[at].first_shape, id);
    fixed[at] = fixed.back();
    bodies.info[fixed[at].id].slot = at;
    fixed.pop_back();
    --bodies.fixed;
    --traits.fixed;
    if (surface.restitution > 0) --traits.fixed_bounce;
    if (surface.friction > 0) --traits.fixed_rough;
    plan_stale = true;
  } else {
    const std::uint32_t at = info.slot;
    frozen[at] = frozen.back();
    bodies.info[frozen[at].id.index].slot = at;
    frozen.pop_back();
  }
  info.place = Place::none;
  info.slot = kNoSlot;
  ++info.generation;
  --bodies.living;
  bodies.free_ids.push_back(id);
  lists_stale = true;
}

// Out of the simulation, but still there: a body whose numbers are broken.
void World::Impl::freeze(std::uint32_t id, const BodyState& last) {
  bodies.find_slots();
  BodyInfo& info = bodies.info[id];
  const Surface& surface = bodies.surface(id);
  bodies.id[info.slot] = kNoSlot;
  ++bodies.dead;
  --bodies.moving;
  count_in(surface, -1);
  if (surface.type == BodyType::kinematic_body) {
    std::erase_if(held, [id](const auto& h) { return h.first == id; });
  }
  info.place = Place::frozen;
  info.slot = static_cast<std::uint32_t>(frozen.size());
  frozen.push_back(last);
  lists_stale = true;
}

bool World::remove_body(BodyId id) {
  if (!is_valid(id)) return false;
  impl_->remove(id.index);
  return true;
}

bool World::is_valid(BodyId id) const {
  const BodyStore& b = impl_->bodies;
  return id.index < b.id_count && b.info[id.index].place != Place::none &&
         b.info[id.index].generation == id.generation;
}

BodyId World::id_of(std::uint32_t index) const {
  const BodyStore& b = impl_->bodies;
  if (index >= b.id_count || b.info[index].place == Place::none) return kNoBody;
  return {index, b.info[index].generation};
}

bool World::set_transform(BodyId id, Vec2 position, double angle) {
  Impl& w = *impl_;
  w.bodies.find_slots();
  if (!is_valid(id) || w.bodies.info[id.index].place != Place::moving) return false;
  if (!finite(position.x) || !finite(position.y) || !finite(angle)) {
    w.doubtful.push_back(id.index);
    return true;
  }
  const std::size_t i = w.bodies.info[id.index].slot;
  if (w.desc.boundary == Boundary::walls) {
    const Bounds& b = w.desc.bounds;
    position.x = std::fmin(std::fmax(position.x, b.xmin), b.xmax);
    position.y = std::fmin(std::fmax(position.y, b.ymin), b.ymax);
  }
  const LatticePoint p = w.lattice.to_lattice(position);
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
  w.lists_stale = w.forces_stale = w.placed = true;
  return true;
}

bool World::set_velocity(BodyId id, Vec2 velocity, double angular_velocity) {
  Impl& w = *impl_;
  w.bodies.find_slots();
  if (!is_valid(id) || w.bodies.info[id.index].place != Place::moving) return false;
  if (!check_motion(velocity, angular_velocity).empty()) {
    w.doubtful.push_back(id.index);
    return true;
  }
  const BodyInfo& info = w.bodies.info[id.index];
  const std::size_t i = info.slot;
  velocity = w.capped(velocity);
  if (angular_velocity != 0 && w.bodies.spin.empty()) {
    w.traits.turning = w.plan_stale = true;
    w.bodies.add_rotation();
  }
  if (!w.bodies.spin.empty()) w.bodies.spin[i] = static_cast<float>(angular_velocity) * w.bodies.radius[i];
  w.bodies.clear_rests(i);
  w.bodies.put_velocity(i, velocity);
  if (w.bodies.surface(id.index).type == BodyType::kinematic_body) {
    for (auto& [held_id, v] : w.held) {
      if (held_id == id.index) v = velocity;
    }
  }
  w.forces_stale = true;
  return true;
}

bool World::apply_impulse(BodyId id, Vec2 impulse) {
  Impl& w = *impl_;
  w.bodies.find_slots();
  if (!is_valid(id) || w.bodies.info[id.index].place != Place::moving) return false;
  const BodyInfo& info = w.bodies.info[id.index];
  const std::size_t i = info.slot;
  const double wm = static_cast<double>(w.bodies.surface(id.index).inv_mass);
  const BodyState now = w.state_of(id.index);
  Vec2 v{now.vx + wm * impulse.x, now.vy + wm * impulse.y};
  if (!finite(v.x) || !finite(v.y)) {
    w.doubtful.push_back(id.index);
    return true;
  }
  v = w.capped(v);
  w.bodies.put_velocity(i, v);
  w.forces_stale = true;
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
  const std::size_t i = info.slot;
  const Vec2 p = lattice.to_world(bodies.pos[2 * i], bodies.pos[2 * i + 1], bodies.disp[2 * i],
                                  bodies.disp[2 * i + 1]);
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
  }
  return s;
}

std::optional<BodyState> World::body(BodyId id) const {
  if (!is_valid(id)) return std::nullopt;
  return impl_->state_of(id.index);
}

}  // namespace psim
