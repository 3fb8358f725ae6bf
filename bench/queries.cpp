// Questions to a pile of 100,000 discs that has run 120 frames, the index made beforehand:
//   Rays/<threads>          10,000 rays of up to 28 m by World::ray_cast_batch, wall time
//   ShapeCast/<shape>       casts of up to 7 m; turning: by 2 rad on the way
//   Mover                   moves of a character that runs to and fro over a terrain of 200 pieces
//   Geometry/<function>     calls about a box, a capsule and a point, without a world
// items_per_second: rays, casts or moves.
#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <vector>

#include "psim/geometry.h"
#include "psim/mover.h"
#include "psim/scene.h"
#include "workload.h"

namespace psim::bench {
namespace {

World* pile(int threads, std::string& error) {
  static std::unique_ptr<World> worlds[3];
  std::unique_ptr<World>& world = worlds[threads];
  if (world) return world.get();
  const auto scene = make_builtin("pile", 100'000, 1, error);
  if (scene) world = build_world(*scene, {best_isa(), threads}, error);
  for (int i = 0; world && i < 120; ++i) world->step();
  return world.get();
}

// Starts of rays and casts within the part of the world where the pile is, and their directions.
std::vector<RayInput> ways(const World& world, std::size_t n, double length) {
  const Bounds& b = world.desc().bounds;
  std::uint64_t random = 1;
  const auto uniform = [&](double low, double high) {  // a linear congruential generator (Knuth)
    random = random * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * static_cast<double>(random >> 11) * 0x1p-53;
  };
  std::vector<RayInput> out(n);
  for (RayInput& way : out) {
    way.from = {uniform(b.xmin, b.xmax), uniform(b.ymin, (b.ymin + b.ymax) / 2)};
    way.to = {way.from.x + uniform(-length, length), way.from.y + uniform(-length, length)};
  }
  return out;
}

void cast_rays(benchmark::State& state, int threads) {
  std::string error;
  World* world = pile(threads, error);
  if (world == nullptr) return state.SkipWithError(error.c_str());
  const std::vector<RayInput> rays = ways(*world, 10'000, 20);
  std::vector<RayHit> hits(rays.size());
  world->ray_cast_batch(rays, hits);
  for (auto _ : state) benchmark::DoNotOptimize(world->ray_cast_batch(rays, hits));
  state.SetItemsProcessed(static_cast<std::int64_t>(rays.size()) * static_cast<std::int64_t>(state.iterations()));
}

void cast_shapes(benchmark::State& state, const Shape& shape, double rotation) {
  std::string error;
  const World* world = pile(1, error);
  if (world == nullptr) return state.SkipWithError(error.c_str());
  QueryFilter filter;
  filter.enter_only = true;  // most casts start in a disc of the pile
  const std::vector<RayInput> all = ways(*world, 1'000, 5);
  for (auto _ : state) {
    for (const RayInput& way : all) {
      const Vec2 by{way.to.x - way.from.x, way.to.y - way.from.y};
      benchmark::DoNotOptimize(world->shape_cast(shape, way.from, 0.3, by, rotation, filter));
    }
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(all.size()) * static_cast<std::int64_t>(state.iterations()));
}

void move_character(benchmark::State& state) {
  std::string error;
  const auto world = World::create({}, {}, error);
  BodyDesc terrain;
  terrain.type = BodyType::static_body;
  ChainShape line;
  for (int k = 0; k <= 200; ++k) line.vertices.push_back({-100.0 + k, k % 7 * 0.2});
  terrain.shape = line;
  world->add_body(terrain, error);
  Mover mover({}, {0, 3});
  double speed = 5;
  for (auto _ : state) {
    if (mover.position().x > 90 || mover.position().x < -90) speed = mover.position().x > 0 ? -5 : 5;
    mover.move(*world, {speed, mover.velocity().y - 0.16}, 1.0 / 60);
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()));
}

// ask(box, capsule, pose) for poses around the box.
template <class Ask>
void ask_geometry(const char* name, const Ask& ask) {
  benchmark::RegisterBenchmark(name, [ask](benchmark::State& state) {
    const Shape box = BoxShape{1, 0.4, 0}, capsule = CapsuleShape{{0, -0.5}, {0, 0.5}, 0.2};
    int k = 0;
    for (auto _ : state) {
      k = (k + 1) % 1000;
      const double angle = 0.37 * k;
      benchmark::DoNotOptimize(ask(box, capsule, Pose{{-2 + 0.004 * k, 0.7}, angle}));
    }
  });
}

}  // namespace

void register_queries() {
  for (const int threads : {1, 2}) {
    benchmark::RegisterBenchmark(("Rays/" + std::to_string(threads)).c_str(),
                                 [threads](benchmark::State& s) { cast_rays(s, threads); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  const auto cast = [](const char* name, const Shape& shape, double rotation) {
    benchmark::RegisterBenchmark(name, [shape, rotation](benchmark::State& s) {
      cast_shapes(s, shape, rotation);
    })->Unit(benchmark::kMillisecond);
  };
  cast("ShapeCast/disc", DiscShape{0.2}, 0);
  cast("ShapeCast/capsule", CapsuleShape{{0, -0.5}, {0, 0.5}, 0.2}, 0);
  cast("ShapeCast/box", BoxShape{1, 0.4, 0}, 0);
  cast("ShapeCast/box_turning", BoxShape{1, 0.4, 0}, 2);
  benchmark::RegisterBenchmark("Mover", move_character);
  ask_geometry("Geometry/bounds", [](const Shape& a, const Shape&, const Pose& at) { return shape_bounds(a, at); });
  ask_geometry("Geometry/holds", [](const Shape& a, const Shape&, const Pose& at) { return shape_holds(a, at, {}); });
  ask_geometry("Geometry/ray", [](const Shape& a, const Shape&, const Pose& at) {
    return shape_ray_cast(a, at, {-3, 0.2}, {3, 0.8});
  });
  ask_geometry("Geometry/distance",
               [](const Shape& a, const Shape& b, const Pose& at) { return shape_distance(a, {}, b, at); });
  const auto fall = [](const Shape& a, const Shape& b, const Pose& at, double rotation) {
    const Pose above{{at.position.x, 5}, at.angle};
    return shape_cast(a, {above, {0, -9}, rotation}, b, {{}, {1, 0}, -rotation});
  };
  ask_geometry("Geometry/cast", [fall](const Shape& a, const Shape& b, const Pose& at) { return fall(a, b, at, 0); });
  ask_geometry("Geometry/cast_turning",
               [fall](const Shape& a, const Shape& b, const Pose& at) { return fall(a, b, at, 2); });
}

}  // namespace psim::bench
