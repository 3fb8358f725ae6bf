// Who collides with whom: category, mask and group; for discs, fixed geometry and bodies with corners.
#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

BodyDesc with(BodyDesc body, Filter filter) {
  body.filter = filter;
  return body;
}

BodyDesc box(Vec2 position, double width, double height) {
  BodyDesc body;
  body.shape = BoxShape{width, height, 0};
  body.position = position;
  return body;
}

BodyDesc fixed(BodyDesc body) {
  body.type = BodyType::static_body;
  return body;
}

constexpr Filter kAll{};
constexpr Filter kGhost{1, 0, 0};
constexpr std::uint32_t kEvery = 0xFFFFFFFFu;

struct Rule {
  Filter a, b;
  bool meet;
};

const Rule kRules[] = {
    {kAll, kAll, true},
    {kAll, kGhost, false},
    {kGhost, kAll, false},
    {{2, kEvery, 0}, {4, kEvery, 0}, true},
    {{2, 4, 0}, {4, 2, 0}, true},
    {{2, 4, 0}, {4, 1, 0}, false},  // both must agree
    {{2, 1, 0}, {4, 2, 0}, false},
    {{2, 2, 0}, {2, 2, 0}, true},
    {{0x80000000u, 0x80000000u, 0}, {0x80000000u, 0x80000000u, 0}, true},
    {{0, kEvery, 0}, kAll, false},
    {{1, kEvery, -3}, {1, kEvery, -3}, false},
    {{1, kEvery, -3}, {1, kEvery, -4}, true},
    {{1, kEvery, -3}, {1, kEvery, 3}, true},
    {{1, 0, 5}, {1, 0, 5}, true},  // a common group is stronger than the masks
    {{1, 0, 5}, {1, 0, 6}, false},
    {{1, 0, 5}, kAll, false},
};

// A body falls on another: it is held or passes.
bool falls_through(BodyDesc above, BodyDesc below) {
  auto world = make(unbounded());
  if (below.type != BodyType::static_body) below.gravity_scale = 0, below.mass = 1e6;
  add(*world, below);
  const BodyId id = add(*world, above);
  run(*world, 90);
  return state(*world, id).y < -1;
}

TEST(Filters, DecideWhetherTwoDiscsMeet) {
  for (const Rule& rule : kRules) {
    EXPECT_EQ(falls_through(with(disc({0, 2}), rule.a), with(disc({0, 0}), rule.b)), !rule.meet) << &rule - kRules;
  }
}

TEST(Filters, DecideWhatFixedThingsHoldDiscs) {
  for (const Rule& rule : kRules) {
    const BodyDesc ball = with(disc({0, 2}), rule.a);
    for (const BodyDesc& floor : {segment({-1, 0}, {1, 0}), static_disc({0, 0}, 0.5),
                                  chain({{-1, 0.2}, {0, 0}, {1, 0.2}}), fixed(box({0, 0}, 4, 1))}) {
      EXPECT_EQ(falls_through(ball, with(floor, rule.b)), !rule.meet)
          << &rule - kRules << ", shape " << floor.shape.index();
    }
  }
}

TEST(Filters, DecideForBodiesWithCorners) {
  for (const Rule& rule : kRules) {
    const BodyDesc crate = with(box({0, 2}, 1, 1), rule.a);
    for (const BodyDesc& floor : {box({0, 0}, 3, 1), disc({0, 0}), fixed(box({0, 0}, 3, 1)), segment({-2, 0}, {2, 0}),
                                  static_disc({0, 0}, 0.5)}) {
      EXPECT_EQ(falls_through(crate, with(floor, rule.b)), !rule.meet)
          << &rule - kRules << ", shape " << floor.shape.index();
    }
    EXPECT_EQ(falls_through(with(disc({0, 2}), rule.a), with(box({0, 0}, 3, 1), rule.b)), !rule.meet) << &rule - kRules;
  }
}

TEST(Filters, DecideForKinematicBodies) {
  for (const Rule& rule : kRules) {
    for (BodyDesc floor : {disc({0, 0}), box({0, 0}, 3, 1)}) {
      floor.type = BodyType::kinematic_body;
      EXPECT_EQ(falls_through(with(disc({0, 2}), rule.a), with(floor, rule.b)), !rule.meet);
      EXPECT_EQ(falls_through(with(box({0, 2}, 1, 1), rule.a), with(floor, rule.b)), !rule.meet);
    }
  }
}

TEST(Filters, DoNotOpenTheWallsOfTheWorld) {
  auto world = make(walled({-5, -5, 5, 5}));
  const BodyId ball = add(*world, with(disc({0, 0}), kGhost));
  const BodyId crate = add(*world, with(box({2, 0}, 1, 1), kGhost));
  run(*world, 240);
  EXPECT_NEAR(state(*world, ball).y, -4.5, 0.01);
  EXPECT_NEAR(state(*world, crate).y, -4.5, 0.01);
}

TEST(Filters, OfTwoMixedGasesKeepThemApart) {
  // Two gases in one box that do not feel each other: as if each were alone. Bodies of one category
  // move as those of a world that has no others, since they have no other partners.
  const Material m = material(1);
  auto world = make(walled({0, 0, 30, 30}, {0, 0}, m));
  std::string error;
  for (int gas = 0; gas < 2; ++gas) {
    const Discs discs = lattice(100, {0, 0, 30, 30}, 0.5, 5, m, 0.5, static_cast<std::uint64_t>(gas));
    for (std::size_t k = 0; k < discs.size(); ++k) {
      const auto category = gas == 0 ? 2u : 4u;
      add(*world, with(disc({discs.x[k], discs.y[k]}, {discs.vx[k], discs.vy[k]}, 0.5, m), {category, category, 0}));
    }
  }
  world->set_event_options({true, true, 0, false});
  const double before = energy(*world);
  std::size_t events = 0, overlaps = 0;
  for (int frame = 0; frame < 200; ++frame) {
    world->step();
    for (const TouchEvent& t : world->events().begin) {
      EXPECT_EQ(t.a.index < 100, t.b.index < 100);
      ++events;
    }
    for (const HitEvent& h : world->events().hits) {
      EXPECT_TRUE(h.b == kNoBody || (h.a.index < 100) == (h.b.index < 100)) << frame;
      ++events;
    }
    const PublishedState s = world->published();
    for (const auto& pair : reference::pairs_closer_than(s.x, s.y, s.radius, -0.05)) {
      EXPECT_NE(s.id[pair.a] < 100, s.id[pair.b] < 100);
      ++overlaps;
    }
  }
  EXPECT_GT(events, 100u);
  EXPECT_GT(overlaps, 100u);
  EXPECT_NEAR(energy(*world), before, 1e-3 * before);
}

// Bodies that the lists link by such pairs alone are solved as they are, not as they were.
TEST(Filters, LetAGasOfGhostsFlyStraightOn) {
  auto world = make(periodic(40, 40));
  Random random(2);
  std::vector<Vec2> velocity;
  for (int k = 0; k < 40; ++k) {
    velocity.push_back({random.uniform(-6, 6), random.uniform(-6, 6)});
    add(*world, with(disc({random.uniform(0, 40), random.uniform(0, 40)}, velocity.back()), kGhost));
  }
  run(*world, 200);
  for (std::uint32_t id = 0; id < 40; ++id) {
    const BodyState s = state(*world, world->id_of(id));
    EXPECT_FLOAT_EQ(static_cast<float>(s.vx), static_cast<float>(velocity[id].x)) << id;
    EXPECT_FLOAT_EQ(static_cast<float>(s.vy), static_cast<float>(velocity[id].y)) << id;
  }
}

TEST(Filters, CostNothingWhereThereAreNone) {
  const auto planned = [](const World& world) {
    for (const PlanEntry& entry : world.plan()) {
      if (entry.stage == "filters") return entry.needed;
    }
    throw std::runtime_error("no such stage");
  };
  auto world = make(unbounded());
  add(*world, disc({0, 0}));
  EXPECT_FALSE(planned(*world));
  const BodyId ghost = add(*world, with(disc({3, 0}), kGhost));
  EXPECT_TRUE(planned(*world));
  world->remove_body(ghost);
  EXPECT_FALSE(planned(*world));
  const BodyId floor = add(*world, with(ground(), kGhost));
  EXPECT_TRUE(planned(*world));
  world->remove_body(floor);
  EXPECT_FALSE(planned(*world));
}

TEST(Filters, AreTheSameForEveryIsaAndThreadCount) {
  std::uint64_t first = 0;
  for (const Isa isa : available_isas()) {
    for (const int threads : thread_counts()) {
      auto world = make(walled({0, 0, 30, 60}), isa, threads);
      Random r(3);
      for (int k = 0; k < 400; ++k) {
        BodyDesc body = disc({r.uniform(1, 29), r.uniform(1, 59)}, {}, 0.4, material(0.2, 0.5));
        body.filter.category = 1u << r.below(3);
        body.filter.mask = static_cast<std::uint32_t>(1 + r.below(7));
        body.filter.group = static_cast<std::int32_t>(r.below(3)) - 1;
        add(*world, body);
      }
      run(*world, 120);
      if (first == 0) first = world->state_hash();
      EXPECT_EQ(world->state_hash(), first);
    }
  }
}

// ---- impulses at a point ------------------------------------------------------------------------

TEST(Impulses, AtAPointTurnABodyToo) {
  WorldDesc desc = unbounded(100, {0, 0});
  auto world = make(desc);
  BodyDesc body = box({2, 3}, 2, 1);
  body.angle = 0.7;
  body.mass = 3;
  const BodyId crate = add(*world, body);
  const double inertia = 3 * (2 * 2 + 1 * 1) / 12.0;
  ASSERT_TRUE(world->apply_impulse_at(crate, {0, 6}, {2.5, 3}));
  EXPECT_NEAR(state(*world, crate).vy, 2, 1e-6);
  EXPECT_NEAR(state(*world, crate).omega, 0.5 * 6 / inertia, 1e-5);
  ASSERT_TRUE(world->apply_angular_impulse(crate, -0.5 * 6));
  EXPECT_NEAR(state(*world, crate).omega, 0, 1e-6);
  const BodyId wheel = add(*world, disc({-5, 0}, {}, 0.5, material(0, 0, 2)));
  const double mass = 2 * kPi * 0.25;
  ASSERT_TRUE(world->apply_angular_impulse(wheel, 1));
  EXPECT_NEAR(state(*world, wheel).omega, 1 / (mass * 0.25 / 2), 1e-5);
  world->step();
  EXPECT_NEAR(state(*world, wheel).angle, world->desc().dt / (mass * 0.25 / 2), 1e-5);
  EXPECT_FALSE(world->apply_impulse_at({99, 0}, {1, 0}, {0, 0}));
  EXPECT_FALSE(world->apply_angular_impulse({99, 0}, 1));
}

TEST(Impulses, ActAboutTheCentreOfMass) {
  auto world = make(unbounded(100, {0, 0}));
  BodyDesc body;
  body.shape = PolygonShape{{{1, 0}, {4, 0}, {1, 3}}, 0};  // its centre at (2, 1)
  body.position = {10, 20};
  const BodyId wedge = add(*world, body);
  world->apply_impulse_at(wedge, {5, -7}, {12, 21});
  EXPECT_NEAR(state(*world, wedge).omega, 0, 1e-5);
}

TEST(Impulses, ReachAcrossTheSeam) {
  auto world = make(periodic(10, 10));
  const BodyId id = add(*world, disc({9.9, 5}));
  world->apply_impulse_at(id, {0, 1}, {0.1, 5});  // 0.2 to the right of it
  const double inertia = kPi * 0.25 * 0.25 / 2;
  EXPECT_NEAR(state(*world, id).omega, 0.2 / inertia, 1e-5);
}

TEST(Impulses, DoNotTurnWhatCannotTurn) {
  auto world = make(unbounded(100, {0, 0}));
  BodyDesc stiff = box({0, 0}, 2, 1);
  stiff.fixed_rotation = true;
  BodyDesc lift = box({5, 0}, 2, 1);
  lift.type = BodyType::kinematic_body;
  lift.angular_velocity = 1;
  for (const BodyDesc& body : {stiff, lift}) {
    const BodyId id = add(*world, body);
    const BodyState before = state(*world, id);
    world->apply_impulse_at(id, {0, 5}, {7, 7});
    world->apply_angular_impulse(id, 5);
    EXPECT_NEAR(state(*world, id).omega, before.omega, 1e-6);
    EXPECT_EQ(state(*world, id).vy == before.vy, body.type == BodyType::kinematic_body);
  }
  const BodyId broken = add(*world, disc({9, 9}));
  EXPECT_TRUE(world->apply_angular_impulse(broken, kNan));
  EXPECT_EQ(world->step().quarantined, 1u);
}

}  // namespace
}  // namespace psim::test
