// fluids[] of scene files: which particles they make, how they are written again, and what is wrong with some.
#include <psim/scene.h>

#include <cmath>

#include "support.h"

namespace psim::test {
namespace {

std::string fluid_scene(const std::string& fluids, const std::string& boundary = "walls") {
  return R"({"psim": 1, "world": {"bounds": [-4, -4, 4, 4], "boundary": ")" + boundary + R"("}, "fluids": [)" + fluids +
         "]}";
}

Scene read_fluids(const std::string& text) {
  std::string error;
  const auto scene = parse_scene(text, "f", error);
  if (!scene) throw std::runtime_error(error);
  return *scene;
}

std::vector<FluidParticleState> particles_of(const Scene& scene) {
  std::string error;
  const auto world = build_world(scene, {}, error);
  if (!world) throw std::runtime_error(error);
  std::vector<FluidParticleState> all;
  world->fluid_particles(all);
  return all;
}

std::string fluid_refusal(const std::string& fluids) {
  std::string error;
  parse_scene(fluid_scene(fluids), "f", error);
  EXPECT_EQ(error.find('\n'), error.npos) << error;
  return error;
}

TEST(SceneFluids, ARegionIsFilledFromHalfASpacing) {
  const auto all =
      particles_of(read_fluids(fluid_scene(R"({"region": [0, 1, 1, 1.5], "spacing": 0.25, "density": 900})")));
  ASSERT_EQ(all.size(), 8u);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_NEAR(all[k].position.x, 0.125 + 0.25 * static_cast<double>(k % 4), 1e-6);
    EXPECT_NEAR(all[k].position.y, 1.125 + 0.25 * static_cast<double>(k / 4), 1e-6);
    EXPECT_EQ(all[k].velocity, (Vec2{}));
  }
  // Columns are rounded: 1 / 0.3 to 3, 1 / 0.28 to 4, whose last one still is in the world.
  EXPECT_EQ(particles_of(read_fluids(fluid_scene(R"({"region": [3, 3, 4, 4], "spacing": 0.3})"))).size(), 9u);
  EXPECT_EQ(particles_of(read_fluids(fluid_scene(R"({"region": [3, 3, 4, 4], "spacing": 0.28})"))).size(), 16u);
}

TEST(SceneFluids, ADiscAndAPolygonHoldWhatLiesInThem) {
  const auto drop =
      particles_of(read_fluids(fluid_scene(R"({"disc": {"position": [1, 1], "radius": 1}, "spacing": 0.02})")));
  EXPECT_NEAR(static_cast<double>(drop.size()), kPi / 0.0004, 0.005 * kPi / 0.0004);
  for (const auto& p : drop) EXPECT_LE(std::hypot(p.position.x - 1, p.position.y - 1), 1 + 1e-5);
  // An area that is not convex: an L of 3 m^2, and its line goes round either way.
  for (const char* vertices :
       {"[0,0], [2,0], [2,1], [1,1], [1,2], [0,2]", "[0,2], [1,2], [1,1], [2,1], [2,0], [0,0]"}) {
    const auto corner = particles_of(
        read_fluids(fluid_scene(R"({"polygon": {"vertices": [)" + std::string(vertices) + R"(]}, "spacing": 0.1})")));
    EXPECT_EQ(corner.size(), 300u);
    for (const auto& p : corner) EXPECT_FALSE(p.position.x > 1 && p.position.y > 1);
  }
}

TEST(SceneFluids, ListsAndVelocitiesAreTaken) {
  const auto all = particles_of(read_fluids(fluid_scene(
      R"({"layout": "explicit", "x": [0, 1], "y": [2, 3], "vx": [1, 2], "vy": [3, 4], "spacing": 0.1},
         {"layout": "explicit", "x": [2], "y": [2], "vy": [5], "spacing": 0.1},
         {"region": [-1, -1, -0.9, -0.9], "spacing": 0.1, "velocity": [6, 7]})",
      "periodic")));
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[1].velocity, (Vec2{2, 4}));
  EXPECT_EQ(all[2].velocity, (Vec2{0, 5}));
  EXPECT_EQ(all[3].velocity, (Vec2{6, 7}));
  EXPECT_EQ(all[3].fluid, 2u);
}

TEST(SceneFluids, AreWrittenAsTheyWereRead) {
  const Scene scene = read_fluids(fluid_scene(
      R"({"region": [0, 1, 1, 1.5], "spacing": 0.25, "density": 900, "viscosity": 0.01, "velocity": [0.1, -2]},
         {"disc": {"position": [1, -1], "radius": 0.7}, "spacing": 0.1},
         {"polygon": {"vertices": [[0, 0], [-2, 0], [-1, 1.3]]}, "spacing": 0.2},
         {"layout": "explicit", "x": [0.1], "y": [0.2], "vx": [0.3], "vy": [0.4], "spacing": 0.1},
         {"layout": "explicit", "x": [], "y": [], "spacing": 0.1, "velocity": [1, 0]})"));
  const std::string text = scene_to_json(scene);
  const Scene again = read_fluids(text);
  EXPECT_EQ(scene_to_json(again), text);
  ASSERT_EQ(again.fluids.size(), 5u);
  EXPECT_EQ(again.fluids[0].fluid.viscosity, 0.01);
  const auto a = particles_of(scene), b = particles_of(again);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].position, b[k].position);
    EXPECT_EQ(a[k].velocity, b[k].velocity);
  }
}

TEST(SceneFluids, WhatIsWrongIsNamed) {
  const auto expect = [](const std::string& fluid, const std::string& what) {
    const std::string error = fluid_refusal(fluid);
    EXPECT_NE(error.find(what), error.npos) << error << "\nis not: " << what;
  };
  const std::string region = R"("region": [0, 0, 1, 1])";
  for (const char* wrong : {"0", "-0.1", "1e-4", "1e9"}) {
    expect("{" + region + R"(, "spacing": )" + wrong + "}", "fluids[0].spacing");
  }
  expect("{" + region + "}", "\"spacing\" is missing");
  expect("{" + region + R"(, "spacing": 0.1, "density": 0})", "fluids[0].density");
  expect("{" + region + R"(, "spacing": 0.1, "viscosity": -1})", "fluids[0].viscosity");
  expect("{" + region + R"(, "spacing": 0.1, "velocity": [1e7, 0]})", "fluids[0].velocity");
  expect("{" + region + R"(, "spacing": 0.1, "colour": 1})", "unknown key");
  expect("{" + region + R"(, "disc": {"position": [0, 0], "radius": 1}, "spacing": 0.1})", "stands beside \"region\"");
  expect(R"({"spacing": 0.1})", R"("region", "disc", "polygon" or "layout" is missing)");
  expect(R"({"region": [0, 0, 5, 1], "spacing": 0.1})", "reaches out of the world");
  expect(R"({"disc": {"position": [3.5, 0], "radius": 1}, "spacing": 0.1})", "reaches out of the world");
  expect(R"({"polygon": {"vertices": [[0, 0], [5, 0], [0, 1]]}, "spacing": 0.1})", "is outside the world");
  expect(R"({"region": [0, 0, 1, 0.1], "spacing": 0.5})", "has no room for a particle");
  expect(R"({"layout": "explicit", "x": [0, 1], "y": [0], "spacing": 0.1})", "one for each particle");
  expect(R"({"layout": "explicit", "x": [9], "y": [0], "spacing": 0.1})", "9 is outside the world");
  expect(R"({"layout": "hex", "x": [0], "y": [0], "spacing": 0.1})", "\"hex\" is not known");
  expect("{" + region + R"(, "spacing": 0.1}, {)" + region + R"(, "spacing": 0.2})", "that of the first fluid");
}

TEST(SceneFluids, TooManyParticlesAreRefusedBeforeThereAreAny) {
  const auto expect = [](const std::string& fluids) {
    const std::string error = fluid_refusal(fluids);
    EXPECT_NE(error.find("more than 10000000 particles in all"), error.npos) << error;
  };
  expect(R"({"region": [-4, -4, 4, 4], "spacing": 0.001})");
  expect(R"({"disc": {"position": [0, 0], "radius": 4}, "spacing": 0.001})");
  expect(R"({"polygon": {"vertices": [[-4, -4], [4, -4], [4, 4], [-4, 4]]}, "spacing": 0.001})");
  expect(R"({"region": [-4, -4, 4, -2], "spacing": 0.0015}, {"region": [-4, 0, 4, 2], "spacing": 0.0015})");
  Scene scene;
  scene.world.bounds = {-1e8, -1e8, 1e8, 1e8};
  scene.world.boundary = Boundary::open;
  scene.fluids.push_back({{1, 1000, 0}, FluidDisc{{0, 0}, 1e8}, {}});
  std::string error;
  EXPECT_EQ(build_world(scene, {}, error), nullptr);
  EXPECT_EQ(error, "fluids[0]: more than 10000000 particles: a larger spacing or a smaller region");
}

}  // namespace
}  // namespace psim::test
