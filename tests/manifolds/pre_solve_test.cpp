// New contacts that the host decides (World::set_pre_solve): what is shown, what a decision does, how long it lasts.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

BodyDesc asking(BodyDesc body) {
  body.pre_solve = true;
  return body;
}

BodyDesc bouncing(BodyDesc body, double restitution, double friction = 0) {
  body.material.restitution = restitution;
  body.material.friction = friction;
  return body;
}

WorldDesc still_sky(Vec2 gravity = {0, -kG}) {
  WorldDesc desc = unbounded(500, gravity);
  desc.sleeping = false;
  return desc;
}

const auto kLetThrough = [](std::span<NewContact> contacts) {
  for (NewContact& c : contacts) c.enabled = false;
};

// Things in the way of what falls from y = 10 above x = 0, with their top at y = 0.
std::vector<BodyDesc> floors() {
  BodyDesc chain;
  chain.type = BodyType::static_body;
  chain.shape = ChainShape{{{20, 0}, {0.1, 0}, {-0.1, 0}, {-20, 0}}, false};
  BodyDesc parts;
  parts.type = BodyType::static_body;
  parts.shape = CompoundShape{{{BoxShape{20, 1}, {-10, -0.5}}, {BoxShape{20, 1}, {10, -0.5}}}};
  return {fixed(box({0, -1}, 40, 2)),     test::segment({-20, 0}, {20, 0}), chain, parts,
          kinematic(box({0, -1}, 40, 2)), static_disc({0, -5}, 5)};
}

std::vector<BodyDesc> fallers() { return {disc({0, 10}), box({0, 10}, 1, 1), capsule({0, 10}, 1, 0.3)}; }

// ---- what a decision does

TEST(PreSolve, WhatIsLetThroughFallsAsIfNothingWasThere) {
  for (const BodyDesc& floor : floors()) {
    for (const BodyDesc& faller : fallers()) {
      for (const bool who : {false, true}) {
        auto world = make(still_sky()), free = make(still_sky());
        add(*world, who ? floor : asking(floor));
        const BodyId id = add(*world, who ? asking(faller) : faller), alone = add(*free, faller);
        int calls = 0;
        world->set_pre_solve([&](std::span<NewContact> contacts) {
          ++calls;
          kLetThrough(contacts);
        });
        run(*world, 200);
        run(*free, 200);
        EXPECT_GE(calls, 1);
        // Substeps beside the closed form, in floats.
        EXPECT_NEAR(state(*world, id).y, state(*free, alone).y, 3e-4);
        EXPECT_NEAR(state(*world, id).vy, state(*free, alone).vy, 1e-4);
        EXPECT_LT(state(*world, id).y, -20);
      }
    }
  }
}

TEST(PreSolve, WhatIsNotDecidedIsAsItWas) {
  for (const BodyDesc& floor : floors()) {
    for (const BodyDesc& faller : fallers()) {
      auto world = make(still_sky()), usual = make(still_sky());
      add(*world, asking(bouncing(floor, 0.4, 0.5)));
      add(*usual, asking(bouncing(floor, 0.4, 0.5)));
      add(*world, bouncing(faller, 0.4, 0.5));
      add(*usual, bouncing(faller, 0.4, 0.5));
      int shown = 0;
      world->set_pre_solve([&](std::span<NewContact> contacts) { shown += static_cast<int>(contacts.size()); });
      run(*world, 300);
      run(*usual, 300);
      EXPECT_GE(shown, 1);
      EXPECT_EQ(world->state_hash(), usual->state_hash());
    }
  }
}

// A box that slides at 3 m/s comes to rest after v^2 / (2 mu g); with a belt it takes its speed; a disc bounces to e^2 h.
TEST(PreSolve, SurfacesOfAContactChange) {
  for (const BodyDesc& floor : floors()) {
    if (std::holds_alternative<DiscShape>(floor.shape)) continue;
    auto world = make(still_sky());
    add(*world, asking(bouncing(floor, 0, 0.9)));
    BodyDesc slides = box({2, 0.5}, 1, 1, material(0, 0.9));
    slides.velocity = {3, 0};
    const BodyId rubs = add(*world, slides);
    slides.position = {-15, 0.5}, slides.velocity = {};
    const BodyId carried = add(*world, slides);
    const BodyId ball = add(*world, disc({10, 1.5}, {}, 0.5, material(0, 0)));
    world->set_pre_solve([&](std::span<NewContact> contacts) {
      for (NewContact& c : contacts) {
        EXPECT_EQ(c.friction, static_cast<double>(c.b == ball ? 0.0f : 0.9f));
        EXPECT_EQ(c.restitution, 0);
        if (c.b == rubs) c.friction = 0.2;
        if (c.b == carried) c.tangent_speed = 2;
        if (c.b == ball) c.restitution = 0.8;
      }
    });
    double highest = 0;
    bool bounced = false;
    for (int k = 0; k < 240; ++k) {
      world->step();
      bounced = bounced || (state(*world, ball).vy > 0);
      if (bounced && state(*world, ball).vy > 0) highest = std::max(highest, state(*world, ball).y - 0.5);
    }
    EXPECT_NEAR(state(*world, rubs).x, 2 + 9 / (2 * 0.2 * kG), 0.02);
    EXPECT_NEAR(state(*world, carried).vx, 2, 1e-3);
    EXPECT_NEAR(highest, 0.64, 0.02);
  }
}

TEST(PreSolve, NumbersOutOfTheirRangesChangeNothing) {
  const std::vector<std::function<void(NewContact&)>> wrong = {
      [](NewContact& c) { c.friction = -1; },          [](NewContact& c) { c.friction = kNan; },
      [](NewContact& c) { c.restitution = 1.5; },      [](NewContact& c) { c.tangent_speed = kInf; },
      [](NewContact& c) { c.rolling_resistance = 2; }, [](NewContact& c) { c.normal = {kNan, 3}, c.a = kNoBody; }};
  for (std::size_t k = 0; k <= wrong.size(); ++k) {
    auto world = make(still_sky());
    add(*world, asking(bouncing(fixed(box({0, -1}, 40, 2)), 0.3, 0.5)));
    BodyDesc body = bouncing(box({0, 1}, 1, 1), 0.3, 0.5);
    body.velocity = {3, 0};
    add(*world, body);
    static std::uint64_t right = 0;
    if (k < wrong.size()) world->set_pre_solve([&](std::span<NewContact> cs) { std::ranges::for_each(cs, wrong[k]); });
    run(*world, 120);
    if (k == 0) right = world->state_hash();
    EXPECT_EQ(world->state_hash(), right) << k;
  }
}

// However fast: what is let through is not stopped, what is not is.
TEST(PreSolve, FastBodies) {
  Random random(3);
  for (int k = 0; k < 60; ++k) {
    const bool through = k % 2 == 0;
    const double speed = std::pow(10.0, random.uniform(1, 3.5)), angle = random.uniform(-1, 1);
    auto world = make(still_sky({0, 0}));
    const BodyDesc thin = test::segment({0, -400}, {0, 400});
    add(*world, k % 3 == 0 ? asking(thin) : asking(kinematic(box({0, 0}, 0.05, 800))));
    BodyDesc fast = fallers()[static_cast<std::size_t>(k) % 3];
    fast.position = {-3, 0};
    fast.bullet = k % 5 == 0;
    fast.velocity = {speed * std::cos(angle), speed * std::sin(angle)};
    const BodyId id = add(*world, fast);
    if (through) world->set_pre_solve(kLetThrough);
    for (int n = 0; n < 30 && std::fabs(state(*world, id).x) < 3.5 && state(*world, id).vx > 0; ++n) world->step();
    EXPECT_EQ(state(*world, id).x > 0, through) << k << ": " << speed << " m/s";
  }
}

// ---- what is shown, and when

TEST(PreSolve, AContactIsShownOnceUntilItIsApart) {
  auto world = make(still_sky());
  add(*world, asking(fixed(box({0, -1}, 40, 2))));
  const BodyId ball = add(*world, disc({0, 2}, {}, 0.5, material(0.9)));
  int shown = 0, hits = 0;
  double last = 0;
  world->set_pre_solve([&](std::span<NewContact> contacts) {
    ASSERT_EQ(contacts.size(), 1u);
    ++shown;
    const NewContact& c = contacts[0];
    EXPECT_EQ(c.b, ball);
    EXPECT_NEAR(c.normal.x, 0, 1e-6);
    EXPECT_NEAR(c.normal.y, 1, 1e-6);
    EXPECT_NEAR(c.speed, -state(*world, ball).vy, 1e-5);
    EXPECT_NEAR(c.separation, state(*world, ball).y - 0.5, 1e-4);
    EXPECT_NEAR(c.point.y, c.separation / 2, 1e-4);
    EXPECT_GT(c.speed, 0);
  });
  for (int k = 0; k < 300; ++k) {
    world->step();
    const double v = state(*world, ball).vy;
    hits += last < 0 && v > 0;
    last = v;
  }
  EXPECT_EQ(shown, hits);
  EXPECT_GE(hits, 3);

  auto still = make(still_sky());
  add(*still, asking(fixed(box({0, -1}, 40, 2))));
  for (int k = 0; k < 5; ++k) add(*still, box({3.0 * k, 0.5}));
  std::vector<std::size_t> counts;
  still->set_pre_solve([&](std::span<NewContact> contacts) { counts.push_back(contacts.size()); });
  run(*still, 100);
  EXPECT_EQ(counts, std::vector<std::size_t>{5});
  still->set_pre_solve({});
  run(*still, 10);
  EXPECT_EQ(counts.size(), 1u);
}

std::vector<NewContact> shown_in(Isa isa, int threads, int frames, std::uint64_t& hash) {
  WorldDesc desc = walled({-20, -5, 20, 40});
  auto world = make(desc, isa, threads);
  Random random(7);
  BodyDesc floor = chain({{20, 0}, {0, -1}, {-20, 0}});
  floor.pre_solve = true;
  add(*world, floor);
  for (int k = 0; k < 150; ++k) {
    BodyDesc body = k % 3 == 0 ? disc({}) : k % 3 == 1 ? box({}) : capsule({}, 0.5, 0.3);
    body.position = {random.uniform(-18, 18), random.uniform(2, 30)};
    body.angle = random.uniform(-3, 3);
    body.pre_solve = random.chance(0.3);
    body.material = material(random.uniform(0, 0.5), random.uniform(0, 1));
    add(*world, body);
  }
  std::vector<NewContact> all;
  world->set_pre_solve([&](std::span<NewContact> contacts) {
    const auto key = [](const NewContact& c) { return std::tuple(c.a.index, c.b.index, c.part_a, c.part_b); };
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      if (k != 0) {
        EXPECT_LT(key(contacts[k - 1]), key(contacts[k]));
      }
      NewContact& c = contacts[k];
      all.push_back(c);
      EXPECT_LT(c.a.index, c.b.index);
      c.enabled = (c.a.index * 7 + c.b.index * 13) % 5 != 0;
      c.friction = (c.b.index % 3) * 0.4;
      c.restitution = (c.b.index % 4) * 0.2;
    }
  });
  run(*world, frames);
  hash = world->state_hash();
  return all;
}

TEST(PreSolve, TheSameEverywhere) {
  std::uint64_t hash = 0;
  const std::vector<NewContact> all = shown_in(Isa::scalar, 1, 120, hash);
  EXPECT_GT(all.size(), 100u);
  EXPECT_TRUE(std::ranges::any_of(all, [](const NewContact& c) { return c.b == kNoBody; }));
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 2, 4}) {
      std::uint64_t other = 0;
      const std::vector<NewContact> same = shown_in(isa, threads, 120, other);
      EXPECT_EQ(other, hash);
      ASSERT_EQ(same.size(), all.size());
      for (std::size_t k = 0; k < all.size(); ++k) {
        EXPECT_EQ(same[k].a, all[k].a);
        EXPECT_EQ(same[k].b, all[k].b);
        EXPECT_EQ(same[k].separation, all[k].separation);
        EXPECT_EQ(same[k].speed, all[k].speed);
        EXPECT_EQ(same[k].point.x, all[k].point.x);
      }
    }
  }
}

TEST(PreSolve, PartsAskForThemselves) {
  auto world = make(still_sky());
  BodyDesc table;
  table.type = BodyType::static_body;
  ShapePart left{BoxShape{4, 1}, {-4, -0.5}}, right{BoxShape{4, 1}, {4, -0.5}};
  right.pre_solve = true;
  table.shape = CompoundShape{{left, right}};
  add(*world, table);
  const BodyId stays = add(*world, box({-4, 0.5})), falls = add(*world, box({4, 0.5}));
  world->set_pre_solve([&](std::span<NewContact> contacts) {
    for (NewContact& c : contacts) {
      EXPECT_EQ(c.part_a, 1u);
      EXPECT_EQ(c.b, falls);
      c.enabled = false;
    }
  });
  run(*world, 60);
  EXPECT_NEAR(state(*world, stays).y, 0.5, 0.01);
  EXPECT_LT(state(*world, falls).y, -3);
}

// ---- how long a decision lasts

TEST(PreSolve, ABodyWithTheIndexOfAnotherOneIsNew) {
  auto world = make(still_sky());
  add(*world, asking(fixed(box({0, -1}, 40, 2))));
  int shown = 0;
  world->set_pre_solve([&](std::span<NewContact> contacts) { shown += static_cast<int>(contacts.size()); });
  BodyId id = add(*world, box({0, 0.5}));
  for (int k = 1; k <= 5; ++k) {
    run(*world, 3);
    EXPECT_EQ(shown, k);
    ASSERT_TRUE(world->remove_body(id));
    const BodyId next = add(*world, box({0, 0.5}));
    EXPECT_EQ(next.index, id.index);
    id = next;
  }
}

TEST(PreSolve, SleepKeepsDecisions) {
  WorldDesc desc = unbounded(500);
  auto world = make(desc);
  add(*world, fixed(box({0, -1}, 40, 2)));
  const BodyId shelf = add(*world, asking(fixed(box({0, 0.5}, 4, 0.2))));  // within the box that lies on the floor
  const BodyId lies = add(*world, box({0, 0.5}));
  int shown = 0;
  world->set_pre_solve([&](std::span<NewContact> contacts) {
    shown += static_cast<int>(contacts.size());
    for (NewContact& c : contacts) {
      EXPECT_EQ(c.a, shelf);
      c.enabled = false;
    }
  });
  run(*world, 400);
  ASSERT_FALSE(world->is_awake(lies));
  EXPECT_EQ(shown, 1);
  ASSERT_TRUE(world->apply_impulse(lies, {0.5, 0}));
  run(*world, 100);
  EXPECT_EQ(shown, 1);
  EXPECT_NEAR(state(*world, lies).y, 0.5, 0.01);
}

TEST(PreSolve, TraitsTurnItOnAndOff) {
  auto world = make(still_sky());
  const BodyId floor = add(*world, fixed(box({0, -1}, 40, 2)));
  add(*world, box({0, 0.5}));
  int shown = 0;
  world->set_pre_solve([&](std::span<NewContact> contacts) { shown += static_cast<int>(contacts.size()); });
  run(*world, 5);
  EXPECT_EQ(shown, 0);
  BodyTraits traits = *world->traits(floor);
  EXPECT_FALSE(traits.pre_solve);
  traits.pre_solve = true;
  ASSERT_TRUE(world->set_traits(floor, traits));
  EXPECT_TRUE(world->traits(floor)->pre_solve);
  run(*world, 5);
  EXPECT_EQ(shown, 1);  // what touches is new to who asks
  traits.pre_solve = false;
  ASSERT_TRUE(world->set_traits(floor, traits));
  add(*world, box({5, 0.5}));
  run(*world, 5);
  EXPECT_EQ(shown, 1);
}

// What was decided of a contact ends when nobody asks any more.
TEST(PreSolve, DecisionsEndWithTheTrait) {
  auto world = make(still_sky());
  const BodyId floor = add(*world, asking(bouncing(fixed(box({0, -1}, 80, 2)), 0, 0.9)));
  BodyDesc body = box({-30, 0.5}, 1, 1, material(0, 0.9));
  body.velocity = {3, 0};
  const BodyId slides = add(*world, body);
  world->set_pre_solve([](std::span<NewContact> contacts) {
    for (NewContact& c : contacts) c.friction = 0;
  });
  run(*world, 60);
  EXPECT_NEAR(state(*world, slides).vx, 3, 1e-4);
  BodyTraits traits = *world->traits(floor);
  traits.pre_solve = false;
  ASSERT_TRUE(world->set_traits(floor, traits));
  run(*world, 60);
  EXPECT_NEAR(state(*world, slides).vx, 0, 1e-4);
}

// A state holds what was decided, and a recording what the host answered.
TEST(PreSolve, StatesAndRecordings) {
  for (const bool governed : {false, true}) {
    auto world = make(walled({-20, -5, 20, 40}), best_isa(), 2);
    if (governed) {
      GovernorDesc tight;
      tight.on = true;
      tight.budget_ms = 0.02;
      ASSERT_TRUE(world->set_governor(tight));
    }
    Random random(11);
    add(*world, asking(chain({{20, 0}, {0, -1}, {-20, 0}})));
    for (int k = 0; k < 120; ++k) {
      BodyDesc body = k % 2 == 0 ? disc({}) : box({});
      body.position = {random.uniform(-18, 18), random.uniform(2, 30)};
      body.pre_solve = random.chance(0.2);
      add(*world, body);
    }
    const PreSolve host = [](std::span<NewContact> contacts) {
      for (NewContact& c : contacts) {
        c.enabled = c.b.index % 4 != 0;
        c.friction = c.b.index % 3 * 0.3;
      }
    };
    world->set_pre_solve(host);
    std::string error;
    std::vector<std::byte> recording;
    {
      Recorder recorder(*world, 5);
      for (int k = 0; k < 100; ++k) {
        if (k == 50) recorder.set_pre_solve({});
        if (k == 70) recorder.set_pre_solve(host);
        const StepReport report = recorder.step();
        std::vector<std::byte> state;
        world->save(state);
        auto copy = World::from_state(state, {.threads = 1}, error);
        ASSERT_NE(copy, nullptr) << error;
        copy->set_pre_solve(world->pre_solve());
        EXPECT_EQ(copy->state_hash(), world->state_hash());
        static_cast<void>(report);
      }
      recording = recorder.recording();
    }
    EXPECT_TRUE(world->pre_solve() != nullptr);
    auto replay = Replay::open(recording, {.isa = Isa::scalar}, error);
    ASSERT_NE(replay, nullptr) << error;
    while (replay->next()) {
    }
    EXPECT_TRUE(replay->complete());
    EXPECT_EQ(replay->differs_at(), 0u);
    EXPECT_EQ(replay->world().state_hash(), world->state_hash());

    // From any state on, the same.
    std::vector<std::byte> state;
    for (int k = 0; k < 40; ++k) {
      world->save(state);
      auto copy = World::from_state(state, {.threads = 1}, error);
      ASSERT_NE(copy, nullptr) << error;
      copy->set_pre_solve(host);
      const StepReport report = world->step();
      copy->replay(report.detail);
      ASSERT_EQ(copy->state_hash(), world->state_hash()) << k;
    }
  }
}

}  // namespace
}  // namespace psim::test
