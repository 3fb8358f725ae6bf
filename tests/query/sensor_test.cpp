// Who enters and leaves sensors: bodies, and parts of bodies.
#include <cmath>
#include <set>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "body_outlines.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

using Pair = std::pair<std::uint32_t, std::uint32_t>;

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
    std::set<Pair> inside;
    for (int frame = 0; frame < 90; ++frame) {
      world->step();
      const Events e = world->events();
      for (const TouchEvent& t : e.sensor_end) {
        EXPECT_EQ(inside.erase({t.a.index, t.b.index}), 1u);
      }
      for (const TouchEvent& t : e.sensor_begin) {
        EXPECT_TRUE(inside.insert({t.a.index, t.b.index}).second);
      }
      for (std::uint32_t a = 0; a < bodies.size(); ++a) {
        if (!bodies[a].sensor) continue;
        for (std::uint32_t b = 0; b < bodies.size(); ++b) {
          const bool told = inside.count({a, b}) != 0;
          if (a == b || (bodies[a].type == BodyType::static_body && bodies[b].type == BodyType::static_body)) {
            EXPECT_FALSE(told);
            continue;
          }
          const BodyState s = state(*world, world->id_of(a)), o = state(*world, world->id_of(b));
          const auto apart = [&](double dx, double dy) {  // with b moved aside by so much
            double least = 1e300;
            for (int x = -1; x <= 1; ++x) {
              for (int y = -1; y <= 1; ++y) {
                if (boundary != Boundary::periodic && (x != 0 || y != 0)) continue;
                const Vec2 at{o.x + 30 * x + dx, o.y + 30 * y + dy};
                if (std::hypot(at.x - s.x, at.y - s.y) > 10) continue;
                for (const ShapePart& p : parts[a]) {
                  for (const ShapePart& q : parts[b]) {
                    if (!tells(p, q)) continue;
                    for (const auto& mine : outlines(CompoundShape{{p}}, {s.x, s.y}, s.angle)) {
                      for (const auto& theirs : outlines(CompoundShape{{q}}, at, o.angle)) {
                        least = std::min(least, distance(mine, theirs));
                      }
                    }
                  }
                }
              }
            }
            return least;
          };
          const double fuzz = 1e-5, least = apart(0, 0);
          EXPECT_TRUE(!told || least < fuzz) << a << " " << b;
          if (!told && least == 0) {  // unless they only just touch
            EXPECT_GT(apart(fuzz, 0) + apart(-fuzz, 0) + apart(0, fuzz) + apart(0, -fuzz), 0) << a << " " << b;
          }
          seen += told ? 1 : 0;
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
