// What a step tells: touching pairs, hits.
#include <set>

#include "body_outlines.h"
#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;

EventOptions all_events(double hit_speed = 1) { return {true, true, hit_speed, true}; }

BodyDesc box(Vec2 position, double width, double height, Material m = {}) {
  BodyDesc body;
  body.shape = BoxShape{width, height, 0};
  body.position = position;
  body.material = m;
  return body;
}

/// The touching pairs as begin and end events tell them; each begins before it ends.
struct Touching {
  std::set<Pair> pairs;

  // The walls of the world have numbers that no body has.
  static Pair pair_of(const TouchEvent& t) {
    if (t.b != kNoBody) return {t.a.index, t.b.index};
    const int wall = static_cast<int>(t.normal.x + 3 * t.normal.y);
    EXPECT_TRUE(wall == 1 || wall == -1 || wall == 3 || wall == -3);
    return {t.a.index, t.b.index - 4 + static_cast<std::uint32_t>(wall)};
  }

  void follow(const World& world) {
    const Events e = world.events();
    for (const TouchEvent& t : e.end) {
      EXPECT_LT(t.a.index, t.b.index);
      EXPECT_EQ(pairs.erase(pair_of(t)), 1u);
    }
    for (const TouchEvent& t : e.begin) {
      EXPECT_LT(t.a.index, t.b.index);
      EXPECT_TRUE(world.is_valid(t.a) && (t.b == kNoBody || world.is_valid(t.b)));
      EXPECT_TRUE(pairs.insert(pair_of(t)).second);
    }
    const auto ordered = [](std::span<const TouchEvent> list) {
      return std::is_sorted(list.begin(), list.end(), [](const TouchEvent& x, const TouchEvent& y) {
        return Pair{x.a.index, x.b.index} < Pair{y.a.index, y.b.index};
      });
    };
    EXPECT_TRUE(ordered(e.begin) && ordered(e.end));
  }
};

/// A bin of static segments, a body each, with discs over it; no walls of the world.
std::unique_ptr<World> bin(std::size_t n, Material m, Isa isa = best_isa(), int threads = 1) {
  const double columns = std::ceil(std::sqrt(static_cast<double>(n))), width = 1.05 * columns + 1;
  auto world = make(unbounded(20 * columns + 20), isa, threads);
  add(*world, segment({0, 0}, {width, 0}, m));
  add(*world, segment({0, 0}, {0, 4 * width}, m));
  add(*world, segment({width, 0}, {width, 4 * width}, m));
  add(*world, lattice(n, {0.5, 0.5, width - 0.5, 0.5 + 1.05 * columns}, 0.5, 1, m));
  return world;
}

TEST(Events, AreNoneUnlessAskedFor) {
  auto world = bin(50, {});
  run(*world, 60);
  const Events e = world->events();
  EXPECT_TRUE(e.begin.empty() && e.end.empty() && e.hits.empty());
  bool planned = true;
  for (const PlanEntry& entry : world->plan()) {
    if (entry.stage == "events") planned = entry.needed;
  }
  EXPECT_FALSE(planned);
}

TEST(Events, ChangeNoResult) {
  const auto build = [] { return pile(500, material(0.3, 0.5)); };
  auto heard = build(), unheard = build();
  for (int k = 0; k < 200; ++k) {
    if (k == 20) heard->set_event_options(all_events());
    if (k == 120) heard->set_event_options({});
    heard->step();
    unheard->step();
    ASSERT_EQ(heard->state_hash(), unheard->state_hash()) << "frame " << k;
  }
}

TEST(Events, TellLandingAndLeaving) {
  auto world = make(unbounded());
  world->set_event_options(all_events());
  const BodyId floor = add(*world, ground());
  const BodyId ball = add(*world, disc({0, 1}));
  int began = 0, ended = 0, frame = 0;
  for (; frame < 120; ++frame) {
    world->step();
    for (const TouchEvent& t : world->events().begin) {
      ++began;
      EXPECT_EQ(t.a, floor);
      EXPECT_EQ(t.b, ball);
      EXPECT_NEAR(state(*world, ball).y, 0.5, 0.01);
    }
    ended += static_cast<int>(world->events().end.size());
  }
  EXPECT_EQ(began, 1);
  EXPECT_EQ(ended, 0);
  world->apply_impulse(ball, {0, 4});
  for (int k = 0; k < 10; ++k) {
    world->step();
    ended += static_cast<int>(world->events().end.size());
  }
  EXPECT_EQ(ended, 1);
}

TEST(Events, AreThePairsThatTheReportCounts) {
  for (const Material m : {material(0), material(0, 0.5), material(0.5, 0.3)}) {
    auto world = bin(300, m);
    world->set_sleeping(false);  // who sleeps touches, but has no contacts
    world->set_event_options({true, false, 1, false});
    Touching touching;
    std::size_t most = 0;
    for (int k = 0; k < 300; ++k) {
      const StepReport report = world->step();
      touching.follow(*world);
      ASSERT_EQ(touching.pairs.size(), report.contacts) << "frame " << k;
      most = std::max(most, touching.pairs.size());
    }
    EXPECT_GT(most, 300u);
    for (const auto& [a, b] : touching.pairs) {  // near each other, and all that overlap
      if (a < 3) continue;
      const BodyState p = state(*world, world->id_of(a)), q = state(*world, world->id_of(b));
      EXPECT_LT(std::hypot(p.x - q.x, p.y - q.y), 1.02);
    }
    const PublishedState s = world->published();
    for (const auto& pair : reference::pairs_closer_than(s.x, s.y, s.radius, -1e-3)) {
      if (s.type[pair.a] == BodyType::static_body) continue;
      EXPECT_TRUE(touching.pairs.count({s.id[pair.a], s.id[pair.b]})) << s.id[pair.a];
    }
  }
}

TEST(Events, AreTheSameForEveryIsaAndThreadCount) {
  std::vector<std::uint32_t> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : thread_counts()) {
      auto world = bin(600, material(0.3, 0.4), isa, threads);
      for (int k = 0; k < 30; ++k) add(*world, box({3.0 + 0.7 * k, 40 + 1.1 * k}, 0.8, 0.6, material(0.3, 0.4)));
      BodyDesc eye = box({10, 5}, 8, 6);
      eye.type = BodyType::static_body;
      eye.sensor = true;
      add(*world, eye);
      world->set_event_options(all_events());
      std::vector<std::uint32_t> told;
      for (int k = 0; k < 150; ++k) {
        world->step();
        const Events e = world->events();
        for (const auto list : {e.begin, e.end, e.sensor_begin, e.sensor_end}) {
          told.push_back(static_cast<std::uint32_t>(list.size()));
          for (const TouchEvent& t : list) told.insert(told.end(), {t.a.index, t.b.index});
        }
        for (const HitEvent& h : e.hits) {
          told.insert(told.end(), {h.a.index, h.b.index, static_cast<std::uint32_t>(std::lround(1e6 * h.speed))});
        }
      }
      if (first.empty()) first = told;
      EXPECT_GT(told.size(), 3000u);
      ASSERT_EQ(told, first);
    }
  }
}

TEST(Events, EndWithTheHandleOfARemovedBody) {
  auto world = make(unbounded());
  world->set_event_options(all_events());
  add(*world, ground());
  const BodyId old = add(*world, disc({0, 0.5}));
  run(*world, 5);
  world->remove_body(old);
  const BodyId fresh = add(*world, disc({0, 0.5}));
  ASSERT_EQ(fresh.index, old.index);
  world->step();
  ASSERT_EQ(world->events().end.size(), 1u);
  EXPECT_EQ(world->events().end[0].b, old);
  ASSERT_EQ(world->events().begin.size(), 1u);
  EXPECT_EQ(world->events().begin[0].b, fresh);
  world->remove_body(fresh);  // the last: nothing moves
  world->step();
  ASSERT_EQ(world->events().end.size(), 1u);
  EXPECT_EQ(world->events().end[0].b, fresh);
  world->step();
  EXPECT_TRUE(world->events().end.empty());
}

TEST(Events, EndForBodiesThatAreFrozenOrLeave) {
  WorldDesc desc = unbounded(10);
  auto world = make(desc);
  world->set_event_options(all_events());
  add(*world, segment({-10, 0}, {10, 0}));
  const BodyId broken = add(*world, disc({0, 0.5}));
  const BodyId runner = add(*world, disc({8, 0.5}, {6, 0}));
  Touching touching;
  for (int k = 0; k < 10; ++k) world->step(), touching.follow(*world);
  EXPECT_EQ(touching.pairs.size(), 2u);
  world->set_velocity(broken, {kNan, 0}, 0);
  for (int k = 0; k < 30; ++k) world->step(), touching.follow(*world);
  EXPECT_FALSE(world->is_valid(runner));
  EXPECT_TRUE(touching.pairs.empty());
}

TEST(Events, DoNotFlickerOverTheJointsOfAChain) {
  auto world = make(unbounded());
  world->set_event_options(all_events());
  std::vector<Vec2> points;
  for (int k = -20; k <= 20; ++k) points.push_back({1.0 * k, 0});
  add(*world, chain(points, false, material(0, 0.5)));
  BodyDesc ball = disc({-10, 0.5}, {5, 0}, 0.5, material(0, 0.5));
  ball.angular_velocity = -10;
  add(*world, ball);
  std::size_t began = 0, ended = 0;
  for (int k = 0; k < 180; ++k) {
    world->step();
    began += world->events().begin.size();
    ended += world->events().end.size();
  }
  EXPECT_EQ(began, 1u);
  EXPECT_EQ(ended, 0u);
}

TEST(Events, TellBodiesWithCornersOnce) {
  auto world = make(unbounded());
  world->set_event_options(all_events());
  add(*world, ground(material(0, 0.5)));
  for (int k = 0; k < 5; ++k) add(*world, box({0, 0.5 + 1.01 * k}, 1, 1, material(0, 0.5)));
  BodyDesc block = box({5, 0.5}, 1, 1);
  block.type = BodyType::static_body;
  const BodyId fixed = add(*world, block);
  const BodyId ball = add(*world, disc({5, 2}));
  Touching touching;
  for (int k = 0; k < 180; ++k) world->step(), touching.follow(*world);
  const std::set<Pair> expected{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {fixed.index, ball.index}};
  EXPECT_EQ(touching.pairs, expected);
}

// ---- hits -------------------------------------------------------------------------------------

struct Impact {
  const char* name;
  double restitution, speed;
};

class Hits : public testing::TestWithParam<Impact> {};

TEST_P(Hits, TellHowFastTwoDiscsMet) {
  const auto [name, e, speed] = GetParam();
  auto world = make(unbounded(100, {0, 0}));
  world->set_event_options(all_events(0.5 * speed));
  const BodyId left = add(*world, disc({-1.7, 0}, {speed, 0}, 0.5, material(e)));
  const BodyId right = add(*world, disc({1.3, 0.6}, {}, 0.5, material(e)));
  std::vector<HitEvent> hits;
  for (int k = 0; k < 200; ++k) {
    world->step();
    const auto now = world->events().hits;
    hits.insert(hits.end(), now.begin(), now.end());
  }
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].a, left);
  EXPECT_EQ(hits[0].b, right);
  // Off centre by 0.6 of a diameter: the cosine is 0.8.
  EXPECT_NEAR(hits[0].speed, 0.8 * speed, 0.02 * speed);
  EXPECT_NEAR(hits[0].normal.x, 0.8, 0.02);
  EXPECT_NEAR(hits[0].normal.y, 0.6, 0.02);
  EXPECT_NEAR(hits[0].point.x, 1.3 - 0.4, 0.03);
  EXPECT_NEAR(hits[0].point.y, 0.6 - 0.3, 0.03);
}

TEST_P(Hits, TellHowFastFixedThingsAreHit) {
  const auto [name, e, speed] = GetParam();
  for (const int kind : {0, 1, 2, 3}) {
    auto world = make(kind == 0 ? walled({-5, -5, 5, 5}, {0, 0}, material(e)) : unbounded(100, {0, 0}));
    world->set_event_options(all_events(0.5 * speed));
    BodyId fixed = kNoBody;
    if (kind == 1) fixed = add(*world, segment({5, -9}, {5, 9}, material(e)));
    if (kind == 2) fixed = add(*world, static_disc({6, 0}, 1, material(e)));
    BodyDesc body = disc({0, 0}, {speed, 0}, 0.5, material(e));
    if (kind == 3) {
      BodyDesc block = box({6, 0}, 2, 2, material(e));
      block.type = BodyType::static_body;
      fixed = add(*world, block);
      body.shape = BoxShape{1, 1, 0};
    }
    const BodyId ball = add(*world, body);
    std::vector<HitEvent> hits;
    for (int k = 0; k < 400 && hits.empty(); ++k) {
      world->step();
      const auto now = world->events().hits;
      hits.insert(hits.end(), now.begin(), now.end());
    }
    ASSERT_EQ(hits.size(), 1u) << kind;
    const bool wall = kind == 0;
    EXPECT_EQ(hits[0].a, wall ? ball : fixed);
    EXPECT_EQ(hits[0].b, wall ? kNoBody : ball);
    EXPECT_NEAR(hits[0].normal.x, wall ? 1 : -1, 1e-5);
    EXPECT_NEAR(hits[0].speed, speed, 0.01 * speed);
    EXPECT_NEAR(hits[0].point.x, 5, 0.05);
    run(*world, 3);
    EXPECT_TRUE(world->events().hits.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Speeds, Hits,
                         testing::Values(Impact{"DullSlow", 0, 1}, Impact{"Dull", 0, 8}, Impact{"DullFast", 0, 60},
                                         Impact{"Slow", 0.5, 1}, Impact{"Middling", 0.5, 8}, Impact{"Fast", 0.5, 60},
                                         Impact{"Elastic", 1, 8}, Impact{"ElasticFast", 1, 60}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(HitEvents, AreNoneForNearMissesAndSlowOnes) {
  auto world = make(unbounded(100, {0, 0}));
  world->set_event_options(all_events(2));
  for (int k = 0; k < 8; ++k) {  // pass at a distance of 1 to 8 % of a diameter
    add(*world, disc({-5.0 - 0.1 * k, 5.0 * k}, {20, 0}, 0.5, material(0.5)));
    add(*world, disc({0, 5.0 * k + 1.01 + 0.01 * k}, {}, 0.5, material(0.5)));
  }
  add(*world, disc({0, -5}, {1.9, 0}));
  add(*world, disc({2, -5}));
  for (int k = 0; k < 120; ++k) {
    world->step();
    EXPECT_TRUE(world->events().hits.empty()) << "frame " << k;
  }
}

TEST(HitEvents, OfAnElasticGasAreItsImpacts) {
  // Every impact changes the direction of two discs; none is told twice in a frame.
  auto world = gas_in_period(300, 0.1, material(1), 5);
  world->set_event_options({false, true, 0.01, false});
  std::size_t hits = 0, changed = 0, missed = 0;
  for (int k = 0; k < 100; ++k) {
    const PublishedState s = world->published();
    const std::vector<double> vx(s.vx.begin(), s.vx.end()), vy(s.vy.begin(), s.vy.end());
    world->step();
    std::set<std::uint32_t> told;
    for (const HitEvent& h : world->events().hits) told.insert({h.a.index, h.b.index});
    hits += world->events().hits.size();
    const PublishedState now = world->published();
    for (std::size_t i = 0; i < now.id.size(); ++i) {
      const bool turned = std::hypot(now.vx[i] - vx[i], now.vy[i] - vy[i]) > 0.2;
      changed += turned ? 1 : 0;
      missed += turned && told.count(now.id[i]) == 0 ? 1 : 0;
    }
  }
  EXPECT_GT(hits, 300u);
  EXPECT_GT(changed, 600u);
  EXPECT_LT(missed, changed / 50);  // those hit twice within a frame
}

}  // namespace
}  // namespace psim::test
