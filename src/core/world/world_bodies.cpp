// The host adds, removes, moves and pushes bodies. The population does it; here the others are told: the lists are
// made anew, the query grids are forgotten, sleepers wake. A number that is not finite changes nothing now: the next
// step freezes the body.
#include <cmath>

#include "bodies/body_desc.h"
#include "world/world_impl.h"

namespace psim {

void World::Impl::body_came(std::uint32_t id) {
  spoil_lists();
  plan_stale = placed = true;
  if (population.bodies.info[id].place == Place::fixed) {
    observers.queries.forget(QueryIndex::kFixed);
    note_sleep(sleep.disturb_at_fixed(sleep_source(), id));
  } else {
    observers.queries.forget(QueryIndex::kMoving);
    sleep.sleepers.mark_moving(id);
  }
}

// Tells all others that a body goes out of the simulation. `same`: it keeps its id.
void World::Impl::body_goes(std::uint32_t id, bool same) {
  remove_joints_of(id);
  population.bodies.find_slots();
  note_sleep(sleep.disturb_neighbours(sleep_source(), id));  // a sleeping body itself wakes, too
  const BodyInfo& info = population.bodies.info[id];
  if (info.place == Place::fixed) {
    observers.queries.forget(QueryIndex::kFixed);
  } else {
    observers.queries.forget(QueryIndex::kMoving);
  }
  if (observers.events.on()) observers.events.body_left({id, info.generation}, same);
  if (info.place != Place::frozen) plan_stale = true;
}

void World::Impl::remove(std::uint32_t id) {
  settled();
  body_goes(id, false);
  population.remove(id);
  spoil_lists();
}

void World::Impl::freeze(const BodyState& last) {
  body_goes(last.id.index, true);
  population.freeze(last);
  spoil_lists();
}

// Bodies fell asleep or woke if `changed`. The impulses of the lists are nobody's once no body is awake.
bool World::Impl::note_sleep(bool changed) {
  if (!changed) return false;
  spoil_lists();
  observers.forget_sleep();
  if (population.bodies.count == 0) contacts.impulses_valid = false;
  return true;
}

// Whether the host may move or push a body. From now on it is awake and its slot is known.
bool World::Impl::can_move(BodyId id) {
  settled();
  population.bodies.find_slots();
  if (!population.is_valid(id)) return false;
  const Place place = population.bodies.info[id.index].place;
  if (place != Place::moving && place != Place::asleep) return false;
  disturb(id.index);
  return true;
}

// A body gets an angle or an angular velocity.
void World::Impl::let_turn() {
  if (!population.bodies.rim_speed.empty()) return;
  plan_stale = true;
  population.let_turn();
}

BodyId World::add_body(const BodyDesc& d, std::string& error) {
  Impl& w = impl_->settled();
  error = check(d, w.desc.bounds);
  if (!error.empty()) return kNoBody;
  const BodyId id = w.population.add(d, error);
  if (id != kNoBody) w.body_came(id.index);
  return id;
}

std::size_t World::add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error) {
  Impl& w = impl_->settled();
  error = check(batch, w.desc.bounds);
  if (!error.empty()) return 0;
  const std::size_t n = batch.x.size();
  first = w.population.next_id();
  if (batch.type == BodyType::static_body) {
    w.population.fixed.reserve(w.population.fixed.size() + n);
    for (std::size_t i = 0; i < n; ++i) add_body(disc_of(batch, i), error);
    return n;
  }
  w.population.make_room(n);
  for (std::size_t i = 0; i < n; ++i) {
    const BodyId id = w.population.add(disc_of(batch, i), error);
    if (id == kNoBody) return i;  // none: all discs are of one kind
    w.sleep.sleepers.mark_moving(id.index);
  }
  if (n != 0) w.plan_stale = w.placed = true;
  w.observers.queries.forget(QueryIndex::kMoving);
  w.spoil_lists();
  return n;
}

bool World::remove_body(BodyId id) {
  if (!is_valid(id)) return false;
  impl_->remove(id.index);
  return true;
}

bool World::is_valid(BodyId id) const { return impl_->population.is_valid(id); }

BodyId World::id_of(std::uint32_t index) const {
  const BodyStore& b = impl_->population.bodies;
  if (index >= b.id_count || b.info[index].place == Place::none) return kNoBody;
  return {index, b.info[index].generation};
}

std::optional<BodyState> World::body(BodyId id) const {
  if (!is_valid(id)) return std::nullopt;
  return impl_->state_of(id.index);
}

bool World::set_transform(BodyId id, Vec2 position, double angle) {
  Impl& w = *impl_;
  if (!w.can_move(id)) return false;
  if (!finite(position.x) || !finite(position.y) || !finite(angle)) {
    w.quarantine.doubtful.push_back(id);
    return true;
  }
  w.note_sleep(w.sleep.disturb_neighbours(w.sleep_source(), id.index));  // what leaned on it where it was
  if (angle != 0) w.let_turn();
  w.population.place(id.index, position, angle);
  w.spoil_lists();
  w.dynamics.forces_stale = w.placed = true;
  w.observers.queries.forget(QueryIndex::kMoving);
  return true;
}

bool World::set_velocity(BodyId id, Vec2 velocity, double angular_velocity) {
  Impl& w = *impl_;
  if (!w.can_move(id)) return false;
  if (!finite(velocity.x) || !finite(velocity.y) || !finite(angular_velocity)) {
    w.quarantine.doubtful.push_back(id);
    return true;
  }
  const Motion before = w.population.motion_of(w.population.bodies.info[id.index].slot);
  if (angular_velocity != 0) w.let_turn();
  w.population.set_velocity(id.index, velocity, angular_velocity);
  w.step_work.pushed(w.context(), id.index, before);
  w.dynamics.forces_stale = true;
  return true;
}

bool World::apply_impulse(BodyId id, Vec2 impulse) {
  Impl& w = *impl_;
  if (!w.can_move(id)) return false;
  const std::size_t i = w.population.bodies.info[id.index].slot;
  const double wm = static_cast<double>(w.population.bodies.properties(id.index).inv_mass);
  const BodyState now = w.population.state_of(id.index);
  const Vec2 v{now.vx + wm * impulse.x, now.vy + wm * impulse.y};
  if (!finite(v.x) || !finite(v.y)) {
    w.quarantine.doubtful.push_back(id);
    return true;
  }
  const Motion before = w.population.motion_of(i);
  w.population.bodies.put_velocity(i, w.population.capped(v));
  w.step_work.pushed(w.context(), id.index, before);
  w.dynamics.forces_stale = true;
  return true;
}

bool World::apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point) {
  Impl& w = *impl_;
  if (!apply_impulse(id, impulse)) return false;
  const std::size_t i = w.population.bodies.info[id.index].slot;
  const Observed seen = w.observed();
  const Vec2 centre = seen.to_world(seen.place(i)), period = seen.period();
  Vec2 arm{point.x - centre.x, point.y - centre.y};
  if (period.x > 0) {  // to the nearest of the repeated copies of the point
    arm.x -= period.x * std::nearbyint(arm.x / period.x);
    arm.y -= period.y * std::nearbyint(arm.y / period.y);
  }
  return apply_angular_impulse(id, arm.x * impulse.y - arm.y * impulse.x);
}

// The angular velocity changes by impulse / I; with the rim speed u = omega R and the gain g = R^2 / I that is
// du = g impulse / R.
bool World::apply_angular_impulse(BodyId id, double impulse) {
  Impl& w = *impl_;
  if (!w.can_move(id)) return false;
  const BodyProperties& properties = w.population.bodies.properties(id.index);
  if (properties.rim_gain == 0 || impulse == 0) return true;
  const std::size_t i = w.population.bodies.info[id.index].slot;
  const double change = static_cast<double>(properties.rim_gain) * impulse / static_cast<double>(properties.radius);
  const Motion before = w.population.motion_of(i);
  const auto rim_speed = static_cast<float>(static_cast<double>(before.rim_speed) + change);
  if (!finite(static_cast<double>(rim_speed))) {
    w.quarantine.doubtful.push_back(id);
    return true;
  }
  w.let_turn();
  w.population.bodies.rim_speed[i] = rim_speed;
  w.step_work.pushed(w.context(), id.index, before);
  return true;
}

bool World::is_awake(BodyId id) const {
  return is_valid(id) && impl_->population.bodies.info[id.index].place == Place::moving;
}

bool World::wake(BodyId id) {
  if (!is_valid(id)) return false;
  Impl& w = impl_->settled();
  w.note_sleep(w.sleep.wake_body(w.sleep_source(), id.index));
  return true;
}

std::string World::why_awake(BodyId id) const {
  if (!is_valid(id)) return "there is no such body";
  Impl& w = impl_->settled();
  return w.sleep.why_awake(w.sleep_source(), id.index, w.desc.sleeping, w.desc.dt);
}

}  // namespace psim
