// One run from options to report. Only World::step is inside the timed span: diagnostics, files,
// trace and progress happen between frames and cost the figures nothing. Loading ends with
// World::prepare; there is no hidden warm-up: the first frames count.
#include "run/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>

#include "options/scene_choice.h"
#include "os/console.h"
#include "os/interrupt.h"
#include "output/text.h"
#include "output/user_error.h"
#include "picture/film.h"
#include "picture/image.h"
#include "psim/recording.h"
#include "psim/saved_state.h"
#include "report/csv.h"
#include "report/run_report.h"
#include "report/trace.h"
#include "run/details.h"
#include "run/outputs.h"
#include "run/progress.h"
#include "run/replay.h"

namespace psim::cli {
namespace {

using Clock = std::chrono::steady_clock;

RunReport begin_report(const Options& options, const Scene& scene, const World& world) {
  RunReport report;
  report.scene = scene.name;
  report.isa = world.isa();
  report.threads = world.threads();
  report.frames_wanted = options.frame_count();
  report.dt_s = world.desc().dt;
  report.substeps = world.desc().substeps;
  report.seed = scene.seed;
  report.budget_ms = options.budget_ms;
  report.bodies_awake = world.dynamic_count();
  report.frame_ms.reserve(report.frames_wanted);
  for (Samples& phase : report.phase_ms) phase.reserve(report.frames_wanted);
  report.start = world.diagnostics();
  if (!scene.fluids.empty()) report.fluid = world.fluid_report();
  return report;
}

// Returns the substeps that the governor saved in the frame.
std::uint64_t add_frame(RunReport& report, double total_ms, const StepReport& step, std::uint64_t frame) {
  report.frame_ms.add(total_ms);
  if (total_ms > report.budget_ms) ++report.frames_over_budget;
  const auto phases = phase_ms(step);
  for (std::size_t i = 0; i < kPhaseCount; ++i) report.phase_ms[i].add(phases[i]);
  report.pairs_sum += static_cast<double>(step.pairs);
  report.contacts_sum += static_cast<double>(step.contacts);
  report.touching_sum += static_cast<double>(step.touching);
  report.colours_sum += step.colours;
  report.neighbour_rebuilds += step.rebuilt ? 1 : 0;
  report.virial += step.virial;
  const bool nobody_moved = report.bodies_awake == 0 && step.awake == 0;
  report.bodies_awake = step.awake;
  report.bodies_asleep = step.asleep;
  report.asleep_sum += static_cast<double>(step.asleep);
  report.reused_sum += static_cast<double>(step.pairs_reused);
  report.lists_kept += step.rebuilt ? 0 : 1;
  report.frames_renewed += step.renewed != 0;
  report.renewed_sum += step.renewed;
  report.fast_frames += step.fast != 0;
  report.fast_sum += step.fast;
  for (std::size_t k = 0; k < kSkipNames.size(); ++k) report.frames_skipped[k] += step.skipped >> k & 1;
  if (step.quarantined > 0 && report.quarantined == 0) report.first_quarantine_frame = frame;
  report.quarantined += step.quarantined;
  report.frames_few_parts += step.detail.fluid_parts != 0;
  if (nobody_moved) return 0;
  const int done = step.detail.waits() ? 0 : step.detail.substeps;
  report.frames_waited += step.detail.waits();
  report.frames_few_sweeps += step.detail.sweeps != 0;
  ++report.frames_waiting;
  if (!step.detail.waits()) {
    report.frames_lost += report.frames_waiting - std::min<std::uint64_t>(report.frames_waiting, step.detail.frames);
    report.frames_waiting = 0;
  }
  report.frames_cut += done < report.substeps && !step.detail.waits();
  const auto saved = static_cast<std::uint64_t>(std::max(report.substeps - done, 0));
  report.substeps_saved += saved;
  return saved;
}

void end_report(RunReport& report, const World& world) {
  report.bodies_total = world.body_count();
  report.bodies_dynamic = world.dynamic_count();
  report.bodies_static = world.static_count();
  report.lanes = world.lane_counts();
  if (report.profile) report.profile->lanes = world.lane_use();
  report.end = world.diagnostics();
  if (report.fluid) report.fluid = world.fluid_report();
  report.escaped = world.escaped_total();
  report.skipped = world.skipped();
  report.memory_bytes = world.memory_bytes();
  report.state_hash = world.state_hash();
}

void run_frames(RunReport& report, World& world, OutputFiles& files, std::uint64_t every, Film* film,
                const std::vector<StepDetail>& replayed, Recorder* recorder) {
  const auto one_step = [&](std::uint64_t frame) {
    if (frame <= replayed.size()) {
      return recorder ? recorder->replay(replayed[frame - 1]) : world.replay(replayed[frame - 1]);
    }
    return recorder ? recorder->step() : world.step();
  };
  std::optional<TraceWriter> trace;
  if (files.trace) trace.emplace(*files.trace, world);
  if (files.metrics) write_metrics_header(*files.metrics);
  if (files.governor_log) write_details_header(*files.governor_log);
  if (files.trajectory) {
    write_trajectory_header(*files.trajectory);
    write_trajectory_rows(*files.trajectory, 0, world.published());
  }
  if (film != nullptr) film->after(0, world);
  Progress progress(one_line(report.scene), report.frames_wanted);
  for (std::uint64_t frame = 1; frame <= report.frames_wanted && !os::interrupted(); ++frame) {
    const bool looked_at = report.profile && report.profile->looks_at(frame);
    if (looked_at) world.start_trace();
    std::uint64_t faults = files.metrics ? os::page_faults() : 0;
    const Clock::time_point begin = Clock::now();
    const StepReport step = one_step(frame);
    const Clock::time_point end = Clock::now();
    if (files.metrics) faults = os::page_faults() - faults;
    if (step.no_room_for != nullptr) {
      throw UserError(fmt::format("frame {}: no memory for {}; the world holds {}, and {} are allowed (--memory)",
                                  frame, step.no_room_for, bytes_text(world.memory_bytes()),
                                  bytes_text(world.desc().max_bytes)));
    }
    const double total_ms = std::chrono::duration<double, std::milli>(end - begin).count();

    const std::uint64_t saved = add_frame(report, total_ms, step, frame);
    if (files.governor_log) write_details_row(*files.governor_log, frame, step.detail);
    if (files.metrics) {
      write_metrics_row(*files.metrics, frame, total_ms, step, saved, faults, world.diagnostics());
    }
    if (files.trajectory && frame % every == 0) {
      write_trajectory_rows(*files.trajectory, frame, world.published());
    }
    if (film != nullptr) film->after(frame, world);
    std::vector<TraceEvent> spans;
    if (trace || looked_at) spans = world.take_trace();
    if (looked_at && !trace) world.stop_trace();
    if (trace) trace->frame(frame, begin, end, step, spans);
    if (report.profile) report.profile->add(step, looked_at ? &spans : nullptr);
    progress.update(frame, end);
  }
  if (trace) trace->finish();
}

std::string_view text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void write_files(OutputFiles& files, const Scene& scene, const PictureOptions& pictures, Film* film, World& world,
                 const Recorder* recorder) {
  if (files.save) {
    std::vector<std::byte> state;
    world.save(state);
    files.save->write(text_of(pack_state(state)));
  }
  if (files.record) files.record->write(text_of(recorder->recording()));
  if (files.state) write_state(*files.state, world.published());
  if (files.fluid_state) {
    std::vector<FluidParticleState> particles;
    world.fluid_particles(particles);
    write_particles(*files.fluid_state, particles);
  }
  if (files.image) {
    Moment moment;
    take_moment(world, moment, pictures.colouring, joints_of(scene));
    write_image(*files.image, scene, moment, pictures, world.threads());
  }
  for (std::optional<AtomicFile>* file :
       {&files.state, &files.fluid_state, &files.metrics, &files.trajectory, &files.image, &files.trace,
        &files.governor_log, &files.save, &files.record}) {
    if (*file) (*file)->commit();
  }
  if (film != nullptr) film->finish();
}

void say_what_was_odd(const RunReport& report) {
  if (report.frame_ms.count() < report.frames_wanted) {
    fmt::print(stderr, "psim: interrupted after frame {} of {}\n", report.frame_ms.count(), report.frames_wanted);
  }
  if (report.quarantined > 0) {
    fmt::print(stderr,
               "psim: {} bodies had numbers that are not finite or out of range and were frozen, "
               "the first in frame {}\n",
               report.quarantined, report.first_quarantine_frame);
  }
}

}  // namespace

int run_scene(const Options& options) {
  os::catch_interrupts();
  Scene scene = choose_scene(options);
  check_memory(scene);
  const std::optional<Target> target = apply_target(options, scene);
  std::vector<StepDetail> replayed;
  if (!options.governor_replay.empty()) replayed = read_details(options.governor_replay);
  OutputFiles files(options);
  std::optional<Film> film;
  if (options.pictures.is_film()) {
    film.emplace(options.pictures, scene, files.video ? &*files.video : nullptr, options.threads);
  }
  Film* const pictures = film ? &*film : nullptr;
  const auto world =
      options.restore.empty() ? make_world(scene, options.isa, options.threads) : restored_world(options);
  if (options.governor) {
    const CostModel costs =
        World::measure_costs({options.isa, options.threads}, world->dynamic_count(), world->shape_count());
    world->set_governor({true, options.budget_ms, costs});
  }
  world->prepare();
  std::optional<Recorder> recorder;
  if (files.record) recorder.emplace(*world);

  RunReport report = begin_report(options, scene, *world);
  if (options.profile) {
    report.profile.emplace(world->threads(), report.frames_wanted);
    world->count_lane_use();
  }
  report.governed = options.governor || !replayed.empty();
  report.target = target;
  Recorder* const recording = recorder ? &*recorder : nullptr;
  run_frames(report, *world, files, options.every, pictures, replayed, recording);
  end_report(report, *world);

  say_what_was_odd(report);
  print_out(options.report == ReportFormat::json ? report_json(report) : report_text(report));
  write_files(files, scene, options.pictures, pictures, *world, recording);
  return 0;
}

}  // namespace psim::cli
