// The governor: what it decides from counts, and that a run that was cut replays bit for bit.
#include "step/governor.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "support.h"

namespace psim::test {
namespace {

WorkCounts heap_work() {
  WorkCounts work;
  work.bodies = work.solved = 10000;
  work.contacts = 27000;
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
  EXPECT_EQ(governor.horizon(heap_work(), 8), 1);
  const Governor::Choice choice = governor.choose(heap_work(), governor.room_ns(), 1, 1, 8);
  EXPECT_TRUE(choice.solves);
  EXPECT_EQ(choice.substeps, 8);
  EXPECT_EQ(choice.frames, 1);
}

TEST(Governor, TakesAsManySubstepsAsFit) {
  const WorkCounts work = heap_work();
  const Governor any = with_budget(1);
  for (int substeps = 1; substeps <= 8; ++substeps) {
    const double left = rest_ns(any.costs(), work) + (substeps + 0.5) * substep_ns(any.costs(), work);
    EXPECT_EQ(any.choose(work, left, 1, 1, 8).substeps, substeps);
  }
}

TEST(Governor, AWholeFrameHasOneSubstepAtLeast) {
  const Governor poor = with_budget(1e-6);
  const Governor::Choice choice = poor.choose(heap_work(), poor.room_ns(), 3, 3, 8);
  EXPECT_TRUE(choice.solves);
  EXPECT_EQ(choice.substeps, 1);
  EXPECT_EQ(choice.frames, 1) << "no substep is longer than a frame";
}

// Little is left of the third frame: one substep makes up for one frame of three, the next frame's four for four.
TEST(Governor, WaitsAFrameWhereThatLosesLessTime) {
  const WorkCounts work = heap_work();
  const double budget = (rest_ns(with_budget(1).costs(), work) + 4.5 * substep_ns(with_budget(1).costs(), work)) / 1e6;
  const Governor governor = with_budget(budget * 1e6 / with_budget(1).room_ns());
  const double one = rest_ns(governor.costs(), work) + 1.5 * substep_ns(governor.costs(), work);
  EXPECT_FALSE(governor.choose(work, one, 3, 4, 4).solves);
  EXPECT_TRUE(governor.choose(work, one, 1, 1, 4).solves) << "nothing is lost";
}

WorkCounts bouncing_work() {
  WorkCounts work = heap_work();
  work.lanes = 30000;
  work.sweeps = 9;
  return work;
}

TEST(Governor, SweepsOverImpactsGoOnlyWhereTimeWouldBeLost) {
  const WorkCounts work = bouncing_work(), few = with_sweeps(work, Governor::kFewSweeps);
  const Governor any = with_budget(1);
  ASSERT_LT(substep_ns(any.costs(), few), 0.7 * substep_ns(any.costs(), work));
  const double fits = rest_ns(any.costs(), work) + 1.05 * substep_ns(any.costs(), work);
  const double fits_few = rest_ns(any.costs(), work) + 0.95 * substep_ns(any.costs(), work);
  EXPECT_EQ(any.choose(work, fits, 1, 1, 4).sweeps, 0);
  EXPECT_EQ(any.choose(work, fits_few, 1, 1, 4).sweeps, Governor::kFewSweeps);
  EXPECT_TRUE(any.choose(work, fits_few, 1, 1, 4).solves);
  EXPECT_EQ(any.choose(heap_work(), rest_ns(any.costs(), work), 1, 1, 4).sweeps, 0) << "there are none";
}

TEST(Governor, FewSweepsMakeUpForMoreFrames) {
  const WorkCounts work = bouncing_work(), few = with_sweeps(work, Governor::kFewSweeps);
  const Governor any = with_budget(1);
  const double left = rest_ns(any.costs(), work) + 2.1 * substep_ns(any.costs(), few);
  ASSERT_LT(left, rest_ns(any.costs(), work) + 2 * substep_ns(any.costs(), work));
  const double share = any.room_ns() / 1e6;
  const Governor governor = with_budget((left + 2 * any.costs().step) / share / 1e6);
  const Governor::Choice choice = governor.choose(work, left, 2, 2, 4);
  EXPECT_TRUE(choice.solves);
  EXPECT_EQ(choice.frames, 2);
  EXPECT_EQ(choice.sweeps, Governor::kFewSweeps);
}

TEST(Governor, ListsServeNoFewerFramesTheLessThereIsOfThem) {
  int last = StepDetail::kMostFrames;
  for (double ms = 0.3; ms < 10; ms *= 1.05) {
    const Governor governor = with_budget(ms);
    const int horizon = governor.horizon(heap_work(), 64);
    const bool one_fits =
        rest_ns(governor.costs(), heap_work()) + 8 * substep_ns(governor.costs(), heap_work()) < governor.room_ns();
    if (!one_fits) continue;  // substeps are the limit
    EXPECT_LE(horizon, last) << ms;
    last = horizon;
  }
  EXPECT_EQ(last, 1);
}

// Of bodies that fly fast, lists for a frame more may have many times as many candidates.
TEST(Governor, ListsThatGrowFasterThanTheirTimeServeOneFrame) {
  WorkCounts work = heap_work();
  work.lists.candidates = 40000;
  const Governor governor = with_budget(0.4);
  const auto steady = [](int) { return Governor::Growth{}; };
  const auto growing = [](int frames) { return Governor::Growth{std::pow(9, frames - 1), 1.0 * frames}; };
  EXPECT_GT(governor.horizon(work, 64, steady), 2);
  EXPECT_EQ(governor.horizon(work, 64, growing), 1);
}

TEST(Governor, MeasuresCostsAboveZero) {
  for (const double ns : World::measure_costs({best_isa(), 1}, 2000, 1000).numbers()) EXPECT_GT(ns, 0);
}

// Falling discs with a budget far below what they need, details as they were chosen.
struct Cut {
  std::uint64_t hash = 0;
  int elapsed = 0, made_up = 0;  // frames
  int waits = 0, fewer = 0, few_sweeps = 0;
  std::vector<StepDetail> details;
};

std::unique_ptr<World> falling(Isa isa, int threads, double restitution) {
  auto world = make(walled({0, 0, 60, 200}, {0, -kG}, material(restitution)), isa, threads);
  add(*world, lattice(1500, {0, 0, 60, 60}, 0.6, 1, material(restitution)));
  return world;
}

void govern(World& world, double budget_ms) {
  GovernorDesc desc;
  desc.on = true;
  desc.budget_ms = budget_ms;
  world.set_governor(desc);
}

Cut governed(std::unique_ptr<World> world, double budget_ms, int frames) {
  govern(*world, budget_ms);
  Cut cut;
  for (int k = 0; k < frames; ++k) {
    const StepReport report = world->step();
    cut.details.push_back(report.detail);
    cut.waits += report.detail.waits();
    cut.few_sweeps += report.detail.sweeps != 0;
    cut.fewer += !report.detail.waits() && report.detail.substeps < 4;
    if (!report.detail.waits()) {
      cut.made_up += report.detail.frames;
      cut.elapsed = k + 1;
    }
  }
  cut.hash = world->state_hash();
  return cut;
}

void expect_replays(const Cut& cut, const std::function<std::unique_ptr<World>(Isa, int)>& make_world) {
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = make_world(isa, threads);
      for (const StepDetail& detail : cut.details) EXPECT_EQ(world->replay(detail).detail, detail);
      EXPECT_EQ(world->state_hash(), cut.hash) << isa_name(isa) << " " << threads;
    }
  }
}

TEST(Governor, ACutRunReplaysBitForBitOnEveryIsaAndThreadCount) {
  for (const double restitution : {0.0, 0.5}) {
    const Cut cut = governed(falling(best_isa(), 1, restitution), 0.15, 300);
    EXPECT_GT(cut.waits, 10) << restitution;
    EXPECT_GT(cut.fewer, 10) << restitution;
    expect_replays(cut, [&](Isa isa, int threads) { return falling(isa, threads, restitution); });
  }
}

// Sweeps over impacts too: discs that bounce, thrown together.
std::unique_ptr<World> colliding(Isa isa, int threads) {
  auto world = make(walled({0, 0, 60, 60}, {0, -kG}, material(0.8)), isa, threads);
  add(*world, lattice(1500, {0, 0, 60, 55}, 0.6, 0.5, material(0.8)));
  for (std::uint32_t k = 0; k < 1500; ++k) {
    world->set_velocity(world->id_of(k), {k % 2 == 0 ? 20.0 : -20.0, k % 3 == 0 ? 20.0 : -20.0}, 0);
  }
  return world;
}

TEST(Governor, ARunWithFewSweepsReplaysBitForBitOnEveryIsaAndThreadCount) {
  const Cut cut = governed(colliding(best_isa(), 1), 0.12, 150);
  EXPECT_GT(cut.few_sweeps, 10);
  expect_replays(cut, colliding);
  auto with_all = colliding(best_isa(), 1);
  for (StepDetail detail : cut.details) {
    detail.sweeps = 0;
    with_all->replay(detail);
  }
  EXPECT_NE(with_all->state_hash(), cut.hash) << "the log's sweeps are not heeded";
}

TEST(Governor, SweepsAreNotCutWithoutNeed) {
  EXPECT_EQ(governed(colliding(best_isa(), 1), 100, 60).few_sweeps, 0);
  EXPECT_EQ(governed(falling(best_isa(), 1, 0), 0.03, 100).few_sweeps, 0) << "nothing bounces";
}

TEST(Governor, ALimitThatNoSubstepReachesChangesNothing) {
  std::vector<std::uint64_t> hashes;
  for (const int sweeps : {0, 15, 1}) {
    auto world = colliding(best_isa(), 1);
    StepDetail detail;
    detail.sweeps = static_cast<std::uint8_t>(sweeps);
    for (int k = 0; k < 30; ++k) world->replay(detail);
    hashes.push_back(world->state_hash());
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_NE(hashes[2], hashes[0]);
  StepDetail detail;
  detail.sweeps = 16;
  auto world = colliding(best_isa(), 1);
  world->replay(detail);
  EXPECT_EQ(world->frame(), 0u) << "no governor chooses it";
}

// Water that falls two metres and strikes a wall moves in two parts where there is time for them.
std::unique_ptr<World> falling_water(Isa isa = best_isa(), int threads = 1) {
  auto world = make(walled({0, 0, 4, 6}), isa, threads);
  add(*world, disc({3, 1}, {}, 0.2));
  std::string error;
  const FluidId water = world->add_fluid({.spacing = 0.05}, error);
  std::vector<Vec2> places;
  for (int k = 0; k < 1600; ++k) places.push_back({0.05 * (k % 40 + 0.5), 3 + 0.05 * (k / 40 + 0.5)});
  EXPECT_TRUE(world->add_particles(water, places, std::vector<Vec2>(places.size(), {0, -25}), error)) << error;
  return world;
}

TEST(Governor, FluidsMoveInFewerPartsWhereThereIsNoTime) {
  const auto run = [](double budget_ms, std::vector<StepDetail>* details) {
    auto world = falling_water();
    EXPECT_EQ(world->set_governor({budget_ms > 0, budget_ms, {}}), budget_ms > 0);
    for (int k = 0; k < 60; ++k) {
      const StepReport report = world->step();
      EXPECT_EQ(report.predicted_ms > 0.05, budget_ms > 0) << k;
      EXPECT_FALSE(report.detail.waits()) << "bodies have half of the time";
      if (details != nullptr) details->push_back(report.detail);
    }
    return world->state_hash();
  };
  std::vector<StepDetail> cut, whole;
  const std::uint64_t in_full = run(0, nullptr), with_time = run(100, &whole), without = run(0.1, &cut);
  EXPECT_EQ(with_time, in_full);
  EXPECT_NE(without, in_full);
  const auto few = [](const StepDetail& d) { return d.fluid_parts == 1; };
  EXPECT_TRUE(std::none_of(whole.begin(), whole.end(), [](const StepDetail& d) { return d.fluid_parts != 0; }));
  EXPECT_GT(std::count_if(cut.begin(), cut.end(), few), 3);
  for (const Isa isa : available_isas()) {
    auto again = falling_water(isa, 2);
    for (const StepDetail& detail : cut) again->replay(detail);
    EXPECT_EQ(again->state_hash(), without) << isa_name(isa);
  }
}

// What a governor chooses hangs on nothing that a saved state leaves out.
TEST(Governor, WhatItChoosesForFluidsIsSaved) {
  auto world = falling_water();
  const GovernorDesc poor{true, 0.1, {}};
  EXPECT_TRUE(world->set_governor(poor));
  for (int k = 0; k < 10; ++k) world->step();
  std::vector<std::byte> saved;
  world->save(saved);
  std::string error;
  const auto other = World::from_state(saved, {}, error);
  ASSERT_NE(other, nullptr) << error;
  EXPECT_TRUE(other->set_governor(poor));
  for (int k = 0; k < 20; ++k) {
    const StepReport a = world->step(), b = other->step();
    EXPECT_EQ(a.detail, b.detail) << k;
    EXPECT_EQ(a.predicted_ms, b.predicted_ms) << k;
  }
  EXPECT_EQ(world->state_hash(), other->state_hash());
}

TEST(Governor, MorePartsThanAGovernorChoosesAreRefused) {
  auto world = falling_water();
  StepDetail detail;
  detail.fluid_parts = 4;
  world->replay(detail);
  EXPECT_EQ(world->frame(), 0u);
}

TEST(Governor, ACutPileOfBoxesReplays) {
  const auto boxes = [](Isa isa, int threads) {
    auto world = make(walled({0, 0, 40, 80}, {0, -kG}, material(0, 0.5)), isa, threads);
    for (int k = 0; k < 240; ++k) {
      BodyDesc d;
      d.shape = BoxShape{1, 1, 0};
      d.position = {1 + 1.3 * (k % 28), 1 + 1.4 * (k / 28)};
      d.angle = 0.1 * k;
      d.material = material(0, 0.5);
      add(*world, d);
    }
    return world;
  };
  const Cut cut = governed(boxes(best_isa(), 1), 0.06, 150);
  EXPECT_GT(cut.waits, 10);
  expect_replays(cut, boxes);
}

TEST(Governor, TimeStandsStillAndIsMadeUpFor) {
  const Cut cut = governed(falling(best_isa(), 1, 0), 0.19, 300);
  EXPECT_GT(cut.waits, 10);
  EXPECT_GT(cut.made_up, cut.elapsed * 9 / 10);
  EXPECT_LE(cut.made_up, cut.elapsed);
  auto world = falling(best_isa(), 1, 0);
  for (const StepDetail& detail : cut.details) {
    const double before = state(*world, world->id_of(0)).y;
    world->replay(detail);
    if (detail.waits()) {
      EXPECT_EQ(state(*world, world->id_of(0)).y, before);
    } else {
      EXPECT_GE(detail.substeps, detail.frames) << "no substep is longer than a frame";
    }
  }
  EXPECT_TRUE(all_finite(*world));
}

// Where not even a substep a frame fits, the world goes slower instead of wilder.
TEST(Governor, WhatSubstepsCannotMakeUpForIsLost) {
  const Cut cut = governed(falling(best_isa(), 1, 0), 0.03, 200);
  EXPECT_LT(cut.made_up, cut.elapsed / 2);
  EXPECT_GT(cut.made_up, 0);
}

TEST(Governor, BodiesMayComeAndGoWhileTimeStandsStill) {
  auto world = falling(best_isa(), 1, 0);
  govern(*world, 0.1);
  int changes = 0;
  for (int k = 0; k < 200; ++k) {
    if (world->step().detail.waits() && k % 3 == 0) {
      add(*world, disc({5 + 0.25 * (k % 200), 150}));
      world->remove_body(world->id_of(static_cast<std::uint32_t>(k)));
      ++changes;
    }
  }
  EXPECT_GT(changes, 5);
  EXPECT_TRUE(all_finite(*world));
  EXPECT_EQ(world->body_count(), 1500u);
}

// A host that adds a body in every frame makes every step begin again; the world goes on all the same.
TEST(Governor, AHostThatChangesBodiesInEveryFrameStopsNothing) {
  auto world = falling(best_isa(), 1, 0);
  govern(*world, 0.1);
  int solved = 0;
  for (int k = 0; k < 100; ++k) {
    solved += world->step().detail.solves;
    add(*world, disc({5 + 0.25 * k, 150}));
  }
  EXPECT_GT(solved, 20);
}

std::unique_ptr<World> discs_and_large_ones(Isa isa, int threads, std::size_t large = 320) {
  auto world = make(walled({0, 0, 120, 200}, {0, -kG}), isa, threads);
  add(*world, lattice(6000, {0, 0, 120, 40}, 0.15, 1, {}));
  add(*world, lattice(large, {0, 45, 120, 190}, 2, 1, {}));
  return world;
}

// Frames with one piece of a step's work each, until its lists are made.
int pieces_of_lists(World& world) {
  StepDetail one;
  one.solves = false;
  one.pieces = 1;
  for (int k = 1; k < 1000; ++k) {
    if (world.replay(one).rebuilt) return k;
  }
  return 0;
}

// Where many are large, their search is the longest part of it all.
TEST(Governor, LargeBodiesAreSearchedForInPieces) {
  const auto never_cut = discs_and_large_ones(best_isa(), 1);
  for (int k = 0; k < 3; ++k) never_cut->step();
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      const auto cut = discs_and_large_ones(isa, threads);
      const int pieces = pieces_of_lists(*cut), of_few = pieces_of_lists(*discs_and_large_ones(isa, threads, 16));
      EXPECT_GE(pieces, of_few + 320 / 16 / 2) << "large bodies are searched for all at once";
      for (int k = 0; k < 3; ++k) cut->step();
      EXPECT_EQ(cut->state_hash(), never_cut->state_hash()) << isa_name(isa) << " " << threads;
    }
  }
}

// What is near fixed shapes, too.
TEST(Governor, FixedShapesAreLookedForAFewBodiesAtATime) {
  const auto world = [](bool shapes) {
    auto w = make(walled({0, 0, 60, 200}, {0, -kG}), best_isa(), 1);
    add(*w, lattice(1000, {0, 0, 60, 60}, 0.6, 1, {}));
    if (!shapes) return w;
    BodyDesc floor;
    floor.type = BodyType::static_body;
    floor.shape = BoxShape{10, 1, 0};
    floor.position = {30, 30.5};
    add(*w, floor);
    return w;
  };
  EXPECT_GE(pieces_of_lists(*world(true)), pieces_of_lists(*world(false)) + 1000 / 32 / 2);
}

TEST(Governor, RoomIsMadeBeforeTheFirstFrame) {
  for (const int which : {0, 1, 2}) {
    const auto world = which == 2 ? discs_and_large_ones(best_isa(), 1) : falling(best_isa(), 1, 0.5 * which);
    govern(*world, 0.15);
    world->prepare();
    std::uint64_t growths = 0;
    for (int k = 0; k < 40; ++k) growths += world->step().arena_growths;
    EXPECT_EQ(growths, 0u) << which;
  }
}

}  // namespace
}  // namespace psim::test
