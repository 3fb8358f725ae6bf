// Bodies in water against closed forms: how deep they float, which way up they float, what water pushes them with, and how
// much water they take along. Bounds are those of the measured errors; where a target is smaller, the comment names it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/lattice.h"
#include "psim/scene.h"
#include "psim/world.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr double kWaterWeight = 1000 * kG;  // N/m^2 for each metre of depth

// A tank without sleep that is `level` deep before bodies come.
Scene float_tank(double wide, double level, double spacing) {
  Scene scene;
  scene.world = walled({0, 0, wide, level + 1.5});
  scene.world.sleeping = false;
  SceneFluid water;
  water.fluid = {spacing, 1000, 0};
  water.place = Bounds{0, 0, wide, level};
  scene.fluids.push_back(water);
  return scene;
}

std::unique_ptr<World> float_world(const Scene& scene) {
  std::string error;
  std::unique_ptr<World> world = build_world(scene, {}, error);
  if (!world) throw std::runtime_error(error);
  return world;
}

// The level of water that carries its weight, by the pressure of particles below `below`.
double level_by_pressure(const World& world, double below) {
  std::vector<FluidParticleState> particles;
  world.fluid_particles(particles);
  double sum = 0, count = 0;
  for (const FluidParticleState& p : particles) {
    if (p.position.y > below) continue;
    sum += p.position.y + p.pressure / kWaterWeight;
    ++count;
  }
  return sum / count;
}

struct Floating {
  double draft = 0;    // m: from the level to the lowest point of the body
  double missing = 0;  // m: by how much the level is too low
};

// Lets a body float that begins where it should, and takes the mean from 1.2 s to 6 s. `area` and `below` are the area of
// the body and how far its lowest point lies below its centre.
Floating floats(BodyDesc body, double share, double area, double below, double draft, double wide, double level) {
  constexpr double kSpacing = 0.02;
  Scene scene = float_tank(wide, level, kSpacing);
  body.material.density = 1000 * share;
  body.position = {wide / 2, level + share * area / wide - draft + below};
  scene.bodies.push_back(body);
  const auto world = float_world(scene);
  const double water = static_cast<double>(world->fluid_report().particles) * kSpacing * kSpacing;
  Floating mean;
  constexpr int kFirst = 72, kLast = 360, kEvery = 8;
  for (int frame = 1; frame <= kLast; ++frame) {
    world->step();
    if (frame <= kFirst || frame % kEvery != 0) continue;
    const double now = level_by_pressure(*world, level / 4);
    constexpr double kWeight = static_cast<double>(kEvery) / (kLast - kFirst);
    mean.draft += kWeight * (now - (state(*world, world->id_of(0)).y - below));
    mean.missing += kWeight * ((water + share * area) / wide - now);
  }
  return mean;
}

// The area of the part of the disc below the level is `share` of the disc. The target is 0.5 % of the draft.
TEST(FluidFloats, ADiscFloatsAsDeepAsItsDensitySays) {
  constexpr double kRadius = 0.4;
  for (const auto& [share, draft] :
       {std::pair{0.1, 0.312951}, {0.25, 0.596027}, {0.5, 1.0}, {0.75, 1.403973}, {0.9, 1.687049}}) {
    const Floating mean =
        floats(disc({}, {}, kRadius), share, kPi * kRadius * kRadius, kRadius, draft * kRadius, 1.6, 0.8);
    EXPECT_NEAR(mean.draft / (draft * kRadius), 1, 5e-3) << share;
    EXPECT_NEAR(mean.missing, 0, 2.5e-3) << share;
  }
}

// The target is 0.5 % of the draft. The level is up to 4 mm too low beside a box that takes half of the surface.
TEST(FluidFloats, ABoxFloatsAsDeepAsItsDensitySays) {
  constexpr double kWide = 1, kHigh = 0.5;
  for (const double share : {0.1, 0.5, 0.9}) {
    const double draft = share * kHigh;
    const Floating mean = floats(box({}, kWide, kHigh), share, kWide * kHigh, kHigh / 2, draft, 2, 0.8);
    EXPECT_NEAR(mean.draft / draft, 1, 5e-3) << share;
    EXPECT_NEAR(mean.missing, 0, 4.5e-3) << share;
  }
}

// A square of the relative density s is stable upright where s (1 - s) < 1/6, so outside 0.21132 to 0.78868. It rests at
// the tilt whose tangent is sqrt(12 s (1 - s) - 2), or at half a right angle from 0.28125 to 0.71875.
TEST(FluidFloats, ASquareFloatsUprightIfItIsLightOrHeavy) {
  constexpr double kSide = 0.6, kWide = 2, kLevel = 0.9, kDegrees = 180 / kPi;
  const auto mean_tilt = [](double share, double before) {
    Scene scene = float_tank(kWide, kLevel, 0.04);
    BodyDesc square =
        turned(box({kWide / 2, kLevel + share * kSide * kSide / kWide + kSide * (0.5 - share)}, kSide, kSide), before);
    square.material.density = 1000 * share;
    scene.bodies.push_back(square);
    const auto world = float_world(scene);
    run(*world, 240);
    double sum = 0;
    for (int frame = 0; frame < 300; ++frame) {
      world->step();
      sum += std::fabs(state(*world, world->id_of(0)).angle) / 300;
    }
    return sum * kDegrees;
  };
  for (const double share : {0.2, 0.8}) EXPECT_LT(mean_tilt(share, 0.05), 3) << share;
  for (const double share : {0.25, 0.75}) EXPECT_NEAR(mean_tilt(share, 0.46), 26.565, 2.5) << share;
  EXPECT_NEAR(mean_tilt(0.5, 0.05), 45, 0.5);
}

// Force on a disc that is held under water, by the weight of the water that it displaces: up, and to the side.
Vec2 lift_of_disc(Vec2 at, double radius, double level, double spacing) {
  Scene scene = float_tank(1.2, level, spacing);
  scene.bodies.push_back(fixed(disc(at, {}, radius)));
  const auto world = float_world(scene);
  run(*world, 30);
  Vec2 mean;
  for (int frame = 0; frame < 30; ++frame) {
    world->step();
    mean = mean + (1 / (30 * kWaterWeight * kPi * radius * radius)) * world->fluid_load(world->id_of(0))->force;
  }
  return mean;
}

// The target is 0.5 %. A face that is closed since next to nothing of it is open belongs to the body as a whole: otherwise the
// pressure on that part of it would be missing, and the error would grow with the depth.
TEST(FluidFloats, ADiscUnderWaterIsLiftedByItsArea) {
  double worst = 0, worst_deep = 0, aside = 0;
  for (const auto& [radius, at] :
       {std::pair{0.3, Vec2{0.6, 0.6}}, {0.2, Vec2{0.613, 0.617}}, {0.3, Vec2{0.613, 0.617}}}) {
    const Vec2 lift = lift_of_disc(at, radius, 1.2, 0.02), deep = lift_of_disc(at, radius, 4.2, 0.02);
    worst = std::max(worst, std::fabs(lift.y - 1));
    worst_deep = std::max(worst_deep, std::fabs(deep.y - 1));
    aside = std::max({aside, std::fabs(lift.x), std::fabs(deep.x)});
  }
  EXPECT_LT(worst, 2e-3);
  EXPECT_LT(worst_deep, 2e-3);
  EXPECT_LT(aside, 5e-4);
}

// A gate on a floor of its own holds water 1 m deep: rho g H^2 / 2 at a third of the height. In the corner the pressure on half
// a cell of the floor counts for the gate too, which pushes it up and moves the centre of pressure up by 1 %.
TEST(FluidFloats, AGateBearsTheWeightOfTheWater) {
  Scene scene = float_tank(2, 1.2, 0.02);
  scene.fluids[0].place = Bounds{0, 0.2, 1, 1.2};
  scene.bodies.push_back(fixed(box({1, 0.1}, 2, 0.2)));
  scene.bodies.push_back(fixed(box({1.1, 1.2}, 0.2, 2)));
  const auto world = float_world(scene);
  run(*world, 60);
  double push = 0, torque = 0;
  for (int frame = 0; frame < 60; ++frame) {
    world->step();
    const FluidLoad load = *world->fluid_load(world->id_of(1));
    push += load.force.x / 60;
    torque += load.torque / 60;
  }
  EXPECT_NEAR(push / (kWaterWeight / 2), 1, 1e-3);
  EXPECT_NEAR(1 - torque / push, 1.0 / 3, 0.012 / 3);  // the centre of the gate is 1 m above its floor
}

// A disc of twice the density in a full tank with the same centre and twice its radius carries 5/3 of the displaced water
// along: it falls by g (2 - 1) / (2 + 5/3). The target is 2 %.
TEST(FluidFloats, ADiscInARoundTankTakesWaterAlong) {
  constexpr double kRadius = 0.5, kTank = 1;
  constexpr int kBoards = 96;
  const Vec2 middle{2.5, 2.5};
  for (const auto& [spacing, bound] : {std::pair{0.05, 0.015}, {0.025, 0.007}}) {
    Scene scene = float_tank(5, 3.5, spacing);
    // The boards touch a polygon of the area of the tank.
    const double tangent = std::tan(kPi / kBoards), inner = kTank * std::sqrt(kPi / (kBoards * tangent)), thick = 0.6;
    for (int k = 0; k < kBoards; ++k) {
      const double angle = 2 * kPi * k / kBoards, out = inner + thick / 2;
      const Vec2 at = middle + Vec2{out * std::cos(angle), out * std::sin(angle)};
      scene.bodies.push_back(fixed(turned(box(at, thick, 2 * (inner + thick) * tangent + 0.02), angle)));
    }
    scene.bodies.push_back(disc(middle, {}, kRadius));
    scene.bodies.back().material.density = 2000;
    FluidList ring;
    const int n = static_cast<int>(std::lround(4 * kRadius / spacing));
    for (int k = 0; k < n * n; ++k) {
      const double x = (k % n + 0.5) * spacing - kTank, y = (k / n + 0.5) * spacing - kTank, r = x * x + y * y;
      if (r < kRadius * kRadius || r > kTank * kTank) continue;
      ring.x.push_back(middle.x + x);
      ring.y.push_back(middle.y + y);
      ring.vx.push_back(0);
      ring.vy.push_back(0);
    }
    scene.fluids[0].place = ring;
    const auto world = float_world(scene);
    run(*world, 6);
    const double fall = -state(*world, world->id_of(kBoards)).vy / (kG * 0.1);
    EXPECT_NEAR(fall / (3.0 / 11), 1, bound) << spacing;
  }
}

}  // namespace
}  // namespace psim::test
