#include "options/settings_options.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <thread>
#include <vector>

#include "base/os.h"
#include "os/console.h"
#include "output/text.h"
#include "output/user_error.h"
#include "psim/limits.h"

namespace psim::cli {
namespace {

constexpr int kMostThreads = static_cast<int>(limits::kThreads.max);

// "auto, scalar, ... or simd128": all of them, also those that this build lacks.
std::string isa_choices() {
  std::string text = "auto";
  for (const Isa isa : kAllIsas) {
    text += isa == std::end(kAllIsas)[-1] ? " or " : ", ";
    text += isa_name(isa);
  }
  return text;
}

// "scalar, sse, avx2": what a build for x86-64 has.
std::string isas_built_in() {
  std::string text;
  for (const Isa isa : kAllIsas) {
    if (isa_lanes(isa) != 0) text.append(text.empty() ? "" : ", ").append(isa_name(isa));
  }
  return text;
}

Isa choose_isa(const std::string& text, bool given) {
  if (!given || text == "auto") return best_isa();
  const std::optional<Isa> isa = parse_isa(text);
  if (!isa) refuse("--isa", text, "must be " + isa_choices());
  if (isa_lanes(*isa) == 0) refuse("--isa", text, "this build lacks it and has " + isas_built_in());
  if (!isa_available(*isa)) {
    refuse("--isa", text, fmt::format("this CPU lacks it; its best is {}", isa_name(best_isa())));
  }
  return *isa;
}

std::optional<Integrator> choose_integrator(const std::string& text, bool given) {
  if (!given) return std::nullopt;
  const std::optional<Integrator> integrator = parse_integrator(text);
  if (!integrator) refuse("--integrator", text, "must be verlet, euler, rk4 or symplectic4");
  return integrator;
}

}  // namespace

void refuse(std::string_view option, std::string_view text, std::string_view right) {
  throw UserError(fmt::format("{} {}: {}", option, text.empty() ? "''" : one_line(text), right));
}

void require_ending(std::string_view option, const std::string& file, std::string_view ending) {
  const std::string file_name = os::name_of(os::path_of(file).filename());
  if (file_name.empty() || file.starts_with("/dev/")) return;  // a folder is refused when it is opened
  const auto same = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  const std::string_view name = file_name;
  if (name.size() > ending.size() && std::ranges::equal(name.substr(name.size() - ending.size()), ending, same)) {
    return;
  }
  refuse(option, file, fmt::format("must end in {}, the only format that is written", ending));
}

std::optional<bool> on_off(std::string_view option, const std::string& text, bool given) {
  if (!given) return std::nullopt;
  if (text != "on" && text != "off") refuse(option, text, "must be on or off");
  return text == "on";
}

void refuse_leftovers(const CLI::App& app) {
  const std::vector<std::string> left = app.remaining();
  if (left.empty()) return;
  const std::string& word = left.front();
  if (!word.starts_with('-')) {
    std::vector<std::string> commands;
    for (const CLI::App* command : app.get_subcommands({})) commands.push_back(command->get_name());
    throw UserError(
        fmt::format("{}: unexpected word; options begin with --, and a scene is given "
                    "as --scene NAME{}",
                    one_line(word), did_you_mean(word, commands)));
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string name = word.substr(0, word.find('='));
  const std::string hint = did_you_mean(name, known);
  throw UserError(
      fmt::format("{}: unknown option{}", one_line(name), hint.empty() ? "; psim --help lists them all" : hint));
}

std::string reworded(const CLI::ParseError& error) {
  std::string text = one_line(error.what());
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    const std::string name = text.substr(0, text.find_first_of(": "));
    if (name.starts_with("--")) return name + ": needs a value";
    if (text.find("flag override") != std::string::npos) return "--" + name + ": takes no value";
  }
  return text;
}

CLI::Option* add_value(CLI::App& app, const char* name, std::string& target, const char* type, const char* group,
                       const char* what) {
  return app.add_option(name, target, what)
      ->type_name(type)
      ->group(group)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

void declare_settings(CLI::App& app, TypedSettings& typed) {
  const auto value = [&app](const char* name, std::string& target, const char* type, const char* group,
                            const char* what) { add_value(app, name, target, type, group, what); };
  value("--scene", typed.scene, "FILE|NAME", "Scene", "scene file, or name of a built-in scene (discs)");
  value("--particles", typed.particles, "N", "Scene", "number of bodies of a built-in scene, 1..10000000");
  value("--seed", typed.seed, "N", "Scene", "seed of all random numbers of the scene");

  value("--frames", typed.frames, "N", "Run", "number of frames to run (600)");
  value("--dt", typed.dt, "S", "Run", "length of a frame in seconds (the scene's, else 1/60)");
  value("--substeps", typed.substeps, "N", "Run", "substeps in each frame, 1..64 (the scene's, else 4)");
  value("--integrator", typed.integrator, "NAME", "Run",
        "method for wells and drag: verlet, euler, rk4 or symplectic4 (the scene's, else verlet)");
  value("--threads", typed.threads, "N", "Run", "number of threads, 1..256 (the machine's cores)");
  value("--isa", typed.isa, "NAME", "Run", ("instruction set: " + isa_choices() + " (auto: the CPU's best)").c_str());
  value("--sleep", typed.sleep, "on|off", "Run", "whether bodies at rest fall asleep (the scene's, else on)");
  value("--skin", typed.skin, "F", "Run",
        "margin of neighbour lists, as a factor of the usual one, 0.25..4 (the scene's, else 1)");
  value("--memory", typed.memory, "MB", "Run", "what the run may take, in million bytes (what the machine has free)");
}

void read_settings(const CLI::App& app, const TypedSettings& typed, Options& options) {
  const auto given = [&app](const char* name) { return app.count(name) > 0; };
  if (given("--scene")) options.scene = typed.scene;
  if (options.scene.empty()) refuse("--scene", "", "needs a file or the name of a built-in scene");
  options.particles = number<std::uint64_t>("--particles", typed.particles, given("--particles"), 1, 10'000'000,
                                            "must be a whole number, 1 to 10000000");
  options.seed = number<std::uint64_t>("--seed", typed.seed, given("--seed"), 0, UINT64_MAX,
                                       "must be a whole number, 0 to 18446744073709551615");
  options.frames = number<std::uint64_t>("--frames", typed.frames, given("--frames"), 0, 1'000'000'000,
                                         "must be a whole number, 0 to 1000000000");
  options.dt_s = number<double>("--dt", typed.dt, given("--dt"), 1e-6, 1, "must be a number of seconds, 0.000001 to 1");
  options.substeps =
      number<int>("--substeps", typed.substeps, given("--substeps"), 1, 64, "must be a whole number, 1 to 64");
  options.integrator = choose_integrator(typed.integrator, given("--integrator"));
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  options.threads =
      number<int>("--threads", typed.threads, given("--threads"), 1, kMostThreads, "must be a whole number, 1 to 256")
          .value_or(std::clamp(cores, 1, kMostThreads));
  options.isa = choose_isa(typed.isa, given("--isa"));
  options.skin = number<double>("--skin", typed.skin, given("--skin"), 0.25, 4, "must be a number, 0.25 to 4");
  const auto megabytes = number<std::uint64_t>("--memory", typed.memory, given("--memory"), 1, 1'000'000'000,
                                               "must be a whole number of million bytes, 1 to 1000000000");
  options.memory_bytes = std::min<std::uint64_t>(megabytes ? *megabytes * 1'000'000 : os::available_bytes(), SIZE_MAX);
  options.sleep = on_off("--sleep", typed.sleep, given("--sleep"));
}

}  // namespace psim::cli
