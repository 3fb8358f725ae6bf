// Elastic gases on average and for long: the distribution of speeds, the pressure of the hard-disc
// fluid, momentum and energy over very many steps.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "cases/case.h"
#include "cases/gas_scenes.h"
#include "hard_disc_fluid.h"

namespace psim::accuracy {
namespace {

constexpr double kDiameter = 1;

// ---- statistics -------------------------------------------------------------------------------

/// Equal speeds in directions spread by the golden ratio.
Scene equal_speeds(int count) {
  const double side = side_of(count, 0.2);
  Scene scene = walled_scene(side, side, material(1));
  GroupDesc group = lattice(count, side, 0, 0, 7);
  std::string error;
  const auto placed = place_group(group, error);
  if (!placed) throw std::runtime_error(error);
  group.layout = Layout::explicit_list;
  group.x = placed->x;
  group.y = placed->y;
  group.radius = {0.5};
  for (int k = 0; k < count; ++k) {
    const double turn = 2 * std::numbers::pi * k * std::numbers::phi;
    group.vx.push_back(5 * std::cos(turn));
    group.vy.push_back(5 * std::sin(turn));
  }
  scene.groups = {group};
  return scene;
}

std::vector<double> measure_speeds(Run& run, int samples) {
  run.seconds(10);
  double speed = 0, second = 0, fourth = 0, n = 0;
  for (int k = 0; k < samples; ++k) {
    run.seconds(0.5);
    for (const BodyState& s : run.bodies()) {
      speed += std::hypot(s.vx, s.vy);
      second += s.vx * s.vx + s.vy * s.vy;
      fourth += s.vx * s.vx * s.vx * s.vx + s.vy * s.vy * s.vy * s.vy;
      n += 1;
    }
  }
  const double sigma = std::sqrt(second / (2 * n));  // of one axis, as hot as the gas is now
  const double mean = speed / n / sigma, kurtosis = fourth / (2 * n) / std::pow(sigma, 4);
  return {std::abs(mean / std::sqrt(std::numbers::pi / 2) - 1), std::abs(kurtosis / 3 - 1)};
}

Case maxwell(Effort effort) {
  Case c;
  c.name = "maxwell";
  c.shows =
      "1000 elastic discs from equal speeds: the speeds become Maxwell's (statistics: 0.06 %, "
      "0.25 % with default settings, else twice that)";
  c.quantities = {{"maxwell-speed", "relative", "analytic", {{4, 0.01}}},
                  {"maxwell-kurtosis", "relative", "analytic", {{4, 0.03}}}};
  c.scale = Scale::large;
  c.timed_seconds = 1;
  c.scene = [] { return equal_speeds(1000); };
  c.machine_variants = false;
  const int samples = effort == Effort::quick ? 20 : 60;
  c.measure = [samples](Run& run) { return measure_speeds(run, run.thorough() ? 4 * samples : samples); };
  return c;
}

}  // namespace

// Z = 1 + virial / (2 N kT t). Momentum is conserved, so that N discs share the heat of N - 1:
// kT = (K - P^2/2M) / (N - 1).
double compressibility(Run& run, double seconds) {
  run.simulation().watch_impulses();
  const double before = run.simulation().virial();
  run.seconds(seconds);
  const auto n = static_cast<double>(run.bodies().size());
  const Vec2 p = momentum(run);
  const double drift = (p.x * p.x + p.y * p.y) / (2 * n * mass_of(run.model().bodies[0]));
  const double temperature = (kinetic_energy(run) - drift) / (n - 1);
  return 1 + (run.simulation().virial() - before) / (2 * n * temperature * seconds);
}

namespace {

std::vector<double> measure_pressure(Run& run, double truth, double seconds) {
  run.seconds(10);
  const double z = compressibility(run, seconds);
  return {std::abs(z / truth - 1), deepest(run) / kDiameter};
}

// At kT/m = 1, as hard-disc fluids are tabulated.
const double kThermalSpread = std::sqrt(3.0);

Case pressure(const reference::HardDiscFluid& state, Effort effort) {
  const std::string name = "pressure-" + std::to_string(state.packing).substr(0, 3);
  const bool quick = effort == Effort::quick;
  Case c;
  c.name = name;
  c.shows = "Z = pA/NkT of 1000 elastic discs at that packing, periodic, kT/m = 1 (statistics: " +
            std::string(quick ? "1 %" : "0.06 % with default settings, else 0.12 %") + ")";
  c.quantities = {{name, "relative", "Kolafa-Rottner 2006", {{4, quick ? 0.02 : 3e-3}}},
                  {name + "-penetration", "of a diameter", "analytic", {{4, 0.2}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [packing = state.packing] { return gas_in_period(1000, packing, kThermalSpread, 5); };
  c.machine_variants = false;
  c.measure = [z = state.compressibility, quick](Run& run) {
    return measure_pressure(run, z, quick ? 20 : run.thorough() ? 800 : 200);
  };
  return c;
}

// ---- a gas for long ---------------------------------------------------------------------------

std::vector<double> measure_gas(Run& run, int frames) {
  const Vec2 p = momentum(run);
  const double start = kinetic_energy(run);
  double sum = 0;
  for (std::size_t k = 0; k < run.bodies().size(); ++k) {
    sum += mass_of(run.model().bodies[k]) * std::hypot(run.body(k).vx, run.body(k).vy);
  }
  run.frames(frames);
  const Vec2 q = momentum(run);
  return {std::hypot(q.x - p.x, q.y - p.y) / sum, std::abs(kinetic_energy(run) / start - 1)};
}

Case long_gas(Effort effort) {
  const int frames = effort == Effort::quick ? 2000 : 25000;
  Case c;
  c.name = "long-gas";
  c.shows = "1000 elastic discs, packing 0.3, periodic, over " + std::to_string(frames) + " frames";
  c.quantities = {{"long-gas-momentum", "relative", "analytic", {{4, 1e-5}}},
                  {"long-gas-energy", "relative", "analytic", {{4, 1e-3}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [] { return gas_in_period(1000, 0.3, 10, 5); };
  c.measure = [frames](Run& run) { return measure_gas(run, frames); };
  return c;
}

}  // namespace

std::vector<Case> fluid_cases(Effort effort) {
  std::vector<Case> cases = {maxwell(effort), long_gas(effort)};
  for (const auto& state : reference::kHardDiscFluid) {
    if (effort == Effort::full || state.packing == 0.3) cases.push_back(pressure(state, effort));
  }
  return cases;
}

}  // namespace psim::accuracy
