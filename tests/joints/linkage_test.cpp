// Joints with springs, ends and motors at once and those of more than two bodies, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "joint_support.h"

namespace psim::test {
namespace {

class Linkages : public testing::TestWithParam<int> {
 protected:
  static JointScene scene(Vec2 gravity = {0, -kG}) { return free_scene(GetParam(), gravity); }
};
INSTANTIATE_TEST_SUITE_P(Substeps, Linkages, testing::Values(1, 4, 8));

double inertia_of_disc(double mass, double radius) { return mass * radius * radius / 2; }

// ---- springs, ends and motors along one row

TEST_P(Linkages, RodWithSpringAndEndsSwingsBetweenThem) {
  Random random(3);
  for (int round = 0; round < 8; ++round) {
    JointScene s = scene();
    const double mass = std::pow(10, random.uniform(-1, 1)), rate = random.uniform(4, 12),
                 stiffness = mass * rate * rate;
    const BodyId bob = ghost(s, {3, 1}, mass);
    JointDesc d = between(JointType::distance, kWorldBody, bob, {3, 3});
    d.length = 2;
    d.stiffness = stiffness;
    d.lower = 0.5, d.upper = 5;
    s.join(d);
    const double deep = 3 - 2 - kG / (rate * rate), swing = 1 - deep;
    std::vector<double> y;
    for (int frame = 0; frame < 600; ++frame) {
      s.run(1);
      y.push_back(s.at(bob).y - deep);
    }
    EXPECT_NEAR(*std::ranges::max_element(y.end() - 200, y.end()), swing, 0.02 * swing);
    std::vector<double> up;
    for (std::size_t k = 1; k < y.size(); ++k) {
      if (y[k - 1] < 0 && y[k] >= 0) up.push_back((static_cast<double>(k) - y[k] / (y[k] - y[k - 1])) / 60);
    }
    ASSERT_GE(up.size(), 2u);
    const double period = (up.back() - up.front()) / static_cast<double>(up.size() - 1);
    EXPECT_NEAR(period * rate / (2 * kPi), 1, 2e-3) << "mass " << mass << " rate " << rate;
  }
}

TEST_P(Linkages, RodEndsHoldAnything) {
  JointScene s = scene();
  std::vector<BodyId> bobs;
  for (int k = 0; k < 12; ++k) {
    bobs.push_back(ghost(s, {6.0 * k, -2}, 1 + k));
    JointDesc d = between(JointType::distance, kWorldBody, bobs.back(), {6.0 * k, 0});
    d.lower = 1.5, d.upper = 2.5;
    if (k % 2 == 1) d.stiffness = 400;
    s.join(d);
    ASSERT_TRUE(s.world->set_velocity(bobs.back(), {3.0 * (k % 3), k % 4 < 2 ? -30.0 : 25.0}, 0));
  }
  for (int frame = 0; frame < 600; ++frame) {
    s.run(1);
    for (std::size_t k = 0; k < bobs.size(); ++k) {
      const BodyState b = s.at(bobs[k]);
      const double far = std::hypot(b.x - 6.0 * static_cast<double>(k), b.y);
      ASSERT_GT(far, 1.49) << "bob " << k << " in frame " << frame;
      ASSERT_LT(far, 2.52) << "bob " << k << " in frame " << frame;
    }
  }
}

TEST_P(Linkages, WinchPullsAtItsSpeedIfStrongEnough) {
  for (const double limit : {15.0, 60.0}) {  // the weight is 19.62 N
    JointScene s = scene();
    const BodyId load = ghost(s, {0, -8}, 2);
    JointDesc d = between(JointType::distance, kWorldBody, load, {0, 0});
    d.motor_speed = -1, d.motor_limit = limit;
    const JointId id = s.join(d);
    s.run(120);
    EXPECT_NEAR(s.at(load).vy, limit > 20 ? 1 : 2 * (limit / 2 - kG), 2e-3);
    EXPECT_NEAR(s.joint(id).force.y, std::min(limit, 2 * kG), 0.02 * limit);
  }
}

TEST_P(Linkages, SpringOfAPinIsATorsionPendulum) {
  Random random(5);
  for (int round = 0; round < 8; ++round) {
    JointScene s = scene({0, 0});
    const double mass = random.uniform(0.5, 5), radius = random.uniform(0.2, 1), rate = random.uniform(3, 12);
    const double inertia = inertia_of_disc(mass, radius), rest = random.uniform(-1, 1);
    const BodyId wheel = ghost(s, {0, 0}, mass, radius);
    JointDesc d = between(JointType::revolute, kWorldBody, wheel);
    d.stiffness = inertia * rate * rate;
    d.rest = rest;
    s.join(d);
    for (int frame = 1; frame <= 240; ++frame) {
      s.run(1);
      EXPECT_NEAR(s.at(wheel).angle, rest - rest * std::cos(rate * frame / 60), 0.02) << "frame " << frame;
    }
  }
}

TEST_P(Linkages, SpringOfASlideRestsWhereForcesBalance) {
  for (const bool swapped : {false, true}) {
    JointScene s = scene();
    const BodyId block = board(s, {0, 0}, 1, 0.5, 3);
    JointDesc d = between(JointType::prismatic, kWorldBody, block);
    if (swapped) d = between(JointType::prismatic, block, kWorldBody);
    d.axis = {0, swapped ? -1.0 : 1.0};
    d.stiffness = 300, d.damping = 40, d.rest = 0.5;
    s.join(d);
    s.run(600);
    EXPECT_NEAR(s.at(block).y, 0.5 - 3 * kG / 300, 1e-5);
    EXPECT_NEAR(s.at(block).angle, 0, 1e-6);
  }
}

TEST_P(Linkages, FrequencyIsThatOfTheSwing) {
  Random random(11);
  const JointType types[] = {JointType::distance,  JointType::spring, JointType::revolute, JointType::weld,
                             JointType::prismatic, JointType::wheel,  JointType::target};
  for (const JointType type : types) {
    const double f = random.uniform(0.5, 2);
    JointScene s = scene({0, 0});
    const BodyId body = ghost(s, {2, 0}, random.uniform(0.5, 5), random.uniform(0.2, 1));
    JointDesc d = between(type, kWorldBody, body, {0, 0});
    const bool turns = type == JointType::revolute || type == JointType::weld;
    if (turns || type == JointType::prismatic || type == JointType::wheel) d.anchor_a = {2, 0};
    d.target = {2, 0};
    d.frequency = f;
    s.join(d);
    ASSERT_TRUE(s.world->set_velocity(body, turns ? Vec2{} : Vec2{0.3, 0}, turns ? 0.3 : 0));
    double last = 0;
    std::vector<double> up;
    for (int frame = 0; frame < 600; ++frame) {
      s.run(1);
      const double now = turns ? s.at(body).angle : s.at(body).x - 2;
      if (last < 0 && now >= 0) up.push_back((frame - now / (now - last)) / 60);
      last = now;
    }
    ASSERT_GE(up.size(), 2u) << "type " << static_cast<int>(type);
    const double period = (up.back() - up.front()) / static_cast<double>(up.size() - 1);
    EXPECT_NEAR(period * f, 1, 5e-3) << "type " << static_cast<int>(type);
  }
}

TEST_P(Linkages, DampingRatioOneIsTheLeastWithoutASwing) {
  for (const double ratio : {0.9, 1.0, 3.0}) {
    JointScene s = scene({0, 0});
    const BodyId body = ghost(s, {1, 0}, 2);
    JointDesc d = between(JointType::target, kNoBody, body);
    d.frequency = 1, d.damping_ratio = ratio;
    s.join(d);
    double least = 1;
    for (int frame = 0; frame < 300; ++frame) {
      s.run(1);
      least = std::min(least, s.at(body).x);
    }
    EXPECT_EQ(least < -1e-3, ratio < 1) << least;
  }
}

// ---- wheels, motors, targets

TEST_P(Linkages, CarSagsOnItsSpringsAndDrives) {
  JointScene s = scene();
  BodyDesc ground;
  ground.type = BodyType::static_body;
  ground.shape = SegmentShape{{-50, 0}, {50, 0}};
  ground.material.friction = 1;
  s.add(ground);
  const BodyId chassis = board(s, {0, 1.2}, 3, 0.5, 20);
  std::vector<JointId> axles;
  for (const double x : {-1.0, 1.0}) {
    BodyDesc wheel;
    wheel.shape = DiscShape{0.4};
    wheel.position = {x, 0.4};
    wheel.mass = 1;
    wheel.material.friction = 1;
    JointDesc d = between(JointType::wheel, chassis, s.add(wheel), {x, -0.8});
    d.axis = {0, 1};
    d.stiffness = 4000, d.damping = 150;
    d.lower = -0.3, d.upper = 0.3;
    d.motor_speed = -5, d.motor_limit = 40;
    axles.push_back(s.join(d));
  }
  s.run(600);
  const double sag = 20 * kG / (2 * 4000);
  EXPECT_NEAR(s.at(chassis).y, 1.2 - sag, 1e-3);
  EXPECT_NEAR(s.at(chassis).vx, 2, 0.01);
  for (const JointId id : axles) EXPECT_NEAR(s.joint(id).value, sag, 1e-3);
}

TEST_P(Linkages, MotorGivesItsForceAndTorqueUntilItsSpeeds) {
  JointScene s = scene({0, 0});
  const BodyId body = ghost(s, {0, 0}, 4, 0.5);
  JointDesc d = between(JointType::motor, kWorldBody, body);
  d.linear_velocity = {3, 4};
  d.angular_velocity = 2;
  d.force_limit = 10, d.torque_limit = 0.5;
  const JointId id = s.join(d);
  s.run(60);
  const BodyState early = s.at(body);
  EXPECT_NEAR(early.vx, 0.6 * 10 / 4, 1e-4);
  EXPECT_NEAR(early.vy, 0.8 * 10 / 4, 1e-4);
  EXPECT_NEAR(early.omega, 0.5 / inertia_of_disc(4, 0.5), 1e-4);
  EXPECT_NEAR(std::hypot(s.joint(id).force.x, s.joint(id).force.y), 10, 1e-3);
  EXPECT_NEAR(s.joint(id).torque, 0.5, 1e-4);
  s.run(120);
  EXPECT_NEAR(s.at(body).vx, 3, 1e-5);
  EXPECT_NEAR(s.at(body).vy, 4, 1e-5);
  EXPECT_NEAR(s.at(body).omega, 2, 1e-5);
}

TEST_P(Linkages, TargetPullsAtAnyAnchorAndNoHarderThanItMay) {
  Random random(13);
  for (int round = 0; round < 8; ++round) {
    JointScene s = scene();
    const double mass = std::pow(10, random.uniform(-1, 2));
    const Vec2 anchor{random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3)};
    const BodyId body = board(s, {0, 0}, 1, 0.6, mass);
    JointDesc d = between(JointType::target, kNoBody, body, {}, anchor);
    d.target = anchor;
    d.stiffness = mass * 250, d.damping = mass * 20;
    BodyTraits still = *s.world->traits(body);
    still.angular_damping = 3;
    ASSERT_TRUE(s.world->set_traits(body, still));
    const bool weak = round % 2 == 1;
    if (weak) d.force_limit = 0.5 * mass * kG;
    const JointId id = s.join(d);
    s.run(weak ? 60 : 900);
    const JointState j = s.joint(id);
    if (weak) {
      EXPECT_LE(std::hypot(j.force.x, j.force.y), 0.5 * mass * kG * (1 + 1e-5));
      EXPECT_LT(s.at(body).y, -1);
    } else {
      EXPECT_NEAR(j.anchor_b.y, anchor.y - kG / 250, 2e-3);
      EXPECT_NEAR(j.force.y, mass * kG, 0.02 * mass * kG);
    }
  }
}

TEST_P(Linkages, TargetThatMovesTakesTheBodyAlong) {
  JointScene s = scene();
  const BodyId body = ghost(s, {0, 0}, 1);
  JointDesc d = between(JointType::target, kNoBody, body);
  d.frequency = 5, d.damping_ratio = 1;
  const JointId id = s.join(d);
  ASSERT_TRUE(s.world->set_target(id, {3, 2}));
  s.run(120);
  EXPECT_NEAR(s.at(body).x, 3, 1e-3);
  EXPECT_NEAR(s.at(body).y, 2 - kG / std::pow(2 * kPi * 5, 2), 1e-3);
  EXPECT_FALSE(s.world->set_target(id, {std::nan(""), 0}));
  EXPECT_FALSE(s.world->set_target(kNoJoint, {0, 0}));
}

// ---- gears, pulleys, filters

TEST_P(Linkages, GearKeepsItsSumAndSharesTheTorque) {
  Random random(17);
  for (int round = 0; round < 6; ++round) {
    JointScene s = scene({0, 0});
    const double m1 = random.uniform(0.5, 5), m2 = random.uniform(0.5, 5), ratio = random.uniform(0.3, 3);
    const BodyId one = ghost(s, {0, 0}, m1, 0.5), two = ghost(s, {3, 0}, m2, 0.8);
    const JointId a = s.join(between(JointType::revolute, kWorldBody, one, {0, 0}));
    JointDesc pin = between(JointType::revolute, kWorldBody, two, {3, 0});
    const JointId b = s.join(pin);
    JointDesc d;
    d.type = JointType::gear;
    d.joint_a = a, d.joint_b = b;
    d.ratio = round % 2 == 0 ? ratio : -ratio;
    const JointId gear = s.join(d);
    double spun = 0;
    for (int frame = 0; frame < 120; ++frame) {
      ASSERT_TRUE(s.world->apply_angular_impulse(one, 2.0 / 60));
      s.run(1);
      spun = s.at(one).omega;
    }
    const double i1 = inertia_of_disc(m1, 0.5), i2 = inertia_of_disc(m2, 0.8);
    const double speed = 2.0 * 2 / (i1 + i2 / (ratio * ratio));
    EXPECT_NEAR(spun / speed, 1, 2e-3);
    EXPECT_NEAR(s.at(two).omega, -spun / d.ratio, 1e-4 * std::fabs(spun) + 1e-4);
    EXPECT_NEAR(s.joint(gear).value, 0, 1e-2 / GetParam());  // the drift goes with half of the answer to a blow
    // A gear goes with its joints.
    ASSERT_TRUE(s.world->remove_joint(a));
    EXPECT_FALSE(s.world->is_valid_joint(gear));
    EXPECT_EQ(s.world->joint_count(), 1u);
  }
}

TEST_P(Linkages, RackRunsWithItsPinion) {
  JointScene s = scene();
  const BodyId pinion = ghost(s, {0, 0}, 2, 0.5), rack = board(s, {2, 0}, 0.3, 2, 3);
  const JointId turn = s.join(between(JointType::revolute, kWorldBody, pinion));
  JointDesc slide = between(JointType::prismatic, kWorldBody, rack, {2, 0});
  slide.axis = {0, 1};
  JointDesc d;
  d.type = JointType::gear;
  d.joint_a = turn;
  d.joint_b = s.join(slide);
  d.ratio = 2;  // the angle by 2 radians a metre
  s.join(d);
  s.run(60);
  const double a = 3 * kG / (3 + 4 * inertia_of_disc(2, 0.5));
  EXPECT_NEAR(s.at(rack).vy, -a, 2e-3 * a);
  EXPECT_NEAR(s.at(pinion).omega, 2 * a, 4e-3 * a);
  EXPECT_NEAR(s.at(rack).y, -a / 2, 1e-2 * a);
}

TEST_P(Linkages, PulleyIsAnAtwoodMachine) {
  Random random(19);
  for (int round = 0; round < 8; ++round) {
    JointScene s = scene();
    const double m1 = random.uniform(1, 8), m2 = random.uniform(1, 8), r = round < 2 ? 1 : random.uniform(0.5, 2);
    const BodyId one = ghost(s, {0, -12}, m1), two = ghost(s, {4, -12}, m2);
    JointDesc d = between(JointType::pulley, one, two);
    d.ground_a = {0, 0}, d.ground_b = {4, 0};
    d.ratio = r;
    const JointId id = s.join(d);
    EXPECT_NEAR(s.joint(id).value, 12 + 12 * r, 1e-9);
    s.run(60);
    const double a2 = kG * (m2 - r * m1) / (m2 + r * r * m1);  // downwards
    EXPECT_NEAR(s.at(two).vy, -a2, 2e-3 * kG);
    EXPECT_NEAR(s.at(one).vy, r * a2, 2e-3 * kG);
    EXPECT_NEAR(s.joint(id).value, 12 + 12 * r, 1e-4);
    const double tension = m1 * (kG + r * a2);
    EXPECT_NEAR(s.joint(id).force.y, r * tension, 5e-3 * r * tension);
  }
}

TEST(Linkage, PulleyRopeHangsLoose) {
  JointScene s;
  const BodyId one = ghost(s, {0, -3}, 1), two = ghost(s, {4, -3}, 1);
  JointDesc d = between(JointType::pulley, one, two);
  d.ground_a = {0, 0}, d.ground_b = {4, 0};
  s.join(d);
  ASSERT_TRUE(s.world->set_velocity(one, {0, 4}, 0));
  s.run(12);
  EXPECT_NEAR(s.at(one).vy, 4 - kG / 5, 1e-3);  // as if it were free
  EXPECT_NEAR(s.at(two).vy, -kG / 5, 1e-3);
}

TEST(Linkage, FilterKeepsTwoBodiesFromColliding) {
  for (const bool filtered : {false, true}) {
    JointScene s(Vec2{0, 0});
    const BodyId a = s.disc({0, 0}, 0.5), b = s.disc({3, 0}, 0.5);
    if (filtered) s.join(between(JointType::filter, a, b));
    ASSERT_TRUE(s.world->set_velocity(a, {4, 0}, 0));
    s.run(120);
    EXPECT_EQ(s.at(a).vx > 3.9, filtered);
    EXPECT_EQ(s.at(b).vx > 1, !filtered);
  }
}

}  // namespace
}  // namespace psim::test
