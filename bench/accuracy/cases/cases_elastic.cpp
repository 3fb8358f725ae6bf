// Elastic shapes: a gas of boxes and polygons keeps its energy; boxes thrown at a floor at many angles leave it as the
// impulse at the time of impact says.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cases/case.h"

namespace psim::accuracy {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// ---- a gas ------------------------------------------------------------------------------------

constexpr int kAcross = 10;
constexpr double kPen = 24;  // m

/// A hundred boxes, triangles and pentagons of about 0.8 m.
Scene shape_gas() {
  Scene scene = walled_scene(kPen, kPen, material(1));
  for (int k = 0; k < kAcross * kAcross; ++k) {
    const double pitch = (kPen - 2) / kAcross, turn = 2 * std::numbers::pi * k * std::numbers::phi;
    BodyDesc body = box({1 + (k % kAcross + 0.5) * pitch, 1 + (k / kAcross + 0.5) * pitch}, {0.8, 0.4}, material(1));
    if (k % 3 > 0) {
      PolygonShape polygon;
      const int corners = k % 3 == 1 ? 3 : 5;
      for (int c = 0; c < corners; ++c) {
        const double a = 2 * std::numbers::pi * c / corners;
        polygon.vertices.push_back({0.4 * std::cos(a), 0.4 * std::sin(a)});
      }
      body.shape = polygon;
    }
    body.velocity = {8 * std::cos(turn), 8 * std::sin(turn)};
    body.angle = turn;
    scene.bodies.push_back(body);
  }
  return scene;
}

Case shape_gas_case(Effort effort) {
  const double seconds = effort == Effort::quick ? 5 : 60;
  Case c;
  c.name = "shape-gas";
  c.shows = "100 elastic boxes, triangles and pentagons in a pen of 24 m, a minute";
  c.quantities = {{"shape-gas-energy", "relative", "analytic", {}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = shape_gas;
  c.measure = [seconds](Run& run) -> std::vector<double> {
    const double start = kinetic_energy(run);
    double off = 0;
    for (int k = 0; k < 6 * seconds; ++k) {
      run.frames(10);
      off = std::max(off, std::abs(kinetic_energy(run) / start - 1));
    }
    for (const BodyState& s : run.bodies()) {
      if (std::min({s.x, s.y, kPen - s.x, kPen - s.y}) < 0) throw Failed("a body left the pen");
    }
    return {off};
  };
  return c;
}

// ---- a box thrown at a floor ------------------------------------------------------------------

constexpr int kThrows = 33;
constexpr double kWidth = 1, kHeight = 0.5, kThrow = 5;  // m, m, m/s

double throw_angle(int k) { return (5.0 + 2.5 * k) * kDegree; }

/// From the centre to the lowest corner.
Vec2 lowest_corner(double angle) {
  Vec2 lowest{0, 0};
  for (const double x : {-kWidth / 2, kWidth / 2}) {
    for (const double y : {-kHeight / 2, kHeight / 2}) {
      const Vec2 at{std::cos(angle) * x - std::sin(angle) * y, std::sin(angle) * x + std::cos(angle) * y};
      if (at.y < lowest.y) lowest = at;
    }
  }
  return lowest;
}

// The gaps differ, so that impacts come at all times of a frame. Each is over a floor of its own.
Scene thrown_boxes() {
  Scene scene = open_scene(400, {0, 0});
  for (int k = 0; k < kThrows; ++k) {
    const double x = 10.0 * k - 160, angle = throw_angle(k);
    BodyDesc floor = floor_box(material(1), 3);
    floor.position.x = x;
    BodyDesc body = box({x, 0.5 + 0.007 * k - lowest_corner(angle).y}, {kWidth, kHeight}, material(1), 1);
    body.angle = angle;
    body.velocity = {0, -kThrow};
    scene.bodies.push_back(floor);
    scene.bodies.push_back(body);
  }
  return scene;
}

/// Velocities after the impact of one corner.
struct Rebound {
  double vy, omega;
};

Rebound rebound(double angle) {
  const double arm = lowest_corner(angle).x, inertia = (kWidth * kWidth + kHeight * kHeight) / 12;
  const double impulse = 2 * kThrow / (1 + arm * arm / inertia);
  return {impulse - kThrow, impulse * arm / inertia};
}

/// Whether the box is off the floor for good after the first corner: no other reaches it in the next half second.
bool hits_once(int k) {
  const double angle = throw_angle(k);
  const Rebound after = rebound(angle);
  const double height = -lowest_corner(angle).y;
  for (double t = 0.002; t < 0.5; t += 0.002) {
    if (height + after.vy * t + lowest_corner(angle + after.omega * t).y < 0) return false;
  }
  return true;
}

std::vector<double> measure_throws(Run& run) {
  const double start = kinetic_energy(run);
  run.seconds(0.4);
  double off = 0;
  for (int k = 0; k < kThrows; ++k) {
    if (!hits_once(k)) continue;
    const BodyState& s = run.body(static_cast<std::size_t>(2 * k + 1));
    const Rebound truth = rebound(throw_angle(k));
    off = std::max(
        {off, std::hypot(s.vx, s.vy - truth.vy) / kThrow, std::abs(s.omega - truth.omega) * 0.5 * kWidth / kThrow});
  }
  return {off, std::abs(kinetic_energy(run) / start - 1)};
}

Case box_impact() {
  Case c;
  c.name = "box-impact";
  c.shows =
      "elastic boxes of 1 x 0.5 m thrown at a floor at 33 angles: velocities of those that hit once, energy of all";
  c.quantities = {{"box-impact", "of the speed", "analytic", {{4, 1e-6}}},
                  {"box-impact-energy", "relative", "analytic", {{4, 1e-6}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = thrown_boxes;
  c.measure = measure_throws;
  return c;
}

// ---- a box that bounces -----------------------------------------------------------------------

Case box_bounce() {
  Case c;
  c.name = "box-bounce";
  c.shows = "elastic boxes dropped from 5 m flat, at 30 degrees and on a corner: energy over 10 s";
  c.quantities = {{"box-bounce-energy", "relative", "analytic", {{4, 1e-5}, {8, 2e-5}}}};
  c.scale = Scale::large;
  c.scene = [] {
    Scene scene = open_scene(200);
    for (int k = 0; k < 3; ++k) {
      BodyDesc floor = floor_box(material(1), 30);
      floor.position.x = 65.0 * k - 65;
      BodyDesc body = box({floor.position.x, 5.5}, {1, 1}, material(1), 1);
      body.angle = std::array{0.0, 30.0, 45.0}[static_cast<std::size_t>(k)] * kDegree;
      scene.bodies.push_back(floor);
      scene.bodies.push_back(body);
    }
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    double off = 0;
    const auto energy_of = [&](std::size_t k) {
      const BodyState& s = run.body(k);
      return 0.5 * (s.vx * s.vx + s.vy * s.vy + s.omega * s.omega / 6) + kGravity * s.y;
    };
    for (int frame = 0; frame < 10 * kFrameRate; ++frame) {
      run.frame();
      for (const std::size_t k : {1u, 3u, 5u}) off = std::max(off, std::abs(energy_of(k) / (kGravity * 5.5) - 1));
    }
    return {off};
  };
  return c;
}

}  // namespace

std::vector<Case> elastic_cases(Effort effort) { return {shape_gas_case(effort), box_impact(), box_bounce()}; }

}  // namespace psim::accuracy
