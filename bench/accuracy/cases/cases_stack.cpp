// Boxes that stand: stacks, a pyramid, heavy on light. All start where they should stay, so every
// way that they have gone is an error: sunk, or gone sideways; with the motion that is left.
#include <algorithm>
#include <cmath>
#include <string>

#include "cases/case.h"

namespace psim::accuracy {
namespace {

const Material kGrip = material(0, 0.6);

/// From where the scene has the body.
double way(Run& run, std::size_t body) {
  const Vec2 start = run.model().bodies[body].position;
  return std::hypot(run.body(body).x - start.x, run.body(body).y - start.y);
}

double sideways(Run& run) {
  double most = 0;
  for (std::size_t k = 1; k < run.bodies().size(); ++k) {
    most = std::max(most, std::abs(run.body(k).x - run.model().bodies[k].position.x));
  }
  return most;
}

/// Of the topmost box, the last of the scene, at the end of ten seconds.
std::vector<double> measure_standing(Run& run) {
  run.seconds(10);
  const std::size_t top = run.bodies().size() - 1;
  const double right = run.model().bodies[top].position.y;
  const double off = std::abs(run.body(top).y - right), aside = sideways(run);
  if (aside > 0.5 || off > 0.5 * right) throw Failed("it fell");
  return {off, aside, rms_speed(run)};
}

/// Boxes of 1 m and 1 kg, one on the other, every other one `stagger` to the right.
Scene stack(int count, double stagger = 0) {
  Scene scene = open_scene(200);
  scene.bodies = {floor_box(kGrip)};
  for (int k = 0; k < count; ++k) {
    scene.bodies.push_back(box({k % 2 * stagger, k + 0.5}, {1, 1}, kGrip, 1));
  }
  return scene;
}

Case standing(const std::string& name, std::string shows, double height_limit, double sideways_limit) {
  Case c;
  c.name = name;
  c.shows = std::move(shows);
  c.quantities = {{name + "-height", "m", "analytic", {{4, height_limit}}},
                  {name + "-sideways", "m", "analytic", {{4, sideways_limit}}},
                  {name + "-speed", "m/s, rms", "analytic", {{4, 1e-3}}}};
  c.scale = Scale::large;
  c.timed_seconds = 1;
  c.measure = measure_standing;
  return c;
}

Case stack_case(int count, double limit) {
  const std::string n = std::to_string(count);
  Case c = standing("stack-" + n,
                    n + " boxes on top of one another: the top's height, the largest way "
                        "sideways and motion after 10 s",
                    limit, 1e-4);
  c.scene = [count] { return stack(count); };
  return c;
}

Case staggered() {
  Case c = standing("staggered-20",
                    "20 boxes, every other one 10 cm to the right: the top's height, the largest way "
                    "sideways and motion after 10 s",
                    0.01, 0.01);
  c.scene = [] { return stack(20, 0.1); };
  return c;
}

Case loaded(int ratio, double limit) {
  const std::string n = std::to_string(ratio);
  Case c = standing("loaded-" + n,
                    "five boxes under one that is " + n +
                        " times heavier: its height, the largest way sideways and motion after 10 s",
                    limit, 1e-3);
  c.scene = [ratio] {
    Scene scene = stack(5);
    scene.bodies.push_back(box({0, 5.5}, {1, 1}, kGrip, ratio));
    return scene;
  };
  return c;
}

Case two_legs() {
  Case c = standing("two-legs",
                    "1000 kg on two boxes of 1 kg: its height, the largest way sideways and "
                    "motion after 10 s",
                    0.02, 1e-3);
  c.scene = [] {
    Scene scene = open_scene(200);
    scene.bodies = {floor_box(kGrip), box({-1, 0.5}, {1, 1}, kGrip, 1), box({1, 0.5}, {1, 1}, kGrip, 1),
                    box({0, 1.5}, {3, 1}, kGrip, 1000)};
    return scene;
  };
  return c;
}

// ---- a pyramid --------------------------------------------------------------------------------

constexpr int kBase = 20;

Scene pyramid() {
  Scene scene = open_scene(200);
  scene.bodies = {floor_box(kGrip)};
  for (int row = 0; row < kBase; ++row) {
    for (int k = 0; k < kBase - row; ++k) {
      const double x = (k - 0.5 * (kBase - row - 1)) * 1.05;
      scene.bodies.push_back(box({x, row + 0.5}, {1, 1}, kGrip, 1));
    }
  }
  return scene;
}

Case pyramid_case() {
  Case c;
  c.name = "pyramid-20";
  c.shows = "20 rows of boxes, 5 cm apart: the largest way of any and motion after 10 s";
  c.quantities = {{"pyramid-20-way", "m", "analytic", {{4, 0.02}}},
                  {"pyramid-20-speed", "m/s, rms", "analytic", {{4, 1e-3}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = pyramid;
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(10);
    double most = 0;
    for (std::size_t k = 1; k < run.bodies().size(); ++k) most = std::max(most, way(run, k));
    if (most > 1) throw Failed("it fell");
    return {most, rms_speed(run)};
  };
  return c;
}

}  // namespace

std::vector<Case> stack_cases(Effort) {
  return {stack_case(20, 0.004), stack_case(100, 0.05), staggered(),        pyramid_case(),
          loaded(10, 0.001),     loaded(100, 0.005),    loaded(1000, 0.04), two_legs()};
}

}  // namespace psim::accuracy
