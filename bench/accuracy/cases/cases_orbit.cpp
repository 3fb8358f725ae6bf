// Smooth forces: a Kepler orbit against its closed form, and a path between two wells, which has
// none and is held against the limit of psim's own runs.
#include <algorithm>
#include <array>
#include <cmath>

#include "cases/case.h"
#include "closed_forms.h"
#include "convergence.h"

namespace psim::accuracy {
namespace {

const reference::Orbit kOrbit;
constexpr int kOrbits = 10;

Scene orbit() {
  Scene scene = open_scene(100, {0, 0});
  scene.world.fields = {WellField{{0, 0}, kOrbit.gm, 0, 2, 0}};
  const auto v = kOrbit.start_velocity();
  scene.bodies = {disc({kOrbit.start().x, 0}, {v.x, v.y}, material(0), 0.01)};
  return scene;
}

struct Drift {
  double energy = 0;    ///< largest, relative
  double momentum = 0;  ///< of angular momentum
};

Drift follow_orbit(Run& run, int frames) {
  Drift drift;
  for (int k = 0; k < frames; ++k) {
    run.frame();
    const BodyState& s = run.body(0);
    const double e = kOrbit.energy_of({s.x, s.y}, {s.vx, s.vy});
    const double l = s.x * s.vy - s.y * s.vx;
    drift.energy = std::max(drift.energy, std::abs(e / kOrbit.energy() - 1));
    drift.momentum = std::max(drift.momentum, std::abs(l / kOrbit.angular_momentum() - 1));
  }
  return drift;
}

Case kepler() {
  Case c;
  c.name = "kepler";
  c.shows = "ten Kepler orbits, GM 1000, a 10 m, e 0.5, from the pericentre";
  c.quantities = {{"kepler-energy", "relative", "analytic", {{4, 4e-4}, {8, 3e-5}}},
                  {"kepler-momentum", "relative", "analytic", {{4, 1e-4}, {8, 3e-5}}},
                  {"kepler-position", "m", "analytic", {{8, 1e-2}}}};
  c.scene = orbit;
  c.measure = [](Run& run) -> std::vector<double> {
    const Drift drift = follow_orbit(run, static_cast<int>(kOrbits * kOrbit.period() * kFrameRate));
    const auto truth = kOrbit.position(run.time());
    return {drift.energy, drift.momentum, std::hypot(run.body(0).x - truth.x, run.body(0).y - truth.y)};
  };
  return c;
}

Case kepler_long() {
  Case c;
  c.name = "kepler-long";
  c.shows = "332 Kepler orbits: 125,000 frames, a million substeps of 1/480 s";
  c.quantities = {{"kepler-long-energy", "relative", "analytic", {{8, 3e-4}}},
                  {"kepler-long-momentum", "relative", "analytic", {{8, 3e-4}}}};
  c.scene = orbit;
  c.measure = [](Run& run) -> std::vector<double> {
    const Drift drift = follow_orbit(run, 125000);
    return {drift.energy, drift.momentum};
  };
  return c;
}

// ---- between two wells ------------------------------------------------------------------------

constexpr double kWellsTime = 3;

Scene two_wells() {
  Scene scene = open_scene(100, {0, 0});
  scene.world.fields = {WellField{{-3, 0}, 60, 0.5, 2, 0}, WellField{{3, 0}, 40, 0.5, 2, 0}};
  scene.bodies = {disc({0, 4}, {2, 0}, material(0), 0.01)};
  return scene;
}

Vec2 end_of_path(Run& run) {
  run.seconds(kWellsTime);
  return {run.body(0).x, run.body(0).y};
}

// By Richardson from psim's runs of fourth order with 4, 8 and 16 substeps.
Vec2 two_wells_limit() {
  const Model model = make_model(two_wells());
  std::array<double, 3> x{}, y{};
  for (std::size_t k = 0; k < 3; ++k) {
    Setting setting;
    setting.integrator = integrator_name(Integrator::symplectic4);
    setting.substeps = 4 << k;
    Run run(model, psim_engine().make(model, setting));
    const Vec2 end = end_of_path(run);
    x[k] = end.x;
    y[k] = end.y;
  }
  return {reference::richardson(x, 4).limit, reference::richardson(y, 4).limit};
}

Case wells() {
  Case c;
  c.name = "two-wells";
  c.shows = "a path between two softened wells, place after 3 s";
  c.quantities = {{"two-wells", "m", "Richardson", {{4, 1e-3}}}};
  c.scene = two_wells;
  c.measure = [](Run& run) -> std::vector<double> {
    static const Vec2 truth = two_wells_limit();
    const Vec2 end = end_of_path(run);
    return {std::hypot(end.x - truth.x, end.y - truth.y)};
  };
  return c;
}

}  // namespace

std::vector<Case> orbit_cases(Effort effort) {
  if (effort == Effort::quick) return {kepler(), wells()};
  return {kepler(), kepler_long(), wells()};
}

}  // namespace psim::accuracy
