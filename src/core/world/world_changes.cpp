// The host changes what a body is: whether it takes part, its traits, its type, shape and place, what is kept with it.
#include "bodies/body_desc.h"
#include "psim/limits.h"
#include "world/world_impl.h"

namespace psim {

bool World::set_enabled(BodyId id, bool on) try {
  const FloatSettings settings;
  if (!is_valid(id) || impl_->bodies.info[id.index].place == Place::frozen) return false;
  if (is_enabled(id) == on) return true;
  Owners& w = impl_->settled();
  Population& population = w.population;
  if (on) {
    population.make_room_to_enable(id.index);
    const DisabledBody was = population.disabled[w.bodies.info[id.index].slot];
    population.enable(id.index);
    const auto take_back = [&] {
      population.disable(id.index);
      population.disabled.back() = was;  // to the last bit
    };
    or_else(take_back, [&] {
      body_came(w, id.index);
      disturb_joined(w, id.index);
    });
  } else {
    disturb(w, id.index);
    population.make_room_to_disable();
    body_goes(w, id.index, true, true);
    population.disable(id.index);
    forget_impulses_of_nobody(w);
  }
  if (!w.joints.empty()) w.joints.follow(id.index);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::is_enabled(BodyId id) const {
  return is_valid(id) && impl_->bodies.info[id.index].place != Place::disabled;
}

std::optional<BodyTraits> World::traits(BodyId id) const {
  const FloatSettings settings;
  if (!is_valid(id)) return std::nullopt;
  return impl_->population.traits_of(id.index);
}

namespace {

// Before traits change: the body wakes, and what it touches or is joined to.
void wake_around(Owners& w, std::uint32_t id) {
  disturb(w, id);
  disturb_joined(w, id);
  w.bodies.find_slots();
  w.note_sleep(w.sleep.disturb_neighbours(w.sleep_source(), id));
}

// After they changed.
void traits_changed(Owners& w, std::uint32_t id) {
  if (!w.joints.empty()) w.joints.follow(id);
  spoil_work(w);
  w.plan_stale = true;
  w.observers.queries.forget(QueryIndex::kMoving, QueryIndex::kFixed);
}

}  // namespace

bool World::set_traits(BodyId id, const BodyTraits& to) try {
  const FloatSettings settings;
  if (!is_valid(id) || impl_->bodies.info[id.index].place == Place::frozen) return false;
  if (!check(to, impl_->bodies.properties(id.index).type()).empty()) return false;
  Owners& w = impl_->settled();
  if (w.population.traits_of(id.index) == to) return true;
  wake_around(w, id.index);
  if (!w.population.set_traits(id.index, to)) return false;
  traits_changed(w, id.index);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

std::uint32_t World::part_count(BodyId id) const { return is_valid(id) ? impl_->population.told_parts(id.index) : 0; }

std::optional<PartTraits> World::part_traits(BodyId id, std::uint32_t part) const {
  const FloatSettings settings;
  if (part >= part_count(id)) return std::nullopt;
  return impl_->population.part_traits_of(id.index, part);
}

bool World::set_part_traits(BodyId id, std::uint32_t part, const PartTraits& to) try {
  const FloatSettings settings;
  if (part >= part_count(id) || impl_->bodies.info[id.index].place == Place::frozen || !check(to).empty()) return false;
  Owners& w = impl_->settled();
  PartTraits now = w.population.part_traits_of(id.index, part);
  if (now == to) return true;
  const bool alone = part_count(id) == 1;
  if (alone && !set_user_data(id, to.user_data)) return false;
  now.user_data = to.user_data;
  if (now == to && alone) return true;
  wake_around(w, id.index);
  if (!w.population.set_part(id.index, part, to)) return false;
  traits_changed(w, id.index);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::set_body(BodyId id, const BodyDesc& d, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  error = check(d, w.desc.bounds);
  if (!is_valid(id)) error = "there is no such body";
  if (error.empty() && w.bodies.info[id.index].place == Place::frozen) error = "the body is frozen";
  if (!error.empty()) return false;
  wake_around(w, id.index);
  w.bodies.reserve_slots(w.sleep.sleepers.list.size() + 2);  // if it must come back, others may have woken meanwhile
  const bool was_out = is_out(w.bodies.info[id.index].place);
  const auto change = w.population.change(id.index, d, error);
  if (!change) return false;
  const auto come = [&] {
    body_came(w, id.index);
    if (w.observers.events.on() && !was_out) w.observers.events.body_left(id, true);
  };
  or_else([&] { w.population.take_back(id.index, *change); }, come);
  w.population.keep(*change);
  w.observers.queries.forget(QueryIndex::kMoving, QueryIndex::kFixed);
  spoil_work(w);
  w.plan_stale = w.observers.placed = true;
  if (!w.joints.empty()) w.joints.follow(id.index);
  forget_impulses_of_nobody(w);
  return true;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "the body", error);
  return impl_->ran_out(false);
}

std::uint64_t World::user_data(BodyId id) const {
  const UserValues& values = impl_->population.user_values;
  return is_valid(id) && values.has(id.index) ? values.at(id.index).value : 0;
}

bool World::set_user_data(BodyId id, std::uint64_t value) try {
  if (!is_valid(id)) return false;
  UserValues& values = impl_->settled().population.user_values;
  if (values.has(id.index)) {
    values.at(id.index).value = value;
    if (value == 0) values.remove(id.index);
  } else if (value != 0) {
    values.add({id.index, value});
  }
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

}  // namespace psim
