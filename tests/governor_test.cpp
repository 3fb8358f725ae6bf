// The governor: what it decides from counts, and that a run that was cut replays bit for bit.
#include "governor.h"

#include "support.h"

namespace psim::test {
namespace {

WorkCounts heap_work() {
  WorkCounts work;
  work.bodies = work.solved = 10000;
  work.contacts = 27000;
  work.builds = work.lays_out = true;
  return work;
}

Governor with_budget(double ms) {
  Governor governor;
  GovernorDesc desc;
  desc.on = true;
  desc.budget_ms = ms;
  governor.set(desc);
  return governor;
}

TEST(Governor, CutsNothingThatFits) {
  const Governor governor = with_budget(100);
  EXPECT_EQ(governor.spread(heap_work()).frames, 1);
  EXPECT_EQ(governor.substeps(heap_work(), 1, 8), 8);
}

TEST(Governor, TakesAsManySubstepsAsFitInFourFifthsOfTheBudget) {
  const Governor any = with_budget(1);
  const WorkCounts work = heap_work();
  for (int substeps = 1; substeps <= 8; ++substeps) {
    const double ns = any.fixed_ns(work) + (substeps + 0.5) * any.substep_ns(work);
    EXPECT_EQ(with_budget(ns / 0.8e6).substeps(work, 1, 8), substeps);
  }
}

TEST(Governor, NeverGoesBelowTheLeast) {
  EXPECT_EQ(with_budget(1e-6).substeps(heap_work(), 1, 8), 1);
  EXPECT_EQ(with_budget(1e-6).substeps(heap_work(), 3, 8), 3);
}

TEST(Governor, SpreadsWhatDoesNotFitOverFewFrames) {
  int last = 3;
  bool seen[4] = {};
  for (double ms = 0.01; ms < 10; ms *= 1.05) {
    const Governor::Spread spread = with_budget(ms).spread(heap_work());
    EXPECT_LE(spread.frames, last) << ms;  // more budget, no more frames
    last = spread.frames;
    seen[spread.frames] = true;
    int all = 0;
    for (int k = 0; k < spread.frames; ++k) {
      EXPECT_EQ(all & spread.parts[k], 0) << "done twice";
      all |= spread.parts[k];
    }
    EXPECT_EQ(all, StepDetail::kAll);
    EXPECT_NE(spread.parts[spread.frames - 1] & StepDetail::kSolve, 0);
  }
  EXPECT_TRUE(seen[1] && seen[2] && seen[3]);
}

TEST(Governor, MeasuresCostsAboveZero) {
  const CostModel costs = World::measure_costs({best_isa(), 1}, 2000);
  EXPECT_GT(costs.build, 0);
  EXPECT_GT(costs.pass, 0);
  EXPECT_GT(costs.check, 0);
}

// Falling discs with a budget far below what they need, details as they were chosen.
struct Cut {
  std::uint64_t hash = 0;
  double time = 0;  // s that passed in the world
  int waits = 0, fewer = 0;
  std::vector<StepDetail> details;
};

std::unique_ptr<World> falling(Isa isa, int threads, double restitution) {
  auto world = make(walled({0, 0, 60, 200}, {0, -kG}, material(restitution)), isa, threads);
  add(*world, lattice(1500, {0, 0, 60, 60}, 0.6, 1, material(restitution)));
  return world;
}

Cut governed(double restitution) {
  auto world = falling(best_isa(), 1, restitution);
  GovernorDesc desc;
  desc.on = true;
  desc.budget_ms = 0.12;
  world->set_governor(desc);
  Cut cut;
  for (int k = 0; k < 300; ++k) {
    const StepReport report = world->step();
    cut.details.push_back(report.detail);
    cut.waits += report.detail.waits();
    cut.fewer += !report.detail.waits() && report.detail.substeps < 4;
    if (!report.detail.waits()) cut.time += report.detail.frames / 60.0;
  }
  cut.hash = world->state_hash();
  return cut;
}

TEST(Governor, ACutRunReplaysBitForBitOnEveryIsaAndThreadCount) {
  for (const double restitution : {0.0, 0.5}) {
    const Cut cut = governed(restitution);
    EXPECT_GT(cut.waits, 10) << restitution;
    EXPECT_GT(cut.fewer, 10) << restitution;
    for (const Isa isa : available_isas()) {
      for (const int threads : {1, 3}) {
        auto world = falling(isa, threads, restitution);
        for (const StepDetail& detail : cut.details) world->replay(detail);
        EXPECT_EQ(world->state_hash(), cut.hash) << isa_name(isa) << " " << threads;
      }
    }
  }
}

TEST(Governor, TimeStandsStillAndIsMadeUpFor) {
  const Cut cut = governed(0);
  EXPECT_NEAR(cut.time, 5, 3 / 60.0);  // up to a step under way
  auto world = falling(best_isa(), 1, 0);
  double before = 0;
  for (const StepDetail& detail : cut.details) {
    before = state(*world, world->id_of(0)).y;
    world->replay(detail);
    if (detail.waits()) {
      EXPECT_EQ(state(*world, world->id_of(0)).y, before);
    }
  }
  EXPECT_TRUE(all_finite(*world));
}

TEST(Governor, BodiesMayComeAndGoWhileTimeStandsStill) {
  auto world = falling(best_isa(), 1, 0);
  GovernorDesc desc;
  desc.on = true;
  desc.budget_ms = 0.12;
  world->set_governor(desc);
  int changes = 0;
  for (int k = 0; k < 200; ++k) {
    if (world->step().detail.waits()) {
      add(*world, disc({5 + 0.25 * (k % 200), 150}));
      world->remove_body(world->id_of(static_cast<std::uint32_t>(k)));
      ++changes;
    }
  }
  EXPECT_GT(changes, 5);
  EXPECT_TRUE(all_finite(*world));
  EXPECT_EQ(world->body_count(), 1500u);
}

}  // namespace
}  // namespace psim::test
