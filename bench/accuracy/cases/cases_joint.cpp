// Joints: pendulums on rods and pins, a spring, a chain at rest. Trajectories for short times only,
// as double pendulums are chaotic.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cases/case.h"
#include "pendulums.h"

namespace psim::accuracy {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDt = 1.0 / kFrameRate;

/// A body of 1 kg as good as a point.
BodyDesc point(Vec2 position) {
  BodyDesc body = disc(position, {0, 0}, material(0), 0.01);
  body.mass = 1;
  body.fixed_rotation = true;
  return body;
}

// ---- a pendulum -------------------------------------------------------------------------------

constexpr int kSwings = 10;

// A swing ends where the body turns back on the side that it came from; in between frames by its
// speed, which there goes through zero in a straight line.
std::vector<double> measure_pendulum(Run& run) {
  const double period = reference::pendulum_period(1, kPi / 2, kGravity);
  const int most = static_cast<int>(std::lround(1.5 * kSwings * period * kFrameRate));
  double before = 0, stretch = 0;
  for (int turns = 0; run.frame_count() < most;) {
    run.frame();
    const BodyState& s = run.body(1);
    stretch = std::max(stretch, std::abs(std::hypot(s.x, s.y) - 1));
    const double turning = s.x * s.vy - s.y * s.vx;
    if (before > 0 && turning <= 0 && ++turns == kSwings) {
      const double end = run.time() - kDt * -turning / (before - turning);
      const double height = s.y + 0.5 * (s.vx * s.vx + s.vy * s.vy) / kGravity;
      return {std::abs(end / (kSwings * period) - 1), std::abs(height), stretch};
    }
    before = turning;
  }
  throw Failed("it came to rest");
}

Case pendulum() {
  Case c;
  c.name = "pendulum";
  c.shows = "a mass on a rod of 1 m from 90 degrees: ten periods, the height left, the rod's length";
  c.quantities = {{"pendulum-period", "relative", "analytic", {{4, 5e-4}}},
                  {"pendulum-height", "of the length", "analytic", {{4, 5e-3}}},
                  {"pendulum-length", "m", "analytic", {{4, 5e-5}}}};
  c.scale = Scale::large;
  c.scene = [] {
    Scene scene = open_scene(50);
    scene.bodies = {peg({0, 0}), point({1, 0})};
    join(scene, JointType::distance, 0, 1);
    return scene;
  };
  c.measure = measure_pendulum;
  return c;
}

// ---- double pendulums -------------------------------------------------------------------------

double off(double angle, double truth) { return std::abs(std::remainder(angle - truth, 2 * kPi)); }

Case double_pendulum() {
  Case c;
  c.name = "double-pendulum";
  c.shows = "two masses on rods of 1 m, let go level: the angles after 1 s";
  c.quantities = {{"double-pendulum", "rad", "Runge-Kutta", {{4, 2e-3}}}};
  c.scale = Scale::large;
  c.timed_seconds = 1;
  c.scene = [] {
    Scene scene = open_scene(50);
    scene.bodies = {peg({0, 0}), point({1, 0}), point({2, 0})};
    join(scene, JointType::distance, 0, 1);
    join(scene, JointType::distance, 1, 2);
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    const auto truth = reference::DoublePendulum{1, 1, 0, kGravity}.after(1, {kPi / 2, kPi / 2, 0, 0});
    run.seconds(1);
    const BodyState &p = run.body(1), &q = run.body(2);
    return {std::max(off(std::atan2(p.x, -p.y), truth[0]), off(std::atan2(q.x - p.x, p.y - q.y), truth[1]))};
  };
  return c;
}

constexpr double kRodWidth = 0.1;

Case double_rods() {
  Case c;
  c.name = "double-rods";
  c.shows = "two boxes of 1 x 0.1 m pinned end to end, let go level: the angles after 1 s";
  c.quantities = {{"double-rods", "rad", "Runge-Kutta", {{4, 5e-3}}}};
  c.scale = Scale::large;
  c.timed_seconds = 1;
  c.scene = [] {
    Scene scene = open_scene(50);
    // Pinned to something that they do not reach.
    scene.bodies = {peg({0, 3}), box({0.5, 0}, {1, kRodWidth}, material(0), 1),
                    box({1.5, 0}, {1, kRodWidth}, material(0), 1)};
    join(scene, JointType::revolute, 0, 1, {0, -3}, {-0.5, 0});
    join(scene, JointType::revolute, 1, 2, {0.5, 0}, {-0.5, 0});
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    const reference::DoublePendulum rods{1, 0.5, (1 + kRodWidth * kRodWidth) / 12, kGravity};
    const auto truth = rods.after(1, {kPi / 2, kPi / 2, 0, 0});
    run.seconds(1);
    return {std::max(off(run.body(1).angle + kPi / 2, truth[0]), off(run.body(2).angle + kPi / 2, truth[1]))};
  };
  return c;
}

// ---- a spring ---------------------------------------------------------------------------------

constexpr double kAmplitude = 0.1;
constexpr int kPeriods = 100;  // of a second each

/// The top of the parabola through the largest of the samples and its neighbours.
double peak(const std::vector<double>& samples) {
  std::size_t at = 1;
  for (std::size_t k = 1; k + 1 < samples.size(); ++k) at = samples[k] > samples[at] ? k : at;
  const double a = samples[at - 1], b = samples[at], c = samples[at + 1];
  const double bend = a - 2 * b + c;
  return bend < 0 ? b - (c - a) * (c - a) / (8 * bend) : b;
}

std::vector<double> measure_oscillator(Run& run) {
  double astray = 0;
  std::vector<double> last;
  for (int frame = 1; frame <= (kPeriods + 1) * kFrameRate; ++frame) {
    run.frame();
    const double x = run.body(1).x - 1;
    if (frame <= kFrameRate) {
      astray = std::max(astray, std::abs(x / kAmplitude - std::cos(2 * kPi * frame * kDt)));
    }
    if (frame >= kPeriods * kFrameRate - 30) last.push_back(x);
  }
  return {std::abs(peak(last) / kAmplitude - 1), astray};
}

Case oscillator() {
  Case c;
  c.name = "oscillator";
  c.shows = "a mass on a spring of 1 Hz: the amplitude after 100 periods, its place during the first";
  c.quantities = {{"oscillator-amplitude", "relative", "analytic", {{4, 1e-3}}},
                  {"oscillator-place", "of the amplitude", "analytic", {{4, 1e-2}}}};
  c.scale = Scale::large;
  c.scene = [] {
    Scene scene = open_scene(50, {0, 0});
    scene.bodies = {peg({0, 0}), point({1 + kAmplitude, 0})};
    JointDesc& spring = join(scene, JointType::spring, 0, 1).joint;
    spring.length = 1;
    spring.stiffness = 4 * kPi * kPi;
    return scene;
  };
  c.measure = measure_oscillator;
  return c;
}

// ---- a chain ----------------------------------------------------------------------------------

constexpr int kLinks = 20;
constexpr double kLink = 0.6, kSpan = 10;

// It starts as a V, taut, and comes to rest by drag.
Scene chain() {
  Scene scene = open_scene(50);
  scene.world.linear_damping = 1.2;
  const double half = 0.5 * kLinks * kLink, run = 0.5 * kSpan;
  const double deep = std::sqrt(half * half - run * run);
  scene.bodies = {peg({-run, 0})};
  for (int k = 1; k < kLinks; ++k) {
    const double along = k * kLink / half;
    scene.bodies.push_back(point({run * (along - 1), -deep * std::min(along, 2 - along)}));
  }
  scene.bodies.push_back(peg({run, 0}));
  for (std::size_t k = 0; k < kLinks; ++k) {
    join(scene, JointType::distance, k, k + 1).joint.length = kLink;
  }
  return scene;
}

Case hanging_chain() {
  Case c;
  c.name = "chain";
  c.shows = "20 rods, 12 m in all, hung up 10 m apart: sag and longest stretch of a rod after 30 s";
  c.quantities = {{"chain-sag", "m", "analytic", {{4, 1e-4}}}, {"chain-stretch", "of a link", "analytic", {{4, 1e-3}}}};
  c.scale = Scale::large;
  c.scene = chain;
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(30);
    double stretch = 0;
    for (std::size_t k = 0; k < kLinks; ++k) {
      const BodyState a = run.body(k), b = run.body(k + 1);
      stretch = std::max(stretch, std::abs(std::hypot(b.x - a.x, b.y - a.y) / kLink - 1));
    }
    const double truth = reference::chain_sag(kLinks, kLink, kSpan);
    return {std::abs(-run.body(kLinks / 2).y - truth), stretch};
  };
  return c;
}

}  // namespace

std::vector<Case> joint_cases(Effort) {
  return {pendulum(), double_pendulum(), double_rods(), oscillator(), hanging_chain()};
}

}  // namespace psim::accuracy
