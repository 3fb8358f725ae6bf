#include "options/about.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "options/scene_choice.h"
#include "output/text.h"
#include "psim/version.h"

namespace psim::cli {
namespace {

std::string_view build_type() {
  constexpr std::string_view kByCMake = PSIM_BUILD_TYPE;
  return kByCMake.empty() ? "unnamed" : kByCMake;
}

}  // namespace

std::string compiler_name() {
#if defined(__clang__)
  return fmt::format("clang++ {}.{}.{}", __clang_major__, __clang_minor__, __clang_patchlevel__);
#elif defined(_MSC_VER)
  return fmt::format("MSVC {}", _MSC_FULL_VER);
#else
  return fmt::format("g++ {}.{}.{}", __GNUC__, __GNUC_MINOR__, __GNUC_PATCHLEVEL__);
#endif
}

int print_version() {
  std::string compiled, available;
  for (const Isa isa : kAllIsas) {
    if (isa_lanes(isa) != 0) compiled += fmt::format(" {}", isa_name(isa));
    if (isa_available(isa)) available += fmt::format(" {}", isa_name(isa));
  }
  print_out(fmt::format("psim {}\ncompiler {}\nbuild {}\nISAs compiled in:{}\nISAs of this CPU:{}\n",
                        PSIM_VERSION_STRING, compiler_name(), build_type(), compiled, available));
  return 0;
}

int print_scenes() {
  std::size_t width = 0;
  for (const BuiltinScene& scene : builtin_scenes()) width = std::max(width, scene.name.size());
  std::string text;
  for (const BuiltinScene& scene : builtin_scenes()) {
    fmt::format_to(std::back_inserter(text), "{:<{}}  {:>9}  {}\n", scene.name, width, grouped(scene.default_particles),
                   scene.description);
  }
  print_out(text);
  return 0;
}

int explain_scene(const Options& options) {
  const Scene scene = choose_scene(options);
  check_memory(scene);
  const auto world = make_world(scene, options.isa, 1);
  world->step();  // what it owns then
  const std::vector<PlanEntry> plan = world->plan();
  std::size_t width = std::string_view("stage").size();
  for (const PlanEntry& entry : plan) width = std::max(width, entry.stage.size());
  std::string text =
      fmt::format("psim {}  scene {}  {} bodies ({} dynamic, {} static)\n", PSIM_VERSION_STRING, one_line(scene.name),
                  grouped(world->body_count()), grouped(world->dynamic_count()), grouped(world->static_count()));
  fmt::format_to(std::back_inserter(text), "{:<{}}  needed  {:>13}  reason\n", "stage", width, "own bytes");
  std::size_t bytes = 0;
  for (const PlanEntry& entry : plan) {
    bytes += entry.bytes;
    // A stage that runs works on something: 0 would read as if it took no memory.
    const std::string own = entry.needed && entry.bytes == 0 ? "-" : grouped(entry.bytes);
    fmt::format_to(std::back_inserter(text), "{:<{}}  {:<6}  {:>13}  {}\n", entry.stage, width,
                   entry.needed ? "yes" : "no", own, entry.reason);
  }
  fmt::format_to(std::back_inserter(text),
                 "{} of {} bytes after a step are for one stage alone; - has none of its own, but works on the bodies, "
                 "lists and contacts that stages share\n",
                 grouped(bytes), grouped(world->memory_bytes()));
  print_out(text);
  return 0;
}

int check_scene_file(const Options& options) {
  const Scene scene = choose_scene(options);
  check_memory(scene);
  std::vector<std::string> warnings = check_scene(scene);
  if (std::string line = memory_warning(scene); !line.empty()) warnings.push_back(std::move(line));
  std::string text;
  for (const std::string& warning : warnings) {
    fmt::format_to(std::back_inserter(text), "{}: {}\n", one_line(scene.name), one_line(warning));
  }
  if (warnings.empty()) text = fmt::format("{}: nothing to warn of\n", one_line(scene.name));
  print_out(text);
  return warnings.empty() ? 0 : 1;
}

}  // namespace psim::cli
