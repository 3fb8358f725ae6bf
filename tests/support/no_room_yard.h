// A world with something of everything, for the tests of calls without memory. Public API only.
#pragma once

#include "psim/psim.h"

#include <memory>
#include <string>
#include <vector>

namespace psim::test {

inline BodyDesc disc_at(double x, double y) {
  BodyDesc d;
  d.position = {x, y};
  d.shape = DiscShape{0.4};
  d.material.friction = 0.5;
  return d;
}

// Heaps that sleep, one of them on a joint; others that fall; a kinematic bar, a sensor, terrain.
inline std::unique_ptr<World> yard() {
  std::string error;
  WorldDesc desc;
  desc.bounds = {-40, -10, 40, 40};
  auto world = World::create(desc, {.threads = 2}, error);
  BodyDesc ground;
  ground.type = BodyType::static_body;
  ground.shape = ChainShape{{{30, 1}, {10, 0}, {-10, 0}, {-30, 1}}, false};
  world->add_body(ground, error);
  std::vector<BodyId> ids;
  for (int k = 0; k < 12; ++k) {
    BodyDesc box = disc_at(-8 + 1.5 * k, 0.4);
    if (k % 2 == 0) box.shape = BoxShape{0.8, 0.8, 0};
    ids.push_back(world->add_body(box, error));
  }
  BodyDesc bar = disc_at(20, 8);
  bar.type = BodyType::kinematic_body;
  bar.shape = BoxShape{4, 0.3, 0};
  bar.angular_velocity = 1;
  world->add_body(bar, error);
  BodyDesc sensor = disc_at(0, 2);
  sensor.sensor = true;
  sensor.type = BodyType::static_body;
  world->add_body(sensor, error);
  JointDesc rod;
  rod.a = ids[0], rod.b = ids[1];
  world->add_joint(rod, error);
  world->set_event_options({.contacts = true, .hits = true, .hit_speed = 0.1, .sensors = true});
  world->enable_snapshots(true);
  for (int k = 0; k < 150; ++k) world->step();
  for (int k = 0; k < 20; ++k) world->add_body(disc_at(-9.7 + k, 6 + 0.1 * k), error);
  for (const BodyType type : {BodyType::dynamic_body, BodyType::static_body}) {  // ids 35 and 36
    BodyDesc off = disc_at(-3.5, 1.3);
    off.type = type;
    off.enabled = false;
    world->add_body(off, error);
  }
  for (int k = 0; k < 20; ++k) world->step();
  return world;
}

template <class S>
inline BodyDesc of_shape(BodyType type, double x, double y, S shape) {
  BodyDesc d = disc_at(x, y);
  d.type = type;
  d.shape = std::move(shape);
  return d;
}

inline BodyId nth(World& world, std::uint32_t index) { return world.id_of(index); }

// Changes most of what a body has.
inline bool change(World& w, std::uint32_t index) {
  BodyTraits t = w.traits(nth(w, index)).value_or(BodyTraits{});
  t.friction = 0.7;
  t.tangent_speed = 2;
  t.bullet = true;
  t.linear_damping = 1;
  t.locks.x = true;
  return w.set_traits(nth(w, index), t);
}

inline bool change_part(World& w, std::uint32_t index) {
  PartTraits t = w.part_traits(nth(w, index), 0).value_or(PartTraits{});
  t.friction = 0.75;
  t.pre_solve = true;
  return w.set_part_traits(nth(w, index), 0, t);
}

/// What calls are given is made beforehand: only what the engine allocates shall fail.
struct Given {
  BodyDesc disc = disc_at(0, 20), above = disc_at(-3.5, 1.2);
  BodyDesc polygon = of_shape(BodyType::dynamic_body, 3, 20, PolygonShape{{{0, 0}, {1, 0}, {0.5, 1}}, 0.1});
  BodyDesc terrain = of_shape(BodyType::static_body, 0, 0, ChainShape{{{9, 0.5}, {0, 0.5}, {-9, 0.5}}, false});
  BodyDesc bar = of_shape(BodyType::kinematic_body, -2, 0.9, BoxShape{1, 1, 0});
  std::vector<double> x{1, 2, 3, 4}, y{30, 30, 30, 30}, r{0.5}, low_x{-6, -5, -3, 1}, low_y{0.5, 0.6, 0.5, 0.6};
  DiscBatch discs, fixed;
  Shape box = BoxShape{10, 10, 0};
  ShapeMove fall{{{0, 5}, 0}, {0, -9}, 1};
  std::vector<Field> fields{WellField{{0, 5}, 3, 1}, DragField{0.1, 0.1}, BuoyancyField{{-20, -10, 20, 0}},
                            WindField{{3, 0}}};
  Vec2 low{-7, -5}, high{-7, 20};
  std::vector<std::byte> state;
  std::vector<RayInput> rays = std::vector<RayInput>(300, RayInput{{-20, 0.4}, {20, 0.4}});
  std::vector<RayHit> hits = std::vector<RayHit>(300);
  std::vector<Vec2> water = std::vector<Vec2>(40, {0, 3});
  std::vector<NearHit> near = std::vector<NearHit>(8);

  Given() {
    discs.x = x, discs.y = y, discs.radius = r;
    fixed.x = low_x, fixed.y = low_y, fixed.radius = r;
    fixed.type = BodyType::static_body;
    const auto later = yard();
    for (int k = 0; k < 10; ++k) later->step();
    later->save(state);
  }
};

inline Given& given() {
  static Given all;
  return all;
}

// Adds a fluid and some particles.
inline bool pour(World& world, std::string& error) {
  const FluidId fluid = world.add_fluid({0.1, 1000, 0}, error);
  return fluid != kNoFluid && world.add_particles(fluid, given().water, {}, error);
}

// Adds a fluid, an emitter of it and a drain.
inline bool open_taps(World& world, std::string& error) {
  if (world.add_fluid({0.1, 1000, 0}, error) == kNoFluid) return false;
  EmitterDesc tap;
  tap.from = {0, 5};
  tap.to = {1, 5};
  tap.speed = 1;
  return world.add_emitter(tap, error) != kNoEmitter && world.add_drain({0, 0, 1, 1}, error) != kNoDrain;
}

}  // namespace psim::test
