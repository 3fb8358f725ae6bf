// Driving motion hard: fast discs at thin walls and at each other, far places, denormals, a million
// steps, a thousand joints, time reversed. The bounds are about twice what is measured today
// (docs/stress.md); better is welcome, worse is a loss.
#include <gtest/gtest.h>

#include <cmath>

#include "stress.h"

namespace psim::accuracy::stress {
namespace {

// ---- speed ------------------------------------------------------------------------------------

TEST(StressSpeed, AThinWallHoldsALoneDiscOfAnySpeed) {
  for (const double speed : {1e2, 1e3, 1e4, 1e5}) {
    for (const double angle : {0.0, 0.8, 1.5}) {
      for (const double restitution : {0.0, 0.5, 1.0}) {
        EXPECT_EQ(lone_discs_through_a_wall(speed, angle, restitution), 0)
            << speed << " m/s, angle " << angle << ", e " << restitution;
      }
    }
  }
}

TEST(StressSpeed, AThinWallHoldsManyElasticDiscsOfAnySpeed) {
  for (const double speed : {1e2, 1e3, 1e4, 1e5}) {
    EXPECT_EQ(discs_through_a_wall(speed, 1), 0) << speed;
  }
}

// Discs without restitution are stopped by a line, not by a disc, when they cross it within a substep: those
// that would pass each other closely throw each other aside, some through the wall.
TEST(StressSpeed, AThinWallHoldsInelasticDiscsToThreeHundredMetresASecond) {
  EXPECT_EQ(discs_through_a_wall(100, 0), 0);
  EXPECT_EQ(discs_through_a_wall(300, 0), 0);
  EXPECT_LT(discs_through_a_wall(1000, 0), 8);
  EXPECT_LT(discs_through_a_wall(3000, 0), 60);
}

TEST(StressSpeed, BulletsShotAtEachOtherMeet) {
  for (const double speed : {1e2, 1e3, 1e4, 1e5}) {
    for (const double restitution : {0.0, 1.0}) {
      EXPECT_EQ(bullets_through_each_other(speed, restitution), 0) << speed << " e " << restitution;
    }
  }
}

TEST(StressSpeed, InelasticPairsGainNoEnergyBelowADiameterASubstep) {
  for (const double reach : {0.1, 0.3, 0.5, 0.8, 1.0}) {
    EXPECT_LE(energy_of_inelastic_pair(reach), 1) << reach;
  }
  EXPECT_GT(first_gaining_reach(), 1.2);
}

TEST(StressSpeed, FasterInelasticPairsGainABoundedEnergy) {
  EXPECT_LT(energy_of_inelastic_pair(4), 11);
  EXPECT_LT(energy_of_inelastic_pair(16), 20);
}

// ---- far away, denormals ----------------------------------------------------------------------

TEST(StressFar, AWorldAboutADistantPointHasTheSameBits) {
  for (const double x : {1e4, -1e6, 1e8}) EXPECT_EQ(difference_at(x), 0) << x;
}

TEST(SlowStressDenormals, SlowAStepDownByABoundedFactor) { EXPECT_LT(denormal_slowdown(), 50); }

// ---- long runs --------------------------------------------------------------------------------

TEST(StressLong, InvariantsOverAHundredThousandSteps) {
  EXPECT_LT(kepler_energy(4, 100'000).largest, 4e-5);
  EXPECT_LT(bounce_energy(25'000).largest, 6e-5);
  EXPECT_LT(gas_energy(25'000).largest, 1.5e-4);
  EXPECT_LT(stack_place(0.5, 25'000).largest, 1e-8);
}

TEST(SlowStressLong, AnOrbitKeepsItsEnergyForAMillionSteps) {
  const Drift drift = kepler_energy(4, 1'000'000);
  EXPECT_LT(drift.largest, 5e-5);
  EXPECT_LT(std::abs(drift.change), 1.5e-5);
}

TEST(SlowStressLong, ElasticImpactsKeepTheirEnergyForAMillionSteps) {
  EXPECT_LT(bounce_energy(250'000).largest, 5e-4);
  EXPECT_LT(gas_energy(250'000).largest, 1.5e-3);
}

TEST(SlowStressLong, AColumnDoesNotCreepInAMillionSteps) {
  for (const double friction : {0.0, 0.5}) {
    const Drift drift = stack_place(friction, 250'000);
    EXPECT_LT(drift.largest, 1e-8) << friction;
    EXPECT_LT(std::abs(drift.change), 2e-10) << friction;
  }
}

// ---- smooth ground, time reversed -------------------------------------------------------------

TEST(StressJoints, AThousandAreNeitherFeltNorCostSpeed) {
  for (const double speed : {5.0, 20.0, 50.0}) {
    for (const double friction : {0.0, 0.5}) {
      const Glide way = glide(speed, friction);
      EXPECT_LT(way.bump, 2.5e-5) << speed << " mu " << friction;
      EXPECT_LT(std::abs(way.speed_lost), 1e-6) << speed << " mu " << friction;
    }
  }
}

TEST(StressReversal, AnOrbitReturnsAfterTenRounds) {
  EXPECT_LT(orbit_return(4, 377), 3e-4);
  EXPECT_LT(orbit_return(4, 3770), 1e-2);
}

TEST(StressReversal, ABouncingDiscReturns) {
  EXPECT_LT(bounce_return(600), 4e-6);
  EXPECT_LT(bounce_return(6000), 4e-5);
}

TEST(StressReversal, AGasReturnsUntilChaosTakesOver) {
  EXPECT_LT(gas_return(60), 1e-5);
  EXPECT_LT(gas_return(120), 3e-4);
}

}  // namespace
}  // namespace psim::accuracy::stress
