// A call that finds no memory changes nothing: whichever of its allocations fails, and wherever the budget of a world
// ends.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "allocation_counter.h"
#include "psim/scene.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

std::unique_ptr<World> late_world(const char* name, std::uint64_t bodies, int steps) {
  std::string error;
  const auto scene = make_builtin(name, bodies, 1, error);
  if (!scene) throw std::runtime_error(error);
  auto world = build_world(*scene, {.threads = 2}, error);
  for (int k = 0; k < steps; ++k) world->step();
  return world;
}

// All numbers of all bodies.
std::vector<double> numbers_of(World& world) {
  const PublishedState s = world.published();
  std::vector<double> all;
  for (const auto& column : {s.x, s.y, s.angle, s.vx, s.vy, s.omega})
    all.insert(all.end(), column.begin(), column.end());
  return all;
}

struct LateScene {
  const char* scene;
  std::uint64_t bodies;
  int steps;  // before the one that fails
};

class NoRoom : public ::testing::TestWithParam<LateScene> {};

TEST_P(NoRoom, AStepThatFindsNoMemoryChangesNothing) {
  const LateScene& late = GetParam();
  const auto first = late_world(late.scene, late.bodies, late.steps);
  std::vector<std::byte> state;
  first->save(state);
  const std::vector<double> before = numbers_of(*first);
  first->step();
  const std::vector<double> after = numbers_of(*first);
  int refused = 0;
  for (std::uint64_t n = 1;; ++n) {
    std::string error;
    const auto world = World::from_state(state, {.threads = 2}, error);
    ASSERT_NE(world, nullptr) << error;
    fail_allocation(allocations() + n);
    const StepReport report = world->step();
    fail_allocation(0);
    if (report.no_room_for == nullptr) break;
    ASSERT_STRNE(report.no_room_for, "motion") << "allocation " << n;
    ++refused;
    ASSERT_EQ(numbers_of(*world), before) << "allocation " << n << ", " << report.no_room_for;
    ASSERT_EQ(world->step().no_room_for, nullptr);
    ASSERT_EQ(numbers_of(*world), after) << "allocation " << n << ", " << report.no_room_for;
  }
  EXPECT_GE(refused, 1);
}

INSTANTIATE_TEST_SUITE_P(Scenes, NoRoom,
                         ::testing::Values(LateScene{"discs", 300, 0}, LateScene{"discs", 300, 40},
                                           LateScene{"rough-pile", 300, 3}, LateScene{"tumbler", 100, 0},
                                           LateScene{"tumbler", 100, 30}, LateScene{"rain", 55, 20},
                                           LateScene{"cloth", 100, 0}, LateScene{"smash", 200, 30},
                                           LateScene{"card_house", 40, 60}, LateScene{"joint_grid", 100, 3},
                                           LateScene{"bridge", 20, 0}, LateScene{"orbits", 100, 3},
                                           LateScene{"gas-periodic", 200, 10}, LateScene{"washer", 50, 20}));

// Plays `steps` steps from a state for each allocation in them, which fails alone or with all that follow in its step.
// Each step must be done or say what it did without; `look` is shown the world at the end. Returns how many steps did
// without something.
int play_without_memory(const std::vector<std::byte>& state, int steps, bool alone, const auto& look) {
  int without = 0;
  for (std::uint64_t n = 1;; ++n) {
    std::string error;
    const auto world = World::from_state(state, {.threads = 2}, error);
    EXPECT_NE(world, nullptr) << error;
    bool failed = false;
    const std::uint64_t due = allocations() + n;
    for (int k = 0; k < steps; ++k) {
      if (!failed) fail_allocation(due, !alone);
      const StepReport report = world->step();
      const bool now = allocations() >= due && !failed;
      fail_allocation(0);
      failed = failed || now;
      if (report.no_room_for == nullptr) continue;
      ++without;
      EXPECT_STRNE(report.no_room_for, "motion") << "allocation " << n << " in step " << k;
      if (std::string_view(report.no_room_for) == "motion") return without;
    }
    if (!failed) return without;
    look(*world);
  }
}

// Bodies fall asleep, first and beside others that sleep, and wake: a step without memory for it is done all the same.
TEST(NoRoomToSleep, BodiesStayAwakeForAWhile) {
  for (const auto& [scene, bodies] : {std::pair{"rough-pile", 60}, {"arch", 0}, {"bridge", 10}, {"pyramid", 0}}) {
    const auto first = late_world(scene, static_cast<std::uint64_t>(bodies), 0);
    std::vector<std::vector<std::byte>> last(12);
    std::uint64_t asleep = 0;
    int states = 0;
    for (int k = 0; k < 1500 && states < 2; ++k) {
      first->save(last[static_cast<std::size_t>(k) % last.size()]);
      const std::uint64_t now = first->step().asleep;
      if (now <= asleep) continue;
      asleep = now;
      ++states;
      for (const bool alone : {true, false}) {
        const auto oldest = last[static_cast<std::size_t>(k + 1) % last.size()];
        if (oldest.empty()) continue;
        play_without_memory(oldest, 24, alone, [&](World& world) {
          EXPECT_EQ(world.body_count(), first->body_count());
          for (const double number : numbers_of(world)) ASSERT_TRUE(std::isfinite(number));
        });
      }
    }
    EXPECT_GE(states, 1) << scene;
  }
}

TEST(NoRoomToLeave, BodiesLeaveAnOpenWorldLater) {
  WorldDesc desc;
  desc.bounds = {-10, -10, 10, 10};
  desc.boundary = Boundary::open;
  desc.gravity = {};
  const auto first = make(desc);
  BodyDesc body = box({0, 0});
  for (int k = 0; k < 12; ++k) {
    if (k % 2 == 0) body = disc({0, 0});
    body.position = {9, -9 + 1.5 * k};
    body.velocity = {20 + 3.0 * k, 0};
    add(*first, body);
  }
  const BodyId stays = add(*first, box({0, 0}));
  first->step();
  std::vector<std::byte> state;
  first->save(state);
  int without = 0;
  for (const bool alone : {true, false}) {
    without += play_without_memory(state, 12, alone, [&](World& world) {
      EXPECT_EQ(world.body_count(), 1u);
      EXPECT_EQ(world.escaped_total(), 12u);
      EXPECT_TRUE(world.is_valid(stays));
    });
  }
  EXPECT_GE(without, 1);
}

// The first step of 2,000 discs, under budgets from what the world has to what the step needs.
TEST(MemoryBudget, EndsAStepThatNeedsMore) {
  const auto whole = late_world("pile", 2000, 0);
  whole->step();
  const std::vector<double> after = numbers_of(*whole);
  int refused = 0;
  for (const double share : std::array{0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.2}) {
    const auto world = late_world("pile", 2000, 0);
    const std::vector<double> before = numbers_of(*world);
    const std::size_t has = world->memory_bytes(), needs = whole->memory_bytes();
    world->set_max_bytes(has + static_cast<std::size_t>(share * static_cast<double>(needs - has)));
    const StepReport report = world->step();
    refused += report.no_room_for != nullptr ? 1 : 0;
    EXPECT_EQ(numbers_of(*world), report.no_room_for != nullptr ? before : after) << share;
    EXPECT_TRUE(report.no_room_for == nullptr || std::string_view(report.no_room_for) != "motion") << share;
    world->set_max_bytes(0);
    if (report.no_room_for != nullptr) world->step();
    EXPECT_EQ(numbers_of(*world), after) << share;
  }
  EXPECT_GE(refused, 3);
  EXPECT_LE(refused, 6);
}

// 60,000 discs in one heap have 1.8 billion pairs; lists hold 2^28.
TEST(NoRoomForPairs, EndsAStepThatNeedsMoreThanListsHold) {
  std::string error;
  const auto world = World::create({}, {}, error);
  ASSERT_NE(world, nullptr) << error;
  const std::vector<double> x(60'000), r{0.5};
  DiscBatch batch;
  batch.x = batch.y = x;
  batch.radius = r;
  std::uint32_t first = 0;
  ASSERT_EQ(world->add_discs(batch, first, error), x.size()) << error;
  const StepReport report = world->step();
  ASSERT_NE(report.no_room_for, nullptr);
  EXPECT_STREQ(report.no_room_for, "pairs");
  EXPECT_LT(world->memory_bytes(), 50'000'000u);
  EXPECT_EQ(world->body_count(), x.size());
}

TEST(MemoryBudget, RefusesBodies) {
  std::string error;
  WorldDesc desc;
  desc.max_bytes = 1'000'000;
  const auto world = World::create(desc, {}, error);
  ASSERT_NE(world, nullptr) << error;
  const std::vector<double> x(100'000), r{0.5};
  DiscBatch batch;
  batch.x = batch.y = x;
  batch.radius = r;
  std::uint32_t first = 0;
  EXPECT_EQ(world->add_discs(batch, first, error), 0u);
  EXPECT_EQ(error.rfind("no room for 100000 bodies: the world holds ", 0), 0u) << error;
  EXPECT_EQ(world->body_count(), 0u);
  std::size_t added = 0;
  BodyDesc body;
  while (world->add_body(body, error) != kNoBody) body.position.x = 0.001 * static_cast<double>(++added);
  EXPECT_EQ(error.rfind("no room for a body: the world holds ", 0), 0u) << error;
  EXPECT_EQ(world->body_count(), added);
  EXPECT_GT(added, 2000u);
  EXPECT_LE(world->memory_bytes(), 1'200'000u);
}

}  // namespace
}  // namespace psim::test
