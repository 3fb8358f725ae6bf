// Joints that swing and hang, against closed forms and a Runge-Kutta reference, through the public API.
#include <array>

#include "joint_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

constexpr double kMotionDt = 1.0 / 60;

using Scene = JointScene;

TEST(Joint, PendulumKeepsPeriodHeightAndLength) {
  constexpr double kPeriod = 2.3678419476;  // of length 1 from 90 degrees
  for (const bool ends_swapped : {false, true}) {
    Scene s;
    const BodyId peg = s.peg({0, 0}), bob = s.disc({1, 0}, 0.01, 1, true);
    s.join(ends_swapped ? between(JointType::distance, bob, peg) : between(JointType::distance, peg, bob));
    double before = 0, height = -1, stretch = 0, back = 0;
    int turns = 0;
    for (int frame = 1; turns < 10 && frame < 1600; ++frame) {
      s.world->step();
      const BodyState b = s.at(bob);
      stretch = std::fmax(stretch, std::fabs(std::hypot(b.x, b.y) - 1));
      const double swing = b.vy * b.x - b.vx * b.y;
      if (before > 0 && swing <= 0) {
        ++turns;
        back = (frame - 1 + before / (before - swing)) * kMotionDt;
        height = b.y;
      }
      before = swing;
    }
    ASSERT_EQ(turns, 10);
    EXPECT_NEAR(back / (10 * kPeriod), 1, 2e-4);
    EXPECT_GT(height, -0.005);
    EXPECT_LT(height, 0.002);
    EXPECT_LT(stretch, 2e-5);
  }
}

// In fields every substep takes its forces anew; a well too weak to matter makes the scene one.
TEST(Joint, PendulumSwingsTheSameInFields) {
  for (const Integrator integrator : {Integrator::verlet, Integrator::symplectic4}) {
    WorldDesc d;
    d.fields = {WellField{{100, 0}, 1e-9, 1, 2, 0}};
    d.integrator = integrator;
    Scene s(d);
    const BodyId peg = s.peg({0, 0}), bob = s.disc({1, 0}, 0.01, 1, true);
    s.join(between(JointType::distance, peg, bob));
    std::array<double, 2> y{kPi / 2, 0};
    for (int frame = 0; frame < 300; ++frame) {
      s.world->step();
      runge_kutta(y, kMotionDt, 20, [](const std::array<double, 2>& a) {
        return std::array<double, 2>{a[1], -kG * std::sin(a[0])};
      });
    }
    const BodyState b = s.at(bob);
    EXPECT_NEAR(std::atan2(b.x, -b.y), y[0], 5e-3);
  }
}

TEST(Joint, DoublePendulumFollowsRungeKutta) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), p = s.disc({1, 0}, 0.01, 1, true), q = s.disc({2, 0}, 0.01, 1, true);
  s.join(between(JointType::distance, peg, p));
  s.join(between(JointType::distance, p, q));
  std::array<double, 4> y{kPi / 2, kPi / 2, 0, 0};
  const auto slope = [](const std::array<double, 4>& a) {
    const double d = a[0] - a[1], c = std::cos(d), below = 2 - c * c;
    const double f = -2 * kG * std::sin(a[0]) - std::sin(d) * a[3] * a[3];
    const double g = -kG * std::sin(a[1]) + std::sin(d) * a[2] * a[2];
    return std::array<double, 4>{a[2], a[3], (f - c * g) / below, (2 * g - c * f) / below};
  };
  for (int frame = 0; frame < 60; ++frame) {
    s.world->step();
    runge_kutta(y, kMotionDt, 100, slope);
  }
  const BodyState b = s.at(p), c = s.at(q);
  EXPECT_NEAR(std::remainder(std::atan2(b.x, -b.y) - y[0], 2 * kPi), 0, 2e-3);
  EXPECT_NEAR(std::remainder(std::atan2(c.x - b.x, b.y - c.y) - y[1], 2 * kPi), 0, 2e-3);
}

// A disc hung by its rim: the arm turns with the body.
TEST(Joint, PinnedDiscSwingsAsAPhysicalPendulum) {
  Scene s;
  constexpr double kRadius = 0.5;
  const BodyId peg = s.peg({0, 0}), disc = s.disc({kRadius, 0}, kRadius, 2);
  const JointId pin = s.join(between(JointType::revolute, peg, disc, {}, {-kRadius, 0}));
  std::array<double, 2> y{kPi / 2, 0};  // from straight down
  const auto slope = [](const std::array<double, 2>& a) {
    return std::array<double, 2>{a[1], -kG * std::sin(a[0]) / (1.5 * kRadius)};
  };
  double apart = 0, off = 0;
  for (int frame = 0; frame < 600; ++frame) {
    s.world->step();
    runge_kutta(y, kMotionDt, 50, slope);
    const BodyState b = s.at(disc);
    const JointState j = s.joint(pin);
    apart = std::fmax(apart, std::hypot(j.anchor_b.x - j.anchor_a.x, j.anchor_b.y - j.anchor_a.y));
    off = std::fmax(off, std::fabs(b.angle + kPi / 2 - y[0]));
  }
  EXPECT_LT(apart, 1e-4);
  EXPECT_LT(off, 0.02);  // after some 6 swings
}

TEST(Joint, SpringKeepsAmplitudeAndFrequency) {
  Scene s(Vec2{0, 0});
  const double w = 2 * kPi;
  const BodyId peg = s.peg({0, 0}), bob = s.disc({1.1, 0}, 0.01, 2, true);
  JointDesc d = between(JointType::spring, peg, bob);
  d.length = 1;
  d.stiffness = 2 * w * w;
  s.join(d);
  double least = 1, most = 0, early = 0;
  for (int frame = 1; frame <= 60000; ++frame) {  // a period a second
    s.world->step();
    const double x = s.at(bob).x - 1;
    if (frame <= 600) early = std::fmax(early, std::fabs(x - 0.1 * std::cos(w * frame * kMotionDt)));
    if (frame > 59940) {
      most = std::fmax(most, x);
      least = std::fmin(least, x);
    }
  }
  EXPECT_LT(early, 1e-4);
  EXPECT_NEAR(most, 0.1, 5e-4);
  EXPECT_NEAR(least, -0.1, 5e-4);
}

TEST(Joint, SpringBetweenTwoBodiesFallsFreelyAndKeepsMomentum) {
  Scene s;
  const BodyId p = s.disc({0, 0}, 0.05, 1), q = s.disc({1.2, 0}, 0.05, 3);
  JointDesc d = between(JointType::spring, p, q);
  d.length = 1;
  const double w = 2 * kPi * 2, mass = 0.75;
  d.stiffness = mass * w * w;
  s.join(d);
  double off = 0;
  for (int frame = 1; frame <= 120; ++frame) {
    s.world->step();
    const double t = frame * kMotionDt;
    const BodyState a = s.at(p), b = s.at(q);
    off = std::fmax(off, std::fabs(b.x - a.x - 1 - 0.2 * std::cos(w * t)));
    EXPECT_NEAR((a.x + 3 * b.x) / 4, 0.9, 1e-5);
    EXPECT_NEAR((a.y + 3 * b.y) / 4, -kG * t * t / 2, 1e-3);
  }
  EXPECT_LT(off, 1e-3);
}

TEST(Joint, DampedSpringsFollowTheClosedForm) {
  for (const double zeta : {0.1, 0.5, 1.0, 3.0}) {
    for (const double frequency : {1.0, 5.0}) {
      Scene s(Vec2{0, 0});
      const double w = 2 * kPi * frequency, m = 2;
      const BodyId peg = s.peg({0, 0}), bob = s.disc({1.1, 0}, 0.01, m, true);
      JointDesc d = between(JointType::spring, peg, bob);
      d.length = 1;
      d.stiffness = m * w * w;
      d.damping = 2 * zeta * w * m;
      s.join(d);
      for (int frame = 1; frame <= 120; ++frame) {
        s.world->step();
        const double t = frame * kMotionDt;
        double exact;
        if (zeta < 1) {
          const double q = w * std::sqrt(1 - zeta * zeta);
          exact = std::exp(-zeta * w * t) * (std::cos(q * t) + zeta * w / q * std::sin(q * t));
        } else if (zeta == 1) {
          exact = std::exp(-w * t) * (1 + w * t);
        } else {
          const double q = w * std::sqrt(zeta * zeta - 1), u = q - zeta * w, v = -q - zeta * w;
          exact = (u * std::exp(v * t) - v * std::exp(u * t)) / (u - v);
        }
        ASSERT_NEAR(s.at(bob).x - 1, 0.1 * exact, 2e-4) << zeta << " at " << t;
      }
    }
  }
}

TEST(Joint, StiffSpringsStayBounded) {
  for (const double frequency : {100.0, 1e3, 1e5}) {
    Scene s;
    const double w = 2 * kPi * frequency;
    const BodyId peg = s.peg({0, 0}), bob = s.disc({1.1, 0}, 0.05, 1), end = s.disc({2.0, 0}, 0.05, 1);
    JointDesc d = between(JointType::spring, peg, bob);
    d.length = 1;
    d.stiffness = w * w;
    s.join(d);
    JointDesc e = between(JointType::spring, bob, end);
    e.length = 1;
    e.stiffness = w * w;
    s.join(e);
    for (int frame = 0; frame < 600; ++frame) {
      s.world->step();
      ASSERT_LT(std::hypot(s.at(bob).x, s.at(bob).y), 1.6) << frequency;
      ASSERT_LT(std::hypot(s.at(end).x, s.at(end).y), 3.2) << frequency;
    }
  }
}

TEST(Joint, RopeIsSlackThenTaut) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), bob = s.disc({0.5, 0}, 0.05, 1);
  JointDesc d = between(JointType::rope, peg, bob);
  d.length = 2;
  const JointId rope = s.join(d);
  for (int frame = 1; frame <= 36; ++frame) {  // taut after 0.628 s
    s.world->step();
    const double t = frame * kMotionDt;
    ASSERT_NEAR(s.at(bob).y, -kG * t * t / 2, 1e-4);
    ASSERT_EQ(s.joint(rope).force.y, 0);
  }
  double longest = 0;
  for (int frame = 0; frame < 600; ++frame) {
    s.world->step();
    longest = std::fmax(longest, s.joint(rope).value);
  }
  EXPECT_LT(longest, 2.02);
  s.run(1);
  EXPECT_GT(s.joint(rope).value, 1.9);
}

TEST(Joint, HangingMassPullsWithItsWeight) {
  for (const JointType type :
       {JointType::distance, JointType::rope, JointType::revolute, JointType::weld, JointType::prismatic}) {
    Scene s;
    const BodyId peg = s.peg({0, 0}), bob = s.disc({0, -1}, 0.1, 3);
    const bool line = type == JointType::distance || type == JointType::rope;
    const JointId id = s.join(between(type, peg, bob, {}, line ? Vec2{0, 0} : Vec2{0, 1}));
    s.run(60);
    const JointState j = s.joint(id);
    EXPECT_NEAR(j.force.y, 3 * kG, 0.05) << static_cast<int>(type);
    EXPECT_NEAR(j.force.x, 0, 0.01);
    EXPECT_NEAR(s.at(bob).y, -1, 1e-4);
  }
}

TEST(Joint, HangingChainIsACatenary) {
  Scene s;
  constexpr int kLinks = 20;
  constexpr double kLink = 12.0 / kLinks;
  const BodyId left = s.peg({-5, 0}), right = s.peg({5, 0});
  const double deep = std::sqrt(36.0 - 25.0);
  std::vector<BodyId> beads;
  BodyId before = left;
  const auto link = [&](BodyId a, BodyId b) {
    JointDesc d = between(JointType::distance, a, b);
    d.length = kLink;
    s.join(d);
  };
  for (int i = 1; i < kLinks; ++i) {
    const double l = i * kLink, x = 5 * l / 6 - 5;
    beads.push_back(s.disc({x, -deep * (l < 6 ? l / 6 : 2 - l / 6)}, 0.05, 1, true));
    link(before, beads.back());
    before = beads.back();
  }
  link(before, right);
  for (int frame = 0; frame < 3600; ++frame) {
    s.world->step();
    for (const BodyId bead : beads) {
      const BodyState b = s.at(bead);
      s.world->set_velocity(bead, {0.98 * b.vx, 0.98 * b.vy}, 0);
    }
  }
  EXPECT_NEAR(-s.at(beads[kLinks / 2 - 1]).y, 2.927215, 2e-5);
}

// A heavy body on a chain of light ones, let go from the side.
TEST(Joint, HeavyBodyDoesNotTearItsChain) {
  for (const double mass : {10.0, 100.0}) {
    Scene s;
    constexpr std::size_t kLinks = 10;
    constexpr double kLink = 0.5;
    BodyId before = s.peg({0, 0});
    std::vector<JointId> pins;
    double most = -1;
    std::vector<BodyId> bodies;
    const auto mass_of = [&](std::size_t i) { return i + 1 == kLinks ? mass : 1; };
    for (std::size_t i = 0; i < kLinks; ++i) {
      const BodyId b = s.disc({kLink * static_cast<double>(i + 1), 0}, 0.2, mass_of(i));
      bodies.push_back(b);
      pins.push_back(s.join(between(JointType::revolute, before, b, i == 0 ? Vec2{0, 0} : Vec2{kLink / 2, 0},
                                    i == 0 ? Vec2{-kLink, 0} : Vec2{-kLink / 2, 0})));
      before = b;
    }
    double apart = 0;
    for (int frame = 0; frame < 600; ++frame) {
      s.world->step();
      for (const JointId pin : pins) {
        const JointState j = s.joint(pin);
        apart = std::fmax(apart, std::hypot(j.anchor_b.x - j.anchor_a.x, j.anchor_b.y - j.anchor_a.y));
      }
      double energy = 0;
      for (std::size_t i = 0; i < kLinks; ++i) {
        const BodyState b = s.at(bodies[i]);
        energy += mass_of(i) * (kG * b.y + (b.vx * b.vx + b.vy * b.vy + 0.02 * b.omega * b.omega) / 2);
      }
      most = std::fmax(most, energy);
    }
    EXPECT_LT(apart, 0.1) << mass;
    EXPECT_LT(most, 0.01 * mass * kG * kLinks * kLink) << mass;
  }
}

}  // namespace
}  // namespace psim::test
