// Surfaces that run like belts, resist rolling, or are solid from one side, against closed forms.
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

Material belt(double speed, double friction = 0.5) {
  Material m = material(0, friction);
  m.tangent_speed = speed;
  return m;
}

Material rolling(double resistance, double friction = 1) {
  Material m = material(0, friction);
  m.rolling_resistance = resistance;
  return m;
}

BodyDesc made_of(BodyDesc body, const Material& m) {
  body.material = m;
  return body;
}

BodyDesc solid_from(BodyDesc body, Vec2 way) {
  body.one_way = way;
  return body;
}

BodyDesc segment(Vec2 p1, Vec2 p2, Material m = {}) {
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = SegmentShape{p1, p2};
  body.material = m;
  return body;
}

WorldDesc open_world(Vec2 gravity = {0, -kG}) {
  WorldDesc desc = unbounded(500, gravity);
  desc.sleeping = false;
  return desc;
}

// Floors with their top at y = 0 that are made of a material, each in its own way.
struct BeltFloor {
  const char* name;
  std::function<void(WorldDesc&, const Material&)> world;
  std::function<void(World&, const Material&)> build;
};

std::vector<BeltFloor> belt_floors() {
  const auto none = [](WorldDesc&, const Material&) {};
  return {{"segment", none,
           [](World& w, const Material& m) {
             add(w, segment({-200, 0}, {200, 0}, m));
           }},
          {"box", none,
           [](World& w, const Material& m) {
             add(w, made_of(fixed(box({0, -1}, 400, 2)), m));
           }},
          {"tiles", none,
           [](World& w, const Material& m) {
             for (int k = -60; k < 60; ++k) add(w, made_of(fixed(box({k + 0.5, -0.5})), m));
           }},
          {"chain", none,
           [](World& w, const Material& m) {
             BodyDesc body;
             body.type = BodyType::static_body;
             ChainShape chain;
             for (int k = 60; k >= -60; --k) chain.vertices.push_back({1.0 * k, 0});
             chain.materials.assign(120, m);
             body.shape = chain;
             add(w, body);
           }},
          {"kinematic", none,
           [](World& w, const Material& m) {
             add(w, made_of(kinematic(box({0, -1}, 400, 2)), m));
           }},
          {"part", none,
           [](World& w, const Material& m) {
             BodyDesc body;
             body.type = BodyType::static_body;
             ShapePart part{BoxShape{400, 2}, {0, -1}};
             part.friction = m.friction;
             part.tangent_speed = m.tangent_speed;
             part.rolling_resistance = m.rolling_resistance;
             body.shape = CompoundShape{{part, {DiscShape{1}, {0, 300}}}};
             add(w, body);
           }},
          {"wall",
           [](WorldDesc& desc, const Material& m) {
             desc.boundary = Boundary::walls;
             desc.bounds = {-250, 0, 250, 400};
             desc.wall = m;
           },
           [](World&, const Material&) {}}};
}

// A box slides until it goes as fast as the belt; a disc until its lowest point does.
TEST(Surfaces, BeltsCarryWhatLiesOnThem) {
  for (const BeltFloor& floor : belt_floors()) {
    for (const double speed : {2.0, -3.0}) {
      WorldDesc desc = open_world();
      floor.world(desc, belt(speed));
      auto world = make(desc);
      floor.build(*world, belt(speed));
      const Material rubs = material(0, 0.5);
      const BodyId lying = add(*world, box({0, 0.25}, 0.5, 0.5, rubs));
      const BodyId round = add(*world, disc({10, 0.5}, {}, 0.5, rubs));
      const BodyId special = add(*world, made_of(disc({-10, 0.5}), rolling(1e-6, 0.5)));  // a disc with a hull
      const BodyId rod = add(*world, capsule({20, 0.2}, 1, 0.2, rubs));
      run(*world, 120);
      const double a = 0.5 * kG, t = 2, slides = std::abs(speed) / a,
                   way = std::copysign(a * slides * slides / 2, speed);
      for (const auto& [id, from] : {std::pair(lying, 0.0), std::pair(rod, 20.0)}) {
        EXPECT_NEAR(state(*world, id).vx, speed, 1e-3) << floor.name;
        EXPECT_NEAR(state(*world, id).x - from, way + speed * (t - slides), 0.02) << floor.name;
      }
      for (const BodyId id : {round, special}) {
        EXPECT_NEAR(state(*world, id).vx, speed / 3, 4e-3) << floor.name;
        EXPECT_NEAR(state(*world, id).omega * 0.5, speed * 2 / 3, 4e-3) << floor.name;
      }
    }
  }
}

TEST(Surfaces, ABodyWithABeltDrivesItself) {
  for (const bool round : {false, true}) {
    auto world = make(open_world());
    add(*world, segment({-200, 0}, {200, 0}, material(0, 0.8)));
    BodyDesc tank = round ? disc({0, 0.5}) : box({0, 0.5}, 3, 1);
    tank.fixed_rotation = round;
    const BodyId id = add(*world, made_of(tank, belt(4, 0.8)));
    run(*world, 120);
    EXPECT_NEAR(state(*world, id).vx, 4, 1e-3) << round;
  }
}

// What two free bodies do to each other changes neither momentum nor angular momentum.
TEST(Surfaces, MomentumStays) {
  WorldDesc desc = open_world({0, 0});
  auto world = make(desc);
  Random r(3);
  for (int k = 0; k < 40; ++k) {
    BodyDesc body = k % 2 == 0 ? disc({}, {}, 0.5) : box({}, 0.9, 0.7);
    body.position = {0.8 * (k % 7), 0.8 * (k / 7)};
    body.velocity = {2 - 0.7 * (k % 7), 2 - 0.7 * (k / 7)};
    body.material = material(0, 0.7);
    if (r.chance(0.6)) body.material.tangent_speed = r.uniform(-3, 3);
    if (r.chance(0.6)) body.material.rolling_resistance = r.uniform(0, 0.5);
    add(*world, body);
  }
  const Diagnostics before = world->diagnostics();
  run(*world, 120);
  const Diagnostics after = world->diagnostics();
  EXPECT_NEAR(after.momentum_x, before.momentum_x, 2e-4);
  EXPECT_NEAR(after.momentum_y, before.momentum_y, 2e-4);
  EXPECT_NEAR(after.angular_momentum, before.angular_momentum, 2e-3);
}

// v' = -2/3 c g, for c of either side.
TEST(Surfaces, RollingResistanceStopsADisc) {
  for (const BeltFloor& floor : belt_floors()) {
    for (const bool own : {false, true}) {
      const double c = 0.05;
      const Material of_floor = own ? material(0, 1) : rolling(c);
      WorldDesc desc = open_world();
      floor.world(desc, of_floor);
      auto world = make(desc);
      floor.build(*world, of_floor);
      BodyDesc wheel = moving(disc({0, 0.5}), {3, 0}, -6);
      wheel.material = own ? rolling(c) : material(0, 1);
      const BodyId id = add(*world, wheel);
      run(*world, 300);
      EXPECT_NEAR(state(*world, id).vx, 3 - 2.0 / 3 * c * kG * 5, 0.01) << floor.name << own;
      run(*world, 600);
      EXPECT_NEAR(state(*world, id).x, 0.75 * 9 / (c * kG), 0.05) << floor.name << own;
      EXPECT_NEAR(state(*world, id).vx, 0, 1e-4) << floor.name << own;
    }
  }
}

// On a slope a disc stays where its tangent is less than c, else it rolls with 2/3 g (sin - c cos).
TEST(Surfaces, RollingResistanceHoldsADiscOnASlope) {
  constexpr double kResistance = 0.1;
  for (const double slope : {0.05, 0.09, 0.11, 0.2, 0.4}) {
    auto world = make(open_world());
    add(*world, segment({-300 * std::cos(slope), 300 * std::sin(slope)},
                        {300 * std::cos(slope), -300 * std::sin(slope)}, rolling(kResistance)));
    const BodyId id = add(*world, made_of(disc({0.5 * std::sin(slope), 0.5 * std::cos(slope)}), rolling(kResistance)));
    run(*world, 120);
    const double pull = 2.0 / 3 * kG * (std::sin(slope) - kResistance * std::cos(slope));
    EXPECT_NEAR(speed_of(state(*world, id)), 2 * std::max(pull, 0.0), 0.01) << slope;
    if (pull < 0) {
      EXPECT_NEAR(state(*world, id).x, 0.5 * std::sin(slope), 1e-3) << slope;
    }
  }
}

// Each segment of a chain has a surface of its own, and the way over their joints is smooth.
TEST(Surfaces, SegmentsOfAChainDiffer) {
  auto world = make(open_world());
  BodyDesc body;
  body.type = BodyType::static_body;
  body.shape = ChainShape{{{100, 0}, {10, 0}, {0, 0}, {-100, 0}}, false, {material(0, 0), belt(5), material(0, 0)}};
  add(*world, body);
  const BodyId lying = add(*world, box({0.5, 0.25}, 0.5, 0.5, material(0, 0.5)));
  run(*world, 30);
  EXPECT_NEAR(state(*world, lying).vx, 0.5 * kG * 0.5, 0.05);
  run(*world, 210);
  EXPECT_GT(state(*world, lying).x, 12);
  EXPECT_NEAR(state(*world, lying).vx, 5, 1e-3);
  EXPECT_NEAR(state(*world, lying).y, 0.25, 1e-3);
  std::string error;
  body.shape = ChainShape{{{0, 0}, {1, 0}}, false, {belt(5), belt(5)}};
  EXPECT_EQ(world->add_body(body, error), kNoBody);
  EXPECT_EQ(error, "the materials of a chain must be as many as its segments, or none");
}

struct Platform {
  const char* name;
  BodyDesc body;
};

// Platforms with their top at y = 3, solid from above.
std::vector<Platform> platforms() {
  BodyDesc chain;
  chain.type = BodyType::static_body;
  chain.shape = ChainShape{{{6, 0}, {2, 0}, {-1, 0}, {-6, 0}}, false, {}};
  chain.position = {0, 3};
  BodyDesc part;
  part.type = BodyType::static_body;
  part.position = {0, 3};
  ShapePart top{BoxShape{12, 0.3}, {0, -0.15}};
  top.one_way = Vec2{0, 5};
  part.shape = CompoundShape{{top, {DiscShape{0.3}, {40, 0}}}};
  BodyDesc line = segment({-6, 0}, {6, 0});
  line.position = {0, 3};
  BodyDesc leaning = segment({0, -6}, {0, 6});  // turned by a quarter
  leaning.position = {0, 3};
  leaning.angle = kPi / 2;
  return {{"segment", solid_from(line, {0, 1})},
          {"turned segment", solid_from(leaning, {1, 0})},
          {"chain", solid_from(chain, {0, 1})},
          {"box", solid_from(fixed(box({0, 2.85}, 12, 0.3)), {0, 2})},
          {"part", part},
          {"kinematic", solid_from(kinematic(box({0, 2.85}, 12, 0.3)), {0, 1})}};
}

TEST(Surfaces, OneWayPlatformsHoldWhatComesFromAbove) {
  for (const Platform& platform : platforms()) {
    for (const double speed : {8.7, 15.0, 60.0}) {
      for (const int kind : {0, 1, 2, 3}) {
        WorldDesc desc = open_world();
        auto world = make(desc);
        add(*world, platform.body);
        const auto body = [&](Vec2 at, double v) {
          BodyDesc b = kind == 0 ? disc(at, {}, 0.4) : kind == 1 ? box(at, 0.8, 0.8) : capsule(at, 0.6, 0.4);
          if (kind == 3) b = made_of(disc(at, {}, 0.4), rolling(0.01));
          return moving(b, {0, v});
        };
        const BodyId rises = add(*world, body({-2, 1}, speed)), falls = add(*world, body({2, 8}, -speed));
        double top = 0;
        for (int k = 0; k < 900; ++k) {
          run(*world, 1);
          top = std::max(top, state(*world, rises).y);
        }
        const std::string where = std::string(platform.name) + " " + std::to_string(speed) + " " + std::to_string(kind);
        EXPECT_GT(top, 1 + 0.95 * speed * speed / 2 / kG - 0.05) << where;  // nothing slows it
        EXPECT_NEAR(state(*world, rises).y, 3.4, 0.01) << where;
        EXPECT_NEAR(state(*world, falls).y, 3.4, 0.01) << where;
      }
    }
  }
}

// One that turns back while it is in the platform falls through.
TEST(Surfaces, WhatTurnsBackWithinAOneWayPlatformFalls) {
  for (const Platform& platform : platforms()) {
    for (const double top : {2.75, 2.9, 3.0, 3.1, 3.2, 3.3}) {
      auto world = make(open_world());
      add(*world, platform.body);
      const BodyId id = add(*world, moving(disc({-2, 1}, {}, 0.4), {0, std::sqrt(2 * kG * (top - 1))}));
      run(*world, 200);
      EXPECT_LT(state(*world, id).y, -5) << platform.name << " " << top;
    }
  }
}

// Everybody thrown about: the same on all instruction sets and numbers of threads, saved, and replayed.
TEST(Surfaces, GoOnWithTheSameBits) {
  std::vector<std::uint64_t> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      WorldDesc desc = walled({-12, 0, 12, 24}, {0, -kG});
      desc.wall.friction = 0.5;
      desc.wall.tangent_speed = 1;
      auto world = make(desc, isa, threads);
      Recorder recorder(*world);
      Random r(11);
      std::string error;
      std::vector<BodyId> ids;
      for (int k = 0; k < 150; ++k) {
        BodyDesc body = k % 3 == 0 ? box({}, 0.8, 0.6) : disc({}, {}, 0.4);
        body.position = {r.uniform(-11, 11), r.uniform(1, 23)};
        body.material = material(r.chance(0.3) ? 0.6 : 0, 0.6);
        if (r.chance(0.3)) body.material.tangent_speed = r.uniform(-3, 3);
        if (r.chance(0.3)) body.material.rolling_resistance = r.uniform(0, 0.4);
        if (r.chance(0.1)) body.one_way = {r.uniform(-1, 1), r.uniform(-1, 1)};
        if (k % 10 == 0) body.type = k % 20 == 0 ? BodyType::static_body : BodyType::kinematic_body;
        if (k % 20 == 10) body.angular_velocity = 1;
        ids.push_back(recorder.add_body(body, error));
      }
      std::vector<std::uint64_t> hashes;
      std::vector<std::byte> saved;
      for (std::size_t frame = 0; frame < 240; ++frame) {
        recorder.step();
        if (frame % 60 == 59) {
          BodyTraits traits = world->traits(ids[frame / 2]).value();
          traits.tangent_speed = 2;
          traits.rolling_resistance = 0.1;
          ASSERT_TRUE(recorder.set_traits(ids[frame / 2], traits));
        }
        if (frame == 120) world->save(saved);
        if (frame % 40 == 39) hashes.push_back(world->state_hash());
      }
      if (first.empty()) first = hashes;
      EXPECT_EQ(hashes, first) << isa_name(isa) << threads;
      const auto replay = Replay::open(recorder.recording(), {isa, threads}, error);
      ASSERT_TRUE(replay) << error;
      while (replay->next()) {
      }
      EXPECT_TRUE(replay->complete() && replay->differs_at() == 0) << replay->differs_at();
      auto other = World::from_state(saved, {isa, threads}, error);
      ASSERT_TRUE(other) << error;
      for (int frame = 121; frame < 160; ++frame) other->step();
      EXPECT_EQ(other->state_hash(), hashes[3]) << isa_name(isa) << threads;
    }
  }
}

}  // namespace
}  // namespace psim::test
