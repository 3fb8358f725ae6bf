#include "bodies/population.h"

#include <cmath>

#include "bodies/body_desc.h"
#include "bodies/hull.h"
#include "bodies/static_pieces.h"

namespace psim {
namespace {

// One line that says what is wrong with the points of a line, or nothing.
std::string check_line(const std::vector<Vec2>& points, bool loop) {
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!finite(points[k])) return "segment points must be finite";
    if (k + 1 == points.size() && !loop) break;
    const Vec2 next = points[(k + 1) % points.size()];
    if (points[k].x == next.x && points[k].y == next.y) return "segment points must differ";
  }
  return {};
}

std::string cut_chain(const ChainShape& chain, Pieces& pieces) {
  const std::size_t n = chain.vertices.size();
  if (n < (chain.loop ? 3u : 2u)) {
    return chain.loop ? "a chain loop needs at least 3 vertices" : "a chain needs at least 2 vertices";
  }
  for (std::size_t k = 0; k + 1 < n; ++k) pieces.segment(chain.vertices[k], chain.vertices[k + 1], 0, false);
  if (chain.loop) pieces.segment(chain.vertices[n - 1], chain.vertices[0], 0, false);
  return check_line(chain.vertices, chain.loop);
}

// Makes the pieces of a static body. One line that says what is wrong with its shape, or nothing.
std::string cut_into_pieces(const BodyDesc& d, Pieces& pieces) {
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    pieces.disc({}, static_cast<float>(disc->radius));
    return {};
  }
  if (const auto* line = std::get_if<SegmentShape>(&d.shape)) return cut_chain({{line->p1, line->p2}, false}, pieces);
  if (const auto* chain = std::get_if<ChainShape>(&d.shape)) return cut_chain(*chain, pieces);
  HullSet hulls;
  std::string error;
  if (make_hulls(d.shape, false, hulls, error)) {
    for (const Hull& hull : hulls.parts) pieces.solid(hull);
  }
  return error;
}

}  // namespace

double speed_limit(const Lattice& lattice, double dt) {
  const double pitch = std::fmin(lattice.pitch_x(), lattice.pitch_y());
  return std::fmin(kFarSteps * pitch / dt, 1e15);
}

Population::Population(const WorldDesc& desc, const Lattice& lattice, MemoryMeter& meter)
    : bodies(meter), statics(meter, lattice), desc_(desc), lattice_(lattice) {}

Vec2 Population::capped(Vec2 v) const {
  const double speed = length_of(v), limit = 0.999 * speed_limit(lattice_, desc_.dt);
  return speed > limit ? Vec2{v.x / speed * limit, v.y / speed * limit} : v;
}

void Population::let_turn() {
  traits.turning = true;
  if (bodies.rim_speed.empty()) bodies.add_rotation();
}

void Population::count(const BodyProperties& p, int sign) {
  const bool disc = bodies.kinds[p.kind].hull_count == 0;
  if (sign > 0 && disc && traits.discs == 0) {
    first_mass = p.mass;
    first_properties = p;
  }
  if (sign > 0 && traits.moving == 0) first_radius = least_radius = p.radius;
  if (sign > 0) least_radius = std::fmin(least_radius, p.radius);
  count_alike(p, sign, traits);
}

// So many equal bodies come or go.
void Population::count_alike(const BodyProperties& p, std::int64_t n, Traits& t) const {
  const auto add = [n](std::uint64_t& counter, bool yes) {
    if (yes) counter += static_cast<std::uint64_t>(n);
  };
  const BodyKind& kind = bodies.kinds[p.kind];
  const bool disc = kind.hull_count == 0;
  add(t.filtered, kind.filter != Filter{});
  add(t.sensors, kind.sensor);
  if (p.type == BodyType::static_body) {
    add(t.fixed, true);
    add(t.fixed_bounce, p.restitution > 0);
    add(t.fixed_rough, p.friction > 0);
    return;
  }
  add(t.moving, true);
  add(t.discs, disc);
  add(t.same_mass, disc && p.mass == first_mass);
  add(t.same_radius, p.radius == first_radius);
  add(t.same_properties, disc && p.mass == first_mass && p.restitution == first_properties.restitution &&
                             p.friction == first_properties.friction && p.rim_gain == first_properties.rim_gain);
  add(t.moving_bounce, p.restitution > 0);
  add(t.moving_rough, p.friction > 0);
  add(t.rough_discs, disc && p.friction > 0);
  add(t.kinematic_discs, disc && p.type == BodyType::kinematic_body);
  add(t.kinematic, p.type == BodyType::kinematic_body);
  add(t.odd_gravity, p.type == BodyType::dynamic_body && p.gravity_scale != 1);
  add(t.cornered, !disc);
  add(t.bullets, kind.bullet);
}

Traits Population::recounted() const {
  Traits t = traits;
  static_cast<BodyCounts&>(t) = {};
  std::vector<std::int64_t> alike(bodies.property_table.size());
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) {
    const BodyInfo& info = bodies.info[id];
    if (info.place != Place::none && info.place != Place::frozen) ++alike[info.properties];
  }
  for (std::uint32_t k = 0; k < alike.size(); ++k) {
    if (alike[k] != 0) count_alike(bodies.property_table[k], alike[k], t);
  }
  return t;
}

BodyId Population::add(const BodyDesc& d, std::string& error) {
  return d.type == BodyType::static_body ? add_fixed(d, error) : add_moving(d, error);
}

BodyId Population::add_moving(const BodyDesc& d, std::string& error) {
  BodyKind kind;
  kind.filter = d.filter;
  kind.bullet = d.bullet;
  kind.sensor = d.sensor;
  BodyProperties properties;
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    properties = disc_properties(d.type, disc->radius, disc_mass(disc->radius, d.mass, d.material), d.material,
                                 d.gravity_scale, d.fixed_rotation);
  } else {
    HullSet hulls;
    if (!shape_properties(d, hulls, properties, kind, error)) return kNoBody;
    kind.first_hull = bodies.hulls.acquire(hulls.parts);
    kind.hull_count = static_cast<std::uint32_t>(hulls.parts.size());
  }
  properties.kind = bodies.kinds.acquire(kind) & kMostKinds;
  bodies.reserve_slots(1);
  const LatticePoint centre = lattice_.to_lattice(d.position, arm_of(kind, d.angle));
  const std::uint32_t id = enter(properties, centre, d.angle, d.velocity, d.angular_velocity);
  if (d.type == BodyType::kinematic_body) go_round(id, capped(d.velocity));
  count(properties, +1);
  return {id, bodies.info[id].generation};
}

BodyId Population::add_fixed(const BodyDesc& d, std::string& error) {
  std::vector<Piece> list;
  Pieces pieces(d.position, d.angle, lattice_, list);
  error = cut_into_pieces(d, pieces);
  if (!error.empty()) return kNoBody;
  BodyKind kind;
  kind.filter = d.filter;
  kind.sensor = d.sensor;
  if (d.sensor) {  // a sensor stops nothing: only queries and events know it
    HullSet hulls;
    if (!make_hulls(d.shape, false, hulls, error)) return kNoBody;
    kind.first_hull = bodies.hulls.acquire(hulls.parts);
    kind.hull_count = static_cast<std::uint32_t>(hulls.parts.size());
    list.clear();
  }
  const std::uint32_t entry = bodies.kinds.acquire(kind);
  if (entry > kMostKinds) {
    error = "too many kinds of body: at most 16,777,215";
    return kNoBody;
  }
  const auto* disc = std::get_if<DiscShape>(&d.shape);
  const double radius = disc != nullptr ? disc->radius : 0;
  BodyProperties properties = disc_properties(BodyType::static_body, radius, 0, d.material, 1, false);
  properties.kind = entry & kMostKinds;

  const std::uint32_t id = bodies.take_id();
  BodyInfo& info = bodies.info[id];
  info.properties = bodies.property_table.acquire(properties);
  info.place = Place::fixed;
  info.slot = static_cast<std::uint32_t>(fixed.size());
  fixed.push_back(
      {d.position.x, d.position.y, d.angle, properties.radius, id, static_cast<std::uint32_t>(statics.size())});
  for (Piece& piece : list) {
    piece.shape.owner = id;
    piece.shape.restitution = properties.restitution;
    piece.shape.friction = properties.friction;
    statics.add(piece.shape, piece.shape.whole ? &piece.hull : nullptr);
  }
  ++bodies.fixed;
  count_alike(properties, +1, traits);
  return {id, info.generation};
}

void Population::make_room(const DiscBatch& batch) {
  bodies.reserve_slots(batch.x.size());
  bodies.info.reserve(bodies.id_count + batch.x.size());
}

BodyId Population::add_disc(const DiscBatch& batch, std::size_t i) {
  BodyKind kind;
  kind.filter = batch.filter;
  kind.bullet = batch.bullet;
  const double r = batch.radius[batch.radius.size() == 1 ? 0 : i];
  BodyProperties properties = disc_properties(batch.type, r, disc_mass(r, batch.mass, batch.material), batch.material,
                                              batch.gravity_scale, batch.fixed_rotation);
  properties.kind = bodies.kinds.acquire(kind) & kMostKinds;
  const std::uint32_t id =
      enter(properties, lattice_.to_lattice({batch.x[i], batch.y[i]}), value_or_zero(batch.angle, i),
            {value_or_zero(batch.vx, i), value_or_zero(batch.vy, i)}, value_or_zero(batch.angular_velocity, i));
  count(properties, +1);
  return {id, bodies.info[id].generation};
}

// Gives a moving body an id, and a slot at the end of the columns.
std::uint32_t Population::enter(const BodyProperties& properties, const LatticePoint& p, double angle, Vec2 velocity,
                                double omega) {
  velocity = capped(velocity);
  bodies.find_slots();
  const std::uint32_t id = bodies.take_id();
  // In open worlds steps remove bodies and give their ids back, which must not allocate.
  if (desc_.boundary == Boundary::open) bodies.free_ids.reserve(bodies.info.capacity());
  const std::size_t slot = bodies.count;
  BodyInfo& info = bodies.info[id];
  info.slot = bodies.count;
  info.properties = bodies.property_table.acquire(properties);
  info.place = Place::moving;
  if (angle != 0 || omega != 0) let_turn();
  bodies.put_point(slot, p);
  bodies.id[slot] = id;
  bodies.radius[slot] = properties.radius;
  bodies.linked[slot] = 0;
  if (traits.fields) bodies.add_remainders(desc_.integrator != Integrator::verlet);
  bodies.clear_remainders(slot);
  bodies.put_velocity(slot, velocity);
  if (!bodies.rim_speed.empty()) {
    bodies.rim_speed[slot] = rim_speed_of(omega, properties.radius);
    bodies.angle[slot] = angle;
  }
  ++bodies.count;
  ++bodies.moving;
  if (properties.type == BodyType::kinematic_body) kinematics.emplace_back(id, velocity);
  if (bodies.kinds[properties.kind].bullet) bullets.push_back(id);
  return id;
}

// The centre of a kinematic body that turns about another place has a velocity of its own.
void Population::go_round(std::uint32_t id, Vec2 velocity) {
  const BodyKind& kind = bodies.kind(id);
  if (kind.centre_x == 0 && kind.centre_y == 0) return;
  const std::size_t i = bodies.info[id].slot;
  const Vec2 arm = arm_of(kind, bodies.angle_of(i));
  const double omega = bodies.omega_of(i);
  bodies.put_velocity(i, {velocity.x - omega * arm.y, velocity.y + omega * arm.x});
}

// A body is not among the moving ones any more.
void Population::leave_columns(std::uint32_t id) {
  const BodyProperties& properties = bodies.properties(id);
  bodies.id[bodies.info[id].slot] = kNoSlot;
  ++bodies.dead;
  --bodies.moving;
  count(properties, -1);
  if (properties.type == BodyType::kinematic_body) {
    std::erase_if(kinematics, [id](const auto& k) { return k.first == id; });
  }
  if (bodies.kinds[properties.kind].bullet) std::erase(bullets, id);
}

void Population::remove_fixed(std::uint32_t id) {
  const std::uint32_t at = bodies.info[id].slot;
  statics.remove(fixed[at].first_shape, id);
  fixed[at] = fixed.back();
  bodies.info[fixed[at].id].slot = at;
  fixed.pop_back();
  --bodies.fixed;
  count_alike(bodies.properties(id), -1, traits);
}

void Population::remove(std::uint32_t id) {
  BodyInfo& info = bodies.info[id];
  if (info.place == Place::moving) {
    leave_columns(id);
  } else if (info.place == Place::fixed) {
    remove_fixed(id);
  } else {
    const std::uint32_t at = info.slot;
    frozen[at] = frozen.back();
    bodies.info[frozen[at].id.index].slot = at;
    frozen.pop_back();
  }
  const std::uint32_t kind = bodies.properties(id).kind;
  bodies.property_table.release(info.properties);
  if (bodies.kinds[kind].hull_count != 0) bodies.hulls.release(bodies.kinds[kind].first_hull);
  bodies.kinds.release(kind);
  info.place = Place::none;
  info.slot = kNoSlot;
  ++info.generation;
  --bodies.living;
  bodies.free_ids.push_back(id);
}

void Population::freeze(std::uint32_t id, const BodyState& last) {
  leave_columns(id);
  BodyInfo& info = bodies.info[id];
  info.place = Place::frozen;
  info.slot = static_cast<std::uint32_t>(frozen.size());
  frozen.push_back(last);
}

void Population::place(std::uint32_t id, Vec2 position, double angle) {
  const std::size_t i = bodies.info[id].slot;
  if (desc_.boundary == Boundary::walls) {
    const Bounds& b = desc_.bounds;
    position.x = std::fmin(std::fmax(position.x, b.xmin), b.xmax);
    position.y = std::fmin(std::fmax(position.y, b.ymin), b.ymax);
  }
  bodies.put_point(i, lattice_.to_lattice(position, arm_of(bodies.kind(id), angle)));
  if (!bodies.angle.empty()) bodies.angle[i] = angle;
  bodies.clear_remainders(i);
}

void Population::set_velocity(std::uint32_t id, Vec2 velocity, double angular_velocity) {
  const std::size_t i = bodies.info[id].slot;
  velocity = capped(velocity);
  if (!bodies.rim_speed.empty()) bodies.rim_speed[i] = rim_speed_of(angular_velocity, bodies.radius[i]);
  bodies.clear_remainders(i);
  bodies.put_velocity(i, velocity);
  if (bodies.properties(id).type != BodyType::kinematic_body) return;
  for (auto& [kinematic, v] : kinematics) {
    if (kinematic == id) v = velocity;
  }
  go_round(id, velocity);
}

BodyState Population::state_of(std::uint32_t id) const {
  bodies.find_slots();
  const BodyInfo& info = bodies.info[id];
  if (info.place == Place::frozen) return frozen[info.slot];
  BodyState s;
  s.id = {id, info.generation};
  s.radius = static_cast<double>(bodies.properties(id).radius);
  s.type = bodies.properties(id).type;
  if (info.place == Place::fixed) {
    s.x = fixed[info.slot].x;
    s.y = fixed[info.slot].y;
    s.angle = fixed[info.slot].angle;
    return s;
  }
  const std::size_t i = info.slot;
  const Vec2 arm = arm_of(bodies.kind(id), bodies.angle_of(i));
  Vec2 p = lattice_.to_world(bodies.point(i)), v = bodies.velocity(i);
  if (arm.x != 0 || arm.y != 0) p = p - arm;
  const auto with = [i](Vec2 of, const Column<float>& remainder) {
    if (remainder.empty()) return of;
    return of + Vec2{static_cast<double>(remainder[2 * i]), static_cast<double>(remainder[2 * i + 1])};
  };
  p = with(p, bodies.disp_remainder);
  v = with(v, bodies.vel_remainder);
  s.angle = bodies.angle_of(i);
  s.omega = bodies.omega_of(i);
  if (s.type == BodyType::kinematic_body && !bodies.rim_speed.empty()) {  // of its place, not of its centre
    v = {v.x + s.omega * arm.y, v.y - s.omega * arm.x};
  }
  s.x = p.x, s.y = p.y;
  s.vx = v.x, s.vy = v.y;
  return s;
}

}  // namespace psim
