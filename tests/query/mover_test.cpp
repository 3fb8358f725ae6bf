// Characters: what they climb, stand on, pass and never enter.
#include "allocation_counter.h"
#include "mover_support.h"

namespace psim::test {
namespace {

// It falls as a body does, lands, and then stands still to the last bit.
TEST(Mover, FallsAndStands) {
  auto world = level();
  Mover mover({}, {0, 3});
  walk(*world, mover, 0, 20);
  EXPECT_FALSE(mover.on_ground());
  EXPECT_NEAR(mover.velocity().y, -20 * kG * kDt, 1e-9);
  walk(*world, mover, 0, 60);
  ASSERT_TRUE(mover.on_ground());
  EXPECT_EQ(mover.ground()->body, (BodyId{0, 0}));
  EXPECT_NEAR(mover.ground()->normal.y, 1, 1e-12);
  EXPECT_NEAR(foot(mover), mover.desc().skin, 1e-7);
  EXPECT_EQ(mover.velocity(), Vec2{});
  ASSERT_EQ(mover.touches().size(), 1u);
  EXPECT_EQ(mover.touches()[0].body, (BodyId{0, 0}));
  const Vec2 at = mover.position();
  walk(*world, mover, 0, 100);
  EXPECT_NEAR(mover.position().y, at.y, 1e-12);
  EXPECT_EQ(mover.position().x, at.x);
}

TEST(Mover, NeedsNoMemory) {
  auto world = level();
  for (int k = 0; k < 20; ++k) add(*world, block({2.0 * k, 0.1 * (k % 3)}, 1, 0.3, 0.1 * k));
  Mover mover({}, {0, 3});
  walk(*world, mover, 3, 2);
  const std::uint64_t before = allocations();
  for (int k = 0; k < 300; ++k) ASSERT_TRUE(mover.move(*world, {3, mover.velocity().y - kG * kDt}, kDt));
  EXPECT_EQ(allocations(), before);
  EXPECT_GT(mover.position().x, 5);
}

// A capsule without a straight part is a disc.
TEST(Mover, MayBeADisc) {
  auto world = level();
  MoverDesc desc;
  desc.half_height = 0;
  Mover mover(desc, {0, 3});
  walk(*world, mover, 2, 90);
  EXPECT_TRUE(mover.on_ground());
  EXPECT_NEAR(foot(mover), desc.skin, 1e-7);
  EXPECT_NEAR(mover.position().x, 3, 1e-6);
}

TEST(Mover, WalksAtItsSpeedAndStopsAtWalls) {
  auto world = level();
  const BodyId wall = add(*world, block({8, 5}, 2, 10));
  Mover mover({}, {0, 1});
  walk(*world, mover, 4, 60);
  EXPECT_NEAR(mover.position().x, 4, 0.2);
  walk(*world, mover, 4, 120);
  EXPECT_NEAR(mover.position().x, 7 - mover.desc().radius - mover.desc().skin, 1e-6);
  EXPECT_TRUE(mover.on_ground());
  EXPECT_EQ(mover.velocity().x, 0);
  const auto touched = mover.touches();
  EXPECT_TRUE(std::any_of(touched.begin(), touched.end(), [&](const MoverTouch& t) { return t.body == wall; }));
}

// Steps up to the height are climbed and walked down without a fall; higher ones stop it.
TEST(Mover, ClimbsStepsOfItsHeightAndNoHigherOnes) {
  for (const double radius : {0.2, 0.4}) {
    for (const double height : {0.02, 0.1, 0.2, 0.29, 0.31, 0.4, 0.8}) {
      for (const double way : {1.0, -1.0}) {
        auto world = level();
        add(*world, block({way * 6, height / 2}, 8, height));
        MoverDesc desc;
        desc.radius = radius;
        Mover mover(desc, {0, 1 + radius});
        walk(*world, mover, 0, 60);
        ASSERT_TRUE(mover.on_ground());
        walk(*world, mover, way * 3, 80);
        const bool climbs = height < desc.step_height;
        EXPECT_EQ(way * mover.position().x > 2.5, climbs) << height;
        EXPECT_NEAR(foot(mover), (climbs ? height : 0) + desc.skin, 1e-6) << height;
        EXPECT_TRUE(mover.on_ground()) << height;
        if (!climbs) continue;
        // Down again at the far end: it never leaves the ground.
        for (int k = 0; k < 180; ++k) {
          walk(*world, mover, way * 3, 1);
          ASSERT_TRUE(mover.on_ground()) << height << " at " << mover.position().x;
        }
        EXPECT_NEAR(foot(mover), desc.skin, 1e-6);
      }
    }
  }
}

TEST(Mover, ClimbsStairsAndComesDown) {
  auto world = level();
  for (int k = 1; k <= 10; ++k) add(*world, block({2 + 0.3 * k, 0.1 * k}, 0.3, 0.2 * k));
  add(*world, block({7.15, 1}, 4, 2));
  Mover mover({}, {0, 1});
  walk(*world, mover, 0, 30);
  double most = 0;
  for (int k = 0; k < 120; ++k) {
    const double before = foot(mover);
    walk(*world, mover, 3, 1);
    ASSERT_TRUE(mover.on_ground()) << mover.position().x;
    most = std::max(most, std::fabs(foot(mover) - before));
  }
  EXPECT_NEAR(foot(mover), 2.01, 1e-6);
  EXPECT_NEAR(mover.position().x, 6, 0.6);
  for (int k = 0; k < 140; ++k) {
    walk(*world, mover, -3, 1);
    ASSERT_TRUE(mover.on_ground()) << mover.position().x;
  }
  EXPECT_NEAR(foot(mover), 0.01, 1e-6);
  EXPECT_LT(most, 0.21);
}

// Slopes below the limit are walked up at the same speed along the slope; steeper ones are not, and it slides down them.
TEST(Mover, WalksUpWhatIsLessSteepThanItsLimit) {
  for (const double degrees : {10.0, 30.0, 49.0, 51.0, 70.0}) {
    auto world = level();
    const double a = degrees * kPi / 180;
    add(*world, chain({{2, 0}, {2 + 20 * std::cos(a), 20 * std::sin(a)}}));
    Mover mover({}, {0, 1});
    walk(*world, mover, 0, 30);
    walk(*world, mover, 3, 120);
    const bool climbs = degrees < 50;
    EXPECT_EQ(foot(mover) > 0.5, climbs) << degrees;
    EXPECT_TRUE(mover.on_ground());
    if (climbs) {
      EXPECT_NEAR(mover.ground()->normal.x, -std::sin(a), 1e-6);
      const Vec2 at = mover.position();
      walk(*world, mover, 3, 10);
      EXPECT_NEAR(std::hypot(mover.position().x - at.x, mover.position().y - at.y), 0.5, 1e-6);
      walk(*world, mover, 0, 60);  // it stands on the slope
      const Vec2 stood = mover.position();
      walk(*world, mover, 0, 60);
      EXPECT_NEAR(mover.position().x, stood.x, 1e-9);
      walk(*world, mover, -3, 30);  // and goes down on it
      EXPECT_TRUE(mover.on_ground());
      EXPECT_NEAR(mover.ground()->normal.x, -std::sin(a), 1e-6);
    } else {
      mover.set_position({2 + 5 * std::cos(a), 5 * std::sin(a) + 2});
      const auto fall = [&](int moves) {
        for (int k = 0; k < moves; ++k) {
          const Vec2 v = mover.velocity();
          ASSERT_TRUE(mover.move(*world, {v.x, v.y - kG * kDt}, kDt));
        }
      };
      fall(60);
      EXPECT_FALSE(mover.on_ground());
      EXPECT_NEAR(mover.velocity().y / mover.velocity().x, std::tan(a), 1e-6);  // along the slope
      fall(120);
      EXPECT_LT(mover.position().x, 2.3);
      EXPECT_NEAR(foot(mover), 0.01, 1e-3);
    }
  }
}

// In corners of any angle it comes to rest: no jitter.
TEST(Mover, RestsInCorners) {
  for (const double degrees : {20.0, 45.0, 80.0, 100.0, 125.0}) {
    auto world = level();
    const double a = degrees * kPi / 180;
    add(*world, segment({3, 0}, {3 - 10 * std::cos(a), 10 * std::sin(a)}));
    Mover mover({}, {-14, 1});
    walk(*world, mover, 6, 240);
    const Vec2 at = mover.position();
    EXPECT_LT(depth_of(*world, mover), 0);
    for (int k = 0; k < 30; ++k) {
      walk(*world, mover, 6, 1);
      EXPECT_NEAR(mover.position().x, at.x, 1e-6) << degrees;
      EXPECT_NEAR(mover.position().y, at.y, 1e-6) << degrees;
    }
  }
}

// Between two steep sides it hangs still and may jump.
TEST(Mover, StandsInAWedge) {
  auto world = make(unbounded());
  add(*world, chain({{-2, 6}, {0, 0}, {2, 6}}));
  Mover mover({}, {0.1, 8});
  walk(*world, mover, 0, 200);
  EXPECT_TRUE(mover.on_ground());
  const Vec2 at = mover.position();
  walk(*world, mover, 0, 60);
  EXPECT_NEAR(mover.position().y, at.y, 1e-2);
  EXPECT_LT(depth_of(*world, mover), 0);
}

// Random levels of all shapes, random walks and jumps: it never enters what stands still, and each run has the same bits.
TEST(Mover, NeverEntersAnythingInRandomLevels) {
  std::size_t stood = 0, jumps = 0, moves = 0;
  double deepest = -1;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Vec2 last[2];
    for (const int again : {0, 1}) {
      Random r(seed);
      auto world = make(walled({-30, -5, 30, 30}));
      add(*world, ground());
      add(*world, segment({-15, 0}, {-15, 30}));
      add(*world, segment({15, 0}, {15, 30}));
      for (int k = 0; k < 50; ++k) {
        const Vec2 at{r.uniform(-15, 15), r.uniform(0, 8)};
        const double angle = r.uniform(-2, 2);
        BodyDesc body = block(at, r.uniform(0.1, 3), r.uniform(0.1, 1), angle);
        if (k % 5 == 1) body.shape = DiscShape{r.uniform(0.1, 1)};
        if (k % 5 == 2)
          body.shape = ChainShape{{{-2, 0}, {-1, r.uniform(-1, 1)}, {0.5, 0}, {2, r.uniform(-1, 1)}}, false};
        if (k % 5 == 3) body.shape = CapsuleShape{{-1, 0}, {1, r.uniform(-1, 1)}, r.uniform(0.1, 0.4)};
        if (k % 10 == 4) body.one_way = {0, 1};
        add(*world, body);
      }
      MoverDesc desc;
      desc.radius = r.uniform(0.1, 0.4);
      desc.half_height = r.uniform(0.05, 0.7);
      Mover mover(desc, {0, 15});
      double speed = 4;
      for (int k = 0; k < 1000; ++k, ++moves) {
        if (r.chance(0.05)) speed = r.uniform(-6, 6);
        Vec2 v = mover.velocity();
        v.x = speed;
        const bool jump = mover.on_ground() && r.chance(0.1);
        v.y = jump ? r.uniform(3, 9) : v.y - kG * kDt;
        ASSERT_TRUE(mover.move(*world, v, kDt));
        const double depth = depth_of(*world, mover);
        deepest = std::max(deepest, depth);
        ASSERT_LT(depth, 1e-6) << "level " << seed << ", move " << k << " at " << mover.position().x << " "
                               << mover.position().y;
        stood += mover.on_ground();
        jumps += jump;
        ASSERT_GT(foot(mover), 0);
        ASSERT_LT(std::fabs(mover.position().x), 15);
      }
      last[again] = mover.position();
    }
    EXPECT_EQ(last[0], last[1]);
  }
  EXPECT_EQ(moves, 20'000u);
  EXPECT_GT(stood, 2'000u);
  EXPECT_GT(jumps, 100u);
}

TEST(Mover, GoesAcrossTheSeamOfAPeriodicWorld) {
  auto world = make(periodic(20, 20));
  BodyDesc floor = block({10, 1}, 20, 1, 0, BodyType::kinematic_body);
  floor.velocity = {3, 0};
  const BodyId id = add(*world, floor);
  Mover mover({}, {10, 2.6});
  walk(*world, mover, 0, 30);
  ASSERT_TRUE(mover.on_ground());
  const double x = mover.position().x;
  walk(*world, mover, 2, 400);
  EXPECT_TRUE(mover.on_ground());
  EXPECT_EQ(mover.ground()->body, id);
  EXPECT_NEAR(mover.position().x - x, 5 * 400 * kDt, 0.1);
}

TEST(Mover, StandsAlongItsUp) {
  auto world = make(unbounded());
  add(*world, segment({5, -50}, {5, 50}));  // the ground, for who falls to the right
  MoverDesc desc;
  desc.up = {-2, 0};
  Mover mover(desc, {3, 0});
  for (int k = 0; k < 60; ++k) ASSERT_TRUE(mover.move(*world, {mover.velocity().x + kG * kDt, 2}, kDt));
  ASSERT_TRUE(mover.on_ground());
  EXPECT_NEAR(mover.position().x, 5 - 0.91, 1e-6);
  EXPECT_NEAR(mover.position().y, 2, 0.1);
}

TEST(Mover, RefusesBadNumbersAndStaysAsItIs) {
  auto world = level();
  Mover mover({}, {0, 1});
  walk(*world, mover, 1, 30);
  const Vec2 at = mover.position(), v = mover.velocity();
  const auto same = [&] { return mover.position() == at && mover.velocity() == v && mover.on_ground(); };
  for (const double bad : {kNan, kInf, -kInf, 1e7}) {
    EXPECT_FALSE(mover.move(*world, {bad, 0}, kDt));
    EXPECT_FALSE(mover.move(*world, {0, bad}, kDt));
    EXPECT_FALSE(mover.move(*world, {1, 0}, bad));
  }
  for (const double bad : {kNan, kInf, 0.0, -1.0}) {
    EXPECT_FALSE(mover.move(*world, {1, 0}, bad));
    EXPECT_FALSE(mover.set_position({0, bad == 0 || bad == -1 ? 2e9 : bad}));
    MoverDesc d;
    d.radius = bad;
    EXPECT_FALSE(Mover::sound(d));
    EXPECT_FALSE(mover.set_desc(d));
    Mover never(d, {0, 5});
    EXPECT_FALSE(never.move(*world, {1, 0}, kDt));
    EXPECT_EQ(never.position(), (Vec2{0, 5}));
  }
  double MoverDesc::*const of[] = {&MoverDesc::half_height, &MoverDesc::slope_limit, &MoverDesc::step_height,
                                   &MoverDesc::skin, &MoverDesc::push_force};
  for (const auto member : of) {
    for (const double bad : {kNan, kInf, -1.0}) {
      MoverDesc d;
      d.*member = bad;
      EXPECT_FALSE(mover.set_desc(d));
    }
  }
  MoverDesc d;
  d.up = {0, 0};
  EXPECT_FALSE(mover.set_desc(d));
  EXPECT_TRUE(same());
  EXPECT_TRUE(mover.move(*world, {1, 0}, kDt));
  EXPECT_FALSE(same());
}

// What it stood on may go, or be another body of the same index.
TEST(Mover, FallsWhenItsGroundGoes) {
  auto world = make(unbounded());
  const BodyId id = add(*world, block({0, 0}, 4, 1));
  Mover mover({}, {0, 1.5});
  walk(*world, mover, 0, 20);
  ASSERT_TRUE(mover.on_ground());
  world->remove_body(id);
  add(*world, block({50, 0}, 4, 1));
  walk(*world, mover, 0, 30);
  EXPECT_FALSE(mover.on_ground());
  EXPECT_LT(mover.position().y, 1);
  EXPECT_GT(mover.position().y, -1);
  EXPECT_NEAR(mover.position().x, 0, 1e-9);
}

}  // namespace
}  // namespace psim::test
