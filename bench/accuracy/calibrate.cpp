#include "calibrate.h"

#include <time.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "calibrate_rigid.h"
#include "cases/case.h"
#include "cases/gas_scenes.h"
#include "check/scene_kind.h"
#include "closed_forms.h"
#include "hard_disc_fluid.h"
#include "psim/psim.h"

namespace psim::accuracy {
namespace {

/// A scene that stands for its kind.
struct Reference {
  std::string measure;
  std::function<Scene(std::uint64_t seed)> scene;
  int seeds = 1;  ///< the error is the mean over so many
  std::function<double(Run&)> error;
  std::function<double(const Scene&)> own_error;  ///< instead of `error`, in a world of psim
  double dt = 1.0 / kFrameRate;
  std::function<Scene()> timed;  ///< another scene to time; empty: the same
  std::vector<Integrator> integrators = {Integrator::verlet};
};

// ---- fields -------------------------------------------------------------------------------------

Scene builtin(std::string_view name, std::uint64_t discs, std::uint64_t seed) {
  std::string error;
  auto scene = make_builtin(name, discs, seed, error);
  if (!scene) throw std::runtime_error(error);
  for (GroupDesc& group : scene->groups) group.seed = seed;
  return std::move(*scene);
}

double energy_error_in_ten_orbits(Run& run, double dt) {
  const reference::Orbit orbit;
  double worst = 0;
  for (int k = 0; k < static_cast<int>(10 * orbit.period() / dt); ++k) {
    run.frame();
    const BodyState& s = run.body(0);
    worst = std::max(worst, std::abs(orbit.energy_of({s.x, s.y}, {s.vx, s.vy}) / orbit.energy() - 1));
  }
  return worst;
}

Reference orbit(double dt) {
  const Case kepler = orbit_cases(Effort::quick).front();
  Reference r;
  r.dt = dt;
  r.measure = "largest relative error of the energy over ten Kepler orbits of eccentricity 0.5";
  r.scene = [kepler](std::uint64_t) { return kepler.scene(); };
  r.error = [dt](Run& run) { return energy_error_in_ten_orbits(run, dt); };
  r.timed = [] { return builtin("orbits", 2000, 1); };
  r.integrators.assign(std::begin(kAllIntegrators), std::end(kAllIntegrators));
  return r;
}

// ---- gas ----------------------------------------------------------------------------------------

// The mean error over ten stretches, or what chance leaves of it if that is more.
double pressure_error(Run& run, double truth, double seconds) {
  constexpr int kStretches = 10;
  double sum = 0, squares = 0;
  run.seconds(10);
  for (int k = 0; k < kStretches; ++k) {
    const double off = compressibility(run, seconds / kStretches) / truth - 1;
    sum += off;
    squares += off * off;
  }
  const double mean = sum / kStretches;
  const double chance = std::sqrt((squares / kStretches - mean * mean) / (kStretches - 1));
  return std::max(std::abs(mean), chance);
}

Reference gas(std::size_t state, double speed, Effort effort) {
  const reference::HardDiscFluid& fluid = reference::kHardDiscFluid[state];
  Reference r;
  r.measure = "relative error of the pressure of an elastic gas";
  r.scene = [=](std::uint64_t seed) { return gas_in_period(1000, fluid.packing, speed, seed); };
  r.error = [=](Run& run) { return pressure_error(run, fluid.compressibility, effort == Effort::quick ? 5 : 200); };
  return r;
}

// ---- piles --------------------------------------------------------------------------------------

double overlap_at_rest(Run& run) {
  run.seconds(10);
  return quantile(penetrations(run), 0.99) / (2 * radius_of(run.model().bodies[0]));
}

/// Narrows a pile's world to so many columns.
void stack_up(Scene& scene, double columns) {
  GroupDesc& group = scene.groups[0];
  const double rows = std::ceil(static_cast<double>(group.count) / columns);
  const double width = columns * 1.02 + 1, height = rows * 1.02;
  scene.world.bounds = {0, 0, width, 2 * height};
  group.region = {0.5, 0.5, width - 0.5, 0.5 + height};
}

/// Of every ten discs one is a hundred times heavier than the others.
void add_heavy_ones(Scene& scene) {
  GroupDesc& light = scene.groups[0];
  std::string error;
  const auto placed = place_group(light, error);
  if (!placed) throw std::runtime_error(error);
  light.layout = Layout::explicit_list;
  light.radius = {0.5};
  GroupDesc heavy = light;
  heavy.body.material.density *= 100;
  for (std::size_t k = 0; k < placed->x.size(); ++k) {
    GroupDesc& group = k % 10 == 5 ? heavy : light;
    group.x.push_back(placed->x[k]);
    group.y.push_back(placed->y[k]);
    group.vx.push_back(0);
    group.vy.push_back(0);
  }
  light.count = light.x.size();
  heavy.count = heavy.x.size();
  scene.groups.push_back(heavy);
}

Reference pile(std::string_view name, const std::function<void(Scene&)>& change, Effort effort) {
  Reference r;
  r.measure = "overlap at rest in diameters; 99 % of contacts have less";
  r.scene = [=](std::uint64_t seed) {
    Scene scene = builtin(name, 1000, seed);
    if (change) change(scene);
    return scene;
  };
  r.seeds = effort == Effort::quick ? 1 : 3;
  r.error = overlap_at_rest;
  return r;
}

// ---- shapes and joints ----------------------------------------------------------------------------

Reference rigid(std::string measure, std::function<Scene(std::uint64_t)> scene, double (*error)(const Scene&)) {
  Reference r;
  r.measure = std::move(measure);
  r.scene = std::move(scene);
  r.own_error = error;
  return r;
}

void add_rigid(std::vector<Reference>& references) {
  const std::string rest = "overlap at rest in sizes; 99 % of contacts have less; or the energy gained if it is more";
  const std::string kept = "largest relative change of the energy of elastic shapes in ten seconds";
  const std::string gap = "largest gap of a pin in sizes of a body in ten seconds";
  references.push_back(rigid(rest, pyramid_of_boxes, shapes_error));
  for (const double width : {16.0, 6.0}) {
    references.push_back(rigid(
        rest, [=](std::uint64_t seed) { return heap_of_boxes(width, seed); }, shapes_error));
  }
  for (const double speed : {2.0, 10.0}) {
    references.push_back(rigid(
        kept, [=](std::uint64_t seed) { return gas_of_boxes(speed, seed); }, elastic_shapes_error));
  }
  constexpr std::pair<const char*, std::uint64_t> kPinned[] = {
      {"chain", 30}, {"joint_grid", 400}, {"ball_and_chain", 30}};
  for (const auto& [name, bodies] : kPinned) {
    references.push_back(rigid(
        gap, [name = name, bodies = bodies](std::uint64_t) { return pinned(name, bodies); }, joints_error));
  }
}

std::vector<Reference> references(Effort effort) {
  const auto tall = [](Scene& scene) { stack_up(scene, 8); };
  std::vector<Reference> all = {orbit(1.0 / 60),
                                orbit(1.0 / 6),
                                gas(4, 10, effort),
                                gas(1, 60, effort),
                                pile("pile", {}, effort),
                                pile("pile", tall, effort),
                                pile("rough-pile", {}, effort),
                                pile("rough-pile", tall, effort),
                                pile("pile", add_heavy_ones, effort)};
  add_rigid(all);
  return all;
}

// ---- measuring ----------------------------------------------------------------------------------

double mean_error(const Reference& r, const Setting& setting) {
  double sum = 0;
  for (int seed = 1; seed <= r.seeds; ++seed) {
    if (r.own_error) {
      Scene scene = r.scene(static_cast<std::uint64_t>(seed));
      scene.world.substeps = setting.substeps;
      scene.world.dt = setting.frame;
      sum += r.own_error(scene);
      continue;
    }
    const Model model = make_model(r.scene(static_cast<std::uint64_t>(seed)));
    Run run(model, psim_engine().make(model, setting));
    try {
      sum += r.error(run);
    } catch (const Failed&) {
      return std::numeric_limits<double>::infinity();
    }
  }
  return sum / r.seeds;
}

struct Cost {
  double bodies = 0, pairs = 0, ns_per_frame = 0;
};

/// Time that this thread has run, ns.
double own_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

// Seconds 1 and 2 of the scene: falling discs have met by then.
Cost cost_of(const Scene& original, Integrator integrator, int substeps) {
  Scene scene = original;
  scene.world.substeps = substeps;
  scene.world.integrator = integrator;
  std::string error;
  const auto world = build_world(scene, {best_isa(), 1}, error);
  if (!world) throw std::runtime_error(error);
  world->set_sleeping(false);
  Cost cost;
  std::vector<double> ns;
  for (int k = 0; k < 2 * kFrameRate; ++k) {
    const double begin = own_ns();
    const StepReport report = world->step();
    const double took = own_ns() - begin;
    if (k < kFrameRate) continue;
    ns.push_back(took);
    cost.pairs += static_cast<double>(report.pairs) / kFrameRate;
  }
  const auto middle = ns.begin() + static_cast<std::ptrdiff_t>(ns.size() / 2);
  std::nth_element(ns.begin(), middle, ns.end());
  cost.ns_per_frame = *middle;
  cost.bodies = static_cast<double>(world->dynamic_count());
  return cost;
}

std::string digits(double value, int count) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, count).ptr;
  return {text, end};
}

void append_rows(const Reference& r, Effort effort, std::ostream& out) {
  const Scene scene = r.own_error ? r.scene(1) : make_model(r.scene(1)).scene;
  const Scene timed = r.timed ? make_model(r.timed()).scene : scene;
  const SceneTraits traits = traits_of(scene);
  for (const Integrator integrator : r.integrators) {
    for (const int substeps : {1, 2, 4, 8, 16, 32, 64}) {
      if (effort == Effort::quick && substeps != 1 && substeps != 8) continue;
      Setting setting;
      setting.integrator = integrator_name(integrator);
      setting.substeps = substeps;
      setting.frame = r.dt;
      const Cost cost = cost_of(timed, integrator, substeps);
      out << scene_kind_name(traits.kind) << ',' << r.measure << ',' << setting.integrator << ','
          << digits(traits.rate, 6) << ',' << digits(r.dt, 6) << ',' << substeps << ','
          << digits(mean_error(r, setting), 4) << ',' << cost.bodies << ',' << digits(cost.pairs, 6) << ','
          << digits(cost.ns_per_frame, 4) << '\n';
    }
  }
  std::fprintf(stderr, "%s, rate %.3g /s\n", std::string(scene_kind_name(traits.kind)).c_str(), traits.rate);
}

}  // namespace

std::string calibrate(Effort effort) {
  std::ostringstream table;
  table << "kind,measure,integrator,rate,dt,substeps,error,bodies,pairs,ns_per_frame\n";
  for (const Reference& r : references(effort)) append_rows(r, effort, table);
  return table.str();
}

}  // namespace psim::accuracy
