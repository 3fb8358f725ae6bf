#include "options/scene_choice.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

// A line like "MemAvailable:   12345 kB" of /proc/meminfo or /proc/self/status.
std::uint64_t kib_line(const char* file, std::string_view key, std::uint64_t if_missing) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t digit = line.find_first_of("0123456789");
    if (digit != std::string::npos) return 1024 * std::stoull(line.substr(digit));
  }
  return if_missing;
}

// What this process may still take: of the machine, of its control group, of its own limit.
std::uint64_t available_bytes() {
  std::uint64_t available = kib_line("/proc/meminfo", "MemAvailable:", kUnlimited);
  std::uint64_t group = 0;
  if (std::ifstream limit("/sys/fs/cgroup/memory.max"); limit >> group) {
    available = std::min(available, group);
  }
  struct rlimit own = {};
  if (::getrlimit(RLIMIT_AS, &own) == 0 && own.rlim_cur != RLIM_INFINITY) {
    const std::uint64_t used = kib_line("/proc/self/status", "VmSize:", 0);
    available = std::min<std::uint64_t>(available, own.rlim_cur - std::min<std::uint64_t>(used, own.rlim_cur));
  }
  return available;
}

Scene builtin_scene(const Options& options) {
  std::string error;
  std::optional<Scene> scene =
      make_builtin(options.scene, options.particles.value_or(0), options.seed.value_or(1), error);
  if (!scene) throw UserError(fmt::format("--scene {}: {}", options.scene, one_line(error)));
  return std::move(*scene);
}

Scene file_scene(const Options& options) {
  std::error_code ignored;
  if (!std::filesystem::exists(options.scene, ignored)) {
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
  if (scene->name.empty()) scene->name = std::filesystem::path(options.scene).stem().string();
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
  return scene;
}

void check_memory(const Scene& scene) {
  // Columns of x, y, radius, vx, vy live while the bodies are placed.
  constexpr std::uint64_t kPlacementBytesPerBody = 5 * sizeof(double);
  const std::uint64_t bodies = scene.body_count();
  const std::uint64_t needed = estimate_memory_bytes(bodies) + bodies * kPlacementBytesPerBody;
  const std::uint64_t available = available_bytes();
  if (needed > available) {
    throw UserError(fmt::format("scene {}: {} bodies need {} bytes ({}), and {} are free", one_line(scene.name),
                                grouped(bodies), needed, bytes_text(needed), bytes_text(available)));
  }
}

std::unique_ptr<World> make_world(const Scene& scene, Isa isa, int threads) {
  RunOptions run;
  run.isa = isa;
  run.threads = threads;
  std::string error;
  std::unique_ptr<World> world = build_world(scene, run, error);
  if (!world) throw UserError(fmt::format("scene {}: {}", one_line(scene.name), one_line(error)));
  return world;
}

}  // namespace psim::cli
