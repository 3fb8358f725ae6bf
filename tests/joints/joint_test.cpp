// Joints: limits, motors, what is joined and what is removed, through the public API.
#include <array>

#include "joint_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

constexpr double kDt = 1.0 / 60;

using Scene = JointScene;

TEST(Joint, RevoluteLimitsHold) {
  for (const bool swapped : {false, true}) {
    Scene s;
    const BodyId peg = s.peg({0, 0}), bob = s.disc({1, 0}, 0.1, 1);
    JointDesc d = swapped ? between(JointType::revolute, bob, peg, {-1, 0}, {})
                          : between(JointType::revolute, peg, bob, {}, {-1, 0});
    d.lower = swapped ? -2.0 : -0.5;
    d.upper = swapped ? 0.5 : 2.0;
    const JointId id = s.join(d);
    double least = 0;
    for (int frame = 0; frame < 300; ++frame) {
      s.world->step();
      least = std::fmin(least, s.at(bob).angle);
    }
    EXPECT_NEAR(s.at(bob).angle, -0.5, 1e-3);
    EXPECT_GT(least, -0.52);
    EXPECT_NEAR(s.joint(id).value, swapped ? 0.5 : -0.5, 1e-3);
    EXPECT_NEAR(s.joint(id).torque, (swapped ? -1 : 1) * kG * std::cos(0.5), 0.05);
  }
}

TEST(Joint, RevoluteMotorTurnsWithItsTorque) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), wheel = s.disc({0, 0}, 0.5, 2);  // inertia 0.25
  JointDesc d = between(JointType::revolute, peg, wheel);
  d.motor_speed = 8;
  d.motor_limit = 0.5;  // 2 rad/s^2
  const JointId id = s.join(d);
  s.run(60);
  EXPECT_NEAR(s.at(wheel).omega, 2, 1e-3);
  EXPECT_NEAR(s.at(wheel).angle, 1, 1e-3);
  EXPECT_NEAR(s.joint(id).torque, 0.5, 1e-3);
  s.run(240);
  EXPECT_NEAR(s.at(wheel).omega, 8, 1e-3);
  EXPECT_TRUE(s.world->set_motor(id, -8, 1e3));
  s.run(2);
  EXPECT_NEAR(s.at(wheel).omega, -8, 1e-3);
  EXPECT_FALSE(s.world->set_motor(id, kNan, 1));
}

TEST(Joint, MotorCanBeAddedToARunningPin) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), wheel = s.disc({0, 0}, 0.5, 2);
  const JointId id = s.join(between(JointType::revolute, peg, wheel));
  s.run(30);
  EXPECT_TRUE(s.world->set_motor(id, 3, 100));
  s.run(30);
  EXPECT_NEAR(s.at(wheel).omega, 3, 1e-3);
}

TEST(Joint, SlideMovesAlongItsAxisAlone) {
  for (const bool swapped : {false, true}) {
    Scene s;
    const BodyId peg = s.peg({0, 0}), block = s.disc({0, 0}, 0.2, 2);
    const double c = std::cos(-kPi / 6), r = std::sin(-kPi / 6);
    JointDesc d = swapped ? between(JointType::prismatic, block, peg) : between(JointType::prismatic, peg, block);
    d.axis = swapped ? Vec2{-c, -r} : Vec2{c, r};
    d.upper = 3;
    const JointId id = s.join(d);
    s.run(60);
    BodyState b = s.at(block);
    EXPECT_NEAR(std::hypot(b.x, b.y), kG / 2 / 2, 1e-3);
    EXPECT_NEAR(b.y / b.x, std::tan(-kPi / 6), 1e-4);
    EXPECT_NEAR(b.angle, 0, 1e-5);
    s.run(60);
    b = s.at(block);
    EXPECT_NEAR(s.joint(id).value, 3, 1e-3);
    EXPECT_NEAR(std::hypot(b.vx, b.vy), 0, 1e-3);
  }
}

TEST(Joint, SlideMotorLiftsIfStrongEnough) {
  for (const double limit : {15.0, 40.0}) {  // the weight is 19.62 N
    Scene s;
    const BodyId peg = s.peg({0, 0}), block = s.disc({0, 0}, 0.2, 2);
    JointDesc d = between(JointType::prismatic, peg, block);
    d.axis = {0, 1};
    d.motor_speed = 1;
    d.motor_limit = limit;
    s.join(d);
    s.run(60);
    if (limit > 20) {
      EXPECT_NEAR(s.at(block).vy, 1, 1e-3);
    } else {
      EXPECT_NEAR(s.at(block).vy, limit / 2 - kG, 1e-2);
    }
  }
}

TEST(Joint, WeldedBodiesTurnAsOne) {
  Scene s(Vec2{0, 0});
  const BodyId p = s.disc({-0.5, 0}, 0.2, 1), q = s.disc({0.5, 0}, 0.2, 1);
  s.join(between(JointType::weld, p, q, {0.5, 0}, {-0.5, 0}));
  ASSERT_TRUE(s.world->set_velocity(p, {0, -1}, 2));
  ASSERT_TRUE(s.world->set_velocity(q, {0, 1}, 2));
  for (int frame = 1; frame <= 300; ++frame) {
    s.world->step();
    const BodyState a = s.at(p), b = s.at(q);
    ASSERT_NEAR(std::hypot(b.x - a.x, b.y - a.y), 1, 1e-4);
    ASSERT_NEAR(b.angle - a.angle, 0, 1e-4);
  }
  EXPECT_NEAR(s.at(q).angle, 10, 0.02);
  EXPECT_NEAR(s.at(q).omega, 2, 2e-3);
}

TEST(Joint, SoftWeldSwingsAtItsFrequency) {
  Scene s(Vec2{0, 0});
  const BodyId peg = s.peg({0, 0}), wheel = s.disc({0, 0}, 0.5, 2);  // inertia 0.25
  JointDesc d = between(JointType::weld, peg, wheel);
  const double w = 2 * kPi;
  d.stiffness = 0.25 * w * w;
  s.join(d);
  ASSERT_TRUE(s.world->set_velocity(wheel, {0, 0}, 0.3 * w));
  for (int frame = 1; frame <= 600; ++frame) {
    s.world->step();
    ASSERT_NEAR(s.at(wheel).angle, 0.3 * std::sin(w * frame * kDt), 2e-3);
  }
}

TEST(Joint, KinematicBodiesCarryOthersAndAreNotMoved) {
  Scene s(Vec2{0, 0});
  BodyDesc k;
  k.type = BodyType::kinematic_body;
  k.shape = DiscShape{0.2};
  k.angular_velocity = 1;
  const BodyId hub = s.add(k), rim = s.disc({1, 0}, 0.1, 5);
  s.join(between(JointType::weld, hub, rim, {1, 0}, {}));
  s.run(120);
  EXPECT_NEAR(s.at(hub).omega, 1, 1e-6);
  EXPECT_NEAR(s.at(hub).x, 0, 1e-9);
  EXPECT_NEAR(s.at(rim).x, std::cos(2.0), 5e-3);
  EXPECT_NEAR(s.at(rim).y, std::sin(2.0), 5e-3);
}

TEST(Joint, JoinedBodiesCollideOnlyIfAsked) {
  for (const bool collide : {false, true}) {
    Scene s(Vec2{0, 0});
    const BodyId p = s.disc({0, 0}, 0.5, 1), q = s.disc({0.8, 0}, 0.5, 1);
    JointDesc d = between(JointType::rope, p, q);
    d.length = 3;
    d.collide = collide;
    const JointId rope = s.join(d);
    s.run(120);
    const double far = s.at(q).x - s.at(p).x;
    if (collide) {
      EXPECT_GT(far, 0.99);
    } else {
      EXPECT_NEAR(far, 0.8, 1e-6);
      EXPECT_TRUE(s.world->remove_joint(rope));
      s.run(120);
      EXPECT_GT(s.at(q).x - s.at(p).x, 0.99);
    }
  }
}

TEST(Joint, RemovalLeavesStaleIds) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), p = s.disc({1, 0}, 0.1), q = s.disc({2, 0}, 0.1);
  const JointId first = s.join(between(JointType::distance, peg, p));
  const JointId second = s.join(between(JointType::distance, p, q));
  const JointId third = s.join(between(JointType::distance, peg, q));
  s.run(5);
  EXPECT_EQ(s.world->joint_count(), 3u);
  EXPECT_TRUE(s.world->remove_joint(first));
  EXPECT_FALSE(s.world->remove_joint(first));
  EXPECT_FALSE(s.world->is_valid_joint(first));
  EXPECT_FALSE(s.world->joint(first).has_value());
  EXPECT_FALSE(s.world->set_motor(first, 1, 1));
  const JointId again = s.join(between(JointType::distance, peg, p));
  EXPECT_EQ(again.index, first.index);
  EXPECT_NE(again, first);
  s.run(5);
  EXPECT_TRUE(s.world->remove_body(p));
  EXPECT_EQ(s.world->joint_count(), 1u);
  EXPECT_FALSE(s.world->is_valid_joint(second));
  EXPECT_TRUE(s.world->is_valid_joint(third));
  s.run(5);
  EXPECT_TRUE(s.world->remove_body(peg));
  EXPECT_EQ(s.world->joint_count(), 0u);
  const double before = s.at(q).vy;
  s.run(60);
  EXPECT_NEAR(s.at(q).vy, before - kG, 1e-3);  // it falls freely
}

TEST(Joint, BadDescriptionsAreRefusedWithOneLine) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), other = s.peg({3, 0}), p = s.disc({1, 0}, 0.1), q = s.disc({2, 0}, 0.1),
               gone = s.disc({4, 0}, 0.1);
  s.world->remove_body(gone);
  BodyDesc k;
  k.type = BodyType::kinematic_body;
  k.position = {5, 5};
  const BodyId held = s.add(k);
  const auto refused = [&](const JointDesc& d) {
    std::string error;
    const bool no = s.world->add_joint(d, error) == kNoJoint;
    return no && !error.empty() && error.find('\n') == std::string::npos;
  };
  const auto wrong = [&](JointType type, const auto& change) {
    JointDesc d = between(type, p, q);
    change(d);
    return refused(d);
  };
  EXPECT_TRUE(refused(between(JointType::distance, p, gone)));
  EXPECT_TRUE(refused(between(JointType::distance, kNoBody, p)));
  EXPECT_TRUE(refused(between(JointType::distance, p, p)));
  EXPECT_TRUE(refused(between(JointType::distance, peg, other)));
  EXPECT_TRUE(refused(between(JointType::distance, peg, held)));
  EXPECT_TRUE(refused(between(JointType::distance, p, q, {1, 0}, {0, 0})));  // length 0
  EXPECT_TRUE(wrong(JointType::distance, [](JointDesc& d) { d.length = 0; }));
  EXPECT_TRUE(wrong(JointType::distance, [](JointDesc& d) { d.length = -1; }));
  EXPECT_TRUE(wrong(JointType::rope, [](JointDesc& d) { d.length = kNan; }));
  EXPECT_TRUE(wrong(JointType::spring, [](JointDesc& d) { d.stiffness = -1; }));
  EXPECT_TRUE(wrong(JointType::spring, [](JointDesc& d) { d.damping = kInf; }));
  EXPECT_TRUE(wrong(JointType::revolute, [](JointDesc& d) { d.lower = 1, d.upper = 0; }));
  EXPECT_TRUE(wrong(JointType::revolute, [](JointDesc& d) { d.anchor_a.x = kNan; }));
  EXPECT_TRUE(wrong(JointType::revolute, [](JointDesc& d) { d.motor_limit = -1; }));
  EXPECT_TRUE(wrong(JointType::revolute, [](JointDesc& d) { d.motor_speed = kInf; }));
  EXPECT_TRUE(wrong(JointType::prismatic, [](JointDesc& d) { d.axis = {0, 0}; }));
  EXPECT_TRUE(wrong(JointType::weld, [](JointDesc& d) { d.reference = kNan; }));
  EXPECT_EQ(s.world->joint_count(), 0u);
}

// All kinds of joints among some hundred bodies, with contacts and a floor.
std::unique_ptr<World> mixed_world(Isa isa, int threads) {
  WorldDesc d = walled({0, 0, 60, 40}, {0, -kG}, material(0, 0.4));
  std::string error;
  std::unique_ptr<World> w = World::create(d, {isa, threads}, error);
  Random random(7);
  std::vector<BodyId> ids;
  for (int i = 0; i < 900; ++i) {
    BodyDesc b;
    b.shape = DiscShape{random.uniform(0.2, 0.45)};
    b.position = {1 + 1.9 * (i % 30), 1 + 1.2 * (i / 30)};
    b.material = material(0, 0.3);
    if (i % 97 == 0) b.type = i % 2 == 0 ? BodyType::static_body : BodyType::kinematic_body;
    if (b.type == BodyType::kinematic_body) b.velocity = {0.2, 0};
    ids.push_back(w->add_body(b, error));
  }
  for (std::size_t i = 0; i + 31 < ids.size(); ++i) {
    JointDesc j;
    j.type = static_cast<JointType>(random.below(6));
    j.a = ids[i];
    j.b = ids[random.chance(0.5) ? i + 1 : i + 30];
    j.stiffness = j.type == JointType::spring ? random.uniform(1, 500) : 0;
    j.damping = random.uniform(0, 2);
    if (random.chance(0.5)) j.lower = -0.3, j.upper = 0.4;
    if (random.chance(0.3)) j.motor_speed = 2, j.motor_limit = 5;
    j.collide = random.chance(0.3);
    if (j.type == JointType::revolute) j.anchor_b = {-0.5, 0.2};
    w->add_joint(j, error);
  }
  return w;
}

TEST(Joint, SameBitsOnEveryIsaAndAnyThreads) {
  constexpr int kFrames = 40;
  std::vector<std::uint64_t> expected;
  for (const Isa isa : available_isas()) {
    for (const int threads : thread_counts()) {
      const std::unique_ptr<World> w = mixed_world(isa, threads);
      EXPECT_GT(w->joint_count(), 800u);
      for (int frame = 0; frame < kFrames; ++frame) {
        w->step();
        if (expected.size() < kFrames) {
          expected.push_back(w->state_hash());
        } else {
          ASSERT_EQ(w->state_hash(), expected[static_cast<std::size_t>(frame)])
              << isa_name(isa) << " " << threads << " frame " << frame;
        }
      }
    }
  }
}

TEST(Joint, AWarmStepAllocatesNothing) {
  const std::unique_ptr<World> w = mixed_world(best_isa(), 2);
  for (int frame = 0; frame < 5; ++frame) w->step();
  EXPECT_EQ(w->step().arena_growths, 0u);
}

}  // namespace
}  // namespace psim::test
