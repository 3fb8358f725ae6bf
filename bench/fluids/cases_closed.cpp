// Flows without a free surface that moves: vortices that decay, and water at rest.
#include <cmath>
#include <numbers>
#include <random>

#include "cases.h"

namespace psim::fluids {
namespace {

constexpr double kPi = std::numbers::pi, kGravity = 9.81;
constexpr double kVortexViscosity = 0.01;  // Re 100: the speed is 1 m/s and the box 1 m wide

Flow vortices(int n) {
  Flow flow;
  flow.bounds = {0, 0, 1, 1};
  flow.boundary = Boundary::periodic;
  flow.spacing = 1.0 / n;
  flow.viscosity = kVortexViscosity;
  fill(flow, {0, 0}, n, n);
  std::mt19937 random(5);
  const auto jitter = [&] { return 0.2 * (static_cast<double>(random()) / 4294967296.0 - 0.5) / n; };
  for (Vec2& p : flow.places) {
    p.x += jitter(), p.y += jitter();
    flow.velocities.push_back(
        {-std::cos(2 * kPi * p.x) * std::sin(2 * kPi * p.y), std::sin(2 * kPi * p.x) * std::cos(2 * kPi * p.y)});
  }
  return flow;
}

// Kinetic energy falls as exp(-16 pi^2 nu t).
std::vector<Measured> measure_vortices(Motion& motion, const Flow&, bool quick) {
  const double before = motion.energy();
  std::vector<Measured> out;
  for (int second = 1; second <= (quick ? 1 : 5); ++second) {
    for (int k = 0; k < 60; ++k) motion.advance(1.0 / 60);
    if (second != 1 && second != 5) continue;
    const double left = std::exp(-16 * kPi * kPi * kVortexViscosity * second);
    out.push_back({"taylor-green-" + std::to_string(second) + "s", "of the energy", "law of decay",
                   motion.energy() / before / left - 1});
  }
  return out;
}

Flow water_at_rest(int layers, int depth) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  flow.bounds = {0, 0, 1, depth * 1.2};
  flow.gravity = {0, -kGravity};
  flow.speed = std::sqrt(kGravity * depth);
  flow.pressure = [depth](Vec2 p) { return kDensity * kGravity * (depth - p.y); };
  fill(flow, {0, 0}, layers, layers * depth);
  return flow;
}

// p = rho g (H - y), and nothing moves. Error of the pressure in the square mean, over that at the bottom.
std::vector<Measured> measure_rest(Motion& motion, const std::string& name, int depth, bool quick) {
  for (int k = 0; k < (quick ? 30 : 240); ++k) motion.advance(1.0 / 60);
  std::vector<Particle> particles;
  motion.look(particles);
  double off = 0, speed = 0;
  for (const Particle& p : particles) {
    const double e = p.pressure - kDensity * kGravity * std::max(0.0, depth - p.place.y);
    off += e * e;
    speed += p.velocity.x * p.velocity.x + p.velocity.y * p.velocity.y;
  }
  const auto count = static_cast<double>(particles.size());
  return {{name + "-pressure", "of the largest pressure", "rho g (H - y)",
           std::sqrt(off / count) / (kDensity * kGravity * depth)},
          {name + "-speed", "of sqrt(g H)", "rest", std::sqrt(speed / count / (kGravity * depth))}};
}

}  // namespace

Case taylor_green() {
  Case c;
  c.name = "taylor-green";
  c.shows = "vortices of Re 100 in a periodic box, from places that are a little uneven";
  c.layers = {25, 50, 100};
  c.quick_layers = 25;
  c.flow = vortices;
  c.measure = measure_vortices;
  return c;
}

Case hydrostatic(int depth) {
  Case c;
  c.name = depth == 1 ? "hydrostatic" : "hydrostatic-deep";
  c.shows = "water at rest, 1 m wide and " + std::to_string(depth) + " m deep, after 4 s";
  c.layers = depth == 1 ? std::vector{25, 50, 100} : std::vector{25, 50};
  c.finest_by_all = depth == 1;
  c.quick_layers = 20;
  c.flow = [depth](int layers) { return water_at_rest(layers, depth); };
  c.measure = [name = c.name, depth](Motion& m, const Flow&, bool quick) {
    return measure_rest(m, name, depth, quick);
  };
  return c;
}

}  // namespace psim::fluids
