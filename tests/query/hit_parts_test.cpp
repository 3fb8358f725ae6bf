// Questions, contacts and hits tell which part of a body they are about.
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "psim/psim.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// A beam, and three discs on it from left to right: parts 0 to 3.
BodyDesc comb(Vec2 position, Material m = {}) {
  BodyDesc body;
  body.shape = CompoundShape{{{BoxShape{4, 0.5}, {0, 0}, 0},
                              {DiscShape{0.3}, {-1.5, 0.5}, 0},
                              {DiscShape{0.3}, {0, 0.5}, 0},
                              {DiscShape{0.3}, {1.5, 0.5}, 0}}};
  body.position = position;
  body.material = m;
  return body;
}

TEST(HitParts, QuestionsTellThePart) {
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    for (const bool asleep : {false, true}) {
      if (asleep && type != BodyType::dynamic_body) continue;
      auto world = make(unbounded(50, {0, 0}));
      BodyDesc body = turned(comb({3, 2}), 0.4);
      body.type = type;
      const BodyId id = add(*world, body);
      run(*world, asleep ? 120 : 1);
      EXPECT_EQ(world->is_awake(id), !asleep && type != BodyType::static_body);
      const auto at = [](Vec2 p) {
        return Vec2{3 + std::cos(0.4) * p.x - std::sin(0.4) * p.y, 2 + std::sin(0.4) * p.x + std::cos(0.4) * p.y};
      };
      for (std::uint32_t k = 1; k < 4; ++k) {
        const double x = 1.5 * (k - 2.0);
        const auto ray = world->ray_cast(at({x, 3}), at({x, 0}));
        ASSERT_TRUE(ray);
        EXPECT_EQ(ray->part, k);
        const Vec2 from = at({x, 3}), to = at({x, 0});
        const auto cast = world->shape_cast(DiscShape{0.1}, from, 0, {to.x - from.x, to.y - from.y});
        ASSERT_TRUE(cast);
        EXPECT_EQ(cast->part, k);
        const auto closest = world->closest(at({x, 1.2}), 5);
        ASSERT_TRUE(closest);
        EXPECT_EQ(closest->part, k);
        NearHit near[4];
        ASSERT_EQ(world->nearby(DiscShape{0.1}, at({x, 1.0}), 0, 0.3, near), 1u);
        EXPECT_EQ(near[0].part, k);
      }
      EXPECT_EQ(world->ray_cast(at({0.7, -3}), at({0.7, 3}))->part, 0u);
      EXPECT_EQ(world->ray_cast_all(at({1.5, 3}), at({1.5, -3})).at(0).part, 3u);
    }
  }
}

// Also of what fell asleep, of static bodies, and of walls.
TEST(HitParts, ContactsAndHitsTellTheParts) {
  for (const bool compound : {false, true}) {
    WorldDesc desc = unbounded(20);
    auto world = make(desc);
    world->set_event_options({true, true, 0.5, true});
    BodyDesc floor = compound ? comb({0, -0.75}) : box({0, -1}, 30, 1);
    if (compound) std::get<CompoundShape>(floor.shape).parts[0].shape = BoxShape{30, 0.5};
    floor.type = BodyType::static_body;
    const BodyId ground = add(*world, floor);
    // It stands on two feet, parts 1 and 2, which stand on the floor away from its discs.
    BodyDesc table;
    table.shape = CompoundShape{
        {{BoxShape{3, 0.2}, {0, 1}, 0}, {BoxShape{0.2, 1}, {-1.3, 0.5}, 0}, {BoxShape{0.2, 1}, {1.3, 0.5}, 0}}};
    table.position = {8, 0.5};
    const BodyId id = add(*world, table);
    std::set<std::uint32_t> hit, met;
    for (int frame = 0; frame < 300; ++frame) {
      run(*world, 1);
      for (const HitEvent& e : world->events().hits) {
        EXPECT_EQ(e.a, ground);
        EXPECT_EQ(e.b, id);
        EXPECT_EQ(e.part_a, 0u);
        hit.insert(e.part_b);
      }
    }
    ASSERT_FALSE(hit.empty());
    EXPECT_TRUE(std::ranges::all_of(hit, [](std::uint32_t part) { return part == 1 || part == 2; }));
    EXPECT_FALSE(world->is_awake(id));
    for (const bool asleep : {true, false}) {
      if (!asleep) {
        EXPECT_TRUE(world->wake(id));
        run(*world, 1);
      }
      met.clear();
      for (const Contact& c : world->contacts()) {
        EXPECT_EQ(c.part_a, 0u);
        met.insert(c.part_b);
      }
      EXPECT_EQ(met, (std::set<std::uint32_t>{1, 2})) << asleep;
    }
  }
}

TEST(HitParts, OfTwoBodiesTheOnesThatTouch) {
  auto world = make(unbounded(20));
  add(*world, ground(material(0, 0.5)));
  const BodyId lower = add(*world, comb({0, 0.25}, material(0, 0.5)));
  const BodyId upper = add(*world, box({0, 1.05}, 3.4, 0.5, material(0, 0.5)));
  run(*world, 60);
  std::set<std::pair<std::uint32_t, std::uint32_t>> met;
  for (const Contact& c : world->contacts()) {
    if (c.a == lower && c.b == upper) met.insert({c.part_a, c.part_b});
  }
  EXPECT_TRUE(met.contains({1, 0}) && met.contains({3, 0}));
  EXPECT_TRUE(std::ranges::all_of(met, [](const auto& m) { return m.first >= 1 && m.second == 0; }));
}

}  // namespace
}  // namespace psim::test
