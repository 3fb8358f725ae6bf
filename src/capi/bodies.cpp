// Bodies come, go, and are pushed.
#include <cstring>

#include "convert.h"
#include "psim/limits.h"
#include "structs.h"

using namespace psim::capi;

namespace {

psim_result stale_body(const Call& call, std::uint32_t index) {
  return call.fail(PSIM_ERROR_STALE_ID, "there is no body " + std::to_string(index) + " of this generation");
}

psim_result no_part(const Call& call, std::uint32_t body, std::uint32_t part) {
  return call.fail(PSIM_ERROR_ARGUMENT, "body " + std::to_string(body) + " has no part " + std::to_string(part));
}

psim_result add(const Call& call, const psim_body_desc* desc, const std::string& who, psim_body_id* id) {
  psim_body_desc given;
  if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
  psim::BodyDesc body;
  std::string wrong = convert(given, body);
  psim::BodyId made = psim::kNoBody;
  if (wrong.empty()) made = call.world->changed([&](auto& w) { return w.add_body(body, wrong); });
  if (made == psim::kNoBody) return call.fail(PSIM_ERROR_ARGUMENT, who + wrong);
  if (id != nullptr) *id = to_c(made);
  return PSIM_OK;
}

// A column as the engine takes it: in place where its numbers lie side by side, else a copy.
class Column {
 public:
  Column(const psim_column& from, std::size_t count) {
    if (from.data == nullptr) return;
    if (from.stride == 0 || from.stride == sizeof(double)) {
      values_ = {from.data, count};
      return;
    }
    copy_.resize(count);
    const auto* at = reinterpret_cast<const unsigned char*>(from.data);
    for (std::size_t k = 0; k < count; ++k) {
      std::memcpy(&copy_[k], at + k * from.stride, sizeof(double));
    }
    values_ = copy_;
  }
  std::span<const double> values() const { return values_; }

 private:
  std::vector<double> copy_;
  std::span<const double> values_;
};

// Pushes a body by apply(world); says why where it does not move. `fits`: whether the numbers are in their ranges.
template <class Push>
psim_result push(psim_world* world, const char* name, psim_body_id id, const Push& apply, bool fits = true) {
  return guarded(world, name, [&](psim::World& w, const Call& call) -> psim_result {
    if (!fits) {
      return call.fail(PSIM_ERROR_ARGUMENT, "forces must be -1e30 to 1e30 N or N m, points -1e9 to 1e9 m");
    }
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    if (world->changed(apply)) return PSIM_OK;
    return call.fail(PSIM_ERROR_NOT_MOVABLE, "body " + std::to_string(id.index) + " is static or frozen");
  });
}

// What a world knows of a body.
template <class Out, class Ask>
psim_result tell(const psim_world* world, const char* name, psim_body_id id, Out* out, const Ask& ask) {
  return guarded(world, name, [&](const psim::World& w, const Call& call) -> psim_result {
    if (out == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "the place for the answer must not be NULL");
    const auto known = ask(w);
    if (!known) return stale_body(call, id.index);
    *out = to_c(*known);
    return PSIM_OK;
  });
}

}  // namespace

psim_result psim_world_add_body(psim_world* world, const psim_body_desc* desc, psim_body_id* id) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) { return add(call, desc, "", id); });
}

psim_result psim_world_add_bodies(psim_world* world, const psim_body_desc* descs, size_t count, size_t stride,
                                  psim_body_id* ids, size_t* added) {
  if (added != nullptr) *added = 0;
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (count != 0 && descs == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "descs must not be NULL");
    }
    if (const psim_result r = check_stride(call, count, stride); r != PSIM_OK) return r;
    const auto* at = reinterpret_cast<const unsigned char*>(descs);
    for (std::size_t k = 0; k < count; ++k) {
      const psim_result result = add(call, reinterpret_cast<const psim_body_desc*>(at + k * stride),
                                     "body " + std::to_string(k) + ": ", ids != nullptr ? ids + k : nullptr);
      if (result != PSIM_OK) return result;
      if (added != nullptr) *added = k + 1;
    }
    return PSIM_OK;
  });
}

psim_result psim_world_add_discs(psim_world* world, const psim_disc_batch* batch, uint32_t* first) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    psim_disc_batch given;
    if (const psim_result r = read(call, "batch", batch, given); r != PSIM_OK) return r;
    const auto refuse = [&](std::string_view what) { return call.fail(PSIM_ERROR_ARGUMENT, what); };
    const auto type = to_enum(given.type, psim::BodyType::kinematic_body);
    if (!type) return refuse("type is none of psim_body_type, 0 to 2");
    if (given.reserved != 0) return refuse("reserved must be 0");
    if (given.count > 0xFFFFFFFEu) return refuse("count must be at most 4294967294");
    if (given.count != 0 && (given.x.data == nullptr || given.y.data == nullptr)) {
      return refuse("x and y must not be NULL");
    }
    const std::size_t n = given.count;
    const Column x(given.x, n), y(given.y, n), radius(given.radius, n), angle(given.angle, n);
    const Column vx(given.vx, n), vy(given.vy, n), omega(given.angular_velocity, n);
    psim::DiscBatch discs;
    discs.x = x.values();
    discs.y = y.values();
    discs.radius = given.radius.data != nullptr ? radius.values() : std::span<const double>(&given.common_radius, 1);
    discs.angle = angle.values();
    discs.vx = vx.values();
    discs.vy = vy.values();
    discs.angular_velocity = omega.values();
    discs.type = *type;
    discs.material = to_cpp(given.material);
    discs.material.tangent_speed = given.tangent_speed;
    discs.material.rolling_resistance = given.rolling_resistance;
    discs.mass = given.mass;
    discs.gravity_scale = given.gravity_scale;
    discs.fixed_rotation = given.fixed_rotation != 0;
    discs.bullet = given.bullet != 0;
    discs.filter = to_cpp(given.filter);
    std::string error;
    std::uint32_t begin = 0;
    world->changed([&](auto& w) { return w.add_discs(discs, begin, error); });
    if (!error.empty()) return call.fail(PSIM_ERROR_ARGUMENT, error);
    if (first != nullptr) *first = begin;
    return PSIM_OK;
  });
}

psim_result psim_world_remove_body(psim_world* world, psim_body_id id) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    return world->changed([&](auto& w) { return w.remove_body(to_cpp(id)); }) ? PSIM_OK : stale_body(call, id.index);
  });
}

int32_t psim_world_is_valid(const psim_world* world, psim_body_id id) {
  return asked(world, __func__, int32_t{0}, [id](const psim::World& w) -> int32_t { return w.is_valid(to_cpp(id)); });
}

psim_result psim_world_id_of(const psim_world* world, uint32_t index, psim_body_id* id) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (id == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "id must not be NULL");
    const psim::BodyId found = w.id_of(index);
    *id = to_c(found);
    return found == psim::kNoBody ? PSIM_NOTHING : PSIM_OK;
  });
}

psim_result psim_world_body(const psim_world* world, psim_body_id id, psim_body_state* state) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (state == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "state must not be NULL");
    const auto s = w.body(to_cpp(id));
    if (!s) return stale_body(call, id.index);
    *state = to_c(*s);
    return PSIM_OK;
  });
}

psim_result psim_world_set_transform(psim_world* world, psim_body_id id, psim_vec2 position, double angle) {
  return push(world, __func__, id, [&](auto& w) { return w.set_transform(to_cpp(id), to_cpp(position), angle); });
}

psim_result psim_world_set_velocity(psim_world* world, psim_body_id id, psim_vec2 velocity, double angular_velocity) {
  return push(world, __func__, id,
              [&](auto& w) { return w.set_velocity(to_cpp(id), to_cpp(velocity), angular_velocity); });
}

psim_result psim_world_apply_impulse(psim_world* world, psim_body_id id, psim_vec2 impulse) {
  return push(world, __func__, id, [&](auto& w) { return w.apply_impulse(to_cpp(id), to_cpp(impulse)); });
}

psim_result psim_world_apply_impulse_at(psim_world* world, psim_body_id id, psim_vec2 impulse, psim_vec2 point) {
  return push(world, __func__, id,
              [&](auto& w) { return w.apply_impulse_at(to_cpp(id), to_cpp(impulse), to_cpp(point)); });
}

psim_result psim_world_apply_angular_impulse(psim_world* world, psim_body_id id, double impulse) {
  return push(world, __func__, id, [&](auto& w) { return w.apply_angular_impulse(to_cpp(id), impulse); });
}

psim_result psim_world_centre_of_mass(const psim_world* world, psim_body_id id, psim_vec2* centre) {
  return tell(world, __func__, id, centre, [&](const psim::World& w) { return w.centre_of_mass(to_cpp(id)); });
}

psim_result psim_world_velocity_at(const psim_world* world, psim_body_id id, psim_vec2 point, psim_vec2* velocity) {
  return tell(world, __func__, id, velocity,
              [&](const psim::World& w) { return w.velocity_at(to_cpp(id), to_cpp(point)); });
}

psim_result psim_world_bounds_of(const psim_world* world, psim_body_id id, psim_bounds* bounds) {
  return tell(world, __func__, id, bounds, [&](const psim::World& w) { return w.bounds_of(to_cpp(id)); });
}

psim_result psim_world_shapes_of(psim_world* world, psim_body_id id, const psim_shape_part** parts, size_t* count) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (parts == nullptr || count == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "parts and count must not be NULL");
    }
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    const std::vector<psim::ShapePart> told = w.shapes_of(to_cpp(id));
    std::size_t corners = 0;
    for (const psim::ShapePart& part : told) corners += vertex_count(part.shape);
    world->parts.clear();
    world->parts.reserve(told.size());
    world->corners.resize(corners);
    psim_vec2* next = world->corners.data();
    for (const psim::ShapePart& part : told) {
      world->parts.push_back(to_c(part, next));
      next += vertex_count(part.shape);
    }
    *parts = world->parts.data();
    *count = world->parts.size();
    return PSIM_OK;
  });
}

psim_result psim_world_bounds_of_part(const psim_world* world, psim_body_id id, size_t number, psim_bounds* bounds) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (bounds == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "bounds must not be NULL");
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    const auto known = w.bounds_of_part(to_cpp(id), number);
    if (!known) return PSIM_NOTHING;
    *bounds = to_c(*known);
    return PSIM_OK;
  });
}

psim_result psim_world_set_body(psim_world* world, psim_body_id id, const psim_body_desc* desc) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_body_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    psim::BodyDesc body;
    std::string wrong = convert(given, body);
    if (wrong.empty() && world->changed([&](auto& one) { return one.set_body(to_cpp(id), body, wrong); })) {
      return PSIM_OK;
    }
    return call.fail(PSIM_ERROR_ARGUMENT, wrong);
  });
}

psim_result psim_world_apply_force(psim_world* world, psim_body_id id, psim_vec2 force) {
  const bool fits = psim::limits::kForce.contains(to_cpp(force));
  return push(
      world, __func__, id, [&](auto& w) { return w.apply_force(to_cpp(id), to_cpp(force)); }, fits);
}

psim_result psim_world_apply_force_at(psim_world* world, psim_body_id id, psim_vec2 force, psim_vec2 point) {
  const bool fits = psim::limits::kForce.contains(to_cpp(force)) && psim::limits::kCoordinate.contains(to_cpp(point));
  return push(
      world, __func__, id, [&](auto& w) { return w.apply_force_at(to_cpp(id), to_cpp(force), to_cpp(point)); }, fits);
}

psim_result psim_world_apply_torque(psim_world* world, psim_body_id id, double torque) {
  return push(
      world, __func__, id, [&](auto& w) { return w.apply_torque(to_cpp(id), torque); },
      psim::limits::kForce.contains(torque));
}

psim_result psim_world_explode(psim_world* world, const psim_explosion* explosion, size_t* pushed) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (explosion == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "explosion must not be NULL");
    if (explosion->reserved != 0) return call.fail(PSIM_ERROR_ARGUMENT, "reserved must be 0");
    const psim::Explosion given{to_cpp(explosion->position), explosion->radius, explosion->falloff,
                                explosion->impulse_per_length, explosion->mask};
    const auto found = world->changed([&](auto& w) { return w.explode(given); });
    if (pushed != nullptr) *pushed = found.value_or(0);
    if (found) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT,
                     "an explosion's radius and falloff must be 0 to 1e6 m, its impulse per length "
                     "-1e12 to 1e12 N s/m, its place -1e9 to 1e9 m");
  });
}

psim_result psim_world_set_enabled(psim_world* world, psim_body_id id, int32_t on) {
  return push(world, __func__, id, [&](auto& w) { return w.set_enabled(to_cpp(id), on != 0); });
}

int32_t psim_world_is_enabled(const psim_world* world, psim_body_id id) {
  return asked(world, __func__, int32_t{0}, [id](const psim::World& w) -> int32_t { return w.is_enabled(to_cpp(id)); });
}

psim_result psim_world_traits(const psim_world* world, psim_body_id id, psim_body_traits* traits) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "traits", traits); r != PSIM_OK) return r;
    const auto known = w.traits(to_cpp(id));
    if (!known) return stale_body(call, id.index);
    write(to_c(*known), traits);
    return PSIM_OK;
  });
}

psim_result psim_world_set_traits(psim_world* world, psim_body_id id, const psim_body_traits* traits) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_body_traits given;
    if (const psim_result r = read(call, "traits", traits, given); r != PSIM_OK) return r;
    psim::BodyTraits to;
    if (const std::string wrong = convert(given, to); !wrong.empty()) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    if (world->changed([&](auto& of) { return of.set_traits(to_cpp(id), to); })) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "body " + std::to_string(id.index) + " cannot have these traits");
  });
}

uint32_t psim_world_part_count(const psim_world* world, psim_body_id id) {
  return asked(world, __func__, uint32_t{0}, [id](const psim::World& w) { return w.part_count(to_cpp(id)); });
}

psim_result psim_world_part_traits(const psim_world* world, psim_body_id id, uint32_t part, psim_part_traits* traits) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "traits", traits); r != PSIM_OK) return r;
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    const auto known = w.part_traits(to_cpp(id), part);
    if (!known) return no_part(call, id.index, part);
    write(to_c(*known), traits);
    return PSIM_OK;
  });
}

psim_result psim_world_set_part_traits(psim_world* world, psim_body_id id, uint32_t part,
                                       const psim_part_traits* traits) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_part_traits given;
    if (const psim_result r = read(call, "traits", traits, given); r != PSIM_OK) return r;
    if (!w.is_valid(to_cpp(id))) return stale_body(call, id.index);
    if (part >= w.part_count(to_cpp(id))) return no_part(call, id.index, part);
    if (world->changed([&](auto& of) { return of.set_part_traits(to_cpp(id), part, to_cpp(given)); })) return PSIM_OK;
    const std::string which = "part " + std::to_string(part) + " of body " + std::to_string(id.index);
    return call.fail(PSIM_ERROR_ARGUMENT, which + " cannot have these traits");
  });
}

uint64_t psim_world_user_data(const psim_world* world, psim_body_id id) {
  return asked(world, __func__, uint64_t{0}, [id](const psim::World& w) { return w.user_data(to_cpp(id)); });
}

psim_result psim_world_set_user_data(psim_world* world, psim_body_id id, uint64_t value) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    const bool done = world->changed([&](auto& w) { return w.set_user_data(to_cpp(id), value); });
    return done ? PSIM_OK : stale_body(call, id.index);
  });
}

int32_t psim_world_is_awake(const psim_world* world, psim_body_id id) {
  return asked(world, __func__, int32_t{0}, [id](const psim::World& w) -> int32_t { return w.is_awake(to_cpp(id)); });
}

psim_result psim_world_wake(psim_world* world, psim_body_id id) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    return world->changed([&](auto& w) { return w.wake(to_cpp(id)); }) ? PSIM_OK : stale_body(call, id.index);
  });
}

size_t psim_world_why_awake(const psim_world* world, psim_body_id id, char* buffer, size_t capacity) {
  copy_text({}, buffer, capacity);
  return asked(world, __func__, size_t{0},
               [&](const psim::World& w) { return copy_text(w.why_awake(to_cpp(id)), buffer, capacity); });
}

size_t psim_world_body_count(const psim_world* world) {
  return asked(world, __func__, size_t{0}, [](const psim::World& w) { return w.body_count(); });
}

size_t psim_world_dynamic_count(const psim_world* world) {
  return asked(world, __func__, size_t{0}, [](const psim::World& w) { return w.dynamic_count(); });
}

size_t psim_world_static_count(const psim_world* world) {
  return asked(world, __func__, size_t{0}, [](const psim::World& w) { return w.static_count(); });
}

size_t psim_world_shape_count(const psim_world* world) {
  return asked(world, __func__, size_t{0}, [](const psim::World& w) { return w.shape_count(); });
}

uint64_t psim_world_escaped_total(const psim_world* world) {
  return asked(world, __func__, uint64_t{0}, [](const psim::World& w) { return w.escaped_total(); });
}
