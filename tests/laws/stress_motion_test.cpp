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

TEST(StressSpeed, AThinWallHoldsManyInelasticDiscsOfAnySpeed) {
  for (const double speed : {1e2, 1e3, 3e3, 1e4, 1e5}) {
    EXPECT_EQ(discs_through_a_wall(speed, 0), 0) << speed;
  }
}

TEST(StressSpeed, BulletsShotAtEachOtherMeet) {
  for (const double speed : {1e2, 1e3, 1e4, 1e5}) {
    for (const double restitution : {0.0, 1.0}) {
      EXPECT_EQ(bullets_through_each_other(speed, restitution), 0) << speed << " e " << restitution;
    }
  }
}

TEST(StressSpeed, InelasticPairsGainNoEnergy) {
  for (const double reach : {0.1, 0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 4.0, 8.0, 16.0}) {
    EXPECT_LE(energy_of_inelastic_pair(reach), 1) << reach;
  }
}

TEST(StressSpeed, InelasticPairsThatMissEachOtherGoOnStraight) {
  for (const double reach : {0.1, 1.0, 4.0, 16.0, 100.0}) {
    for (const double distance : {1.05, 1.5, 5.0}) {
      EXPECT_LT(deflection_at_a_miss(reach, distance), 1e-6) << reach << " " << distance;
    }
  }
}

// ---- far away, denormals ----------------------------------------------------------------------

TEST(StressFar, AWorldAboutADistantPointHasTheSameBits) {
  for (const double x : {1e4, -1e6, 1e8}) EXPECT_EQ(difference_at(x), 0) << x;
}

TEST(SlowStressDenormals, DoNotSlowAStepDown) { EXPECT_LT(denormal_slowdown(), 5); }

// ---- long runs --------------------------------------------------------------------------------

TEST(StressLong, InvariantsOverAHundredThousandSteps) {
  EXPECT_LT(kepler_energy(25'000).largest, 2.4e-5);
  EXPECT_LT(bounce_energy(25'000).largest, 1.2e-4);
  EXPECT_LT(gas_energy(25'000).largest, 1e-4);
  EXPECT_LT(stack_place(0.5, 25'000).largest, 7e-9);
}

TEST(SlowStressLong, AnOrbitKeepsItsEnergyForAMillionSteps) {
  const Drift drift = kepler_energy(250'000);
  EXPECT_LT(drift.largest, 2.8e-5);
  EXPECT_LT(std::abs(drift.change), 4e-6);
}

TEST(SlowStressLong, ElasticImpactsKeepTheirEnergyForAMillionSteps) {
  EXPECT_LT(bounce_energy(250'000).largest, 1.1e-3);
  EXPECT_LT(gas_energy(250'000).largest, 1e-3);
}

TEST(SlowStressLong, AColumnDoesNotCreepInAMillionSteps) {
  for (const double friction : {0.0, 0.5}) {
    const Drift drift = stack_place(friction, 250'000);
    EXPECT_LT(drift.largest, 8e-9) << friction;
    EXPECT_LT(std::abs(drift.change), 1e-10) << friction;
  }
}

// ---- smooth ground, time reversed -------------------------------------------------------------

TEST(StressJoints, AThousandAreNeitherFeltNorCostSpeed) {
  for (const double speed : {5.0, 20.0, 50.0}) {
    for (const double friction : {0.0, 0.5}) {
      const Glide way = glide(speed, friction);
      EXPECT_LT(way.bump, 1.4e-5) << speed << " mu " << friction;
      EXPECT_LT(std::abs(way.speed_lost), 1e-6) << speed << " mu " << friction;
    }
  }
}

TEST(StressReversal, AnOrbitReturnsAfterTenRounds) {
  EXPECT_LT(orbit_return(377), 3e-5);
  EXPECT_LT(orbit_return(3770), 5e-4);
}

TEST(StressReversal, ABouncingDiscReturns) {
  EXPECT_LT(bounce_return(600), 9e-6);
  EXPECT_LT(bounce_return(6000), 7e-5);
}

TEST(StressReversal, AGasReturnsUntilChaosTakesOver) {
  EXPECT_LT(gas_return(60), 6e-6);
  EXPECT_LT(gas_return(120), 1e-4);
}

}  // namespace
}  // namespace psim::accuracy::stress
