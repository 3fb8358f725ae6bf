// Characters and the bodies that move: platforms, belts, shelves that are solid from above, crates, presses.
#include "mover_support.h"

namespace psim::test {
namespace {

// It rides on what moves, up, down, to the side and round, as a point of the platform does.
TEST(Mover, RidesOnPlatforms) {
  for (const Vec2 v : {Vec2{2, 0}, Vec2{-3, 0}, Vec2{0, 2}, Vec2{0, -2}, Vec2{1, 1}}) {
    auto world = make(unbounded());
    BodyDesc platform = block({0, 0}, 6, 0.5, 0, BodyType::kinematic_body);
    const BodyId id = add(*world, platform);
    Mover mover({}, {0.5, 1.5});
    walk(*world, mover, 0, 40);
    ASSERT_TRUE(mover.on_ground());
    const Vec2 on{mover.position().x - state(*world, id).x, mover.position().y - state(*world, id).y};
    world->set_velocity(id, v, 0);
    for (int k = 0; k < 200; ++k) {
      walk(*world, mover, 0, 1);
      ASSERT_TRUE(mover.on_ground()) << k;
      ASSERT_NEAR(mover.position().x - state(*world, id).x, on.x, 1e-3) << k;
      ASSERT_NEAR(mover.position().y - state(*world, id).y, on.y, 1e-3) << k;
    }
    EXPECT_NEAR(mover.ground()->velocity.x, v.x, 1e-6);
    EXPECT_NEAR(mover.ground()->velocity.y, v.y, 1e-6);
    EXPECT_NEAR(mover.velocity().x, 0, 1e-12);
    walk(*world, mover, 1, 60);  // walks on it
    EXPECT_NEAR(mover.position().x - state(*world, id).x, on.x + 1, 2e-2);
  }
}

TEST(Mover, TurnsWithATurningPlatform) {
  auto world = make(unbounded());
  BodyDesc wheel = static_disc({0, 0}, 5);
  wheel.type = BodyType::kinematic_body;
  const BodyId id = add(*world, wheel);
  Mover mover({}, {0, 6.2});
  walk(*world, mover, 0, 40);
  ASSERT_TRUE(mover.on_ground());
  world->set_velocity(id, {0, 0}, -0.4);
  double angle = state(*world, id).angle;
  for (int k = 0; k < 60; ++k) {
    const Vec2 before = mover.ground()->point;
    walk(*world, mover, 0, 1);
    ASSERT_TRUE(mover.on_ground()) << k;
    const double turn = state(*world, id).angle - angle;
    angle += turn;
    const Vec2 carried{std::cos(turn) * before.x - std::sin(turn) * before.y,
                       std::sin(turn) * before.x + std::cos(turn) * before.y};
    ASSERT_NEAR(mover.ground()->point.x, carried.x, 2e-3) << k;
    ASSERT_NEAR(mover.ground()->point.y, carried.y, 2e-3) << k;
  }
  EXPECT_NEAR(mover.ground()->velocity.x, 0.4 * mover.ground()->point.y, 1e-6);
  EXPECT_GT(mover.position().x, 1.5);
}

TEST(Mover, IsCarriedByABelt) {
  auto world = make(unbounded());
  BodyDesc belt = block({0, 0}, 40, 1);
  belt.material.tangent_speed = 2;
  add(*world, belt);
  Mover mover({}, {-10, 1.5});
  walk(*world, mover, 0, 40);
  const double x = mover.position().x;
  walk(*world, mover, 0, 60);
  EXPECT_NEAR(mover.position().x - x, 2, 1e-6);
  EXPECT_NEAR(mover.ground()->velocity.x, 2, 1e-6);
}

// A shelf that is solid from above: it is passed by a jump from below, and holds who falls on it, at rest or moving.
TEST(Mover, PassesOneWayShapesFromBelowAlone) {
  for (const double speed : {0.0, 1.0, -1.0}) {
    auto world = level();
    BodyDesc shelf = block({0, 1.8}, 30, 0.2, 0, speed == 0 ? BodyType::static_body : BodyType::kinematic_body);
    shelf.one_way = {0, 1};
    shelf.velocity = {speed, 0};
    const BodyId id = add(*world, shelf);
    Mover mover({}, {0, 0.92});
    walk(*world, mover, 0, 20);
    ASSERT_TRUE(mover.on_ground());
    EXPECT_EQ(mover.ground()->body, (BodyId{0, 0}));
    walk(*world, mover, 1, 10);  // its head is in the shelf, and it walks
    EXPECT_GT(mover.position().x, 0.1);
    walk(*world, mover, 0, 25, 7.5);
    EXPECT_GT(foot(mover), 1.9);
    walk(*world, mover, 0, 60);
    ASSERT_TRUE(mover.on_ground());
    EXPECT_EQ(mover.ground()->body, id);
    EXPECT_NEAR(foot(mover), 1.91, 1e-3);
  }
}

// A lift that is solid from above comes up under who falls.
TEST(Mover, LandsOnAOneWayLiftThatRises) {
  auto world = make(unbounded());
  BodyDesc lift = block({0, -4}, 4, 0.2, 0, BodyType::kinematic_body);
  lift.one_way = {0, 1};
  lift.velocity = {0, 3};
  const BodyId id = add(*world, lift);
  for (int k = 0; k < 12; ++k) {  // at other phases of a step each time
    world->set_transform(id, {0, -4}, 0);
    Mover mover({}, {0, 1 + 0.013 * k});
    walk(*world, mover, 0, 60);
    ASSERT_TRUE(mover.on_ground()) << k;
    EXPECT_EQ(mover.ground()->body, id);
    EXPECT_NEAR(foot(mover) - state(*world, id).y, 0.11, 1e-3);
  }
}

TEST(Mover, DoesNotFallThroughAThinChainAtSpeed) {
  auto world = make(unbounded());
  add(*world, chain({{-20, 0.3}, {-7, 0}, {0, 0.2}, {9, -0.1}, {20, 0}}));
  for (int k = 0; k < 40; ++k) {
    Mover mover({}, {-15.0 + 0.7 * k, 20 + 0.17 * k});
    Vec2 v{k % 3 - 1.0, -50};
    for (int n = 0; n < 40; ++n) {
      ASSERT_TRUE(mover.move(*world, v, kDt));
      ASSERT_LT(depth_of(*world, mover), 0);
    }
    EXPECT_GT(foot(mover), -0.2);
    EXPECT_TRUE(mover.on_ground());
  }
}

// A body in its way gets its speed, as far as the force does; without a force it does not move.
TEST(Mover, PushesBodiesWithItsForce) {
  for (const double force : {0.0, 100.0, 1e6}) {
    auto world = make(unbounded(100, {0, 0}));
    const BodyId crate = add(*world, block({2, 0}, 1, 1, 0, BodyType::dynamic_body));  // 1 kg
    add(*world, ground());
    world->set_transform(crate, {2, 0.5}, 0);
    MoverDesc desc;
    desc.push_force = force;
    Mover mover(desc, {0, 0.91});
    walk(*world, mover, 0, 5);
    double fastest = 0;
    int moves = 0;
    while (mover.position().x < 1.15 && ++moves < 60) walk(*world, mover, 3, 1);
    walk(*world, mover, 3, 1);
    fastest = state(*world, crate).vx;
    if (force == 0) {
      EXPECT_EQ(fastest, 0);
    } else {
      EXPECT_GT(fastest, 0);
      EXPECT_LE(fastest, std::min(3.0, 2 * force * kDt) + 1e-6);  // in two moves at most
    }
    EXPECT_LT(depth_of(*world, mover), 1e-6);
  }
}

// What comes upon it moves it; between two it says how deep it is in them.
TEST(Mover, IsMovedByWhatComesUponIt) {
  auto world = level();
  const BodyId press = add(*world, block({-5, 1}, 2, 2, 0, BodyType::kinematic_body));
  Mover mover({}, {0, 0.91});
  walk(*world, mover, 0, 5);
  world->set_velocity(press, {2, 0}, 0);
  walk(*world, mover, 0, 180);
  EXPECT_NEAR(mover.position().x - state(*world, press).x, 1.3, 0.05);
  EXPECT_TRUE(mover.on_ground());
  EXPECT_LT(depth_of(*world, mover), 1e-6);
  EXPECT_EQ(mover.squeezed(), 0);
  add(*world, block({state(*world, press).x + 3, 5}, 2, 10));
  walk(*world, mover, 0, 15);
  EXPECT_GT(mover.squeezed(), 0.01);
  EXPECT_LT(mover.squeezed(), 0.2);
  walk(*world, mover, 0, 60);
  EXPECT_TRUE(std::isfinite(mover.position().x));
}

}  // namespace
}  // namespace psim::test
