// fluids: error against run time of psim's fluids and of a reference solver by smoothed particles.
//
//   fluids --list                               cases and methods
//   fluids --quick                              one coarse run of each, a few seconds
//   fluids --case dam-break --engine sph        one case by one method, all settings
//   fluids --output docs/data/fluids.csv        everything: a quarter of an hour of processor time
// Rows go to stdout or the file, in the columns of `accuracy`; tools/plot draws them. Exit 1 if a run of --quick is
// far from the truth, 2 if asked wrongly.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "cases.h"

namespace {

using namespace psim::fluids;

constexpr double kCheap = 2;  // seconds: shorter runs are repeated, and the least time counts
constexpr int kRepeats = 3;

struct Options {
  bool list = false;
  bool quick = false;
  std::vector<int> layers;
  std::vector<std::string> cases, engines;
  std::string output;
};

// With --quick the default of each engine alone.
std::vector<Method> methods_of(const Options& options, const Case& c, int layers) {
  std::vector<Method> all = {{"psim", "1 step a frame default", 1, {}},
                             {"psim", "2 steps a frame", 2, {}},
                             {"psim", "4 steps a frame", 4, {}},
                             {"sph", "reach 4 default", 1, {.reach = 4}},
                             {"sph", "reach 4 without artificial viscosity", 1, {.reach = 4, .alpha = 0}},
                             {"sph", "reach 3", 1, {.reach = 3}},
                             {"sph", "reach 2.6", 1, {.reach = 2.6}}};
  std::erase_if(all, [&](const Method& m) {
    const bool other =
        !options.engines.empty() && std::ranges::find(options.engines, m.engine) == options.engines.end();
    const bool not_default = !m.setting.ends_with(" default");
    const bool same = c.name == "taylor-green" && m.sph.alpha == 0;  // has none anyway
    const bool costly = m.engine == "sph" && !c.finest_by_all && layers == c.layers.back();
    return other || same || (not_default && costly) ||
           (not_default && (options.quick || (c.name == "large-dam" && m.engine == "psim")));
  });
  return all;
}

struct Run {
  std::vector<Measured> measured;
  std::size_t particles = 0;
  double dt = 0;
  double seconds = 0;  // for one simulated
};

Run run(const Case& c, const Method& method, int layers, bool quick) {
  const Flow flow = c.flow(layers);
  Run best;
  best.particles = flow.places.size();
  double spent = 0;
  for (int k = 0; k < kRepeats && (k == 0 || (!quick && spent < kCheap)); ++k) {
    const auto motion = begin(method, flow, c.frame);
    best.measured = c.measure(*motion, flow, quick);
    const double seconds = motion->seconds / motion->simulated;
    best.seconds = k == 0 ? seconds : std::min(best.seconds, seconds);
    best.dt = motion->dt;
    spent += motion->seconds;
  }
  return best;
}

void write_rows(std::ostream& out, const Method& method, const Run& r) {
  for (const Measured& m : r.measured) {
    char numbers[160];
    std::snprintf(numbers, sizeof numbers, "%.6g,0,%.4g,0,%.4g", r.dt, r.seconds, std::abs(m.error));
    out << m.name << ',' << method.engine << ',' << method.setting << ',' << numbers << ",\"" << m.unit << "\","
        << m.truth;
    std::snprintf(numbers, sizeof numbers, ",%zu,1,%.4g\n", r.particles, m.error);
    out << numbers;
  }
  out.flush();
}

// Far beyond what is measured, near enough to see that a method is broken.
bool within_limit(const Measured& m) {
  const double limit = m.name.starts_with("hydrostatic") ? 0.05 : m.name.starts_with("dam") ? 0.4 : 0.25;
  return std::abs(m.error) < limit;
}

std::vector<int> layers_of(const Options& options, const Case& c) {
  if (!options.layers.empty()) return options.layers;
  return options.quick ? std::vector{c.quick_layers} : c.layers;
}

bool run_all(const Options& options, std::ostream& out) {
  bool good = true;
  out << "case,engine,setting,h,iterations,seconds_per_sim_second,row_visits,error,unit,reference,particles,threads,"
         "signed_error\n";
  for (const Case& c : all_cases()) {
    if (!options.cases.empty() && std::ranges::find(options.cases, c.name) == options.cases.end()) continue;
    if (options.quick && c.quick_layers == 0) continue;
    for (const int layers : layers_of(options, c)) {
      for (const Method& method : methods_of(options, c, layers)) {
        const Run r = run(c, method, layers, options.quick);
        write_rows(out, method, r);
        for (const Measured& m : r.measured) {
          if (!options.quick || within_limit(m)) continue;
          std::cerr << "fluids: " << m.name << " by " << method.engine << " is off by " << m.error << '\n';
          good = false;
        }
      }
    }
  }
  return good;
}

void list() {
  for (const Case& c : all_cases()) std::cout << c.name << ": " << c.shows << '\n';
}

}  // namespace

int main(int count, char** words) {
  Options options;
  CLI::App app("Error against run time of fluids: psim and smoothed particles");
  app.add_flag("--list", options.list, "say which cases there are");
  app.add_flag("--quick", options.quick, "one coarse run of each");
  app.add_option("--case", options.cases, "only this one; may be given again");
  app.add_option("--engine", options.engines, "psim or sph; may be given again");
  app.add_option("--layers", options.layers, "particles in a metre, instead of the case's own");
  app.add_option("--output", options.output, "CSV; stdout without it");
  try {
    app.parse(count, words);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (options.list) {
    list();
    return 0;
  }
  try {
    if (options.output.empty()) return run_all(options, std::cout) ? 0 : 1;
    std::ofstream file(options.output);
    if (!file) throw std::runtime_error("cannot write " + options.output);
    return run_all(options, file) ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "fluids: " << error.what() << '\n';
    return 2;
  }
}
