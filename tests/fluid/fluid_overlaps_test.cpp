// Areas of fluids that overlap bodies.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"

namespace psim {
namespace {

Scene tank(const std::string& rest) {
  std::string error;
  const std::string text = R"({"psim": 1, "name": "tank", "step": {"sleeping": false},
    "world": {"bounds": [0, 0, 4, 3], "boundary": "walls", "gravity": [0, -9.81]}, )" +
                           rest + "}";
  const std::optional<Scene> scene = parse_scene(text, "tank", error);
  EXPECT_TRUE(scene.has_value()) << error;
  return scene.value_or(Scene());
}

std::vector<FluidParticleState> particles_of(const World& world) {
  std::vector<FluidParticleState> seen;
  world.fluid_particles(seen);
  return seen;
}
std::vector<Vec2> places_of(const World& world) {
  std::vector<Vec2> places;
  for (const FluidParticleState& p : particles_of(world)) places.push_back(p.position);
  return places;
}

std::unique_ptr<World> build(const Scene& scene) {
  std::string error;
  std::unique_ptr<World> world = build_world(scene, {}, error);
  EXPECT_NE(world, nullptr) << error;
  return world;
}

const char* const kHalfSunken = R"("fluids": [{"region": [0, 0, 4, 1], "spacing": 0.04}],
  "bodies": [{"type": "dynamic", "shape": {"box": {"size": [1, 0.6]}}, "position": [2, 1], "density": 500}])";

TEST(FluidOverlaps, WaterLiesAboveWhatTakesItsPlace) {
  const std::unique_ptr<World> world = build(tank(kHalfSunken));
  const std::vector<Vec2> places = places_of(*world);
  EXPECT_EQ(places.size(), 2500u);
  std::size_t above = 0;
  double sum = 0;
  for (const Vec2& p : places) {
    EXPECT_FALSE(std::fabs(p.x - 2) < 0.5 && std::fabs(p.y - 1) < 0.3) << p.x << ", " << p.y;
    above += p.y > 1 ? 1 : 0;
    sum += p.y > 1 ? p.x : 0;
    EXPECT_LT(p.y, 1.12);
  }
  EXPECT_EQ(above, 208u);  // 26 columns of 8
  EXPECT_NEAR(sum / 208, 2, 0.02);
}

// So a box comes to float where its weight says, and water that it displaces throws it nowhere.
TEST(FluidOverlaps, ABoxFloatsWhereItsWeightSays) {
  const std::unique_ptr<World> world = build(tank(kHalfSunken));
  const BodyId box = world->id_of(0);
  double mean = 0;
  for (int frame = 0; frame < 600; ++frame) {
    world->step(1.0 / 60);
    mean += world->body(box)->y / 600;
  }
  EXPECT_NEAR(mean, 1.075, 0.005);
  EXPECT_NEAR(world->body(box)->x, 2, 0.05);
}

TEST(FluidOverlaps, UpIsAgainstGravity) {
  for (const Vec2 gravity : {Vec2{0, 9.81}, Vec2{9.81, 0}, Vec2{-9.81, 1}}) {
    Scene scene = tank(R"("fluids": [{"region": [1, 1, 3, 2], "spacing": 0.05}],
      "bodies": [{"type": "static", "shape": {"disc": {"radius": 0.3}}, "position": [2, 1.5]}])");
    scene.world.gravity = gravity;
    const std::unique_ptr<World> world = build(scene);
    const std::vector<Vec2> places = places_of(*world);
    EXPECT_EQ(places.size(), 800u);
    for (const Vec2& p : places) {
      EXPECT_TRUE(p.y >= 1 || gravity.y > 5) << p.x << ", " << p.y;
      EXPECT_TRUE(p.y <= 2);
      EXPECT_TRUE(p.x <= 3 || gravity.x < 0);
      EXPECT_TRUE(p.x >= 1 || gravity.x > 5);
      EXPECT_GT(std::hypot(p.x - 2, p.y - 1.5), 0.3);
    }
  }
}

TEST(FluidOverlaps, RowsPassOverOtherFluidsAndBodies) {
  const std::unique_ptr<World> world = build(tank(R"("fluids": [
      {"region": [0, 0, 4, 1], "spacing": 0.05, "density": 1000}, {"region": [0, 1, 4, 1.5], "spacing": 0.05, "density": 800}],
    "bodies": [{"type": "static", "shape": {"box": {"size": [0.4, 2]}}, "position": [2, 1.5]}])"));
  const std::vector<FluidParticleState> seen = particles_of(*world);
  EXPECT_EQ(seen.size(), 2400u);
  for (const FluidParticleState& p : seen) {
    EXPECT_FALSE(std::fabs(p.position.x - 2) < 0.2 && p.position.y > 0.5);
    EXPECT_EQ(p.fluid == 0 ? p.position.y < 1 || p.position.y > 1.5 : p.position.y > 1, true) << p.position.y;
  }
}

// What has no room anywhere stays, and the step presses it out. A list is what its places say.
TEST(FluidOverlaps, NothingIsLost) {
  const std::unique_ptr<World> full = build(tank(R"("fluids": [{"region": [0, 0, 4, 3], "spacing": 0.1}],
    "bodies": [{"type": "static", "shape": {"disc": {"radius": 0.5}}, "position": [2, 1.5]}])"));
  EXPECT_EQ(places_of(*full).size(), 1200u);
  full->step(1.0 / 60);
  EXPECT_EQ(places_of(*full).size(), 1200u);
  const std::unique_ptr<World> list =
      build(tank(R"("fluids": [{"layout": "explicit", "x": [2], "y": [1.5], "spacing": 0.1}],
    "bodies": [{"type": "static", "shape": {"disc": {"radius": 0.5}}, "position": [2, 1.5]}])"));
  EXPECT_NEAR(places_of(*list)[0].y, 1.5, 1e-6);
}

// Shapes that fluids do not meet take no place.
TEST(FluidOverlaps, SensorsAndWhatMeetsNothingTakeNoPlace) {
  const std::unique_ptr<World> world = build(tank(R"("fluids": [{"region": [0, 0, 4, 1], "spacing": 0.1}],
    "bodies": [{"type": "static", "sensor": true, "shape": {"disc": {"radius": 0.5}}, "position": [2, 0.5]},
               {"type": "static", "mask": 0, "shape": {"disc": {"radius": 0.3}}, "position": [3, 0.5]}])"));
  for (const Vec2& p : places_of(*world)) EXPECT_LT(p.y, 1);
}

}  // namespace
}  // namespace psim
