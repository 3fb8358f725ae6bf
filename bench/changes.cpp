// Changes of a world that runs:
//   RemoveBodies/<what>     100,000 at once by World::remove_bodies: of a pile awake, and of one that sleeps
//   Stream/<what>           10,000 static segments that come and go far from 20,000 discs: as one chain, as a body each
//   StepAfter/<what>        the step after they came
// Time of one change.
#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "psim/psim.h"

namespace psim::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPile = 100'000, kCrowd = 20'000, kSegments = 10'000;

std::unique_ptr<World> world_of(int discs, bool sleeps, std::vector<BodyId>& ids) {
  WorldDesc desc;
  desc.boundary = Boundary::open;
  desc.bounds = kOpenBounds;
  desc.sleeping = sleeps;
  if (sleeps) desc.gravity = {0, 0};
  std::string error;
  auto world = World::create(desc, {best_isa(), 1}, error);
  BodyDesc disc;
  disc.material.friction = 0.5;
  for (int k = 0; world && k < discs; ++k) {
    disc.position = {k % 1000 * 1.01, 0.5 + k / 1000 * 1.01};
    ids.push_back(world->add_body(disc, error));
  }
  BodyDesc ground;
  ground.type = BodyType::static_body;
  ground.shape = SegmentShape{{1500, 0}, {-500, 0}};
  if (world) world->add_body(ground, error);
  for (int k = 0; world && k < 3; ++k) world->step();
  // Bodies fall asleep some thousand at a time.
  const auto awake = [&] {
    for (const BodyId id : ids) {
      if (world->is_awake(id)) return true;
    }
    return false;
  };
  for (int k = 0; world && sleeps && k < 200 && awake(); ++k) {
    for (int n = 0; n < 50; ++n) world->step();
  }
  return world;
}

void remove_bodies(benchmark::State& state, bool sleeps) {
  std::vector<std::byte> before;
  std::vector<BodyId> ids;
  std::string error;
  const auto world = world_of(kPile, sleeps, ids);
  if (!world) return state.SkipWithError("no world");
  world->save(before);
  for (auto _ : state) {
    if (!world->restore(before, error)) return state.SkipWithError(error.c_str());
    const auto begin = Clock::now();
    benchmark::DoNotOptimize(world->remove_bodies(ids));
    state.SetIterationTime(std::chrono::duration<double>(Clock::now() - begin).count());
  }
}

std::vector<BodyDesc> region(bool chain) {
  BodyDesc body;
  body.type = BodyType::static_body;
  std::vector<Vec2> points;
  for (int k = 0; k <= kSegments; ++k) points.push_back({3000 - 0.1 * k, 0.01 * (k % 7)});
  std::vector<BodyDesc> all;
  if (chain) {
    body.shape = ChainShape{points};
    return {body};
  }
  for (std::size_t k = 0; k < kSegments; ++k) {
    body.shape = SegmentShape{points[k], points[k + 1]};
    all.push_back(body);
  }
  return all;
}

enum class Part { come, step, go };

void stream(benchmark::State& state, bool chain, Part part) {
  std::vector<BodyId> ids, came;
  std::string error;
  const auto world = world_of(kCrowd, false, ids);
  if (!world) return state.SkipWithError("no world");
  const std::vector<BodyDesc> bodies = region(chain);
  for (auto _ : state) {
    came.clear();
    const auto begin = Clock::now();
    for (const BodyDesc& body : bodies) came.push_back(world->add_body(body, error));
    const auto there = Clock::now();
    world->step();
    const auto stepped = Clock::now();
    world->remove_bodies(came);
    const auto gone = Clock::now();
    world->step();
    const auto took = part == Part::come ? there - begin : part == Part::step ? stepped - there : gone - stepped;
    state.SetIterationTime(std::chrono::duration<double>(took).count());
  }
}

}  // namespace

void register_changes() {
  const auto set = [](benchmark::internal::Benchmark* b) { b->UseManualTime()->Unit(benchmark::kMillisecond); };
  set(benchmark::RegisterBenchmark("RemoveBodies/awake", [](benchmark::State& s) { remove_bodies(s, false); }));
  set(benchmark::RegisterBenchmark("RemoveBodies/asleep", [](benchmark::State& s) { remove_bodies(s, true); }));
  for (const bool chain : {true, false}) {
    const std::string name = chain ? "chain" : "segments";
    const auto add = [&](const std::string& what, Part part) {
      set(benchmark::RegisterBenchmark(what.c_str(), [=](benchmark::State& s) { stream(s, chain, part); }));
    };
    add("Stream/add_" + name, Part::come);
    add("Stream/remove_" + name, Part::go);
    add("StepAfter/" + name, Part::step);
  }
}

}  // namespace psim::bench
