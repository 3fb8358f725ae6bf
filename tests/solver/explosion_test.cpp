// Explosions, and fields that change while the world runs.
#include <cmath>
#include <string>
#include <vector>

#include "rigid_support.h"

namespace psim::test {
namespace {

// impulse = per length x width x share, along the way from the explosion to the nearest point.
TEST(Explosion, PushesByWidthAndDistance) {
  WorldDesc desc = unbounded(100);
  desc.gravity = {};
  auto world = make(desc);
  struct Case {
    BodyDesc body;
    double width, share;
  };
  BodyDesc two = disc({0, 4});
  two.shape = CompoundShape{{{BoxShape{2, 1}, {0, 0}}, {BoxShape{1, 1}, {0, 1}}}};
  const Case cases[] = {
      {disc({1.5, 0}, {}, 0.5), 1, 1},     // its nearest point is at 1
      {disc({-3.5, 0}, {}, 0.5), 1, 0.5},  // at 3, between 2 and 4
      {box({0, -3}, 3, 1), 3, 0.75},       // at 2.5
      {disc({6, 6}), 0, 0},                // beyond
      {capsule({0, 2}, 1, 0.2, material(0)), 1.4, 1},
  };
  std::vector<BodyId> ids;
  for (const Case& c : cases) ids.push_back(add(*world, c.body));
  const BodyId parts = add(*world, two), still = add(*world, fixed(disc({0.7, 0.7}, {}, 0.1)));
  const BodyId other = add(*world, [] {
    BodyDesc body = disc({-0.7, 0.7}, {}, 0.1);
    body.filter.category = 2;
    return body;
  }());
  EXPECT_EQ(world->explode({{0, 0}, 2, 2, 3, ~2u}), 5u);
  for (std::size_t k = 0; k < std::size(cases); ++k) {
    const BodyState s = state(*world, ids[k]);
    const double mass = world->traits(ids[k]).value().mass;
    EXPECT_NEAR(mass * std::hypot(s.vx, s.vy), 3 * cases[k].width * cases[k].share, 1e-5) << k;
    EXPECT_GE(s.vx * s.x + s.vy * s.y, 0) << k;
  }
  // The lower box begins at 3.5, the upper one at 4.5.
  EXPECT_NEAR(state(*world, parts).vy * world->traits(parts).value().mass, 3 * 2 * 0.25, 1e-5);
  EXPECT_EQ(state(*world, still).vx, 0);
  EXPECT_EQ(state(*world, other).vx, 0);
}

// Of bodies that lie evenly around it none gains momentum in sum, also across the edge of a periodic world.
TEST(Explosion, ReachesAcrossTheEdge) {
  WorldDesc desc = unbounded(10);
  desc.gravity = {};
  desc.boundary = Boundary::periodic;
  auto world = make(desc);
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) add(*world, disc({10 * x - 1 * x, 9 * y}, {}, 0.3));
  }
  EXPECT_EQ(world->explode({{10, 10}, 1, 3, 2, ~0u}), 4u);
  Vec2 sum;
  for (std::uint32_t k = 0; k < 4; ++k) {
    const BodyState s = state(*world, world->id_of(k));
    EXPECT_GT(std::hypot(s.vx, s.vy), 0.1);
    sum = {sum.x + s.vx, sum.y + s.vy};
  }
  EXPECT_NEAR(sum.x, 0, 1e-5);
  EXPECT_NEAR(sum.y, 0, 1e-5);
}

// A well that was moved pulls as one that was there from the beginning; without fields a world is as one that never had
// any.
TEST(Fields, ChangedAreAsMade) {
  std::string error;
  for (const Integrator integrator : kAllIntegrators) {
    const std::vector<std::vector<Field>> sets = {
        {}, {WellField{{3, 4}, 30, 0.1}}, {DragField{0.2, 0}}, {DragField{0, 0.1}, WellField{{-3, 4}, -30, 0.1}}};
    for (const auto& from : sets) {
      for (const auto& to : sets) {
        WorldDesc desc = walled({-10, -10, 10, 10}, {0, -1});
        desc.integrator = integrator;
        desc.fields = to;
        auto made = make(desc);
        desc.fields = from;
        auto changed = make(desc);
        Random r(2), again(2);
        for (int k = 0; k < 30; ++k) {
          const Vec2 at{-9 + 3.0 * (k % 6), -9 + 3.0 * (k / 6)};
          add(*made, body_of_any_shape(r, at));
          add(*changed, body_of_any_shape(again, at));
        }
        ASSERT_TRUE(changed->set_fields(to, error)) << error;
        for (int k = 0; k < 10; ++k) {
          made->step();
          changed->step();
        }
        EXPECT_EQ(made->state_hash(), changed->state_hash()) << from.size() << " " << to.size();
        EXPECT_EQ(changed->desc().fields.size(), to.size());
      }
    }
  }
}

TEST(Fields, ChangesWakeEverybody) {
  Placed p = stack(1);
  for (int k = 0; k < 300 && p.world->is_awake(p.ids[0]); ++k) p.world->step();
  ASSERT_FALSE(p.world->is_awake(p.ids[0]));
  std::string error;
  ASSERT_TRUE(p.world->set_fields({WellField{{0, 30}, 40000, 1}}, error));
  EXPECT_TRUE(p.world->is_awake(p.ids[0]));
  for (int k = 0; k < 60; ++k) p.world->step();
  EXPECT_GT(p.top().y, 1);
}

}  // namespace
}  // namespace psim::test
