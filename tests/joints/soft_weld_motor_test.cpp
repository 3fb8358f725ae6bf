// Welds with a spring between their anchors, and motors that have a place to come to.
#include <cmath>
#include <string>
#include <vector>

#include "rigid_support.h"

namespace psim::test {
namespace {

JointDesc tie(JointType type, BodyId a, BodyId b) {
  JointDesc d;
  d.type = type;
  d.a = a;
  d.b = b;
  return d;
}

JointId join(World& world, const JointDesc& desc) {
  std::string error;
  const JointId id = world.add_joint(desc, error);
  EXPECT_NE(id, kNoJoint) << error;
  return id;
}

WorldDesc space(Vec2 gravity = {0, 0}, int substeps = 4) {
  WorldDesc desc = unbounded(200, gravity);
  desc.sleeping = false;
  desc.substeps = substeps;
  return desc;
}

// It sags by m g / k along gravity, whatever its direction, and swings with w^2 = k / m; the angle is kept.
TEST(SoftWeld, SagsAndSwings) {
  for (const Vec2 gravity : {Vec2{0, -kG}, Vec2{kG, 0}, Vec2{3, -4}}) {
    for (const int substeps : {1, 4, 8}) {
      auto world = make(space(gravity, substeps));
      const BodyId id = add(*world, box({1, 2}, 1, 1));  // 1 kg
      JointDesc d = tie(JointType::weld, kWorldBody, id);
      d.anchor_a = {1, 2};
      d.linear_stiffness = 100;
      join(*world, d);
      const double g = std::hypot(gravity.x, gravity.y), sag = g / 100, w = 10;
      double most = 0;
      for (int k = 1; k <= 300; ++k) {
        world->step();
        const BodyState s = state(*world, id);
        const double along = ((s.x - 1) * gravity.x + (s.y - 2) * gravity.y) / g;
        const double expected = sag * (1 - std::cos(w * k / 60));
        if (substeps > 1) most = std::max(most, std::fabs(along - expected));
        ASSERT_NEAR(s.angle, 0, 1e-4);
        ASSERT_NEAR((s.x - 1) * gravity.y - (s.y - 2) * gravity.x, 0, 1e-4);
      }
      EXPECT_LT(most, 0.2 * sag) << substeps;  // the phase drifts a little
      JointDesc damped = d;
      damped.linear_damping = 20;
      ASSERT_TRUE(world->remove_joint({0, 0}));
      join(*world, damped);
      run(*world, 600);
      EXPECT_NEAR(((state(*world, id).x - 1) * gravity.x + (state(*world, id).y - 2) * gravity.y) / g, sag, 1e-3 * sag);
    }
  }
}

// An arm welded at its end: the angle gives way by m g l / k where it is soft, else it is kept.
TEST(SoftWeld, ItsAngleIsRigidOrSoft) {
  for (const double stiffness : {0.0, 400.0}) {
    auto world = make(space({0, -kG}, 8));
    BodyDesc arm = box({1, 0}, 2, 0.2);
    arm.mass = 2;
    const BodyId id = add(*world, arm);
    JointDesc d = tie(JointType::weld, kWorldBody, id);
    d.anchor_b = {-1, 0};
    d.linear_stiffness = 2000;
    d.linear_damping = 100;
    d.stiffness = stiffness;
    d.damping = stiffness > 0 ? 30 : 0;
    join(*world, d);
    run(*world, 900);
    const BodyState s = state(*world, id);
    const double turn = stiffness > 0 ? -2 * kG / stiffness : 0;  // of cos(turn), near 1
    EXPECT_NEAR(s.angle, turn, 2e-3);
    EXPECT_NEAR(s.y - std::sin(s.angle), -2 * kG / 2000, 1e-3);
    EXPECT_NEAR(s.omega, 0, 1e-3);
  }
}

TEST(SoftWeld, KeepsMomentaAndComesAndGoes) {
  auto world = make(space());
  BodyDesc left = box({0, 0}), right = box({1.5, 0.2});
  left.velocity = {2, 1};
  right.velocity = {-1, 0.5};
  right.mass = 3;
  left.angular_velocity = 1;
  const BodyId a = add(*world, left), b = add(*world, right);
  JointDesc d = tie(JointType::weld, a, b);
  d.anchor_a = {0.75, 0};
  d.anchor_b = {-0.75, -0.2};
  d.linear_stiffness = 500;
  d.stiffness = 50;
  const JointId id = join(*world, d);
  const auto momenta = [&] {
    const Diagnostics now = world->diagnostics();
    return std::vector<double>{now.momentum_x, now.momentum_y, now.angular_momentum};
  };
  const std::vector<double> before = momenta();
  run(*world, 300);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(momenta()[k], before[k], 2e-3) << k;
  std::string error;
  d.linear_stiffness = 0;  // rigid from now on
  ASSERT_TRUE(world->set_joint(id, d, error)) << error;
  EXPECT_EQ(world->joint_desc(id)->linear_stiffness, 0);
  run(*world, 300);
  const auto joint = world->joint(id);
  EXPECT_NEAR(joint->anchor_a.x, joint->anchor_b.x, 2e-3);
  EXPECT_NEAR(joint->anchor_a.y, joint->anchor_b.y, 2e-3);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(momenta()[k], before[k], 4e-3) << k;
  d.linear_stiffness = 500;
  ASSERT_TRUE(world->set_joint(id, d, error)) << error;
  run(*world, 60);
  EXPECT_GT(std::hypot(world->joint(id)->force.x, world->joint(id)->force.y), 0);
}

// Each step makes up the share that it is told, at one speed but for its first substep, which goes by the mean of the
// speeds before and after.
TEST(Motor, GoesToItsPlace) {
  for (const double share : {1.0, 0.3, 0.05}) {
    for (const int substeps : {1, 4}) {
      auto world = make(space({0, 0}, substeps));
      const BodyId id = add(*world, box({5, 1}));
      JointDesc d = tie(JointType::motor, kWorldBody, id);
      d.anchor_a = {2, 1};
      d.offset = {1, 2};
      d.reference = 0.5;
      d.correction = share;
      d.force_limit = d.torque_limit = 1e9;
      join(*world, d);
      double left = 1, speed = 0;  // of the way, and of it in a step
      for (int k = 0; k < 40; ++k) {
        world->step();
        const double next = -share * left;
        left += next - (next - speed) / (2 * substeps);
        speed = next;
        const BodyState s = state(*world, id);
        ASSERT_NEAR(s.x, 3 + 2 * left, 2e-3) << share << " " << k;
        ASSERT_NEAR(s.y, 3 - 2 * left, 2e-3) << share << " " << k;
        ASSERT_NEAR(s.angle, 0.5 - 0.5 * left, 2e-3) << share << " " << k;
      }
    }
  }
}

// It follows a body that moves and turns, with no more than its limits.
TEST(Motor, FollowsABodyWithinItsLimits) {
  auto world = make(space());
  BodyDesc carrier = kinematic(box({0, 0}));
  carrier.velocity = {1, 0};
  carrier.angular_velocity = 0.5;
  const BodyId a = add(*world, carrier), b = add(*world, box({2, 0}));
  JointDesc d = tie(JointType::motor, a, b);
  d.offset = {2, 0};
  d.reference = 0;
  d.correction = 0.5;
  d.force_limit = d.torque_limit = 1000;
  join(*world, d);
  run(*world, 240);
  const BodyState s = state(*world, b), from = state(*world, a);
  // The place goes round at 1 m/s: the body lags by what that is in dt / share.
  EXPECT_NEAR(s.x, from.x + 2 * std::cos(from.angle), 0.036);
  EXPECT_NEAR(s.y, from.y + 2 * std::sin(from.angle), 0.036);
  EXPECT_NEAR(s.angle, from.angle, 0.02);

  auto weak = make(space());
  const BodyId id = add(*weak, box({0, 0}));  // 1 kg
  JointDesc push = tie(JointType::motor, kWorldBody, id);
  push.offset = {100, 0};
  push.correction = 1;
  push.force_limit = 3;
  join(*weak, push);
  run(*weak, 60);
  EXPECT_NEAR(state(*weak, id).vx, 3, 1e-3);
  EXPECT_NEAR(state(*weak, id).x, 1.5, 0.02);
}

TEST(Motor, BadNumbersAreRefused) {
  auto world = make(space());
  const BodyId id = add(*world, box({0, 0}));
  std::string error;
  for (const double bad : {kNan, -0.1, 1.1}) {
    JointDesc d = tie(JointType::motor, kWorldBody, id);
    d.correction = bad;
    EXPECT_EQ(world->add_joint(d, error), kNoJoint);
    EXPECT_NE(error.find("correction"), std::string::npos) << error;
  }
  JointDesc d = tie(JointType::weld, kWorldBody, id);
  d.linear_stiffness = kInf;
  EXPECT_EQ(world->add_joint(d, error), kNoJoint);
  EXPECT_NE(error.find("linear stiffness"), std::string::npos) << error;
}

}  // namespace
}  // namespace psim::test
