// What a world tells about itself: the plan with its reasons, times, traces, counts.
#include "support.h"

namespace psim::test {
namespace {

TEST(Plan, GivesAReasonForEveryStage) {
  auto world = pile(20);
  const auto plan = world->plan();
  ASSERT_FALSE(plan.empty());
  for (const PlanEntry& entry : plan) {
    EXPECT_FALSE(entry.stage.empty());
    EXPECT_FALSE(entry.reason.empty()) << entry.stage;
  }
}

bool needs(World& world, std::string_view stage) {
  for (const PlanEntry& entry : world.plan()) {
    if (entry.stage == stage) return entry.needed;
  }
  ADD_FAILURE() << "no stage " << stage << " in the plan";
  return false;
}

TEST(Plan, HasFrictionOnlyWhereSomethingRubs) {
  auto smooth = pile(20);
  EXPECT_FALSE(needs(*smooth, "solver.friction"));
  auto rough = pile(20, material(0, 0.5));
  EXPECT_TRUE(needs(*rough, "solver.friction"));
  // Rough discs that can only touch smooth ones: the mean is zero.
  auto mixed = make(walled({0, 0, 10, 10}));
  add(*mixed, disc({5, 5}, {}, 0.5, material(0, 0)));
  EXPECT_FALSE(needs(*mixed, "solver.friction"));
}

TEST(Plan, FollowsWhatIsAdded) {
  auto world = make(unbounded());
  add(*world, ground(material(0, 0.5)));
  add(*world, disc({0, 1}));
  EXPECT_FALSE(needs(*world, "solver.friction"));
  const BodyId rough = add(*world, disc({5, 0.5}, {3, 0}, 0.5, material(0, 0.5)));
  EXPECT_TRUE(needs(*world, "solver.friction"));
  run(*world, 60);
  EXPECT_LT(state(*world, rough).omega, -1);
}

TEST(StepReports, HoldTimesOfTheStages) {
  auto world = pile(500);
  for (int k = 0; k < 10; ++k) {
    const StepReport report = world->step();
    double sum = 0;
    for (const double ms : report.stage_ms) {
      EXPECT_GE(ms, 0);
      sum += ms;
    }
    EXPECT_GT(report.total_ms, 0);
    EXPECT_LE(sum, report.total_ms * 1.05 + 0.05);
    EXPECT_EQ(report.awake, 500u);
  }
}

TEST(StepReports, CountContactsAndPairs) {
  auto apart = make(unbounded(100, {0, 0}));
  add(*apart, disc({0, 0}));
  add(*apart, disc({50, 0}));
  EXPECT_EQ(apart->step().contacts, 0u);

  auto column = make(unbounded());
  column->set_sleeping(false);
  add(*column, ground());
  for (int k = 0; k < 3; ++k) add(*column, disc({0, 0.5 + k}));
  run(*column, 120);
  const StepReport report = column->step();
  EXPECT_EQ(report.contacts, 3u);
  EXPECT_GE(report.pairs, 3u);
  EXPECT_GE(report.colours, 2u);
}

TEST(StepReports, CountNoContactsOfAnEarlierStep) {
  auto world = make(unbounded());
  const BodyId floor = add(*world, ground());
  add(*world, disc({0, 0.5}));
  run(*world, 20);
  EXPECT_EQ(world->step().contacts, 1u);
  world->remove_body(floor);
  EXPECT_EQ(world->step().contacts, 0u);
}

TEST(StepReports, VirialOfOneImpactIsItsImpulseTimesTheDistance) {
  auto world = make(unbounded(100, {0, 0}));
  BodyDesc a = disc({-2, 0}, {3, 0}, 0.5, material(1)), b = disc({0, 0}, {}, 0.75, material(1));
  a.mass = b.mass = 2;
  add(*world, a);
  add(*world, b);
  double virial = 0;
  for (int k = 0; k < 60; ++k) virial += world->step().virial;
  EXPECT_NEAR(virial, 2 * 3 * 1.25, 1e-3);  // equal masses swap: J = m v
}

TEST(Traces, HoldEveryStageOfEveryStep) {
  auto world = pile(500, {}, best_isa(), 2);
  EXPECT_TRUE(world->take_trace().empty());
  world->start_trace();
  run(*world, 5);
  const auto events = world->take_trace();
  EXPECT_GE(events.size(), 5u);
  std::vector<std::string> names;
  for (const TraceEvent& event : events) {
    EXPECT_GE(event.begin_ns, 0);
    EXPECT_GE(event.end_ns, event.begin_ns);
    EXPECT_GE(event.thread, 0);
    EXPECT_LT(event.thread, 2);
    names.push_back(event.name);
  }
  EXPECT_NE(std::find(names.begin(), names.end(), "solver"), names.end());
}

TEST(Traces, StopAndGoOn) {
  auto world = pile(500, {}, best_isa(), 2);
  const auto of_solver = [&] {
    std::vector<TraceEvent> spans = world->take_trace();
    std::erase_if(spans, [](const TraceEvent& e) { return e.thread != 0 || std::string_view(e.name) != "solver"; });
    return spans;
  };
  world->start_trace();
  run(*world, 3);
  world->stop_trace();
  run(*world, 4);
  const auto before = of_solver();
  EXPECT_EQ(before.size(), 3u);
  run(*world, 2);
  EXPECT_TRUE(world->take_trace().empty());
  world->start_trace();
  run(*world, 2);
  const auto after = of_solver();
  ASSERT_EQ(after.size(), 2u);
  EXPECT_GT(after[0].begin_ns, before.back().end_ns);  // of one clock, from the first start on
}

TEST(Skipped, CountsFramesOfWhatWasLeftOut) {
  auto world = pile(20);
  run(*world, 10);
  bool friction_skipped = false;
  for (const auto& [stage, frames] : world->skipped()) {
    EXPECT_LE(frames, 10u) << stage;
    if (stage == "solver.friction") friction_skipped = frames == 10;
  }
  EXPECT_TRUE(friction_skipped);
}

// Boxes and joints are done in lanes: only what no kernel takes is one at a time.
TEST(Lanes, OfHullsAndJointsCountAsWhatTheyAre) {
  if (best_isa() == Isa::scalar) GTEST_SKIP() << "no lanes";
  auto world = make(unbounded());
  world->set_sleeping(false);
  add(*world, ground());
  for (int k = 0; k < 64; ++k) {
    BodyDesc box = disc({-60 + 1.9 * k, 0.5}, {0, 0});
    box.shape = BoxShape{1, 1};
    add(*world, box);
  }
  world->count_lane_use();
  run(*world, 32);
  const LaneCounts boxes = world->lane_counts();
  EXPECT_GT(boxes.vector, 100 * boxes.scalar);
  bool found = false;
  for (const LaneUse& use : world->lane_use()) {
    EXPECT_LE(use.used, use.lanes) << use.kernels;
    EXPECT_GT(use.used, 0u) << use.kernels;
    found |= use.kernels == "manifolds" && use.used == 2 * 64;
  }
  EXPECT_TRUE(found);

  BodyDesc six = disc({0, 30});  // no kernel takes six vertices
  six.shape = PolygonShape{{{1, 0}, {0.5, 0.9}, {-0.5, 0.9}, {-1, 0}, {-0.5, -0.9}, {0.5, -0.9}}};
  add(*world, six);
  six.position = {0, 31.7};
  add(*world, six);
  run(*world, 20);
  EXPECT_GT(world->lane_counts().scalar, boxes.scalar);
}

TEST(Lanes, AreNotCountedUnlessAskedFor) {
  auto world = pile(200);
  run(*world, 40);
  EXPECT_TRUE(world->lane_use().empty());
}

// A bit a frame, as often as the sums say, also where nobody moves.
TEST(Skipped, OfEveryFrameAddUp) {
  auto world = make(walled({0, 0, 10, 10}));
  const BodyId one = add(*world, disc({5, 0.5}));
  std::array<std::uint64_t, kSkipNames.size()> sums{};
  int asleep = 0;
  for (int frame = 0; frame < 200; ++frame) {
    const bool sleeps = !world->is_awake(one);
    const StepReport report = world->step();
    asleep += sleeps;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      sums[k] += report.skipped >> k & 1;
      if (sleeps) {
        EXPECT_EQ(report.skipped >> k & 1, 1u) << kSkipNames[k];
      }
    }
  }
  EXPECT_GT(asleep, 0);
  EXPECT_FALSE(world->is_awake(one));
  std::array<std::uint64_t, kSkipNames.size()> told{};
  for (const auto& [stage, frames] : world->skipped()) {
    told[static_cast<std::size_t>(std::find(kSkipNames.begin(), kSkipNames.end(), stage) - kSkipNames.begin())] =
        frames;
  }
  EXPECT_EQ(sums, told);
}

TEST(StepReports, CountBodiesThatAreFastForTheirSize) {
  auto world = make(unbounded());
  add(*world, ground());
  BodyDesc box = disc({0, 50}, {0, -200});
  box.shape = BoxShape{1, 1};
  add(*world, box);
  EXPECT_EQ(world->step().fast, 1u);
  run(*world, 300);
  EXPECT_EQ(world->step().fast, 0u);
}

}  // namespace
}  // namespace psim::test
