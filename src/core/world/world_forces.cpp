// The host pushes bodies for a step, lets something explode, and changes the fields.
#include "base/room.h"
#include "psim/limits.h"
#include "query/blast.h"
#include "query/queries.h"
#include "world/world_impl.h"

namespace psim {

bool add_force(Owners& w, BodyId id, Vec2 force, double torque) {
  if (!can_move(w, id)) return false;
  push_body(w, id, force, torque);
  return true;
}

void push_body(Owners& w, BodyId id, Vec2 force, double torque) {
  Population& population = w.population;
  population.applied.make_room();
  if (torque != 0 && w.bodies.properties(id.index).rim_gain != 0) let_turn(w);
  if (!w.progress.untouched()) spoil_work(w);  // what was found for this step did not know of it
  if (!population.traits.pushed) population.traits.pushed = w.plan_stale = true;
  if (!population.applied.has(id.index)) {
    AppliedForce none;
    none.id = id.index;
    population.applied.add(none);
  }
  AppliedForce& all = population.applied.at(id.index);
  all.force = all.force + force;
  all.torque += torque;
}

Vec2 arm_to(Owners& w, BodyId id, Vec2 point) {
  const Vec2 centre = w.lattice.to_world(w.bodies.point(w.bodies.info[id.index].slot));
  return nearest_copy(point - centre, w.observed().period());
}

bool World::apply_force(BodyId id, Vec2 force) try {
  const FloatSettings settings;
  return limits::kForce.contains(force) && add_force(*impl_, id, force, 0);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::apply_force_at(BodyId id, Vec2 force, Vec2 point) try {
  const FloatSettings settings;
  Owners& w = *impl_;
  if (!limits::kForce.contains(force) || !limits::kCoordinate.contains(point) || !can_move(w, id)) return false;
  return add_force(w, id, force, cross(arm_to(w, id, point), force));
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::apply_torque(BodyId id, double torque) try {
  const FloatSettings settings;
  return limits::kForce.contains(torque) && add_force(*impl_, id, {}, torque);
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

std::optional<std::size_t> World::explode(const Explosion& e) try {
  const FloatSettings settings;
  if (!limits::kCoordinate.contains(e.position) || !limits::kBlastLength.contains(e.radius) ||
      !limits::kBlastLength.contains(e.falloff) || !limits::kBlast.contains(e.impulse_per_length)) {
    return std::nullopt;
  }
  Owners& w = impl_->settled();
  const double reach = e.radius + e.falloff;
  const Vec2 far{reach, reach}, low = e.position - far, high = e.position + far;
  const QueryFilter filter{.mask = e.mask, .kinematic = false, .fixed = false};
  const std::vector<BodyId> near =
      Queries{w.observers.queries, w.observed()}.in_region({low.x, low.y, high.x, high.y}, filter);
  const std::vector<Blow> blows = blows_of(e, w.observed(), near);
  // All that needs memory comes first.
  w.done_so_far.reserve(w.done_so_far.size() + 2 * blows.size());
  w.quarantine.doubtful.reserve(w.quarantine.doubtful.size() + 2 * blows.size());
  for (const Blow& blow : blows) can_move(w, blow.body);
  if (!blows.empty()) let_turn(w);
  std::size_t pushed = 0;
  BodyId last = kNoBody;
  for (const Blow& blow : blows) {
    if (!apply_impulse_at(blow.body, blow.impulse, blow.point) || blow.body == last) continue;
    last = blow.body;
    ++pushed;
  }
  return pushed;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(std::optional<std::size_t>());
}

bool World::set_fields(const std::vector<Field>& fields, std::string& error) try {
  const FloatSettings settings;
  error = check(fields);
  if (!error.empty()) return false;
  std::vector<Field> copy = fields;
  Owners& w = impl_->settled();
  w.note_sleep(w.sleep.wake_all(w.sleep_source()));
  if (!w.progress.untouched()) spoil_work(w);  // they were made for the old fields
  w.desc.fields.swap(copy);
  take_traits(w.desc, w.population.traits);
  w.dynamics.forces.reset();
  w.plan_stale = true;
  return true;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "the fields", error);
  return impl_->ran_out(false);
}

}  // namespace psim
