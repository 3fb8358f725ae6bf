// Kinematic bodies go their own way: nothing pushes them, they push everything.
#include "support.h"

namespace psim::test {
namespace {

BodyDesc kinematic(Vec2 position, Vec2 velocity, double radius = 0.5, Material m = {}) {
  BodyDesc body = disc(position, velocity, radius, m);
  body.type = BodyType::kinematic_body;
  return body;
}

TEST(Kinematic, MovesAtItsVelocityWhateverItMeets) {
  for (const Isa isa : available_isas()) {
    WorldDesc desc = unbounded(200);  // with gravity, which it does not feel
    desc.dt = 1.0 / 64;
    desc.linear_damping = 0.3;
    desc.fields.push_back(WellField{{0, 50}, 100, 1, 2, 0});
    auto world = make(desc, isa);
    const BodyId id = add(*world, kinematic({-20, 0}, {4, 0.5}, 2));
    add(*world, lattice(100, {-10, -5, 10, 5}, 0.4, 1, material(0.5, 0.5)));
    run(*world, 256);
    const BodyState s = state(*world, id);
    EXPECT_EQ(s.x, -4);
    EXPECT_EQ(s.y, 2);
    EXPECT_EQ(s.vx, 4);
    EXPECT_EQ(s.vy, 0.5);
    EXPECT_EQ(s.omega, 0);
  }
}

TEST(Kinematic, PushesADiscAheadAtItsOwnSpeed) {
  auto world = make(unbounded(200, {0, 0}));
  const BodyId pusher = add(*world, kinematic({0, 0}, {3, 0}));
  const BodyId pushed = add(*world, disc({2, 0}));
  run(*world, 300);
  EXPECT_NEAR(state(*world, pushed).vx, 3, 1e-3);
  EXPECT_NEAR(state(*world, pushed).x - state(*world, pusher).x, 1, 0.01);
}

TEST(Kinematic, IsAnEndlesslyHeavyPartnerInAnImpact) {
  auto world = make(unbounded(200, {0, 0}));
  add(*world, kinematic({0, 0}, {2, 0}, 0.5, material(1)));
  const BodyId id = add(*world, disc({3, 0}, {-1, 0}, 0.5, material(1)));
  run(*world, 120);
  EXPECT_NEAR(state(*world, id).vx, 5, 1e-4);
}

TEST(Kinematic, TurnsWhatTouchesIt) {
  // A turning roller under a disc with friction spins it the other way, surface at equal speed.
  auto world = make(unbounded(50));
  BodyDesc roller = kinematic({0, 0}, {}, 1, material(0, 1));
  roller.angular_velocity = 2;
  const BodyId id = add(*world, roller);
  BodyDesc rider = disc({0, 1.5}, {}, 0.5, material(0, 1));
  const BodyId top = add(*world, rider);
  run(*world, 20);
  EXPECT_EQ(state(*world, id).omega, 2);
  EXPECT_LT(state(*world, top).omega, -0.5);
  EXPECT_NEAR(state(*world, id).angle, 2 * 20 / 60.0, 1e-5);
}

TEST(Kinematic, CanBeSteered) {
  auto world = make(unbounded(50, {0, 0}));
  const BodyId id = add(*world, kinematic({0, 0}, {1, 0}));
  run(*world, 60);
  ASSERT_TRUE(world->set_velocity(id, {0, -2}, 0));
  run(*world, 60);
  EXPECT_NEAR(state(*world, id).x, 1, 1e-5);
  EXPECT_NEAR(state(*world, id).y, -2, 1e-5);
}

TEST(Kinematic, DoesNotCollideWithStaticOrKinematic) {
  auto world = make(unbounded(50));
  add(*world, ground());
  add(*world, kinematic({5, 0}, {0, 0}));
  const BodyId id = add(*world, kinematic({0, 0}, {2, 0}));
  run(*world, 300);
  EXPECT_NEAR(state(*world, id).x, 10, 1e-4);
  EXPECT_NEAR(state(*world, id).y, 0, 1e-6);
}

}  // namespace
}  // namespace psim::test
