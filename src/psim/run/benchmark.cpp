// Rows of one table run the same frames of the same scene, so they do the same work bit for bit.
// How many frames that is, the slowest row finds out: it goes first and stops at kMostSeconds.
#include "run/benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "options/scene_choice.h"
#include "os/interrupt.h"
#include "output/text.h"
#include "output/user_error.h"
#include "psim/version.h"
#include "report/samples.h"

namespace psim::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kMostFrames = 200;
constexpr std::uint64_t kFewestFrames = 3;
constexpr double kMostSeconds = 1.5;  // a row, warm-up not counted
constexpr std::uint64_t kWarmUpFrames = 10;

// Medians over the frames of one row.
struct Timing {
  std::uint64_t frames = 0;
  double frame_ms = 0;
  std::array<double, kStageCount> stage_ms{};
  std::size_t memory_bytes = 0;
};

// Runs kWarmUpFrames and then `frames` frames, or as many as fit into kMostSeconds if not given.
Timing measure(const Scene& scene, Isa isa, int threads, std::optional<std::uint64_t> frames) {
  const auto world = make_world(scene, isa, threads);
  for (std::uint64_t frame = 0; frame < kWarmUpFrames && !os::interrupted(); ++frame) world->step();
  Samples total;
  std::array<Samples, kStageCount> stages;
  const Clock::time_point start = Clock::now();
  const auto wants_more = [&] {
    if (os::interrupted()) return false;
    if (frames) return total.count() < *frames;
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return total.count() < kFewestFrames || (total.count() < kMostFrames && seconds < kMostSeconds);
  };
  while (wants_more()) {
    const Clock::time_point begin = Clock::now();
    const StepReport step = world->step();
    total.add(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    for (std::size_t i = 0; i < kStageCount; ++i) stages[i].add(step.stage_ms[i]);
  }
  Timing timing;
  timing.frames = total.count();
  timing.frame_ms = total.percentile(50);
  for (std::size_t i = 0; i < kStageCount; ++i) timing.stage_ms[i] = stages[i].percentile(50);
  timing.memory_bytes = world->memory_bytes();
  return timing;
}

std::string ratio(double over, double under) { return under > 0 ? fmt::format("{:.2f}x", over / under) : "-"; }

double per_body(double value, std::uint64_t bodies) { return bodies > 0 ? value / static_cast<double>(bodies) : 0; }

// 1k, 10k, 100k, and what was asked for.
std::vector<std::uint64_t> particle_counts(const Options& options) {
  std::set<std::uint64_t> counts = {1'000, 10'000, 100'000};
  if (options.particles) {
    counts.insert(*options.particles);
    if (*options.particles > 1'000'000) counts.insert(1'000'000);
  }
  return {counts.begin(), counts.end()};
}

void table_by_particles(const Options& options) {
  print_out(fmt::format("\nBy particle count, {}, {} threads\n{:>11}{:>11}{:>13}{:>10}{:>12}{:>9}\n",
                        isa_name(options.isa), options.threads, "particles", "ms", "ns/particle", "fps", "bytes each",
                        "frames"));
  const auto row = [&](const Scene& scene) {
    check_memory(scene);
    const std::uint64_t bodies = scene.body_count();
    const Timing timing = measure(scene, options.isa, options.threads, options.frames);
    if (timing.frames == 0) return;
    print_out(fmt::format("{:>11}{:>11.4f}{:>13.1f}{:>10.0f}{:>12.0f}{:>9}\n", grouped(bodies), timing.frame_ms,
                          per_body(timing.frame_ms * 1e6, bodies), timing.frame_ms > 0 ? 1000 / timing.frame_ms : 0,
                          per_body(static_cast<double>(timing.memory_bytes), bodies), timing.frames));
  };
  if (!is_sized(options.scene)) {
    row(choose_scene(options));
    return;
  }
  for (const std::uint64_t count : particle_counts(options)) {
    if (os::interrupted()) return;
    Options sized = options;
    sized.particles = count;
    std::optional<Scene> scene;
    try {
      scene = choose_scene(sized);
    } catch (const UserError& error) {
      if (options.particles == count) throw;
      fmt::print(stderr, "psim: {} particles left out: {}\n", grouped(count), error.what());
      continue;
    }
    row(*scene);
  }
}

void table_by_threads(const Options& options, const Scene& scene) {
  std::vector<int> counts;
  for (int threads = 1; threads < options.threads; threads *= 2) counts.push_back(threads);
  counts.push_back(options.threads);
  print_out(fmt::format("\nBy threads, {}, {} bodies\n{:>11}{:>11}{:>11}{:>13}{:>9}\n", isa_name(options.isa),
                        grouped(scene.body_count()), "threads", "ms", "speed-up", "efficiency", "frames"));
  std::optional<Timing> one;
  for (const int threads : counts) {
    const Timing timing = measure(scene, options.isa, threads, one ? std::optional(one->frames) : options.frames);
    if (os::interrupted() || timing.frames == 0) return;
    if (!one) one = timing;
    const double speed_up = timing.frame_ms > 0 ? one->frame_ms / timing.frame_ms : 1;
    print_out(fmt::format("{:>11}{:>11.4f}{:>10.2f}x{:>11.1f} %{:>9}\n", threads, timing.frame_ms, speed_up,
                          100 * speed_up / threads, timing.frames));
  }
}

void table_by_isa(const Options& options, const Scene& scene) {
  std::vector<std::pair<Isa, Timing>> columns;
  for (const Isa isa : kAllIsas) {
    if (!isa_available(isa)) {
      fmt::print(stderr, "psim: {} left out: this CPU lacks it\n", isa_name(isa));
      continue;
    }
    const auto frames = columns.empty() ? options.frames : std::optional(columns[0].second.frames);
    columns.emplace_back(isa, measure(scene, isa, 1, frames));
    if (os::interrupted() || columns.back().second.frames == 0) return;
  }
  std::string text = fmt::format("\nBy instruction set, 1 thread, {} bodies, {} frames\n{:<14}",
                                 grouped(scene.body_count()), columns[0].second.frames, "stage");
  for (const auto& [isa, timing] : columns) {
    text += fmt::format("{:>11}", fmt::format("{} ms", isa_name(isa)));
  }
  for (std::size_t i = 1; i < columns.size(); ++i) {
    text += fmt::format("{:>10}", isa_name(columns[i].first));
  }
  text += '\n';
  const auto row = [&](std::string_view name, const auto& ms_of) {
    text += fmt::format("{:<14}", name);
    for (const auto& column : columns) text += fmt::format("{:>11.4f}", ms_of(column.second));
    for (std::size_t i = 1; i < columns.size(); ++i) {
      text += fmt::format("{:>10}", ratio(ms_of(columns[0].second), ms_of(columns[i].second)));
    }
    text += '\n';
  };
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    row(kStageNames[stage], [stage](const Timing& timing) { return timing.stage_ms[stage]; });
  }
  row("whole frame", [](const Timing& timing) { return timing.frame_ms; });
  print_out(text);
}

}  // namespace

int benchmark_scene(const Options& options) {
  os::catch_interrupts();
  const Scene scene = choose_scene(options);
  check_memory(scene);
  print_out(fmt::format("psim {}  scene {}  median of the frames after {} warm-up frames\n", PSIM_VERSION_STRING,
                        one_line(scene.name), kWarmUpFrames));
  table_by_particles(options);
  if (!os::interrupted()) table_by_threads(options, scene);
  if (!os::interrupted()) table_by_isa(options, scene);
  if (os::interrupted()) fmt::print(stderr, "psim: interrupted\n");
  return 0;
}

}  // namespace psim::cli
