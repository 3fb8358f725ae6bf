// Lasting load: a column's weight, heavy on light, a pile that comes to rest. Overlap always with
// what is left of motion: either alone can be bought with the other.
#include <algorithm>
#include <cmath>
#include <string>

#include "cases/case.h"

namespace psim::accuracy {
namespace {

constexpr double kRadius = 0.5, kDiameter = 1;

// ---- a column ---------------------------------------------------------------------------------

constexpr int kColumn = 10;

Scene column() {
  Scene scene = open_scene(100);
  scene.bodies = {disc({0, 0}, {0, 0}, material(0))};
  scene.bodies[0].type = BodyType::static_body;
  for (int k = 1; k <= kColumn; ++k) scene.bodies.push_back(disc({0, 1.0 * k}, {0, 0}, material(0)));
  return scene;
}

// Contact k carries the weight of all above it; the virial is the sum of impulse x distance.
std::vector<double> measure_column(Run& run) {
  run.seconds(9);
  run.simulation().watch_impulses();
  const double before = run.simulation().virial();
  run.seconds(1);
  double expected = 0;
  for (std::size_t k = 1; k <= kColumn; ++k) {
    const double above = static_cast<double>(kColumn + 1 - k) * mass_of(run.model().bodies[k]);
    expected += above * kGravity * (run.body(k).y - run.body(k - 1).y);
  }
  return {std::abs((run.simulation().virial() - before) / expected - 1), deepest(run) / kDiameter, rms_speed(run)};
}

Case column_case() {
  Case c;
  c.name = "column";
  c.shows = "ten discs on top of one another: load of the contacts, overlap, motion after 10 s";
  c.quantities = {{"column-load", "relative", "analytic", {{4, 0.01}}},
                  {"column-penetration", "of a diameter", "analytic", {{4, 0.02}}},
                  {"column-speed", "m/s", "analytic", {{4, 1e-3}}}};
  c.scene = column;
  c.measure = measure_column;
  return c;
}

// ---- heavy on light ---------------------------------------------------------------------------

Scene heavy_on_light(double ratio) {
  Scene scene = open_scene(100);
  BodyDesc light = disc({0, 0.5}, {0, 0}, material(0));
  light.mass = 1;
  light.fixed_rotation = true;
  BodyDesc heavy = light;
  heavy.position.y = 1.5;
  heavy.mass = ratio;
  scene.bodies = {ground(material(0)), light, heavy};
  return scene;
}

Case heavy(int ratio, double limit) {
  const std::string name = "heavy-" + std::to_string(ratio);
  Case c;
  c.name = name;
  c.shows = "a disc on one that is " + std::to_string(ratio) + " times lighter: overlap and motion after 10 s";
  c.quantities = {{name + "-penetration", "of a radius", "analytic", {{4, limit}}},
                  {name + "-speed", "m/s", "analytic", {{4, 1e-3}}}};
  c.scene = [ratio] { return heavy_on_light(ratio); };
  c.measure = [](Run& run) -> std::vector<double> {
    run.seconds(10);
    const BodyState &light = run.body(1), &heavy = run.body(2);
    if (std::abs(heavy.x - light.x) > 0.1) throw Failed("the heavy one fell off");
    if (light.y < 0 || heavy.y < light.y) throw Failed("pushed through");
    return {deepest(run) / kRadius, rms_speed(run)};
  };
  return c;
}

// ---- a pile -----------------------------------------------------------------------------------

Scene pile(int count) {
  const double columns = std::ceil(std::sqrt(static_cast<double>(count)));
  const double width = columns * 1.02 + 1;
  Scene scene = walled_scene(width, 4 * width, material(0), {0, -kGravity});
  GroupDesc group;
  group.count = static_cast<std::uint64_t>(count);
  group.region = {0.5, 0.5, width - 0.5, 0.5 + columns * 1.02};
  group.jitter = 0.5;
  group.body.material = material(0);
  scene.groups = {group};
  return scene;
}

std::vector<double> measure_pile(Run& run) {
  const double start = energy(run);
  double gained = 0;
  for (int k = 0; k < 240; ++k) {  // some piles slip once more after ten seconds
    run.frames(5);
    gained = std::max(gained, energy(run) / start - 1);
  }
  return {quantile(penetrations(run), 0.99) / kDiameter, rms_speed(run), gained};
}

Case pile_case() {
  Case c;
  c.name = "pile";
  c.shows = "1000 discs dropped 2 cm apart: overlap and motion after 20 s, energy gained on the way";
  // Which pile it becomes is chance: any change of order makes another one.
  c.quantities = {{"pile-penetration", "of a diameter, p99", "analytic", {{4, 0.02}, {8, 0.008}}},
                  {"pile-speed", "m/s, rms", "analytic", {{4, 5e-3}, {8, 5e-3}}},
                  {"pile-energy-gain", "relative", "analytic", {{4, 1e-3}}}};
  c.scale = Scale::large;
  c.scene = [] { return pile(1000); };
  c.measure = measure_pile;
  return c;
}

}  // namespace

std::vector<Case> rest_cases(Effort) {
  return {column_case(), heavy(10, 0.04), heavy(100, 0.04), heavy(1000, 0.4), pile_case()};
}

}  // namespace psim::accuracy
