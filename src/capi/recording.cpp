// Recordings, and what runs them.
#include "psim/recording.h"

#include "structs.h"

using namespace psim::capi;

/// A replay, and its world as C sees it.
struct psim_replay {
  std::unique_ptr<psim::Replay> replay;
  psim_world handle;

  psim_replay() = default;
  psim_replay(const psim_replay&) = delete;
  psim_replay& operator=(const psim_replay&) = delete;
  ~psim_replay() { static_cast<void>(handle.world.release()); }  // it is the replay's
};

psim_result psim_world_record(psim_world* world, uint64_t every) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (every < 1) return call.fail(PSIM_ERROR_ARGUMENT, "every must be at least 1");
    world->recorder = std::make_unique<psim::Recorder>(w, every);
    return PSIM_OK;
  });
}

psim_result psim_world_recording(psim_world* world, const void** recording, size_t* size) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (recording == nullptr || size == nullptr) {
      return call.fail(PSIM_ERROR_ARGUMENT, "recording and size must not be NULL");
    }
    *recording = nullptr;
    *size = 0;
    if (!world->recorder) return PSIM_NOTHING;
    world->recording = world->recorder->recording();
    *recording = world->recording.data();
    *size = world->recording.size();
    return PSIM_OK;
  });
}

psim_result psim_world_stop_recording(psim_world* world) {
  return guarded(world, __func__, [&](psim::World&, const Call&) -> psim_result {
    if (!world->recorder) return PSIM_NOTHING;
    world->recorder.reset();
    return PSIM_OK;
  });
}

psim_result psim_replay_open(const void* recording, size_t size, const psim_run_options* options, psim_replay** replay,
                             char* error, size_t error_capacity) {
  copy_text({}, error, error_capacity);
  if (replay == nullptr) return PSIM_ERROR_ARGUMENT;
  *replay = nullptr;
  std::unique_ptr<psim_replay> made(new (std::nothrow) psim_replay);
  if (made == nullptr) {
    copy_text("out of memory", error, error_capacity);
    return PSIM_ERROR_OUT_OF_MEMORY;
  }
  const Call call{&made->handle, __func__};
  const psim_result result = caught(call, [&]() -> psim_result {
    if (recording == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, "recording must not be NULL");
    psim::RunOptions run;
    if (const psim_result r = read_options(call, options, run); r != PSIM_OK) return r;
    std::string wrong;
    made->replay = psim::Replay::open({static_cast<const std::byte*>(recording), size}, run, wrong);
    if (made->replay == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
    made->handle.world.reset(&made->replay->world());
    keep_fields(made->handle);
    return PSIM_OK;
  });
  if (result == PSIM_OK) {
    *replay = made.release();
  } else {
    copy_text(made->handle.error, error, error_capacity);
  }
  return result;
}

void psim_replay_close(psim_replay* replay) { delete replay; }

psim_result psim_replay_next(psim_replay* replay) {
  return guarded(
      replay != nullptr ? &replay->handle : nullptr, __func__,
      [&](psim::World&, const Call&) -> psim_result { return replay->replay->next() ? PSIM_OK : PSIM_NOTHING; });
}

psim_world* psim_replay_world(psim_replay* replay) { return replay != nullptr ? &replay->handle : nullptr; }

uint64_t psim_replay_steps(const psim_replay* replay) { return replay != nullptr ? replay->replay->steps() : 0; }

uint64_t psim_replay_steps_in_all(const psim_replay* replay) {
  return replay != nullptr ? replay->replay->steps_in_all() : 0;
}

uint64_t psim_replay_hashes(const psim_replay* replay) { return replay != nullptr ? replay->replay->hashes() : 0; }

int32_t psim_replay_complete(const psim_replay* replay) {
  return replay != nullptr && replay->replay->complete() ? 1 : 0;
}

uint64_t psim_replay_differs_at(const psim_replay* replay) {
  return replay != nullptr ? replay->replay->differs_at() : 0;
}
