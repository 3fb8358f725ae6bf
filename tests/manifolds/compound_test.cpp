// Bodies of several shapes: they move as what they are put together to, each shape has its own material, and queries,
// contacts, sleep and saved states know them.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

ShapePart part(PartShape shape, Vec2 position = {}, double angle = 0) { return {std::move(shape), position, angle}; }

BodyDesc compound(std::vector<ShapePart> parts, Vec2 position, Material m = {}) {
  BodyDesc body;
  body.shape = CompoundShape{std::move(parts)};
  body.position = position;
  body.material = m;
  return body;
}

// Two legs of different masses that reach 1 m below a beam.
BodyDesc table(Vec2 position, Material m = {}) {
  std::vector<ShapePart> parts{part(BoxShape{3, 0.2}), part(BoxShape{0.2, 1}, {-1.3, -0.5}),
                               part(BoxShape{0.4, 1}, {1.2, -0.5})};
  return compound(std::move(parts), position, m);
}

// What holds a body up, N.
double load_on(World& world, BodyId id) {
  double sum = 0;
  for (const Contact& c : world.contacts()) {
    if (c.b == id) sum += c.impulse * c.normal.y;
    if (c.a == id) sum -= c.impulse * c.normal.y;
  }
  return sum / world.desc().dt;
}

TEST(Compound, TwoHalvesMoveAsTheWhole) {
  std::vector<Vec2> end;
  for (const bool halves : {false, true}) {
    auto world = make(unbounded(50));
    add(*world, ground(material(0.3, 0.5)));
    BodyDesc body = box({0, 4}, 2, 0.6, material(0.3, 0.5));
    if (halves) body.shape = CompoundShape{{part(BoxShape{1, 0.6}, {-0.5, 0}), part(BoxShape{1, 0.6}, {0.5, 0})}};
    const BodyId id = add(*world, moving(turned(body, 0.1), {1, 0}, 0.2));
    run(*world, 50);  // in flight
    const BodyState s = state(*world, id);
    end.push_back({s.x, s.angle});
    run(*world, 400);
    EXPECT_NEAR(state(*world, id).y, 0.3, 2e-3);
  }
  EXPECT_NEAR(end[0].x, end[1].x, 1e-6);
  EXPECT_NEAR(end[0].y, end[1].y, 1e-6);
}

TEST(Compound, TurnsAboutTheCentreOfMassOfItsParts) {
  // A light rod with a heavy disc at one end.
  BodyDesc hammer = compound({part(BoxShape{2, 0.1}), part(DiscShape{0.3}, {1, 0})}, {0, 0});
  std::get<CompoundShape>(hammer.shape).parts[1].density = 8;
  const double rod = 0.2, head = 8 * kPi * 0.09, centre = head / (rod + head);
  auto world = make(unbounded(50, {0, 0}));
  const BodyId id = add(*world, moving(hammer, {0, 0}, 3));
  for (int k = 0; k < 60; ++k) {
    run(*world, 1);
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.x + centre * std::cos(s.angle), centre, 2e-5);
    EXPECT_NEAR(s.y + centre * std::sin(s.angle), 0, 2e-5);
  }
  // The inertia about that centre takes an impulse with the arm to the other end.
  const double inertia = rod * (4.01 / 12 + centre * centre) + head * (0.045 + (1 - centre) * (1 - centre));
  auto still = make(unbounded(50, {0, 0}));
  const BodyId other = add(*still, hammer);
  EXPECT_TRUE(still->apply_impulse_at(other, {0, 1}, {-1, 0}));
  EXPECT_NEAR(state(*still, other).omega, -(1 + centre) / inertia, 1e-5);
}

TEST(Compound, StandsOnItsLegsAndEachBearsItsShare) {
  for (const Isa isa : available_isas()) {
    WorldDesc desc = unbounded(50);
    desc.sleeping = false;
    auto world = make(desc, isa);
    add(*world, ground(material(0, 0.6)));
    const BodyId id = add(*world, table({0, 1}, material(0, 0.6)));
    run(*world, 240);
    EXPECT_NEAR(state(*world, id).y, 1, 2e-3);
    EXPECT_NEAR(state(*world, id).angle, 0, 1e-3);
    const double beam = 0.6, left = 0.2, right = 0.4, mass = beam + left + right;
    EXPECT_NEAR(load_on(*world, id), mass * kG, 0.01 * mass * kG);
    double moment = 0;
    for (const Contact& c : world->contacts()) moment += c.impulse * c.point.x / desc.dt;
    EXPECT_NEAR(moment, (1.2 * right - 1.3 * left) * kG, 0.02 * mass * kG);
  }
}

TEST(Compound, HoldsWhatLiesInIt) {
  auto world = make(unbounded(50));
  add(*world, ground(material(0, 0.5)));
  const BodyId tray =
      add(*world,
          compound({part(BoxShape{2, 0.2}), part(BoxShape{0.2, 1}, {-0.9, 0.6}), part(BoxShape{0.2, 1}, {0.9, 0.6})},
                   {0, 0.1}, material(0, 0.5)));
  const BodyId ball = add(*world, disc({0.3, 3}, {0.5, 0}, 0.3));
  run(*world, 400);
  EXPECT_NEAR(state(*world, ball).y, 0.5, 3e-3);
  EXPECT_LT(std::fabs(state(*world, ball).x - state(*world, tray).x), 0.51);  // the ball pushes the tray a little
}

TEST(Compound, PartsHaveTheirOwnMaterial) {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body}) {
    BodyDesc floor = compound({part(BoxShape{4, 1}, {-2, -0.5}), part(BoxShape{4, 1}, {2, -0.5})}, {0, 0});
    floor.type = type;
    std::get<CompoundShape>(floor.shape).parts[1].restitution = 0.8;
    std::get<CompoundShape>(floor.shape).parts[1].friction = 0.5;
    WorldDesc desc = unbounded(50);
    desc.sleeping = false;
    auto world = make(desc);
    add(*world, floor);
    const BodyId dull = add(*world, disc({-0.6, 3})), lively = add(*world, disc({2, 3}));
    const BodyId slides = add(*world, moving(box({-3.7, 0.25}, 0.5, 0.5, material(0, 0.5)), {1, 0}));
    double top_dull = 0, top_lively = 0;
    for (int k = 0; k < 120; ++k) {
      run(*world, 1);
      if (k < 50) continue;
      top_dull = std::max(top_dull, state(*world, dull).y);
      top_lively = std::max(top_lively, state(*world, lively).y);
    }
    EXPECT_NEAR(top_dull, 0.5, 5e-3);
    EXPECT_NEAR(top_lively, 0.5 + 0.64 * 2.5, 0.05);
    EXPECT_NEAR(state(*world, slides).vx, 1, 1e-3);  // no friction there
  }
}

TEST(Compound, PartsThatMoveBounceEachAsTheyAre) {
  for (const double e : {0.0, 0.9}) {
    auto world = make(unbounded(50));
    add(*world, ground());
    BodyDesc body = compound({part(BoxShape{1, 0.4}, {0, 0.5}), part(BoxShape{1, 0.4}, {0, -0.5})}, {0, 3});
    std::get<CompoundShape>(body.shape).parts[e > 0 ? 1 : 0].restitution = 0.9;
    const BodyId id = add(*world, body);
    double top = 0;
    for (int k = 0; k < 90; ++k) {
      run(*world, 1);
      if (k > 45) top = std::max(top, state(*world, id).y);
    }
    EXPECT_NEAR(top, 0.7 + e * e * 2.3, 0.05) << "the lower part meets the ground";
  }
}

TEST(Compound, SleepsAndWakesWithItsLoads) {
  auto world = make(unbounded(50));
  add(*world, ground(material(0, 0.6)));
  const BodyId low = add(*world, table({0, 1}, material(0, 0.6))),
               high = add(*world, table({0.1, 2.1}, material(0, 0.6)));
  run(*world, 600);
  ASSERT_FALSE(world->is_awake(low));
  ASSERT_FALSE(world->is_awake(high));
  const double weight = 1.2 * kG;
  EXPECT_NEAR(load_on(*world, high), weight, 0.02 * weight) << "asleep";
  EXPECT_NEAR(load_on(*world, low), weight, 0.04 * weight) << "asleep";
  const double y = state(*world, high).y;
  world->wake(low);
  run(*world, 1);
  EXPECT_NEAR(load_on(*world, high), weight, 0.05 * weight) << "awake again";
  run(*world, 30);
  EXPECT_NEAR(state(*world, high).y, y, 1e-3);
}

TEST(Compound, QueriesSeeEachPart) {
  auto world = make(unbounded(50, {0, 0}));
  const BodyId id = add(*world, table({0, 1}));
  const auto hit = world->ray_cast({-5, 0.5}, {5, 0.5});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, id);
  EXPECT_NEAR(hit->point.x, -1.4, 1e-6);
  EXPECT_FALSE(world->ray_cast({0, 0.8}, {0, -5})) << "between the legs";
  EXPECT_TRUE(world->overlap(DiscShape{0.2}, {0, 0.5}, 0).empty());
  const Shape cross = CompoundShape{{part(BoxShape{0.1, 4}), part(BoxShape{4, 0.1}, {0, -1})}};
  EXPECT_EQ(world->overlap(cross, {0, 0.5}, 0).size(), 1u);
  EXPECT_TRUE(world->overlap(cross, {0, -2.5}, 0).empty());
}

TEST(Compound, NothingThatIsFastPassesIt) {
  auto world = make(unbounded(200, {0, 0}));
  BodyDesc fork = compound({part(BoxShape{0.1, 6}, {-2, 0}), part(BoxShape{0.1, 6}, {2, 0})}, {0, 0});
  fork.type = BodyType::static_body;
  add(*world, fork);
  const BodyId dumbbell = add(
      *world, moving(compound({part(DiscShape{0.2}, {-0.8, 0}), part(DiscShape{0.2}, {0.8, 0})}, {0, 0}, material(1)),
                     {700, 30}, 40));
  for (int k = 0; k < 20; ++k) {
    run(*world, 1);
    const BodyState s = state(*world, dumbbell);
    if (std::fabs(s.y) > 2.2) break;
    for (const double side : {-0.8, 0.8}) EXPECT_LT(std::fabs(s.x + side * std::cos(s.angle)), 2.0) << k;
  }
}

// A body of a box, of which a ball hangs below; each has something of its own.
BodyDesc lantern(Vec2 position) {
  return compound({part(BoxShape{1, 0.4}), part(DiscShape{0.3}, {0, -0.8})}, position, material(0, 0.5));
}
ShapePart& part_of(BodyDesc& body, std::size_t k) { return std::get<CompoundShape>(body.shape).parts.at(k); }

TEST(Compound, EachPartCollidesByItsOwnFilter) {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    for (const bool sensor : {false, true}) {
      for (const bool ghostly_floor : {false, true}) {
        auto world = make(unbounded(50));
        BodyDesc floor = compound({part(BoxShape{8, 1}, {0, -0.5}), part(BoxShape{8, 0.2}, {0, 0.5})}, {0, 0},
                                  material(0, 0.5, 1000));
        floor.type = type;
        if (type == BodyType::dynamic_body) add(*world, fixed(box({0, -1.5}, 9, 1)));
        BodyDesc body = lantern({0, 3});
        body.bullet = true;
        ShapePart& ghost = part_of(ghostly_floor ? floor : body, 1);
        if (sensor) {
          ghost.sensor = true;
        } else {
          ghost.filter = Filter{1, ghostly_floor ? 2u : 0u, 0};
        }
        add(*world, floor);
        const BodyId slow = add(*world, body);
        body.position = {2.5, 3};
        const BodyId fast = add(*world, moving(body, {0, -900}));
        run(*world, 300);
        // Of the floor the upper slab, or of the lantern the ball, is not there for the other one.
        const double height = ghostly_floor ? 1.1 : 0.8;
        EXPECT_NEAR(state(*world, slow).y, height, 0.01) << static_cast<int>(type) << sensor;
        EXPECT_NEAR(state(*world, fast).y, height, 0.02) << static_cast<int>(type) << sensor;
      }
    }
  }
}

TEST(Compound, SensorsOfBodiesTellWhoIsInThem) {
  auto world = make(unbounded(50));
  world->set_event_options({.sensors = true});
  const BodyId floor = add(*world, ground(material(0, 0.5)));
  BodyDesc guard = compound({part(BoxShape{1, 1}, {0, 0.5}), part(DiscShape{3})}, {0, 0}, material(0, 0.5));
  part_of(guard, 1).sensor = true;
  const BodyId id = add(*world, guard);
  const BodyId guest = add(*world, moving(box({6, 0.25}, 0.5, 0.5), {-4, 0}));
  std::vector<std::pair<int, BodyId>> seen;
  for (int k = 0; k < 90; ++k) {
    run(*world, 1);
    const Events e = world->events();
    for (const TouchEvent& t : e.sensor_begin) {
      EXPECT_EQ(t.a, id);
      seen.emplace_back(k, t.b);
    }
  }
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].second, floor);
  EXPECT_EQ(seen[1].second, guest);
  EXPECT_NEAR(seen[1].first, (6 - 3 - 0.25) / 4 * 60, 3) << "when it comes into reach";
  EXPECT_NEAR(state(*world, guest).x, 0.75, 0.02) << "it is stopped by the box alone";
  EXPECT_TRUE(world->remove_body(guest));
  run(*world, 1);
  EXPECT_EQ(world->events().sensor_end.size(), 1u);
}

TEST(Compound, QueriesAskEachPart) {
  auto world = make(unbounded(50, {0, 0}));
  BodyDesc body = lantern({0, 0});
  part_of(body, 0).filter = Filter{4, ~0u, 0};
  part_of(body, 1).sensor = true;
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    body.type = type;
    const BodyId id = add(*world, body);
    const auto box = world->ray_cast({-5, 0}, {5, 0}, {.mask = 4});
    ASSERT_TRUE(box);
    EXPECT_NEAR(box->point.x, -0.5, 1e-6);
    EXPECT_FALSE(world->ray_cast({-5, 0}, {5, 0}, {.mask = 3}));
    EXPECT_FALSE(world->ray_cast({-5, -0.8}, {5, -0.8}));
    const auto ball = world->ray_cast({-5, -0.8}, {5, -0.8}, {.mask = 1, .sensors = true});
    ASSERT_TRUE(ball);
    EXPECT_NEAR(ball->point.x, -0.3, 1e-6);
    EXPECT_TRUE(world->overlap(DiscShape{0.1}, {0, -0.8}, 0).empty());
    EXPECT_EQ(world->overlap(DiscShape{0.1}, {0, -0.8}, 0, {.sensors = true}).size(), 1u);
    EXPECT_NEAR(world->closest({0, -2}, 5)->distance, 1.8, 1e-6);
    EXPECT_TRUE(world->remove_body(id));
  }
}

TEST(Compound, IsRefusedWithThePartThatIsWrong) {
  auto world = make(unbounded(50));
  const auto refusal = [&](BodyDesc body) {
    std::string error;
    EXPECT_EQ(world->add_body(body, error), kNoBody);
    return error;
  };
  const auto has = [](const std::string& text, const char* words) { return text.find(words) != std::string::npos; };
  EXPECT_TRUE(has(refusal(compound({}, {})), "1 part or more"));
  EXPECT_TRUE(has(refusal(compound({part(BoxShape{1, 1}), part(BoxShape{1, 0})}, {})), "part 1: height"));
  EXPECT_TRUE(has(refusal(compound({part(BoxShape{1, 1}, {kNan, 0})}, {})), "part 0: position"));
  EXPECT_TRUE(has(refusal(compound({part(ChainShape{{{0, 0}, {1, 0}}})}, {})), "a chain is static or kinematic"));
  BodyDesc dense = compound({part(BoxShape{1, 1}), part(DiscShape{1})}, {});
  std::get<CompoundShape>(dense.shape).parts[1].density = 0;
  EXPECT_TRUE(has(refusal(dense), "part 1: density"));
  std::get<CompoundShape>(dense.shape).parts[1].density = 1;
  std::get<CompoundShape>(dense.shape).parts[0].friction = -1;
  EXPECT_TRUE(has(refusal(fixed(dense)), "part 0: friction"));
  EXPECT_EQ(world->body_count(), 0u);
}

// Saved, sent and replayed, and the same on every instruction set and any number of threads.
TEST(Compound, GoesOnWithTheSameBits) {
  std::vector<std::uint64_t> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = make(unbounded(50), isa, threads);
      Recorder recorder(*world);
      std::string error;
      recorder.add_body(ground(material(0.2, 0.5)), error);
      for (int k = 0; k < 40; ++k) {
        BodyDesc body = turned(table({3.4 * (k % 5) - 7, 2 + 3.4 * (k / 5)}, material(0.1, 0.5)), 0.7 * k);
        part_of(body, 1).friction = 0.1;
        if (k % 3 == 0) part_of(body, 2).filter = Filter{2, 1, 0};
        if (k % 7 == 0) part_of(body, 0).sensor = true;
        recorder.add_body(body, error);
      }
      for (int k = 0; k < 60; ++k) recorder.step();
      std::vector<std::byte> state;
      world->save(state);
      auto other = World::from_state(state, {isa, threads}, error);
      ASSERT_TRUE(other) << error;
      for (int k = 0; k < 200; ++k) {
        recorder.step();
        other->step();
      }
      EXPECT_EQ(world->state_hash(), other->state_hash());
      const auto replay = Replay::open(recorder.recording(), {isa, threads}, error);
      ASSERT_TRUE(replay) << error;
      while (replay->next()) {
      }
      EXPECT_TRUE(replay->complete() && replay->differs_at() == 0);
      first.push_back(world->state_hash());
      EXPECT_EQ(first.back(), first.front()) << isa_name(isa) << ' ' << threads;
      for (const Contact& c : world->contacts()) EXPECT_GT(c.separation, -0.03);
    }
  }
}

}  // namespace
}  // namespace psim::test
