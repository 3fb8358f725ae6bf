// Whole frames, Frame/<scene>/<isa>/<threads>: one World::step each. Gases have run 20 frames
// before, piles 120, by when the block has come down on itself. All rows of a scene run the same
// frames, hence the same work bit for bit. Times are wall times. Reported besides:
//   ns_per_element     wall time a frame / bodies
//   speedup_vs_scalar  against the scalar variant with as many threads (not for a million bodies)
//   contacts           touching pairs, mean of the frames
#include <benchmark/benchmark.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "psim/scene.h"
#include "workload.h"

namespace psim::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct FrameScene {
  const char* name;
  const char* builtin;
  std::uint64_t bodies;
  int warm_frames;
  int frames;
  bool all_isas;
};

constexpr FrameScene kScenes[] = {
    {"discs", "discs", 100'000, 20, 120, true},
    {"pile", "pile", 100'000, 120, 60, true},
    {"rough-pile", "rough-pile", 100'000, 120, 60, true},
    {"million", "million", 1'000'000, 20, 20, false},
    {"pile-million", "pile", 1'000'000, 120, 10, false},
    {"large_pyramid", "large_pyramid", 5'050, 60, 120, true},
    {"many_pyramids", "many_pyramids", 22'000, 60, 60, true},
    {"joint_grid", "joint_grid", 10'000, 20, 120, true},
    {"tumbler", "tumbler", 2'025, 120, 120, false},
    {"boxes_into_discs", "boxes_into_discs", 50'000, 120, 60, false},
};

std::unique_ptr<World> warm_world(const FrameScene& scene, Isa isa, int threads,
                                  std::string& error) {
  const auto made = make_builtin(scene.builtin, scene.bodies, 1, error);
  auto world = made ? build_world(*made, {isa, threads}, error) : nullptr;
  if (world) {
    for (int i = 0; i < scene.warm_frames; ++i) world->step();
  }
  return world;
}

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Seconds a frame with scalar kernels: from the scalar row if it ran before, else measured here.
double& scalar_frame(const FrameScene& scene, int threads) {
  static std::map<std::pair<std::string, int>, double> seconds;
  return seconds[{scene.name, threads}];
}

void run_frames(benchmark::State& state, const FrameScene& scene, Isa isa, int threads) {
  if (!isa_available(isa)) {
    state.SkipWithError(("skipped: this CPU lacks " + std::string(isa_name(isa))).c_str());
    return;
  }
  if (threads > 1 && std::thread::hardware_concurrency() < static_cast<unsigned>(threads)) {
    state.SkipWithError("skipped: this machine has too few cores");
    return;
  }
  std::string error;
  double& scalar = scalar_frame(scene, threads);
  if (scene.all_isas && isa != Isa::scalar && scalar == 0) {
    const auto world = warm_world(scene, Isa::scalar, threads, error);
    const auto begin = Clock::now();
    for (int i = 0; world && i < scene.frames; ++i) world->step();
    scalar = seconds_since(begin) / scene.frames;
  }
  const auto world = warm_world(scene, isa, threads, error);
  if (!world) {
    state.SkipWithError(error.c_str());
    return;
  }
  double contacts = 0;
  const auto begin = Clock::now();
  for (auto _ : state) contacts += static_cast<double>(world->step().contacts);
  const double frame_s = seconds_since(begin) / static_cast<double>(state.iterations());
  if (isa == Isa::scalar) scalar = frame_s;
  const auto bodies = static_cast<double>(scene.bodies);
  state.SetItemsProcessed(static_cast<std::int64_t>(scene.bodies) *
                          static_cast<std::int64_t>(state.iterations()));
  state.counters["ns_per_element"] = 1e9 * frame_s / bodies;
  state.counters["contacts"] = contacts / static_cast<double>(state.iterations());
  if (scene.all_isas) state.counters["speedup_vs_scalar"] = scalar / frame_s;
}

}  // namespace

void register_frames() {
  for (const FrameScene& scene : kScenes) {
    for (const int threads : {1, 2}) {
      for (const Isa isa : kAllIsas) {
        if (!scene.all_isas && isa != Isa::avx2) continue;
        const std::string name = std::string("Frame/") + scene.name + "/" +
                                 std::string(isa_name(isa)) + "/" + std::to_string(threads);
        benchmark::RegisterBenchmark(
            name.c_str(),
            [scene, isa, threads](benchmark::State& s) { run_frames(s, scene, isa, threads); })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->Iterations(scene.frames);
      }
    }
  }
}

}  // namespace psim::bench
