// Motion of shapes with corners: spin, fall, centres of mass, impacts and what they conserve.
#include "rigid_support.h"

namespace psim::test {
namespace {

const Material kElastic = material(1, 0);

std::vector<BodyDesc> one_of_each(Material m = {}) {
  return {box({0, 0}, 1, 1, m),
          box({0, 0}, 3, 0.2, m),
          capsule({0, 0}, 1, 0.3, m),
          polygon({{0, 0}, {2, 0}, {0.5, 1.5}}, {0, 0}, m),
          polygon({{2, 1}, {3, 1}, {3, 3}, {2, 3}}, {0, 0}, m),
          polygon(regular(7, 0.6), {0, 0}, m)};
}

Vec2 rotated(Vec2 v, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

// ---- spin and fall ----------------------------------------------------------------------------

TEST(RigidSpin, FreeOneTurnsAThousandRadiansInTenSeconds) {
  for (const BodyDesc& body : one_of_each()) {
    for (const bool touched : {false, true}) {
      auto world = make(unbounded(100, {0, 0}));
      const BodyId id = add(*world, moving(body, {0, 0}, 100));
      if (touched) add(*world, box({20, 0}));
      run_seconds(*world, 10);
      EXPECT_NEAR(state(*world, id).angle / 1000, 1, 1e-4);
      EXPECT_NEAR(state(*world, id).omega, 100, 1e-3);
    }
  }
}

TEST(RigidSpin, DoesNotChangeTheFall) {
  BodyState still;
  for (const double omega : {0.0, 5.0, -80.0}) {
    auto world = make(unbounded());
    const BodyId id = add(*world, moving(box({0, 0}, 2, 0.5), {3, 4}, omega));
    run(*world, 60);
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.x, 3, 1e-6);
    EXPECT_NEAR(s.y, 4 - 0.5 * kG, 1e-6);
    EXPECT_NEAR(s.angle, omega, 1e-5);
    if (omega == 0) still = s;
    EXPECT_EQ(s.x, still.x);
    EXPECT_EQ(s.y, still.y);
  }
}

TEST(RigidSpin, KeepsEnergyAndMomentumOfFreeBodies) {
  auto world = make(unbounded(100, {0, 0}));
  double at = -50;
  for (const BodyDesc& body : one_of_each()) {
    BodyDesc b = moving(body, {0.3, -0.2}, 7);
    b.position.x = at += 12;
    add(*world, b);
  }
  const Diagnostics before = world->diagnostics();
  EXPECT_GT(before.kinetic, 10);
  run(*world, 600);
  const Diagnostics after = world->diagnostics();
  EXPECT_NEAR(after.kinetic / before.kinetic, 1, 1e-6);
  EXPECT_NEAR(after.momentum_x / before.momentum_x, 1, 1e-6);
  EXPECT_NEAR(after.momentum_y / before.momentum_y, 1, 1e-6);
}

TEST(RigidSpin, EnergyIsThatOfTheShape) {
  // m (w^2 + h^2) / 24 omega^2 for a box; a rod of kg/m: l^3 / 24 omega^2.
  auto world = make(unbounded(100, {0, 0}));
  add(*world, moving(box({0, 0}, 3, 2, material(0, 0, 5)), {0, 0}, 4));
  EXPECT_NEAR(world->diagnostics().kinetic, 5 * 6 * 13.0 / 24 * 16, 1e-3);
  auto rods = make(unbounded(100, {0, 0}));
  BodyDesc rod;
  rod.shape = SegmentShape{{-1, 0}, {1, 0}};
  rod.material.density = 3;
  rod.angular_velocity = 4;
  add(*rods, rod);
  EXPECT_NEAR(rods->diagnostics().kinetic, 3 * 8.0 / 24 * 16, 1e-3);
}

TEST(RigidSpin, OfABodyThatMayNotTurnStaysZero) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  BodyDesc body = turned(box({0, 3}, 1, 1, kGrip), 0.6);
  body.fixed_rotation = true;
  const BodyId id = add(*world, moving(body, {2, 0}));
  run(*world, 300);
  EXPECT_EQ(state(*world, id).angle, 0.6);
  EXPECT_EQ(state(*world, id).omega, 0);
  EXPECT_NEAR(state(*world, id).y, 0.5 * (std::cos(0.6) + std::sin(0.6)), 1e-3);
}

// ---- place and centre of mass -----------------------------------------------------------------

TEST(RigidPlace, OfAnOffCentrePolygonTurnsAboutItsCentreOfMass) {
  const Vec2 centre{2.5, 2};
  for (const double angle : {0.0, 0.7, -2.0}) {
    auto world = make(unbounded());
    BodyDesc body = turned(polygon({{2, 1}, {3, 1}, {3, 3}, {2, 3}}, {1, -1}), angle);
    const BodyId id = add(*world, moving(body, {1, 2}, 3));
    BodyState s = state(*world, id);
    EXPECT_NEAR(s.x, 1, 1e-6);
    EXPECT_NEAR(s.y, -1, 1e-6);
    EXPECT_NEAR(s.vx, 1, 1e-6);
    EXPECT_NEAR(s.vy, 2, 1e-6);
    run(*world, 60);
    s = state(*world, id);
    const Vec2 was = rotated(centre, angle), is = rotated(centre, angle + 3);
    EXPECT_NEAR(s.angle, angle + 3, 1e-5);
    EXPECT_NEAR(s.x, 1 + was.x + 1 - is.x, 1e-5);
    EXPECT_NEAR(s.y, -1 + was.y + 2 - 0.5 * kG - is.y, 1e-5);
    EXPECT_NEAR(s.vx, 1, 1e-6);
    EXPECT_NEAR(s.vy, 2 - kG, 1e-5);
  }
}

TEST(RigidPlace, OfAKinematicBodyStaysWhileItTurns) {
  for (const BodyDesc& body : one_of_each()) {
    auto world = make(unbounded());
    BodyDesc b = moving(kinematic(body), {0, 0}, 2);
    b.position = {5, 6};
    const BodyId id = add(*world, b);
    run(*world, 60);
    EXPECT_NEAR(state(*world, id).x, 5, 1e-6);
    EXPECT_NEAR(state(*world, id).y, 6, 1e-6);
    EXPECT_NEAR(state(*world, id).angle, 2, 1e-5);
  }
}

TEST(RigidPlace, KinematicArmSweepsWithItsEndNotItsMiddle) {
  // A bar from its hinge at (0, 0) to (4, 0), turning left, meets a box at rest on its way.
  auto world = make(unbounded(100, {0, 0}));
  add(*world, moving(kinematic(polygon({{0, -0.1}, {4, -0.1}, {4, 0.1}, {0, 0.1}}, {0, 0})), {0, 0}, 1));
  const BodyId hit = add(*world, box({3, 1.5}, 0.5, 0.5));
  const BodyId behind = add(*world, box({-2, 0}, 0.5, 0.5));
  run_seconds(*world, 1);
  EXPECT_GT(state(*world, hit).vy, 0.5);
  EXPECT_EQ(speed_of(state(*world, behind)), 0);
}

TEST(RigidPlace, SetAndReadAgree) {
  Random random(5);
  for (const bool moves : {true, false}) {
    for (const BodyDesc& body : one_of_each()) {
      auto world = make(unbounded(100, {0, 0}));
      const BodyId id = add(*world, moves ? body : kinematic(body));
      for (int k = 0; k < 50; ++k) {
        const Vec2 at{random.uniform(-90, 90), random.uniform(-90, 90)};
        const Vec2 v{random.uniform(-9, 9), random.uniform(-9, 9)};
        const double angle = random.uniform(-9, 9), omega = random.uniform(-9, 9);
        ASSERT_TRUE(world->set_transform(id, at, angle));
        ASSERT_TRUE(world->set_velocity(id, v, omega));
        const BodyState s = state(*world, id);
        ASSERT_NEAR(s.x, at.x, 1e-6);
        ASSERT_NEAR(s.y, at.y, 1e-6);
        ASSERT_EQ(s.angle, angle);
        ASSERT_NEAR(s.vx, v.x, 1e-5);
        ASSERT_NEAR(s.vy, v.y, 1e-5);
        ASSERT_NEAR(s.omega, omega, 1e-5);
        if (k % 5 == 0) world->step();
        ASSERT_TRUE(world->set_transform(id, {state(*world, id).x, state(*world, id).y}, state(*world, id).angle));
      }
    }
  }
}

TEST(RigidPlace, SetOnAStackWakesItToFall) {
  Placed p = stack(5);
  run(*p.world, 60);
  ASSERT_TRUE(p.world->set_transform(p.ids[0], {50, 0.5}, 0));
  run(*p.world, 240);
  EXPECT_NEAR(p.top().y, 3.5, 0.01);
  EXPECT_NEAR(p.now(0).x, 50, 1e-4);
}

TEST(RigidPlace, ImpulsesTurnByTheirArm) {
  auto world = make(unbounded(100, {0, 0}));
  const BodyId id = add(*world, box({1, 2}, 2, 1, {}, 3));
  const double inertia = 3 * 5.0 / 12;
  ASSERT_TRUE(world->apply_impulse_at(id, {0, 6}, {2, 2.5}));
  EXPECT_NEAR(state(*world, id).vy, 2, 1e-5);
  EXPECT_NEAR(state(*world, id).omega, 6 / inertia, 1e-4);
  ASSERT_TRUE(world->apply_angular_impulse(id, -6));
  EXPECT_NEAR(state(*world, id).omega, 0, 1e-4);
}

// ---- impacts ----------------------------------------------------------------------------------

TEST(RigidBounce, HeadOnKeepsTheEnergy) {
  for (const double angle : {0.0, 0.25 * kPi}) {
    for (const double speed : {0.5, 5.0, 20.0}) {
      auto world = make(walled({-5, -5, 5, 5}, {0, 0}, kElastic));
      const BodyId id = add(*world, moving(turned(box({0, 0}, 1, 1, kElastic), angle), {speed, 0}));
      run_seconds(*world, 20);
      EXPECT_NEAR(std::abs(state(*world, id).vx) / speed, 1, 0.005) << speed << " at " << angle;
      EXPECT_NEAR(world->diagnostics().kinetic / (0.5 * speed * speed), 1, 0.01) << speed;
    }
  }
}

TEST(RigidBounce, OnACornerFollowsTheClosedForm) {
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double angle : {0.3, 0.6, 1.1}) {
      auto world = make(unbounded(100, {0, 0}));
      const Material m = material(e, 0);
      add(*world, ground(m));
      const BodyId id = add(*world, moving(turned(box({0, 3}, 1, 1, m), angle), {0, -4}));
      run(*world, 50);             // the lowest corner meets the ground; the next is clear until after this
      double arm = 0, lowest = 0;  // of the lowest corner, from the centre
      for (const Vec2 corner : {Vec2{-0.5, -0.5}, Vec2{0.5, -0.5}, Vec2{0.5, 0.5}, Vec2{-0.5, 0.5}}) {
        const Vec2 r = rotated(corner, angle);
        if (r.y < lowest) {
          lowest = r.y;
          arm = r.x;
        }
      }
      const double inertia = 1.0 / 6, impulse = (1 + e) * 4 / (1 + arm * arm / inertia);
      BodyState first = state(*world, id);
      // The first change of velocity:
      auto again = make(unbounded(100, {0, 0}));
      add(*again, ground(m));
      const BodyId twin = add(*again, moving(turned(box({0, 3}, 1, 1, m), angle), {0, -4}));
      for (int k = 0; k < 60; ++k) {
        again->step();
        first = state(*again, twin);
        if (std::abs(first.vy + 4) > 1e-3) break;
      }
      EXPECT_NEAR(first.vy, -4 + impulse, 0.02 * impulse) << e << " at " << angle;
      EXPECT_NEAR(first.omega, arm * impulse / inertia, 0.02 * std::abs(arm * impulse / inertia))
          << e << " at " << angle;
    }
  }
}

TEST(RigidBounce, FallingBoxBouncesAsHighAsItsRestitutionSays) {
  for (const double e : {0.3, 0.8, 1.0}) {
    auto world = make(unbounded());
    add(*world, ground(material(e, 0.4)));
    const BodyId id = add(*world, box({0, 1.5}, 1, 1, material(e, 0.4)));
    double apex = 0;
    bool hit = false;
    for (int k = 0; k < 70; ++k) {
      world->step();
      hit |= state(*world, id).vy > 0;
      if (hit) apex = std::max(apex, state(*world, id).y - 0.5);
    }
    EXPECT_NEAR(apex, e * e, 0.02) << e;
    EXPECT_NEAR(state(*world, id).angle, 0, 1e-3) << e;
  }
}

TEST(RigidImpulse, TwoThatCollideKeepTheirMomenta) {
  Random random(11);
  const auto shapes = one_of_each();
  for (int round = 0; round < 60; ++round) {
    const Material m = material(round % 3 * 0.5, round % 2 * 0.5);
    auto world = make(unbounded(100, {0, 0}));
    auto shape_of = [&] {
      BodyDesc b = shapes[random.below(shapes.size())];
      b.material = m;
      return turned(b, random.uniform(0, 6));
    };
    BodyDesc a = moving(shape_of(), {random.uniform(1, 9), random.uniform(-1, 1)}, random.uniform(-5, 5));
    BodyDesc b = moving(shape_of(), {-random.uniform(1, 9), 0}, random.uniform(-5, 5));
    a.position = {-8, 0};
    b.position = {8, random.uniform(-1, 1)};
    add(*world, a);
    add(*world, b);
    const Diagnostics before = world->diagnostics();
    run(*world, 240);
    const Diagnostics after = world->diagnostics();
    const double scale = std::sqrt(2 * before.kinetic * 3);
    ASSERT_NEAR(after.momentum_x, before.momentum_x, 3e-5 * scale) << round;
    ASSERT_NEAR(after.momentum_y, before.momentum_y, 3e-5 * scale) << round;
    ASSERT_NEAR(after.angular_momentum, before.angular_momentum, 0.02 * 8 * scale) << round;
    ASSERT_LT(after.kinetic, before.kinetic * 1.001) << round;
  }
}

TEST(RigidImpulse, ManyThatCollideKeepTheirMomentum) {
  auto world = make(unbounded(100, {0, 0}));
  Random random(3);
  const auto shapes = one_of_each(material(0.5, 0.3));
  double size = 0;
  for (int k = 0; k < 100; ++k) {
    const double x = k % 10 * 3.0 - 13.5, y = k / 10 * 3.0 - 13.5;
    const double omega = random.uniform(-3, 3);
    const Vec2 velocity{-x + random.uniform(-2, 2), -y};
    BodyDesc b = moving(turned(box({x, y}, 1, 1.4, material(0.5, 0.3)), random.uniform(0, 6)), velocity, omega);
    size += 1.4 * std::hypot(b.velocity.x, b.velocity.y);
    add(*world, b);
  }
  const Diagnostics before = world->diagnostics();
  double most = before.kinetic;
  for (int k = 0; k < 300; ++k) {
    world->step();
    const double now = world->diagnostics().kinetic;
    EXPECT_LE(now, most * 1.001) << k;
    most = std::min(most, now);
  }
  const Diagnostics after = world->diagnostics();
  EXPECT_LT(most, 0.9 * before.kinetic);  // they did collide
  EXPECT_NEAR(after.momentum_x, before.momentum_x, 1e-5 * size);
  EXPECT_NEAR(after.momentum_y, before.momentum_y, 1e-5 * size);
  EXPECT_NEAR(after.angular_momentum, before.angular_momentum, 1e-3 * size * 10);
}

TEST(RigidEnergy, OfAnElasticGasOfBoxesStays) {
  auto world = make(walled({-10, -10, 10, 10}, {0, 0}, kElastic));
  Random random(3);
  for (int k = 0; k < 25; ++k) {
    const double x = k % 5 * 3.5 - 7, y = k / 5 * 3.5 - 7;
    const double omega = random.uniform(-3, 3);
    const Vec2 velocity{random.uniform(-4, 4), random.uniform(-4, 4)};
    add(*world, moving(turned(box({x, y}, 1, 1, kElastic), random.uniform(0, 6)), velocity, omega));
  }
  const double before = world->diagnostics().kinetic;
  run_seconds(*world, 20);
  EXPECT_NEAR(world->diagnostics().kinetic / before, 1, 0.1);
}

}  // namespace
}  // namespace psim::test
