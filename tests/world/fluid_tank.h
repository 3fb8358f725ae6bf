// A tank of water, 2 m wide and 3 m high, with taps and drains.
#pragma once

#include "saved_support.h"

namespace psim::test {

inline constexpr double kPitch = 0.05;  // m between particles

inline BodyDesc body_of(BodyType type, Vec2 at, const Shape& shape) {
  BodyDesc d;
  d.type = type;
  d.shape = shape;
  d.position = at;
  return d;
}

inline BodyDesc sensor_disc(Vec2 at, double radius) {
  BodyDesc d = body_of(BodyType::kinematic_body, at, DiscShape{radius});
  d.sensor = true;
  return d;
}

inline std::unique_ptr<World> tank(double spacing = kPitch, double gravity = kG, Isa isa = best_isa(),
                                   int threads = 1) {
  auto world = make(walled({0, 0, 2, 3}, {0, -gravity}), isa, threads);
  std::string error;
  EXPECT_EQ(world->add_fluid({spacing, 1000, 0}, error), 0u) << error;
  return world;
}

inline EmitterId open_tap(World& world, const EmitterDesc& desc) {
  std::string error;
  const EmitterId id = world.add_emitter(desc, error);
  EXPECT_NE(id, kNoEmitter) << error;
  return id;
}

inline EmitterDesc tap(Vec2 from, Vec2 to, double speed) {
  EmitterDesc d;
  d.from = from;
  d.to = to;
  d.speed = speed;
  return d;
}

inline void open_drain(World& world, const Bounds& region) {
  std::string error;
  EXPECT_NE(world.add_drain(region, error), kNoDrain) << error;
}

// Water up to `top`.
inline void fill_up_to(World& world, double top, double spacing = kPitch) {
  std::vector<Vec2> places;
  for (double y = spacing / 2; y < top; y += spacing) {
    for (double x = spacing / 2; x < 2; x += spacing) places.push_back({x, y});
  }
  std::string error;
  ASSERT_TRUE(world.add_particles(0, places, {}, error)) << error;
}

inline std::vector<FluidParticleState> drops(const World& world) {
  std::vector<FluidParticleState> all;
  world.fluid_particles(all);
  return all;
}

}  // namespace psim::test
