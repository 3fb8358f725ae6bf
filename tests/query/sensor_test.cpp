// Who enters and leaves sensors: bodies, and parts of bodies.
#include <cmath>
#include <set>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "body_outlines.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

using Felt = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // sensor, its part, who is in it

// The parts of a body, each with the filter and the flag that count for it.
std::vector<ShapePart> parts_of(const BodyDesc& body) {
  const auto* compound = std::get_if<CompoundShape>(&body.shape);
  std::vector<ShapePart> parts(1);
  if (compound != nullptr) {
    parts = compound->parts;
  } else {
    std::visit(
        [&](const auto& s) {
          if constexpr (std::is_convertible_v<decltype(s), PartShape>) parts[0].shape = s;
        },
        body.shape);
  }
  for (ShapePart& part : parts) {
    part.filter = part.filter.value_or(body.filter);
    part.sensor = part.sensor.value_or(body.sensor);
  }
  return parts;
}

// Whether part a is a sensor that is to tell of part b.
bool tells(const ShapePart& a, const ShapePart& b) {
  const Filter &f = *a.filter, &g = *b.filter;
  return *a.sensor && !*b.sensor && (f.category & g.mask) != 0 && (g.category & f.mask) != 0;
}

TEST(Sensors, TellWhoIsInThemAsBruteForceDoes) {
  std::size_t seen = 0;
  for (const Boundary boundary : {Boundary::walls, Boundary::periodic}) {
    WorldDesc desc;
    desc.bounds = {-15, 0, 15, 30};
    desc.boundary = boundary;
    desc.gravity = {0, boundary == Boundary::walls ? -kG : 0};
    auto world = make(desc);
    world->set_event_options({false, false, 1, true});
    Random r(7);
    std::vector<BodyDesc> bodies;
    const auto put = [&](BodyDesc body) {
      body.angle = r.uniform(-3, 3);
      body.position = {r.uniform(-14, 14), r.uniform(1, 29)};
      body.velocity = {r.uniform(-3, 3), r.uniform(-3, 3)};
      body.filter.category = 1u << r.below(3);
      body.filter.mask = r.chance(0.8) ? 7u : 5u;
      add(*world, body);
      bodies.push_back(body);
    };
    for (int k = 0; k < 40; ++k) put(k % 2 == 0 ? disc({}, {}, 0.4) : box({}, 0.9, 0.5));
    for (int k = 0; k < 24; ++k) {
      BodyDesc eye = k % 3 == 0 ? disc({}, {}, 2) : box({}, 4, 2);
      if (k % 3 == 2) eye.shape = CapsuleShape{{-2, 0}, {1, 1}, 0.5};
      if (k % 4 == 3) {
        eye.shape = CompoundShape{{{BoxShape{1, 0.6}}, {DiscShape{0.8}, {0.9, 0}}, {DiscShape{0.5}, {-0.9, 0.3}}}};
        for (ShapePart& part : std::get<CompoundShape>(eye.shape).parts) {
          if (r.chance(0.5)) part.filter = Filter{1u << r.below(3), 6, 0};
          if (r.chance(0.5)) part.sensor = false;
        }
      }
      eye.type = k < 8 ? BodyType::static_body : k < 16 ? BodyType::kinematic_body : BodyType::dynamic_body;
      eye.sensor = true;
      put(eye);
    }
    std::vector<std::vector<ShapePart>> parts;
    for (const BodyDesc& body : bodies) parts.push_back(parts_of(body));
    std::set<Felt> inside;
    for (int frame = 0; frame < 90; ++frame) {
      world->step();
      const Events e = world->events();
      for (const TouchEvent& t : e.sensor_end) {
        EXPECT_EQ(inside.erase({t.a.index, t.part, t.b.index}), 1u);
      }
      for (const TouchEvent& t : e.sensor_begin) {
        EXPECT_TRUE(inside.insert({t.a.index, t.part, t.b.index}).second);
      }
      for (std::uint32_t a = 0; a < bodies.size(); ++a) {
        if (!bodies[a].sensor) continue;
        const BodyState s = state(*world, world->id_of(a));
        for (std::uint32_t part = 0; part < parts[a].size(); ++part) {
          const ShapePart& p = parts[a][part];
          const auto own = outlines(CompoundShape{{p}}, {s.x, s.y}, s.angle);
          for (std::uint32_t b = 0; b < bodies.size(); ++b) {
            const bool told = inside.count({a, part, b}) != 0;
            if (a == b || (bodies[a].type == BodyType::static_body && bodies[b].type == BodyType::static_body)) {
              EXPECT_FALSE(told);
              continue;
            }
            const BodyState o = state(*world, world->id_of(b));
            const auto apart = [&](double dx, double dy) {  // with b moved aside by so much
              double least = 1e300;
              for (int k = 0; k < 9; ++k) {
                const int x = k % 3 - 1, y = k / 3 - 1;
                if (boundary != Boundary::periodic && (x != 0 || y != 0)) continue;
                const Vec2 at{o.x + 30 * x + dx, o.y + 30 * y + dy};
                if (std::hypot(at.x - s.x, at.y - s.y) > 10) continue;
                for (const ShapePart& q : parts[b]) {
                  if (!tells(p, q)) continue;
                  for (const auto& mine : own) {
                    for (const auto& theirs : outlines(CompoundShape{{q}}, at, o.angle)) {
                      least = std::min(least, distance(mine, theirs));
                    }
                  }
                }
              }
              return least;
            };
            const double fuzz = 1e-5, least = apart(0, 0);
            EXPECT_TRUE(!told || least < fuzz) << a << " " << part << " " << b;
            if (!told && least == 0) {  // unless they only just touch
              EXPECT_GT(apart(fuzz, 0) + apart(-fuzz, 0) + apart(0, fuzz) + apart(0, -fuzz), 0)
                  << a << " " << b << " " << part;
            }
            seen += told ? 1 : 0;
          }
        }
      }
    }
  }
  EXPECT_GT(seen, 400u);
}

// Or they would fall out of the world.
TEST(Sensors, ThatMoveAreHeldByTheWallsAlone) {
  for (const bool boxes : {false, true}) {
    auto world = make(walled({-20, 0, 20, 40}));
    add(*world, fixed(box({0, 5}, 30, 1)));
    std::vector<BodyId> ids;
    for (const double speed : {0.0, -50.0, -900.0}) {
      BodyDesc eye = boxes ? box({speed / 100, 20}, 1, 1) : disc({speed / 100, 20});
      eye.sensor = true;
      ids.push_back(add(*world, moving(eye, {0, speed})));
    }
    const BodyId ball = add(*world, disc({0, 12}));
    run(*world, 300);
    for (const BodyId id : ids) EXPECT_NEAR(state(*world, id).y, 0.5, 0.01) << boxes << id.index;
    EXPECT_NEAR(state(*world, ball).y, 6, 0.01);
  }
}

// A foot and a hand of one character feel the same ground, a floor and a wall in one piece, each for itself.
TEST(Sensors, OfOneBodyFeelTheSameOtherEachForItself) {
  auto world = make(walled({-20, 0, 20, 20}));
  world->set_event_options({false, false, 1, true});
  BodyDesc ground = fixed(box({0, 1}, 20, 1));
  ground.shape = CompoundShape{{{BoxShape{20, 1}}, {BoxShape{1, 10}, {9, 5}}}};
  const BodyId level = add(*world, ground);
  BodyDesc hero = box({6, 6}, 1, 1);
  hero.fixed_rotation = true;
  ShapePart foot{BoxShape{0.6, 0.3}, {0, -0.6}}, hand{BoxShape{0.3, 0.6}, {0.6, 0}};
  foot.sensor = hand.sensor = true;
  hero.shape = CompoundShape{{{BoxShape{0.9, 1}}, foot, hand}};
  const BodyId id = add(*world, hero);
  std::vector<Felt> began, ended;
  const auto listen = [&](int frames) {
    began.clear();
    ended.clear();
    for (int k = 0; k < frames; ++k) {
      world->step();
      for (const TouchEvent& t : world->events().sensor_begin) began.emplace_back(t.a.index, t.part, t.b.index);
      for (const TouchEvent& t : world->events().sensor_end) ended.emplace_back(t.a.index, t.part, t.b.index);
    }
  };
  const Felt by_foot{id.index, 1, level.index}, by_hand{id.index, 2, level.index};
  listen(90);
  EXPECT_EQ(began, std::vector{by_foot});
  world->set_velocity(id, {3, 0}, 0);
  listen(60);
  EXPECT_EQ(began, std::vector{by_hand});
  EXPECT_TRUE(ended.empty());
  world->set_transform(id, {7, 9}, 0);
  listen(1);
  EXPECT_EQ(ended, (std::vector{by_foot, by_hand}));
  world->remove_body(id);
  listen(1);
  EXPECT_TRUE(began.empty() && ended.empty());
}

// Also of a static body, whose sensors are kept apart from what stops others.
TEST(Sensors, OfStaticBodiesTellTheirPartsToRaysToo) {
  auto world = make(walled({-20, 0, 20, 20}));
  world->set_event_options({false, false, 1, true});
  BodyDesc gate = fixed(box({0, 1}, 1, 1));
  ShapePart left{BoxShape{2, 2}, {-5, 0}}, right{ChainShape{.vertices = {{4, -1}, {5, 0}, {6, 1}}}};
  left.sensor = right.sensor = true;
  gate.shape = CompoundShape{{{BoxShape{1, 1}}, left, {BoxShape{1, 3}}, right}};
  const BodyId id = add(*world, gate), ball = add(*world, disc({5, 1}, {}, 0.5));
  world->step();
  ASSERT_EQ(world->events().sensor_begin.size(), 1u);
  EXPECT_EQ(world->events().sensor_begin[0].a, id);
  EXPECT_EQ(world->events().sensor_begin[0].part, 3u);
  world->set_transform(ball, {-5, 1}, 0);
  world->step();
  ASSERT_EQ(world->events().sensor_begin.size(), 1u);
  EXPECT_EQ(world->events().sensor_begin[0].part, 1u);
  EXPECT_EQ(world->events().sensor_end[0].part, 3u);
  QueryFilter all;
  all.sensors = true;
  all.ignore = ball;
  const auto hit = world->ray_cast({-5, 5}, {-5, 0}, all);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->part, 1u);
  EXPECT_TRUE(world->part_traits(id, hit->part)->sensor);
}

TEST(Sensors, StopNothing) {
  auto world = make(unbounded(100));
  BodyDesc eye = box({0, -5}, 4, 1);
  eye.type = BodyType::static_body;
  eye.sensor = true;
  add(*world, eye);
  BodyDesc lift = disc({0, -10}, {0, 1}, 1);
  lift.type = BodyType::kinematic_body;
  lift.sensor = true;
  add(*world, lift);
  const BodyId ball = add(*world, disc({0, 0})), block = add(*world, box({1.5, 0}, 1, 1));
  run(*world, 60);
  EXPECT_NEAR(state(*world, ball).vy, -kG, 1e-3);
  EXPECT_NEAR(state(*world, block).vy, -kG, 1e-3);
}

}  // namespace
}  // namespace psim::test
