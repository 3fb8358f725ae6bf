// What contacts carry: the weight of stacks, pyramids, heavy bodies on light ones, discs in a silo. Means of a second, as
// the engine reports them.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "cases/case.h"

namespace psim::accuracy {
namespace {

const Material kGrip = material(0, 0.6);

using Pair = std::pair<std::size_t, std::size_t>;

/// Mean force of every pair that touched, N.
std::map<Pair, double> mean_loads(Run& run) {
  std::map<Pair, double> sums;
  for (int frame = 0; frame < kFrameRate; ++frame) {
    run.frame();
    for (const Load& load : run.simulation().loads()) sums[{load.a, load.b}] += load.force / kFrameRate;
  }
  if (sums.empty()) throw Failed("nothing touches");
  return sums;
}

/// Of all pairs with body 0, the ground.
double ground_load(const std::map<Pair, double>& loads) {
  double sum = 0;
  for (const auto& [pair, force] : loads) sum += pair.first == 0 ? force : 0;
  return sum;
}

double weight(const Model& model) {
  double sum = 0;
  for (const BodyDesc& body : model.bodies) sum += body.type == BodyType::dynamic_body ? kGravity * mass_of(body) : 0;
  return sum;
}

// ---- stacks -----------------------------------------------------------------------------------

Scene stack(int count) {
  Scene scene = open_scene(200);
  scene.bodies = {floor_box(kGrip)};
  for (int k = 0; k < count; ++k) scene.bodies.push_back(box({0, k + 0.5}, {1, 1}, kGrip, 1));
  return scene;
}

Case stack_load(int count, Effort effort) {
  const double settle = effort == Effort::quick ? 4 : 9;
  const std::string n = std::to_string(count);
  Case c;
  c.name = "stack-load-" + n;
  c.shows = n + " boxes on top of one another: load of each contact after 10 s, by what lies on it";
  c.quantities = {{"stack-load-" + n, "relative", "analytic", {{4, 1e-6}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [count] { return stack(count); };
  c.measure = [count, settle](Run& run) -> std::vector<double> {
    run.seconds(settle);
    const std::map<Pair, double> loads = mean_loads(run);
    double off = 0;
    for (int k = 0; k < count; ++k) {
      const auto below = static_cast<std::size_t>(k);
      const auto found = loads.find({below, below + 1});
      if (found == loads.end()) throw Failed("it fell");
      off = std::max(off, std::abs(found->second / ((count - k) * kGravity) - 1));
    }
    return {off};
  };
  return c;
}

Case pyramid_load(Effort effort) {
  const double settle = effort == Effort::quick ? 2 : 9;
  constexpr int kBase = 20;
  Case c;
  c.name = "pyramid-load";
  c.shows = "20 rows of boxes: load of the ground after 10 s, by the weight of all";
  c.quantities = {{"pyramid-load", "relative", "analytic", {{4, 1.2e-5}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [] {
    Scene scene = open_scene(200);
    scene.bodies = {floor_box(kGrip)};
    for (int row = 0; row < kBase; ++row) {
      for (int k = 0; k < kBase - row; ++k) {
        scene.bodies.push_back(box({(k - 0.5 * (kBase - row - 1)) * 1.05, row + 0.5}, {1, 1}, kGrip, 1));
      }
    }
    return scene;
  };
  c.measure = [settle](Run& run) -> std::vector<double> {
    run.seconds(settle);
    return {std::abs(ground_load(mean_loads(run)) / weight(run.model()) - 1)};
  };
  return c;
}

// ---- heavy on light ---------------------------------------------------------------------------

Case legs(int ratio, double overlap) {
  const std::string n = std::to_string(ratio), name = "legs-" + n;
  Case c;
  c.name = name;
  c.shows =
      n + " kg on two boxes of 1 kg: their shares after 10 s, overlap, and how far they jump when it is taken away";
  c.quantities = {{name + "-share", "relative", "analytic", {{4, 1e-5}}},
                  {name + "-overlap", "of a box", "analytic", {{4, overlap}, {8, overlap / 4}}},
                  {name + "-jump", "m", "analytic", {{4, 1e-4}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [ratio] {
    Scene scene = open_scene(200);
    scene.bodies = {floor_box(kGrip), box({-1, 0.5}, {1, 1}, kGrip, 1), box({1, 0.5}, {1, 1}, kGrip, 1),
                    box({0, 1.5}, {3, 1}, kGrip, ratio)};
    return scene;
  };
  c.measure = [ratio](Run& run) -> std::vector<double> {
    run.seconds(9);
    const std::map<Pair, double> loads = mean_loads(run);
    double off = 0;
    for (const Pair& pair : {Pair{1, 3}, Pair{2, 3}}) {
      const auto found = loads.find(pair);
      if (found == loads.end()) throw Failed("a leg carries nothing");
      off = std::max(off, std::abs(found->second / (0.5 * ratio * kGravity) - 1));
    }
    const double sunk = 1.5 - run.body(3).y;
    const double rest = std::max(run.body(1).y, run.body(2).y);
    run.simulation().set_velocity(3, {0, 20}, 0);
    double jump = 0;
    for (int frame = 0; frame < kFrameRate; ++frame) {
      run.frame();
      jump = std::max(jump, std::max(run.body(1).y, run.body(2).y) - std::max(rest, 0.5));
    }
    return {off, std::abs(sunk), jump};
  };
  return c;
}

// ---- a silo -----------------------------------------------------------------------------------

/// Discs still slide past each other for seconds, so quick runs settle for as long as full ones.
Case silo() {
  constexpr double kSettle = 29;  // s
  Case c;
  c.name = "silo";
  c.shows =
      "200 smooth discs of two sizes in a silo 6 m wide: load of the floor in a second after 29 s, by the weight "
      "of all and the momentum that they gain; contacts that carry, by two a disc";
  c.quantities = {{"silo-load", "relative", "analytic", {{4, 1e-5}}},
                  {"silo-contacts", "relative", "isostatic", {{4, 0.12}}}};
  c.scale = Scale::large;
  c.timed_seconds = 0.5;
  c.scene = [] {
    Scene scene = open_scene(100);
    scene.bodies = {segment({-3, 0}, {3, 0}, material(0)), segment({-3, 0}, {-3, 80}, material(0)),
                    segment({3, 0}, {3, 80}, material(0))};
    for (int k = 0; k < 200; ++k) {
      const double radius = k % 2 == 0 ? 0.25 : 0.35, row = k / 8;
      const double aside = 0.02 * std::sin(7.0 * k);
      scene.bodies.push_back(disc({-2.6 + 0.74 * (k % 8) + aside, 0.4 + 0.72 * row}, {0, 0}, material(0), radius));
    }
    return scene;
  };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(kSettle);
    const double before = momentum(run).y;
    const std::map<Pair, double> loads = mean_loads(run);
    const double gained = momentum(run).y - before;  // discs may still slide past each other
    std::map<std::size_t, int> carried;              // by disc: how many contacts hold it
    double count = 0;
    for (const auto& [pair, force] : loads) {
      if (force < 0.02 * kGravity * mass_of(run.model().bodies[pair.second])) continue;
      ++count;
      ++carried[pair.second];
      if (pair.first > 2) ++carried[pair.first];
    }
    return {std::abs((ground_load(loads) - gained) / weight(run.model()) - 1),
            std::abs(count / (2 * static_cast<double>(carried.size())) - 1)};
  };
  return c;
}

}  // namespace

std::vector<Case> weight_cases(Effort effort) {
  return {silo(),
          stack_load(10, effort),
          stack_load(20, effort),
          stack_load(100, effort),
          pyramid_load(effort),
          legs(1000, 0.0084),
          legs(10000, 0.05)};
}

}  // namespace psim::accuracy
