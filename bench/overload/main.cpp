// Does the frame governor keep its budget? Every scene is run in full, then with a budget of a share of its
// median frame, and the governed run is replayed from its details. Of each frame the least CPU time of all runs
// counts: other programs only ever add. Prints a row a scene (docs/governor.md).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

#include "psim/psim.h"
#include "psim/scene.h"

namespace {

using namespace psim;

struct Overload {
  std::string scene;
  std::size_t particles;
  std::size_t frames;
};

const std::vector<Overload> kAll = {
    {"pile", 5000, 300},
    {"pile", 20000, 200},
    {"pile", 50000, 150},
    {"pile", 100000, 100},
    {"rough-pile", 10000, 200},
    {"rough-pile", 50000, 100},
    {"dam", 50000, 100},
    {"hourglass", 5000, 150},
    {"discs", 20000, 200},
    {"discs", 100000, 100},
    {"gas-periodic", 10000, 100},
    {"mixed-sizes", 5000, 150},
    {"mixed-sizes", 50000, 100},
    {"boxes_into_discs", 5000, 150},
    {"boxes_into_discs", 50000, 100},
    {"large_pyramid", 0, 150},
    {"many_pyramids", 0, 100},
    {"smash", 0, 150},
    {"tumbler", 500, 300},
    {"tumbler", 5000, 150},
    {"rain", 400, 300},
    {"rain", 3000, 150},
    {"joint_grid", 1000, 150},
};

// Of the calling thread.
double worked_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double quantile(std::vector<double> of, double share) {
  std::sort(of.begin(), of.end());
  return of[std::min(of.size() - 1, static_cast<std::size_t>(share * static_cast<double>(of.size())))];
}

struct Trial {
  const Scene& scene;
  std::size_t frames;
  RunOptions options;

  std::unique_ptr<World> world() const {
    std::string error;
    auto world = build_world(scene, options, error);
    if (!world) throw std::runtime_error(error);
    return world;
  }

  // Takes part in the least time of each frame.
  template <class Step>
  std::uint64_t run(World& world, std::vector<double>& least, const Step& step) const {
    world.prepare();
    least.resize(frames, 1e300);
    for (std::size_t k = 0; k < frames; ++k) {
      const double begin = worked_ms();
      step(world, k);
      least[k] = std::min(least[k], worked_ms() - begin);
    }
    return world.state_hash();
  }
};

void show(const Overload& what, double share, int runs) {
  std::string error;
  const auto scene = make_builtin(what.scene, what.particles, 1, error);
  if (!scene) throw std::runtime_error(error);
  const Trial trial{*scene, what.frames, {best_isa(), 1}};
  const auto first = trial.world();
  const CostModel costs = World::measure_costs(trial.options, first->dynamic_count(), first->shape_count());

  std::vector<double> full;
  for (int k = 0; k < runs; ++k) trial.run(*trial.world(), full, [](World& w, std::size_t) { w.step(); });
  const double budget = share * quantile(full, 0.5);

  std::vector<double> least;
  std::vector<StepDetail> details;
  std::vector<double> predicted;
  const auto governed = trial.world();
  governed->set_governor({true, budget, costs});
  const std::uint64_t hash = trial.run(*governed, least, [&](World& w, std::size_t) {
    const StepReport report = w.step();
    details.push_back(report.detail);
    predicted.push_back(report.predicted_ms);
  });
  bool same = true;
  for (int k = 0; k < runs; ++k) {
    const auto world = trial.world();
    world->set_governor({true, budget, costs});  // room is made as it was
    same &= trial.run(*world, least, [&](World& w, std::size_t frame) { w.replay(details[frame]); }) == hash;
  }

  std::size_t over = 0, time = 0, steps = 0, substeps = 0;
  std::vector<double> ratios;
  for (std::size_t k = 0; k < what.frames; ++k) {
    over += least[k] > budget;
    ratios.push_back(least[k] / predicted[k]);
    if (!details[k].solves) continue;
    ++steps;
    time += details[k].frames;
    substeps += details[k].substeps;
  }
  const double frames = static_cast<double>(what.frames);
  fmt::print(
      "| {} {} | {:.2f} | {:.2f} | {:.1f} % | {:.2f} | {:.2f} to {:.2f} | {:.0f} % | {:.1f} | {} "
      "|\n",
      what.scene, first->dynamic_count(), quantile(full, 0.5), budget, 100 * static_cast<double>(over) / frames,
      quantile(least, 0.99) / budget, quantile(ratios, 0.05), quantile(ratios, 0.95),
      100 * static_cast<double>(time) / frames,
      static_cast<double>(substeps) / static_cast<double>(std::max<std::size_t>(steps, 1)),
      same ? "same" : "DIFFERENT");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Frames over budget where the work is more than fits"};
  double share = 0.5;
  int runs = 3;
  std::string scene;
  std::size_t particles = 0, frames = 150;
  app.add_option("--share", share, "budget, of the median frame in full")->check(CLI::Range(0.01, 10.0));
  app.add_option("--runs", runs, "of which the least time counts")->check(CLI::Range(1, 100));
  app.add_option("--scene", scene, "only this one");
  app.add_option("--particles", particles, "of that scene; 0: its own number");
  app.add_option("--frames", frames, "of that scene")->check(CLI::Range(1, 1000000));
  bool costs = false;
  app.add_flag("--costs", costs, "measures what work costs here and prints the numbers (tools/cost-table)");
  CLI11_PARSE(app, argc, argv);
  if (costs) {
    for (const double ns : World::measure_costs({best_isa(), 1}, 20000, 5000).numbers()) {
      fmt::print("{}\n", ns);
    }
    return 0;
  }
  fmt::print(
      "| scene, bodies | full p50 ms | budget ms | over | p99 / budget | time / predicted, p5 to "
      "p95 | time kept | "
      "substeps | replay |\n|---|---|---|---|---|---|---|---|---|\n");
  try {
    if (!scene.empty()) {
      show({scene, particles, frames}, share, runs);
    } else {
      for (const Overload& what : kAll) show(what, share, runs);
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "overload: {}\n", e.what());
    return 1;
  }
}
