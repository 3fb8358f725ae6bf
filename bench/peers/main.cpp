// peers: the same scenes in psim and in the engines that are installed, ms a frame beside what is
// wrong with the result.
//
//   peers --quick                                  small scenes, recommended settings: a minute
//   peers --scenes stack,gas --engines psim,box2d  some of it
//   peers --scenes scenes/dam.json                 a scene file
//   peers --scenes psim:smash --frame-times t.csv  a built-in scene of psim, with a row a frame
//   peers --csv peers.csv --plot peers.png         everything, with a row a point and a picture
// The table goes to stdout, talk to stderr. Exit 2 if asked wrongly. The file of --csv takes its name at the end: a run
// that is interrupted leaves the old one.
#include <spawn.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "comparison.h"
#include "engines.h"
#include "output/atomic_file.h"
#include "output/user_error.h"
#include "report.h"

extern char** environ;

namespace {

using namespace psim::peers;

struct Options {
  bool list = false;
  bool quick = false;
  bool full = false;
  std::vector<std::string> scenes;
  std::vector<std::string> engines;
  std::string csv;
  std::string plot;
  std::string frame_times;
  int repeats = 0;
  int frames = 0;

  Size size() const { return quick ? Size::quick : full ? Size::full : Size::normal; }
};

/// An engine with one of its settings.
struct Entry {
  const Engine* engine;
  NamedSetting setting;
};

template <class T>
std::string names_of(const std::vector<T>& all) {
  std::string names;
  for (const T& t : all) names += " " + t.name;
  return names;
}

std::vector<Comparison> chosen_scenes(const std::vector<std::string>& wanted) {
  const std::vector<Comparison> all = all_comparisons();
  if (wanted.empty()) return all;
  std::vector<Comparison> chosen;
  for (const std::string& name : wanted) {
    const auto found = std::ranges::find(all, name, &Comparison::name);
    if (found != all.end()) {
      chosen.push_back(*found);
    } else if (name.ends_with(".json")) {
      chosen.push_back(comparison_of_file(name));
    } else if (name.starts_with("psim:")) {
      chosen.push_back(comparison_of_builtin(name));
    } else {
      throw std::invalid_argument(
          "--scenes: no scene '" + name +
          "'; a file that ends in .json, psim: with a built-in scene, or one of:" + names_of(all));
    }
  }
  return chosen;
}

std::vector<Engine> chosen_engines(const std::vector<std::string>& wanted) {
  std::vector<Engine> all = all_engines();
  for (const std::string& name : wanted) {
    const auto found = std::ranges::find(all, name, &Engine::name);
    if (found == all.end()) {
      throw std::invalid_argument("--engines: no engine '" + name + "'; there are:" + names_of(all));
    }
    if (!found->absent.empty()) throw std::invalid_argument(name + ": " + found->absent);
  }
  std::erase_if(all, [&](const Engine& e) {
    if (!wanted.empty()) return std::ranges::find(wanted, e.name) == wanted.end();
    if (!e.absent.empty()) std::fprintf(stderr, "peers: %s %s\n", e.name.c_str(), e.absent.c_str());
    return !e.absent.empty();
  });
  return all;
}

void list(const Options& options) {
  const std::vector<Engine> engines = all_engines();
  std::printf("engines\n");
  for (const Engine& e : engines) {
    std::printf("  %-9s %-7s %s\n", e.name.c_str(), e.version.c_str(), e.absent.c_str());
    for (const NamedSetting& s : settings_of(e)) {
      std::printf("    %s%s\n", s.name.c_str(), s.recommended ? " *" : "");
    }
  }
  std::printf("scenes\n");
  for (const Comparison& c : chosen_scenes(options.scenes)) {
    const auto model = psim::accuracy::make_model(c.scene(options.size()));
    std::printf("  %-18s %6zu bodies: %s\n", c.name.c_str(), model.bodies.size(), c.shows.c_str());
    for (const Engine& e : engines) {
      const std::string what = e.absent.empty() ? e.refuses(model) : "";
      if (!what.empty()) std::printf("    not supported by %s: %s\n", e.name.c_str(), what.c_str());
    }
  }
}

std::vector<Entry> entries_of(const std::vector<Engine>& engines, bool recommended) {
  std::vector<Entry> entries;
  for (const Engine& engine : engines) {
    for (const NamedSetting& setting : settings_of(engine)) {
      if (!recommended || setting.recommended) entries.push_back({&engine, setting});
    }
  }
  return entries;
}

void add(const Result& result, Row& row) {
  ++row.repeats;
  if (row.repeats == 1) row.errors = result.errors;
  if (row.note.empty() && !result.failed.empty()) row.note = "failed: " + result.failed;
  if (!row.note.empty()) {
    row.frame_ms.clear();
  } else if (row.frame_ms.empty()) {
    row.frame_ms = result.frame_ms;
  } else {
    for (std::size_t k = 0; k < row.frame_ms.size(); ++k) {
      row.frame_ms[k] = std::min(row.frame_ms[k], result.frame_ms[k]);
    }
  }
}

/// All entries in one scene, in turn, as often as asked: A B C A B C.
std::vector<Row> compare(Comparison of, const std::vector<Entry>& entries, const Options& options) {
  if (options.quick) {
    of.frames = std::min(of.frames, 60);
    of.settle = std::min(of.settle, 60);
  }
  if (options.frames != 0) of.frames = options.frames;
  const Model model = psim::accuracy::make_model(of.scene(options.size()));
  std::vector<Row> rows;
  for (const Entry& entry : entries) {
    Row row;
    row.engine = entry.engine->name;
    row.version = entry.engine->version;
    row.setting = entry.setting.name;
    row.recommended = entry.setting.recommended;
    row.threads = entry.setting.setting.threads;
    row.scene = of.name;
    row.bodies = model.bodies.size();
    const std::string what = entry.engine->refuses(model);
    if (!what.empty()) row.note = "not supported: " + what;
    rows.push_back(row);
  }
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    std::fprintf(stderr, "%s %d/%d\n", of.name.c_str(), repeat + 1, options.repeats);
    for (std::size_t k = 0; k < entries.size(); ++k) {
      if (!rows[k].note.empty()) continue;
      const Entry& entry = entries[k];
      add(run(of, model, of.frames, *entry.engine, entry.setting.setting, repeat == 0), rows[k]);
    }
  }
  return rows;
}

void plot(const Options& options) {
  const std::string script = PSIM_PEERS_PLOT;
  std::vector<std::string> words = {script, options.csv, "--plot", options.plot};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t child = 0;
  int status = 0;
  if (::posix_spawn(&child, script.c_str(), nullptr, nullptr, argv.data(), environ) != 0 ||
      ::waitpid(child, &status, 0) != child || status != 0) {
    throw std::runtime_error("--plot: " + script + " failed; the rows are in " + options.csv);
  }
}

bool is_same_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) ||
         fs::weakly_canonical(fs::absolute(a), ignored) == fs::weakly_canonical(fs::absolute(b), ignored);
}

// What can be wrong with them is told before the run.
void check_outputs(const Options& options) {
  const auto refuse_scene = [&](const std::string& option, const std::string& path) {
    for (const std::string& scene : options.scenes) {
      if (scene.ends_with(".json") && is_same_file(path, scene)) {
        throw std::invalid_argument(option + " " + path + ": is the file of --scenes too");
      }
    }
  };
  if (!options.csv.empty()) refuse_scene("--csv", options.csv);
  if (!options.frame_times.empty()) {
    refuse_scene("--frame-times", options.frame_times);
    if (!options.csv.empty() && is_same_file(options.frame_times, options.csv)) {
      throw std::invalid_argument("--frame-times " + options.frame_times + ": is the file of --csv too");
    }
  }
  if (options.plot.empty()) return;
  refuse_scene("--plot", options.plot);
  if (!options.plot.ends_with(".png") && !options.plot.ends_with(".svg")) {
    throw std::invalid_argument("--plot " + options.plot + ": must end in .png or .svg");
  }
  if (is_same_file(options.plot, options.csv)) {
    throw std::invalid_argument("--plot " + options.plot + ": is the file of --csv too");
  }
  psim::cli::AtomicFile("--plot", options.plot);
}

int run_all(const Options& options) {
  const std::vector<Comparison> scenes = chosen_scenes(options.scenes);
  const std::vector<Engine> engines = chosen_engines(options.engines);
  const std::vector<Entry> entries = entries_of(engines, options.quick || !options.frame_times.empty());
  check_outputs(options);
  std::optional<psim::cli::AtomicFile> csv;
  if (!options.csv.empty()) csv.emplace("--csv", options.csv);
  std::optional<psim::cli::AtomicFile> frame_times;
  if (!options.frame_times.empty()) frame_times.emplace("--frame-times", options.frame_times);
  std::ostringstream rows_written, times_written;
  write_header(rows_written);
  write_times_header(times_written);
  for (const Comparison& of : scenes) {
    const std::vector<Row> rows = compare(of, entries, options);
    print_scene(std::cout, rows);
    std::cout.flush();
    for (const Row& row : rows) {
      write_row(rows_written, row);
      write_times(times_written, row);
    }
  }
  if (csv) {
    csv->write(rows_written.view());
    csv->commit();
  }
  if (frame_times) {
    frame_times->write(times_written.view());
    frame_times->commit();
  }
  if (!options.plot.empty()) plot(options);
  return std::cout ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("The same scenes in several engines: ms a frame beside what is wrong.", "peers");
  app.add_flag("--list", options.list, "engines, settings (* = recommended) and scenes; runs nothing");
  app.add_option("--scenes", options.scenes,
                 "only these, by name, FILE.json or psim:NAME:BODIES for a scene of psim, commas between")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--engines", options.engines, "only these, commas between")->delimiter(',')->allow_extra_args(false);
  auto* quick = app.add_flag("--quick", options.quick, "small scenes, few frames, recommended settings, one run each");
  app.add_flag("--full", options.full, "100,000 discs, pyramid of base 100, 22,000 boxes")->excludes(quick);
  app.add_option("--repeats", options.repeats, "runs of each, in turn (3; --quick: 1)")->check(CLI::Range(1, 99));
  app.add_option("--frames", options.frames, "that are timed, instead of a scene's own number")
      ->check(CLI::Range(1, 100000));
  app.add_option("--frame-times", options.frame_times,
                 "a row for every frame of the recommended settings, which alone are run");
  auto* csv = app.add_option("--csv", options.csv, "a row for every engine, setting and scene");
  app.add_option("--plot", options.plot, "a picture of that file, PNG or SVG")->needs(csv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return std::fputs(app.help().c_str(), stdout), 0;
  } catch (const CLI::ParseError& e) {
    return std::fprintf(stderr, "peers: %s\n", e.what()), 2;
  }
  if (options.repeats == 0) options.repeats = options.quick ? 1 : 3;
  try {
    if (options.list) return list(options), 0;
    return run_all(options);
  } catch (const std::invalid_argument& e) {
    return std::fprintf(stderr, "peers: %s\n", e.what()), 2;
  } catch (const psim::cli::UserError& e) {
    return std::fprintf(stderr, "peers: %s\n", e.what()), 2;
  } catch (const std::exception& e) {
    return std::fprintf(stderr, "peers: %s\n", e.what()), 1;
  }
}
