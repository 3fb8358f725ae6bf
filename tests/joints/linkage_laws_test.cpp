// Linkages that break, that the host changes, and what holds for all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "joint_support.h"

namespace psim::test {
namespace {

class LinkageLaws : public testing::TestWithParam<int> {
 protected:
  static JointScene scene(Vec2 gravity = {0, -kG}) { return free_scene(GetParam(), gravity); }
};
INSTANTIATE_TEST_SUITE_P(Substeps, LinkageLaws, testing::Values(1, 4, 8));

// ---- breaking

TEST_P(LinkageLaws, JointsBreakPastTheirLoadAndTell) {
  const JointType types[] = {JointType::distance,  JointType::spring, JointType::rope,  JointType::revolute,
                             JointType::prismatic, JointType::weld,   JointType::wheel, JointType::target};
  for (const JointType type : types) {
    for (const double share : {0.9, 1.1}) {  // of the load that it bears
      JointScene s = scene();
      const BodyId body = board(s, {0, -1}, 0.5, 0.5, 5);
      const bool line = type == JointType::distance || type == JointType::spring || type == JointType::rope;
      JointDesc d = between(type, kWorldBody, body, line ? Vec2{0, 0} : Vec2{0, -1});
      d.target = {0, -1};
      if (type == JointType::spring || type == JointType::target || type == JointType::wheel) {
        d.stiffness = 5e4, d.damping = 5e3;  // it comes to rest without a swing
      }
      d.axis = {0, 1};
      if (type == JointType::prismatic) d.lower = 0;
      d.break_force = 5 * kG / share;
      d.user_data = 77;
      const JointId id = s.join(d);
      std::vector<JointBreak> told;
      for (int frame = 0; frame < 180; ++frame) {
        s.run(1);
        const auto breaks = s.world->events().breaks;
        told.insert(told.end(), breaks.begin(), breaks.end());
      }
      const std::string what = "type " + std::to_string(static_cast<int>(type)) + " at " + std::to_string(share);
      EXPECT_EQ(s.world->is_valid_joint(id), share < 1) << what;
      ASSERT_EQ(told.size(), share < 1 ? 0u : 1u) << what;
      if (share < 1) continue;
      EXPECT_EQ(told[0].joint, id) << what;
      EXPECT_EQ(told[0].b, body) << what;
      EXPECT_EQ(told[0].user_data, 77u) << what;
      EXPECT_NEAR(told[0].force.y, 5 * kG, 0.1 * 5 * kG) << what;
      EXPECT_LT(s.at(body).y, -5) << what;
    }
  }
}

TEST_P(LinkageLaws, WeldsBreakUnderTorque) {
  for (const double share : {0.97, 1.03}) {
    JointScene s = scene();
    const BodyId arm = board(s, {1, 0}, 2, 0.2, 3);
    JointDesc d = between(JointType::weld, kWorldBody, arm, {0, 0}, {-1, 0});
    d.break_torque = 3 * kG * 1 / share;
    const JointId id = s.join(d);
    s.run(60);
    EXPECT_EQ(s.world->is_valid_joint(id), share < 1);
  }
}

TEST(LinkageChanges, WhatABrokenJointHeldWakesAndFalls) {
  WorldDesc desc;
  desc.gravity = {0, -kG};
  JointScene s(desc);
  const BodyId body = board(s, {0, 0}, 0.5, 0.5, 5);
  const JointId id = s.join(between(JointType::weld, kWorldBody, body));
  s.run(300);
  ASSERT_FALSE(s.world->is_awake(body));
  JointDesc d = *s.world->joint_desc(id);
  d.break_force = 1;
  std::string error;
  ASSERT_TRUE(s.world->set_joint(id, d, error)) << error;
  s.run(60);
  EXPECT_FALSE(s.world->is_valid_joint(id));
  EXPECT_LT(s.at(body).y, -3);
}

// ---- laws

JointDesc any_joint(Random& random, JointType type, BodyId a, BodyId b) {
  JointDesc d = between(type, a, b, {random.uniform(-0.3, 0.3), 0}, {random.uniform(-0.3, 0.3), 0});
  d.stiffness = random.uniform(20, 400);
  if (type == JointType::weld && random.uniform(0, 1) < 0.5) d.stiffness = 0;
  d.axis = {random.uniform(-1, 1), 1};
  d.length = random.uniform(0.5, 2);
  if (type == JointType::distance) d.lower = 0.3, d.upper = 3;
  if (type == JointType::revolute || type == JointType::prismatic || type == JointType::wheel)
    d.lower = -1, d.upper = 1;
  d.linear_velocity = {random.uniform(-1, 1), random.uniform(-1, 1)};
  d.angular_velocity = random.uniform(-2, 2);
  d.force_limit = 20, d.torque_limit = 5;
  return d;
}

// Between free bodies every joint takes from one what it gives to the other.
TEST_P(LinkageLaws, MomentaOfFreeBodiesStay) {
  Random random(23);
  const JointType types[] = {JointType::distance, JointType::revolute, JointType::prismatic,
                             JointType::weld,     JointType::wheel,    JointType::motor};
  for (const JointType type : types) {
    JointScene s = scene({0, 0});
    std::vector<BodyId> bodies;
    for (int k = 0; k < 6; ++k) {
      bodies.push_back(board(s, {1.0 * k, 0.2 * k}, 0.8, 0.4, random.uniform(0.5, 4)));
      ASSERT_TRUE(
          s.world->set_velocity(bodies.back(), {random.uniform(-2, 2), random.uniform(-2, 2)}, random.uniform(-2, 2)));
      if (k > 0) s.join(any_joint(random, type, bodies[static_cast<std::size_t>(k) - 1], bodies.back()));
    }
    const Diagnostics before = s.world->diagnostics();
    s.run(300);
    const Diagnostics after = s.world->diagnostics();
    const std::string what = "type " + std::to_string(static_cast<int>(type));
    EXPECT_NEAR(after.momentum_x, before.momentum_x, 1e-3) << what;  // rounding to floats, some 100,000 times
    EXPECT_NEAR(after.momentum_y, before.momentum_y, 1e-3) << what;
    EXPECT_TRUE(std::isfinite(after.kinetic)) << what;
  }
}

// A point of the world holds like a static body there, bit for bit.
TEST_P(LinkageLaws, TheWorldHoldsLikeAStaticBody) {
  const JointType types[] = {JointType::distance,  JointType::spring, JointType::rope,  JointType::revolute,
                             JointType::prismatic, JointType::weld,   JointType::wheel, JointType::motor};
  for (const JointType type : types) {
    std::vector<std::uint64_t> x;
    for (const bool world : {false, true}) {
      Random random(29);
      JointScene s = scene();
      const BodyId peg = s.peg({3.3, 4.7});
      const BodyId body = board(s, {4, 4}, 0.8, 0.4, 2);
      JointDesc d = any_joint(random, type, world ? kWorldBody : peg, body);
      d.anchor_a = world ? Vec2{3.3, 4.7} : Vec2{};
      s.join(d);
      s.run(120);
      x.push_back(std::bit_cast<std::uint64_t>(s.at(body).x + s.at(body).y));
    }
    EXPECT_EQ(x[0], x[1]) << "type " << static_cast<int>(type);
  }
}

// ---- what the host changes

TEST(LinkageChanges, ChangedIsAsMade) {
  Random random(31);
  const JointType types[] = {JointType::distance, JointType::spring,    JointType::rope,
                             JointType::revolute, JointType::prismatic, JointType::weld,
                             JointType::wheel,    JointType::motor,     JointType::target};
  for (const JointType type : types) {
    for (int round = 0; round < 4; ++round) {
      std::uint64_t hash[2];
      JointDesc first, last;
      for (const bool changed : {false, true}) {
        JointScene s;
        const BodyId a = board(s, {0, 0}, 0.8, 0.4, 2), b = board(s, {1, 0.5}, 0.8, 0.4, 1);
        if (!changed) {
          first = any_joint(random, type, a, b), last = any_joint(random, type, a, b);
          if (round % 2 == 1 && type != JointType::spring && type != JointType::target) first.stiffness = 0;
        }
        const JointId id = s.join(changed ? first : last);
        std::string error;
        EXPECT_TRUE(!changed || s.world->set_joint(id, last, error)) << error;
        s.run(60);
        hash[changed ? 1 : 0] = s.world->state_hash();
      }
      EXPECT_EQ(hash[0], hash[1]) << "type " << static_cast<int>(type) << " round " << round;
    }
  }
}

// One of each, of which some hang together.
std::unique_ptr<World> machines(const RunOptions& options) {
  WorldDesc desc;
  desc.gravity = {0, -kG};
  std::string error;
  JointScene s(desc);
  s.world = World::create(desc, options, error);
  Random random(37);
  JointId turn, slide;
  for (int k = 0; k < 60; ++k) {
    const auto type = static_cast<JointType>(k % 9);
    const BodyId a = board(s, {2.0 * k, 0}, 0.8, 0.4, 2), b = board(s, {2.0 * k + 1, 0.5}, 0.8, 0.4, 1);
    s.join(any_joint(random, type, k % 3 == 0 ? kWorldBody : a, b));
    if (type == JointType::distance) turn = s.join(between(JointType::revolute, kWorldBody, b, {2.0 * k + 1, 0.5}));
    if (type == JointType::spring) slide = s.join(between(JointType::prismatic, a, b));
    if (type == JointType::rope)
      s.join(JointDesc{.type = JointType::gear, .ratio = 2, .joint_a = turn, .joint_b = slide});
    JointDesc pulley = between(JointType::pulley, a, b);
    pulley.ground_a = {2.0 * k, 4}, pulley.ground_b = {2.0 * k + 1, 4};
    if (k % 4 == 0) s.join(pulley);
  }
  return std::move(s.world);
}

TEST(LinkageChanges, SameBitsOnAnyIsaAndThreadsAndAfterASave) {
  const auto world = machines({Isa::scalar, 1});
  for (int k = 0; k < 40; ++k) world->step();
  std::vector<std::byte> state;
  world->save(state);
  std::string error;
  const auto resumed = World::from_state(state, {best_isa(), 3}, error);
  ASSERT_NE(resumed, nullptr) << error;
  const auto other = machines({best_isa(), 3});
  for (int k = 0; k < 40; ++k) other->step();
  for (int k = 0; k < 60; ++k) {
    world->step();
    resumed->step();
    other->step();
    ASSERT_EQ(world->state_hash(), other->state_hash()) << "step " << k;
    ASSERT_EQ(world->state_hash(), resumed->state_hash()) << "step " << k << " after a save";
  }
}

TEST(LinkageChanges, DescriptionsAreReadAsTheyStand) {
  JointScene s;
  const BodyId b = ghost(s, {1, 0}, 2);
  JointDesc d = between(JointType::distance, kWorldBody, b);
  d.frequency = 2, d.damping_ratio = 0.5, d.user_data = 9;
  const JointDesc now = *s.world->joint_desc(s.join(d));
  const double rate = 2 * kPi * 2;
  EXPECT_NEAR(now.stiffness, 2 * rate * rate, 1e-3);
  EXPECT_NEAR(now.damping, 2 * 0.5 * 2 * rate, 1e-4);
  EXPECT_FALSE(now.frequency);
  EXPECT_EQ(now.length, 1.0);
  EXPECT_EQ(now.user_data, 9u);
  EXPECT_EQ(now.a, kWorldBody);
  EXPECT_FALSE(s.world->joint_desc(kNoJoint));
}

TEST(LinkageChanges, RefusesWhatHasNoSense) {
  JointScene s;
  const BodyId a = ghost(s, {0, 0}, 1), b = ghost(s, {2, 0}, 1), peg = s.peg({5, 5});
  const JointId pin = s.join(between(JointType::revolute, kWorldBody, a));
  const JointId rod = s.join(between(JointType::distance, a, b));
  const auto refused = [&](JointDesc d, const char* part) {
    std::string error;
    EXPECT_EQ(s.world->add_joint(d, error), kNoJoint) << part;
    EXPECT_NE(error.find(part), error.npos) << error;
    EXPECT_EQ(error.find('\n'), error.npos);
  };
  JointDesc d = between(JointType::distance, kWorldBody, kWorldBody);
  refused(d, "differ");
  refused(between(JointType::revolute, kWorldBody, peg), "dynamic");
  refused(between(JointType::pulley, kWorldBody, b), "a is not a body");
  refused(between(JointType::filter, a, kWorldBody), "b is not a body");
  refused(between(JointType::target, kNoBody, b), "stiffness");
  refused(between(JointType::spring, a, b), "stiffness");
  d = between(JointType::wheel, a, b);
  d.axis = {0, 0};
  refused(d, "axis");
  d = between(JointType::target, kNoBody, b);
  d.stiffness = 1, d.target = {std::nan(""), 0};
  refused(d, "target");
  d = between(JointType::revolute, a, b);
  d.frequency = 0;
  refused(d, "frequency");
  d.frequency = 2e6;
  refused(d, "frequency");
  d.frequency = {};
  d.break_force = -1;
  refused(d, "break force");
  d = between(JointType::pulley, a, b);
  d.ground_b = {2, 3}, d.ground_a = {0, 3}, d.ratio = 0;
  refused(d, "ratio");
  d = JointDesc{.type = JointType::gear, .joint_a = pin, .joint_b = rod};
  refused(d, "joint b");
  d.joint_b = pin;
  refused(d, "two bodies");
  d = between(JointType::rope, a, b);
  d.frequency = 1;
  refused(d, "frequency");

  std::string error;
  const JointDesc before = *s.world->joint_desc(rod);
  d = before;
  d.type = JointType::rope;
  EXPECT_FALSE(s.world->set_joint(rod, d, error));
  EXPECT_NE(error.find("type"), error.npos);
  d = before;
  d.b = peg;
  EXPECT_FALSE(s.world->set_joint(rod, d, error));
  EXPECT_NE(error.find("bodies"), error.npos);
  EXPECT_FALSE(s.world->set_joint(kNoJoint, before, error));
  EXPECT_TRUE(s.world->set_joint(rod, before, error));
  EXPECT_TRUE(error.empty());
}

}  // namespace
}  // namespace psim::test
