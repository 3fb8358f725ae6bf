// Joints against closed forms and a Runge-Kutta reference, through the public API.
#include <array>

#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

constexpr double kDt = 1.0 / 60;

struct Scene {
  explicit Scene(Vec2 gravity = {0, -kG}) {
    WorldDesc d;
    d.gravity = gravity;
    make(d);
  }
  explicit Scene(const WorldDesc& d) { make(d); }
  void make(const WorldDesc& d) {
    std::string error;
    world = World::create(d, {}, error);
    EXPECT_NE(world, nullptr) << error;
  }

  BodyId add(const BodyDesc& d) {
    std::string error;
    const BodyId id = world->add_body(d, error);
    EXPECT_NE(id, kNoBody) << error;
    return id;
  }
  BodyId disc(Vec2 at, double radius, double mass = 1, bool fixed_rotation = false) {
    BodyDesc d;
    d.shape = DiscShape{radius};
    d.position = at;
    d.mass = mass;
    d.fixed_rotation = fixed_rotation;
    return add(d);
  }
  BodyId peg(Vec2 at) {
    BodyDesc d;
    d.type = BodyType::static_body;
    d.shape = DiscShape{0.01};
    d.position = at;
    return add(d);
  }
  JointId join(const JointDesc& d) {
    std::string error;
    const JointId id = world->add_joint(d, error);
    EXPECT_NE(id, kNoJoint) << error;
    return id;
  }
  BodyState at(BodyId id) const { return world->body(id).value(); }
  JointState joint(JointId id) const { return world->joint(id).value(); }
  void run(int frames) {
    for (int i = 0; i < frames; ++i) world->step();
  }

  std::unique_ptr<World> world;
};

JointDesc between(JointType type, BodyId a, BodyId b, Vec2 anchor_a = {}, Vec2 anchor_b = {}) {
  JointDesc d;
  d.type = type;
  d.a = a;
  d.b = b;
  d.anchor_a = anchor_a;
  d.anchor_b = anchor_b;
  return d;
}

template <std::size_t N, class Slope>
void runge_kutta(std::array<double, N>& y, double time, int steps, const Slope& slope) {
  const double h = time / steps;
  const auto ahead = [&](const std::array<double, N>& k, double s) {
    std::array<double, N> z = y;
    for (std::size_t i = 0; i < N; ++i) z[i] += s * k[i];
    return z;
  };
  for (int n = 0; n < steps; ++n) {
    const auto k1 = slope(y), k2 = slope(ahead(k1, h / 2)), k3 = slope(ahead(k2, h / 2)),
               k4 = slope(ahead(k3, h));
    for (std::size_t i = 0; i < N; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
}

TEST(Joint, PendulumKeepsPeriodHeightAndLength) {
  constexpr double kPeriod = 2.3678419476;  // of length 1 from 90 degrees
  for (const bool ends_swapped : {false, true}) {
    Scene s;
    const BodyId peg = s.peg({0, 0}), bob = s.disc({1, 0}, 0.01, 1, true);
    s.join(ends_swapped ? between(JointType::distance, bob, peg)
                        : between(JointType::distance, peg, bob));
    double before = 0, height = -1, stretch = 0, back = 0;
    int turns = 0;
    for (int frame = 1; turns < 10 && frame < 1600; ++frame) {
      s.world->step();
      const BodyState b = s.at(bob);
      stretch = std::fmax(stretch, std::fabs(std::hypot(b.x, b.y) - 1));
      const double swing = b.vy * b.x - b.vx * b.y;
      if (before > 0 && swing <= 0) {
        ++turns;
        back = (frame - 1 + before / (before - swing)) * kDt;
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
      runge_kutta(y, kDt, 20, [](const std::array<double, 2>& a) {
        return std::array<double, 2>{a[1], -kG * std::sin(a[0])};
      });
    }
    const BodyState b = s.at(bob);
    EXPECT_NEAR(std::atan2(b.x, -b.y), y[0], 5e-3);
  }
}

TEST(Joint, DoublePendulumFollowsRungeKutta) {
  Scene s;
  const BodyId peg = s.peg({0, 0}), p = s.disc({1, 0}, 0.01, 1, true),
               q = s.disc({2, 0}, 0.01, 1, true);
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
    runge_kutta(y, kDt, 100, slope);
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
    runge_kutta(y, kDt, 50, slope);
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
    if (frame <= 600) early = std::fmax(early, std::fabs(x - 0.1 * std::cos(w * frame * kDt)));
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
    const double t = frame * kDt;
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
        const double t = frame * kDt;
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
    const BodyId peg = s.peg({0, 0}), bob = s.disc({1.1, 0}, 0.05, 1),
                 end = s.disc({2.0, 0}, 0.05, 1);
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
    const double t = frame * kDt;
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
  for (const JointType type : {JointType::distance, JointType::rope, JointType::revolute,
                               JointType::weld, JointType::prismatic}) {
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
    JointDesc d = swapped ? between(JointType::prismatic, block, peg)
                          : between(JointType::prismatic, peg, block);
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
      pins.push_back(
          s.join(between(JointType::revolute, before, b, i == 0 ? Vec2{0, 0} : Vec2{kLink / 2, 0},
                         i == 0 ? Vec2{-kLink, 0} : Vec2{-kLink / 2, 0})));
      before = b;
    }
    double apart = 0;
    for (int frame = 0; frame < 600; ++frame) {
      s.world->step();
      for (const JointId pin : pins) {
        const JointState j = s.joint(pin);
        apart =
            std::fmax(apart, std::hypot(j.anchor_b.x - j.anchor_a.x, j.anchor_b.y - j.anchor_a.y));
      }
      double energy = 0;
      for (std::size_t i = 0; i < kLinks; ++i) {
        const BodyState b = s.at(bodies[i]);
        energy +=
            mass_of(i) * (kG * b.y + (b.vx * b.vx + b.vy * b.vy + 0.02 * b.omega * b.omega) / 2);
      }
      most = std::fmax(most, energy);
    }
    EXPECT_LT(apart, 0.1) << mass;
    EXPECT_LT(most, 0.01 * mass * kG * kLinks * kLink) << mass;
  }
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
  const BodyId peg = s.peg({0, 0}), other = s.peg({3, 0}), p = s.disc({1, 0}, 0.1),
               q = s.disc({2, 0}, 0.1), gone = s.disc({4, 0}, 0.1);
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
