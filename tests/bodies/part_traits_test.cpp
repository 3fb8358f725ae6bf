// What single parts of a body have, and what changes of it while the world runs.
#include <cmath>
#include <string>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// Two boxes side by side, with their top at y = 0, that move as one.
BodyDesc twin_tables(BodyType type) {
  BodyDesc body;
  body.type = type;
  ShapePart left{BoxShape{8, 1}, {-4, -0.5}}, right{BoxShape{8, 1}, {4, -0.5}};
  left.user_data = 7, right.user_data = 0x123456789ABCDEFu;
  body.shape = CompoundShape{{left, right}};
  body.material.friction = 0.5;
  return body;
}

TEST(PartTraits, AreReadAndChangedOneByOne) {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    auto world = make(unbounded(100, {0, 0}));
    const BodyId id = add(*world, twin_tables(type));
    ASSERT_EQ(world->part_count(id), 2u);
    EXPECT_EQ(world->part_traits(id, 0)->user_data, 7u);
    EXPECT_EQ(world->part_traits(id, 1)->user_data, 0x123456789ABCDEFu);
    EXPECT_FALSE(world->part_traits(id, 2));
    PartTraits to = *world->part_traits(id, 1);
    EXPECT_EQ(to.friction, 0.5);
    to = {.filter = {2, 5, -1},
          .restitution = 0.25,
          .friction = 0,
          .tangent_speed = 3,
          .rolling_resistance = 0.125,
          .one_way = {0, 1},
          .sensor = false,
          .pre_solve = true,
          .user_data = 9};
    ASSERT_TRUE(world->set_part_traits(id, 1, to));
    EXPECT_EQ(*world->part_traits(id, 1), to);
    const PartTraits other = *world->part_traits(id, 0);
    EXPECT_EQ(other.friction, 0.5);
    EXPECT_EQ(other.user_data, 7u);
    EXPECT_EQ(other.filter, Filter{});
    to.sensor = true;
    EXPECT_EQ(world->set_part_traits(id, 1, to), type != BodyType::static_body);
    world->step();

    // Wrong ones change nothing.
    const PartTraits before = *world->part_traits(id, 0);
    for (const double bad : {-1.0, kNan, kInf}) {
      PartTraits wrong = before;
      wrong.friction = bad;
      EXPECT_FALSE(world->set_part_traits(id, 0, wrong));
    }
    EXPECT_FALSE(world->set_part_traits(id, 2, before));
    EXPECT_FALSE(world->set_part_traits({id.index, id.generation + 1}, 0, before));
    EXPECT_EQ(*world->part_traits(id, 0), before);
    EXPECT_EQ(world->part_count({id.index, id.generation + 1}), 0u);
  }
}

// A box slides on, where its part of the table lost its friction.
TEST(PartTraits, CountFromTheNextStepOn) {
  auto world = make(unbounded(100));
  const BodyId table = add(*world, twin_tables(BodyType::static_body));
  BodyDesc body = box({-6, 0.5}, 1, 1, material(0, 0.5));
  body.velocity = {2, 0};
  const BodyId left = add(*world, body);
  body.position = {1, 0.5};
  const BodyId right = add(*world, body);
  PartTraits smooth = *world->part_traits(table, 1);
  smooth.friction = 0;
  ASSERT_TRUE(world->set_part_traits(table, 1, smooth));
  run(*world, 120);
  EXPECT_NEAR(state(*world, left).x, -6 + 4 / (2 * 0.5 * kG), 0.02);
  EXPECT_NEAR(state(*world, right).x, 1 + 4, 0.02);
  // One that sleeps wakes where its part goes.
  run(*world, 200);
  ASSERT_FALSE(world->is_awake(left));
  PartTraits gone = *world->part_traits(table, 0);
  gone.filter.mask = 0;
  ASSERT_TRUE(world->set_part_traits(table, 0, gone));
  run(*world, 60);
  EXPECT_LT(state(*world, left).y, -1);
}

// Changed or made so: the same.
TEST(PartTraits, ChangedIsAsMade) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    auto changed = make(walled({-10, 0, 10, 20})), made = make(walled({-10, 0, 10, 20}));
    for (int k = 0; k < 6; ++k) {
      CompoundShape plain, special;
      for (int p = 0; p < 3; ++p) {
        ShapePart part{BoxShape{0.8, 0.4}, {0.5 * p - 0.5, 0.3 * p}, random.uniform(-1, 1)};
        plain.parts.push_back(part);
        part.friction = static_cast<double>(static_cast<float>(random.uniform(0, 1)));
        part.restitution = static_cast<double>(static_cast<float>(random.uniform(0, 0.5)));
        if (p == 1) part.sensor = true;
        part.filter = Filter{1, 0xFFFFFFFFu, 0};
        special.parts.push_back(part);
      }
      BodyDesc body;
      body.position = {random.uniform(-8, 8), 2.0 + 3 * k};
      body.shape = plain;
      const BodyId id = add(*changed, body);
      body.shape = special;
      add(*made, body);
      for (std::uint32_t p = 0; p < 3; ++p) {
        PartTraits to = *changed->part_traits(id, p);
        to.friction = *special.parts[p].friction, to.restitution = *special.parts[p].restitution;
        to.sensor = special.parts[p].sensor.value_or(false);
        ASSERT_TRUE(changed->set_part_traits(id, p, to));
      }
    }
    run(*changed, 120);
    run(*made, 120);
    EXPECT_EQ(changed->state_hash(), made->state_hash()) << seed;
  }
}

TEST(PartTraits, OfABodyOfOnePart) {
  auto world = make(unbounded(100));
  BodyDesc one = disc({0, 5});
  const BodyId id = add(*world, one);
  EXPECT_EQ(world->part_count(id), 1u);
  PartTraits to = *world->part_traits(id, 0);
  to.user_data = 4;
  ASSERT_TRUE(world->set_part_traits(id, 0, to));
  EXPECT_EQ(world->user_data(id), 4u);
  to.friction = 0.5;
  ASSERT_TRUE(world->set_part_traits(id, 0, to));
  EXPECT_EQ(world->traits(id)->friction, 0.5);
  EXPECT_EQ(world->part_traits(id, 0)->user_data, 4u);
  ShapePart part{BoxShape{1, 1}};
  part.user_data = 11;
  one.shape = CompoundShape{{part}};
  EXPECT_EQ(world->user_data(add(*world, one)), 11u);
}

TEST(PartTraits, StatesAndRecordings) {
  auto world = make(unbounded(100));
  const BodyId table = add(*world, twin_tables(BodyType::static_body));
  add(*world, box({2, 1}));
  std::string error;
  Recorder recorder(*world, 3);
  for (int k = 0; k < 20; ++k) {
    recorder.step();
    if (k != 5) continue;
    PartTraits to = *world->part_traits(table, 1);
    to.tangent_speed = 2, to.friction = 1, to.user_data = 99;
    ASSERT_TRUE(recorder.set_part_traits(table, 1, to));
  }
  const auto replay = Replay::open(recorder.recording(), {}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_TRUE(replay->complete());
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_EQ(replay->world().part_traits(table, 1)->user_data, 99u);
  std::vector<std::byte> state;
  world->save(state);
  const auto copy = World::from_state(state, {}, error);
  ASSERT_NE(copy, nullptr) << error;
  EXPECT_EQ(*copy->part_traits(table, 1), *world->part_traits(table, 1));
}

}  // namespace
}  // namespace psim::test
