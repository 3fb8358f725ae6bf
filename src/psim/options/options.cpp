#include "options/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <utility>

#include "options/diff_options.h"
#include "options/settings_options.h"
#include "output/text.h"
#include "output/user_error.h"

namespace psim::cli {
namespace {

// The words as they were typed; CLI11 fills them, parse_options turns them into values.
struct Typed {
  TypedSettings settings;
  TypedDiff diff;
  TypedPictures pictures;
  std::string report, state, fluid_state, metrics, trajectory, every, image, trace, budget, governor, governor_log,
      governor_replay;
  std::string save, restore, record, replay;
  std::string target_error, target_ms;
  bool profile = false, list_scenes = false, explain = false, verify = false, check = false, benchmark = false,
       version = false;
};

void declare(CLI::App& app, Typed& typed) {
  const auto value = [&app](const char* name, std::string& target, const char* type, const char* group,
                            const char* what) { add_value(app, name, target, type, group, what); };
  const auto flag = [&app](const char* name, bool& target, const char* what) {
    app.add_flag(name, target, what)->group("Instead of a run")->disable_flag_override();
  };

  declare_settings(app, typed.settings);
  value("--budget", typed.budget, "MS", "Run", "time that a frame may take, milliseconds (16.67)");
  value("--governor", typed.governor, "on|off", "Run",
        "whether to compute less where a frame would exceed the budget (off)");
  value("--governor-log", typed.governor_log, "FILE.csv", "Output", "write what the governor did in each frame");
  value("--governor-replay", typed.governor_replay, "FILE.csv", "Run",
        "repeat what the governor did in a logged run, with the same bits");

  value("--restore", typed.restore, "FILE", "Run", "start from a state of this scene that --save wrote");
  value("--save", typed.save, "FILE", "Output", "write the final state; --restore goes on from it with the same bits");
  value("--record", typed.record, "FILE", "Output", "write a recording of the run for --replay");
  value("--replay", typed.replay, "FILE", "Instead of a run",
        "run a recording and check that the bits are the same here");

  value("--target-error", typed.target_error, "E", "Run",
        "choose the cheapest integrator and substeps whose measured error is at most E");
  value("--target-ms", typed.target_ms, "MS", "Run",
        "choose the most accurate integrator and substeps whose frames take at most MS ms");

  value("--report", typed.report, "text|json", "Output", "format of the report (text)");
  value("--state", typed.state, "FILE.csv", "Output", "write the final state, a row for each body");
  value("--fluid-state", typed.fluid_state, "FILE.csv", "Output",
        "write the final state of fluids, a row for each particle");
  value("--metrics", typed.metrics, "FILE.csv", "Output", "write times and counts, a row for each frame");
  value("--trajectory", typed.trajectory, "FILE.csv", "Output", "write the state of every K-th frame");
  value("--every", typed.every, "K", "Output", "write a state or picture every K frames (1)");
  value("--image", typed.image, "FILE.png", "Output", "paint a picture of the final state");
  declare_pictures(app, typed.pictures);
  value("--trace", typed.trace, "FILE.json", "Output", "write a trace of all stages for ui.perfetto.dev or Chrome");
  app.add_flag("--profile", typed.profile, "report the time of stages and threads, and the bottleneck")
      ->group("Output")
      ->disable_flag_override();

  flag("--list-scenes", typed.list_scenes, "list the built-in scenes");
  flag("--explain", typed.explain, "list the stages that the scene needs, and why");
  flag("--check", typed.check, "warn of what is likely to go wrong in the scene");
  flag("--verify", typed.verify, "check that all instruction sets and thread counts give the same bits");
  flag("--benchmark", typed.benchmark, "measure time by number of bodies, threads and instruction set");
  flag("--version", typed.version, "print version, compiler, build type and instruction sets");
}

// One mode at most.
Mode choose_mode(const Typed& typed) {
  const std::pair<bool, std::pair<Mode, const char*>> asked[] = {
      {typed.version, {Mode::version, "--version"}},       {typed.list_scenes, {Mode::list_scenes, "--list-scenes"}},
      {typed.explain, {Mode::explain, "--explain"}},       {typed.check, {Mode::check, "--check"}},
      {typed.verify, {Mode::verify, "--verify"}},          {typed.benchmark, {Mode::benchmark, "--benchmark"}},
      {!typed.replay.empty(), {Mode::replay, "--replay"}},
  };
  Mode mode = Mode::run;
  std::string_view first;
  for (const auto& [is_asked, what] : asked) {
    if (!is_asked) continue;
    if (!first.empty()) throw UserError(fmt::format("{} and {}: one at a time", first, what.second));
    mode = what.first;
    first = what.second;
  }
  return mode;
}

// File names, and the options that have no meaning without a run.
void check_outputs(const CLI::App& app, Mode mode) {
  for (const char* name : {"--state", "--fluid-state", "--metrics", "--trajectory", "--image", "--trace",
                           "--governor-log", "--save", "--record", "--restore", "--replay"}) {
    const CLI::Option* option = app.get_option(name);
    if (option->count() == 0) continue;
    if (option->as<std::string>().empty()) refuse(name, "", "needs a file name");
  }
  if (app.count("--image") > 0) require_ending("--image", app.get_option("--image")->as<std::string>(), ".png");
  if (app.count("--every") > 0 && app.count("--trajectory") == 0 && app.count("--frames-dir") == 0 &&
      app.count("--video") == 0) {
    throw UserError("--every: has a meaning only with --trajectory, --frames-dir or --video");
  }
  if (mode == Mode::run) return;
  for (const char* name :
       {"--state",        "--metrics",      "--trajectory",      "--image",      "--trace",       "--report",
        "--profile",      "--governor-log", "--governor-replay", "--save",       "--restore",     "--record",
        "--target-error", "--target-ms",    "--frames-dir",      "--video",      "--fps",         "--image-size",
        "--view",         "--colour",       "--fluid-state",     "--fluid-look", "--fluid-colour"}) {
    if (app.count(name) > 0) {
      throw UserError(fmt::format("{}: belongs to a run, and nothing is run for a report here", name));
    }
  }
}

// A target chooses the settings, so nobody else may.
void check_target(const CLI::App& app) {
  for (const char* target : {"--target-error", "--target-ms"}) {
    if (app.count(target) == 0) continue;
    for (const char* other : {"--target-error", "--target-ms", "--substeps", "--integrator"}) {
      if (std::string_view(other) == target || app.count(other) == 0) continue;
      const bool is_target = std::string_view(other).starts_with("--target");
      throw UserError(is_target ? std::string("--target-error and --target-ms: one at a time")
                                : fmt::format("{}: {} chooses it", other, target));
    }
  }
}

void refuse_options_before_diff(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    throw UserError(fmt::format("{}: the options of diff stand behind it", option->get_name()));
  }
}

// Options that say what a file says already, or that need one another.
void refuse_contradictions(const CLI::App& app, const Typed& typed, const Options& options) {
  const auto given = [&app](const char* name) { return app.count(name) > 0; };
  if (options.governor && given("--governor-replay")) {
    throw UserError("--governor-replay: does what the log says; --governor on would choose anew");
  }
  if (given("--governor-replay") && typed.governor_replay.empty()) {
    refuse("--governor-replay", "", "needs a file name");
  }
  for (const char* name :
       {"--seed", "--dt", "--substeps", "--integrator", "--sleep", "--skin", "--target-error", "--target-ms"}) {
    if (given("--restore") && given(name)) throw UserError(fmt::format("{}: the state of --restore says it", name));
  }
  for (const char* name : {"--scene", "--particles", "--seed", "--frames", "--dt", "--substeps", "--integrator",
                           "--sleep", "--skin", "--governor"}) {
    if (given("--replay") && given(name)) throw UserError(fmt::format("{}: the recording of --replay says it", name));
  }
  if (given("--replay") && given("--budget"))
    throw UserError("--budget: belongs to a run, and a replay has none to keep");
}

}  // namespace

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Typed typed;
  CLI::App app("psim: a 2D physics engine for very many bodies", "psim");
  app.set_help_flag("-h,--help", "print this text");
  app.allow_extras();
  app.get_formatter()->column_width(28);
  app.footer("Without options: the scene discs, 100,000 bodies, 600 frames.");
  declare(app, typed);
  const CLI::App* const diff = declare_diff(app, typed.diff);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print_out(app.help());
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw UserError(reworded(error));
  }
  if (diff->parsed()) {
    refuse_options_before_diff(app);
    return read_diff(*diff, typed.diff);
  }
  refuse_leftovers(app);

  const auto given = [&app](const char* name) { return app.count(name) > 0; };
  Options options;
  options.mode = choose_mode(typed);
  check_outputs(app, options.mode);
  check_target(app);
  read_settings(app, typed.settings, options);
  options.governor = on_off("--governor", typed.governor, given("--governor")).value_or(false);
  options.governor_log = typed.governor_log;
  options.profile = typed.profile;
  options.governor_replay = typed.governor_replay;
  refuse_contradictions(app, typed, options);
  options.save = typed.save;
  options.restore = typed.restore;
  options.record = typed.record;
  options.replay = typed.replay;
  options.budget_ms =
      number<double>("--budget", typed.budget, given("--budget"), 1e-9, 1e9, "must be a number of milliseconds above 0")
          .value_or(options.budget_ms);
  options.target_error = number<double>("--target-error", typed.target_error, given("--target-error"), 1e-12, 1,
                                        "must be a number above 0 and at most 1, as 1e-3");
  options.target_ms = number<double>("--target-ms", typed.target_ms, given("--target-ms"), 1e-9, 1e9,
                                     "must be a number of milliseconds above 0");
  if (given("--report") && typed.report != "text" && typed.report != "json") {
    refuse("--report", typed.report, "must be text or json");
  }
  options.report = typed.report == "json" ? ReportFormat::json : ReportFormat::text;
  options.state = typed.state;
  options.fluid_state = typed.fluid_state;
  options.metrics = typed.metrics;
  options.trajectory = typed.trajectory;
  options.image = typed.image;
  options.trace = typed.trace;
  const auto every = number<std::uint64_t>("--every", typed.every, given("--every"), 1, 1'000'000'000,
                                           "must be a whole number of frames, 1 to 1000000000");
  options.every = every.value_or(1);
  options.pictures = read_pictures(app, typed.pictures, every);
  return options;
}

}  // namespace psim::cli
