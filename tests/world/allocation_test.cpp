// A warm step allocates nothing: by its own report, and by counting every operator new.
#include "allocation_counter.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

void expect_no_allocation(World& world, int warm_up, int frames) {
  run(world, warm_up);
  std::uint64_t growths = 0;
  const std::uint64_t before = allocations();
  for (int k = 0; k < frames; ++k) growths += world.step().arena_growths;
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_EQ(growths, 0u);
}

TEST(Allocation, TheCounterCounts) {
  const std::uint64_t before = allocations();
  const auto p = std::make_unique<std::vector<int>>(10);
  EXPECT_GE(allocations() - before, 2u);
}

TEST(Allocation, NoneInAWarmGas) {
  for (const int threads : {1, 3}) {
    auto world = gas_in_walls(2000, 0.2, material(1), 10, best_isa(), threads);
    expect_no_allocation(*world, 120, 240);
  }
}

TEST(Allocation, NoneInAPileAtRest) {
  for (const int threads : {1, 3}) {
    auto world = pile(1000, material(0.2, 0.5), best_isa(), threads);
    world->set_sleeping(false);  // falling asleep: sleep_test.cpp
    expect_no_allocation(*world, 300, 120);
  }
}

TEST(Allocation, NoneWhereTheListsOfAFewBodiesAreMadeAnew) {
  auto world = pile(1000, material(0.2, 0.5));
  world->set_sleeping(false);
  run(*world, 160);
  std::uint64_t renewed = 0;
  const std::uint64_t before = allocations();
  for (int k = 0; k < 80; ++k) renewed += world->step().renewed;
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_GT(renewed, 30u);
}

TEST(Allocation, NoneInAPeriodicWorldWithFields) {
  WorldDesc desc = periodic(60, 60);
  desc.fields.push_back(WellField{{30, 30}, 100, 1, 2, 0});
  desc.fields.push_back(DragField{0.01, 0.01});
  auto world = make(desc);
  add(*world, lattice(800, {0, 0, 60, 60}, 0.5, 5, material(1)));
  expect_no_allocation(*world, 300, 120);
}

TEST(Allocation, NoneWhileBodiesEscape) {
  auto world = make(unbounded(30, {0, 0}));
  add(*world, lattice(500, {-25, -25, 25, 25}, 0.5, 10, material(1)));
  expect_no_allocation(*world, 30, 120);
  EXPECT_GT(world->escaped_total(), 50u);
}

TEST(Allocation, NoneWhileSnapshotsArePublished) {
  auto world = gas_in_walls(500, 0.2, material(1));
  world->enable_snapshots(true);
  run(*world, 30);
  world->latest_snapshot();
  expect_no_allocation(*world, 90, 120);
}

/// Of a step in which bodies fall asleep, the first or the only one.
void expect_none_at_the_first_sleep(World& world) {
  for (int k = 0; k < 1200; ++k) {
    const std::uint64_t before = allocations();
    const StepReport report = world.step();
    if (report.asleep == 0) continue;
    EXPECT_EQ(allocations() - before, 0u) << "frame " << k;
    EXPECT_EQ(report.arena_growths, 0u) << "frame " << k;
    return;
  }
  ADD_FAILURE() << "nobody fell asleep";
}

TEST(Allocation, NoneWhenTheFirstDiscsFallAsleep) {
  for (const int threads : {1, 3}) {
    auto world = pile(600, material(0.2, 0.5), best_isa(), threads);
    expect_none_at_the_first_sleep(*world);
  }
}

TEST(Allocation, NoneWhenTheFirstShapesFallAsleep) {
  for (const bool joined : {false, true}) {
    auto world = make(walled({0, 0, 30, 30}, {0, -kG}, material(0, 0.5)));
    BodyId last;
    for (int k = 0; k < 24; ++k) {
      const Vec2 at{1.5 + 2.2 * (k % 12), 0.5 + (k < 12 ? 0 : 1)};
      const BodyId id = add(*world, k % 3 == 0 ? disc(at, {}, 0.5, material(0, 0.5)) : box(at, 1, 1, material(0, 0.5)));
      if (joined && k % 6 == 1) {
        JointDesc rod;
        rod.a = last;
        rod.b = id;
        std::string error;
        ASSERT_NE(world->add_joint(rod, error), kNoJoint) << error;
      }
      last = id;
    }
    world->prepare();
    expect_none_at_the_first_sleep(*world);
  }
}

TEST(Allocation, GrowthIsReported) {
  auto world = gas_in_walls(2000, 0.2, material(1));
  std::uint64_t growths = 0;
  for (int k = 0; k < 10; ++k) growths += world->step().arena_growths;
  EXPECT_GT(growths, 0u);
}

}  // namespace
}  // namespace psim::test
