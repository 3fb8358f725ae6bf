// Water comes to rest, whatever stands in it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"
#include "scene_text.h"

namespace psim {
namespace {

using test::parsed_scene;

// Static boxes, discs and triangles that stand at any angle in a tank, partly in its floor and walls.
Scene random_basin(unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  std::string bodies;
  const int count = 1 + static_cast<int>(random() % 3);
  for (int k = 0; k < count; ++k) {
    const double size = between(0.1, 0.5);
    std::string shape;
    switch (random() % 3) {
      case 0:
        shape = R"({"disc": {"radius": )" + std::to_string(0.8 * size) + "}}";
        break;
      case 1:
        shape = R"({"box": {"size": [)" + std::to_string(3 * size) + ", " + std::to_string(size) + "]}}";
        break;
      default:
        shape = R"({"polygon": {"vertices": [[0, 0], [)" + std::to_string(2 * size) + ", 0], [0, " +
                std::to_string(size) + "]]}}";
    }
    bodies += (k == 0 ? "" : ", ") + (R"({"type": "static", "shape": )" + shape) + R"(, "position": [)" +
              std::to_string(between(0.2, 3.8)) + ", " + std::to_string(between(0, 0.9)) + R"(], "angle": )" +
              std::to_string(between(0, 6.28)) + "}";
  }
  return parsed_scene(
      R"({"psim": 1, "step": {"sleeping": false}, "world": {"bounds": [0, 0, 4, 3], "boundary": "walls", "gravity": [0, -9.81]},
    "fluids": [{"region": [0, 0, 4, 1], "spacing": 0.04}], "bodies": [)" +
      bodies + "]}");
}

// Speeds by sqrt(g spacing); most are 0.003 to 0.03. A film that is thinner than a cell, over a disc, flows for ever: 0.12. When
// cells between a shape and a wall counted as empty they drew water in: 0.5 to 0.9.
TEST(FluidRest, WaterBesideShapesComesToRest) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::string error;
    const Scene scene = random_basin(seed);
    const std::unique_ptr<World> world = build_world(scene, {}, error);
    ASSERT_NE(world, nullptr) << error;
    for (int frame = 0; frame < 300; ++frame) world->step(1.0 / 60);
    std::vector<FluidParticleState> particles;
    world->fluid_particles(particles);
    ASSERT_EQ(particles.size(), 2500u);
    double sum = 0;
    for (const FluidParticleState& p : particles) sum += p.velocity.x * p.velocity.x + p.velocity.y * p.velocity.y;
    EXPECT_LT(std::sqrt(sum / 2500 / (9.81 * 0.04)), 0.15) << seed << scene_to_json(scene);
    EXPECT_LT(world->fluid_report().density_error_max, 0.1) << seed;
  }
}

// A thin wall holds water wherever it stands: also if its side is where the middles of cells are, at 2.01 m, so that rounding
// says on which side of it they lie. There it let pressure through, and cells became 40 times too dense.
TEST(FluidRest, ThinWallsHoldWater) {
  for (const double thickness : {0.004, 0.02, 0.03, 0.04}) {
    for (const double left : {1.995, 2.0, 2.01, 2.02, 2.04}) {
      const Scene scene = parsed_scene(
          R"({"psim": 1, "step": {"sleeping": false}, "world": {"bounds": [0, 0, 4, 3], "gravity": [0, -9.81]},
        "fluids": [{"region": [0, 0, 1.98, 1.5], "spacing": 0.03}], "bodies": [{"type": "static",
        "shape": {"box": {"size": [)" +
          std::to_string(thickness) + R"(, 3]}}, "position": [)" + std::to_string(left + thickness / 2) + ", 1.5]}]}");
      std::string error;
      const std::unique_ptr<World> world = build_world(scene, {}, error);
      ASSERT_NE(world, nullptr) << error;
      for (int frame = 0; frame < 60; ++frame) world->step(1.0 / 60);
      EXPECT_LT(world->fluid_report().density_error_mean, 2e-3) << thickness << " at " << left;
      std::vector<FluidParticleState> particles;
      world->fluid_particles(particles);
      for (const FluidParticleState& p : particles) EXPECT_LT(p.position.x, left + 0.001);
    }
  }
}

// So does a vessel of thin walls, also at its corners, wherever they lie among cells.
TEST(FluidRest, ThinVesselsHoldWater) {
  for (const double x : {0.0, 0.01, 0.02, 0.03, 0.013}) {
    for (const double y : {0.0, 0.01, 0.03, 0.017}) {
      const std::string at = "[" + std::to_string(x) + ", " + std::to_string(y) + "]";
      const Scene scene = parsed_scene(
          R"({"psim": 1, "step": {"sleeping": false}, "world": {"bounds": [-3, -3, 3, 3], "gravity": [0, -9.81]},
        "fluids": [{"spacing": 0.03, "region": [)" +
          std::to_string(x - 0.45) + ", " + std::to_string(y - 0.45) + ", " + std::to_string(x + 0.45) + ", " +
          std::to_string(y + 0.06) + R"(]}],
        "bodies": [{"type": "static", "position": )" +
          at + R"(, "shapes": [{"box": {"size": [0.06, 1]}, "position": [-0.5, 0]},
          {"box": {"size": [0.06, 1]}, "position": [0.5, 0]}, {"box": {"size": [1, 0.06]}, "position": [0, -0.5]}]}]})");
      std::string error;
      const std::unique_ptr<World> world = build_world(scene, {}, error);
      ASSERT_NE(world, nullptr) << error;
      for (int frame = 0; frame < 90; ++frame) world->step(1.0 / 60);
      EXPECT_LT(world->fluid_report().density_error_mean, 2e-3) << at;
      EXPECT_LT(world->fluid_report().density_error_max, 0.05) << at;
    }
  }
}

// In a tank without a surface nothing tells the mean of the pressure. A body that is as heavy as the water that it displaces
// was thrown about by it, at 20 m/s and more; 3 % too much water, as here, stirs it a little.
TEST(FluidRest, ABodyInAFullTankStaysThere) {
  for (const std::string boundary : {"walls", "periodic"}) {
    const Scene scene =
        parsed_scene(R"({"psim": 1, "step": {"sleeping": false}, "world": {"bounds": [0, 0, 4, 4], "gravity": [0, )" +
                     std::string(boundary == "walls" ? "-9.81" : "0") + R"(], "boundary": ")" + boundary +
                     R"("}, "fluids": [{"region": [0, 0, 4, 4], "spacing": 0.05}],
      "bodies": [{"type": "dynamic", "position": [2, 2], "shape": {"disc": {"radius": 0.4}}, "density": 1000}]})");
    std::string error;
    const std::unique_ptr<World> world = build_world(scene, {}, error);
    ASSERT_NE(world, nullptr) << error;
    for (int frame = 0; frame < 180; ++frame) {
      world->step(1.0 / 60);
      const BodyState body = *world->body(world->id_of(0));
      ASSERT_LT(std::hypot(body.vx, body.vy), 0.3) << boundary << " " << frame;
    }
  }
}

// Spray shoots up along a leaning wall into the corner at the ceiling, where it turns back. What is mirrored at the ceiling
// stays on its side of the wall.
TEST(FluidRest, NobodyComesBackBehindALeaningWall) {
  constexpr double kLean = 0.3;
  std::string x, y, vx, vy;
  for (int k = 0; k < 200; ++k) {
    const double along = 0.5 + 0.005 * k, beside = -0.02 - 0.015 * (k % 7);
    const char* const comma = k == 0 ? "" : ", ";
    x += comma + std::to_string(2 + along * std::sin(kLean) + beside * std::cos(kLean));
    y += comma + std::to_string(along * std::cos(kLean) - beside * std::sin(kLean));
    vx += comma + std::to_string(14 * std::sin(kLean) + 0.3);
    vy += comma + std::to_string(14 * std::cos(kLean));
  }
  const Scene scene =
      parsed_scene(R"({"psim": 1, "step": {"sleeping": false}, "world": {"bounds": [0, 0, 5, 3], "gravity": [0, -9.81]},
    "fluids": [{"layout": "explicit", "spacing": 0.03, "x": [)" +
                   x + R"(], "y": [)" + y + R"(], "vx": [)" + vx + R"(], "vy": [)" + vy +
                   R"(]}], "bodies": [{"type": "static", "position": [2, 0],
    "angle": -0.3, "shape": {"box": {"size": [0.02, 9]}}}]})");
  std::string error;
  const std::unique_ptr<World> world = build_world(scene, {}, error);
  ASSERT_NE(world, nullptr) << error;
  for (int frame = 0; frame < 60; ++frame) {
    world->step(1.0 / 60);
    std::vector<FluidParticleState> particles;
    world->fluid_particles(particles);
    for (const FluidParticleState& p : particles) {
      ASSERT_LT((p.position.x - 2) * std::cos(kLean) - p.position.y * std::sin(kLean), 0.001) << frame;
    }
  }
}

}  // namespace
}  // namespace psim
