// The host adds, removes, moves and pushes bodies. The population does it; here the others are told: the lists are
// made anew, the query grids are forgotten, sleepers wake. A number that is not finite changes nothing now: the next
// step freezes the body.
#include <algorithm>
#include <cmath>

#include "base/room.h"
#include "base/rotor.h"
#include "base/sort_keys.h"
#include "bodies/body_desc.h"
#include "psim/limits.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// Sleepers see a body that moves, and a dynamic one that leans on them. A kinematic body may do neither.
void wake_around_kinematic(Owners& w, std::uint32_t id) {
  if (w.bodies.properties(id).type() != BodyType::kinematic_body || w.sleep.sleepers.empty()) return;
  w.bodies.find_slots();
  w.note_sleep(w.sleep.disturb_neighbours(w.sleep_source(), id));
}

// A body that moves, and that the host took out of the simulation for a while; else none.
DisabledBody* disabled_mover(Owners& w, BodyId id) {
  if (!w.population.is_valid(id) || w.bodies.info[id.index].place != Place::disabled) return nullptr;
  DisabledBody& body = w.population.disabled[w.bodies.info[id.index].slot];
  return body.last.type != BodyType::static_body ? &body : nullptr;
}

// Lets change(slot) change how a body moves. It returns false, and changes nothing, if a number is not finite.
template <class Change>
bool push(Owners& w, BodyId id, const Change& change) {
  if (!can_move(w, id)) return false;
  const std::uint32_t slot = w.bodies.info[id.index].slot;
  const Motion before = w.population.motion_of(slot);
  if (!w.progress.untouched()) w.done_so_far.reserve(roomier(w.done_so_far));  // note_push() needs no memory
  if (change(slot)) {
    note_push(w, id.index, before);
  } else {
    w.quarantine.doubtful.push_back(id);
  }
  return true;
}

// Tells those who keep something of a body that it is not there any more. Its joints are gone.
void tell_of_going(Owners& w, std::uint32_t id, bool same) {
  const BodyInfo& info = w.bodies.info[id];
  if (w.observers.events.on()) w.observers.events.body_left({id, info.generation}, same);
  w.observers.queries.forget(info.place == Place::fixed    ? QueryIndex::kFixed
                             : info.place == Place::asleep ? QueryIndex::kSleeping
                                                           : QueryIndex::kMoving);
  if (!is_out(info.place)) w.plan_stale = true;
  w.contacts.manifolds.forget_decisions(id);
  spoil_work(w);
}

// Those that sleep and have no joints go together, and only what leaned on them wakes.
std::size_t remove_sleeping(Owners& w, std::span<const BodyId> ids) {
  std::vector<std::uint32_t> sleeping;
  for (const BodyId id : ids) {
    const bool asleep = w.population.is_valid(id) && w.bodies.info[id.index].place == Place::asleep;
    if (asleep && !w.joints.ties(id.index)) sleeping.push_back(id.index);
  }
  if (sleeping.empty()) return 0;
  sort_keys(sleeping.begin(), sleeping.end());
  sleeping.erase(std::unique(sleeping.begin(), sleeping.end()), sleeping.end());
  w.observers.events.make_room_to_leave(sleeping.size());
  w.note_sleep(w.sleep.let_go(w.sleep_source(), sleeping));
  for (const std::uint32_t id : sleeping) {
    tell_of_going(w, id, false);
    w.population.remove(id);
  }
  return sleeping.size();
}

// Room for what leaves is made once. Joints, sleepers and events are told of each body.
void remove_all(Owners& w, std::span<const BodyId> ids, std::size_t& removed) {
  const auto is_static = [&](BodyId id) {
    return w.population.is_valid(id) && w.bodies.properties(id.index).type() == BodyType::static_body;
  };
  w.population.make_room_to_leave(ids.size(), std::ranges::any_of(ids, is_static));
  if (!w.sleep.sleepers.empty()) removed += remove_sleeping(w, ids);
  for (const BodyId id : ids) {
    if (!w.population.is_valid(id)) continue;
    body_goes(w, id.index, false);
    w.population.remove(id.index);
    ++removed;
  }
  forget_impulses_of_nobody(w);
}

}  // namespace

void body_came(Owners& w, std::uint32_t id) {
  spoil_work(w);
  w.plan_stale = w.observers.placed = true;
  if (w.bodies.info[id].place == Place::disabled) return;
  if (w.bodies.info[id].place == Place::fixed) {
    w.observers.queries.forget(QueryIndex::kFixed);
    w.note_sleep(w.sleep.disturb_at_fixed(w.sleep_source(), id));
  } else {
    w.observers.queries.forget(QueryIndex::kMoving);
    w.sleep.sleepers.mark_moving(id);
    wake_around_kinematic(w, id);
  }
}

void body_goes(Owners& w, std::uint32_t id, bool same, bool tied) {
  w.observers.events.make_room_to_leave(1);
  disturb_joined(w, id);
  w.bodies.find_slots();
  w.note_sleep(w.sleep.disturb_neighbours(w.sleep_source(), id));  // a sleeping body itself wakes, too
  if (!tied) remove_joints_of(w, id);
  tell_of_going(w, id, same);
}

void forget_impulses_of_nobody(Owners& w) {
  if (w.bodies.count == 0) w.contacts.impulses_valid = false;
}

bool can_move(Owners& w, BodyId id) {
  w.settled();
  w.bodies.find_slots();
  if (!w.population.is_valid(id)) return false;
  const Place place = w.bodies.info[id.index].place;
  if (place != Place::moving && place != Place::asleep) return false;
  disturb(w, id.index);
  return true;
}

void let_turn(Owners& w) {
  if (!w.bodies.rim_speed.empty()) return;
  w.plan_stale = true;
  w.population.let_turn();
}

void remove_body(Owners& w, std::uint32_t id) {
  w.settled();
  w.population.make_room_to_leave(1, w.bodies.properties(id).type() == BodyType::static_body);
  body_goes(w, id, false);
  w.population.remove(id);
  forget_impulses_of_nobody(w);
}

void freeze_body(Owners& w, const BodyState& last) {
  w.population.frozen.reserve(roomier(w.population.frozen));
  body_goes(w, last.id.index, true);
  w.population.freeze(last);
  forget_impulses_of_nobody(w);
}

void disturb(Owners& w, std::uint32_t id) { w.note_sleep(w.sleep.disturb(w.sleep_source(), id)); }

bool Owners::note_sleep(bool changed) {
  if (!changed) return false;
  spoil_work(*this);
  observers.queries.forget(QueryIndex::kMoving, QueryIndex::kSleeping);
  forget_impulses_of_nobody(*this);
  return true;
}

BodyId World::add_body(const BodyDesc& d, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  error = check(d, w.desc.bounds);
  if (!error.empty()) return kNoBody;
  if (!w.sleep.sleepers.empty())
    w.population.make_room_to_leave(1, d.type == BodyType::static_body);  // to take it back, if others cannot wake
  const BodyId id = w.population.add(d, error);
  if (id == kNoBody) return kNoBody;
  or_else([&] { w.population.remove(id.index); }, [&] { body_came(w, id.index); });
  return id;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "a body", error);
  return impl_->ran_out(kNoBody);
}

std::size_t World::add_discs(const DiscBatch& batch, std::uint32_t& first, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  error = check(batch, w.desc.bounds);
  if (!error.empty()) return 0;
  const std::size_t n = batch.x.size();
  first = w.population.next_id();
  if (n == 0) return 0;  // nothing changes: a step that is spread over frames goes on
  const bool fixed = batch.type == BodyType::static_body;
  w.population.make_room(n, fixed);
  std::vector<std::uint32_t> came;
  came.reserve(n);
  if (!w.sleep.sleepers.empty()) w.population.make_room_to_leave(n, fixed);
  const auto take_back = [&] {
    for (; !came.empty(); came.pop_back()) w.population.remove(came.back());
  };
  return or_else(take_back, [&]() -> std::size_t {
    for (std::size_t i = 0; i < n; ++i) {
      const BodyId id = w.population.add(disc_of(batch, i), error);
      if (id == kNoBody) return i;  // none: all discs are of one kind
      came.push_back(id.index);
      if (fixed) {
        body_came(w, id.index);
      } else {
        w.sleep.sleepers.mark_moving(id.index);
        wake_around_kinematic(w, id.index);
      }
    }
    if (n != 0) w.plan_stale = w.observers.placed = true;
    w.observers.queries.forget(QueryIndex::kMoving);
    spoil_work(w);
    return n;
  });
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, std::to_string(batch.x.size()) + " bodies", error);
  return impl_->ran_out(std::size_t{0});
}

bool World::remove_body(BodyId id) try {
  if (!is_valid(id)) return false;
  std::size_t removed = 0;
  remove_all(impl_->settled(), {&id, 1}, removed);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

std::size_t World::remove_bodies(std::span<const BodyId> ids) {
  std::size_t removed = 0;
  try {
    remove_all(impl_->settled(), ids, removed);
  } catch (const std::bad_alloc&) {
    impl_->ran_out(removed);
  }
  return removed;
}

bool World::is_valid(BodyId id) const { return impl_->population.is_valid(id); }

BodyId World::id_of(std::uint32_t index) const {
  const BodyStore& b = impl_->bodies;
  if (index >= b.id_count || b.info[index].place == Place::none) return kNoBody;
  return {index, b.info[index].generation};
}

std::optional<BodyState> World::body(BodyId id) const {
  const FloatSettings settings;
  if (!is_valid(id)) return std::nullopt;
  return impl_->observed().state_of(id.index);
}

bool World::set_transform(BodyId id, Vec2 position, double angle) try {
  const FloatSettings settings;
  Owners& w = *impl_;
  if (DisabledBody* body = disabled_mover(w, id)) {
    if (!limits::kCoordinate.contains(position) || !limits::kAngle.contains(angle)) return false;
    w.settled();
    position = w.population.within_walls(position);
    body->last.x = position.x, body->last.y = position.y, body->last.angle = angle;
    w.observers.placed = true;
    return true;
  }
  if (!can_move(w, id)) return false;
  if (!finite(position) || !finite(angle)) {
    w.quarantine.doubtful.push_back(id);
    return true;
  }
  w.note_sleep(w.sleep.disturb_neighbours(w.sleep_source(), id.index));  // what leaned on it where it was
  if (angle != 0) let_turn(w);
  const std::uint32_t slot = w.bodies.info[id.index].slot;
  const LatticePoint at = w.bodies.point(slot);
  const double turned = w.bodies.angle_of(slot);
  w.population.place(id.index, position, angle);
  const auto put_back = [&] {
    w.bodies.put_point(slot, at);
    if (!w.bodies.angle.empty()) w.bodies.angle[slot] = turned;
  };
  or_else(put_back, [&] { wake_around_kinematic(w, id.index); });
  spoil_work(w);
  w.observers.placed = true;
  w.observers.queries.forget(QueryIndex::kMoving);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::set_velocity(BodyId id, Vec2 velocity, double angular_velocity) try {
  const FloatSettings settings;
  const bool within = limits::kVelocity.contains(velocity) && limits::kAngularVelocity.contains(angular_velocity);
  if (!within && std::isfinite(velocity.x) && std::isfinite(velocity.y) && std::isfinite(angular_velocity))
    return false;
  if (DisabledBody* body = disabled_mover(*impl_, id)) {
    if (!within) return false;
    impl_->settled();
    body->last.vx = velocity.x, body->last.vy = velocity.y, body->last.omega = angular_velocity;
    return true;
  }
  return push(*impl_, id, [&](std::uint32_t) {
    if (!within) return false;
    if (angular_velocity != 0) let_turn(*impl_);
    impl_->population.set_velocity(id.index, velocity, angular_velocity);
    return true;
  });
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::apply_impulse(BodyId id, Vec2 impulse) try {
  const FloatSettings settings;
  Population& population = impl_->population;
  return push(*impl_, id, [&](std::uint32_t slot) {
    const BodyState now = population.state_of(id.index);
    const double wm = static_cast<double>(population.bodies.properties(id.index).inv_mass);
    const Vec2 v = Vec2{now.vx, now.vy} + wm * impulse;
    if (!finite(v)) return false;
    population.bodies.put_velocity(slot, population.capped(v));
    return true;
  });
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::apply_impulse_at(BodyId id, Vec2 impulse, Vec2 point) try {
  const FloatSettings settings;
  if (!can_move(*impl_, id)) return false;
  const double turn = cross(arm_to(*impl_, id, point), impulse);
  if (turn != 0 && impl_->bodies.properties(id.index).rim_gain != 0) let_turn(*impl_);
  return apply_impulse(id, impulse) && apply_angular_impulse(id, turn);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

// The angular velocity changes by impulse / I; with the rim speed u = omega R and the gain g = R^2 / I that is
// du = g impulse / R.
bool World::apply_angular_impulse(BodyId id, double impulse) try {
  const FloatSettings settings;
  Population& population = impl_->population;
  const bool turns = is_valid(id) && population.bodies.properties(id.index).rim_gain != 0 && impulse != 0;
  if (!turns) return can_move(*impl_, id);
  return push(*impl_, id, [&](std::uint32_t slot) {
    const BodyProperties& properties = population.bodies.properties(id.index);
    const double change = static_cast<double>(properties.rim_gain) * impulse / static_cast<double>(properties.radius);
    const double rim_speed = static_cast<double>(population.motion_of(slot).rim_speed) + change;
    if (!std::isfinite(static_cast<float>(rim_speed))) return false;
    let_turn(*impl_);
    population.bodies.put_rim_speed(slot, rim_speed);
    return true;
  });
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::is_awake(BodyId id) const { return is_valid(id) && impl_->bodies.info[id.index].place == Place::moving; }

bool World::wake(BodyId id) try {
  if (!is_valid(id)) return false;
  Owners& w = impl_->settled();
  w.note_sleep(w.sleep.wake_body(w.sleep_source(), id.index));
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

std::string World::why_awake(BodyId id) const try {
  if (!is_valid(id)) return "there is no such body";
  Owners& w = impl_->settled();
  return w.sleep.why_awake(w.sleep_source(), id.index, w.desc.sleeping, w.desc.dt);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(std::string());
}

}  // namespace psim
