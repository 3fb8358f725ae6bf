#include "options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <thread>
#include <vector>

#include "text.h"
#include "user_error.h"

namespace psim::cli {
namespace {

constexpr int kMostThreads = 256;

// The words as they were typed; CLI11 fills them, parse_options turns them into values.
struct Typed {
  std::string scene, particles, seed, frames, dt, substeps, threads, isa, report, state, metrics,
      trajectory, every, image, trace, budget, governor, sleep;
  bool list_scenes = false, explain = false, verify = false, check = false, benchmark = false,
       version = false;
};

void declare(CLI::App& app, Typed& typed) {
  const auto value = [&app](const char* name, std::string& target, const char* type,
                            const char* group, const char* what) {
    app.add_option(name, target, what)
        ->type_name(type)
        ->group(group)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  };
  const auto flag = [&app](const char* name, bool& target, const char* what) {
    app.add_flag(name, target, what)->group("Instead of a run")->disable_flag_override();
  };

  value("--scene", typed.scene, "FILE|NAME", "Scene", "a scene file or a built-in scene (discs)");
  value("--particles", typed.particles, "N", "Scene", "bodies of a built-in scene, 1..10000000");
  value("--seed", typed.seed, "N", "Scene", "seed of every generator in the scene");

  value("--frames", typed.frames, "N", "Run", "frames to run (600)");
  value("--dt", typed.dt, "S", "Run", "seconds a frame (the scene's, else 1/60)");
  value("--substeps", typed.substeps, "N", "Run", "substeps a frame, 1..64 (the scene's, else 4)");
  value("--threads", typed.threads, "N", "Run", "worker threads, 1..256 (the machine's cores)");
  value("--isa", typed.isa, "NAME", "Run", "auto, scalar, sse or avx2 (auto: the CPU's best)");
  value("--sleep", typed.sleep, "on|off", "Run", "bodies at rest sleep (the scene's, else on)");
  value("--budget", typed.budget, "MS", "Run", "frame budget in ms (16.67)");
  value("--governor", typed.governor, "on|off", "Run", "keep the budget by doing less (off)");

  value("--report", typed.report, "text|json", "Output", "form of the report (text)");
  value("--state", typed.state, "FILE.csv", "Output", "final state, a row per body");
  value("--metrics", typed.metrics, "FILE.csv", "Output", "times and counts, a row per frame");
  value("--trajectory", typed.trajectory, "FILE.csv", "Output", "state of every K-th frame");
  value("--every", typed.every, "K", "Output", "frames between trajectory rows (1)");
  value("--image", typed.image, "FILE.png", "Output", "picture of the final state");
  value("--trace", typed.trace, "FILE.json", "Output", "Chrome/Perfetto trace of all stages");

  flag("--list-scenes", typed.list_scenes, "the built-in scenes");
  flag("--explain", typed.explain, "the stages that the scene needs, and why");
  flag("--check", typed.check, "warns of what will go wrong in the scene");
  flag("--verify", typed.verify, "same bits on every ISA and thread count?");
  flag("--benchmark", typed.benchmark, "time by particles, by threads, by ISA");
  flag("--version", typed.version, "version, compiler, build type, ISAs");
}

[[noreturn]] void refuse(std::string_view option, std::string_view text, std::string_view right) {
  throw UserError(fmt::format("{} {}: {}", option, text.empty() ? "''" : one_line(text), right));
}

template <class Number>
std::optional<Number> number(std::string_view option, const std::string& text, bool given,
                             Number least, Number most, std::string_view right) {
  if (!given) return std::nullopt;
  Number value{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end || !(value >= least && value <= most)) {
    refuse(option, text, right);
  }
  return value;
}

std::optional<bool> on_off(std::string_view option, const std::string& text, bool given) {
  if (!given) return std::nullopt;
  if (text != "on" && text != "off") refuse(option, text, "must be on or off");
  return text == "on";
}

Isa choose_isa(const std::string& text, bool given) {
  if (!given || text == "auto") return best_isa();
  const std::optional<Isa> isa = parse_isa(text);
  if (!isa) refuse("--isa", text, "must be auto, scalar, sse or avx2");
  if (!isa_available(*isa)) {
    refuse("--isa", text, fmt::format("this CPU lacks it; its best is {}", isa_name(best_isa())));
  }
  return *isa;
}

// One mode at most.
Mode choose_mode(const Typed& typed) {
  const std::pair<bool, std::pair<Mode, const char*>> asked[] = {
      {typed.version, {Mode::version, "--version"}},
      {typed.list_scenes, {Mode::list_scenes, "--list-scenes"}},
      {typed.explain, {Mode::explain, "--explain"}},
      {typed.check, {Mode::check, "--check"}},
      {typed.verify, {Mode::verify, "--verify"}},
      {typed.benchmark, {Mode::benchmark, "--benchmark"}},
  };
  Mode mode = Mode::run;
  std::string_view first;
  for (const auto& [is_asked, what] : asked) {
    if (!is_asked) continue;
    if (!first.empty())
      throw UserError(fmt::format("{} and {}: one at a time", first, what.second));
    mode = what.first;
    first = what.second;
  }
  return mode;
}

void refuse_leftovers(const CLI::App& app) {
  const std::vector<std::string> left = app.remaining();
  if (left.empty()) return;
  const std::string& word = left.front();
  if (!word.starts_with('-')) {
    throw UserError(
        fmt::format("{}: unexpected word; options begin with --, and a scene is given "
                    "as --scene NAME",
                    one_line(word)));
  }
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string name = word.substr(0, word.find('='));
  const std::string hint = did_you_mean(name, known);
  throw UserError(fmt::format("{}: unknown option{}", one_line(name),
                              hint.empty() ? "; psim --help lists them all" : hint));
}

// CLI11's own complaints: a value that is missing, or one that a flag does not take.
std::string reworded(const CLI::ParseError& error) {
  const std::string text = one_line(error.what());
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    const std::string name = text.substr(0, text.find_first_of(": "));
    if (name.starts_with("--")) return name + ": needs a value";
    if (text.find("flag override") != std::string::npos) return "--" + name + ": takes no value";
  }
  return text;
}

// File names, and the options that have no meaning without a run.
void check_outputs(const CLI::App& app, Mode mode) {
  for (const char* name : {"--state", "--metrics", "--trajectory", "--image", "--trace"}) {
    const CLI::Option* option = app.get_option(name);
    if (option->count() == 0) continue;
    if (option->as<std::string>().empty()) refuse(name, "", "needs a file name");
  }
  if (app.count("--every") > 0 && app.count("--trajectory") == 0) {
    throw UserError("--every: has a meaning only with --trajectory FILE");
  }
  if (mode == Mode::run) return;
  for (const char* name :
       {"--state", "--metrics", "--trajectory", "--image", "--trace", "--report"}) {
    if (app.count(name) > 0) {
      throw UserError(
          fmt::format("{}: belongs to a run, and nothing is run for a report here", name));
    }
  }
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Typed typed;
  CLI::App app("psim: a 2D physics engine for very many bodies", "psim");
  app.set_help_flag("-h,--help", "this text");
  app.allow_extras();
  app.get_formatter()->column_width(28);
  app.footer("Without options: the scene discs, 100,000 bodies, 600 frames.");
  declare(app, typed);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print_out(app.help());
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw UserError(reworded(error));
  }
  refuse_leftovers(app);

  const auto given = [&app](const char* name) { return app.count(name) > 0; };
  Options options;
  options.mode = choose_mode(typed);
  check_outputs(app, options.mode);
  if (given("--scene")) options.scene = typed.scene;
  if (options.scene.empty()) refuse("--scene", "", "needs a file or the name of a built-in scene");
  options.particles = number<std::uint64_t>("--particles", typed.particles, given("--particles"), 1,
                                            10'000'000, "must be a whole number, 1 to 10000000");
  options.seed = number<std::uint64_t>("--seed", typed.seed, given("--seed"), 0, UINT64_MAX,
                                       "must be a whole number, 0 to 18446744073709551615");
  options.frames = number<std::uint64_t>("--frames", typed.frames, given("--frames"), 0,
                                         1'000'000'000, "must be a whole number, 0 to 1000000000");
  options.dt_s = number<double>("--dt", typed.dt, given("--dt"), 1e-6, 1,
                                "must be a number of seconds, 0.000001 to 1");
  options.substeps = number<int>("--substeps", typed.substeps, given("--substeps"), 1, 64,
                                 "must be a whole number, 1 to 64");
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  options.threads = number<int>("--threads", typed.threads, given("--threads"), 1, kMostThreads,
                                "must be a whole number, 1 to 256")
                        .value_or(std::clamp(cores, 1, kMostThreads));
  options.isa = choose_isa(typed.isa, given("--isa"));
  options.sleep = on_off("--sleep", typed.sleep, given("--sleep"));
  if (on_off("--governor", typed.governor, given("--governor")).value_or(false)) {
    refuse("--governor", "on", "there is no governor yet; only off works");
  }
  options.budget_ms = number<double>("--budget", typed.budget, given("--budget"), 1e-9, 1e9,
                                     "must be a number of milliseconds above 0")
                          .value_or(options.budget_ms);
  if (given("--report") && typed.report != "text" && typed.report != "json") {
    refuse("--report", typed.report, "must be text or json");
  }
  options.report = typed.report == "json" ? ReportFormat::json : ReportFormat::text;
  options.state = typed.state;
  options.metrics = typed.metrics;
  options.trajectory = typed.trajectory;
  options.image = typed.image;
  options.trace = typed.trace;
  options.every = number<std::uint64_t>("--every", typed.every, given("--every"), 1, 1'000'000'000,
                                        "must be a whole number of frames, 1 to 1000000000")
                      .value_or(1);
  return options;
}

}  // namespace psim::cli
