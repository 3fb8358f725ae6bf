// Links that bend: rows and rings of beams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "psim/scene.h"
#include "psim/world.h"
#include "scene_text.h"

namespace psim {
namespace {

using test::parsed_scene;

constexpr double kRadius = 0.05, kDensity = 10;
const double kMass = kDensity * std::numbers::pi * kRadius * kRadius;

std::unique_ptr<World> built(const std::string& gravity, const std::string& group) {
  const Scene scene = parsed_scene(R"({"psim": 1, "name": "beams", "step": {"substeps": 4, "sleeping": false},
    "world": {"bounds": [-9, -9, 9, 9], "boundary": "open", "gravity": )" +
                                   gravity + R"(}, "groups": [{"radius": 0.05, "density": 10, )" + group + "}]}");
  std::string error;
  std::unique_ptr<World> world = build_world(scene, {}, error);
  EXPECT_NE(world, nullptr) << error;
  return world;
}

BodyState state(const World& world, std::uint32_t k) { return *world.body(world.id_of(k)); }

// Each beam bends in its middle by the moment of what lies beyond, whether the row lies, stands upright or is turned.
TEST(Beams, ARowSagsByItsWeight) {
  constexpr int kBeams = 10;
  constexpr double kWay = 0.1;
  for (const double bending : {300.0, 1e4, 1e7}) {
    const std::unique_ptr<World> world =
        built("[0, -9.81]", R"("layout": "lattice", "count": 11, "region": [0, 0, 1.1, 0.1], "linear_damping": 3,
          "links": {"pin": "left", "bending": )" +
                                std::to_string(bending) + "}");
    double sag = 0;
    for (int beam = 0; beam < kBeams; ++beam) {
      const double at = (beam + 0.5) * kWay;
      double moment = 0;
      for (int body = beam + 1; body <= kBeams; ++body) moment += kMass * 9.81 * (body * kWay - at);
      sag += moment / bending * (kBeams * kWay - at);
    }
    for (int frame = 0; frame < 600; ++frame) world->step(1.0 / 60);
    EXPECT_NEAR(kRadius - state(*world, 10).y, sag, 5e-3 * sag + 1e-7) << bending;
  }
}

// A row that stands on its fixed end (here it is the upper one, and gravity points up) buckles under its own weight w where
// w L^3 is above 7.837 EI (Greenhill 1881): with beams of 11.4 N m/rad.
TEST(Beams, AColumnBucklesUnderItsOwnWeight) {
  const auto aside = [](const std::string& bending) {
    const std::unique_ptr<World> world =
        built("[0.02, 9.81]", R"("layout": "lattice", "count": 11, "region": [0, 0, 0.1, 1.1], "linear_damping": 1,
          "links": {"pin": "top", "bending": )" +
                                  bending + "}");
    for (int frame = 0; frame < 1800; ++frame) world->step(1.0 / 60);
    return std::fabs(state(*world, 0).x - kRadius);
  };
  EXPECT_LT(aside("15"), 0.03);
  EXPECT_GT(aside("9"), 0.5);
}

// Under pressure a ring of beams rests as one of rods does, at any stiffness.
TEST(Beams, ARingUnderPressureRests) {
  for (const std::string bending : {"0.1", "1", "3", "10", "1000"}) {
    const std::unique_ptr<World> world = built("[0, 0]", R"("layout": "ring", "count": 40, "region": [-1, -1, 1, 1],
          "links": {"pressure": 50, "bending": )" + bending + "}");
    for (int frame = 0; frame < 1200; ++frame) world->step(1.0 / 60);
    for (std::uint32_t k = 0; k < 40; ++k) {
      const BodyState s = state(*world, k);
      EXPECT_NEAR(std::hypot(s.x, s.y), 1, 1e-3) << bending;
      EXPECT_LT(std::hypot(s.vx, s.vy), 1e-5) << bending;
    }
  }
}

// A tyre lies on the floor the rounder the stiffer it is, and keeps its energy's bound.
TEST(Beams, ATyreIsTheRounderTheStiffer) {
  double last = 0;
  for (const std::string bending : {"3", "30", "300"}) {
    const Scene scene = parsed_scene(R"({"psim": 1, "name": "tyre", "step": {"substeps": 4},
      "world": {"bounds": [0, 0, 10, 10], "boundary": "walls", "gravity": [0, -9.81]},
      "groups": [{"layout": "ring", "count": 40, "region": [4, 0.1, 6, 2.1], "radius": 0.05, "density": 10,
                  "linear_damping": 1, "links": {"bending": )" +
                                     bending + "}}]}");
    std::string error;
    const std::unique_ptr<World> world = build_world(scene, {}, error);
    ASSERT_NE(world, nullptr) << error;
    for (int frame = 0; frame < 600; ++frame) world->step(1.0 / 60);
    double high = 0;
    for (std::uint32_t k = 0; k < 40; ++k) high = std::max(high, state(*world, k).y);
    EXPECT_GT(high, last + 0.1) << bending;
    last = high;
  }
  EXPECT_GT(last, 1.8);
}

TEST(Beams, ANetOfThemIsRefused) {
  Scene scene = parsed_scene(R"({"psim": 1, "world": {"bounds": [0, 0, 9, 9]},
    "groups": [{"layout": "lattice", "count": 9, "region": [1, 1, 8, 8], "radius": 0.1, "links": {}}]})");
  scene.groups[0].links->bending = 1;
  std::string error;
  EXPECT_EQ(build_world(scene, {}, error), nullptr);
  EXPECT_EQ(error, "groups[0].links: bending is for a ring, or a single row or column");
}

}  // namespace
}  // namespace psim
