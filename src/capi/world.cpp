// Worlds, their steps, and how they are run.
#include "psim/world.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "convert.h"
#include "structs.h"

using namespace psim::capi;

namespace {

psim_step_report report_of(const psim::StepReport& from) {
  psim_step_report r;
  psim_step_report_init(&r);
  for (std::size_t k = 0; k < psim::kStageCount; ++k) r.stage_ms[k] = from.stage_ms[k];
  r.total_ms = from.total_ms;
  r.pairs = from.pairs;
  r.contacts = from.contacts;
  r.colours = from.colours;
  r.awake = from.awake;
  r.asleep = from.asleep;
  r.pairs_reused = from.pairs_reused;
  r.rebuilt = from.rebuilt;
  r.stopped = from.stopped;
  r.skipped = from.skipped;
  r.fast = from.fast;
  r.renewed = from.renewed;
  r.escaped = from.escaped;
  r.quarantined = from.quarantined;
  r.arena_growths = from.arena_growths;
  const psim::StepDetail& d = from.detail;
  const int flags = (d.solves ? 0 : PSIM_STEP_WAITS) | (d.wakes ? PSIM_STEP_WAKES : 0) |
                    d.fluid_parts * PSIM_STEP_FLUID_PART | d.sweeps * PSIM_STEP_SWEEP;
  r.detail = {d.substeps, static_cast<std::uint8_t>(flags), d.frames, d.horizon, d.pieces};
  r.predicted_ms = from.predicted_ms;
  r.virial = from.virial;
  r.touching = from.touching;
  return r;
}

// Steps by advance(world) and writes the report, if there is one.
template <class Advance>
psim_result step(const Call& call, psim_step_report* report, const Advance& advance) {
  if (report != nullptr) {
    const psim_result result = check_output(call, "report", report);
    if (result != PSIM_OK) return result;
  }
  const psim::StepReport done = call.world->changed(advance);
  if (report != nullptr) write(report_of(done), report);
  if (done.no_room_for == nullptr) return PSIM_OK;
  const std::string what = done.no_room_for;
  psim::out_of_memory();  // this line says more
  for (const std::string_view done_without : {"events", "snapshot", "sleep", "escape"}) {
    if (what != done_without) continue;
    return call.fail(PSIM_ERROR_OUT_OF_MEMORY, "no room for the " + what + " of a step, which was done");
  }
  if (what != "motion") return call.fail(PSIM_ERROR_OUT_OF_MEMORY, "no room for " + what + "; the world is as before");
  call.world->broken = true;
  return call.fail(PSIM_ERROR_OUT_OF_MEMORY, "out of memory; the world can only be destroyed");
}

psim_result replay(const Call& call, psim_step_detail detail, double dt, psim_step_report* report) {
  using D = psim::StepDetail;
  static_assert(sizeof detail.flags == 1 && 255 / PSIM_STEP_SWEEP == D::kMostSweeps &&
                PSIM_STEP_SWEEP / PSIM_STEP_FLUID_PART - 1 == D::kMostFluidParts);
  const auto frames = [](int n) { return n >= 1 && n <= D::kMostFrames; };
  const int flags = detail.flags % PSIM_STEP_FLUID_PART, sweeps = detail.flags / PSIM_STEP_SWEEP;
  const int parts = detail.flags % PSIM_STEP_SWEEP / PSIM_STEP_FLUID_PART;
  if (detail.substeps > D::kMostSubsteps || !frames(detail.frames) || !frames(detail.horizon) ||
      flags == PSIM_STEP_WAKES || flags > (PSIM_STEP_WAITS | PSIM_STEP_WAKES)) {
    return call.fail(PSIM_ERROR_ARGUMENT, "substeps must be 0 to " + std::to_string(D::kMostSubsteps) +
                                              ", frames and horizon 1 to " + std::to_string(D::kMostFrames) +
                                              ", flags 0, 1 or 3 and a multiple of 4");
  }
  if (!(dt > 0 && dt <= 10)) {
    return call.fail(PSIM_ERROR_ARGUMENT, "dt must be above 0 and at most 10 s");
  }
  return step(call, report, [&](auto& one) {
    return one.replay(
        {detail.substeps, (flags & PSIM_STEP_WAITS) == 0, detail.frames, detail.horizon, detail.pieces,
         (flags & PSIM_STEP_WAKES) != 0, static_cast<std::uint8_t>(sweeps), static_cast<std::uint8_t>(parts)},
        dt);
  });
}

psim_result create(const Call& call, const psim_world_desc* desc, const psim_run_options* options) {
  psim_world_desc given;
  if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
  psim::WorldDesc world;
  const std::string wrong = convert(given, world);
  if (!wrong.empty()) return call.fail(PSIM_ERROR_ARGUMENT, wrong);
  psim::RunOptions run;
  if (const psim_result r = read_options(call, options, run); r != PSIM_OK) return r;
  std::string error;
  call.world->world = psim::World::create(world, run, error);
  if (call.world->world == nullptr) return call.fail(PSIM_ERROR_ARGUMENT, error);
  keep_fields(*call.world);
  return PSIM_OK;
}

// The present fields become these, unless something is wrong with them.
psim_result set_fields(psim_world& world, const std::vector<psim::Field>& given, std::string& wrong, const Call& call) {
  world.fields.reserve(given.size());  // keep_fields() needs no memory then
  world.media.reserve(given.size());
  if (!wrong.empty() || !world.changed([&](auto& w) { return w.set_fields(given, wrong); })) {
    return call.fail(PSIM_ERROR_ARGUMENT, wrong);
  }
  keep_fields(world);
  return PSIM_OK;
}

// One parallel_for of the engine on the caller's job system. Nothing may be thrown through the
// caller's code: it is kept, and thrown on the thread that steps.
struct HostLoop {
  const std::function<void(std::size_t)>& job;
  std::atomic<std::size_t> done{0};  // each job adds by release; read by acquire, it shows `error`, too
  std::atomic<bool> failed{false};   // chooses the one job that writes `error`
  std::exception_ptr error;
};

extern "C" void run_host_job(void* loop_pointer, size_t index) {
  auto& loop = *static_cast<HostLoop*>(loop_pointer);
  try {
    loop.job(index);
  } catch (...) {
    if (!loop.failed.exchange(true, std::memory_order_relaxed)) loop.error = std::current_exception();
  }
  loop.done.fetch_add(1, std::memory_order_release);
}

psim::JobSystem job_system(const psim_job_system& jobs) {
  psim::JobSystem out;
  out.workers = jobs.workers;
  out.parallel_for = [jobs](std::size_t count, const std::function<void(std::size_t)>& job) {
    HostLoop loop{job, {}, {}, {}};
    jobs.parallel_for(jobs.user, count, &run_host_job, &loop);
    const std::size_t done = loop.done.load(std::memory_order_acquire);  // before `error` is read
    if (loop.error) std::rethrow_exception(loop.error);
    if (done != count) {
      throw std::runtime_error("the job system ran " + std::to_string(done) + " jobs of " + std::to_string(count) +
                               "; the world can only be destroyed");
    }
  };
  return out;
}

}  // namespace

psim_result psim_world_create(const psim_world_desc* desc, const psim_run_options* options, psim_world** world,
                              char* error, size_t capacity) {
  return make_handle(__func__, world, error, capacity, [&](const Call& call) { return create(call, desc, options); });
}

void psim_world_destroy(psim_world* world) { delete world; }

size_t psim_last_error(const psim_world* world, char* buffer, size_t capacity) {
  if (world == nullptr) return copy_text({}, buffer, capacity);
  const std::lock_guard lock(world->error_mutex);
  return copy_text(world->error, buffer, capacity);
}

psim_result psim_world_step(psim_world* world, psim_step_report* report) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) {
    return step(call, report, [](auto& one) { return one.step(); });
  });
}

psim_result psim_world_step_by(psim_world* world, double dt, psim_step_report* report) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) {
    if (!(dt > 0 && dt <= 10)) {
      return call.fail(PSIM_ERROR_ARGUMENT, "dt must be above 0 and at most 10 s");
    }
    return step(call, report, [dt](auto& one) { return one.step(dt); });
  });
}

psim_result psim_world_replay(psim_world* world, psim_step_detail detail, psim_step_report* report) {
  return guarded(world, __func__,
                 [&](psim::World& w, const Call& call) { return replay(call, detail, w.desc().dt, report); });
}

psim_result psim_world_replay_by(psim_world* world, psim_step_detail detail, double dt, psim_step_report* report) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) { return replay(call, detail, dt, report); });
}

psim_result psim_world_prepare(psim_world* world) {
  return guarded(world, __func__, [](psim::World& w, const Call&) -> psim_result {
    w.prepare();
    return PSIM_OK;
  });
}

psim_result psim_world_set_max_bytes(psim_world* world, uint64_t bytes) {
  return guarded(world, __func__, [&](psim::World& w, const Call&) -> psim_result {
    w.set_max_bytes(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, SIZE_MAX)));
    return PSIM_OK;
  });
}

psim_result psim_world_set_gravity(psim_world* world, psim_vec2 gravity) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (world->changed([&](auto& w) { return w.set_gravity(to_cpp(gravity)); })) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "gravity must be finite");
  });
}

psim_result psim_world_set_fields(psim_world* world, const psim_field* fields, size_t count) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    std::vector<psim::Field> given;
    std::string wrong = convert(fields, count, given);
    std::ranges::copy_if(w.desc().fields, std::back_inserter(given), is_medium);
    return set_fields(*world, given, wrong, call);
  });
}

psim_result psim_world_set_media(psim_world* world, const psim_medium* media, size_t count) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    std::vector<psim::Field> given;
    std::ranges::copy_if(w.desc().fields, std::back_inserter(given), std::not_fn(is_medium));
    std::string wrong = convert(media, count, given);
    return set_fields(*world, given, wrong, call);
  });
}

psim_result psim_world_set_skin(psim_world* world, double factor) {
  return guarded(world, __func__, [&](psim::World&, const Call& call) -> psim_result {
    if (world->changed([&](auto& w) { return w.set_skin(factor); })) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "skin must be 0.25 to 4");
  });
}

psim_result psim_world_set_sleeping(psim_world* world, int32_t on) {
  return guarded(world, __func__, [world, on](psim::World&, const Call&) -> psim_result {
    world->changed([on](auto& w) { w.set_sleeping(on != 0); });
    return PSIM_OK;
  });
}

psim_result psim_world_set_governor(psim_world* world, const psim_governor_desc* desc) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    psim_governor_desc given;
    if (const psim_result r = read(call, "desc", desc, given); r != PSIM_OK) return r;
    psim_cost_model costs;
    set_defaults(costs);
    if (given.costs != nullptr) {
      if (const psim_result r = read(call, "costs", given.costs, costs); r != PSIM_OK) return r;
    }
    if (!(given.budget_ms > 0) || !std::isfinite(given.budget_ms)) {
      return call.fail(PSIM_ERROR_ARGUMENT, "budget_ms must be above 0 and finite");
    }
    if (w.set_governor({given.on != 0, given.budget_ms, to_cpp(costs)})) return PSIM_OK;
    return call.fail(PSIM_ERROR_ARGUMENT, "costs must be 0 or more, and finite");
  });
}

psim_result psim_world_set_pre_solve(psim_world* world, psim_pre_solve function, void* user) {
  return guarded(world, __func__, [&](psim::World&, const Call&) -> psim_result {
    psim::PreSolve asked;
    if (function != nullptr) {
      asked = [function, user](std::span<psim::NewContact> contacts) {
        std::vector<psim_new_contact> shown;
        shown.reserve(contacts.size());
        for (const psim::NewContact& c : contacts) shown.push_back(to_c(c));
        function(user, shown.data(), shown.size());
        for (std::size_t k = 0; k < shown.size(); ++k) take_answer(shown[k], contacts[k]);
      };
    }
    world->changed([&](auto& w) { w.set_pre_solve(std::move(asked)); });
    return PSIM_OK;
  });
}

psim_result psim_world_set_job_system(psim_world* world, const psim_job_system* jobs) {
  return guarded(world, __func__, [&](psim::World& w, const Call& call) -> psim_result {
    if (jobs == nullptr) {
      w.set_job_system({});
      return PSIM_OK;
    }
    psim_job_system given;
    if (const psim_result r = read(call, "jobs", jobs, given); r != PSIM_OK) return r;
    if (given.workers < 1) return call.fail(PSIM_ERROR_ARGUMENT, "workers must be 1 or more");
    w.set_job_system(given.parallel_for == nullptr ? psim::JobSystem{} : job_system(given));
    return PSIM_OK;
  });
}

psim_result psim_world_get_desc(const psim_world* world, psim_world_desc* desc) {
  return guarded(world, __func__, [&](const psim::World& w, const Call& call) -> psim_result {
    if (const psim_result r = check_output(call, "desc", desc); r != PSIM_OK) return r;
    const psim::WorldDesc& from = w.desc();
    psim_world_desc d;
    set_defaults(d);
    d.boundary = static_cast<int32_t>(from.boundary);
    d.bounds = to_c(from.bounds);
    d.gravity = to_c(from.gravity);
    d.linear_damping = from.linear_damping;
    d.wall = to_c(from.wall);
    d.fields = world->fields.data();
    d.field_count = world->fields.size();
    d.media = world->media.data();
    d.medium_count = world->media.size();
    d.dt = from.dt;
    d.substeps = from.substeps;
    d.integrator = static_cast<int32_t>(from.integrator);
    d.restitution_threshold = from.restitution_threshold;
    d.sleeping = from.sleeping;
    d.skin = from.skin;
    d.max_bytes = from.max_bytes;
    d.restitution_mixing = static_cast<std::int32_t>(from.mixing.restitution);
    d.friction_mixing = static_cast<std::int32_t>(from.mixing.friction);
    d.wall_tangent_speed = from.wall.tangent_speed;
    d.wall_rolling_resistance = from.wall.rolling_resistance;
    write(d, desc);
    return PSIM_OK;
  });
}

int32_t psim_world_isa(const psim_world* world) {
  return asked(world, __func__, int32_t{-1}, [](const psim::World& w) { return static_cast<int32_t>(w.isa()); });
}

int32_t psim_world_threads(const psim_world* world) {
  return asked(world, __func__, int32_t{0}, [](const psim::World& w) { return w.threads(); });
}

uint64_t psim_world_frame(const psim_world* world) {
  return asked(world, __func__, uint64_t{0}, [](const psim::World& w) { return w.frame(); });
}
