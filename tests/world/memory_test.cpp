// Bytes a disc, estimates before a run, and bulk adding.
#include "support.h"

namespace psim::test {
namespace {

TEST(Memory, AGasTakesAtMostTwoHundredBytesADisc) {
  const std::size_t n = 100000;
  auto world = make(walled({0, 0, 1000, 1000}, {0, -kG}, material(0.5)), best_isa(), 2);
  add(*world, lattice(n, {1, 1, 999, 999}, 0.5, 10, material(0.5), 0.9));
  run(*world, 30);
  EXPECT_LE(world->memory_bytes() / n, 200u);
}

TEST(Memory, APileTakesAtMostSixHundredBytesADisc) {
  const std::size_t n = 20000;
  auto world = pile(n, {}, best_isa(), 2);
  run(*world, 60);
  EXPECT_LE(world->memory_bytes() / n, 600u);
}

// The lists of a block that falls far in an empty box follow its own density, not the box's.
TEST(Memory, ABlockThatFallsFarKeepsItsListsShort) {
  const std::size_t n = 5000;
  auto world = make(walled({0, 0, 3000, 3000}));
  add(*world, lattice(n, {1000, 2000, 1030, 2030}, 0.1, 0, {}, 0.5));
  std::size_t most = 0;
  for (int frame = 0; frame < 120; ++frame) {
    world->step();
    most = std::max(most, world->memory_bytes() / n);
  }
  EXPECT_LE(most, 800u);
}

TEST(Memory, TheEstimateIsAnUpperOne) {
  for (const std::size_t n : {0u, 1u, 1000u, 100000u}) {
    auto world = make(walled({0, 0, 1000, 1000}, {0, -kG}));
    if (n) add(*world, lattice(n, {1, 1, 999, 999}, 0.5, 10, {}));
    EXPECT_GE(estimate_memory_bytes(n), world->memory_bytes()) << n;
  }
  EXPECT_GT(estimate_memory_bytes(10000000), estimate_memory_bytes(1000000));
}

// Until the first step a prepared world keeps its state of before, and then gives it back: `x = {}` would keep the
// room.
TEST(Memory, WhatPreparingKeepsCountsUntilTheFirstStep) {
  const std::size_t n = 20000;
  auto world = pile(n, {}, best_isa(), 2);
  world->prepare();
  const std::size_t prepared = world->memory_bytes();
  world->step();
  EXPECT_GE(prepared, world->memory_bytes() + 20 * n);
}

TEST(Memory, DoesNotGrowWithTime) {
  auto world = gas_in_walls(2000, 0.2, material(1));
  run(*world, 120);
  const std::size_t before = world->memory_bytes();
  run(*world, 600);
  EXPECT_EQ(world->memory_bytes(), before);
}

TEST(Memory, RemovedBodiesMakeRoomForNewOnes) {
  auto world = make(walled({0, 0, 200, 200}, {0, 0}));
  std::size_t after_first = 0;
  for (int round = 0; round < 10; ++round) {
    add(*world, lattice(5000, {0, 0, 200, 200}, 0.5, 1, {}));
    run(*world, 2);
    const PublishedState s = world->published();
    const std::vector<std::uint32_t> ids(s.id.begin(), s.id.end());
    for (const std::uint32_t id : ids) ASSERT_TRUE(world->remove_body(world->id_of(id)));
    ASSERT_EQ(world->body_count(), 0u);
    if (round == 1) after_first = world->memory_bytes();
  }
  EXPECT_LE(world->memory_bytes(), after_first + after_first / 4);
}

TEST(SlowBulk, AMillionDiscsGoInAtOnce) {
  const std::size_t n = 1000000;
  auto world = make(walled({0, 0, 3200, 3200}, {0, -kG}), best_isa(), 2);
  EXPECT_EQ(add(*world, lattice(n, {1, 1, 3199, 3199}, 0.5, 10, {}, 0.9)), 0u);
  EXPECT_EQ(world->body_count(), n);
  run(*world, 3);
  EXPECT_LE(world->memory_bytes() / n, 200u);  // before columns are published: 61 bytes more
  EXPECT_TRUE(all_inside(*world));
  EXPECT_TRUE(all_finite(*world));
}

TEST(Bulk, EqualsOneByOne) {
  const Discs discs = lattice(300, {0, 0, 30, 30}, 0.5, 5, material(0.5, 0.3));
  auto bulk = make(walled({0, 0, 30, 30}));
  auto single = make(walled({0, 0, 30, 30}));
  add(*bulk, discs);
  for (std::size_t k = 0; k < discs.size(); ++k) {
    add(*single, disc({discs.x[k], discs.y[k]}, {discs.vx[k], discs.vy[k]}, 0.5, discs.m));
  }
  EXPECT_EQ(bulk->state_hash(), single->state_hash());
  EXPECT_EQ(hashes(*bulk, 60), hashes(*single, 60));
}

TEST(Bulk, TakesEveryColumn) {
  const std::vector<double> x{0, 5}, y{1, 6}, radius{0.5, 0.75}, angle{0.1, 0.2}, vx{1, 2}, vy{3, 4}, omega{5, 6};
  DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.radius = radius;
  batch.angle = angle;
  batch.vx = vx;
  batch.vy = vy;
  batch.angular_velocity = omega;
  batch.mass = 3;
  auto world = make(unbounded());
  std::uint32_t first = 7;
  std::string error;
  ASSERT_EQ(world->add_discs(batch, first, error), 2u) << error;
  EXPECT_EQ(first, 0u);
  for (std::uint32_t k = 0; k < 2; ++k) {
    const BodyState s = state(*world, world->id_of(k));
    EXPECT_EQ(s.x, x[k]);
    EXPECT_EQ(s.y, y[k]);
    EXPECT_NEAR(s.angle, angle[k], 1e-6);
    EXPECT_EQ(s.vx, vx[k]);
    EXPECT_EQ(s.vy, vy[k]);
    EXPECT_EQ(s.omega, omega[k]);
    EXPECT_EQ(s.radius, radius[k]);
  }
  EXPECT_NEAR(world->diagnostics().momentum_x, 9, 1e-6);
}

}  // namespace
}  // namespace psim::test
