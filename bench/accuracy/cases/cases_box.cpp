// Friction of boxes: sliding to a stop, and the angles at which they let go or tip over. A threshold
// is found in one run, by a row of like boxes at angles around it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cases/case.h"
#include "closed_forms.h"

namespace psim::accuracy {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Case box_slide() {
  Case c;
  c.name = "box-slide";
  c.shows = "a box slides from 5 m/s, mu = 0.5, and stops";
  c.quantities = {{"box-slide-distance", "of the way", "analytic", {{4, 0.01}}},
                  {"box-slide-creep", "m/s", "analytic", {{4, 1e-6}}}};
  c.scale = Scale::large;
  c.scene = [] {
    Scene scene = open_scene(100);
    scene.bodies = {floor_box(material(0, 0.5)), box({-4, 0.5}, {1, 1}, material(0, 0.5), 1)};
    scene.bodies[1].velocity = {5, 0};
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    const reference::Slide truth{5, 0.5, kGravity};
    run.seconds(1.5);
    const double stopped = run.body(1).x;
    run.seconds(10);
    return {std::abs((stopped + 4) / truth.distance() - 1), std::abs(run.body(1).x - stopped) / 10};
  };
  return c;
}

// ---- thresholds -------------------------------------------------------------------------------

/// Boxes on slopes of angles about `centre`, none exactly on it.
struct Fan {
  double centre = 0, half_width = 1, pitch = 0.05;  ///< degrees

  int count() const { return static_cast<int>(std::lround(2 * half_width / pitch)); }
  double angle(int k) const { return centre - half_width + (k + 0.5) * pitch; }
  /// The threshold if the first `held` of them are on its near side.
  double error(int held) const { return std::abs(held * pitch - half_width); }
};

/// Slope k is body 2 k, its box body 2 k + 1. They go down to the right.
Scene slopes(const Fan& fan, Vec2 size, Material m) {
  Scene scene = open_scene(400);
  for (int k = 0; k < fan.count(); ++k) {
    const double angle = fan.angle(k) * kDegree, x = 15.0 * k - 300;
    const Vec2 down{std::cos(angle), -std::sin(angle)}, up{-down.y, down.x};
    const auto at = [&](double along, double height) {
      return Vec2{x + along * down.x + height * up.x, along * down.y + height * up.y};
    };
    BodyDesc slab = box(at(3, -0.5), {10, 1}, m);
    slab.type = BodyType::static_body;
    slab.angle = -angle;
    BodyDesc body = box(at(0, 0.5 * size.y), size, m, 1);
    body.angle = -angle;
    scene.bodies.push_back(slab);
    scene.bodies.push_back(body);
  }
  return scene;
}

double way(const Vec2& from, const BodyState& s) { return std::hypot(s.x - from.x, s.y - from.y); }

constexpr Fan kHold{20, 1, 0.05};

// Creep: of those half a degree and more below the threshold, from one second on.
std::vector<double> measure_hold(Run& run) {
  run.seconds(1);
  std::vector<Vec2> settled;
  for (int k = 0; k < kHold.count(); ++k) {
    const BodyState& s = run.body(static_cast<std::size_t>(2 * k + 1));
    settled.push_back({s.x, s.y});
  }
  run.seconds(4);
  int held = 0;
  double creep = 0;
  for (int k = 0; k < kHold.count(); ++k) {
    const auto n = static_cast<std::size_t>(k);
    const BodyState& s = run.body(2 * n + 1);
    held += way(run.model().bodies[2 * n + 1].position, s) < 0.01 ? 1 : 0;
    if (kHold.angle(k) < kHold.centre - 0.5) creep = std::max(creep, way(settled[n], s) / 4);
  }
  return {kHold.error(held), creep};
}

Case box_hold() {
  Case c;
  c.name = "box-hold";
  c.shows =
      "40 boxes on slopes of 19 to 21 degrees, mu = tan 20: which slide in 5 s, and how fast those "
      "creep that should not";
  c.quantities = {{"box-hold-threshold", "degrees", "analytic", {{4, 0.5}}},
                  {"box-hold-creep", "m/s", "analytic", {{4, 1e-5}}}};
  c.scale = Scale::large;
  c.scene = [] { return slopes(kHold, {1, 1}, material(0, std::tan(kHold.centre * kDegree))); };
  c.measure = measure_hold;
  return c;
}

const Fan kTip{std::atan(1.0 / 3) / kDegree, 1, 0.05};

Case box_tip() {
  Case c;
  c.name = "box-tip";
  c.shows = "40 boxes of 1 x 3 m on slopes around atan(1/3) = 18.43 degrees, mu = 2: which tip in 10 s";
  c.quantities = {{"box-tip-threshold", "degrees", "analytic", {{4, 0.5}}}};
  c.scale = Scale::large;
  c.scene = [] { return slopes(kTip, {1, 3}, material(0, 2)); };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(10);
    int stand = 0;
    for (std::size_t k = 1; k < run.model().bodies.size(); k += 2) {
      stand += std::abs(run.body(k).angle - run.model().bodies[k].angle) < 0.1 ? 1 : 0;
    }
    return {kTip.error(stand)};
  };
  return c;
}

}  // namespace

std::vector<Case> box_cases(Effort) { return {box_slide(), box_hold(), box_tip()}; }

}  // namespace psim::accuracy
