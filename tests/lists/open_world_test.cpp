// Open worlds: who leaves the bounds is taken out and counted, nobody else notices.
#include "support.h"

namespace psim::test {
namespace {

TEST(OpenWorld, TakesOutWhoLeavesAndCounts) {
  for (const Isa isa : available_isas()) {
    auto world = make(unbounded(50, {0, 0}), isa);
    const BodyId east = add(*world, disc({40, 0}, {20, 0}));
    const BodyId north = add(*world, disc({0, 45}, {0, 20}));
    const BodyId stays = add(*world, disc({0, 0}, {1, 0}));
    std::uint32_t escaped = 0;
    std::uint64_t east_gone = 0, north_gone = 0;
    for (int k = 0; k < 120; ++k) {
      escaped += world->step().escaped;
      if (!east_gone && !world->is_valid(east)) east_gone = world->frame();
      if (!north_gone && !world->is_valid(north)) north_gone = world->frame();
    }
    EXPECT_EQ(escaped, 2u);
    EXPECT_EQ(world->escaped_total(), 2u);
    EXPECT_EQ(world->body_count(), 1u);
    EXPECT_TRUE(world->is_valid(stays));
    EXPECT_FALSE(world->body(east).has_value());
    EXPECT_NEAR(static_cast<double>(east_gone), 30, 2);   // the centre crosses at 0.5 s
    EXPECT_NEAR(static_cast<double>(north_gone), 15, 2);  // and at 0.25 s
    EXPECT_NEAR(state(*world, stays).x, 2, 1e-5);
  }
}

TEST(OpenWorld, OthersGoOnUnchanged) {
  const auto build = [](bool runaway) {
    auto world = make(unbounded(60));
    add(*world, ground(material(0.2, 0.3), 50));
    add(*world, lattice(150, {-20, 1, 20, 30}, 0.5, 2, material(0.2, 0.3)));
    if (runaway) {
      for (int k = 0; k < 10; ++k) add(*world, disc({55, 10.0 + 3 * k}, {30, 0}, 0.5, material(0.2, 0.3)));
    }
    return world;
  };
  auto with = build(true);
  auto without = build(false);
  // Before the heap at the ground makes every last bit count.
  run(*with, 60);
  run(*without, 60);
  EXPECT_EQ(with->escaped_total(), 10u);
  const PublishedState s = with->published(), t = without->published();
  ASSERT_EQ(s.id.size(), t.id.size());
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    EXPECT_EQ(s.id[k], t.id[k]);
    EXPECT_NEAR(s.x[k], t.x[k], 1e-2);
    EXPECT_NEAR(s.y[k], t.y[k], 1e-2);
  }
}

TEST(OpenWorld, CanRunEmpty) {
  auto world = make(unbounded(10));
  add(*world, disc({0, 0}));
  run(*world, 300);
  EXPECT_EQ(world->body_count(), 0u);
  EXPECT_EQ(world->escaped_total(), 1u);
  EXPECT_EQ(world->published().id.size(), 0u);
  const BodyId again = add(*world, disc({0, 0}));
  run(*world, 10);
  EXPECT_TRUE(world->is_valid(again));
}

TEST(OpenWorld, AnEmptyWorldSteps) {
  for (const WorldDesc& desc : {unbounded(), walled({0, 0, 1, 1}), periodic(10, 10)}) {
    auto world = make(desc, best_isa(), 2);
    const StepReport report = world->step();
    EXPECT_EQ(report.pairs, 0u);
    EXPECT_EQ(report.contacts, 0u);
    EXPECT_EQ(world->frame(), 1u);
    world->state_hash();
    EXPECT_EQ(world->diagnostics().kinetic, 0);
  }
}

}  // namespace
}  // namespace psim::test
