// Saved states.
#include "psim/saved_state.h"

#include <cstring>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

namespace {

std::span<const std::byte> bytes(const void* data, std::size_t size) {
  return {static_cast<const std::byte*>(data), size};
}

psim_result fill(const Call& call, std::span<const std::byte> from, void* buffer, std::size_t capacity,
                 std::size_t* size) {
  *size = from.size();
  if (buffer == nullptr) return PSIM_OK;
  if (capacity < from.size()) {
    return call.fail(PSIM_ERROR_ARGUMENT, "the buffer has room for " + std::to_string(capacity) + " bytes of " +
                                              std::to_string(from.size()));
  }
  std::memcpy(buffer, from.data(), from.size());
  return PSIM_OK;
}

psim_result null_refused(const Call& call) {
  return call.fail(PSIM_ERROR_ARGUMENT, "only the buffer to fill may be NULL");
}

}  // namespace

psim_result psim_world_save(psim_world* world, const void** state, size_t* size) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (state == nullptr || size == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "state and size must not be NULL");
    }
    w.save(world->state);
    *state = world->state.data();
    *size = world->state.size();
    return PSIM_OK;
  });
}

psim_result psim_world_restore(psim_world* world, const void* state, size_t size) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (state == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "state must not be NULL");
    if (world->recorder) {
      return call.fail(PSIM_ERROR_ARGUMENT, "a recording is under way, which cannot hold a restore; stop it first");
    }
    std::string error;
    if (!w.restore(bytes(state, size), error)) return call.fail(PSIM_ERROR_ARGUMENT, error);
    keep_fields(*world);
    return PSIM_OK;
  });
}

psim_result psim_world_from_state(const void* state, size_t size, const psim_run_options* options, psim_world** world,
                                  char* error, size_t error_capacity) {
  return make_handle(__func__, world, error, error_capacity, [&](const Call& call) -> psim_result {
    if (state == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "state must not be NULL");
    psim::RunOptions run;
    if (const psim_result r = read_options(call, options, run); r != PSIM_OK) return r;
    std::string wrong;
    call.world->world = psim::World::from_state(bytes(state, size), run, wrong);
    if (call.world->world == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    keep_fields(*call.world);
    return PSIM_OK;
  });
}

psim_result psim_pack_state(const void* state, size_t state_size, void* packed, size_t capacity, size_t* size) {
  return alone(__func__, nullptr, 0, [&](const Call& call) -> psim_result {
    if (state == nullptr || size == nullptr) return null_refused(call);
    return fill(call, psim::pack_state(bytes(state, state_size)), packed, capacity, size);
  });
}

psim_result psim_unpack_state(const void* packed, size_t packed_size, void* state, size_t capacity, size_t* size,
                              char* error, size_t error_capacity) {
  return alone(__func__, error, error_capacity, [&](const Call& call) -> psim_result {
    if (packed == nullptr || size == nullptr) return null_refused(call);
    std::vector<std::byte> out;
    std::string wrong;
    if (!psim::unpack_state(bytes(packed, packed_size), out, wrong)) {
      return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    }
    return fill(call, out, state, capacity, size);
  });
}

psim_result psim_write_state(const char* path, const void* state, size_t state_size, char* error,
                             size_t error_capacity) {
  return alone(__func__, error, error_capacity, [&](const Call& call) -> psim_result {
    if (path == nullptr || state == nullptr) return null_refused(call);
    std::string wrong;
    if (psim::write_state(path, bytes(state, state_size), wrong)) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, wrong);
  });
}

psim_result psim_read_state(const char* path, void* state, size_t capacity, size_t* size, char* error,
                            size_t error_capacity) {
  return alone(__func__, error, error_capacity, [&](const Call& call) -> psim_result {
    if (path == nullptr || size == nullptr) return null_refused(call);
    std::vector<std::byte> out;
    std::string wrong;
    if (!psim::read_state(path, out, wrong)) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    return fill(call, out, state, capacity, size);
  });
}
