// Single impacts: pairs of discs over impact parameters, mass ratios, restitution and friction; a
// disc against a wall over angles. Each is far from all others in one scene without gravity.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cases/case.h"
#include "closed_forms.h"

namespace psim::accuracy {
namespace {

constexpr double kSpeed = 7;     // m/s
constexpr double kAfter = 1.5;   // s, when all have met and parted
constexpr int kParameters = 20;  // of an impact, from head-on to grazing

struct PairKind {
  double mass_ratio;  ///< of the one at rest to the one that comes
  double radius;      ///< of the one at rest; the other has 0.5
  double restitution;
  double friction;
};

constexpr std::array<PairKind, 4> kElastic = {{{1, 0.5, 1, 0}, {10, 0.5, 1, 0}, {1000, 0.5, 1, 0}, {0.001, 0.5, 1, 0}}};
constexpr std::array<PairKind, 4> kRough = {{{1, 0.5, 0.8, 0.1}, {3, 1, 0.8, 0.1}, {1, 0.5, 0.5, 0.5}, {3, 1, 1, 1}}};

void append_pairs(const PairKind& kind, double x, Scene& scene) {
  const double reach = kind.radius + 0.5;
  for (int j = 0; j < kParameters; ++j) {
    const double y = 60.0 * j - 600, b = 0.049 * j * reach;
    BodyDesc target = disc({x, y}, {0, 0}, material(kind.restitution, kind.friction), kind.radius);
    BodyDesc comer = disc({x - reach - 2.03, y + b}, {kSpeed, 0}, material(kind.restitution, kind.friction));
    target.mass = kind.mass_ratio;
    comer.mass = 1;
    scene.bodies.push_back(target);
    scene.bodies.push_back(comer);
  }
}

Scene pairs_of(const std::array<PairKind, 4>& kinds) {
  Scene scene = open_scene(800, {0, 0});
  double x = -500;
  for (const PairKind& kind : kinds) append_pairs(kind, x += 200, scene);
  return scene;
}

reference::Disc reference_disc(const BodyDesc& d) {
  return {{d.position.x, d.position.y}, {d.velocity.x, d.velocity.y}, radius_of(d), mass_of(d), 0};
}

struct Misses {
  double sum = 0, most = 0, spin = 0;
  void add(const reference::Disc& truth, const BodyState& s) {
    const double off = std::hypot(s.vx - truth.v.x, s.vy - truth.v.y) / kSpeed;
    sum += off;
    most = std::max(most, off);
    spin = std::max(spin, std::abs(s.omega - truth.omega) * truth.radius / kSpeed);
  }
};

Misses misses_of(Run& run) {
  run.seconds(kAfter);
  Misses misses;
  for (std::size_t k = 0; k < run.model().bodies.size(); k += 2) {
    const BodyDesc &a = run.model().bodies[k], &b = run.model().bodies[k + 1];
    const auto truth =
        reference::collide(reference_disc(a), reference_disc(b), a.material.restitution, a.material.friction);
    misses.add(truth.a, run.body(k));
    misses.add(truth.b, run.body(k + 1));
  }
  return misses;
}

Case elastic_pairs() {
  Case c;
  c.name = "oblique";
  c.shows = "elastic pairs: 20 impact parameters x mass ratios 1, 10, 1000, 1/1000";
  c.quantities = {{"oblique-mean", "of the speed", "analytic", {{4, 1e-4}}},
                  {"oblique-max", "of the speed", "analytic", {{4, 1e-4}}}};
  c.timed_seconds = 1;
  c.scene = [] { return pairs_of(kElastic); };
  c.measure = [](Run& run) -> std::vector<double> {
    const Misses misses = misses_of(run);
    return {misses.sum / static_cast<double>(run.model().bodies.size()), misses.most};
  };
  return c;
}

Case rough_pairs() {
  Case c;
  c.name = "oblique-rough";
  c.shows = "pairs with restitution, friction and spin: 20 impact parameters x 4 kinds";
  c.quantities = {{"oblique-rough-speed", "of the speed", "analytic", {{4, 1e-3}}},
                  {"oblique-rough-spin", "of the speed", "analytic", {{4, 1e-3}}}};
  c.timed_seconds = 1;
  c.scene = [] { return pairs_of(kRough); };
  c.measure = [](Run& run) -> std::vector<double> {
    const Misses misses = misses_of(run);
    return {misses.most, misses.spin};
  };
  return c;
}

// ---- a wall -----------------------------------------------------------------------------------

constexpr std::array<double, 5> kWallAngles = {15, 30, 45, 60, 75};  // degrees from the normal
constexpr double kWallRestitution = 0.8, kWallFriction = 0.3;

Scene thrown_at_wall() {
  Scene scene = open_scene(200, {0, 0});
  const Material m = material(kWallRestitution, kWallFriction);
  scene.bodies = {ground(m, 150)};
  for (std::size_t k = 0; k < kWallAngles.size(); ++k) {
    const double angle = kWallAngles[k] * std::numbers::pi / 180;
    scene.bodies.push_back(
        disc({40.0 * static_cast<double>(k) - 90, 2.5}, {kSpeed * std::sin(angle), -kSpeed * std::cos(angle)}, m));
  }
  return scene;
}

std::vector<double> measure_wall(Run& run) {
  run.seconds(kAfter);
  double speed = 0, spin = 0;
  for (std::size_t k = 0; k < kWallAngles.size(); ++k) {
    const double angle = kWallAngles[k] * std::numbers::pi / 180;
    const double along = kSpeed * std::sin(angle), onto = kSpeed * std::cos(angle);
    const double kept = reference::wall_tangential_ratio(angle, kWallRestitution, kWallFriction);
    const BodyState& s = run.body(k + 1);
    speed = std::max(speed, std::hypot(s.vx - kept * along, s.vy - kWallRestitution * onto));
    spin = std::max(spin, std::abs(-s.omega - reference::wall_spin(along, kept, 0.5)) * 0.5);
  }
  return {speed / kSpeed, spin / kSpeed};
}

Case wall() {
  Case c;
  c.name = "wall";
  c.shows = "a disc thrown at a wall at 15 to 75 degrees, e = 0.8, mu = 0.3";
  c.quantities = {{"wall-speed", "of the speed", "analytic", {{4, 1e-3}}},
                  {"wall-spin", "of the speed", "analytic", {{4, 1e-3}}}};
  c.timed_seconds = 1;
  c.scene = thrown_at_wall;
  c.measure = measure_wall;
  return c;
}

}  // namespace

std::vector<Case> impact_cases(Effort) { return {elastic_pairs(), rough_pairs(), wall()}; }

}  // namespace psim::accuracy
