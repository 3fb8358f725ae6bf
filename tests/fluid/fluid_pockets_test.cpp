// Water that bodies shut in within a few cells, whose equations have no solution, and particles beside plates that are thinner
// than a cell.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

std::vector<FluidParticleState> all_particles(const World& world) {
  std::vector<FluidParticleState> seen;
  world.fluid_particles(seen);
  return seen;
}

std::unique_ptr<World> pool_with(std::vector<BodyDesc> bodies, const std::vector<Vec2>& more) {
  Scene scene;
  scene.world = walled({0, 0, 4, 3});
  scene.world.sleeping = false;
  scene.bodies = std::move(bodies);
  SceneFluid pool;
  pool.fluid = {0.1, 1000, 0};
  pool.place = Bounds{0, 0, 2, 0.8};
  scene.fluids.push_back(pool);
  std::string error;
  std::unique_ptr<World> world = build_world(scene, {}, error);
  EXPECT_NE(world, nullptr) << error;
  EXPECT_TRUE(world->add_particles(0, more, {}, error)) << error;
  return world;
}

// Beside a pool with a surface there is a box with a hole of two cells, in which there is too much water. No displacement makes
// room there, and the pool is not to be displaced by what is asked for in the hole.
TEST(FluidPockets, TooMuchWaterShutInHarmsNoOther) {
  for (const double at : {0.0, 0.03, 0.07, 0.1, 0.15}) {
    const double x = 3 + at, y = 0.2;  // the lower left corner of the hole of 0.4 m x 0.2 m
    std::vector<Vec2> shut_in;
    for (int k = 0; k < 15; ++k) shut_in.push_back({x + 0.04 + 0.08 * (k % 5), y + 0.04 + 0.06 * (k / 5)});
    const auto world = pool_with({fixed(box({x - 0.2, y + 0.2}, 0.4, 0.8)), fixed(box({x + 0.6, y + 0.2}, 0.4, 0.8)),
                                  fixed(box({x + 0.2, y - 0.2}, 0.4, 0.4)), fixed(box({x + 0.2, y + 0.4}, 0.4, 0.4)),
                                  fixed(box({2.3, 1}, 0.6, 2))},
                                 shut_in);
    for (int frame = 0; frame < 240; ++frame) world->step();
    double fastest = 0, highest = 0;
    std::size_t pool = 0;
    for (const FluidParticleState& p : all_particles(*world)) {
      ASSERT_TRUE(std::isfinite(p.position.x + p.position.y + p.velocity.x + p.velocity.y));
      if (p.position.x > 2) continue;
      ++pool;
      highest = std::max(highest, p.position.y);
      fastest = std::max(fastest, std::hypot(p.velocity.x, p.velocity.y));
    }
    EXPECT_EQ(pool, 160u) << at;
    EXPECT_LT(highest, 0.8) << at;
    EXPECT_LT(fastest, 0.02) << at;
  }
}

// A particle half a spacing from a line lies within what counts as the line, and stays on its side whatever it hits.
TEST(FluidPockets, ParticlesStayOnTheirSideOfLines) {
  for (const double angle : {0.0, 0.4, kPi / 4, kPi / 2}) {
    for (const double side : {1.0, -1.0}) {
      const Vec2 along{std::cos(angle), std::sin(angle)}, out{-side * along.y, side * along.x};
      BodyDesc line;
      line.type = BodyType::static_body;
      line.position = {3, 1.5};
      line.shape = SegmentShape{{-0.8 * along.x, -0.8 * along.y}, {0.8 * along.x, 0.8 * along.y}};
      const auto world = pool_with({line}, {});
      std::vector<Vec2> places, speeds;
      for (int k = 0; k < 20; ++k) {
        const double s = -0.4 + 0.04 * k, off = 0.02 + 0.004 * k;
        places.push_back({3 + s * along.x + off * out.x, 1.5 + s * along.y + off * out.y});
        speeds.push_back({-10 * out.x, -10 * out.y});
      }
      std::string error;
      ASSERT_TRUE(world->add_particles(0, places, speeds, error)) << error;
      for (int frame = 0; frame < 3; ++frame) world->step();
      for (const FluidParticleState& p : all_particles(*world)) {
        if (p.id < 160) continue;
        EXPECT_GT((p.position.x - 3) * out.x + (p.position.y - 1.5) * out.y, 0) << angle << " " << side << " " << p.id;
      }
    }
  }
}

}  // namespace
}  // namespace psim::test
