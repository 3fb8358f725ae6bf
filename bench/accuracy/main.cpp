// accuracy: errors against truths, beside the time they cost, for psim and for the engines that are
// installed.
//
//   accuracy --quick                         the default settings and few others, 1 to 2 minutes
//   accuracy --case kepler --case pile       two cases over all settings
//   accuracy --kind discs --output docs/data/accuracy.csv        everything with discs
//   accuracy --kind rigid --output docs/data/accuracy-rigid.csv  everything with boxes or joints
//   accuracy --calibrate                     docs/data/calibration.csv, 4 minutes
//   accuracy --stress --quick                how far the engines can be driven, 20 s
// Rows go to stdout or the file, talk to stderr. Exit 1 if psim misses a limit, 2 if asked wrongly.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <variant>
#include <vector>

#include "calibrate.h"
#include "cases/case.h"
#include "csv.h"
#include "engines/engine.h"
#include "output/atomic_file.h"
#include "report_stress.h"
#include "sweep.h"

namespace {

using namespace psim::accuracy;

struct Options {
  bool list = false;
  bool quick = false;
  bool stress = false;
  bool calibrate = false;
  std::vector<std::string> cases;
  std::vector<std::string> engines;
  std::string kind;
  std::string output;
  std::string scenes;

  Effort effort() const { return quick ? Effort::quick : Effort::full; }
};

void list(const std::vector<Case>& cases, const std::vector<Engine>& engines) {
  std::printf("engines\n");
  for (const Engine& e : engines) {
    std::printf("  %-10s %-8s %s\n", e.name.c_str(), e.version.c_str(), e.absent.c_str());
  }
  std::printf("cases\n");
  for (const Case& c : cases) {
    std::printf("  %s: %s\n", c.name.c_str(), c.shows.c_str());
    for (const Quantity& q : c.quantities) {
      std::printf("    %-26s %-20s %s\n", q.name.c_str(), q.unit.c_str(), q.reference.c_str());
    }
    const Model model = make_model(c.scene());
    for (const Engine& e : engines) {
      if (!e.absent.empty()) continue;
      const std::string why = e.refuses(model);
      if (!why.empty()) std::printf("    not in %s: %s\n", e.name.c_str(), why.c_str());
    }
  }
}

/// Keeps the wanted ones, all if none is named; an unknown name throws with those there are.
template <class T>
void keep(const std::vector<std::string>& wanted, const char* what, std::vector<T>& from) {
  const auto named = [&](const std::string& name) {
    return std::ranges::any_of(from, [&](const T& t) { return t.name == name; });
  };
  for (const std::string& name : wanted) {
    if (named(name)) continue;
    std::string known;
    for (const T& t : from) known += " " + t.name;
    throw std::invalid_argument("no " + std::string(what) + " '" + name + "'; there are:" + known);
  }
  if (wanted.empty()) return;
  std::erase_if(from, [&](const T& t) { return std::ranges::find(wanted, t.name) == wanted.end(); });
}

bool is_rigid(const Case& of) {
  const Model model = make_model(of.scene());
  const bool chains = std::ranges::any_of(
      model.bodies, [](const psim::BodyDesc& b) { return std::holds_alternative<psim::ChainShape>(b.shape); });
  return has_boxes(model) || chains || !model.scene.joints.empty();
}

void keep_kind(const std::string& kind, std::vector<Case>& cases) {
  if (kind.empty()) return;
  std::erase_if(cases, [rigid = kind == "rigid"](const Case& c) { return is_rigid(c) != rigid; });
}

void drop_absent(const std::vector<std::string>& wanted, std::vector<Engine>& engines) {
  for (const Engine& e : engines) {
    if (!e.absent.empty() && !wanted.empty()) throw std::invalid_argument(e.name + ": " + e.absent);
  }
  std::erase_if(engines, [](const Engine& e) { return !e.absent.empty(); });
}

void write_scenes(const std::vector<Case>& cases, const std::string& folder) {
  std::filesystem::create_directories(folder);
  for (const Case& c : cases) {
    psim::Scene scene = c.scene();
    scene.name = c.name;
    scene.description = c.shows;
    std::ofstream(std::filesystem::path(folder) / (c.name + ".json")) << scene_to_json(scene);
  }
}

/// One case in all engines; rows are written as they come. Returns the complaints.
std::vector<std::string> run_case(const Case& of, const std::vector<Engine>& engines, Effort effort,
                                  std::ostream& out) {
  const Model model = make_model(of.scene());
  std::vector<Row> all;
  for (const Engine& engine : engines) {
    if (!engine.refuses(model).empty()) continue;
    for (const Setting& setting : engine.settings(effort, of.scale)) {
      if (!matters(setting, of, model)) continue;
      for (const Row& row : run_setting(of, model, engine, setting, effort)) {
        write_row(out, row);
        all.push_back(row);
      }
      out.flush();
    }
  }
  return complaints(all);
}

int run(const Options& options) {
  std::vector<Case> cases = all_cases(options.effort());
  std::vector<Engine> engines = all_engines();
  if (options.list) return list(cases, engines), 0;
  if (options.stress && !options.cases.empty()) {
    throw std::invalid_argument("--stress and --case: one at a time");
  }
  if (options.calibrate) {
    if (options.stress || !options.cases.empty() || !options.engines.empty()) {
      throw std::invalid_argument("--calibrate: stands alone, or with --quick and --output");
    }
    const std::string path = options.output.empty() ? PSIM_CALIBRATION_FILE : options.output;
    psim::cli::AtomicFile table("--output", path);
    table.write(calibrate(options.effort()));
    table.commit();
    return 0;
  }
  keep_kind(options.kind, cases);
  keep(options.cases, "case", cases);
  keep(options.engines, "engine", engines);
  drop_absent(options.engines, engines);
  if (!options.scenes.empty()) return write_scenes(cases, options.scenes), 0;

  std::optional<psim::cli::AtomicFile> file;
  if (!options.output.empty()) file.emplace("--output", options.output);
  std::ostringstream rows;
  const auto keep_rows = [&] {
    if (!file) return;
    file->write(rows.view());
    file->commit();
  };
  if (options.stress) {
    const int missed = report_stress(engines, options.effort(), std::cout, file ? &rows : nullptr);
    keep_rows();
    if (missed > 0) std::fprintf(stderr, "accuracy: psim misses %d limits\n", missed);
    return missed == 0 && std::cout ? 0 : 1;
  }
  std::ostream& out = file ? static_cast<std::ostream&>(rows) : std::cout;
  write_header(out);
  bool good = true;
  for (const Case& of : cases) {
    std::fprintf(stderr, "%s\n", of.name.c_str());
    for (const std::string& line : run_case(of, engines, options.effort(), out)) {
      std::fprintf(stderr, "accuracy: %s\n", line.c_str());
      good = false;
    }
  }
  keep_rows();
  return good && out ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Errors against truths, beside the time they cost.", "accuracy");
  app.add_flag("--list", options.list, "engines and cases; runs nothing");
  app.add_option("--case", options.cases, "only this case; may be given again")->allow_extra_args(false);
  app.add_option("--engine", options.engines, "only this engine; may be given again")->allow_extra_args(false);
  app.add_option("--kind", options.kind, "only cases of discs alone, or only those with boxes or joints")
      ->check(CLI::IsMember({"discs", "rigid"}));
  app.add_flag("--quick", options.quick, "few settings, shorter cases: under three minutes");
  app.add_flag("--stress", options.stress, "table of how far the engines can be driven, no cases");
  app.add_flag("--calibrate", options.calibrate,
               "measures what psim --target-error and --target-ms choose from, into "
               "docs/data/calibration.csv or --output");
  app.add_option("--output", options.output, "CSV file instead of stdout; complete or not there");
  app.add_option("--write-scenes", options.scenes, "writes the cases' scene files into this folder and ends");
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return std::fputs(app.help().c_str(), stdout), 0;
  } catch (const CLI::ParseError& e) {
    return std::fprintf(stderr, "accuracy: %s\n", e.what()), 2;
  }
  try {
    return run(options);
  } catch (const std::exception& e) {
    return std::fprintf(stderr, "accuracy: %s\n", e.what()), 2;
  }
}
