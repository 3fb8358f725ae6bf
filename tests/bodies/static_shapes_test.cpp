// Static discs, segments and chains: smooth to roll over, tight to be inside of, solid from both
// sides.
#include "rigid_support.h"

namespace psim::test {
namespace {

/// Ground from -5 to 100 of pieces of one metre, as segments or as one chain.
void add_pieces(World& world, bool as_chain, Material m) {
  std::vector<Vec2> vertices;
  for (int k = -5; k <= 100; ++k) vertices.push_back({1.0 * k, 0});
  if (as_chain) {
    add(world, chain(vertices, false, m));
    return;
  }
  for (std::size_t k = 0; k + 1 < vertices.size(); ++k) add(world, segment(vertices[k], vertices[k + 1], m));
}

TEST(StaticShapes, SegmentsOfAnyLengthCarry) {
  for (const double reach : {50.0, 250.0, 300.0, 401.0, 1000.0, 1e6, 5e8}) {
    for (const double slope : {0.0, 0.2}) {
      SCOPED_TRACE(testing::Message() << reach << " slope " << slope);
      auto world = make(unbounded(100));
      add(*world, segment({-reach, -slope * reach}, {reach, slope * reach}));
      // Touching it, on both sides of the origin.
      const double above = 0.5 * std::hypot(1, slope);
      std::vector<BodyId> ids;
      for (const double x : {-40.0, 3.0, 40.0}) ids.push_back(add(*world, disc({x, slope * x + above})));
      run(*world, 60);
      for (const BodyId id : ids) {
        const BodyState s = state(*world, id);
        EXPECT_NEAR(s.y, slope * s.x + above, 2e-3);
      }
    }
  }
}

TEST(StaticShapes, PointsBeyondAllMeasureAreRefused) {
  auto world = make(unbounded(100));
  std::string error;
  for (const double far : {1.1e9, 1e151, kInf}) {
    BodyDesc chain = segment({-far, 0}, {far, 0});
    EXPECT_EQ(world->add_body(chain, error), kNoBody);
    EXPECT_TRUE(error.starts_with("vertex 0 must be from -1e9 to 1e9, not -")) << error;
    chain.shape = ChainShape{{{-far, 0}, {0, 1}, {far, 0}}, false};
    EXPECT_EQ(world->add_body(chain, error), kNoBody);
  }
  EXPECT_EQ(world->body_count(), 0u);
}

TEST(StaticShapes, DiscGlidesOverAHundredJointsUnmoved) {
  for (const Isa isa : available_isas()) {
    for (const bool as_chain : {false, true}) {
      SCOPED_TRACE(testing::Message() << isa_name(isa) << (as_chain ? " chain" : " segments"));
      auto world = make(unbounded(200), isa);
      add_pieces(*world, as_chain, {});
      const BodyId id = add(*world, disc({0, 0.5}, {4.7, 0}));
      run(*world, 120);
      const double level = state(*world, id).y;
      double bump = 0;
      for (int k = 0; k < 1000; ++k) {
        world->step();
        bump = std::max(bump, std::abs(state(*world, id).y - level));
      }
      EXPECT_GT(state(*world, id).x, 80);
      EXPECT_LT(bump, 1e-4);
      EXPECT_NEAR(state(*world, id).vx / 4.7, 1, 1e-5);
    }
  }
}

TEST(StaticShapes, DiscRollsOverAHundredJointsWithoutLoss) {
  for (const bool as_chain : {false, true}) {
    auto world = make(unbounded(200));
    add_pieces(*world, as_chain, material(0, 0.5));
    BodyDesc rolling = disc({0, 0.5}, {4.7, 0}, 0.5, material(0, 0.5));
    rolling.angular_velocity = -9.4;
    const BodyId id = add(*world, rolling);
    run(*world, 1100);
    EXPECT_NEAR(state(*world, id).vx / 4.7, 1, 1e-3) << as_chain;
    EXPECT_NEAR(state(*world, id).omega / -9.4, 1, 1e-3) << as_chain;
  }
}

TEST(StaticShapes, ElasticDiscBouncesTrueOnAJoint) {
  for (const bool as_chain : {false, true}) {
    auto world = make(unbounded(200));
    add_pieces(*world, as_chain, material(1));
    const BodyId id = add(*world, disc({7, 2}, {0.9, 0}, 0.5, material(1)));
    run(*world, 600);
    EXPECT_NEAR(state(*world, id).vx, 0.9, 1e-4) << as_chain;
  }
}

TEST(StaticShapes, DiscRestsInAV) {
  for (const bool as_chain : {false, true}) {
    auto world = make(unbounded());
    if (as_chain) {
      add(*world, chain({{-5, 5}, {0, 0}, {5, 5}}));
    } else {
      add(*world, segment({-5, 5}, {0, 0}));
      add(*world, segment({0, 0}, {5, 5}));
    }
    const BodyId id = add(*world, disc({0.4, 1.5}));
    run_seconds(*world, 60);
    EXPECT_NEAR(state(*world, id).x, 0, 0.01) << as_chain;
    EXPECT_NEAR(state(*world, id).y, 0.5 * std::sqrt(2.0), 0.01) << as_chain;
    EXPECT_NEAR(std::hypot(state(*world, id).vx, state(*world, id).vy), 0, 0.01) << as_chain;
  }
}

TEST(StaticShapes, DiscBalancesOnTheTipOfASegment) {
  // The end of a segment is a point: the disc's normal is from the point to its centre.
  auto world = make(unbounded());
  add(*world, segment({0, -5}, {0, 0}));
  const BodyId on_top = add(*world, disc({0, 0.5}));
  run_seconds(*world, 2);
  EXPECT_NEAR(state(*world, on_top).y, 0.5, 0.01);

  auto bounce = make(unbounded(100, {0, 0}));
  add(*bounce, segment({-5, 0}, {0, 0}, material(1)));
  // Comes down beside the end: hits the point at 45 degrees and leaves sideways.
  const double offset = 0.5 * std::sqrt(0.5);
  const BodyId id = add(*bounce, disc({offset, 2}, {0, -3}, 0.5, material(1)));
  run(*bounce, 120);
  EXPECT_NEAR(state(*bounce, id).vx, 3, 3e-4);
  EXPECT_NEAR(state(*bounce, id).vy, 0, 3e-4);
}

TEST(StaticShapes, SegmentsAreSolidFromBothSides) {
  auto world = make(unbounded(100, {0, 0}));
  add(*world, segment({-5, 0}, {5, 0}, material(1)));
  const BodyId above = add(*world, disc({-1, 2}, {0, -3}, 0.5, material(1)));
  const BodyId below = add(*world, disc({1, -2}, {0, 3}, 0.5, material(1)));
  run(*world, 60);
  EXPECT_NEAR(state(*world, above).vy, 3, 3e-4);
  EXPECT_NEAR(state(*world, below).vy, -3, 3e-4);
}

TEST(StaticShapes, PositionAndAngleMoveTheShape) {
  auto world = make(unbounded(100, {0, 0}));
  BodyDesc wall = segment({0, 0}, {10, 0}, material(1));
  wall.position = {5, -5};
  wall.angle = kPi / 2;  // upright at x = 5, from y = -5 to 5
  add(*world, wall);
  const BodyId id = add(*world, disc({2, 1}, {3, 0}, 0.5, material(1)));
  run(*world, 90);
  EXPECT_NEAR(state(*world, id).vx, -3, 3e-4);
  EXPECT_LT(state(*world, id).x, 4.5);
}

TEST(StaticShapes, ThinWallsHoldFastDiscs) {
  for (const double speed : {30.0, 100.0, 300.0}) {
    for (const double restitution : {0.0, 1.0}) {
      auto world = make(unbounded(1000, {0, 0}));
      add(*world, segment({0, -50}, {0, 50}, material(restitution)));
      std::vector<BodyId> ids;
      for (int k = 0; k < 40; ++k) {
        ids.push_back(add(*world, disc({-5 - 0.13 * k, -40.0 + 2 * k}, {speed, 0}, 0.1, material(restitution))));
      }
      run(*world, 60);
      for (const BodyId& id : ids) EXPECT_LT(state(*world, id).x, 0) << speed << " e " << restitution;
    }
  }
}

TEST(StaticShapes, BulletsDoNotPassThinWalls) {
  for (const double speed : {1e3, 1e4}) {
    auto world = make(unbounded(1000, {0, 0}));
    add(*world, segment({0, -50}, {0, 50}, material(1)));
    BodyDesc bullet = disc({-7, 0.3}, {speed, 0}, 0.1, material(1));
    bullet.bullet = true;
    const BodyId id = add(*world, bullet);
    for (int k = 0; k < 3 && world->is_valid(id); ++k) {
      world->step();
      ASSERT_TRUE(!world->is_valid(id) || state(*world, id).x < 0) << speed;
    }
  }
}

std::vector<Vec2> circle(double radius, int corners) {
  std::vector<Vec2> vertices;
  for (int k = 0; k < corners; ++k) {
    const double a = 2 * kPi * k / corners;
    vertices.push_back({radius * std::cos(a), radius * std::sin(a)});
  }
  return vertices;
}

TEST(StaticShapes, ALoopKeepsItsDiscsInside) {
  for (const Isa isa : available_isas()) {
    for (const double restitution : {0.0, 0.8}) {
      auto world = make(unbounded(50), isa, 2);
      add(*world, chain(circle(15, 32), true, material(restitution)));
      add(*world, lattice(200, {-9, -9, 9, 9}, 0.4, 5, material(restitution)));
      for (int k = 0; k < 600; ++k) {
        world->step();
        if (k % 20) continue;
        const PublishedState s = world->published();
        for (std::size_t row = 1; row < s.id.size(); ++row) {
          ASSERT_LT(std::hypot(s.x[row], s.y[row]), 15 - 0.35) << "frame " << k << " disc " << row;
        }
      }
      EXPECT_EQ(world->body_count(), 201u);
    }
  }
}

TEST(StaticShapes, AnElasticGasInALoopKeepsItsEnergy) {
  auto world = make(unbounded(50, {0, 0}));
  add(*world, chain(circle(15, 32), true, material(1)));
  add(*world, lattice(100, {-9, -9, 9, 9}, 0.4, 5, material(1)));
  const double start = world->diagnostics().kinetic;
  run(*world, 600);
  EXPECT_NEAR(world->diagnostics().kinetic / start, 1, 1e-3);
}

TEST(StaticShapes, DiscRollsThroughABowlAndBack) {
  // Frictionless bowl of 100 pieces: comes up again to where it was let go.
  std::vector<Vec2> bowl;
  for (int k = 0; k <= 200; ++k) {
    const double a = kPi + kPi * k / 200;
    bowl.push_back({10 * std::cos(a), 10 * std::sin(a)});
  }
  auto world = make(unbounded());
  add(*world, chain(bowl));
  const double a = kPi + 0.8;
  const BodyId id = add(*world, disc({9.499 * std::cos(a), 9.499 * std::sin(a)}));
  const double start = state(*world, id).y;
  double highest = -100;
  for (int k = 0; k < 600; ++k) {
    world->step();
    if (state(*world, id).x > 0) highest = std::max(highest, state(*world, id).y);
  }
  const double depth = start + 9.5;
  EXPECT_GT(highest, start - 0.02 * depth);
  EXPECT_LT(highest, start + 0.01 * depth);
}

TEST(StaticShapes, ManySmallDiscsDrainThroughAGap) {
  // A funnel: whoever is above the gap comes out below it, none elsewhere.
  auto world = make(walled({-20, -20, 20, 20}));
  add(*world, chain({{-20, 10}, {-2, 0}}));
  add(*world, chain({{20, 10}, {2, 0}}));
  add(*world, lattice(150, {-8, 10, 8, 19}, 0.3, 0, {}));
  for (int k = 0; k < 600; ++k) {
    world->step();
    if (k % 10) continue;
    const PublishedState s = world->published();
    for (std::size_t row = 2; row < s.id.size(); ++row) {
      if (s.y[row] > 0 && std::abs(s.x[row]) > 2) {
        ASSERT_GT(s.y[row] - (std::abs(s.x[row]) - 2) * 10 / 18, 0.2) << "frame " << k;
      }
    }
  }
  EXPECT_TRUE(all_inside(*world));
}

// Wide floors, one above the other: a body is near the one on which it lies, and not near those whose boxes are far away,
// however wide they are.
TEST(StaticShapes, WideBoxesAreNearNobodyFarAbove) {
  constexpr int kFloors = 12, kBodies = 10;
  for (const double angle : {0.0, 0.5 * kPi}) {  // as a box that is turned, too
    for (const Boundary boundary : {Boundary::open, Boundary::periodic}) {
      WorldDesc desc = unbounded(200);
      if (boundary == Boundary::periodic) desc = periodic(400, 400);
      desc.gravity = {0, -kG};
      const double middle = boundary == Boundary::periodic ? 200 : 0;
      auto world = make(desc);
      for (int floor = 0; floor < kFloors; ++floor) {
        const double y = middle + 12.0 * floor - 70;
        const Vec2 at{middle, y - 0.25};
        const BodyDesc plate = angle == 0 ? box(at, 180, 0.5) : turned(box(at, 0.5, 180), angle);
        add(*world, fixed(plate));
        for (int k = 0; k < kBodies; ++k) add(*world, box({middle + 8.0 * k - 40, y + 0.5}, 1, 1));
      }
      EXPECT_EQ(world->step().pairs, static_cast<std::uint64_t>(kFloors * kBodies));
      run(*world, 30);
      for (const psim::Contact& c : world->contacts()) EXPECT_NEAR(c.separation, 0, 0.001);
    }
  }
}

}  // namespace
}  // namespace psim::test
