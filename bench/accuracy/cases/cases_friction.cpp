// Friction in lasting contact: stopping, rolling, inclines, and the thresholds at which something
// lets go. A threshold is found in one run, by a row of like bodies at angles around it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cases/case.h"
#include "closed_forms.h"

namespace psim::accuracy {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// ---- level ground -----------------------------------------------------------------------------

Case slide() {
  Case c;
  c.name = "slide";
  c.shows = "what cannot turn slides from 5 m/s, mu = 0.5, and stops";
  c.quantities = {{"slide-distance", "of the way", "analytic", {{4, 5e-3}}},
                  {"slide-creep", "m/s", "analytic", {{4, 1e-6}}}};
  c.scene = [] {
    Scene scene = open_scene(100);
    BodyDesc body = disc({-50, 0.5}, {5, 0}, material(0, 0.5));
    body.fixed_rotation = true;
    scene.bodies = {ground(material(0, 0.5)), body};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    const reference::Slide truth{5, 0.5, kGravity};
    run.seconds(1.5);
    const double stopped = run.body(1).x;
    run.seconds(10);
    return {std::abs((stopped + 50) / truth.distance() - 1), std::abs(run.body(1).x - stopped) / 10};
  };
  return c;
}

Case slide_to_roll() {
  Case c;
  c.name = "roll";
  c.shows = "a disc set down at 5 m/s without spin, mu = 0.2, comes to roll: after 4 s";
  c.quantities = {{"roll-speed", "of the speed", "analytic", {{4, 5e-3}}},
                  {"roll-distance", "of the way", "analytic", {{4, 5e-3}}}};
  c.scene = [] {
    Scene scene = open_scene(100);
    scene.bodies = {ground(material(0, 0.2)), disc({-50, 0.5}, {5, 0}, material(0, 0.2))};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    const reference::SlideToRoll truth{5, 0.2, kGravity};
    run.seconds(4);
    const BodyState& s = run.body(1);
    const double v = truth.rolling_speed();
    return {std::max(std::abs(s.vx / v - 1), std::abs(-s.omega * 0.5 / v - 1)),
            std::abs((s.x + 50) / truth.position(4) - 1)};
  };
  return c;
}

// ---- inclines ---------------------------------------------------------------------------------

/// A slope of `angle` degrees down to the right, of length `length`, and a disc at its upper end.
void append_slope(Vec2 top, double angle, double length, Material m, bool turns, Scene& scene) {
  const Vec2 down{std::cos(angle * kDegree), -std::sin(angle * kDegree)};
  const Vec2 normal{-down.y, down.x};
  const auto at = [&](double s, double height) {
    return Vec2{top.x + s * down.x + height * normal.x, top.y + s * down.y + height * normal.y};
  };
  scene.bodies.push_back(segment(at(-1, 0), at(length, 0), m));
  BodyDesc body = disc(at(0, 0.5), {0, 0}, m);
  body.fixed_rotation = !turns;
  scene.bodies.push_back(body);
}

constexpr std::array<double, 5> kSlopes = {10, 30, 41, 44, 60};  // rolls up to atan 0.9 = 41.99
constexpr double kSlopeFriction = 0.3;

std::vector<double> measure_inclines(Run& run) {
  run.seconds(1);
  double worst = 0;
  for (std::size_t k = 0; k < kSlopes.size(); ++k) {
    const reference::Incline truth{kSlopes[k] * kDegree, kSlopeFriction, 0.5, kGravity};
    const BodyState& s = run.body(2 * k + 1);
    const Vec2 start = run.model().bodies[2 * k + 1].position;
    const double a = truth.acceleration();
    worst = std::max({worst, std::abs(std::hypot(s.x - start.x, s.y - start.y) / (0.5 * a) - 1),
                      std::abs(std::hypot(s.vx, s.vy) / a - 1), std::abs(-s.omega / truth.angular_acceleration() - 1)});
  }
  return {worst};
}

Case inclines() {
  Case c;
  c.name = "incline";
  c.shows = "discs roll or slip down slopes of 10 to 60 degrees, mu = 0.3: way, speed, spin after 1 s";
  c.quantities = {{"incline", "relative", "analytic", {{4, 5e-3}}}};
  c.timed_seconds = 1;
  c.scene = [] {
    Scene scene = open_scene(200);
    double x = -100;
    for (const double angle : kSlopes) {
      append_slope({x += 20, 0}, angle, 10, material(0, kSlopeFriction), true, scene);
    }
    return scene;
  };
  c.measure = measure_inclines;
  return c;
}

// ---- thresholds -------------------------------------------------------------------------------

/// Angles about `centre`, none exactly on it.
struct Fan {
  double centre = 0, half_width = 1, pitch = 0.05;  ///< degrees

  int count() const { return static_cast<int>(std::lround(2 * half_width / pitch)); }
  double angle(int k) const { return centre - half_width + (k + 0.5) * pitch; }
  /// The threshold if the first `held` of them are on its near side.
  double error(int held) const { return std::abs(centre - half_width + held * pitch - centre); }
};

constexpr Fan kHold{20, 1, 0.05};

Case hold() {
  Case c;
  c.name = "hold";
  c.shows = "40 bodies that cannot turn on slopes of 19 to 21 degrees, mu = tan 20: which slide in 5 s";
  c.quantities = {{"hold-threshold", "degrees", "analytic", {{4, 0.5}}}};
  c.scene = [] {
    Scene scene = open_scene(400);
    const Material m = material(0, std::tan(kHold.centre * kDegree));
    for (int k = 0; k < kHold.count(); ++k) {
      append_slope({15.0 * k - 300, 0}, kHold.angle(k), 8, m, false, scene);
    }
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(5);
    int held = 0;
    for (std::size_t k = 1; k < run.model().bodies.size(); k += 2) {
      const Vec2 start = run.model().bodies[k].position;
      held += std::hypot(run.body(k).x - start.x, run.body(k).y - start.y) < 0.01 ? 1 : 0;
    }
    return {kHold.error(held)};
  };
  return c;
}

constexpr Fan kThree{15, 2, 0.1};
constexpr double kThreeTop = 0.5 + std::numbers::sqrt3 / 2;

/// One disc on two that touch on level ground, between dividers that keep the fallen away from
/// the neighbours.
void append_three(double x, double friction, Scene& scene) {
  const Material m = material(0, friction);
  scene.bodies.push_back(disc({x - 0.5, 0.5}, {0, 0}, m));
  scene.bodies.push_back(disc({x + 0.5, 0.5}, {0, 0}, m));
  scene.bodies.push_back(disc({x, kThreeTop}, {0, 0}, m));
  scene.bodies.push_back(segment({x + 3, 0}, {x + 3, 3}, m));
}

Case three_discs() {
  Case c;
  c.name = "three-discs";
  c.shows = "one disc on two, 40 times with mu = tan 13 to tan 17 degrees: which stand for 10 s";
  c.quantities = {{"three-discs-threshold", "degrees", "analytic", {{4, 0.5}}}};
  c.scale = Scale::large;
  c.scene = [] {
    Scene scene = open_scene(300);
    for (int k = 0; k < kThree.count(); ++k) {
      append_three(6.0 * k - 120, std::tan(kThree.angle(k) * kDegree), scene);
    }
    scene.bodies.push_back(ground(material(0, 1), 200));
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(10);
    int fallen = 0;
    for (std::size_t k = 2; k < run.model().bodies.size(); k += 4) {
      fallen += run.body(k).y < kThreeTop - 0.05 ? 1 : 0;
    }
    return {kThree.error(fallen)};
  };
  return c;
}

}  // namespace

std::vector<Case> friction_cases(Effort) { return {slide(), slide_to_roll(), inclines(), hold(), three_discs()}; }

}  // namespace psim::accuracy
