// Characters that walk through a world.
#include "psim/mover.h"

#include <algorithm>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

struct psim_mover {
  psim::Mover mover;
};

namespace {

psim_result read_desc(const Call& call, const psim_mover_desc* desc, psim::MoverDesc& out) {
  psim_mover_desc given;
  if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
  out = {given.radius,      given.half_height, to_cpp(given.up), given.slope_limit,
         given.step_height, given.skin,        given.push_force, {}};
  if (const psim_result r = read_filter(call, given.filter, out.filter); r != PSIM_OK) return r;
  return psim::Mover::sound(out) ? PSIM_OK : call.fail(PSIM_ERROR_ARGUMENT, "a number of desc is out of its range");
}

}  // namespace

psim_result psim_mover_create(const psim_mover_desc* desc, psim_vec2 position, psim_mover** mover, char* error,
                              size_t capacity) {
  if (mover != nullptr) *mover = nullptr;
  return alone(__func__, error, capacity, [&](const Call& call) -> psim_result {
    if (mover == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "mover must not be NULL");
    psim::MoverDesc given;
    if (const psim_result r = read_desc(call, desc, given); r != PSIM_OK) return r;
    psim::Mover made(given);
    if (!made.set_position(to_cpp(position))) return call.fail(PSIM_ERROR_ARGUMENT, "position is out of its range");
    *mover = new psim_mover{made};
    return PSIM_OK;
  });
}

void psim_mover_destroy(psim_mover* mover) { delete mover; }

psim_result psim_mover_copy(const psim_mover* from, psim_mover* to) {
  if (from == nullptr || to == nullptr) return PSIM_ERROR_ARGUMENT;
  *to = *from;
  return PSIM_OK;
}

psim_result psim_mover_move(psim_mover* mover, psim_world* world, psim_vec2 velocity, double dt) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (mover == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "mover must not be NULL");
    if (mover->mover.move(w, to_cpp(velocity), dt, world->recorder.get())) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "velocity, dt or the place is out of its range");
  });
}

psim_result psim_mover_set_position(psim_mover* mover, psim_vec2 position) {
  if (mover == nullptr) return PSIM_ERROR_ARGUMENT;
  return mover->mover.set_position(to_cpp(position)) ? PSIM_OK : PSIM_ERROR_ARGUMENT;
}

psim_result psim_mover_set_desc(psim_mover* mover, const psim_mover_desc* desc) {
  if (mover == nullptr) return PSIM_ERROR_ARGUMENT;
  return alone(__func__, nullptr, 0, [&](const Call& call) -> psim_result {
    psim::MoverDesc given;
    const psim_result r = read_desc(call, desc, given);
    if (r == PSIM_OK) mover->mover.set_desc(given);
    return r;
  });
}

psim_result psim_mover_get_state(const psim_mover* mover, psim_mover_state* state) {
  if (mover == nullptr) return PSIM_ERROR_ARGUMENT;
  return alone(__func__, nullptr, 0, [&](const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "state", state); r != PSIM_OK) return r;
    psim_mover_state out;
    psim_mover_state_init(&out);
    const psim::Mover& m = mover->mover;
    const psim::MoverGround ground = m.ground().value_or(psim::MoverGround{psim::BodyId{0, 0}, {}, {}, {}});
    out.on_ground = m.on_ground();
    out.position = to_c(m.position());
    out.velocity = to_c(m.velocity());
    out.ground = to_c(ground.body);
    out.ground_point = to_c(ground.point);
    out.ground_normal = to_c(ground.normal);
    out.ground_velocity = to_c(ground.velocity);
    out.squeezed = m.squeezed();
    write(out, state);
    return PSIM_OK;
  });
}

psim_result psim_mover_touches(const psim_mover* mover, psim_mover_touch* touches, size_t capacity, size_t* count) {
  if (mover == nullptr || count == nullptr || (touches == nullptr && capacity != 0)) return PSIM_ERROR_ARGUMENT;
  const auto from = mover->mover.touches();
  for (std::size_t k = 0; k < std::min(capacity, from.size()); ++k) {
    touches[k] = {to_c(from[k].body), to_c(from[k].point), to_c(from[k].normal)};
  }
  *count = from.size();
  return PSIM_OK;
}
