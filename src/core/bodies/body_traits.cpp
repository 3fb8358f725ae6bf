// Population: what the host reads and changes of a body while the world runs. A body gets another entry in the table of
// properties, and nothing else of it changes: its place, its motion and its contacts stay.
#include <algorithm>
#include <functional>
#include <utility>

#include "bodies/population.h"

namespace psim {
namespace {

// What all parts of a body have; of parts that differ, what the body has.
PartProperties common_of(const BodyStore& b, const BodyProperties& body) {
  const BodyKind& kind = b.kinds[body.kind];
  PartProperties first = b.part_of(body, 0);
  // The table lists the parts of a static body first, and then those that are sensors a second time, for their hulls.
  const bool again = body.type() == BodyType::static_body && kind.first_part != 0;
  for (std::uint32_t k = 1; k < kind.part_count - (again ? kind.hull_count : 0); ++k) {
    if (b.part_of(body, k) == first) continue;
    return {{body.restitution, body.friction, 0, 0}, kind.filter, static_cast<std::uint16_t>(kind.sensor)};
  }
  return first;
}

// Whether a body that moves is a disc about its place.
bool is_disc(const NewBody& body) {
  if (body.hulls.empty()) return true;
  return body.hulls.size() == 1 && body.hulls[0].count == 1 && body.kind.centre_x == 0 && body.kind.centre_y == 0;
}

double inertia_of(const BodyProperties& of, const BodyKind& kind) {
  const double gain = of.rim_gain > 0 ? of.rim_gain : kind.locked_gain, r = of.radius;
  return gain > 0 ? r * r / gain : 0;
}

}  // namespace

BodyTraits Population::traits_of(std::uint32_t id) const {
  const BodyProperties& of = bodies.properties(id);
  const BodyKind& kind = bodies.kinds[of.kind];
  PartProperties common = common_of(bodies, of);
  if (of.type() == BodyType::static_body) turn_one_way({&common, 1}, -state_of(id).angle);
  BodyTraits t;
  t.filter = common.filter;
  t.restitution = common.surface.restitution;
  t.friction = common.surface.friction;
  t.tangent_speed = common.surface.tangent_speed;
  t.rolling_resistance = common.surface.rolling_resistance;
  t.one_way = {common.one_way_x, common.one_way_y};
  t.sensor = common.sensor != 0;
  t.pre_solve = common.pre_solve != 0;
  t.bullet = kind.bullet;
  t.can_sleep = !kind.sleepless;
  if (of.type() != BodyType::dynamic_body) return t;
  t.mass = of.mass;
  t.inertia = inertia_of(of, kind);
  t.gravity_scale = of.gravity_scale;
  t.locks = kind.locks;
  if (!kind.restrained || bodies.info[id].place == Place::frozen) return t;
  if (bodies.info[id].place == Place::disabled) {
    t.linear_damping = disabled[bodies.info[id].slot].linear_damping;
    t.angular_damping = disabled[bodies.info[id].slot].angular_damping;
  } else {
    t.linear_damping = restraints.at(id).linear_damping;
    t.angular_damping = restraints.at(id).angular_damping;
  }
  return t;
}

// Of a body whose parts do not differ, the table does not say how many there are. Hulls of static bodies are those of
// sensors, which stand behind the parts of the pieces.
std::uint32_t Population::part_count(std::uint32_t id) const {
  const BodyKind& kind = bodies.kind(id);
  if (kind.first_part != 0) return kind.part_count;
  const BodyInfo& info = bodies.info[id];
  if (bodies.properties(id).type() != BodyType::static_body) return std::max(1u, kind.hull_count);
  const std::uint32_t first =
      info.place == Place::fixed ? fixed[info.slot].first_shape : disabled[info.slot].first_shape;
  return statics.parts_from(first, id) + kind.hull_count;
}

// What the parts of a body have once those of its traits changed that differ. Nothing, if all have what the body has.
std::vector<PartProperties> Population::changed_parts(std::uint32_t id, const BodyTraits& from,
                                                      const BodyTraits& to) const {
  const BodyProperties& of = bodies.properties(id);
  const std::uint32_t count = part_count(id);
  std::vector<PartProperties> parts;
  const BodyDesc desc{.material = {1, to.restitution, to.friction, to.tangent_speed, to.rolling_resistance},
                      .sensor = to.sensor,
                      .filter = to.filter,
                      .one_way = to.one_way,
                      .pre_solve = to.pre_solve};
  PartProperties wanted = part_properties({}, desc);
  if (of.type() == BodyType::static_body) turn_one_way({&wanted, 1}, state_of(id).angle);
  for (std::uint32_t k = 0; k < count; ++k) {
    PartProperties p = bodies.part_of(of, k);
    const auto change = [](bool differs, auto& value, const auto& by) {
      if (differs) value = by;
    };
    change(to.filter != from.filter, p.filter, wanted.filter);
    change(to.restitution != from.restitution, p.surface.restitution, wanted.surface.restitution);
    change(to.friction != from.friction, p.surface.friction, wanted.surface.friction);
    change(to.tangent_speed != from.tangent_speed, p.surface.tangent_speed, wanted.surface.tangent_speed);
    change(to.rolling_resistance != from.rolling_resistance, p.surface.rolling_resistance,
           wanted.surface.rolling_resistance);
    change(to.one_way.x != from.one_way.x || to.one_way.y != from.one_way.y, p.one_way_x, wanted.one_way_x);
    change(to.one_way.x != from.one_way.x || to.one_way.y != from.one_way.y, p.one_way_y, wanted.one_way_y);
    change(to.sensor != from.sensor, p.sensor, wanted.sensor);
    change(to.pre_solve != from.pre_solve, p.pre_solve, wanted.pre_solve);
    parts.push_back(p);
  }
  return parts;
}

void Population::recount_if_changed() {
  if (!std::exchange(traits_changed, false)) return;
  for (std::uint32_t id = 0; id < bodies.id_count; ++id) {
    const Place place = bodies.info[id].place;
    if (is_out(place) || place == Place::fixed || bodies.kind(id).hull_count != 0) continue;
    first_properties = bodies.properties(id);
    break;
  }
  traits = recounted();
}

// What a body becomes.
NewBody Population::changed_body(std::uint32_t id, const BodyTraits& from, const BodyTraits& to,
                                 std::vector<PartProperties> parts) const {
  const BodyProperties& old = bodies.properties(id);
  const BodyKind& old_kind = bodies.kinds[old.kind];
  const BodyType type = old.type();
  NewBody body{old, old_kind, {}, {}};
  for (std::uint32_t k = 0; k < old_kind.hull_count; ++k) body.hulls.push_back(bodies.hulls[old_kind.first_hull + k]);
  share_properties(std::move(parts), body);
  body.kind.bullet = to.bullet && type != BodyType::static_body;
  body.kind.sleepless = !to.can_sleep && type == BodyType::dynamic_body;
  if (type == BodyType::dynamic_body) {
    body.kind.restrained = to.linear_damping != 0 || to.angular_damping != 0 || to.locks != Locks{};
    body.kind.locks = to.locks;
    if (to.mass != from.mass) {
      body.properties.mass = static_cast<float>(to.mass);
      body.properties.inv_mass = static_cast<float>(1 / to.mass);
    }
    double inertia = to.inertia;
    if (to.mass != from.mass && to.inertia == from.inertia) inertia *= to.mass / from.mass;
    const double r = old.radius;
    const float kept = old.rim_gain > 0 ? old.rim_gain : old_kind.locked_gain;
    const float gain = inertia == from.inertia ? kept : (inertia > 0 ? static_cast<float>(r * r / inertia) : 0.0f);
    body.properties.rim_gain = to.locks.angle ? 0.0f : gain;
    body.kind.locked_gain = to.locks.angle ? gain : 0.0f;
    body.properties.gravity_scale = static_cast<float>(to.gravity_scale);
  }
  if (type != BodyType::static_body && is_disc(body)) {  // contacts of shapes alone know locks and special surfaces
    const bool shaped = to.locks.x || to.locks.y || !body.own.empty();
    body.hulls.assign(shaped ? 1 : 0, disc_hull(old.radius));
    body.kind.inner = shaped ? old.radius : 0;
  }
  return body;
}

bool Population::set_traits(std::uint32_t id, const BodyTraits& to) {
  const BodyTraits from = traits_of(id);
  if (bodies.properties(id).type() == BodyType::static_body && to.sensor != from.sensor) return false;
  return become(id, to, changed_body(id, from, to, changed_parts(id, from, to)));
}

// The hulls of static bodies are those of sensors and stand behind the parts.
std::uint32_t Population::told_parts(std::uint32_t id) const {
  const bool fixed = bodies.properties(id).type() == BodyType::static_body;
  return part_count(id) - (fixed && bodies.kind(id).first_part != 0 ? bodies.kind(id).hull_count : 0);
}

PartTraits Population::part_traits_of(std::uint32_t id, std::uint32_t part) const {
  const BodyProperties& of = bodies.properties(id);
  PartProperties has = bodies.part_of(of, part);
  if (of.type() == BodyType::static_body) turn_one_way({&has, 1}, -state_of(id).angle);
  const bool alone = told_parts(id) == 1;
  return {has.filter,
          has.surface.restitution,
          has.surface.friction,
          has.surface.tangent_speed,
          has.surface.rolling_resistance,
          {has.one_way_x, has.one_way_y},
          has.sensor != 0,
          has.pre_solve != 0,
          alone ? (user_values.has(id) ? user_values.at(id).value : 0) : has.user_data()};
}

bool Population::set_part(std::uint32_t id, std::uint32_t part, const PartTraits& to) {
  const BodyProperties& of = bodies.properties(id);
  const bool fixed = of.type() == BodyType::static_body;
  std::vector<PartProperties> parts;
  for (std::uint32_t k = 0; k < part_count(id); ++k) parts.push_back(bodies.part_of(of, k));
  PartProperties& has = parts[part];
  if (fixed && (has.sensor != 0 || to.sensor)) return false;  // its hulls would have to change, too
  const bool alone = told_parts(id) == 1;
  has = properties_of_part({1, to.restitution, to.friction, to.tangent_speed, to.rolling_resistance}, to.filter,
                           to.sensor, to.one_way, to.pre_solve);
  if (fixed) turn_one_way({&has, 1}, state_of(id).angle);
  if (!alone) has.set_user_data(to.user_data);
  const BodyTraits same = traits_of(id);
  return become(id, same, changed_body(id, same, same, std::move(parts)));
}

// A body gets what it becomes.
bool Population::become(std::uint32_t id, const BodyTraits& to, NewBody body) {
  BodyInfo& info = bodies.info[id];
  const BodyProperties old = bodies.properties(id);
  const BodyKind old_kind = bodies.kinds[old.kind];
  const BodyType type = old.type();
  const Restraint rest{id, coefficient(to.linear_damping), coefficient(to.angular_damping), body.kind.locks};
  // What has no room, has none here: nothing was changed yet.
  const bool here = info.place == Place::moving;
  if (here && body.kind.bullet) bullets.make_room();
  if (here && body.kind.restrained) restraints.make_room();
  std::string error;
  const std::uint32_t row = acquire(body, error);
  if (row == kNoSlot) return false;
  if (info.place != Place::disabled) count(old, -1, traits);
  release(info.properties);
  info.properties = row;
  if (info.place != Place::disabled) count(bodies.properties(id), +1, traits);
  traits_changed = true;
  const auto listed = [&](auto& list, bool before, bool now, const auto& entry) {
    if (!here) return;
    if (before && !now) list.remove(id);
    if (!before && now) list.add(entry);
    if (before && now) list.at(id) = entry;
  };
  listed(bullets, old_kind.bullet, body.kind.bullet, Bullet{id});
  listed(restraints, old_kind.restrained, body.kind.restrained, rest);
  if (info.place == Place::disabled) {
    disabled[info.slot].linear_damping = rest.linear_damping;
    disabled[info.slot].angular_damping = rest.angular_damping;
  }
  if (type == BodyType::static_body) {
    const BodyProperties& now = bodies.properties(id);
    const std::uint32_t first =
        info.place == Place::fixed ? fixed[info.slot].first_shape : disabled[info.slot].first_shape;
    statics.set_surface(first, id, [&](std::uint32_t part) { return bodies.part_of(now, part); });
  }
  return true;
}

}  // namespace psim
