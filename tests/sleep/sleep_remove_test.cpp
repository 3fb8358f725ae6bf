// Bodies that sleep are removed together: what touched them wakes, the others sleep on.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "psim/recording.h"
#include "sleep_support.h"

namespace psim::test {
namespace {

// A heap of discs, boxes and capsules that sleeps, or whatever of it does after a minute.
Placed heap(unsigned seed, int threads = 1) {
  Random random(seed);
  Placed p{make(walled({0, 0, 12, 60}, {0, -kG}, kGrip), best_isa(), threads), {}, {}};
  for (int k = 0; k < 150; ++k) {
    const Vec2 at{1.0 + 1.1 * (k % 10) + random.uniform(-0.1, 0.1), 1.0 + 1.1 * (k / 10)};
    const double angle = random.uniform(0, 3);
    p.put(k % 3 == 0   ? turned(box(at, 0.7, 0.5, kGrip), angle)
          : k % 3 == 1 ? turned(capsule(at, 0.3, 0.2, kGrip), angle)
                       : disc(at, {}, 0.4, kGrip));
  }
  for (int frame = 0; frame < 3600 && p.world->step().awake != 0; ++frame) {
  }
  return p;
}

std::vector<BodyId> some_of(const Placed& p, Random& random, double share) {
  std::vector<BodyId> some;
  for (const BodyId id : p.ids) {
    if (random.chance(share)) some.push_back(id);
  }
  return some;
}

// Whoever touched one of them is awake afterwards.
TEST(SleepRemove, WhatTouchedThemWakes) {
  int others = 0, slept_on = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    Placed p = heap(seed);
    Random random(seed);
    const std::vector<BodyId> gone = some_of(p, random, seed % 4 == 3 ? 0.7 : 0.02 + 0.05 * (seed % 4));
    std::vector<BodyId> touched;
    for (const Contact& c : p.world->contacts()) {
      if (c.b == kNoBody) continue;
      const auto goes = [&](BodyId id) { return std::ranges::find(gone, id) != gone.end(); };
      if (goes(c.a) && !goes(c.b)) touched.push_back(c.b);
      if (goes(c.b) && !goes(c.a)) touched.push_back(c.a);
    }
    const std::size_t before = p.world->body_count();
    EXPECT_EQ(p.world->remove_bodies(gone), gone.size());
    EXPECT_EQ(p.world->body_count(), before - gone.size());
    for (const BodyId id : gone) EXPECT_FALSE(p.world->is_valid(id));
    for (const BodyId id : touched) EXPECT_TRUE(p.world->is_awake(id)) << "seed " << seed << ", body " << id.index;
    others += static_cast<int>(touched.size());
    for (const BodyId id : p.ids) slept_on += p.world->is_valid(id) && !p.world->is_awake(id) ? 1 : 0;
    for (int frame = 0; frame < 60; ++frame) p.world->step();
    for (const Contact& c : p.world->contacts()) {
      EXPECT_TRUE(p.world->is_valid(c.a));
      EXPECT_TRUE(c.b == kNoBody || p.world->is_valid(c.b));
    }
  }
  EXPECT_GT(others, 100);
  EXPECT_GT(slept_on, 100);
}

// The answer does not depend on the number of threads, and a state that is saved before goes on in the same way.
TEST(SleepRemove, TheSameBitsOnAnyNumberOfThreads) {
  for (unsigned seed = 20; seed < 23; ++seed) {
    std::vector<std::uint64_t> hashes;
    for (const int threads : {1, 2, 3}) {
      Placed p = heap(seed, threads);
      std::vector<std::byte> state;
      p.world->save(state);
      Random random(seed);
      const std::vector<BodyId> gone = some_of(p, random, 0.1);
      std::string error;
      const auto other = World::from_state(state, {}, error);
      ASSERT_NE(other, nullptr) << error;
      for (World* world : {p.world.get(), other.get()}) {
        world->remove_bodies(gone);
        for (int frame = 0; frame < 120; ++frame) world->step();
        hashes.push_back(world->state_hash());
      }
    }
    for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]) << "seed " << seed;
  }
}

// The order of the span and names that come twice make no difference, nor do stale ones.
TEST(SleepRemove, InAnyOrder) {
  std::vector<std::uint64_t> hashes;
  for (const int kind : {0, 1, 2}) {
    Placed p = heap(31);
    Random random(31);
    std::vector<BodyId> gone = some_of(p, random, 0.1);
    const std::size_t all = gone.size();
    if (kind == 1) std::ranges::reverse(gone);
    if (kind == 2) {
      gone.insert(gone.end(), gone.begin(), gone.end());
      gone.push_back({5000, 0});
    }
    EXPECT_EQ(p.world->remove_bodies(gone), all);
    for (int frame = 0; frame < 120; ++frame) p.world->step();
    hashes.push_back(p.world->state_hash());
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_EQ(hashes[2], hashes[0]);
}

// Of a stack that goes in part, the rest wakes; of two bodies that a joint ties, the other one.
TEST(SleepRemove, StackedAndJoinedBodiesWake) {
  Placed p = sleeping_stack(6);
  const std::vector<BodyId> gone{p.ids[4], p.ids[5]};
  EXPECT_EQ(p.world->remove_bodies(gone), 2u);
  EXPECT_EQ(awake(*p.world), 4u);

  Placed q = stack(1);
  const BodyId left = q.put(disc({10, 0.5}, {}, 0.5, kGrip)), right = q.put(disc({12, 0.5}, {}, 0.5, kGrip));
  const BodyId far = q.put(disc({30, 0.5}, {}, 0.5, kGrip));
  std::string error;
  JointDesc d;
  d.a = left, d.b = right;
  ASSERT_NE(q.world->add_joint(d, error), kNoJoint) << error;
  wait_for_rest(*q.world);
  const std::vector<BodyId> two{left, far};
  EXPECT_EQ(q.world->remove_bodies(two), 2u);
  EXPECT_TRUE(q.world->is_awake(right));
  EXPECT_FALSE(q.world->is_awake(q.ids[0]));
  EXPECT_EQ(q.world->joint_count(), 0u);
}

// Nobody else wakes, and nothing is left: neither memory nor pieces that others would hit.
TEST(SleepRemove, AllOfAWorld) {
  auto world = make(unbounded(1000, {0, 0}));
  const auto fill = [&](std::vector<BodyId>& ids) {
    for (int k = 0; k < 2000; ++k) ids.push_back(add(*world, disc({k % 50 * 1.5, k / 50 * 1.5})));
    wait_for_rest(*world);
  };
  std::size_t bytes = 0;
  for (int round = 0; round < 6; ++round) {
    std::vector<BodyId> ids;
    fill(ids);
    if (round == 2) bytes = world->memory_bytes();
    EXPECT_LE(world->memory_bytes(), round > 2 ? bytes + bytes / 50 : ~std::size_t{0});
    EXPECT_EQ(world->remove_bodies(ids), ids.size());
    EXPECT_EQ(awake(*world), 0u);
    EXPECT_EQ(world->body_count(), 0u);
    const BodyId ball = add(*world, moving(disc({-2, 7.25}, {}, 0.4), {50, 0}));
    for (int frame = 0; frame < 60; ++frame) world->step();
    EXPECT_NEAR(state(*world, ball).x, 48, 1e-3);
    EXPECT_TRUE(world->remove_body(ball));
  }
}

// The rest of a level falls when the lower half of it goes, and the recording of it replays.
TEST(SleepRemove, ARecordingReplays) {
  Placed p = heap(40);
  Recorder recorder(*p.world, 1);
  const std::vector<BodyId> lower(p.ids.begin(), p.ids.begin() + 50);
  EXPECT_EQ(recorder.remove_bodies(lower), 50u);
  EXPECT_EQ(recorder.remove_bodies(lower), 0u);
  for (int frame = 0; frame < 90; ++frame) recorder.step();
  std::string error;
  const auto replay = Replay::open(recorder.recording(), {}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_TRUE(replay->complete());
}

// Events name the bodies that woke, and none that is gone.
TEST(SleepRemove, EventsTellOfWhoWoke) {
  Placed p = heap(41);
  p.world->set_event_options({.contacts = true, .sleep = true});
  p.world->step();
  const std::vector<BodyId> lower(p.ids.begin(), p.ids.begin() + 20);
  EXPECT_EQ(p.world->remove_bodies(lower), 20u);
  std::vector<BodyId> up;
  for (const BodyId id : p.ids) {
    if (p.world->is_awake(id)) up.push_back(id);
  }
  p.world->step();
  const Events told = p.world->events();
  for (const BodyId id : told.woke) EXPECT_TRUE(p.world->is_valid(id));
  for (const BodyId id : up) EXPECT_NE(std::ranges::find(told.woke, id), told.woke.end()) << id.index;
  EXPECT_FALSE(up.empty());
}

}  // namespace
}  // namespace psim::test
