// A body that touches nothing: fall, flight, spin, damping, drag, impulses. Truths: closed forms.
#include "reference/closed_forms.h"
#include "support.h"

namespace psim::test {
namespace {

TEST(FreeFall, IsExactOverTenSeconds) {
  for (const Isa isa : available_isas()) {
    SCOPED_TRACE(isa_name(isa));
    auto world = make(unbounded(2000), isa);
    const BodyId id = add(*world, disc({0, 1000}, {3, 0}));
    run(*world, 600);
    const BodyState s = state(*world, id);
    const double y = reference::fall_height(1000, 0, kG, 10);
    EXPECT_LT(std::hypot(s.x - 30, s.y - y) / 490.5, 1e-5);
    EXPECT_NEAR(s.vy, -98.1, 1e-3);
  }
}

TEST(FreeFall, DoesNotDependOnTheSubsteps) {
  for (const int substeps : {1, 2, 7, 64}) {
    WorldDesc desc = unbounded(2000);
    desc.substeps = substeps;
    auto world = make(desc);
    const BodyId id = add(*world, disc({0, 0}, {0, 40}));
    run(*world, 300);
    EXPECT_NEAR(state(*world, id).y, reference::fall_height(0, 40, kG, 5), 1e-3) << substeps;
  }
}

TEST(FreeFall, IsExactForAManyBodiedCloud) {
  auto world = make(unbounded(2000), best_isa(), 2);
  const Discs cloud = lattice(1000, {-200, -200, 200, 200}, 0.1, 0, {});
  add(*world, cloud);
  run(*world, 120);
  const PublishedState s = world->published();
  ASSERT_EQ(s.id.size(), cloud.size());
  for (std::size_t k = 0; k < cloud.size(); ++k) {
    ASSERT_NEAR(s.x[k], cloud.x[k], 1e-6);
    ASSERT_NEAR(s.y[k], cloud.y[k] - 0.5 * kG * 4, 1e-4);
  }
}

TEST(FreeFall, ObeysGravityScaleAndAnyDirection) {
  for (const double scale : {0.0, 0.5, 2.0, -1.0}) {
    auto world = make(unbounded(2000, {3, -4}));
    BodyDesc body = disc({0, 0});
    body.gravity_scale = scale;
    const BodyId id = add(*world, body);
    run(*world, 60);
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.x, 1.5 * scale, 1e-5) << scale;
    EXPECT_NEAR(s.y, -2 * scale, 1e-5) << scale;
    EXPECT_NEAR(s.vx, 3 * scale, 1e-5) << scale;
    EXPECT_NEAR(s.vy, -4 * scale, 1e-5) << scale;
  }
}

TEST(FreeFall, TakesAnyStepLength) {
  auto world = make(unbounded(2000));
  const BodyId id = add(*world, disc({0, 0}, {1, 0}));
  Random random(3);
  double t = 0;
  for (int k = 0; k < 200; ++k) {
    const double dt = random.uniform(1.0 / 240, 1.0 / 10);
    world->step(dt);
    t += dt;
  }
  const BodyState s = state(*world, id);
  EXPECT_NEAR(s.x / t, 1, 1e-5);
  EXPECT_NEAR(s.y / (-0.5 * kG * t * t), 1, 1e-5);
}

TEST(UniformMotion, IsExactToTheBit) {
  // Steps that are whole in binary: nothing may round.
  for (const Isa isa : available_isas()) {
    SCOPED_TRACE(isa_name(isa));
    WorldDesc desc = unbounded(1000, {0, 0});
    desc.dt = 1.0 / 64;
    auto world = make(desc, isa);
    const BodyId id = add(*world, disc({-12.5, 3.25}, {3.25, -1.5}));
    run(*world, 6400);
    const BodyState s = state(*world, id);
    EXPECT_EQ(s.x, -12.5 + 325.0);
    EXPECT_EQ(s.y, 3.25 - 150.0);
    EXPECT_EQ(s.vx, 3.25);
    EXPECT_EQ(s.vy, -1.5);
  }
}

TEST(UniformMotion, IsTheSameEverywhere) {
  // Slow motion far from the origin is what plain floats lose: 1e-4 m/s at 1000 m.
  for (const double start : {0.0, 1000.0}) {
    for (const double speed : {1.37, 0.01, 1e-4}) {
      auto world = make(unbounded(2000, {0, 0}));
      const BodyId id = add(*world, disc({start, 0}, {speed, 0}));
      run(*world, 6000);
      EXPECT_NEAR((state(*world, id).x - start) / (100 * speed), 1, 1e-5) << start << " " << speed;
    }
  }
}

TEST(UniformMotion, BodiesThatMeetNothingDoNotFeelEachOther) {
  // The same body alone and in company has the same bits.
  auto alone = make(unbounded(500));
  auto company = make(unbounded(500));
  const BodyId a = add(*alone, disc({1, 2}, {3, 4}));
  const BodyId b = add(*company, disc({1, 2}, {3, 4}));
  add(*company, lattice(300, {20, 20, 200, 200}, 0.3, 5, material(0.5)));
  run(*alone, 120);
  run(*company, 120);
  EXPECT_EQ(state(*alone, a).x, state(*company, b).x);
  EXPECT_EQ(state(*alone, a).y, state(*company, b).y);
  EXPECT_EQ(state(*alone, a).vy, state(*company, b).vy);
}

TEST(FreeSpin, TurnsAThousandRadians) {
  for (const Isa isa : available_isas()) {
    auto world = make(unbounded(), isa);
    BodyDesc body = disc({0, 0});
    body.gravity_scale = 0;
    body.angular_velocity = 100;
    body.angle = 0.5;
    const BodyId id = add(*world, body);
    run(*world, 600);
    EXPECT_NEAR((state(*world, id).angle - 0.5) / 1000, 1, 1e-4) << isa_name(isa);
    EXPECT_EQ(state(*world, id).omega, 100) << isa_name(isa);
  }
}

TEST(LinearDamping, DecaysAsTheExponential) {
  for (const Isa isa : available_isas()) {
    SCOPED_TRACE(isa_name(isa));
    WorldDesc desc = unbounded(1000, {0, 0});
    desc.linear_damping = 0.5;
    auto world = make(desc, isa);
    const BodyId id = add(*world, disc({0, 0}, {10, -4}));
    for (int second = 1; second <= 4; ++second) {
      run(*world, 60);
      const double left = std::exp(-0.5 * second);
      EXPECT_NEAR(state(*world, id).vx / (10 * left), 1, 3e-5);
      EXPECT_NEAR(state(*world, id).vy / (-4 * left), 1, 3e-5);
      EXPECT_NEAR(state(*world, id).x / (20 * (1 - left)), 1, 3e-5);
    }
  }
}

TEST(LinearDamping, OfAFallHasTheClosedForm) {
  WorldDesc desc = unbounded(1000);
  desc.linear_damping = 0.5;
  auto world = make(desc);
  const BodyId id = add(*world, disc({0, 0}, {10, 10}));
  for (int second = 1; second <= 2; ++second) {
    run(*world, 60);
    const auto x = reference::linear_drag_position({10, 10}, kG, 0.5, second);
    const auto v = reference::linear_drag_velocity({10, 10}, kG, 0.5, second);
    EXPECT_NEAR(state(*world, id).x, x.x, 1e-4);
    EXPECT_NEAR(state(*world, id).y, x.y, 1e-4);
    EXPECT_NEAR(state(*world, id).vx, v.x, 1e-4);
    EXPECT_NEAR(state(*world, id).vy, v.y, 1e-4);
  }
}

TEST(Drag, LinearFieldHasTheClosedForm) {
  for (const Isa isa : available_isas()) {
    SCOPED_TRACE(isa_name(isa));
    WorldDesc desc = unbounded(1000);
    desc.fields.push_back(DragField{0.5, 0});
    auto world = make(desc, isa);
    const BodyId id = add(*world, disc({0, 0}, {10, 10}));
    run(*world, 60);
    const auto x = reference::linear_drag_position({10, 10}, kG, 0.5, 1);
    EXPECT_NEAR(state(*world, id).x, x.x, 1e-3);
    EXPECT_NEAR(state(*world, id).y, x.y, 1e-3);
  }
}

TEST(Drag, QuadraticFieldHasTheClosedForm) {
  WorldDesc desc = unbounded(1000, {0, 0});
  desc.fields.push_back(DragField{0, 0.2});
  auto world = make(desc);
  const BodyId id = add(*world, disc({0, 0}, {6, 8}));  // 10 m/s
  run(*world, 120);
  const BodyState s = state(*world, id);
  EXPECT_NEAR(std::hypot(s.vx, s.vy) / reference::quadratic_drag_speed(10, 0.2, 2), 1, 1e-3);
  EXPECT_NEAR(std::hypot(s.x, s.y) / reference::quadratic_drag_distance(10, 0.2, 2), 1, 1e-3);
  EXPECT_NEAR(s.vy / s.vx, 8.0 / 6, 1e-5);
}

TEST(Drag, FallReachesItsTerminalSpeed) {
  WorldDesc desc = unbounded(2000);
  desc.fields.push_back(DragField{0, 0.05});
  auto world = make(desc);
  const BodyId id = add(*world, disc({0, 1500}));
  run(*world, 600);
  EXPECT_NEAR(state(*world, id).vy / -std::sqrt(kG / 0.05), 1, 1e-4);
}

TEST(Impulse, ChangesVelocityByItsShareOfTheMass) {
  auto world = make(unbounded(1000, {0, 0}));
  BodyDesc body = disc({0, 0}, {1, 0});
  body.mass = 4;
  const BodyId id = add(*world, body);
  ASSERT_TRUE(world->apply_impulse(id, {8, -2}));
  EXPECT_DOUBLE_EQ(state(*world, id).vx, 3);
  EXPECT_DOUBLE_EQ(state(*world, id).vy, -0.5);
  const BodyId fixed = add(*world, static_disc({10, 0}, 1));
  world->apply_impulse(fixed, {8, -2});
  run(*world, 10);
  EXPECT_EQ(state(*world, fixed).x, 10);
}

TEST(Mass, ComesFromTheDensityUnlessGiven) {
  auto world = make(unbounded(1000, {0, 0}));
  BodyDesc spinning = disc({0, 0}, {2, 0}, 0.5, material(0, 0, 3));
  spinning.angular_velocity = 4;
  add(*world, spinning);
  const double m = 3 * kPi * 0.25;
  const double kinetic = 0.5 * m * 4 + 0.5 * (0.5 * m * 0.25) * 16;
  EXPECT_NEAR(world->diagnostics().kinetic / kinetic, 1, 1e-6);
  EXPECT_NEAR(world->diagnostics().momentum_x / (2 * m), 1, 1e-6);
  BodyDesc heavy = disc({10, 0}, {0, 1});
  heavy.mass = 1000;
  add(*world, heavy);
  EXPECT_NEAR(world->diagnostics().momentum_y / 1000, 1, 1e-6);
  EXPECT_NEAR(world->diagnostics().angular_momentum / (10 * 1000 + 0.5 * m * 0.25 * 4), 1, 1e-6);
}

TEST(StepLength, ThatIsNoneChangesNothing) {
  auto world = pile(50);
  run(*world, 30);
  for (const double dt : {0.0, -1.0, kNan, kInf}) {
    const auto before = world->state_hash();
    world->step(dt);
    EXPECT_EQ(world->state_hash(), before) << dt;
  }
  EXPECT_TRUE(all_finite(*world));
  world->step(1e-6);
  EXPECT_TRUE(all_finite(*world));
}

}  // namespace
}  // namespace psim::test
