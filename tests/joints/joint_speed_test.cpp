// The speed of a joint is how fast its value grows: against differences of the value from step to step.
#include "joint_support.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// A body of some shape that meets nobody and moves and turns.
BodyId tumbling(JointScene& s, Random& r, Vec2 at, BodyType type = BodyType::dynamic_body) {
  BodyDesc body = body_of_any_shape(r, at);
  body.type = type;
  body.mass = 1;
  body.filter.mask = 0;
  body.velocity = {r.uniform(-2, 2), r.uniform(-2, 2)};
  body.angular_velocity = r.uniform(-2, 2);
  return s.add(body);
}

JointDesc soft(JointType type, BodyId a, BodyId b) {
  JointDesc d;
  d.type = type;
  d.a = a, d.b = b;
  d.anchor_a = {0.3, -0.2}, d.anchor_b = {-0.1, 0.4};
  d.axis = {2, 1};
  d.target = {1, 2};
  d.force_limit = d.torque_limit = 5;
  if (type == JointType::spring || type == JointType::target) d.stiffness = 3;
  if (type == JointType::rope || type == JointType::pulley) d.length = 100;
  if (type == JointType::motor) d.angular_velocity = 1;
  if (type == JointType::pulley) d.ground_a = {-3, 8}, d.ground_b = {6, 9}, d.ratio = 0.5;
  return d;
}

// The point of b where the anchor of a is.
Vec2 same_place(const JointScene& s, const JointDesc& d) {
  const BodyState a = d.a == kWorldBody ? BodyState{} : s.at(d.a), b = s.at(d.b);
  const auto turned = [](double angle, Vec2 v) -> Vec2 {
    return {std::cos(angle) * v.x - std::sin(angle) * v.y, std::sin(angle) * v.x + std::cos(angle) * v.y};
  };
  const Vec2 arm = turned(a.angle, d.anchor_a);
  return turned(-b.angle, {a.x + arm.x - b.x, a.y + arm.y - b.y});
}

// Of each step the mean of the speeds at its ends is the change of the value over its time.
void expect_speed(JointScene& s, JointId id, double dt, double tolerance) {
  double fastest = 0;
  for (int k = 0; k < 40; ++k) {
    const JointState before = s.joint(id);
    s.world->step(dt);
    const JointState after = s.joint(id);
    const double grown = (after.value - before.value) / dt;
    EXPECT_NEAR(grown, (before.speed + after.speed) / 2, tolerance * (1 + std::fabs(grown))) << k;
    fastest = std::max(fastest, std::fabs(after.speed));
  }
  EXPECT_GT(fastest, 0.05);
}

class JointSpeed : public ::testing::TestWithParam<int> {};

TEST_P(JointSpeed, IsHowFastTheValueGrows) {
  const auto type = static_cast<JointType>(GetParam());
  if (type == JointType::filter || type == JointType::gear) return;  // below
  Random r(static_cast<std::uint64_t>(GetParam()) + 20);
  for (int n = 0; n < 6; ++n) {
    JointScene s = free_scene(16, {0, -2});
    const BodyType other = n % 3 == 1 ? BodyType::kinematic_body : BodyType::dynamic_body;
    const BodyId a = tumbling(s, r, {0, 0}, other), b = tumbling(s, r, {2, 1});
    JointDesc d = soft(type, n % 3 == 2 && type != JointType::pulley ? kWorldBody : a, b);
    if (type == JointType::distance) d.lower = 0, d.upper = 50, d.stiffness = 2;  // else it does not change
    const bool pinned = type == JointType::revolute || type == JointType::prismatic || type == JointType::weld ||
                        type == JointType::wheel;
    if (pinned) d.anchor_b = same_place(s, d);  // else the solver would draw them together, which is no speed
    const JointId id = s.join(d);
    s.run(20);
    const bool rigid = type == JointType::weld;
    if (rigid) {
      EXPECT_NEAR(s.joint(id).speed, 0, 1e-3);
      continue;
    }
    expect_speed(s, id, 1e-3, 4e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Types, JointSpeed, ::testing::Range(0, static_cast<int>(JointType::filter) + 1));

TEST(JointSpeeds, OfAGearAddUp) {
  JointScene s = free_scene(16, {0, 0});
  const BodyId a = board(s, {0, 0}, 1, 0.2, 1), b = board(s, {3, 0}, 1, 0.2, 1);
  const auto pin = [&](BodyId body, Vec2 at) {
    JointDesc d;
    d.type = JointType::revolute;
    d.a = kWorldBody, d.b = body, d.anchor_a = at;
    return s.join(d);
  };
  JointDesc gear;
  gear.type = JointType::gear;
  gear.joint_a = pin(a, {0, 0}), gear.joint_b = pin(b, {3, 0}), gear.ratio = 2;
  const JointId id = s.join(gear);
  s.world->set_velocity(a, {}, 3);
  s.run(5);
  EXPECT_GT(std::fabs(s.joint(gear.joint_a).speed), 0.1);
  EXPECT_EQ(s.joint(id).speed, s.joint(gear.joint_a).speed + 2 * s.joint(gear.joint_b).speed);
  EXPECT_NEAR(s.joint(id).speed, 0, 1e-4);
}

TEST(JointSpeeds, AreZeroWhereNothingMoves) {
  JointScene s = free_scene(4, {0, 0});
  const BodyId a = s.peg({0, 0}), b = s.disc({2, 0}, 0.1);
  JointDesc d;
  d.type = JointType::rope, d.a = a, d.b = b, d.length = 9;
  const JointId id = s.join(d);
  EXPECT_EQ(s.joint(id).speed, 0);
  s.world->set_velocity(b, {3, 4}, 0);
  EXPECT_EQ(s.joint(id).speed, 3);
  ASSERT_TRUE(s.world->set_enabled(b, false));
  EXPECT_EQ(s.joint(id).speed, 0) << "a disabled body stands still";
  ASSERT_TRUE(s.world->set_enabled(b, true));
  EXPECT_EQ(s.joint(id).speed, 3);
  ASSERT_TRUE(s.world->set_transform(b, {0, 0}, 0));
  EXPECT_EQ(s.joint(id).speed, 0) << "no length, no direction";
}

}  // namespace
}  // namespace psim::test
