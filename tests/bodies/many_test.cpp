// Calls for many bodies do what those for one do.
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// What is given to many bodies: some of them are static, some are gone.
struct Many {
  std::vector<BodyId> ids;
  std::vector<Vec2> vectors;
  std::vector<double> numbers;
  std::vector<BodyTraits> traits;
};

Many fill(World& world, unsigned seed) {
  Random r(seed);
  Many many;
  for (int k = 0; k < 60; ++k) {
    BodyDesc body = k % 3 == 0 ? box({3.0 * (k % 10), 3.0 * (k / 10)}) : disc({3.0 * (k % 10), 3.0 * (k / 10)});
    if (k % 7 == 0) body = fixed(body);
    many.ids.push_back(add(world, body));
  }
  for (int k = 0; k < 60; ++k) {
    many.vectors.push_back({r.uniform(-20, 20), r.uniform(0, 20)});
    many.numbers.push_back(r.uniform(-2, 2));
    BodyTraits traits = *world.traits(many.ids[static_cast<std::size_t>(k)]);
    traits.friction = r.uniform(0, 1);
    many.traits.push_back(traits);
  }
  for (const std::size_t k : {4u, 44u}) world.remove_body(many.ids[k]);
  return many;
}

// Does one of the calls: for many, or for each; returns how many were changed.
std::size_t call(auto& w, const Many& m, int which, bool at_once) {
  if (at_once) {
    switch (which) {
      case 0:
        return w.set_transforms(m.ids, m.vectors, m.numbers);
      case 1:
        return w.set_velocities(m.ids, m.vectors, m.numbers);
      case 2:
        return w.apply_impulses(m.ids, m.vectors);
      case 3:
        return w.apply_forces(m.ids, m.vectors);
      case 4:
        return w.set_traits_of(m.ids, m.traits);
      case 5:
        return w.set_enabled_of(m.ids, false);
      default:
        return w.set_enabled_of(m.ids, true);
    }
  }
  std::size_t done = 0;
  for (std::size_t k = 0; k < m.ids.size(); ++k) {
    const BodyId id = m.ids[k];
    done += which == 0   ? w.set_transform(id, m.vectors[k], m.numbers[k])
            : which == 1 ? w.set_velocity(id, m.vectors[k], m.numbers[k])
            : which == 2 ? w.apply_impulse(id, m.vectors[k])
            : which == 3 ? w.apply_force(id, m.vectors[k])
            : which == 4 ? w.set_traits(id, m.traits[k])
                         : w.set_enabled(id, which == 6);
  }
  return done;
}

constexpr int kCalls = 7;

TEST(Many, DoesWhatTheCallsForOneDo) {
  auto together = make(unbounded(200)), apart = make(unbounded(200));
  Many a = fill(*together, 3), b = fill(*apart, 3);
  for (int round = 0; round < 3; ++round) {
    for (int which = 0; which < kCalls; ++which) {
      const std::size_t changed = call(*together, a, which, true);
      EXPECT_EQ(changed, call(*apart, b, which, false)) << which;
      EXPECT_GT(changed, 40u) << which;
      EXPECT_LE(changed, 58u) << which;  // two are gone
      together->step();
      apart->step();
      EXPECT_EQ(together->state_hash(), apart->state_hash()) << which;
    }
    for (Vec2& v : a.vectors) v = {0.5 * v.x, 0.5 * v.y};
    b.vectors = a.vectors;
  }
}

TEST(Many, SpansOfOtherLengthsChangeNothing) {
  auto world = make(unbounded(200));
  const Many whole = fill(*world, 4);
  const std::uint64_t before = world->state_hash();
  Many few = whole;
  few.vectors.pop_back();
  few.traits.pop_back();
  for (int which = 0; which < 5; ++which) EXPECT_EQ(call(*world, few, which, true), 0u) << which;
  few = whole;
  few.numbers.push_back(0);
  for (int which = 0; which < 2; ++which) EXPECT_EQ(call(*world, few, which, true), 0u) << which;
  std::vector<BodyState> states(3);
  EXPECT_EQ(world->states_of(whole.ids, states), 0u);
  std::vector<BodyId> room(2);
  std::string error;
  EXPECT_EQ(world->add_bodies(std::vector<BodyDesc>(3), room, error), 0u);
  EXPECT_EQ(error, "there must be as much room for handles as there are descriptions");
  EXPECT_EQ(world->state_hash(), before);
  EXPECT_EQ(call(*world, {}, 1, true), 0u);
}

// A number that is refused concerns its body alone.
TEST(Many, OneThatIsRefusedIsPassedOver) {
  auto world = make(unbounded(200));
  Many many = fill(*world, 5);
  many.vectors[1] = {kNan, 0};
  many.traits[1].friction = -1;
  EXPECT_EQ(call(*world, many, 3, true), 58u - 9 - 1);  // nine are static
  EXPECT_EQ(call(*world, many, 4, true), 58u - 1);
  EXPECT_NE(world->traits(many.ids[1])->friction, -1);
}

TEST(Many, StatesAreThoseOfTheBodies) {
  auto world = make(unbounded(200));
  const Many many = fill(*world, 6);
  call(*world, many, 1, true);
  for (int k = 0; k < 10; ++k) world->step();
  std::vector<BodyState> states(many.ids.size());
  EXPECT_EQ(world->states_of(many.ids, states), 58u);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const auto one = world->body(many.ids[k]);
    EXPECT_EQ(one.has_value(), states[k].id == many.ids[k]) << k;
    if (!one) {
      EXPECT_EQ(states[k].id, kNoBody);
      continue;
    }
    EXPECT_EQ(one->x, states[k].x);
    EXPECT_EQ(one->angle, states[k].angle);
    EXPECT_EQ(one->vy, states[k].vy);
    EXPECT_EQ(one->omega, states[k].omega);
    EXPECT_EQ(one->type, states[k].type);
  }
}

TEST(Many, TheFirstThatIsRefusedEndsAdding) {
  auto world = make(unbounded(200));
  std::vector<BodyDesc> descs;
  for (int k = 0; k < 5; ++k) descs.push_back(disc({2.0 * k, 0}));
  descs[3].shape = DiscShape{-1};
  std::vector<BodyId> ids(5);
  std::string error;
  EXPECT_EQ(world->add_bodies(descs, ids, error), 3u);
  EXPECT_FALSE(error.empty());
  EXPECT_EQ(world->body_count(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(state(*world, ids[k]).x, 2.0 * static_cast<double>(k));
  descs[3].shape = DiscShape{1};
  EXPECT_EQ(world->add_bodies(descs, ids, error), 5u);
  EXPECT_TRUE(error.empty());
}

TEST(Many, ARecordingReplays) {
  auto world = make(unbounded(200));
  Many many = fill(*world, 7);
  Recorder recorder(*world, 1);
  std::vector<BodyId> more(2);
  std::string error;
  EXPECT_EQ(recorder.add_bodies(std::vector<BodyDesc>{disc({-5, 0}), box({-8, 0})}, more, error), 2u);
  for (int which = 0; which < kCalls; ++which) {
    EXPECT_GT(call(recorder, many, which, true), 0u);
    recorder.step();
  }
  recorder.remove_bodies(more);
  recorder.step();
  const auto replay = Replay::open(recorder.recording(), {}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_TRUE(replay->complete());
}

}  // namespace
}  // namespace psim::test
