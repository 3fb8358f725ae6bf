// How much of a fluid is in a rectangle or in the sensors of a body, and what fluids do to a body.
#include "fluid_tank.h"

namespace psim::test {
namespace {

TEST(FluidAmounts, CountWhatIsInARectangle) {
  auto world = tank(kPitch, 0);
  std::string error;
  EXPECT_EQ(world->add_fluid({kPitch, 800, 0}, error), 1u);
  const std::vector<Vec2> places = {{0.5, 0.5}, {1, 1}, {1.2, 1}}, speeds = {{1, 0}, {0, 3}, {2, 1}};
  ASSERT_TRUE(world->add_particles(0, std::span(places).first(2), std::span(speeds).first(2), error)) << error;
  ASSERT_TRUE(world->add_particles(1, std::span(places).last(1), std::span(speeds).last(1), error)) << error;
  for (int k = 0; k < 2; ++k) {
    const FluidAmount all = world->fluid_in({0.9, 0.9, 1.5, 1.5});
    EXPECT_EQ(all.particles, 2u);
    EXPECT_NEAR(all.mass, 4.5, 1e-12);
    const FluidAmount water = world->fluid_in({0, 0, 2, 3}, 0);
    EXPECT_EQ(water.particles, 2u);
    EXPECT_NEAR(water.mass, 5, 1e-12);
    EXPECT_EQ(world->fluid_in({0, 0, 2, 3}, 1).particles, 1u);
    EXPECT_EQ(world->fluid_in({0, 0, 0.1, 0.1}).particles, 0u);
    EXPECT_EQ(world->fluid_in({0, 0, 0.1, 0.1}).mean_velocity, Vec2{});
    if (k == 0) {
      EXPECT_NEAR(all.mean_velocity.x, 4.0 / 4.5, 1e-6);
      EXPECT_NEAR(all.mean_velocity.y, (2.5 * 3 + 2) / 4.5, 1e-6);
    }
    world->step(1e-3);  // they are sorted by tiles now
  }
}

// A bucket is full after as long as its area takes.
TEST(FluidAmounts, ASensorTellsWhenABucketIsFull) {
  auto world = tank(0.025);
  CompoundShape bucket;
  const auto part = [&](Vec2 at, double wide, double high, bool sensor) {
    ShapePart p;
    p.shape = BoxShape{wide, high, 0};
    p.position = at;
    p.sensor = sensor;
    bucket.parts.push_back(p);
  };
  part({0, 0.025}, 0.9, 0.05, false);
  part({-0.425, 0.5}, 0.05, 1, false);
  part({0.425, 0.5}, 0.05, 1, false);
  part({0, 0.3}, 0.8, 0.5, true);  // 0.4 m^2 above the floor
  BodyDesc body = body_of(BodyType::static_body, {1, 0.5}, bucket);
  std::string error;
  const BodyId id = world->add_body(body, error);
  ASSERT_NE(id, kNoBody) << error;
  EXPECT_EQ(world->fluid_in_sensor(id)->particles, 0u);
  EmitterDesc desc = tap({1.1, 2}, {0.9, 2}, 0.5);
  desc.end = 7;  // 0.7 m^2, of which 0.72 fit
  open_tap(*world, desc);
  double before = 0;
  for (int second = 0; second < 10; ++second) {
    for (int k = 0; k < 60; ++k) world->step();
    const FluidAmount in = *world->fluid_in_sensor(id);
    EXPECT_NEAR(in.mass, 1000 * 0.000625 * static_cast<double>(in.particles), 1e-9);
    EXPECT_GE(in.mass, before - 10);
    before = in.mass;
    if (second == 1) {
      EXPECT_LT(in.mass, 200);
    }
  }
  EXPECT_NEAR(before, 400, 12);
  EXPECT_EQ(world->fluid_in_sensor(id, 1)->particles, 0u);
  EXPECT_FALSE(world->fluid_in_sensor(kNoBody).has_value());
  // It is the sensor that counts, and it moves with its body.
  const BodyId ball = world->add_body(body_of(BodyType::kinematic_body, {1, 0.8}, DiscShape{0.1}), error);
  EXPECT_EQ(world->fluid_in_sensor(ball)->particles, 0u);
  const BodyId feeler = world->add_body(sensor_disc({1, 0.8}, 0.1), error);
  EXPECT_NEAR(world->fluid_in_sensor(feeler)->mass, 1000 * kPi * 0.01, 6);
  world->set_transform(feeler, {0.2, 2.5}, 0);
  EXPECT_EQ(world->fluid_in_sensor(feeler)->particles, 0u);
}

TEST(FluidAmounts, ASensorAcrossTheSeamOfAPeriodicWorldSeesBothSides) {
  WorldDesc desc = walled({0, 0, 2, 2}, {});
  desc.boundary = Boundary::periodic;
  auto world = make(desc);
  std::string error;
  world->add_fluid({kPitch, 1000, 0}, error);
  const std::vector<Vec2> places = {{0.05, 1}, {1.95, 1}, {0.3, 1}, {1, 1}};
  ASSERT_TRUE(world->add_particles(0, places, {}, error)) << error;
  const BodyId id = world->add_body(sensor_disc({0, 1}, 0.2), error);
  EXPECT_EQ(world->fluid_in_sensor(id)->particles, 2u);
}

TEST(FluidLoads, AStaticBoxCarriesItsBuoyancy) {
  auto world = tank(0.04);
  fill_up_to(*world, 1.2, 0.04);
  std::string error;
  const BodyId box = world->add_body(body_of(BodyType::static_body, {1, 0.6}, BoxShape{0.4, 0.3, 0}), error);
  const BodyId dry = world->add_body(body_of(BodyType::static_body, {1, 2.5}, BoxShape{0.4, 0.3, 0}), error);
  EXPECT_EQ(world->fluid_load(box)->force, Vec2{});
  double sum = 0;
  for (int k = 0; k < 900; ++k) {
    world->step();
    if (k >= 600) sum += world->fluid_load(box)->force.y / 300;
  }
  EXPECT_NEAR(sum, 1000 * kG * 0.12, 0.02 * 1000 * kG * 0.12);
  EXPECT_EQ(world->fluid_load(dry)->force, Vec2{});
  EXPECT_EQ(world->fluid_load(dry)->torque, 0);
  EXPECT_FALSE(world->fluid_load(kNoBody).has_value());
  world->remove_body(box);
  EXPECT_FALSE(world->fluid_load(box).has_value());
}

}  // namespace
}  // namespace psim::test
