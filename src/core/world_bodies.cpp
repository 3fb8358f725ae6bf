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
  if (!(radius >= 1e-9 && radius <= 1e9)) return {0, "radius must lie between 1e-9 and 1e9 m"};  // floats square it
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
  info.restitution = coefficient(m.restitution);
  info.friction = coefficient(m.friction);
  if (type == BodyType::dynamic_body) {
    info.mass = static_cast<float>(mass);
    info.inv_mass = static_cast<float>(1 / mass);
    info.spin_gain = fixed_rotation ? 0.0f : static_cast<float>(2 / mass);
    info.gravity_scale = static_cast<float>(gravity_scale);
  }
  return info;
}

// What a shape with corners is to the engine: hulls about its centre of mass. A kinematic body turns
// about its place, but it too is found and met by its centre, which goes round (Solver::Run::hold).
bool shape_surface(const BodyDesc& d, HullSet& hulls, Surface& surface, Make& make,
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
  make.inner = inner;
  surface = disc_surface(d.type, static_cast<double>(reach), mass, d.material, d.gravity_scale,
                         d.fixed_rotation);
  make.centre_x = static_cast<float>(hulls.mass.centre.x);
  make.centre_y = static_cast<float>(hulls.mass.centre.y);
  if (!dynamic) return true;
  const double r = static_cast<double>(surface.radius);
  const double inertia = mass * hulls.mass.inertia;
  if (!d.fixed_rotation) surface.spin_gain = static_cast<float>(r * r / inertia);
  return true;
}

}  // namespace

LatticePoint World::Impl::lattice_centre(const Make& make, Vec2 place, double angle) const {
  return lattice.to_lattice(place, arm_of(make, angle));
}

void World::Impl::count_in(const Surface& info, int sign) {
  const auto add = [sign](std::uint64_t& counter, bool yes) {
    if (yes) counter += static_cast<std::uint64_t>(static_cast<std::int64_t>(sign));
  };
  const Make& make = bodies.makes[info.make];
  const bool disc = make.hull_count == 0;
  if (sign > 0 && disc && traits.discs == 0) {
    first_mass = info.mass;
    first_surface = info;
  }
  if (sign > 0 && traits.moving == 0) first_radius = least_radius = info.radius;
  if (sign > 0) least_radius = std::fmin(least_radius, info.radius);
  add(traits.moving, true);
  add(traits.discs, disc);
  add(traits.same_mass, disc && info.mass == first_mass);
  add(traits.same_radius, info.radius == first_radius);
  add(traits.same_surface, disc && info.mass == first_mass &&
                               info.restitution == first_surface.restitution &&
                               info.friction == first_surface.friction &&
                               info.spin_gain == first_surface.spin_gain);
  add(traits.moving_bounce, info.restitution > 0);
  add(traits.moving_rough, info.friction > 0);
  add(traits.rough_discs, disc && info.friction > 0);
  add(traits.held_discs, disc && info.type == BodyType::kinematic_body);
  add(traits.kinematic, info.type == BodyType::kinematic_body);
  add(traits.odd_gravity, info.type == BodyType::dynamic_body && info.gravity_scale != 1);
  add(traits.cornered, !disc);
  add(traits.filtered, make.filter != Filter{});
  add(traits.sensors, make.sensor);
  add(traits.bullets, make.bullet);
  plan_stale = true;
}

// Velocities above the engine's cap would carry a body past the lattice: they are cut to it.
Vec2 World::Impl::capped(Vec2 v) const {
  const double speed = std::sqrt(v.x * v.x + v.y * v.y), limit = 0.999 * speed_limit(desc.dt);
  return speed > limit ? Vec2{v.x / speed * limit, v.y / speed * limit} : v;
}

// Gives a moving disc an id and a slot at the end of the columns.
std::uint32_t World::Impl::enter(const Surface& surface, const LatticePoint& p, double angle,
                                 Vec2 velocity, double omega) {
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
  bodies.roster_changed = true;
  if (angle != 0 || omega != 0) {
    traits.turning = true;
    if (bodies.spin.empty()) bodies.add_rotation();
  }
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
    bodies.spin[slot] = surface_speed(omega, surface.radius);
    bodies.angle[slot] = angle;
  }
  ++bodies.count;
  ++bodies.moving;
  sleepers.mark_moving(id);
  placed = true;
  queries.forget_moving();
  if (surface.type == BodyType::kinematic_body) held.emplace_back(id, velocity);
  if (bodies.makes[surface.make].bullet) bullets.push_back(id);
  return id;
}

BodyId World::add_body(const BodyDesc& d, std::string& error) {
  Impl& w = *impl_;
  w.settle_lists();
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

  if (d.sensor && d.type == BodyType::dynamic_body) {
    error = "a sensor is static or kinematic";
    return kNoBody;
  }
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    error = disc_mass(disc->radius, d.mass, d.material).error;
    if (!error.empty()) return kNoBody;
  }
  return d.type == BodyType::static_body ? w.add_fixed(d, error) : w.add_moving(d, error);
}

BodyId World::Impl::add_moving(const BodyDesc& d, std::string& error) {
  Make make;
  make.filter = d.filter;
  make.bullet = d.bullet;
  make.sensor = d.sensor;
  Surface surface;
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    surface = disc_surface(d.type, disc->radius, disc_mass(disc->radius, d.mass, d.material).mass,
                           d.material, d.gravity_scale, d.fixed_rotation);
  } else {
    HullSet hulls;
    if (!shape_surface(d, hulls, surface, make, error)) return kNoBody;
    make.first_hull = bodies.hulls.acquire(hulls.parts);
    make.hull_count = static_cast<std::uint32_t>(hulls.parts.size());
  }
  surface.make = bodies.makes.acquire(make) & MakeTable::kMost;
  bodies.reserve_slots(1);
  const std::uint32_t id = enter(surface, lattice_centre(make, d.position, d.angle), d.angle,
                                 d.velocity, d.angular_velocity);
  if (d.type == BodyType::kinematic_body) go_round(id, capped(d.velocity));
  count_in(surface, +1);
  spoil_lists();
  return {id, bodies.info[id].generation};
}

std::size_t World::add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error) {
  Impl& w = *impl_;
  w.settle_lists();
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
    d.filter = batch.filter;
    d.mass = batch.mass;
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
  Make make;
  make.filter = batch.filter;
  make.bullet = batch.bullet;
  for (std::size_t i = 0; i < n; ++i) {
    const double r = radius_of(i);
    const double mass = batch.mass > 0 ? batch.mass : batch.material.density * kPi * r * r;
    Surface info = disc_surface(batch.type, r, mass, batch.material, batch.gravity_scale,
                                batch.fixed_rotation);
    info.make = w.bodies.makes.acquire(make) & MakeTable::kMost;
    w.enter(info, w.lattice.to_lattice({batch.x[i], batch.y[i]}), value(batch.angle, i),
            {value(batch.vx, i), value(batch.vy, i)}, value(batch.angular_velocity, i));
    w.count_in(info, +1);
  }
  w.spoil_lists();
  return n;
}

// Takes a body out. Its slot stays as a dead one until the next sort.
void World::Impl::remove(std::uint32_t id) {
  settle_lists();
  remove_joints_of(id);
  bodies.find_slots();
  BodyInfo& info = bodies.info[id];
  rouse_around(info, id);  // a sleeping body itself wakes, too
  if (info.place == Place::fixed) {
    queries.forget_fixed();
  } else {
    queries.forget_moving();
  }
  if (events.on()) events.body_left({id, info.generation}, false);
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
    if (bodies.makes[surface.make].bullet) std::erase(bullets, id);
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
    if (bodies.makes[surface.make].sensor) --traits.sensors;
    if (bodies.makes[surface.make].filter != Filter{}) --traits.filtered;
    plan_stale = true;
  } else {
    const std::uint32_t at = info.slot;
    frozen[at] = frozen.back();
    bodies.info[frozen[at].id.index].slot = at;
    frozen.pop_back();
  }
  const Make& make = bodies.makes[surface.make];
  if (make.hull_count != 0) bodies.hulls.release(make.first_hull);
  bodies.makes.release(surface.make);
  info.place = Place::none;
  bodies.roster_changed = true;
  info.slot = kNoSlot;
  ++info.generation;
  --bodies.living;
  bodies.free_ids.push_back(id);
  spoil_lists();
}

// Out of the simulation, but still there: a body whose numbers are broken.
void World::Impl::freeze(std::uint32_t id, const BodyState& last) {
  remove_joints_of(id);
  bodies.find_slots();
  BodyInfo& info = bodies.info[id];
  rouse_around(info, id);
  const Surface& surface = bodies.surface(id);
  bodies.id[info.slot] = kNoSlot;
  ++bodies.dead;
  --bodies.moving;
  count_in(surface, -1);
  if (surface.type == BodyType::kinematic_body) {
    std::erase_if(held, [id](const auto& h) { return h.first == id; });
  }
  if (bodies.makes[surface.make].bullet) std::erase(bullets, id);
  info.place = Place::frozen;
  bodies.roster_changed = true;
  info.slot = static_cast<std::uint32_t>(frozen.size());
  frozen.push_back(last);
  queries.forget_moving();
  if (events.on()) events.body_left({id, info.generation}, true);
  spoil_lists();
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

}  // namespace psim
