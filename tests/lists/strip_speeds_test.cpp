// How fast bodies move against those around them, strip by strip.
#include "lists/impact_speeds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/machine.h"
#include "support.h"

namespace psim::test {
namespace {

// Six strips of 100 bodies.
class StripSpeedsTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kStrips = 6, kEach = 100;

  StripSpeedsTest() {
    bodies.reserve_slots(kStrips * kEach + 8);
    for (std::uint32_t s = 0; s < kStrips; ++s) {
      Strip strip;
      strip.body_begin = bodies.count;
      for (std::uint32_t k = 0; k < kEach; ++k) {
        bodies.id[bodies.count] = bodies.count;
        push(bodies.count++, 3, -20);
      }
      strip.body_end = bodies.count;
      strips.push_back(strip);
    }
    strips.emplace_back();
    strips.back().body_begin = strips.back().body_end = bodies.count;
  }

  void push(std::uint32_t at, float vx, float vy) {
    bodies.vel[2 * std::size_t{at}] = vx;
    bodies.vel[2 * std::size_t{at} + 1] = vy;
  }
  std::vector<double> measure(bool periodic = false) {
    lattice = Lattice({-500, -500, 500, 500}, periodic);
    speeds.measure(strips);
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
  for (const double speed : measure()) EXPECT_NEAR(speed, 0, 1e-6);
  EXPECT_TRUE(std::isinf(speeds.at(kStrips)));  // of the large bodies' group nothing is known
}

TEST_F(StripSpeedsTest, BytesAreThoseOfTheStrips) {
  EXPECT_EQ(speeds.bytes(), 0u);
  measure();
  EXPECT_GE(speeds.bytes(), 40u * kStrips);
  EXPECT_LE(speeds.bytes(), 60u * (kStrips + 1));
}

TEST_F(StripSpeedsTest, NeighboursCountAndOthersDoNot) {
  for (std::uint32_t k = 0; k < kEach; ++k) push(2 * kEach + k, 3, 0);  // strip 2 stands still
  const std::vector<double> found = measure();
  const double third = 20 * std::sqrt(2.0) / 3;  // r.m.s. of one third that is 20 m/s apart
  EXPECT_NEAR(found[0], 0, 1e-6);
  EXPECT_NEAR(found[1], third, 1e-3);
  EXPECT_NEAR(found[2], third, 1e-3);
  EXPECT_NEAR(found[3], third, 1e-3);
  EXPECT_NEAR(found[4], 0, 1e-6);
}

TEST_F(StripSpeedsTest, InAPeriodicWorldTheLastStripMeetsTheFirst) {
  for (std::uint32_t k = 0; k < kEach; ++k) push(k, 3, 0);
  EXPECT_NEAR(measure()[kStrips - 1], 0, 1e-6);
  EXPECT_GT(measure(true)[kStrips - 1], 9);
}

}  // namespace
}  // namespace psim::test
