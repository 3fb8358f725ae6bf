#include "bodies/population.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "base/room.h"
#include "bodies/body_desc.h"

namespace psim {
namespace {

// omega r, m/s, within what floats can square.
double rim_speed_of(double omega, float radius) {
  constexpr double kMost = 1e15;
  return lesser(greater(omega * radius, -kMost), kMost);
}

bool is_restrained(const BodyDesc& d) {
  const bool any = d.linear_damping != 0 || d.angular_damping != 0 || d.locks != Locks{};
  return any && d.type == BodyType::dynamic_body;
}

// Of a body of one part, that of the part is the body's.
std::uint64_t user_data_of(const BodyDesc& d) {
  const auto* compound = std::get_if<CompoundShape>(&d.shape);
  const bool alone = d.user_data == 0 && compound != nullptr && compound->parts.size() == 1;
  return alone ? compound->parts[0].user_data : d.user_data;
}

}  // namespace

double speed_limit(const Lattice& lattice, double dt) {
  const double pitch = lesser(lattice.pitch_x(), lattice.pitch_y());
  return lesser(kFarSteps * pitch / dt, 1e15);
}

Population::Population(const WorldDesc& desc, const Lattice& lattice, MemoryMeter& meter)
    : bodies(meter), statics(meter, lattice), desc_(desc), lattice_(lattice) {}

Vec2 Population::capped(Vec2 v) const {
  const double speed = length_of(v), limit = 0.999 * speed_limit(lattice_, desc_.dt);
  return speed > limit ? Vec2{v.x / speed * limit, v.y / speed * limit} : v;
}

void Population::let_turn() {
  bodies.keep_rotation(true);
  traits.turning = true;
}

// A body comes (+1) or goes (-1).
void Population::count(const BodyProperties& p, int sign, Traits& t) const {
  const auto add = [sign](std::uint64_t& counter, bool yes) { counter += static_cast<std::uint64_t>(yes ? sign : 0); };
  const BodyKind& kind = bodies.kinds[p.kind];
  const bool disc = kind.hull_count == 0;
  const auto any_part = [&](const auto& has) {
    for (std::uint32_t k = 0; k < std::max(1u, kind.part_count); ++k) {
      if (has(k)) return true;
    }
    return false;
  };
  const bool moves = p.type() != BodyType::static_body;
  const bool senses = any_part([&](std::uint32_t k) { return bodies.is_sensor(kind, k); });
  add(t.filtered, any_part([&](std::uint32_t k) { return bodies.filter_of(kind, k) != Filter{}; }));
  add(t.sensors, senses);
  const bool special = any_part([&](std::uint32_t k) { return bodies.part_of(p, k).is_special(); });
  add(t.special, special);
  add(t.asking, special && any_part([&](std::uint32_t k) { return bodies.asks(kind, k); }));
  add(t.moving_sensors, senses && moves);
  if (!moves) {
    add(t.fixed, true);
    add(t.fixed_bounce, p.restitution > 0);
    add(t.fixed_rough, p.friction > 0);
    return;
  }
  add(t.moving, true);
  add(t.discs, disc);
  add(t.same_mass, disc && p.mass == first_properties.mass);
  add(t.same_radius, p.radius == first_radius);
  add(t.same_properties, disc && p.mass == first_properties.mass && p.restitution == first_properties.restitution &&
                             p.friction == first_properties.friction && p.rim_gain == first_properties.rim_gain);
  add(t.moving_bounce, p.restitution > 0);
  add(t.moving_rough, p.friction > 0);
  add(t.rough_discs, disc && p.friction > 0);
  add(t.kinematic_discs, disc && p.type() == BodyType::kinematic_body);
  add(t.kinematic, p.type() == BodyType::kinematic_body);
  add(t.odd_gravity, p.type() == BodyType::dynamic_body && p.gravity_scale != 1);
  add(t.cornered, !disc);
  add(t.bullets, kind.bullet);
  add(t.restrained, kind.restrained);
}

Traits Population::recounted() const {
  Traits t = traits;
  static_cast<BodyCounts&>(t) = {};
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) {
    const Place place = bodies.info[id].place;
    if (!is_out(place)) count(bodies.properties(id), +1, t);
  }
  return t;
}

// Enters what a body has into the tables. Returns its entry in the table of properties; kNoSlot, and a line in `error`, if
// there are too many kinds.
std::uint32_t Population::acquire(NewBody& body, std::string& error) {
  BodyKind& kind = body.kind;
  kind.first_hull = kind.hull_count = kind.first_part = kind.part_count = 0;
  const auto forget_kind = [&] { forget(kind); };
  if (!body.hulls.empty()) {
    kind.first_hull = bodies.hulls.acquire(body.hulls);
    kind.hull_count = static_cast<std::uint32_t>(body.hulls.size());
  }
  if (!body.own.empty()) {
    kind.first_part = or_else(forget_kind, [&] { return bodies.parts.acquire(body.own); });
    kind.part_count = static_cast<std::uint32_t>(body.own.size());
  }
  const std::uint32_t entry = or_else(forget_kind, [&] { return bodies.kinds.acquire(kind); });
  if (entry > kMostKinds) {
    forget_kind();
    error = "too many kinds of body: at most 16,777,215";
    return kNoSlot;
  }
  body.properties.kind = entry & kMostKinds;
  const auto forget_entry = [&] {
    bodies.kinds.release(entry);
    forget_kind();
  };
  return or_else(forget_entry, [&] { return bodies.property_table.acquire(body.properties); });
}

// The reverse of acquire().
void Population::release(std::uint32_t row) {
  const std::uint32_t entry = bodies.property_table[row].kind;
  forget(bodies.kinds[entry]);
  bodies.kinds.release(entry);
  bodies.property_table.release(row);
}

// Makes the properties and the pieces of a body. What has no room, has none here.
std::optional<Population::Newcomer> Population::describe(const BodyDesc& d, std::string& error) {
  const bool moves = d.type != BodyType::static_body;
  Newcomer made;
  NewBody body;
  BodyKind& kind = body.kind;
  kind.bullet = moves && d.bullet;
  kind.sleepless = d.type == BodyType::dynamic_body && !d.can_sleep;
  kind.restrained = is_restrained(d);
  if (kind.restrained) kind.locks = d.locks;
  if (!(moves ? make_moving(d, body, error) : make_static(d, lattice_, body, made.pieces, error))) return std::nullopt;
  reserve(d, made.pieces.size());
  if (user_data_of(d) != 0) user_values.make_room();
  if (!d.enabled) make_room_to_disable();
  made.row = acquire(body, error);
  if (made.row == kNoSlot) return std::nullopt;
  return made;
}

// A body with an id takes its place.
void Population::enter(std::uint32_t id, const BodyDesc& d, Newcomer& newcomer) {
  const bool moves = d.type != BodyType::static_body;
  bodies.info[id].properties = newcomer.row;
  if (moves) {
    BodyState at = bare_state(id);
    at.x = d.position.x, at.y = d.position.y, at.angle = d.angle;
    at.vx = d.velocity.x, at.vy = d.velocity.y, at.omega = d.angular_velocity;
    enter_columns({at, coefficient(d.linear_damping), coefficient(d.angular_damping)});
  } else {
    enter_statics(id, d, newcomer.pieces);
  }
  count(bodies.properties(id), +1, traits);
  put_user_data(id, user_data_of(d));
  if (!d.enabled) {
    disable(id);
    BodyState& last = disabled.back().last;  // as it was given, not as the columns round it
    last.x = d.position.x, last.y = d.position.y, last.angle = d.angle;
    if (moves) last.vx = d.velocity.x, last.vy = d.velocity.y, last.omega = d.angular_velocity;
  }
}

// There is room for it.
void Population::put_user_data(std::uint32_t id, std::uint64_t value) {
  if (user_values.has(id)) user_values.remove(id);
  if (value != 0) user_values.add({id, value});
}

BodyId Population::add(const BodyDesc& d, std::string& error) {
  std::optional<Newcomer> made = describe(d, error);
  if (!made) return kNoBody;
  const std::uint32_t id = bodies.take_id();
  enter(id, d, *made);
  return {id, bodies.info[id].generation};
}

// Gives back what a kind of body names.
void Population::forget(const BodyKind& kind) {
  if (kind.hull_count != 0) bodies.hulls.release(kind.first_hull);
  if (kind.first_part != 0) bodies.parts.release(kind.first_part);
}

// Room for one body more, of so many pieces if it does not move.
void Population::reserve(const BodyDesc& d, std::size_t pieces) {
  bodies.info.reserve(std::size_t{bodies.id_count} + 1);
  if (d.type == BodyType::static_body) {
    fixed.reserve(roomier(fixed));
    statics.reserve(pieces);
    return;
  }
  bodies.reserve_slots(1);
  if (traits.fields) bodies.keep_remainders(true, desc_.integrator != Integrator::verlet);
  if (d.angle != 0 || d.angular_velocity != 0) let_turn();
  // In open worlds steps remove bodies and give their ids back, which must not allocate.
  if (desc_.boundary == Boundary::open) bodies.free_ids.reserve(bodies.info.capacity());
  if (d.type == BodyType::kinematic_body) kinematics.make_room();
  if (d.bullet) bullets.make_room();
  if (is_restrained(d)) restraints.make_room();
}

void Population::make_room(std::size_t count, bool fixed) {
  bodies.info.reserve(bodies.id_count + count);
  if (!fixed) return bodies.reserve_slots(count);
  this->fixed.reserve(this->fixed.size() + count);
  statics.reserve(count);
}

void Population::enter_statics(std::uint32_t id, const BodyDesc& d, std::vector<Piece>& pieces) {
  bodies.info[id].place = Place::fixed;
  bodies.info[id].slot = static_cast<std::uint32_t>(fixed.size());
  for (Piece& piece : pieces) piece.shape.owner = id;
  fixed.push_back({d.position.x, d.position.y, d.angle, bodies.properties(id).radius, id, statics.add(pieces)});
}

void Population::enter_columns(const DisabledBody& as) {
  const BodyState& at = as.last;
  const std::uint32_t id = at.id.index;
  const BodyProperties& properties = bodies.properties(id);
  const BodyKind& kind = bodies.kind(id);
  bodies.find_slots();
  const std::uint32_t slot = bodies.enter(id, lattice_.to_lattice({at.x, at.y}, arm_of(kind, at.angle)), at.angle);
  bodies.put_rim_speed(slot, rim_speed_of(at.omega, properties.radius));
  const Vec2 velocity = capped({at.vx, at.vy});
  bodies.put_velocity(slot, velocity);
  if (properties.type() == BodyType::kinematic_body) {
    kinematics.add({id, velocity});
    go_round(id, velocity);
  }
  if (kind.bullet) bullets.add({id});
  if (kind.restrained) restraints.add({id, as.linear_damping, as.angular_damping, kind.locks});
  if (traits.moving == 0) first_radius = least_radius = properties.radius;
  if (traits.discs == 0 && kind.hull_count == 0) first_properties = properties;
  least_radius = lesser(properties.radius, least_radius);
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
  bodies.leave(bodies.info[id].slot);
  leave_lists(id);
}

// Neither is it counted or in the lists of what few bodies have.
void Population::leave_lists(std::uint32_t id) {
  const BodyProperties& properties = bodies.properties(id);
  count(properties, -1, traits);
  if (properties.type() == BodyType::kinematic_body) kinematics.remove(id);
  if (bodies.kinds[properties.kind].bullet) bullets.remove(id);
  if (bodies.kinds[properties.kind].restrained) restraints.remove(id);
  if (applied.has(id)) applied.remove(id);
}

void Population::make_room_to_leave(std::size_t n, bool fixed) {
  const std::size_t free = bodies.free_ids.size() + n;
  if (free > bodies.free_ids.capacity()) bodies.free_ids.reserve(2 * free);
  statics.make_room_to_leave(fixed ? n : 0, fixed);
}

void Population::lose_all() {
  bodies.count = bodies.dead = bodies.id_count = bodies.retired = 0;
  bodies.free_ids.clear();
  statics.lose_all();
  fixed.clear();
  frozen.clear();
  disabled.clear();
  user_values.clear();
  kinematics.clear();
  bullets.clear();
  restraints.clear();
  applied.clear();
  traits = {};
}

void Population::remove(std::uint32_t id) {
  BodyInfo& info = bodies.info[id];
  const bool hidden = info.place == Place::disabled && disabled[info.slot].pieces != 0;
  make_room_to_leave(1, info.place == Place::fixed || hidden);
  if (info.place == Place::moving) {
    leave_columns(id);
  } else if (info.place == Place::asleep) {
    leave_lists(id);
  } else if (info.place == Place::fixed) {
    statics.remove(fixed[info.slot].first_shape, id);
    leave_list(fixed, id);
    count(bodies.properties(id), -1, traits);
  } else if (info.place == Place::disabled) {
    statics.remove_hidden(disabled[info.slot].first_shape, disabled[info.slot].pieces);
    leave_list(disabled, id);
  } else {
    leave_list(frozen, id);
  }
  release(info.properties);
  if (user_values.has(id)) user_values.remove(id);
  info.place = Place::none;
  info.slot = kNoSlot;
  if (++info.generation != kLastGeneration) {
    bodies.free_ids.push_back(id);
  } else {
    ++bodies.retired;
  }
}

Vec2 Population::within_walls(Vec2 position) const {
  if (desc_.boundary != Boundary::walls) return position;
  const Bounds& b = desc_.bounds;
  return {lesser(greater(position.x, b.xmin), b.xmax), lesser(greater(position.y, b.ymin), b.ymax)};
}

void Population::place(std::uint32_t id, Vec2 position, double angle) {
  const std::size_t i = bodies.info[id].slot;
  position = within_walls(position);
  bodies.put_point(i, lattice_.to_lattice(position, arm_of(bodies.kind(id), angle)));
  if (!bodies.angle.empty()) bodies.angle[i] = angle;
  bodies.clear_remainders(i);
}

void Population::set_velocity(std::uint32_t id, Vec2 velocity, double angular_velocity) {
  const std::size_t i = bodies.info[id].slot;
  velocity = capped(velocity);
  bodies.put_rim_speed(i, rim_speed_of(angular_velocity, bodies.radius[i]));
  bodies.clear_remainders(i);
  bodies.put_velocity(i, velocity);
  if (bodies.properties(id).type() != BodyType::kinematic_body) return;
  kinematics.at(id).velocity = velocity;
  go_round(id, velocity);
}

BodyState Population::bare_state(std::uint32_t id) const {
  const BodyProperties& properties = bodies.properties(id);
  BodyState s;
  s.id = {id, bodies.info[id].generation};
  s.radius = properties.radius;
  s.type = properties.type();
  return s;
}

BodyState Population::state_of(std::uint32_t id) const {
  bodies.find_slots();
  const std::size_t i = bodies.info[id].slot;
  if (bodies.info[id].place == Place::frozen) return frozen[i];
  if (bodies.info[id].place == Place::disabled) return disabled[i].last;
  BodyState s = bare_state(id);
  if (bodies.info[id].place == Place::fixed) {
    s.x = fixed[i].x, s.y = fixed[i].y;
    s.angle = fixed[i].angle;
    return s;
  }
  s.angle = bodies.angle_of(i);
  s.omega = bodies.omega_of(i);
  const auto with = [i](Vec2 of, const Column<float>& remainder) {
    return remainder.empty() ? of : of + Vec2{remainder[2 * i], remainder[2 * i + 1]};
  };
  const Vec2 arm = arm_of(bodies.kind(id), s.angle), centre = lattice_.to_world(bodies.point(i));
  const Vec2 p = with(arm.x != 0 || arm.y != 0 ? centre - arm : centre, bodies.disp_remainder);
  Vec2 v = with(bodies.velocity(i), bodies.vel_remainder);
  if (s.type == BodyType::kinematic_body && !bodies.rim_speed.empty()) {  // of its place, not of its centre
    v = {v.x + s.omega * arm.y, v.y - s.omega * arm.x};
  }
  s.x = p.x, s.y = p.y;
  s.vx = v.x, s.vy = v.y;
  return s;
}

}  // namespace psim
