// What is where, and what happened in a step.
#include <algorithm>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

psim_result psim::capi::read_filter(const Call& call, const psim_query_filter* filter, QueryFilter& out) {
  if (filter == nullptr) return PSIM_OK;
  psim_query_filter given;
  if (const psim_result r = read(call, "filter", filter, given); r != PSIM_OK) return r;
  out = {given.mask,     given.dynamic != 0,   given.kinematic != 0, given.fixed != 0,     given.sensors != 0,
         given.category, to_cpp(given.ignore), given.one_way != 0,   given.enter_only != 0};
  return PSIM_OK;
}

namespace {

// The shape of a question.
psim_result read_shape(const Call& call, const psim_shape* shape, psim::Shape& out) {
  if (shape == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "shape must not be NULL");
  const std::string wrong = convert(*shape, out);
  return wrong.empty() ? PSIM_OK : call.fail(PSIM_ERROR_ARGUMENT, wrong);
}

// Asks ask(world, filter), which returns a list, and gives out as much of it as there is room for.
template <class Item, class Ask>
psim_result list(const psim_world* world, const char* name, const psim_query_filter* filter, Item* items,
                 size_t capacity, size_t* count, const Ask& ask) {
  return guarded(world, name, [&](const psim::World& w, const Call& call) -> psim_result {
    if (count == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "count must not be NULL");
    *count = 0;
    if (items == nullptr && capacity != 0) {
      return call.fail(PSIM_ERROR_ARGUMENT, "the array must not be NULL where it has a capacity");
    }
    psim::QueryFilter f;
    if (const psim_result r = read_filter(call, filter, f); r != PSIM_OK) return r;
    const auto found = ask(w, f);
    for (std::size_t k = 0; k < std::min(capacity, found.size()); ++k) items[k] = to_c(found[k]);
    *count = found.size();
    return PSIM_OK;
  });
}

void copy(std::span<const psim::TouchEvent> from, std::vector<psim_touch_event>& to) {
  to.clear();
  for (const psim::TouchEvent& e : from) to.push_back({to_c(e.a), to_c(e.b)});
}

void copy_parts(std::span<const psim::TouchEvent> from, std::vector<uint32_t>& to) {
  to.clear();
  for (const psim::TouchEvent& e : from) to.push_back(e.part);
}

void copy_hits(std::span<const psim::HitEvent> from, psim_world& world) {
  world.hits.clear();
  world.hit_impulses.clear();
  world.hit_parts.clear();
  for (const psim::HitEvent& e : from) {
    world.hits.push_back({to_c(e.a), to_c(e.b), to_c(e.point), to_c(e.normal), e.speed});
    world.hit_impulses.push_back(e.impulse);
    world.hit_parts.push_back({e.part_a, e.part_b});
  }
}

void copy_fluids(std::span<const psim::FluidEvent> from, std::vector<psim_fluid_event>& to) {
  to.clear();
  for (const psim::FluidEvent& e : from) to.push_back({to_c(e.sensor), e.part, e.fluid, e.particle});
}

// The lists of events that a world keeps for its host.
psim_events lists_of(const psim_world& world) {
  psim_events out;
  psim_events_init(&out);
  out.begin = world.begin.data();
  out.begin_count = world.begin.size();
  out.end = world.end.data();
  out.end_count = world.end.size();
  out.hits = world.hits.data();
  out.hit_count = world.hits.size();
  out.hit_impulses = world.hit_impulses.data();
  out.hit_impulse_count = world.hit_impulses.size();
  out.hit_parts = world.hit_parts.data();
  out.hit_part_count = world.hit_parts.size();
  out.sensor_begin = world.sensor_begin.data();
  out.sensor_begin_count = world.sensor_begin.size();
  out.sensor_end = world.sensor_end.data();
  out.sensor_end_count = world.sensor_end.size();
  out.sensor_begin_parts = world.sensor_begin_parts.data();
  out.sensor_begin_part_count = world.sensor_begin_parts.size();
  out.sensor_end_parts = world.sensor_end_parts.data();
  out.sensor_end_part_count = world.sensor_end_parts.size();
  out.breaks = world.breaks.data();
  out.break_count = world.breaks.size();
  out.begin_points = world.begin_points.data();
  out.begin_point_count = world.begin_points.size();
  out.fell_asleep = world.fell_asleep.data();
  out.fell_asleep_count = world.fell_asleep.size();
  out.woke = world.woke.data();
  out.woke_count = world.woke.size();
  out.moves = world.moves.data();
  out.move_count = world.moves.size();
  out.fluid_begin = world.fluid_begin.data();
  out.fluid_begin_count = world.fluid_begin.size();
  out.fluid_end = world.fluid_end.data();
  out.fluid_end_count = world.fluid_end.size();
  return out;
}

void copy(std::span<const psim::BodyId> from, std::vector<psim_body_id>& to) {
  to.clear();
  for (const psim::BodyId id : from) to.push_back(to_c(id));
}

// Asks a question with one answer. `part`: where to tell its part, or null; `shape`: what it asks with, or null.
template <class Hit, class Ask>
psim_result first(const psim_world* world, const char* name, const psim_shape* const* shape,
                  const psim_query_filter* filter, Hit* hit, std::uint32_t* part, const Ask& ask) {
  return guarded(world, name, [&](const psim::World& w, const Call& call) -> psim_result {
    if (hit == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "hit must not be NULL");
    psim::Shape given;
    if (shape != nullptr) {
      if (const psim_result r = read_shape(call, *shape, given); r != PSIM_OK) return r;
    }
    psim::QueryFilter f;
    if (const psim_result r = read_filter(call, filter, f); r != PSIM_OK) return r;
    const auto found = ask(w, given, f);
    if (!found) return PSIM_NOTHING;
    *hit = to_c(*found);
    if (part != nullptr) *part = found->part;
    return PSIM_OK;
  });
}

psim_result ray_cast(const psim_world* world, const char* name, psim_vec2 from, psim_vec2 to,
                     const psim_query_filter* filter, psim_ray_hit* hit, std::uint32_t* part) {
  return first(world, name, nullptr, filter, hit, part,
               [&](const psim::World& w, const psim::Shape&, const psim::QueryFilter& f) {
                 return w.ray_cast(to_cpp(from), to_cpp(to), f);
               });
}

psim_result shape_cast(const psim_world* world, const char* name, const psim_shape* shape, psim_vec2 from, double angle,
                       psim_vec2 translation, double rotation, const psim_query_filter* filter,
                       psim_shape_cast_hit* hit, std::uint32_t* part) {
  return first(world, name, &shape, filter, hit, part,
               [&](const psim::World& w, const psim::Shape& given, const psim::QueryFilter& f) {
                 return w.shape_cast(given, to_cpp(from), angle, to_cpp(translation), rotation, f);
               });
}

psim_result closest(const psim_world* world, const char* name, psim_vec2 point, double reach,
                    const psim_query_filter* filter, psim_closest_hit* hit, std::uint32_t* part) {
  return first(world, name, nullptr, filter, hit, part,
               [&](const psim::World& w, const psim::Shape&, const psim::QueryFilter& f) {
                 return w.closest(to_cpp(point), reach, f);
               });
}

}  // namespace

psim_result psim_world_ray_cast(const psim_world* world, psim_vec2 from, psim_vec2 to, const psim_query_filter* filter,
                                psim_ray_hit* hit) {
  return ray_cast(world, __func__, from, to, filter, hit, nullptr);
}

psim_result psim_world_ray_cast_part(const psim_world* world, psim_vec2 from, psim_vec2 to,
                                     const psim_query_filter* filter, psim_ray_hit* hit, uint32_t* part) {
  return ray_cast(world, __func__, from, to, filter, hit, part);
}

psim_result psim_world_ray_cast_all(const psim_world* world, psim_vec2 from, psim_vec2 to,
                                    const psim_query_filter* filter, psim_ray_hit* hits, size_t capacity,
                                    size_t* count) {
  return list(world, __func__, filter, hits, capacity, count, [&](const psim::World& w, const psim::QueryFilter& f) {
    return w.ray_cast_all(to_cpp(from), to_cpp(to), f);
  });
}

psim_result psim_world_overlap(const psim_world* world, const psim_shape* shape, psim_vec2 position, double angle,
                               const psim_query_filter* filter, psim_body_id* ids, size_t capacity, size_t* count) {
  psim::Shape given;
  const psim_result result =
      guarded(world, __func__, [&](const psim::World&, const Call& call) { return read_shape(call, shape, given); });
  if (result != PSIM_OK) return result;
  return list(world, __func__, filter, ids, capacity, count, [&](const psim::World& w, const psim::QueryFilter& f) {
    return w.overlap(given, to_cpp(position), angle, f);
  });
}

psim_result psim_world_ray_cast_batch(psim_world* world, const psim_ray* rays, psim_ray_hit* hits, size_t count,
                                      const psim_query_filter* filter, size_t* met) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if ((rays == nullptr || hits == nullptr) && count != 0) {
      return call.fail(PSIM_ERROR_ARGUMENT, "rays and hits must not be NULL");
    }
    psim::QueryFilter f;
    if (const psim_result r = read_filter(call, filter, f); r != PSIM_OK) return r;
    std::vector<psim::RayInput> asked(count);
    std::vector<psim::RayHit> found(count);
    for (std::size_t k = 0; k < count; ++k) asked[k] = {to_cpp(rays[k].from), to_cpp(rays[k].to)};
    const std::size_t all = w.ray_cast_batch(asked, found, f);
    for (std::size_t k = 0; k < count; ++k) hits[k] = to_c(found[k]);
    if (met != nullptr) *met = all;
    return PSIM_OK;
  });
}

psim_result psim_world_shape_cast(const psim_world* world, const psim_shape* shape, psim_vec2 from, double angle,
                                  psim_vec2 translation, double rotation, const psim_query_filter* filter,
                                  psim_shape_cast_hit* hit) {
  return shape_cast(world, __func__, shape, from, angle, translation, rotation, filter, hit, nullptr);
}

psim_result psim_world_shape_cast_part(const psim_world* world, const psim_shape* shape, psim_vec2 from, double angle,
                                       psim_vec2 translation, double rotation, const psim_query_filter* filter,
                                       psim_shape_cast_hit* hit, uint32_t* part) {
  return shape_cast(world, __func__, shape, from, angle, translation, rotation, filter, hit, part);
}

psim_result psim_world_nearby(const psim_world* world, const psim_shape* shape, psim_vec2 position, double angle,
                              double reach, const psim_query_filter* filter, psim_near_hit* hits, size_t capacity,
                              size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (count == nullptr || (hits == nullptr && capacity != 0)) {
      return call.fail(PSIM_ERROR_ARGUMENT, "count must not be NULL, nor the array where it has a capacity");
    }
    *count = 0;
    psim::Shape given;
    if (const psim_result r = read_shape(call, shape, given); r != PSIM_OK) return r;
    psim::QueryFilter f;
    if (const psim_result r = read_filter(call, filter, f); r != PSIM_OK) return r;
    // No more than there are: a capacity may be any number.
    const std::size_t all = w.nearby(given, to_cpp(position), angle, reach, {}, f);
    std::vector<psim::NearHit> found(std::min(capacity, all));
    w.nearby(given, to_cpp(position), angle, reach, found, f);
    for (std::size_t k = 0; k < found.size(); ++k) {
      const psim::NearHit& h = found[k];
      hits[k] = {to_c(h.body), to_c(h.point), to_c(h.normal), h.distance, h.one_way, h.part};
    }
    *count = all;
    return PSIM_OK;
  });
}

psim_result psim_world_in_region(const psim_world* world, psim_bounds region, const psim_query_filter* filter,
                                 psim_body_id* ids, size_t capacity, size_t* count) {
  return list(world, __func__, filter, ids, capacity, count,
              [&](const psim::World& w, const psim::QueryFilter& f) { return w.in_region(to_cpp(region), f); });
}

psim_result psim_world_closest(const psim_world* world, psim_vec2 point, double reach, const psim_query_filter* filter,
                               psim_closest_hit* hit) {
  return closest(world, __func__, point, reach, filter, hit, nullptr);
}

psim_result psim_world_closest_part(const psim_world* world, psim_vec2 point, double reach,
                                    const psim_query_filter* filter, psim_closest_hit* hit, uint32_t* part) {
  return closest(world, __func__, point, reach, filter, hit, part);
}

psim_result psim_world_set_event_options(psim_world* world, const psim_event_options* options) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_event_options given;
    if (const psim_result r = read(call, "options", options, given); r != PSIM_OK) return r;
    if (!(given.hit_speed >= 0)) {
      return call.fail(PSIM_ERROR_ARGUMENT, "hit_speed must be 0 or more");
    }
    w.set_event_options({given.contacts != 0, given.hits != 0, given.hit_speed, given.sensors != 0, given.sleep != 0,
                         given.moves != 0, given.fluids != 0});
    return PSIM_OK;
  });
}

psim_result psim_world_events(psim_world* world, psim_events* events) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "events", events); r != PSIM_OK) return r;
    const psim::Events from = w.events();
    copy(from.begin, world->begin);
    copy(from.end, world->end);
    copy(from.sensor_begin, world->sensor_begin);
    copy(from.sensor_end, world->sensor_end);
    copy_parts(from.sensor_begin, world->sensor_begin_parts);
    copy_parts(from.sensor_end, world->sensor_end_parts);
    world->begin_points.clear();
    for (const psim::TouchEvent& e : from.begin) world->begin_points.push_back({to_c(e.point), to_c(e.normal)});
    copy(from.fell_asleep, world->fell_asleep);
    copy(from.woke, world->woke);
    world->moves.clear();
    for (const psim::MoveEvent& e : from.moves) {
      world->moves.push_back({to_c(e.body), to_c(e.position), e.angle, e.fell_asleep ? 1 : 0, 0});
    }
    copy_hits(from.hits, *world);
    copy_fluids(from.fluid_begin, world->fluid_begin);
    copy_fluids(from.fluid_end, world->fluid_end);
    world->breaks.clear();
    for (const psim::JointBreak& b : from.breaks) {
      world->breaks.push_back(
          {to_c(b.joint), to_c(b.a), to_c(b.b), to_c(b.point), to_c(b.force), b.torque, b.user_data});
    }
    const psim_events out = lists_of(*world);
    write(out, events);
    return PSIM_OK;
  });
}

psim_result psim_world_contacts(psim_world* world, const psim_contact** contacts, size_t* count) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (contacts == nullptr || count == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "contacts and count must not be NULL");
    }
    world->contacts.clear();
    world->contact_groups.clear();
    world->contact_parts.clear();
    for (const psim::Contact& c : w.contacts()) {
      world->contacts.push_back(
          {to_c(c.a), to_c(c.b), to_c(c.point), to_c(c.normal), c.separation, c.impulse, c.friction});
      world->contact_groups.push_back({c.strip, c.colour});
      world->contact_parts.push_back({c.part_a, c.part_b});
    }
    *contacts = world->contacts.data();
    *count = world->contacts.size();
    return PSIM_OK;
  });
}

psim_result psim_world_contact_groups(psim_world* world, const psim_contact_group** groups, size_t* count) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (groups == nullptr || count == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "groups and count must not be NULL");
    }
    *groups = world->contact_groups.data();
    *count = world->contact_groups.size();
    return PSIM_OK;
  });
}

psim_result psim_world_contact_parts(psim_world* world, const psim_parts** parts, size_t* count) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (parts == nullptr || count == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "parts and count must not be NULL");
    }
    *parts = world->contact_parts.data();
    *count = world->contact_parts.size();
    return PSIM_OK;
  });
}

psim_result psim_world_strips(psim_world* world, const uint32_t** strips, size_t* count) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (strips == nullptr || count == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "strips and count must not be NULL");
    }
    const auto list = w.strips();
    *strips = list.data();
    *count = list.size();
    return PSIM_OK;
  });
}
