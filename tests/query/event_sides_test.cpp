// Events of walls, where touching pairs meet, who falls asleep and wakes, who moved.
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "rigid_support.h"
#include "saved_support.h"

namespace psim::test {
namespace {

EventOptions options_of(bool contacts, bool sleep, bool moves) {
  EventOptions options;
  options.contacts = contacts;
  options.sleep = sleep;
  options.moves = moves;
  return options;
}

BodyDesc some_body(Random& r, Vec2 at) {
  const std::size_t kind = r.below(4);
  BodyDesc body = disc(at, {}, r.uniform(0.2, 0.5), kGrip);
  if (kind == 1) body = box(at, r.uniform(0.3, 1), r.uniform(0.3, 1), kGrip);
  if (kind == 2) body = capsule(at, r.uniform(0.2, 1), 0.2, kGrip);
  if (kind == 3) body.shape = CompoundShape{{{BoxShape{1, 0.2}}, {DiscShape{0.3}, {0.5, 0}}}};
  body.angle = r.uniform(-3, 3);
  return body;
}

TEST(EventSides, WallsOfTheWorldTouchToo) {
  for (const bool square : {false, true}) {
    auto world = make(walled({-5, -3, 5, 10}, {8, -kG}, material(0, 0.5)));
    world->set_event_options(options_of(true, false, false));
    const BodyId id = add(*world, square ? box({4, 0}, 1, 1, kGrip) : disc({4, 0}, {}, 0.5, kGrip));
    std::map<std::pair<double, double>, int> touches;  // by normal
    int ended = 0;
    for (int k = 0; k < 600; ++k) {
      world->step();
      for (const TouchEvent& e : world->events().begin) {
        EXPECT_EQ(e.a, id);
        EXPECT_EQ(e.b, kNoBody);
        ++touches[{e.normal.x, e.normal.y}];
        EXPECT_NEAR(e.normal.x != 0 ? e.point.x : e.point.y, e.normal.x != 0 ? 5 : -3, 0.02);
      }
      ended += static_cast<int>(world->events().end.size());
    }
    EXPECT_FALSE(world->is_awake(id));
    // It leans on the right wall and lies on the bottom. It may have bounced off a wall and come back.
    EXPECT_EQ(touches.size(), 2u) << square;
    EXPECT_GE((touches[{1, 0}]), 1);
    EXPECT_GE((touches[{0, -1}]), 1);
    EXPECT_EQ(touches[std::pair(1.0, 0.0)] + touches[std::pair(0.0, -1.0)] - ended, 2) << "sleep ends no touch";
    ASSERT_TRUE(world->set_transform(id, {0, 5}, 0));
    world->step();
    EXPECT_EQ(world->events().end.size(), 2u);
    for (const TouchEvent& e : world->events().end) {
      EXPECT_EQ(e.a, id);
      EXPECT_EQ(e.b, kNoBody);
    }
  }
}

// All that begins to touch has a point and a normal, those of its deepest contact.
TEST(EventSides, BeginWhereTheContactIs) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Random r(seed);
    auto world = make(walled({-8, 0, 8, 40}, {0, -kG}, kGrip), best_isa(), seed % 2 == 0 ? 1 : 3);
    world->set_event_options(options_of(true, false, false));
    add(*world, fixed(box({0, 3}, 4, 1, kGrip)));
    add(*world, segment({-8, 2}, {-2, 0.5}, kGrip));
    add(*world, static_disc({4, 2}, 1, kGrip));
    add(*world, kinematic(moving(box({-4, 6}, 3, 0.4, kGrip), {0, 0}, 1)));
    const bool discs = seed >= 4;
    for (int k = 0; k < 120; ++k) {
      const Vec2 at{-7 + 1.3 * (k % 11), 8 + 1.3 * (k / 11)};
      add(*world, discs ? disc(at, {}, 0.4, kGrip) : some_body(r, at));
    }
    std::size_t begun = 0, of_walls = 0;
    for (int k = 0; k < 240; ++k) {
      world->step();
      const Events events = world->events();
      const std::vector<TouchEvent> begin(events.begin.begin(), events.begin.end());
      const std::span<const Contact> contacts = world->contacts();
      for (const TouchEvent& e : begin) {
        ++begun;
        of_walls += e.b == kNoBody;
        EXPECT_NEAR(std::hypot(e.normal.x, e.normal.y), 1, 1e-5);
        double deepest = HUGE_VAL, mine = HUGE_VAL;
        for (const Contact& c : contacts) {
          if (c.a != e.a || c.b != e.b) continue;
          if (e.b == kNoBody && c.normal.x * e.normal.x + c.normal.y * e.normal.y < 0.5) continue;
          deepest = std::min(deepest, c.separation);
          const bool same = c.point.x == e.point.x && c.point.y == e.point.y && c.normal.x == e.normal.x;
          if (same) mine = c.separation;
        }
        EXPECT_EQ(mine, deepest) << e.a.index << " " << e.b.index;
      }
    }
    EXPECT_GT(begun, 200u);
    EXPECT_GT(of_walls, 20u);
  }
}

// What began and has not ended are the pairs that touch, walls among them, however bodies sleep and wake.
TEST(EventSides, BegunAndNotEndedIsTouching) {
  using Key = std::tuple<std::uint32_t, std::uint32_t, int, int>;
  Random r(3);
  auto world = make(walled({-6, 0, 6, 30}, {0, -kG}, kGrip));
  world->set_event_options(options_of(true, true, false));
  for (int k = 0; k < 60; ++k) add(*world, some_body(r, {-5 + 1.3 * (k % 8), 2 + 1.3 * (k / 8)}));
  std::multiset<std::pair<std::uint32_t, std::uint32_t>> touching;
  bool slept = false;
  for (int k = 0; k < 1200; ++k) {
    if (k % 300 == 299) world->apply_impulse(world->id_of(static_cast<std::uint32_t>(r.below(60))), {2, 4});
    world->step();
    for (const TouchEvent& e : world->events().end) {
      const auto at = touching.find({e.a.index, e.b.index});
      ASSERT_NE(at, touching.end()) << k;
      touching.erase(at);
    }
    for (const TouchEvent& e : world->events().begin) touching.insert({e.a.index, e.b.index});
    std::uint32_t asleep = 0;
    for (std::uint32_t id = 0; id < 60; ++id) asleep += !world->is_awake(world->id_of(id));
    slept = slept || asleep > 30;
    if (asleep != 0 || k % 10 != 0) continue;
    std::set<Key> now;
    for (const Contact& c : world->contacts()) {
      const bool wall = c.b == kNoBody;
      now.insert({c.a.index, c.b.index, wall ? std::lround(c.normal.x) : 0, wall ? std::lround(c.normal.y) : 0});
    }
    EXPECT_EQ(now.size(), touching.size()) << k;
  }
  EXPECT_TRUE(slept);
}

// Who fell asleep and did not wake sleeps.
TEST(EventSides, TellWhoSleeps) {
  Random r(7);
  auto world = make(walled({-20, 0, 20, 30}, {0, -kG}, kGrip));
  for (int k = 0; k < 80; ++k) add(*world, some_body(r, {-18 + 2.4 * (k % 16), 2 + 1.3 * (k / 16)}));
  std::set<std::uint32_t> asleep;
  std::size_t fell = 0, woke = 0;
  world->set_event_options(options_of(false, true, true));
  for (int k = 0; k < 1500; ++k) {
    if (k % 100 == 99) {
      const BodyId id = world->id_of(static_cast<std::uint32_t>(r.below(80)));
      if (world->is_valid(id) && k % 400 == 399) {
        world->remove_body(id);
        asleep.erase(id.index);
      } else if (world->is_valid(id)) {
        world->apply_impulse(id, {1, 3});
      }
    }
    if (k == 700) {  // a state holds what the host was told
      std::vector<std::byte> state;
      world->save(state);
      std::string error;
      ASSERT_TRUE(world->restore(state, error)) << error;
    }
    world->step();
    const Events e = world->events();
    for (const BodyId id : e.woke) {
      EXPECT_TRUE(world->is_awake(id));
      EXPECT_EQ(asleep.erase(id.index), 1u) << k;
    }
    for (const BodyId id : e.fell_asleep) {
      EXPECT_FALSE(world->is_awake(id));
      EXPECT_TRUE(asleep.insert(id.index).second) << k;
    }
    fell += e.fell_asleep.size();
    woke += e.woke.size();
    const auto by_index = [](const auto& list, const auto& index) {
      for (std::size_t n = 1; n < list.size(); ++n) EXPECT_LT(index(list[n - 1]), index(list[n]));
    };
    by_index(e.woke, [](BodyId id) { return id.index; });
    by_index(e.fell_asleep, [](BodyId id) { return id.index; });
    by_index(e.moves, [](const MoveEvent& m) { return m.body.index; });
    std::size_t moved = 0;
    for (std::uint32_t id = 0; id < 80; ++id) {
      const BodyId body = world->id_of(id);
      if (body == kNoBody) continue;
      EXPECT_EQ(asleep.count(id) != 0, !world->is_awake(body)) << k << " " << id;
      moved += world->is_awake(body);
    }
    EXPECT_EQ(e.moves.size(), moved + e.fell_asleep.size());
    for (const MoveEvent& m : e.moves) {
      const BodyState s = state(*world, m.body);
      EXPECT_EQ(m.position.x, s.x);
      EXPECT_EQ(m.position.y, s.y);
      EXPECT_EQ(m.angle, s.angle);
      EXPECT_EQ(m.fell_asleep, !world->is_awake(m.body));
    }
  }
  EXPECT_GT(fell, 80u);
  EXPECT_GT(woke, 10u);
}

}  // namespace
}  // namespace psim::test
