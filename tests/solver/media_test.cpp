// Wind and water (WindField, BuoyancyField) against closed forms.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "rigid_support.h"

namespace psim::test {
namespace {

BuoyancyField lake(double density, double damping = 0) {
  BuoyancyField water;
  water.region = {-100, -50, 100, 0};
  water.density = density;
  water.linear_damping = water.angular_damping = damping;
  return water;
}

WorldDesc with(std::vector<Field> fields, Vec2 gravity = {0, -kG}, int substeps = 4) {
  WorldDesc desc = unbounded(500, gravity);
  desc.sleeping = false;
  desc.fields = std::move(fields);
  desc.substeps = substeps;
  return desc;
}

BodyDesc dense(BodyDesc body, double density) {
  body.material.density = density;
  return body;
}

// ---- water

TEST(Media, WhatFloatsDisplacesItsMass) {
  struct Case {
    BodyDesc body;
    double density, depth;  // of the body; of its centre below the surface
  };
  // A disc under water up to the angle t on each side has the area r^2 (t - sin t cos t), its centre r cos(t) above.
  const auto disc_depth = [](double share) {
    double low = 0, high = kPi;
    for (int k = 0; k < 60; ++k) {
      const double t = (low + high) / 2;
      (t - std::sin(t) * std::cos(t) < kPi * share ? low : high) = t;
    }
    return -std::cos(low);
  };
  const Case cases[] = {{box({0, 1}, 4, 1), 500, 0},
                        {box({0, 1}, 4, 1), 800, 0.3},
                        {box({0, 1}, 4, 1), 100, -0.4},
                        {disc({0, 2}, {}, 1), 500, 0},
                        {disc({0, 2}, {}, 1), 250, disc_depth(0.25)},
                        {disc({0, 2}, {}, 1), 900, disc_depth(0.9)},
                        {capsule({0, 1}, 3, 0.5), 500, 0}};
  for (const int substeps : {1, 4}) {
    for (const Case& c : cases) {
      auto world = make(with({lake(1000, 10)}, {0, -kG}, substeps));
      const BodyId id = add(*world, dense(c.body, c.density));
      run(*world, 3000);
      EXPECT_NEAR(state(*world, id).y, -c.depth, 0.004) << c.density;
      EXPECT_NEAR(state(*world, id).vy, 0, 1e-4);
      EXPECT_NEAR(std::remainder(state(*world, id).angle, kPi), 0, 1e-3);
    }
  }
}

TEST(Media, WhatIsWhollyUnderRisesEvenly) {
  for (const BodyDesc& body : {disc({0, -40}), box({0, -40}), capsule({0, -40}, 1, 0.3)}) {
    auto world = make(with({lake(1500)}));
    const BodyId id = add(*world, dense(body, 1000));
    run(*world, 60);
    EXPECT_NEAR(state(*world, id).vy, 0.5 * kG, 2e-3 * kG);
    EXPECT_NEAR(state(*world, id).y, -40 + 0.25 * kG, 2e-3 * kG);
    EXPECT_NEAR(state(*world, id).omega, 0, 1e-4);
  }
}

// A box with vertical sides swings about its draught with w^2 = g / draught, and keeps its energy.
TEST(Media, ABoxBobsWithItsPeriod) {
  for (const int substeps : {1, 4, 8}) {
    auto world = make(with({lake(1000)}, {0, -kG}, substeps));
    const BodyId id = add(*world, dense(box({0, 0.1}, 4, 1), 500));
    const double period = 2 * kPi / std::sqrt(kG / 0.5);
    double first = -1, last = -1, most = 0, before = state(*world, id).y;
    int crossings = 0;
    for (int k = 1; k <= 1800; ++k) {
      world->step();
      const double y = state(*world, id).y;
      if (before < 0 && y >= 0) {
        last = (k - y / (y - before)) / 60;
        if (first < 0) first = last;
        ++crossings;
      }
      before = y;
      if (k > 1600) most = std::max(most, std::fabs(y));
    }
    EXPECT_NEAR((last - first) / (crossings - 1), period, 2e-3 * period);
    EXPECT_NEAR(most, 0.1, 2e-3);
  }
}

// The metacentre of a box of the width b that floats by the draught d lies b^2 / (12 d) above the middle of the draught.
TEST(Media, AWideBoxRightsItselfAndATallOneTips) {
  for (const auto& [width, height] :
       {std::pair{2.0, 1.0}, std::pair{1.0, 2.0}, std::pair{1.0, 1.3}, std::pair{1.6, 1.0}}) {
    const double draught = height / 2, lever = width * width / (12 * draught) - (height / 2 - draught / 2);
    auto world = make(with({lake(1000, 1)}));
    BodyDesc body = dense(box({0, 0}, width, height), 500);
    body.angle = 0.05;
    const BodyId id = add(*world, body);
    run(*world, 600);
    EXPECT_EQ(std::fabs(state(*world, id).angle) < 0.02, lever > 0) << width << " x " << height;
  }
}

TEST(Media, WaterSlowsAndCarries) {
  BuoyancyField water = lake(1000, 0.7);
  water.flow = {2, 0};
  auto world = make(with({water}));
  BodyDesc body = dense(box({0, -20}), 1000);
  body.velocity = {-3, 0};
  body.angular_velocity = 5;
  const BodyId id = add(*world, body);
  for (int k = 1; k <= 180; ++k) {
    world->step();
    const double t = k / 60.0, left = std::exp(-0.7 * t);
    ASSERT_NEAR(state(*world, id).vx, 2 - 5 * left, 2e-3);
    ASSERT_NEAR(state(*world, id).omega, 5 * left, 2e-3);
    ASSERT_NEAR(state(*world, id).vy, 0, 2e-3);
  }
}

// The parts of a body that are in a side of a region, or in a corner, are lifted alone.
TEST(Media, TheShareInARegion) {
  BuoyancyField water = lake(1000);
  water.region = {0, -10, 10, 10};
  const auto lifted = [&](Vec2 at, const BodyDesc& body) {
    WorldDesc desc = with({water}, {0, -1});
    desc.dt = 1e-3;
    auto world = make(desc);
    BodyDesc placed = dense(body, 1000);
    placed.position = at;
    const BodyId id = add(*world, placed);
    world->step();
    return state(*world, id).vy / 1e-3 + 1;  // of 1 m/s^2
  };
  for (const BodyDesc& body : {box({}), disc({}), capsule({}, 1, 0.25)}) {
    EXPECT_NEAR(lifted({0, 0}, body), 0.5, 2e-3);
    EXPECT_NEAR(lifted({0, 10}, body), 0.25, 2e-3);
    EXPECT_NEAR(lifted({10, -10}, body), 0.25, 2e-3);
    EXPECT_NEAR(lifted({5, 0}, body), 1, 2e-3);
    EXPECT_NEAR(lifted({-2, 0}, body), 0, 1e-6);
  }
}

// ---- wind

TEST(Media, AFallingDiscTendsToItsTerminalSpeed) {
  for (const int substeps : {1, 4}) {
    WindField air;
    air.density = 0.05;
    air.drag = 0.8;
    auto world = make(with({air}, {0, -kG}, substeps));
    const BodyId id = add(*world, disc({0, 400}, {}, 0.5, material(0, 0, 1)));
    const double mass = kPi * 0.25, terminal = std::sqrt(mass * kG / (0.5 * 0.05 * 0.8 * 1));
    for (int k = 1; k <= 240; ++k) {
      world->step();
      const double expected = -terminal * std::tanh(kG * k / 60 / terminal);
      ASSERT_NEAR(state(*world, id).vy, expected, 0.01 * terminal) << k;
    }
  }
}

// A rod that leans by the angle a to the wind is pushed along it by drag, and to the side by lift.
TEST(Media, DragAndLiftOfARod) {
  for (const double angle : {0.3, 0.8, -0.5, 1.2, kPi / 2}) {
    WindField wind;
    wind.velocity = {10, 0};
    wind.density = 0.01;
    wind.drag = 0.7;
    wind.lift = 1.5;
    WorldDesc desc = with({wind}, {0, 0});
    desc.dt = 1e-3;
    auto world = make(desc);
    BodyDesc rod;
    rod.shape = SegmentShape{{-1, 0}, {1, 0}};
    rod.angle = angle;
    const BodyId id = add(*world, rod);  // 2 kg
    world->step();
    const double facing = std::fabs(std::sin(angle)), width = 2 * facing, u2 = 100;
    const double along = 0.7 * 0.01 * width * u2 / 2, side = 1.5 * 0.01 * width * u2 / 2;
    // The face that meets the wind looks up where the rod rises along the wind: it is pushed down.
    const double lean = -std::cos(angle) * (std::sin(angle) > 0 ? 1 : -1);
    EXPECT_NEAR(state(*world, id).vx * 1000 * 2, along, 1e-3 * along + 1e-6) << angle;
    EXPECT_NEAR(state(*world, id).vy * 1000 * 2, side * lean, 1e-3 * side + 1e-6) << angle;
    EXPECT_NEAR(state(*world, id).omega, 0, 1e-6);
  }
}

TEST(Media, NothingGetsFasterThanTheWind) {
  Random random(5);
  for (int k = 0; k < 60; ++k) {
    WindField wind;
    wind.velocity = {random.uniform(-100, 100), random.uniform(-100, 100)};
    wind.density = std::pow(10.0, random.uniform(-2, 6));
    wind.lift = random.chance(0.5) ? 0 : random.uniform(0, 1);
    auto world = make(with({wind}, {0, 0}));
    BodyDesc body = k % 3 == 0 ? box({}, 1, 0.3) : k % 3 == 1 ? disc({}) : capsule({}, 1, 0.2);
    body.angle = random.uniform(-3, 3);
    const BodyId id = add(*world, body);
    const double most = std::hypot(wind.velocity.x, wind.velocity.y);
    for (int n = 0; n < 200; ++n) {
      world->step();
      const BodyState s = state(*world, id);
      ASSERT_LE(std::hypot(s.vx, s.vy), (wind.lift > 0 ? 1.5 : 1.0001) * most) << k;
      ASSERT_LE(std::fabs(s.omega), 10 * most) << k;
    }
  }
}

TEST(Media, RegionsMasksAndKinds) {
  WindField wind;
  wind.velocity = {10, 0};
  wind.region = Bounds{-5, -5, 5, 5};
  wind.mask = 2;
  auto world = make(with({wind}, {0, 0}));
  BodyDesc body = disc({0, 0});
  body.filter.category = 2;
  const BodyId blown = add(*world, body);
  body.position = {0, 20};
  const BodyId outside = add(*world, body);
  body.position = {0, 3};
  body.filter.category = 1;
  const BodyId masked = add(*world, body);
  body.filter.category = 2;
  body.position = {0, -3};
  body.sensor = true;
  const BodyId sensor = add(*world, body);
  body.sensor = false;
  body.position = {3, 0};
  const BodyId held = add(*world, kinematic(body));
  run(*world, 10);
  EXPECT_GT(state(*world, blown).vx, 1);
  for (const BodyId id : {outside, masked, sensor, held}) EXPECT_EQ(state(*world, id).vx, 0);

  // They come, go and move while the world runs.
  std::string error;
  const double before = state(*world, blown).vx;
  ASSERT_TRUE(world->set_fields({}, error));
  run(*world, 5);
  EXPECT_EQ(state(*world, blown).vx, before);
  wind.region = Bounds{-5, 15, 5, 25};
  ASSERT_TRUE(world->set_fields({wind}, error));
  run(*world, 5);
  EXPECT_EQ(state(*world, blown).vx, before);
  EXPECT_GT(state(*world, outside).vx, 1);
}

TEST(Media, BadNumbersAreRefused) {
  auto world = make(with({}));
  std::string error;
  const auto refused = [&](const Field& field, const char* what) {
    EXPECT_FALSE(world->set_fields({field}, error));
    EXPECT_NE(error.find(what), std::string::npos) << error;
    EXPECT_TRUE(world->desc().fields.empty());
  };
  for (const double bad : {kNan, -1.0, kInf}) {
    BuoyancyField water = lake(1);
    water.density = bad;
    refused(water, "the water's density");
    water = lake(1, bad);
    refused(water, "the water's linear damping");
    WindField wind;
    wind.drag = bad;
    refused(wind, "the wind's drag");
    wind = {};
    wind.region = Bounds{0, 0, bad, 1};
    refused(wind, "the wind's region");
  }
  BuoyancyField empty = lake(1);
  empty.region = {0, 0, 0, 0};
  refused(empty, "the water's region");
}

// ---- with all else

std::uint64_t stormy(Isa isa, int threads, bool resumed, Integrator integrator = Integrator::verlet,
                     bool well = false) {
  WindField wind;
  wind.velocity = {8, 1};
  wind.density = 0.05;
  wind.lift = 0.5;
  std::vector<Field> fields{lake(2, 1), wind};
  if (well) fields.emplace_back(WellField{{0, 30}, 20, 1});
  WorldDesc desc = with(fields);
  desc.bounds = {-60, -40, 60, 60};
  desc.boundary = Boundary::walls;
  desc.integrator = integrator;
  auto world = make(desc, isa, threads);
  Random random(9);
  for (int k = 0; k < 400; ++k) {
    BodyDesc body = k % 3 == 0 ? disc({}) : k % 3 == 1 ? box({}) : capsule({}, 0.6, 0.2);
    body.position = {random.uniform(-50, 50), random.uniform(-30, 50)};
    body.angle = random.uniform(-3, 3);
    body.material.friction = 0.3;
    body.material.density = random.uniform(0.5, 4);
    add(*world, body);
  }
  for (int k = 0; k < 60; ++k) {
    world->step();
    if (!resumed || k % 20 != 10) continue;
    std::vector<std::byte> state;
    std::string error;
    world->save(state);
    world = World::from_state(state, {isa, threads}, error);
    EXPECT_NE(world, nullptr) << error;
  }
  return world->state_hash();
}

TEST(Media, TheSameEverywhere) {
  for (const Integrator integrator : {Integrator::verlet, Integrator::rk4}) {
    for (const bool well : {false, true}) {
      const std::uint64_t hash = stormy(Isa::scalar, 1, false, integrator, well);
      for (const Isa isa : available_isas()) {
        for (const int threads : {1, 3}) EXPECT_EQ(stormy(isa, threads, threads == 3, integrator, well), hash);
      }
    }
  }
}

TEST(Media, AWorldWithoutThemHasNoColumnsForThem) {
  auto world = make(with({}));
  for (int k = 0; k < 1000; ++k) add(*world, disc({k * 0.4 - 200, 5 + k % 7 * 1.1}));
  const auto bytes = [&] {
    for (const PlanEntry& entry : world->plan()) {
      if (entry.stage == "forces") return entry.bytes;
    }
    return std::size_t{1};
  };
  run(*world, 3);
  EXPECT_EQ(bytes(), 0u);
  std::string error;
  ASSERT_TRUE(world->set_fields({WindField{{5, 0}}}, error));
  run(*world, 3);
  EXPECT_GT(bytes(), 1000 * 12u);
  ASSERT_TRUE(world->set_fields({}, error));
  run(*world, 3);
  EXPECT_EQ(bytes(), 0u);
}

}  // namespace
}  // namespace psim::test
