// Shapes with corners under stress: crowds at one point, deep overlaps, size and mass ratios, uneven
// steps, bodies taken away, numbers that are none. Nothing hangs, spreads NaN or gains much energy.
#include "rigid_support.h"

namespace psim::test {
namespace {

double kinetic(const World& world) { return world.diagnostics().kinetic; }

double momentum(const World& world) {
  const Diagnostics d = world.diagnostics();
  return std::hypot(d.momentum_x, d.momentum_y);
}

double fastest(World& world) {
  const PublishedState s = world.published();
  double most = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) most = std::max(most, std::hypot(s.vx[k], s.vy[k]));
  return most;
}

/// Sum of |m v| for bodies of 1 kg.
double all_momenta(World& world) {
  const PublishedState s = world.published();
  double sum = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) sum += std::hypot(s.vx[k], s.vy[k]);
  return sum;
}

// ---- overlaps ---------------------------------------------------------------------------------

TEST(StressRigidOverlap, IdenticalBodiesAtOnePointPart) {
  for (const BodyDesc& body : {box({0, 0}), capsule({0, 0}, 1, 0.3), polygon(regular(5, 0.5), {0, 0})}) {
    for (const int n : {2, 3, 10, 100}) {
      std::uint64_t hash = 0;
      for (int run_again = 0; run_again < 2; ++run_again) {
        auto world = make(unbounded(1000, {0, 0}));
        BodyDesc one = body;
        one.mass = 1;
        for (int k = 0; k < n; ++k) add(*world, one);
        double worst = 0;
        for (int k = 0; k < 240; ++k) {
          ASSERT_EQ(world->step().quarantined, 0u);
          worst = std::max(worst, fastest(*world));
        }
        ASSERT_TRUE(all_finite(*world)) << n;
        EXPECT_LT(momentum(*world), 1e-4 * (1 + all_momenta(*world))) << n;
        EXPECT_LT(worst, 6.0 * n) << n;
        if (run_again) {
          EXPECT_EQ(world->state_hash(), hash) << n;
        }
        hash = world->state_hash();
      }
    }
  }
}

TEST(SlowStressRigidOverlap, AThousandBoxesAtOnePointPart) {
  auto world = make(unbounded(4000, {0, 0}));
  for (int k = 0; k < 1000; ++k) add(*world, box({0, 0}, 1, 1, {}, 1));
  for (int k = 0; k < 20; ++k) ASSERT_EQ(world->step().quarantined, 0u);
  ASSERT_TRUE(all_finite(*world));
  EXPECT_LT(momentum(*world), 1e-4 * (1 + all_momenta(*world)));
  EXPECT_LT(fastest(*world), 2000);
}

TEST(StressRigidOverlap, PairsThatOverlapPartWithLittleEnergy) {
  for (const double overlap : {0.1, 0.25, 0.5, 0.75, 0.99, 1.0}) {
    for (const double e : {0.0, 1.0}) {
      for (const double mass : {1.0, 1000.0}) {
        for (const double angle : {0.0, 0.4}) {
          auto world = make(unbounded(100, {0, 0}));
          const Material m = material(e, 0.3);
          add(*world, box({0, 0}, 1, 1, m, 1));
          const BodyId id = add(*world, turned(box({1 - overlap, 0}, 1, 1, m, mass), angle));
          double worst = 0;
          for (int k = 0; k < 240; ++k) {
            world->step();
            worst = std::max(worst, kinetic(*world));
          }
          ASSERT_TRUE(all_finite(*world));
          EXPECT_LT(worst, 5) << overlap << " e " << e << " mass " << mass;  // J: 3 m/s of push-out
          EXPECT_GT(std::hypot(state(*world, id).x - state(*world, world->id_of(0)).x,
                               state(*world, id).y - state(*world, world->id_of(0)).y),
                    0.9)
              << overlap << " e " << e << " mass " << mass << " angle " << angle;
        }
      }
    }
  }
}

TEST(StressRigidOverlap, OneSunkIntoTheGroundComesOutWithoutAJump) {
  for (const double depth : {0.1, 0.25, 0.45}) {
    for (const bool box_floor : {false, true}) {
      auto world = make(unbounded());
      add(*world, box_floor ? fixed(box({0, -5}, 100, 10, kGrip)) : ground(kGrip));
      const BodyId id = add(*world, box({0, 0.5 - depth}, 1, 1, kGrip));
      double highest = 0;
      for (int k = 0; k < 240; ++k) {
        world->step();
        highest = std::max(highest, state(*world, id).y);
      }
      EXPECT_LT(highest, 0.51) << depth << box_floor;
      EXPECT_NEAR(state(*world, id).y, 0.5, 1e-3) << depth << box_floor;
    }
  }
}

TEST(StressRigidOverlap, AGridThatOverlapsGainsBoundedSpeed) {
  for (const double overlap : {0.1, 0.5, 0.9}) {
    auto world = make(unbounded(1000, {0, 0}));
    for (int k = 0; k < 100; ++k) {
      add(*world, box({k % 10 * (1 - overlap), k / 10 * (1 - overlap)}, 1, 1, {}, 1));
    }
    double worst = 0;
    for (int k = 0; k < 240; ++k) {
      world->step();
      worst = std::max(worst, fastest(*world));
    }
    EXPECT_LT(worst, 40) << overlap;
    EXPECT_LT(momentum(*world), 1e-3) << overlap;
  }
}

// ---- bounce -----------------------------------------------------------------------------------

TEST(StressRigidBounce, NoHeapOfBoxesGainsEnergy) {
  for (const double e : {0.0, 0.3, 0.5, 0.9, 1.0}) {
    for (const double friction : {0.0, 0.4}) {
      for (const int n : {1, 2, 20, 200}) {
        const Material m = material(e, friction);
        auto world = make(walled({-12, 0, 12, 80}, {0, -kG}, m));
        Random random(1);
        for (int k = 0; k < n; ++k) {
          add(*world, moving(box({k % 15 * 1.5 - 10, 1 + 1.5 * (k / 15)}, 0.8, 0.8, m),
                             {random.uniform(-3, 3), random.uniform(-3, 3)}));
        }
        const double before = energy(*world);
        double most = 0;
        for (int k = 0; k < 300; ++k) {
          world->step();
          most = std::max(most, energy(*world));
        }
        EXPECT_LT(most / before, e < 1 ? 1.03 : 1.1) << n << " with e " << e << " and friction " << friction;
      }
    }
  }
}

// ---- ratios -----------------------------------------------------------------------------------

TEST(StressRigidSize, SmallOnLargeAndLargeOnSmall) {
  for (const double small : {0.1, 0.01}) {
    auto world = make(unbounded(100));
    add(*world, ground(kGrip));
    const BodyId large = add(*world, box({0, 5}, 10, 10, kGrip));
    const BodyId on = add(*world, box({1, 10 + 0.5 * small}, small, small, kGrip));
    const BodyId beside = add(*world, box({7, 0.5 * small}, small, small, kGrip));
    run_seconds(*world, 5);
    EXPECT_NEAR(state(*world, large).y, 5, 0.01) << small;
    EXPECT_NEAR(state(*world, on).y, 10 + 0.5 * small, 0.02 + 0.05 * small) << small;
    EXPECT_NEAR(state(*world, beside).y, 0.5 * small, 0.05 * small) << small;
    EXPECT_LT(fastest(*world), 1e-3) << small;
  }
}

// A pebble that is squeezed out is as fast as chance has it, from 12 to 46 m/s in eight heaps: the mean of four counts.
TEST(StressRigidSize, ALargeBoxOnGravelComesToRest) {
  constexpr int kHeaps = 4;
  double worst = 0, rest = 0;
  for (int heap = 1; heap <= kHeaps; ++heap) {
    auto world = make(walled({-8, 0, 8, 60}, {0, -kG}, kGrip));
    Random random(static_cast<std::uint64_t>(heap));
    for (int k = 0; k < 300; ++k) {
      add(*world, turned(box({k % 50 * 0.3 - 7.4, 0.2 + 0.3 * (k / 50)}, 0.2, 0.2, kGrip), random.uniform(0, 3)));
    }
    run_seconds(*world, 3);
    const BodyId large = add(*world, box({0, 12}, 10, 10, kGrip));
    double most = 0;
    for (int k = 0; k < 600; ++k) {
      world->step();
      most = std::max(most, fastest(*world));
    }
    worst += most / kHeaps;
    rest += speed_of(state(*world, large)) / kHeaps;
    EXPECT_GT(state(*world, large).y, 5) << heap;
  }
  EXPECT_LT(worst, 35);
  EXPECT_LT(rest, 0.05);
}

TEST(StressRigidMass, FromAMillionthToAMillion) {
  for (const double ratio : {1e-6, 1e-3, 1e3, 1e6}) {
    auto world = make(unbounded());
    add(*world, ground(kGrip));
    const BodyId low = add(*world, box({0, 0.5}, 1, 1, kGrip, 1));
    const BodyId high = add(*world, box({0, 1.5}, 1, 1, kGrip, ratio));
    run_seconds(*world, 5);
    ASSERT_TRUE(all_finite(*world)) << ratio;
    EXPECT_NEAR(state(*world, low).y, 0.5, ratio > 1e4 ? 0.5 : 0.005) << ratio;
    EXPECT_NEAR(state(*world, high).y, 1.5, ratio > 1e4 ? 1.0 : 0.01) << ratio;
    EXPECT_LT(fastest(*world), 0.01) << ratio;
  }
}

// ---- steps ------------------------------------------------------------------------------------

Placed mixed_heap(std::uint64_t seed) {
  Placed p{make(walled({-6, 0, 6, 40}, {0, -kG}, kGrip)), {}, {}};
  Random random(seed);
  for (int k = 0; k < 60; ++k) {
    const Vec2 at{k % 6 * 1.6 - 4, 1 + 1.6 * (k / 6)};
    p.put(turned(k % 3 == 0   ? box(at, 1, 0.6, kGrip)
                 : k % 3 == 1 ? capsule(at, 0.7, 0.25, kGrip)
                              : polygon(regular(5, 0.5), at, kGrip),
                 random.uniform(0, 6)));
  }
  return p;
}

TEST(StressRigidSteps, OfAnyLengthHeapComesToRest) {
  for (const double dt : {1.0 / 240, 1.0 / 60, 1.0 / 30, 1.0 / 15, 1.0 / 10}) {
    Placed p = mixed_heap(3);
    const double before = energy(*p.world);
    double most = before;
    for (double t = 0; t < 10; t += dt) {
      ASSERT_EQ(p.world->step(dt).quarantined, 0u);
      most = std::max(most, energy(*p.world));
    }
    EXPECT_LT(most / before, 1.01) << dt;
    EXPECT_TRUE(all_inside(*p.world)) << dt;
    EXPECT_LT(rms_speed(*p.world), dt < 0.02 ? 0.01 : 0.5) << dt;
    EXPECT_LT(p.world->diagnostics().max_penetration, dt < 0.02 ? 0.02 : 0.3) << dt;
  }
}

TEST(StressRigidSteps, OfRandomLengthDoNoHarm) {
  for (const auto& [low, high] : {std::pair{0.8 / 60, 1.2 / 60}, std::pair{1e-4, 0.05}}) {
    Placed p = mixed_heap(5);
    Random random(7);
    const double before = energy(*p.world);
    double most = before;
    for (int k = 0; k < 900; ++k) {
      p.world->step(random.uniform(low, high));
      most = std::max(most, energy(*p.world));
    }
    EXPECT_LT(most / before, 1.01) << high;
    EXPECT_TRUE(all_inside(*p.world)) << high;
    EXPECT_LT(rms_speed(*p.world), 0.3) << high;
  }
}

TEST(StressRigidSteps, OfRandomLengthLeaveAStackStanding) {
  Placed p = stack(20);
  Random random(7);
  double shaken = 0;
  for (int k = 0; k < 600; ++k) {
    p.world->step(random.uniform(0.8 / 60, 1.2 / 60));
    if (k > 60) shaken = std::max(shaken, p.fastest());
  }
  EXPECT_NEAR(p.top().y, 19.5, 0.01);
  EXPECT_LT(p.sideways(), 1e-3);
  EXPECT_LT(shaken, 0.05);
}

TEST(StressRigidSteps, OfExtremeLengthsAreFinite) {
  Placed p = mixed_heap(9);
  for (const double dt : {1e-9, 1e-6, 1.0, 1e-3, 0.5, 1.0 / 60}) {
    for (int k = 0; k < 20; ++k) p.world->step(dt);
    ASSERT_TRUE(all_finite(*p.world)) << dt;
    ASSERT_TRUE(all_inside(*p.world)) << dt;
  }
}

TEST(StressRigidGravity, WithoutAnyOrReversedNothingBreaks) {
  auto world = make(unbounded(100, {0, 0}));
  for (int k = 0; k < 50; ++k) add(*world, box({0, k + 0.5}, 1, 1, kGrip));
  run(*world, 300);
  EXPECT_LT(fastest(*world), 1e-6);
  auto sideways = make(walled({0, 0, 40, 40}, {kG, 0}, kGrip));
  std::vector<BodyId> row;
  for (int k = 0; k < 20; ++k) row.push_back(add(*sideways, box({39.5 - k, 20.5}, 1, 1, kGrip)));
  run(*sideways, 600);
  EXPECT_NEAR(state(*sideways, row.back()).x, 20.5, 0.005);
  EXPECT_NEAR(state(*sideways, row.back()).y, 20.5, 1e-4);
}

// ---- bodies that go, and numbers that are none -------------------------------------------------

TEST(StressRigidRemoval, UnderAStackAgainAndAgain) {
  Placed p = stack(30);
  Random random(3);
  std::size_t left = p.ids.size();
  for (int k = 0; k < 600 && left > 1; ++k) {
    if (k % 20 == 19) {
      const std::size_t which = random.below(p.ids.size());
      if (p.world->remove_body(p.ids[which])) --left;
    }
    ASSERT_EQ(p.world->step().quarantined, 0u);
  }
  run(*p.world, 300);
  ASSERT_TRUE(all_finite(*p.world));
  EXPECT_LT(p.fastest(), 1e-3);
  EXPECT_EQ(p.world->dynamic_count(), left);
}

TEST(StressRigidRemoval, OfTheGroundLetsAllFall) {
  auto world = make(unbounded(1000));
  const BodyId floor = add(*world, fixed(box({0, -0.5}, 20, 1, kGrip)));
  std::vector<BodyId> ids;
  for (int k = 0; k < 10; ++k) ids.push_back(add(*world, box({0, k + 0.5}, 1, 1, kGrip)));
  run(*world, 120);
  ASSERT_TRUE(world->remove_body(floor));
  run(*world, 60);
  for (const BodyId id : ids) EXPECT_NEAR(state(*world, id).vy, -kG, 0.01);
}

TEST(StressRigidNumbers, ABrokenBodyIsSetAsideAndTheOthersGoOn) {
  for (const double bad : {kNan, kInf, -kInf, 1e300}) {
    for (const int kind : {0, 1, 2}) {
      Placed with = stack(5), without = stack(5);
      const BodyId broken = add(*with.world, box({10, 0.5}, 1, 1, kGrip));
      add(*without.world, box({10, 0.5}, 1, 1, kGrip));
      run(*with.world, 10);
      run(*without.world, 10);
      if (kind == 0) with.world->set_velocity(broken, {bad, 0}, 0);
      if (kind == 1) with.world->set_velocity(broken, {0, 0}, bad);
      if (kind == 2) with.world->set_transform(broken, {bad, 0.5}, 0);
      std::uint32_t quarantined = 0;
      for (int k = 0; k < 60; ++k) {
        quarantined += with.world->step().quarantined;
        without.world->step();
      }
      ASSERT_TRUE(all_finite(*with.world)) << bad << " kind " << kind;
      if (!std::isfinite(bad)) {
        EXPECT_EQ(quarantined, 1u) << bad << " kind " << kind;
      }
      for (std::size_t k = 0; k < with.ids.size(); ++k) {
        EXPECT_EQ(with.now(k).y, without.now(k).y) << bad << " kind " << kind;
        EXPECT_EQ(with.now(k).vy, without.now(k).vy) << bad << " kind " << kind;
      }
    }
  }
}

TEST(StressRigidNumbers, ABrokenBoxInAStackLeavesTheRestFinite) {
  for (const double bad : {kNan, kInf}) {
    Placed p = stack(10);
    run(*p.world, 60);
    p.world->set_velocity(p.ids[4], {bad, bad}, bad);
    for (int k = 0; k < 300; ++k) p.world->step();
    EXPECT_TRUE(all_finite(*p.world));
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(p.now(k).y, static_cast<double>(k) + 0.5, 0.01);
  }
}

TEST(StressRigidNumbers, ExtremeSpinIsFinite) {
  for (const double omega : {1e3, 1e6, 1e12, 1e30}) {
    auto world = make(unbounded());
    add(*world, ground(kGrip));
    const BodyId spun = add(*world, box({0, 3}, 1, 1, kGrip));
    ASSERT_TRUE(world->apply_angular_impulse(spun, omega / 6));  // of 1 kg
    add(*world, box({2, 0.5}, 1, 1, kGrip));
    for (int k = 0; k < 240; ++k) world->step();
    EXPECT_TRUE(all_finite(*world)) << omega;
  }
}

}  // namespace
}  // namespace psim::test
