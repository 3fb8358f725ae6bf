// The event-driven gas itself: two-body truths, conservation, return under reversed velocities and
// the known pressure of the hard-disc fluid. A second method, brute force in steps, agrees with it.
#include "reference/event_driven.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "reference/hard_disc_fluid.h"
#include "reference/time_stepped.h"

namespace reference {
namespace {

std::vector<Disc> lattice(int columns, int rows, double pitch, double radius, double speed, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, speed);
  std::vector<Disc> discs;
  Vec sum;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      Disc d;
      d.x = {(i + 0.5) * pitch, (j + 0.5) * pitch};
      d.v = {normal(random), normal(random)};
      d.radius = radius;
      sum = sum + d.v;
      discs.push_back(d);
    }
  }
  for (Disc& d : discs) d.v = d.v - (1.0 / static_cast<double>(discs.size())) * sum;
  return discs;
}

TEST(EventDriven, TwoDiscsHitAsTheClosedFormSays) {
  const Disc a{{3, 5.75}, {2, 0}, 0.5, 1, 0};
  const Disc b{{8, 5}, {0, 0}, 1, 3, 0};
  const Impact truth = collide(a, b, 1, 0);
  EventDriven gas({20, 20, false, 0}, 1, {a, b});
  gas.advance(truth.time + 0.5);
  EXPECT_EQ(gas.pair_collisions(), 1u);
  EXPECT_NEAR(length(gas.discs()[0].v - truth.a.v), 0, 1e-12);
  EXPECT_NEAR(length(gas.discs()[1].v - truth.b.v), 0, 1e-12);
  EXPECT_NEAR(length(gas.discs()[0].x - (truth.a.x + 0.5 * truth.a.v)), 0, 1e-12);
}

TEST(EventDriven, BouncesOnTheFloor) {
  const Bounces truth{1, 0.8, 9.81};
  EventDriven gas({10, 10, false, 9.81}, 0.8, {Disc{{5, 1.5}, {0, 0}, 0.5, 1, 0}});
  gas.advance(0.5 * (truth.time(1) + truth.time(2)));  // at the third flight's apex
  EXPECT_EQ(gas.wall_collisions(), 2u);
  EXPECT_NEAR(gas.discs()[0].x.y - 0.5, truth.apex(1), 1e-9);
  EXPECT_NEAR(gas.discs()[0].v.y, 0, 1e-9);
}

TEST(EventDriven, BouncesOffTheCeilingUnderGravity) {
  EventDriven gas({10, 3, false, 9.81}, 1, {Disc{{5, 0.5}, {0.3, 9}, 0.5, 2, 0}});
  const double before = gas.energy();
  gas.advance(60);
  EXPECT_GT(gas.wall_collisions(), 100u);
  EXPECT_NEAR(gas.energy(), before, 1e-10 * before);
  EXPECT_LE(gas.discs()[0].x.y, 2.5 + 1e-9);
  EXPECT_GE(gas.discs()[0].x.y, 0.5 - 1e-9);
}

TEST(EventDriven, WalledGasKeepsItsEnergyAndNeverOverlaps) {
  EventDriven gas({20, 20, false, 0}, 1, lattice(10, 10, 2, 0.5, 3, 1));
  const double before = gas.energy();
  for (int k = 0; k < 50; ++k) {
    gas.advance(0.2);
    for (std::size_t a = 0; a < gas.discs().size(); ++a) {
      for (std::size_t b = a + 1; b < gas.discs().size(); ++b) {
        ASSERT_GT(length(gas.discs()[a].x - gas.discs()[b].x), 1 - 1e-9);
      }
    }
  }
  EXPECT_GT(gas.pair_collisions(), 1000u);
  EXPECT_NEAR(gas.energy(), before, 1e-11 * before);
}

TEST(EventDriven, PeriodicGasKeepsMomentum) {
  EventDriven gas({20, 20, true, 0}, 1, lattice(10, 10, 2, 0.5, 3, 2));
  gas.advance(10);
  EXPECT_GT(gas.pair_collisions(), 1000u);
  EXPECT_NEAR(length(gas.momentum()), 0, 1e-10);
}

TEST(EventDriven, RunsBackToItsStart) {
  const auto start = lattice(6, 6, 2, 0.5, 1, 3);
  EventDriven gas({12, 12, false, 0}, 1, start);
  gas.advance(2);
  const auto there = gas.pair_collisions();
  EXPECT_GT(there, 20u);
  gas.reverse();
  gas.advance(2);
  EXPECT_EQ(gas.pair_collisions(), 2 * there);
  for (std::size_t i = 0; i < start.size(); ++i) {
    EXPECT_NEAR(length(gas.discs()[i].x - start[i].x), 0, 1e-6);
  }
}

TEST(EventDriven, AgreesWithBruteForceInSteps) {
  // Of unlike sizes and masses. Both run until rounding, grown at every collision, would show.
  std::vector<Disc> start = lattice(5, 5, 2, 0.5, 3, 7);
  for (std::size_t k = 0; k < start.size(); ++k) {
    start[k].radius = 0.3 + 0.02 * static_cast<double>(k);
    start[k].mass = 1 + static_cast<double>(k % 4);
  }
  EventDriven events({10, 10, false, 0}, 1, start);
  TimeStepped steps(10, 10, start);
  events.advance(2);
  steps.advance(2, 0.01);
  EXPECT_GT(events.pair_collisions(), 50u);
  EXPECT_EQ(events.pair_collisions() + events.wall_collisions(), static_cast<std::uint64_t>(steps.collisions()));
  for (std::size_t k = 0; k < start.size(); ++k) {
    EXPECT_NEAR(length(events.discs()[k].x - steps.discs()[k].x), 0, 1e-6) << k;
    EXPECT_NEAR(length(events.discs()[k].v - steps.discs()[k].v), 0, 1e-5) << k;
  }
}

/// Z = 1 + virial / (2 N kT t) of n = side^2 discs.
double measured_compressibility(double packing, int side, double span) {
  const double pitch = std::sqrt(std::numbers::pi * 0.25 / packing);
  EventDriven gas({side * pitch, side * pitch, true, 0}, 1, lattice(side, side, pitch, 0.5, 1, 4));
  const double n = side * side;
  const double kt = gas.energy() / n;
  gas.advance(5);  // forget the lattice
  const double before = gas.virial();
  gas.advance(span);
  return 1 + (gas.virial() - before) / (2 * n * kt * span);
}

TEST(EventDriven, PressureIsThatOfTheHardDiscFluid) {
  EXPECT_NEAR(measured_compressibility(0.3, 12, 40), kHardDiscFluid[2].compressibility, 0.03);
}

TEST(SlowEventDriven, PressureIsThatOfTheHardDiscFluidAtEveryPacking) {
  // The table is of the limit of many discs; 144 differ by about 1/N of Z, which is the tolerance.
  for (const HardDiscFluid& state : kHardDiscFluid) {
    const double z = measured_compressibility(state.packing, 12, 300);
    EXPECT_NEAR(z / state.compressibility, 1, 0.01) << "packing " << state.packing;
  }
}

}  // namespace
}  // namespace reference
