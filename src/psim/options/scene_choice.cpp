#include "options/scene_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/machine.h"
#include "base/os.h"
#include "os/console.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

Scene builtin_scene(const Options& options) {
  std::string error;
  std::optional<Scene> scene =
      make_builtin(options.scene, options.particles.value_or(0), options.seed.value_or(1), error);
  if (!scene) throw UserError(fmt::format("--scene {}: {}", options.scene, one_line(error)));
  return std::move(*scene);
}

Scene file_scene(const Options& options) {
  std::error_code ignored;
  if (!exists(os::path_of(options.scene), ignored)) {
    std::vector<std::string> names;
    for (const BuiltinScene& scene : builtin_scenes()) names.emplace_back(scene.name);
    const std::string hint = did_you_mean(options.scene, names);
    throw UserError(fmt::format("--scene {}: no such file and no built-in scene{}", one_line(options.scene),
                                hint.empty() ? " (psim --list-scenes)" : hint));
  }
  if (options.particles) {
    throw UserError(fmt::format("--particles {}: is for built-in scenes; {} says itself how many bodies it has",
                                *options.particles, one_line(options.scene)));
  }
  std::string error;
  std::optional<Scene> scene = load_scene(options.scene, error);
  if (!scene) throw UserError(one_line(error));
  for (const std::string& note : scene->notes) {
    fmt::print(stderr, "psim: {}: {}\n", one_line(options.scene), one_line(note));
  }
  if (scene->name.empty()) scene->name = os::name_of(os::path_of(options.scene).stem());
  if (options.seed) scene->seed = *options.seed;
  return std::move(*scene);
}

}  // namespace

bool is_builtin(const std::string& name) {
  return std::ranges::any_of(builtin_scenes(), [&](const BuiltinScene& scene) { return scene.name == name; });
}

bool is_sized(const std::string& name) {
  return std::ranges::any_of(builtin_scenes(),
                             [&](const BuiltinScene& scene) { return scene.name == name && scene.sized; });
}

Scene choose_scene(const Options& options) {
  Scene scene = is_builtin(options.scene) ? builtin_scene(options) : file_scene(options);
  if (options.dt_s) scene.world.dt = *options.dt_s;
  if (options.substeps) scene.world.substeps = *options.substeps;
  if (options.integrator) scene.world.integrator = *options.integrator;
  if (options.sleep) scene.world.sleeping = *options.sleep;
  if (options.skin) scene.world.skin = *options.skin;
  scene.world.max_bytes = static_cast<std::size_t>(options.memory_bytes);
  return scene;
}

namespace {

// What a scene may take, and a text of it.
std::pair<std::uint64_t, std::string> most_memory(const Scene& scene) {
  const std::uint64_t free = os::available_bytes(), allowed = scene.world.max_bytes;
  const std::uint64_t most = allowed != 0 ? std::min(free, allowed) : free;
  return {most, bytes_text(most) + (most < free ? " are allowed by --memory" : " are free")};
}

}  // namespace

void check_memory(const Scene& scene) {
  // Columns of x, y, radius, vx, vy live while the bodies are placed.
  constexpr std::uint64_t kPlacementBytesPerBody = 5 * sizeof(double);
  const std::uint64_t bodies = scene.body_count();
  const std::uint64_t needed = estimate_memory_bytes(bodies) + bodies * kPlacementBytesPerBody;
  const auto [most, text] = most_memory(scene);
  if (needed > most) {
    throw UserError(fmt::format("scene {}: {} bodies need {} bytes ({}) of memory, and {}", one_line(scene.name),
                                grouped(bodies), needed, bytes_text(needed), text));
  }
}

std::string memory_warning(const Scene& scene) {
  const SceneForecast needs = forecast(scene);
  const auto [most, text] = most_memory(scene);
  const std::string what =
      fmt::format("{} bodies with about {} pairs of near ones", grouped(needs.bodies), grouped(needs.pairs));
  if (needs.pairs > SceneForecast::kMostPairs) {
    return fmt::format("{}: lists hold at most {}; spread them out", what, grouped(SceneForecast::kMostPairs));
  }
  if (needs.bytes <= most) return {};
  return fmt::format("{} will take about {} of memory, and {}; spread them out", what, bytes_text(needs.bytes), text);
}

void say_if_threads_lack(const World& world, int asked) {
  if (!kHasThreads || world.threads() >= asked) return;
  fmt::print(stderr, "psim: the system has no room for {} threads; the world runs on {}\n", asked, world.threads());
}

std::unique_ptr<World> make_world(const Scene& scene, Isa isa, int threads) {
  RunOptions run;
  run.isa = isa;
  run.threads = threads;
  std::string error;
  std::unique_ptr<World> world = build_world(scene, run, error);
  if (!world) throw UserError(fmt::format("scene {}: {}", one_line(scene.name), one_line(error)));
  say_if_threads_lack(*world, threads);
  return world;
}

}  // namespace psim::cli
