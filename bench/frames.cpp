// Whole frames, Frame/<scene>/<isa>/<threads>: one World::step each. Gases have run 20 frames
// before, piles 120, by when the block has come down on itself. All rows of a scene run the same
// frames, hence the same work bit for bit. Times are wall times. Reported besides:
//   ns_per_element     wall time a frame / bodies
//   speedup_vs_scalar  against the scalar variant with as many threads (not for a million bodies)
//   contacts           touching pairs, mean of the frames
// near_clusters and far_clusters are two clouds of 5,000 discs 150 m and 100 km apart, far_diagonal such
// on a diagonal: what lies between bodies should cost nothing.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

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
  Vec2 apart = {};  ///< m: two clouds instead of a built-in scene
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
    {"near_clusters", nullptr, 10'000, 20, 180, false, {150, 0}},
    {"far_clusters", nullptr, 10'000, 20, 180, false, {1e5, 0}},
    {"far_diagonal", nullptr, 10'000, 20, 180, false, {1e5, 1e5}},
};

// Two squares of discs in an open world, half of the area of each free, up to 3 m/s an axis.
std::unique_ptr<World> two_clouds(std::uint64_t bodies, Vec2 apart, RunOptions options, std::string& error) {
  WorldDesc desc;
  desc.bounds = {-2e5, -2e5, 2e5, 2e5};
  desc.boundary = Boundary::open;
  desc.gravity = {0, 0};
  auto world = World::create(desc, options, error);
  const auto columns = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(bodies / 2)));
  std::vector<double> x, y, vx, vy, radius(bodies, 0.5);
  std::uint64_t random = 1;
  const auto uniform = [&](double size) {  // a linear congruential generator (Knuth)
    random = random * 6364136223846793005u + 1442695040888963407u;
    return size * (static_cast<double>(random >> 11) * 0x1p-52 - 1);
  };
  for (std::uint64_t k = 0; k < bodies; ++k) {
    const std::uint64_t i = k / 2 % columns, j = k / 2 / columns;
    const double side = k % 2 == 0 ? -0.5 : 0.5;
    x.push_back(side * apart.x + 1.414 * static_cast<double>(i) + uniform(0.1));
    y.push_back(side * apart.y + 1.414 * static_cast<double>(j) + uniform(0.1));
    vx.push_back(uniform(3));
    vy.push_back(uniform(3));
  }
  DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.vx = vx;
  batch.vy = vy;
  batch.radius = radius;
  std::uint32_t first = 0;
  if (!world || world->add_discs(batch, first, error) != bodies) return nullptr;
  return world;
}

std::unique_ptr<World> warm_world(const FrameScene& scene, Isa isa, int threads, std::string& error) {
  std::unique_ptr<World> world;
  if (scene.builtin == nullptr) {
    world = two_clouds(scene.bodies, scene.apart, {isa, threads}, error);
  } else if (const auto made = make_builtin(scene.builtin, scene.bodies, 1, error)) {
    world = build_world(*made, {isa, threads}, error);
  }
  if (world) {
    for (int i = 0; i < scene.warm_frames; ++i) world->step();
  }
  return world;
}

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

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
  state.SetItemsProcessed(static_cast<std::int64_t>(scene.bodies) * static_cast<std::int64_t>(state.iterations()));
  state.counters["ns_per_element"] = 1e9 * frame_s / bodies;
  state.counters["contacts"] = contacts / static_cast<double>(state.iterations());
  if (scene.all_isas) state.counters["speedup_vs_scalar"] = scalar / frame_s;
}

}  // namespace

void register_frames() {
  for (const FrameScene& scene : kScenes) {
    for (const int threads : {1, 2}) {
      for (const Isa isa : kAllIsas) {
        if (!scene.all_isas && isa != best_isa()) continue;
        const std::string name =
            std::string("Frame/") + scene.name + "/" + std::string(isa_name(isa)) + "/" + std::to_string(threads);
        benchmark::RegisterBenchmark(name.c_str(),
                                     [scene, isa, threads](benchmark::State& s) { run_frames(s, scene, isa, threads); })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->Iterations(scene.frames);
      }
    }
  }
}

}  // namespace psim::bench
