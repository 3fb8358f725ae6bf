// World::contacts: who touches whom, where and how hard, against what mechanics says.
#include <map>

#include "rigid_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

bool same(const Contact& a, const Contact& b) {
  return a.a == b.a && a.b == b.b && a.point.x == b.point.x && a.point.y == b.point.y && a.normal.x == b.normal.x &&
         a.normal.y == b.normal.y && a.separation == b.separation && a.impulse == b.impulse && a.friction == b.friction;
}

std::vector<Contact> listed(World& world) {
  const std::span<const Contact> c = world.contacts();
  return {c.begin(), c.end()};
}

/// Sum of the impulses that come from below, walls and bodies of `ground`.
double borne(World& world, std::uint32_t ground = kNoBody.index) {
  double sum = 0;
  for (const Contact& c : world.contacts()) {
    if (c.b.index == ground) sum -= c.impulse * c.normal.y + c.friction * c.normal.x;  // on a
    if (c.a.index == ground && ground != kNoBody.index) sum += c.impulse * c.normal.y + c.friction * c.normal.x;
  }
  return sum;
}

WorldDesc awake(WorldDesc desc) {
  desc.sleeping = false;
  return desc;
}

/// Every contact is what the bodies' places say.
void expect_sound(World& world) {
  const Contact* before = nullptr;
  for (const Contact& c : world.contacts()) {
    EXPECT_NEAR(std::hypot(c.normal.x, c.normal.y), 1, 1e-6);
    EXPECT_GE(c.impulse, 0);
    EXPECT_TRUE(world.is_valid(c.a));
    EXPECT_TRUE(c.b == kNoBody || world.is_valid(c.b));
    EXPECT_LT(c.a.index, c.b.index);
    if (before != nullptr) {
      EXPECT_LE(std::pair(before->a.index, before->b.index), std::pair(c.a.index, c.b.index));
    }
    before = &c;
    // The point lies on the surface of either, but for half the separation; the normal goes from a to b.
    for (const BodyId id : {c.a, c.b}) {
      if (id == kNoBody || state(world, id).type == BodyType::static_body) continue;
      const BodyState s = state(world, id);
      const double x = c.point.x - s.x, y = c.point.y - s.y;
      EXPECT_LE(std::hypot(x, y), 1.01 * s.radius + std::fabs(c.separation)) << c.a.index << " " << c.b.index;
      EXPECT_GT((x * c.normal.x + y * c.normal.y) * (id == c.a ? 1 : -1), 0) << c.a.index << " " << c.b.index;
    }
  }
}

TEST(Contacts, ADiscAtRestIsHeldByItsWeight) {
  for (const bool wall : {true, false}) {
    for (const double mass : {1.0, 7.0}) {
      auto world = make(awake(walled({-10, 0, 10, 10})));
      const std::uint32_t floor = wall ? kNoBody.index : add(*world, fixed(box({0, 1}, 8, 1))).index;
      BodyDesc body = disc({1, wall ? 0.5 : 2.0});
      body.mass = mass;
      const BodyId id = add(*world, body);
      EXPECT_TRUE(world->contacts().empty());
      run(*world, 60);
      const std::vector<Contact> c = listed(*world);
      ASSERT_EQ(c.size(), 1u);
      EXPECT_NEAR(c[0].impulse, mass * kG / 60, 1e-4 * mass * kG / 60);
      EXPECT_EQ(c[0].friction, 0);
      EXPECT_EQ(wall ? c[0].a : c[0].b, id);
      EXPECT_EQ((wall ? c[0].b : c[0].a).index, floor);
      EXPECT_NEAR(c[0].normal.y, wall ? -1 : 1, 1e-6);  // from a to b
      EXPECT_NEAR(c[0].point.x, 1, 1e-6);
      EXPECT_NEAR(c[0].point.y, wall ? 0 : 1.5, 1e-3);
      EXPECT_NEAR(c[0].separation, 0, 1e-3);
    }
  }
}

TEST(Contacts, AStackOfThreeCarriesThreeTwoOne) {
  for (const bool boxes : {false, true}) {
    for (const double friction : {0.0, 0.5}) {
      auto world = make(awake(walled({-10, 0, 10, 10}, {0, -kG}, material(0, friction))));
      std::vector<BodyId> ids;
      for (int k = 0; k < 3; ++k) {
        const Vec2 at{0, 0.5 + k};
        ids.push_back(
            add(*world, boxes ? box(at, 1, 1, material(0, friction)) : disc(at, {}, 0.5, material(0, friction))));
      }
      run(*world, 120);
      const double mass = boxes ? 1 : kPi / 4, weight = mass * kG / 60;
      std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<double, int>> sum;
      for (const Contact& c : world->contacts()) {
        auto& [impulse, points] = sum[{c.a.index, c.b.index}];
        impulse += c.impulse;
        ++points;
        EXPECT_NEAR(c.normal.x, 0, 1e-5);
      }
      ASSERT_EQ(sum.size(), 3u);
      const std::pair<std::uint32_t, std::uint32_t> joints[] = {
          {ids[0].index, kNoBody.index}, {ids[0].index, ids[1].index}, {ids[1].index, ids[2].index}};
      for (int k = 0; k < 3; ++k) {
        ASSERT_TRUE(sum.contains(joints[k]));
        EXPECT_NEAR(sum[joints[k]].first, (3 - k) * weight, 1e-3 * weight) << k;
        EXPECT_EQ(sum[joints[k]].second, boxes ? 2 : 1);
      }
    }
  }
}

TEST(Contacts, ABoxOnAFloorHasTwoPointsThatBearIt) {
  auto world = make(awake(walled({-10, -10, 10, 10})));
  const BodyId floor = add(*world, fixed(box({0, -0.5}, 20, 1)));
  const BodyId id = add(*world, box({3, 0.5}, 2, 1, {}, 5));
  run(*world, 60);
  const std::vector<Contact> c = listed(*world);
  ASSERT_EQ(c.size(), 2u);
  double left = 1e9, right = -1e9;
  for (const Contact& point : c) {
    EXPECT_EQ(point.a, floor);
    EXPECT_EQ(point.b, id);
    EXPECT_NEAR(point.normal.y, 1, 1e-6);
    EXPECT_NEAR(point.point.y, 0, 1e-3);
    EXPECT_NEAR(point.impulse, 2.5 * kG / 60, 1e-3);
    left = std::min(left, point.point.x);
    right = std::max(right, point.point.x);
  }
  EXPECT_NEAR(left, 2, 1e-3);
  EXPECT_NEAR(right, 4, 1e-3);
}

TEST(Contacts, FrictionHoldsABoxOnASlope) {
  const double angle = 0.3;
  auto world = make(awake(unbounded(50)));
  add(*world, turned(fixed(box({0, 0}, 20, 1, material(0, 0.8))), angle));
  const double across = 1.0;  // centre to centre
  add(*world, turned(box({-across * std::sin(angle), across * std::cos(angle)}, 1, 1, material(0, 0.8)), angle));
  run(*world, 120);
  double normal = 0, along = 0;
  for (const Contact& c : world->contacts()) {
    normal += c.impulse;
    along += c.friction;
    EXPECT_NEAR(c.normal.x, -std::sin(angle), 1e-4);
    EXPECT_LE(std::fabs(c.friction), 0.8 * c.impulse + 1e-6);
  }
  EXPECT_NEAR(normal, kG / 60 * std::cos(angle), 1e-3);
  // Along (-n.y, n.x), which points down the slope: friction holds it back.
  EXPECT_NEAR(along, -kG / 60 * std::sin(angle), 1e-3);
}

// The mean load on the floor of a bin, over 200 steps, once 50 discs and four boxes lie in it. The boxes start `shift` m
// further to the right.
double load_of_pile(double friction, bool sleeping, double shift) {
  WorldDesc desc = unbounded(60);
  desc.sleeping = sleeping;
  auto world = make(desc);
  const Material m = material(0, friction);
  const BodyId bin = add(*world, chain({{0, 9}, {0, 0}, {9, 0}, {9, 9}}, false, m));
  add(*world, lattice(50, {0.5, 0.5, 8.5, 8.5}, 0.5, 0, m));
  for (int k = 0; k < 4; ++k) add(*world, box({2.0 + shift + 1.5 * k, 10}, 1, 1, m));
  run(*world, 900);
  double mean = 0;
  for (int k = 0; k < 200; ++k) {
    world->step();
    mean += borne(*world, bin.index) / 200;
  }
  expect_sound(*world);
  return mean;
}

constexpr double kWeightOfPile = (50 * kPi / 4 + 4) * kG / 60;

TEST(Contacts, AFloorBearsTheWeightOfAPile) {
  const double w = kWeightOfPile;
  EXPECT_NEAR(load_of_pile(0.0, false, 0), w, 0.02 * w);  // without friction it creeps
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(load_of_pile(0.4, false, 1e-3 * k), w, 1e-4 * w) << k;
}

// Each contact that sleeps keeps what it carried in the step in which a side of it fell asleep, and these steps differ. So
// the load of one pile is that of no single step, and time does not average it: it is off by 1e-3, or three times that in
// one start of 30. The mean of the starts is right.
TEST(Contacts, AFloorBearsTheWeightOfPilesThatSleep) {
  const double w = kWeightOfPile;
  constexpr int kStarts = 16;
  double mean = 0, square = 0;
  for (int k = 0; k < kStarts; ++k) {
    const double off = load_of_pile(0.4, true, 1e-3 * (k + 1)) / w - 1;
    mean += off / kStarts;
    square += off * off / kStarts;
  }
  EXPECT_LT(std::fabs(mean), 1e-3);
  EXPECT_LT(std::sqrt(square), 2e-3);
}

TEST(Contacts, AreAsManyAsTheReportCounts) {
  WorldDesc desc = awake(walled({0, 0, 12, 40}, {0, -kG}, material(0, 0.3)));
  auto world = make(desc);
  add(*world, lattice(60, {0.5, 0.5, 11.5, 12}, 0.5, 1, material(0, 0.3)));
  for (int k = 0; k < 5; ++k) add(*world, box({1.5 + 2 * k, 14}, 1.2, 0.8, material(0, 0.3)));
  for (int k = 0; k < 240; ++k) {
    const StepReport report = world->step();
    ASSERT_EQ(world->contacts().size(), report.contacts) << k;
  }
  expect_sound(*world);
}

// Newton's second law for each body, from its contacts alone.
TEST(Contacts, HoldEveryBodyOfAPileUp) {
  auto world = make(awake(walled({0, 0, 8, 40}, {0, -kG}, material(0, 0.5))));
  add(*world, lattice(30, {0.5, 0.5, 7.5, 8}, 0.5, 0, material(0, 0.5)));
  for (int k = 0; k < 6; ++k) add(*world, box({1.0 + k, 10}, 0.8, 0.8, material(0, 0.5)));
  run(*world, 1500);
  std::map<std::uint32_t, Vec2> on;
  for (const Contact& c : world->contacts()) {
    const Vec2 j{c.impulse * c.normal.x - c.friction * c.normal.y, c.impulse * c.normal.y + c.friction * c.normal.x};
    on[c.a.index].x -= j.x, on[c.a.index].y -= j.y;
    on[c.b.index].x += j.x, on[c.b.index].y += j.y;
  }
  for (std::uint32_t id = 0; id < 36; ++id) {
    const double weight = (id < 30 ? kPi / 4 : 0.64) * kG / 60;
    EXPECT_NEAR(on[id].x, 0, 0.05 * weight) << id;
    EXPECT_NEAR(on[id].y, weight, 0.05 * weight) << id;
  }
}

TEST(Contacts, SleepersKeepTheirs) {
  auto world = make(walled({-10, 0, 10, 10}, {0, -kG}, material(0, 0.5)));
  for (int k = 0; k < 3; ++k) add(*world, box({0, 0.5 + k}, 1, 1, material(0, 0.5)));
  add(*world, disc({3, 0.5}, {}, 0.5, material(0, 0.5)));
  std::vector<Contact> before = listed(*world);
  int frames = 0;
  for (; frames < 600 && world->step().asleep < 4; ++frames) {
    ASSERT_TRUE(frames == 0 || world->contacts().size() == 7u) << frames;
    before = listed(*world);
  }
  ASSERT_LT(frames, 600);
  for (int k = 0; k < 3; ++k) {  // in the step in which they fell asleep, and later
    const std::vector<Contact> now = listed(*world);
    ASSERT_EQ(now.size(), before.size());
    for (std::size_t n = 0; n < now.size(); ++n) {
      EXPECT_EQ(now[n].a, before[n].a);
      EXPECT_EQ(now[n].b, before[n].b);
      EXPECT_NEAR(now[n].impulse, before[n].impulse, 1e-3);
      EXPECT_NEAR(now[n].friction, before[n].friction, 1e-3);
      EXPECT_NEAR(now[n].point.x, before[n].point.x, 2e-3);
      EXPECT_NEAR(now[n].point.y, before[n].point.y, 2e-3);
      EXPECT_NEAR(now[n].normal.y, before[n].normal.y, 1e-3);
    }
    world->step();
  }
  const BodyId top = world->id_of(2);
  EXPECT_TRUE(world->wake(top));
  EXPECT_EQ(world->contacts().size(), 7u);  // no step since
  world->step();
  EXPECT_EQ(world->contacts().size(), 7u);
  ASSERT_TRUE(world->remove_body(top));
  EXPECT_EQ(world->contacts().size(), 5u);
  world->step();
  EXPECT_EQ(world->contacts().size(), 5u);
}

TEST(Contacts, AreTheSameOnEveryIsaAndThreadCount) {
  std::vector<std::vector<Contact>> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : kSanitized ? std::vector{5} : std::vector{1, 2, 5}) {
      auto world = make(walled({0, 0, 40, 60}, {0, -kG}, material(0, 0.3)), isa, threads);
      add(*world, lattice(700, {0.5, 0.5, 39.5, 25}, 0.5, 1, material(0.2, 0.3)));
      for (int k = 0; k < 20; ++k) add(*world, box({1.5 + 1.8 * k, 27}, 1.2, 0.8, material(0, 0.3)));
      std::vector<std::vector<Contact>> all;
      for (int k = 0; k < 200; ++k) {
        world->step();
        if (k % 40 == 39) all.push_back(listed(*world));
      }
      EXPECT_GT(all.back().size(), 900u);
      if (first.empty()) first = all;
      ASSERT_EQ(all.size(), first.size());
      for (std::size_t k = 0; k < all.size(); ++k) {
        EXPECT_TRUE(std::equal(all[k].begin(), all[k].end(), first[k].begin(), first[k].end(), same)) << k;
      }
    }
  }
}

TEST(Contacts, AskingChangesNothing) {
  const auto build = [] {
    auto world = make(walled({0, 0, 20, 60}, {0, -kG}, material(0, 0.3)));
    add(*world, lattice(150, {0.5, 0.5, 19.5, 20}, 0.5, 2, material(0.5, 0.3)));
    for (int k = 0; k < 8; ++k) add(*world, box({1.5 + 2 * k, 24}, 1.2, 0.8));
    return world;
  };
  auto asked = build(), left_alone = build();
  for (int k = 0; k < 300; ++k) {
    if (k % 3 == 0) {  // a step spread over frames
      StepDetail wait;
      wait.solves = false;
      wait.pieces = 1 + static_cast<std::uint32_t>(k % 11);
      for (int frame = 0; frame < 3; ++frame) {
        asked->replay(wait);
        left_alone->replay(wait);
        asked->contacts();
      }
    }
    asked->step();
    left_alone->step();
    asked->contacts();
    if (k % 50 == 0) {
      asked->diagnostics();
      asked->contacts();
    }
    ASSERT_EQ(asked->state_hash(), left_alone->state_hash()) << k;
  }
}

TEST(Contacts, ComeBackWithASavedState) {
  for (const bool sleeping : {false, true}) {
    WorldDesc desc = walled({0, 0, 14, 60}, {0, -kG}, material(0, 0.3));
    desc.sleeping = sleeping;
    auto world = make(desc);
    add(*world, lattice(80, {0.5, 0.5, 13.5, 12}, 0.5, 1, material(0, 0.3)));
    for (int k = 0; k < 5; ++k) add(*world, box({1.5 + 2 * k, 14}, 1.2, 0.8));
    for (const int frames : {40, 200, 400}) {
      run(*world, frames);
      std::vector<std::byte> state;
      world->save(state);
      std::string error;
      auto other = World::from_state(state, {}, error);
      ASSERT_TRUE(other) << error;
      const auto push = [](World& w) {  // those that carry something
        std::vector<Contact> all = listed(w);
        std::erase_if(all, [](const Contact& c) { return c.impulse == 0; });
        return all;
      };
      const std::vector<Contact> here = push(*world), there = push(*other);
      EXPECT_TRUE(std::equal(here.begin(), here.end(), there.begin(), there.end(), same)) << frames;
    }
  }
}

TEST(Contacts, ForgetBodiesThatWereRemovedAndSeeThroughTheSeam) {
  auto world = make(periodic(10, 10));
  const BodyId left = add(*world, disc({0.4, 5}, {-1, 0}));
  const BodyId right = add(*world, disc({9.5, 5}, {1, 0}));
  world->step();
  const std::vector<Contact> c = listed(*world);
  ASSERT_EQ(c.size(), 1u);
  EXPECT_EQ(c[0].a, left);
  EXPECT_EQ(c[0].b, right);
  EXPECT_NEAR(c[0].normal.x, -1, 1e-6);  // the way through the seam
  EXPECT_NEAR(c[0].point.x, -0.05, 0.06);
  ASSERT_TRUE(world->remove_body(right));
  EXPECT_TRUE(world->contacts().empty());
  add(*world, disc({9.5, 5}));
  EXPECT_TRUE(world->contacts().empty());
}

TEST(Contacts, OfKinematicBodiesAndCapsules) {
  auto world = make(awake(unbounded(50)));
  const BodyId lift = add(*world, moving(kinematic(box({0, 0}, 6, 1)), {0, 1}));
  const BodyId rod = add(*world, capsule({0, 0.75}, 2, 0.25));
  const BodyId ball = add(*world, disc({2.5, 1}));
  run(*world, 60);
  double on_rod = 0, on_ball = 0;
  for (const Contact& c : world->contacts()) {
    EXPECT_EQ(c.a, lift);
    (c.b == rod ? on_rod : on_ball) += c.impulse;
    EXPECT_NEAR(c.point.y, state(*world, lift).y + 0.5, 2e-3);
  }
  EXPECT_NEAR(on_rod, (1 + kPi / 16) * kG / 60, 1e-3);
  EXPECT_NEAR(on_ball, kPi / 4 * kG / 60, 1e-3);
  EXPECT_TRUE(world->is_valid(ball));
}

// Discs whose common mass lanes hold as 1, and those that differ.
TEST(Contacts, WeighAlikeInEveryModel) {
  for (const int kind : {0, 1, 2}) {
    auto world = make(walled({-10, 0, 10, 10}, {0, -kG}, material(0, kind == 2 ? 0.5 : 0)));
    for (int k = 0; k < 4; ++k) {
      BodyDesc body = disc({-6.0 + 3 * k, 0.5}, {}, 0.5, material(0, kind == 2 ? 0.5 : 0));
      body.mass = kind == 1 ? 3 + k : 3;
      add(*world, body);
    }
    for (const std::size_t asleep : {0u, 4u}) {
      std::size_t sleep = 0;
      for (int k = 0; k < (asleep == 0 ? 20 : 200); ++k) sleep = world->step().asleep;
      ASSERT_EQ(sleep, asleep);
      const std::vector<Contact> c = listed(*world);
      ASSERT_EQ(c.size(), 4u);
      for (int k = 0; k < 4; ++k)
        EXPECT_NEAR(c[static_cast<std::size_t>(k)].impulse, (kind == 1 ? 3 + k : 3) * kG / 60, 1e-3) << kind;
    }
  }
}

// While a governor spreads the work ahead of a step over frames, nobody moves, and what touches is what did.
TEST(Contacts, WhileAStepWaitsAreThoseOfTheLast) {
  for (const bool shapes : {false, true}) {
    for (const double speed : {1.0, 12.0}) {  // lists that last, lists for a step
      WorldDesc desc = walled({0, 0, 40, 80}, {0, -kG}, material(0, 0.3));
      auto world = make(desc);
      add(*world, lattice(600, {0.5, 0.5, 39.5, 30}, 0.5, speed, material(0.3, 0.3)));
      for (int k = 0; shapes && k < 60; ++k) {
        add(*world, box({1.5 + 1.2 * (k % 30), 32.0 + k / 30}, 1, 0.8, material(0, 0.3)));
      }
      const auto pressed = [&] {
        std::vector<Contact> all = listed(*world);
        std::erase_if(all, [](const Contact& c) { return c.impulse == 0; });
        return all;
      };
      std::size_t waited = 0, compared = 0;
      for (int k = 0; k < 240; ++k) {
        world->step();
        const std::vector<Contact> before = pressed();
        for (int piece = 0; piece < 6; ++piece) {  // the work of the next step, a few pieces a frame
          StepDetail wait;
          wait.solves = false;
          wait.pieces = 1 + static_cast<std::uint32_t>(k % 7 == 0 ? piece : 3 * piece);
          world->replay(wait);
          const std::vector<Contact> now = pressed();
          ASSERT_EQ(now.size(), before.size()) << k << " " << piece;
          ASSERT_TRUE(std::equal(now.begin(), now.end(), before.begin(), same)) << k << " " << piece;
          ++waited;
          compared += now.size();
          if (k % 50 == 49 && piece == 4) {  // the host throws the work away
            world->set_velocity(world->id_of(5), {3, 40}, 0);
            const std::vector<Contact> still = pressed();
            ASSERT_TRUE(std::equal(still.begin(), still.end(), before.begin(), before.end(), same)) << k;
          }
        }
      }
      EXPECT_GT(compared, 100 * waited);
    }
  }
}

}  // namespace
}  // namespace psim::test
