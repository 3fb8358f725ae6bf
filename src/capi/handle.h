// What a psim_world* points to, and the guard that every function of the C API runs in: no exception
// leaves it, and every failure leaves one line. The C API sees include/psim only.
#pragma once

#include <psim.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "psim/recording.h"
#include "psim/world.h"

/// The world, its last error, and copies of what C cannot see in place.
struct psim_world {
  std::unique_ptr<psim::World> world;
  std::atomic<bool> broken{false};  // something threw: what is inside is not known, and nothing of it is read any more

  // Fixed room: an error must be kept where there is no memory.
  static constexpr std::size_t kErrorRoom = 512;
  mutable std::mutex error_mutex;
  char error[kErrorRoom] = "";

  std::vector<psim_field> fields;
  std::vector<psim_medium> media;
  std::vector<psim_touch_event> begin, end, sensor_begin, sensor_end;
  std::vector<psim_hit_event> hits;
  std::vector<double> hit_impulses;
  std::vector<psim_parts> hit_parts, contact_parts;
  std::vector<uint32_t> sensor_begin_parts, sensor_end_parts;
  std::vector<psim_joint_break> breaks;
  std::vector<psim_touch_point> begin_points;
  std::vector<psim_body_id> fell_asleep, woke;
  std::vector<psim_move_event> moves;
  std::vector<psim_fluid_event> fluid_begin, fluid_end;
  std::vector<psim::PlanEntry> plan_text;
  std::vector<psim_plan_entry> plan;
  std::vector<size_t> plan_bytes;
  std::vector<psim::LaneUse> lane_names;
  std::vector<psim_lane_use> lane_use;
  std::vector<std::pair<std::string, std::uint64_t>> skipped_text;
  std::vector<psim_skip_entry> skipped;
  std::vector<psim_trace_event> trace;
  std::vector<psim_contact> contacts;
  std::vector<psim_contact_group> contact_groups;
  std::vector<psim_shape_part> parts;
  std::vector<psim_vec2> corners;  // of parts
  std::vector<psim_fluid_particle> particles;
  std::vector<std::byte> state, recording;
  std::unique_ptr<psim::Recorder> recorder;  // where a recording is under way

  /// change(world), written down where a recording is under way.
  template <class Change>
  auto changed(const Change& change) {
    return recorder ? change(*recorder) : change(*world);
  }
};

namespace psim::capi {

/// Where the call is, for its line.
struct Call {
  psim_world* world;
  const char* name;

  /// Keeps "name: what" as the world's last error.
  psim_result fail(psim_result result, std::string_view what) const noexcept;
};

/// Copies text as the header says; the length of all of it.
std::size_t copy_text(std::string_view text, char* buffer, std::size_t capacity) noexcept;

inline constexpr std::string_view kNothingDone = "out of memory; nothing was done";

/// Turns what body() throws into a result. Want of memory does not break the world: the engine answers it with values,
/// and std::bad_alloc comes from the copies that are made for C alone.
template <class Body>
psim_result caught(const Call& call, const Body& body) noexcept {
  psim::out_of_memory();  // forgets what earlier calls found
  try {
    const psim_result result = body();
    return psim::out_of_memory() ? call.fail(PSIM_ERROR_OUT_OF_MEMORY, kNothingDone) : result;
  } catch (const std::bad_alloc&) {
    return call.fail(PSIM_ERROR_OUT_OF_MEMORY, kNothingDone);
  } catch (const std::exception& e) {
    call.world->broken = true;
    return call.fail(PSIM_ERROR_INTERNAL, e.what());
  } catch (...) {
    call.world->broken = true;
    return call.fail(PSIM_ERROR_INTERNAL, "something threw that is no std::exception");
  }
}

/// For functions without a world: its line goes to the caller. body(call) may throw.
template <class Body>
psim_result alone(const char* name, char* error, std::size_t capacity, const Body& body) noexcept {
  copy_text({}, error, capacity);
  psim_world scratch;
  const Call call{&scratch, name};
  const psim_result result = caught(call, [&] { return body(call); });
  if (result < 0) copy_text(scratch.error, error, capacity);
  return result;
}

/// Runs body(world, call), which returns a psim_result, on a world that is whole.
template <class Body>
psim_result guarded(const psim_world* handle, const char* name, const Body& body) noexcept {
  if (handle == nullptr) return PSIM_ERROR_ARGUMENT;
  // Only the error and the broken flag are written through a const handle.
  const Call call{const_cast<psim_world*>(handle), name};
  if (handle->broken) {
    return call.fail(PSIM_ERROR_BROKEN_WORLD, "the world broke before and can only be destroyed");
  }
  return caught(call, [&] { return body(*call.world->world, call); });
}

/// Makes a handle, lets fill(call) put a world into it, and gives it out in `*world`; where that fails
/// `error` has its line.
template <class Fill>
psim_result make_handle(const char* name, psim_world** world, char* error, std::size_t capacity,
                        const Fill& fill) noexcept {
  copy_text({}, error, capacity);
  if (world == nullptr) return PSIM_ERROR_ARGUMENT;
  *world = nullptr;
  std::unique_ptr<psim_world> handle(new (std::nothrow) psim_world);
  if (handle == nullptr) {
    copy_text("out of memory", error, capacity);
    return PSIM_ERROR_OUT_OF_MEMORY;
  }
  const Call call{handle.get(), name};
  const psim_result result = caught(call, [&] { return fill(call); });
  if (result == PSIM_OK) {
    *world = handle.release();
  } else {
    copy_text(handle->error, error, capacity);
  }
  return result;
}

/// The same for functions that answer with a number: `none` where there is no answer.
template <class Value, class Body>
Value asked(const psim_world* handle, const char* name, Value none, const Body& body) noexcept {
  Value value = none;
  const psim_result result = guarded(handle, name, [&](const psim::World& world, const Call&) -> psim_result {
    value = body(world);
    return PSIM_OK;
  });
  return result == PSIM_OK ? value : none;
}

}  // namespace psim::capi
