// World::save and World::restore, Save/<state>/<threads> and Restore/<state>/<threads>: 100,000 equal
// discs of a pile that may not sleep, while they fall (20 frames), as they land (250, 400: pairs are saved by name;
// 700: and where lists were made) and at rest (1,500), when lists last; and of the same pile that may sleep, once at
// least half of it or all does (half_asleep, asleep). Reported besides:
//   bytes_per_disc     of the saved state
//   of_memcpy          time / that of a memcpy of as many bytes, measured in the same process
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "psim/scene.h"
#include "workload.h"

namespace psim::bench {
namespace {

constexpr std::uint64_t kDiscs = 100'000;

struct Moment {
  const char* name;
  int frames;
  double asleep;  // the share that sleeps then, or earlier; 0: nobody may
};
constexpr Moment kMoments[] = {{"falling", 20, 0},   {"landing", 250, 0},  {"landed", 400, 0},
                               {"settling", 700, 0}, {"at_rest", 1500, 0}, {"half_asleep", 5000, 0.5},
                               {"asleep", 5000, 1}};

// The pile then, made once a process. Null, with `error`, if it cannot be made.
World* pile_at(const Moment& moment, int threads, std::string& error) {
  static std::map<std::pair<const char*, int>, std::unique_ptr<World>> worlds;
  std::unique_ptr<World>& world = worlds[{moment.name, threads}];
  if (world) return world.get();
  auto scene = make_builtin("pile", kDiscs, 1, error);
  if (!scene) return nullptr;
  scene->world.sleeping = moment.asleep > 0;
  world = build_world(*scene, {best_isa(), threads}, error);
  const double enough = moment.asleep > 0 ? moment.asleep * kDiscs : 2.0 * kDiscs;
  for (int i = 0; world && i < moment.frames; ++i) {
    if (static_cast<double>(world->step().asleep) >= enough) break;
  }
  return world.get();
}

// Seconds for a memcpy of as many bytes, the least of 20.
double memcpy_seconds(const std::vector<std::byte>& bytes) {
  std::vector<std::byte> copy(bytes.size());
  double least = 1;
  for (int i = 0; i < 20; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    std::memcpy(copy.data(), bytes.data(), bytes.size());
    benchmark::DoNotOptimize(copy.data());
    benchmark::ClobberMemory();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    least = std::min(least, took.count());
  }
  return least;
}

void run_state(benchmark::State& state, const Moment& moment, int threads, bool restoring) {
  std::string error;
  World* const world = pile_at(moment, threads, error);
  if (world == nullptr) {
    state.SkipWithError(error.c_str());
    return;
  }
  std::vector<std::byte> bytes;
  world->save(bytes);
  const double copy = memcpy_seconds(bytes);
  const auto begin = std::chrono::steady_clock::now();
  for (auto _ : state) {
    if (!restoring) {
      world->save(bytes);
    } else if (!world->restore(bytes, error)) {
      state.SkipWithError(error.c_str());
      return;
    }
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const auto turns = static_cast<double>(state.iterations());
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes.size()));
  state.counters["bytes_per_disc"] = static_cast<double>(bytes.size()) / kDiscs;
  state.counters["of_memcpy"] = took.count() / turns / copy;
}

}  // namespace

void register_states() {
  for (const bool restoring : {false, true}) {
    for (const Moment& moment : kMoments) {
      for (const int threads : {1, 2}) {
        const std::string name =
            std::string(restoring ? "Restore/" : "Save/") + moment.name + "/" + std::to_string(threads);
        benchmark::RegisterBenchmark(
            name.c_str(),
            [&moment, threads, restoring](benchmark::State& s) { run_state(s, moment, threads, restoring); })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
      }
    }
  }
}

}  // namespace psim::bench
