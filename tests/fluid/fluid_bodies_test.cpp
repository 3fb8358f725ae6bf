// Fluids and bodies: weight and buoyancy of every shape, what floats, walls that hold, and the same bits everywhere.
#include <cmath>

#include "base/rotor.h"
#include "fluid/fluid_solids.h"
#include "saved_support.h"

namespace psim::test {
namespace {

constexpr double kPace = 0.04;  // m between particles

ConvexOutline outline_of(std::initializer_list<Vec2> corners, double radius = 0, double angle = 0) {
  ConvexOutline o;
  o.radius = radius;
  for (const Vec2 c : corners) o.v[o.count++] = turned(sine_cosine(angle), c);
  return o;
}
ConvexOutline box_outline(double wide, double high, double angle = 0) {
  return outline_of({{-wide / 2, -high / 2}, {wide / 2, -high / 2}, {wide / 2, high / 2}, {-wide / 2, high / 2}}, 0,
                    angle);
}

// Water in a tank up to `top`, but not where a body is.
void pour(World& world, double wide, double top, const ConvexOutline& body = {}, Vec2 at = {}) {
  std::string error;
  const FluidId water = world.add_fluid({kPace, 1000, 0}, error);
  const FluidSolid solid = body.count > 0 ? fluid_solid(body, {}, 2 * static_cast<float>(kPace)) : FluidSolid();
  std::vector<Vec2> places;
  for (double y = kPace / 2; y < top; y += kPace) {
    for (double x = kPace / 2; x < wide; x += kPace) {
      Place2 out;
      const Place2 p{static_cast<float>(x - at.x), static_cast<float>(y - at.y)};
      if (body.count == 0 || solid.distance(p, out) > 0) places.push_back({x, y});
    }
  }
  ASSERT_TRUE(world.add_particles(water, places, {}, error)) << error;
}

BodyDesc box_at(Vec2 at, double wide, double high, double density) {
  BodyDesc d;
  d.shape =
      PolygonShape{{{-wide / 2, -high / 2}, {wide / 2, -high / 2}, {wide / 2, high / 2}, {-wide / 2, high / 2}}, 0};
  d.position = at;
  d.material.density = density;
  return d;
}

std::vector<FluidParticleState> particles_of(const World& world) {
  std::vector<FluidParticleState> all;
  world.fluid_particles(all);
  return all;
}

TEST(FluidSolids, SharesOfSquaresAddUpToTheArea) {
  Random random(1);
  const auto any = [](Random& r) { return r.uniform(-1, 1); };
  for (int k = 0; k < 200; ++k) {
    const double angle = 3 * any(random), wide = 0.5 + 0.4 * any(random), high = 0.5 + 0.4 * any(random);
    const double radius = k % 3 == 0 ? 0.1 : 0;
    ConvexOutline o = k % 4 == 1 ? outline_of({{0, 0}}, 0.4) : box_outline(wide, high, angle);
    if (k % 4 != 1) o.radius = radius;
    for (int v = 0; v < o.count; ++v) o.v[v] = o.v[v] + Vec2{0.01 * any(random), 0.01 * any(random)};
    const FluidSolid s = fluid_solid(o, {}, 0.04f);
    constexpr float kSide = 0.02f;
    double sum = 0;
    for (int j = -80; j < 80; ++j) {
      for (int i = -80; i < 80; ++i) {
        Place2 out;
        const float d =
            s.distance({(static_cast<float>(i) + 0.5f) * kSide, (static_cast<float>(j) + 0.5f) * kSide}, out);
        EXPECT_NEAR(out.x * out.x + out.y * out.y, 1, 1e-5);
        const float share = d > kSide ? 0 : d < -kSide ? 1 : share_within(d, out, kSide, kSide);
        sum += double{share} * double{kSide} * double{kSide};
      }
    }
    // In squares with a corner or an arc a straight edge is a little off.
    EXPECT_NEAR(sum, double{s.area}, double{kSide} * double{kSide}) << "shape " << k;
  }
}

TEST(FluidSolids, StopWhatComesFromAnywhere) {
  Random random(2);
  const auto any = [](Random& r) { return static_cast<float>(r.uniform(-1, 1)); };
  constexpr float kApart = 0.01f;
  for (int k = 0; k < 20000; ++k) {
    const ConvexOutline o = k % 3 == 0   ? outline_of({{0, 0}}, 0.3)
                            : k % 3 == 1 ? box_outline(0.5, 0.3, double{any(random)})
                                         : outline_of({{-0.4, 0}, {0.4, 0.1}});
    const FluidSolid s = fluid_solid(o, {}, 0.08f);
    const Place2 from{any(random), any(random)}, to{any(random), any(random)};
    Place2 out;
    if (s.distance(from, out) < kApart) continue;
    const Stop stop = stop_at(s, from, to, kApart, 0.1f);
    const Place2 end = stop.stopped ? stop.at : to;
    EXPECT_GE(s.distance(end, out), 0.99f * kApart) << "way " << k;
    if (k % 3 == 2 && std::fabs(from.x) < 0.35f && std::fabs(to.x) < 0.35f) {  // it ends on the side where it began
      const float side = from.y - 0.125f * from.x - 0.05f;
      EXPECT_GT(side * (end.y - 0.125f * end.x - 0.05f), 0) << "way " << k;
    }
  }
}

TEST(FluidBodies, WhatFloatsStaysWhereItFloats) {
  constexpr double kWide = 1, kHigh = 0.56;
  for (const double share : {0.25, 0.5, 0.75}) {
    const double at = 1 + kHigh * (0.5 - share);
    auto world = make(walled({0, 0, 4, 3}));
    const BodyId id = add(*world, box_at({2, at}, kWide, kHigh, 1000 * share));
    pour(*world, 4, 1, box_outline(kWide, kHigh), {2, at});
    // The lattice leaves out whole particles, so that the level is not quite 1 m.
    const double water = static_cast<double>(world->fluid_report().particles) * kPace * kPace;
    const double floats = (water + share * kWide * kHigh) / 4 + kHigh * (0.5 - share);
    double mean = 0;
    for (int k = 0; k < 600; ++k) {
      run(*world, 1);
      const BodyState s = state(*world, id);
      if (k >= 300) mean += s.y / 300;
      EXPECT_NEAR(s.y, at, 0.02) << k;
      EXPECT_NEAR(s.x, 2, 0.03) << k;
      EXPECT_NEAR(s.angle, 0, 0.03) << k;
    }
    EXPECT_NEAR(mean, floats, 0.003) << "density " << share;
  }
}

// Bodies as heavy as the water that they displace neither rise nor sink, whatever their shape.
TEST(FluidBodies, WhatIsAsHeavyAsWaterHovers) {
  const auto check = [](const BodyDesc& desc, const ConvexOutline& outline) {
    auto world = make(walled({0, 0, 2, 2}));
    const BodyId id = add(*world, desc);
    pour(*world, 2, 1.2, outline, desc.position);
    const double before = desc.position.y;
    run(*world, 60);
    const BodyState s = state(*world, id);
    // With a hundredth of its weight it would go 4 cm and more.
    EXPECT_NEAR(s.y, before, 0.02);
    EXPECT_NEAR(s.x, 1, 0.02);
  };
  BodyDesc round = disc({1, 0.6}, {}, 0.23);
  round.material.density = 1000;
  check(round, outline_of({{0, 0}}, 0.23));
  check(box_at({1, 0.61}, 0.5, 0.31, 1000), box_outline(0.5, 0.31));
  BodyDesc turned_box = box_at({1, 0.6}, 0.5, 0.3, 1000);
  turned_box.angle = 0.5;
  check(turned_box, box_outline(0.5, 0.3, 0.5));
}

// A stone sinks, a cork rises.
TEST(FluidBodies, HeavyBodiesSinkAndLightOnesRise) {
  for (const double density : {3000.0, 200.0}) {
    auto world = make(walled({0, 0, 2, 2}));
    const BodyId id = add(*world, box_at({1, 0.6}, 0.3, 0.3, density));
    pour(*world, 2, 1.2, box_outline(0.3, 0.3), {1, 0.6});
    run(*world, 90);
    const BodyState s = state(*world, id);
    if (density > 1000) {
      EXPECT_NEAR(s.y, 0.15, 0.02);
    } else {
      EXPECT_GT(s.y, 1.0);
    }
    EXPECT_LT(world->fluid_report().density_error_mean, 0.02);
  }
}

TEST(FluidBodies, NoWaterPassesAWallWithoutThickness) {
  for (const bool slanted : {false, true}) {
    auto world = make(walled({0, 0, 2.5, 2}));
    add(*world, segment({1.2, 0}, {slanted ? 1.5 : 1.2, 2}));
    pour(*world, 1.12, 1.2);
    run(*world, 300);
    for (const FluidParticleState& p : particles_of(*world)) {
      const double at = slanted ? 1.2 + 0.15 * p.position.y : 1.2;
      ASSERT_LT(p.position.x, at) << "particle " << p.id << " at height " << p.position.y;
    }
  }
}

TEST(FluidBodies, AJetDoesNotPassAThinWall) {
  auto world = make(walled({0, 0, 8, 4}));
  add(*world, segment({5, 0}, {5, 4}));
  std::string error;
  const FluidId water = world->add_fluid({kPace, 1000, 0}, error);
  std::vector<Vec2> places, velocities;
  for (int k = 0; k < 400; ++k) {
    places.push_back({1 + kPace * (k % 20), 1.5 + kPace * (k / 20)});
    velocities.push_back({50, 0});
  }
  ASSERT_TRUE(world->add_particles(water, places, velocities, error)) << error;
  for (int k = 0; k < 60; ++k) {
    run(*world, 1);
    for (const FluidParticleState& p : particles_of(*world)) ASSERT_LT(p.position.x, 5) << "frame " << k;
  }
}

// A film on a floor, and bodies that fall on it: they do not press it through the floor, and it comes out below them.
enum class Floor { line, plate, wall };

void expect_a_film_stays_above(Floor floor, double speed) {
  auto world = make(walled({0, floor == Floor::wall ? 1.0 : 0.0, 4, 3}));
  if (floor == Floor::line) add(*world, segment({0, 1}, {4, 1}));
  if (floor == Floor::plate) {
    BodyDesc plate = box_at({2, 0.98}, 4, 0.04, 1000);
    plate.type = BodyType::static_body;
    add(*world, plate);
  }
  std::string error;
  const FluidId water = world->add_fluid({kPace, 1000, 0}, error);
  std::vector<Vec2> places;
  for (double y = 1 + kPace / 2; y < 1 + 3 * kPace; y += kPace) {
    for (double x = kPace / 2; x < 4; x += kPace) places.push_back({x, y});
  }
  ASSERT_TRUE(world->add_particles(water, places, {}, error)) << error;
  constexpr auto kCell = static_cast<float>(2 * kPace);
  const ConvexOutline box = box_outline(0.6, 0.3);
  const double radius = 0.25;
  BodyDesc falls = box_at({1, 1.6}, 0.6, 0.3, 3000);
  falls.velocity = {0, -speed};
  const BodyId fallen = add(*world, falls);
  BodyDesc ball = disc({3, 1.6}, {0, -speed}, radius);
  ball.material.density = 3000;
  const BodyId rolled = add(*world, ball);
  for (int frame = 1; frame <= 90; ++frame) {
    run(*world, 1);
    const BodyState b = *world->body(fallen), d = *world->body(rolled);
    const FluidSolid solid = fluid_solid(outline_of({box.v[0], box.v[1], box.v[2], box.v[3]}, 0, b.angle), {}, kCell);
    for (const FluidParticleState& p : particles_of(*world)) {
      ASSERT_GT(p.position.y, 1 - 1e-4) << "frame " << frame << ", x " << p.position.x;
      if (frame < 30) continue;
      Place2 out;
      const Place2 from_box{static_cast<float>(p.position.x - b.x), static_cast<float>(p.position.y - b.y)};
      ASSERT_GT(solid.distance(from_box, out), -kPace) << "frame " << frame;
      ASSERT_GT(std::hypot(p.position.x - d.x, p.position.y - d.y), radius - kPace) << "frame " << frame;
    }
  }
}

TEST(FluidBodies, PressNoFilmThroughAFloor) {
  for (const Floor floor : {Floor::line, Floor::plate, Floor::wall}) {
    for (const double speed : {0.0, 5.0, 40.0}) {
      SCOPED_TRACE(testing::Message() << "floor " << static_cast<int>(floor) << ", " << speed << " m/s");
      expect_a_film_stays_above(floor, speed);
    }
  }
}

// A drum that turns, a paddle and discs: the same bits on all instruction sets and threads, and from a saved state.
std::unique_ptr<World> stirred(Isa isa, int threads) {
  auto world = make(walled({0, 0, 4, 3}), isa, threads);
  BodyDesc paddle = box_at({2, 0.6}, 1.2, 0.1, 1000);
  paddle.type = BodyType::kinematic_body;
  paddle.angular_velocity = 2;
  add(*world, paddle);
  for (int k = 0; k < 3; ++k) {
    BodyDesc d = disc({0.6 + 1.1 * k, 1.6}, {}, 0.15);
    d.material.density = 300 + 500 * k;
    add(*world, d);
  }
  pour(*world, 4, 1, box_outline(1.2, 0.1), {2, 0.6});
  return world;
}

TEST(FluidBodies, HaveTheSameBitsEverywhere) {
  const auto hash_of = [](Isa isa, int threads) {
    auto world = stirred(isa, threads);
    run(*world, 60);
    return world->state_hash();
  };
  const std::uint64_t expected = hash_of(Isa::scalar, 1);
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 2, 3}) EXPECT_EQ(hash_of(isa, threads), expected) << threads << " threads";
  }
}

TEST(FluidBodies, GoOnFromASavedState) {
  auto world = stirred(best_isa(), 1);
  run(*world, 40);
  expect_resumes(*world, 20, "bodies in water");
}

TEST(FluidBodies, ComeAndGo) {
  auto world = make(walled({0, 0, 2, 2}));
  pour(*world, 2, 1);
  for (int k = 0; k < 6; ++k) {
    const BodyId id = add(*world, disc({1, 0.8}, {0, -2}, 0.2));
    run(*world, 5);
    EXPECT_TRUE(world->remove_body(id));
    run(*world, 2);
  }
  for (const FluidParticleState& p : particles_of(*world)) {
    ASSERT_TRUE(std::isfinite(p.position.x + p.position.y) && length_of(p.velocity) < 20) << p.id;
  }
}

TEST(FluidBodies, SensorsAndFilteredShapesMeetNoWater) {
  auto world = make(walled({0, 0, 2, 2}));
  BodyDesc sensor = box_at({1, 0.5}, 0.6, 0.6, 1000);
  sensor.type = BodyType::static_body;
  sensor.sensor = true;
  add(*world, sensor);
  BodyDesc ghost = sensor;
  ghost.sensor = false;
  ghost.filter.mask = 0;
  add(*world, ghost);
  pour(*world, 2, 1);
  auto without = make(walled({0, 0, 2, 2}));
  pour(*without, 2, 1);
  run(*world, 30);
  run(*without, 30);
  const auto a = particles_of(*world), b = particles_of(*without);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) ASSERT_EQ(a[k].position, b[k].position);
}

}  // namespace
}  // namespace psim::test
