// Elastic gases disc by disc: energy with overlap, short trajectories against the event-driven
// solution, return under reversed velocities. What only holds on average is in cases_fluid.cpp.
#include <algorithm>
#include <array>
#include <cmath>

#include "cases/case.h"
#include "cases/gas_scenes.h"
#include "event_driven.h"

namespace psim::accuracy {
namespace {

constexpr double kDiameter = 1;

// ---- energy -----------------------------------------------------------------------------------

Case gas_energy() {
  Case c;
  c.name = "gas";
  c.shows = "1000 elastic discs in a box of 60 m, 20 s";
  c.quantities = {{"gas-energy", "relative", "analytic", {{4, 1e-4}}},
                  {"gas-penetration", "of a diameter", "analytic", {{4, 0.2}}}};
  c.scale = Scale::large;
  c.scene = [] { return gas_in_walls(1000, 60, 10, 3); };
  c.measure = [](Run& run) -> std::vector<double> {
    const double start = kinetic_energy(run);
    double depth = 0, off = 0;
    for (int k = 0; k < 120; ++k) {
      run.frames(10);
      depth = std::max(depth, deepest(run));
      off = std::max(off, std::abs(kinetic_energy(run) / start - 1));
    }
    return {off, depth / kDiameter};
  };
  return c;
}

// ---- trajectories -----------------------------------------------------------------------------

constexpr int kBoxes = 20;
constexpr int kDiscsABox = 25;
constexpr double kBoxSide = 10;
constexpr double kBoxPitch = 12;
constexpr double kTrajectoryTime = 0.5;  // chaos takes over after a few collisions a disc
constexpr double kAstray = 1e-3;         // m: more than rounding, grown a thousandfold

// Boxes side by side, of four segments and 25 discs each: a wrong collision in one leaves the rest.
Scene boxes() {
  Scene scene = open_scene(300, {0, 0});
  for (int box = 0; box < kBoxes; ++box) {
    const double x = kBoxPitch * box, far = x + kBoxSide;
    const std::array<Vec2, 4> corners = {{{x, 0}, {far, 0}, {far, kBoxSide}, {x, kBoxSide}}};
    for (std::size_t k = 0; k < 4; ++k) {
      scene.bodies.push_back(segment(corners[k], corners[(k + 1) % 4], material(1)));
    }
    GroupDesc group = lattice(kDiscsABox, kBoxSide, 0.5, 8, static_cast<std::uint64_t>(box + 1));
    group.region.xmin += x;
    group.region.xmax += x;
    scene.groups.push_back(group);
  }
  return scene;
}

/// Where the discs of one box are after the time, if all its collisions are exact.
std::vector<reference::Disc> exact_box(const std::vector<BodyState>& start, std::size_t first, double x) {
  std::vector<reference::Disc> discs;
  for (std::size_t k = first; k < first + kDiscsABox; ++k) {
    discs.push_back({{start[k].x - x, start[k].y}, {start[k].vx, start[k].vy}, start[k].radius, 1, 0});
  }
  reference::EventDriven exact({kBoxSide, kBoxSide, false, 0}, 1, discs);
  exact.advance(kTrajectoryTime);
  return exact.discs();
}

std::vector<double> measure_trajectories(Run& run) {
  const std::vector<BodyState> start = run.bodies();
  run.seconds(kTrajectoryTime);
  std::vector<double> off;
  for (int box = 0; box < kBoxes; ++box) {
    const std::size_t first = 4 * kBoxes + static_cast<std::size_t>(box * kDiscsABox);
    const auto exact = exact_box(start, first, kBoxPitch * box);
    for (std::size_t k = 0; k < exact.size(); ++k) {
      const BodyState& s = run.body(first + k);
      off.push_back(std::hypot(s.x - kBoxPitch * box - exact[k].x.x, s.y - exact[k].x.y));
    }
  }
  std::ranges::sort(off);
  const auto astray = std::ranges::count_if(off, [](double d) { return d > kAstray; });
  return {quantile(off, 0.5), static_cast<double>(astray) / static_cast<double>(off.size())};
}

Case trajectories() {
  Case c;
  c.name = "gas-trajectory";
  c.shows = "20 boxes of 10 m with 25 elastic discs each, 0.5 s: distance from the exact places";
  c.quantities = {{"gas-trajectory-median", "m", "event-driven", {{4, 1e-4}}},
                  {"gas-trajectory-astray", "share of discs off by 1 mm", "event-driven", {{4, 0.1}}}};
  c.scale = Scale::large;
  c.timed_seconds = kTrajectoryTime;
  c.scene = boxes;
  c.measure = measure_trajectories;
  return c;
}

Case reversal() {
  Case c;
  c.name = "reversal";
  c.shows = "100 elastic discs run 0.5 s, are turned round and run back";
  c.quantities = {{"reversal", "m", "analytic", {{4, 1e-3}}}};
  c.timed_seconds = 1;
  c.scene = [] { return gas_in_walls(100, side_of(100, 0.1), 10, 3); };
  c.measure = [](Run& run) -> std::vector<double> {
    const std::vector<BodyState> start = run.bodies();
    run.seconds(0.5);
    const std::vector<BodyState> there = run.bodies();
    for (std::size_t k = 0; k < there.size(); ++k) {
      run.simulation().set_velocity(k, {-there[k].vx, -there[k].vy}, -there[k].omega);
    }
    run.seconds(0.5);
    double worst = 0;
    for (std::size_t k = 0; k < start.size(); ++k) {
      worst = std::max(worst, std::hypot(run.body(k).x - start[k].x, run.body(k).y - start[k].y));
    }
    return {worst};
  };
  return c;
}

}  // namespace

std::vector<Case> gas_cases(Effort) { return {gas_energy(), trajectories(), reversal()}; }

}  // namespace psim::accuracy
