// How fast bodies move against those around them, strip by strip.
#include "lists/strip_speeds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/machine.h"
#include "support.h"

namespace psim::test {
namespace {

// Six strips of 100 bodies, one above the other, a million lattice steps of 1 um each.
class StripSpeedsTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kStrips = 6, kEach = 100;
  static constexpr std::int32_t kHeight = 1'000'000;

  StripSpeedsTest() {
    bodies.reserve_slots(kStrips * kEach + 8);
    bodies.info.reserve(kStrips * kEach + 8);
    for (std::uint32_t s = 0; s < kStrips; ++s) {
      Strip strip;
      strip.body_begin = bodies.count;
      for (std::uint32_t k = 0; k < kEach; ++k) {
        add(static_cast<std::int32_t>(s) * kHeight + kHeight / 4, 0.001f, 1, 3, -20);
      }
      strip.body_end = bodies.count;
      strips.push_back(strip);
    }
    strips.emplace_back();
    strips.back().body_begin = strips.back().body_end = bodies.count;
  }

  void add(std::int32_t y, float radius, float mass, float vx, float vy) {
    BodyProperties surface;
    surface.mass = mass;
    surface.inv_mass = mass > 0 ? 1 / mass : 0;
    const std::uint32_t id = bodies.take_id(), at = bodies.count++;
    bodies.info[id].properties = bodies.property_table.acquire(surface);
    bodies.id[at] = id;
    bodies.pos[2 * at] = 0;
    bodies.pos[2 * at + 1] = y;
    bodies.radius[at] = radius;
    push(at, vx, vy);
  }
  void push(std::uint32_t at, float vx, float vy) {
    bodies.vel[2 * std::size_t{at}] = vx;
    bodies.vel[2 * std::size_t{at} + 1] = vy;
  }
  void add_large(std::int32_t y, float radius, float vx, float vy) {
    add(y, radius, 1000, vx, vy);
    strips.back().body_end = bodies.count;
  }
  std::vector<double> measure(bool uneven, bool periodic = false) {
    const double half = periodic ? 2147.483648 : 500;  // 1 um a step, or a little less
    lattice = Lattice({-half, -half, half, half}, periodic);
    speeds.measure(strips, uneven, 0.02);
    std::vector<double> out;
    for (std::uint32_t s = 0; s < kStrips; ++s) out.push_back(speeds.at(s));
    return out;
  }

  MemoryMeter memory;
  WorkerPool pool{1};
  KinematicBodies kinematics;
  MixingRules mixing;
  Material wall;
  BodyStore bodies{memory};
  Lattice lattice;
  StaticShapes shapes{memory, lattice};
  const kernels::KernelTable kernels = kernels_of(best_isa());
  std::vector<Strip> strips;
  StripSpeeds speeds{{memory, lattice, bodies, shapes, kernels, pool, kinematics, mixing, wall}};
};

TEST_F(StripSpeedsTest, ACommonFallIsNoSpeed) {
  for (const bool uneven : {false, true}) {
    for (const double speed : measure(uneven)) EXPECT_NEAR(speed, 0, 1e-6);
  }
  EXPECT_TRUE(std::isinf(speeds.at(kStrips)));  // of the large bodies' group nothing is known
}

TEST_F(StripSpeedsTest, BytesAreThoseOfTheStrips) {
  EXPECT_EQ(speeds.bytes(), 0u);
  measure(false);
  EXPECT_GE(speeds.bytes(), 100u * kStrips);
  EXPECT_LE(speeds.bytes(), 200u * (kStrips + 1));
}

TEST_F(StripSpeedsTest, NeighboursCountAndOthersDoNot) {
  for (std::uint32_t k = 0; k < kEach; ++k) push(2 * kEach + k, 3, 0);  // strip 2 stands still
  const std::vector<double> found = measure(false);
  const double third = 20 * std::sqrt(2.0) / 3;  // r.m.s. of one third that is 20 m/s apart
  EXPECT_NEAR(found[0], 0, 1e-6);
  EXPECT_NEAR(found[1], third, 1e-3);
  EXPECT_NEAR(found[2], third, 1e-3);
  EXPECT_NEAR(found[3], third, 1e-3);
  EXPECT_NEAR(found[4], 0, 1e-6);
}

TEST_F(StripSpeedsTest, InAPeriodicWorldTheLastStripMeetsTheFirst) {
  for (std::uint32_t k = 0; k < kEach; ++k) push(k, 3, 0);
  EXPECT_NEAR(measure(false, false)[kStrips - 1], 0, 1e-6);
  EXPECT_GT(measure(false, true)[kStrips - 1], 9);
}

TEST_F(StripSpeedsTest, OneHeavyBodyAmongLightOnesCountsByMass) {
  push(2 * kEach, 3, 10);
  bodies.property_table.release(bodies.info[bodies.id[2 * kEach]].properties);
  BodyProperties heavy;
  heavy.mass = 100'000;
  heavy.inv_mass = 1e-5f;
  bodies.info[bodies.id[2 * kEach]].properties = bodies.property_table.acquire(heavy);
  EXPECT_LT(measure(false)[2], 30 / std::sqrt(kEach));
  EXPECT_NEAR(measure(true)[2], 30, 0.3);  // it goes on, and so do the others past it
}

TEST_F(StripSpeedsTest, ALargeBodyCountsWhereItMayTouch) {
  add_large(3 * kHeight + kHeight / 4, 0.1f, 3, -50);  // 30 m/s against the others; 0.1 m and 1 m to come
  std::vector<double> found = measure(true);
  for (const std::uint32_t s : {1u, 2u, 3u, 4u, 5u}) EXPECT_NEAR(found[s], 30, 1e-3) << s;
  EXPECT_NEAR(found[0], 0, 1e-6);
  found = measure(false);  // all alike: there are no heavy ones
  EXPECT_NEAR(found[3], 0, 1e-6);
}

TEST_F(StripSpeedsTest, ALargeBodyReachesRoundAPeriodicWorld) {
  for (std::uint32_t i = 0; i < bodies.count; ++i) {  // the strips fill the world's 2^32 steps
    bodies.pos[2 * std::size_t{i} + 1] = static_cast<std::int32_t>(-2'000'000'000 + 800'000'000ll * (i / kEach));
  }
  add_large(2'100'000'000, 150, 3, -20);
  push(bodies.count - 1, 3, 10);
  EXPECT_NEAR(measure(true, true)[0], 30, 1e-3);
  EXPECT_NEAR(measure(true, false)[0], 0, 1e-6);
}

}  // namespace
}  // namespace psim::test
