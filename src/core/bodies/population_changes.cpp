// Bodies leave the simulation for a while and come back, are frozen, or get another description. They keep their ids.
#include "bodies/population.h"

namespace psim {

void Population::disable(std::uint32_t id) {
  DisabledBody now;
  now.last = state_of(id);
  BodyInfo& info = bodies.info[id];
  if (info.place == Place::fixed) {
    now.first_shape = fixed[info.slot].first_shape;
    now.pieces = statics.hide(now.first_shape, id);
    leave_list(fixed, id);
    count(bodies.properties(id), -1, traits);
  } else {
    if (bodies.kind(id).restrained) {
      const Restraint& of = restraints.at(id);
      now.linear_damping = of.linear_damping;
      now.angular_damping = of.angular_damping;
    }
    leave_columns(id);
  }
  info.place = Place::disabled;
  info.slot = static_cast<std::uint32_t>(disabled.size());
  disabled.push_back(now);
}

void Population::make_room_to_enable(std::uint32_t id) {
  const BodyKind& kind = bodies.kind(id);
  const BodyState& last = disabled[bodies.info[id].slot].last;
  reserve({.type = last.type,
           .angle = last.angle,
           .angular_velocity = last.omega,
           .bullet = kind.bullet,
           .locks = {.x = kind.restrained}},
          0);
}

void Population::enable(std::uint32_t id) {
  const DisabledBody was = disabled[bodies.info[id].slot];
  leave_list(disabled, id);
  if (was.last.type == BodyType::static_body) {
    bodies.info[id].place = Place::fixed;
    bodies.info[id].slot = static_cast<std::uint32_t>(fixed.size());
    statics.show(was.first_shape, was.pieces);
    fixed.push_back({was.last.x, was.last.y, was.last.angle, bodies.properties(id).radius, id, was.first_shape});
  } else {
    enter_columns(was);
  }
  count(bodies.properties(id), +1, traits);
}

void Population::freeze(const BodyState& last) {
  leave_columns(last.id.index);
  BodyInfo& info = bodies.info[last.id.index];
  info.place = Place::frozen;
  info.slot = static_cast<std::uint32_t>(frozen.size());
  frozen.push_back(last);
}

std::optional<Population::Change> Population::change(std::uint32_t id, const BodyDesc& d, std::string& error) {
  disabled.reserve(disabled.size() + 2);
  make_room_to_leave(1, true);
  const BodyKind old = bodies.kind(id);  // it may have to come back, without memory
  reserve({.type = bodies.properties(id).type(), .bullet = old.bullet, .locks = {.x = old.restrained}}, 0);
  std::optional<Newcomer> made = describe(d, error);
  if (!made) return std::nullopt;
  const BodyInfo& info = bodies.info[id];  // where it stays: room for one body more was made
  Change change;
  change.was_disabled = info.place == Place::disabled;
  change.row = info.properties;
  if (user_values.has(id)) change.user_data = user_values.at(id).value;
  if (!change.was_disabled) disable(id);
  change.before = disabled[info.slot];
  leave_list(disabled, id);
  enter(id, d, *made);
  return change;
}

void Population::keep(const Change& change) {
  statics.remove_hidden(change.before.first_shape, change.before.pieces);
  release(change.row);
  traits_changed = true;
}

void Population::take_back(std::uint32_t id, const Change& change) {
  BodyInfo& info = bodies.info[id];
  if (info.place != Place::disabled) disable(id);
  statics.remove_hidden(disabled[info.slot].first_shape, disabled[info.slot].pieces);
  release(info.properties);
  info.properties = change.row;
  disabled[info.slot] = change.before;
  put_user_data(id, change.user_data);
  if (!change.was_disabled) enable(id);
}

}  // namespace psim
