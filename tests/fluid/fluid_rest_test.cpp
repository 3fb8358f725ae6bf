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
  return parsed_scene(R"({"psim": 1, "world": {"bounds": [0, 0, 4, 3], "boundary": "walls", "gravity": [0, -9.81]},
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
    EXPECT_LT(world->fluid_report().density_error_max, 0.05) << seed;
  }
}

}  // namespace
}  // namespace psim
