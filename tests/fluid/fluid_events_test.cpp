// Which particles entered a sensor in a step and which left it: against a count of who is where before and after.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "psim/geometry.h"
#include "psim/scene.h"
#include "psim/world.h"
#include "scene_text.h"
#include "support.h"

namespace psim {
namespace {

using test::available_isas;
using test::parsed_scene;

using Within = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;  // body, part, particle

// A dam breaks in a tank in which a disc stands that feels, a bucket floats with a part that feels, and a bar turns that feels.
const char* const kTank = R"({"psim": 1, "world": {"bounds": [0, 0, 4, 3], "gravity": [0, -9.81], "boundary": "$B"},
  "fluids": [{"region": [0, 0, 1, 2], "spacing": 0.05}, {"region": [1.2, 0, 1.6, 0.4], "spacing": 0.05, "density": 800}],
  "drains": [{"region": [3.8, 0, 4, 0.2]}],
  "bodies": [
    {"type": "static", "sensor": true, "shape": {"disc": {"radius": 0.4}}, "position": [1.5, 0.5]},
    {"shapes": [{"box": {"size": [0.8, 0.1]}, "position": [0, -0.2], "density": 300},
                {"box": {"size": [0.8, 0.3]}, "sensor": true}], "position": [2.5, 0.6]},
    {"type": "kinematic", "sensor": true, "shape": {"box": {"size": [1.6, 0.2]}}, "position": [3.6, 0.5],
     "angular_velocity": 2}]})";

struct Tank {
  explicit Tank(const std::string& boundary = "walls", Isa isa = best_isa(), int threads = 1) {
    std::string error, text = kTank;
    text.replace(text.find("$B"), 2, boundary);
    const Scene scene = parsed_scene(text);
    RunOptions options;
    options.isa = isa;
    options.threads = threads;
    world = build_world(scene, options, error);
    EXPECT_NE(world, nullptr) << error;
    world->set_event_options({.fluids = true});
  }
  // Who is in which sensor, by going over all of them.
  std::set<Within> within() const {
    std::vector<FluidParticleState> particles;
    world->fluid_particles(particles);
    const Bounds b = world->desc().bounds;
    const bool wraps = world->desc().boundary == Boundary::periodic;
    std::set<Within> all;
    for (std::uint32_t body = 0; body < 3; ++body) {
      const BodyId id = world->id_of(body);
      if (id == kNoBody) continue;
      const BodyState state = *world->body(id);
      const std::vector<ShapePart> parts = world->shapes_of(id);
      for (std::uint32_t part = 0; part < parts.size(); ++part) {
        if (!parts[part].sensor.value_or(false)) continue;
        const CompoundShape alone{{parts[part]}};
        for (const FluidParticleState& p : particles) {
          for (int image = 0; image < (wraps ? 9 : 1); ++image) {
            const int right = wraps ? image % 3 - 1 : 0, up = wraps ? image / 3 - 1 : 0;
            const Vec2 at{p.position.x + right * (b.xmax - b.xmin), p.position.y + up * (b.ymax - b.ymin)};
            if (shape_holds(alone, {{state.x, state.y}, state.angle}, at)) all.emplace(body, part, p.id);
          }
        }
      }
    }
    return all;
  }

  std::unique_ptr<World> world;
};

std::vector<Within> those_not_in(const std::set<Within>& all, const std::set<Within>& without) {
  std::vector<Within> found;
  std::ranges::copy_if(all, std::back_inserter(found), [&](const Within& w) { return !without.contains(w); });
  return found;
}

std::vector<Within> told(std::span<const FluidEvent> events) {
  std::vector<Within> all;
  for (const FluidEvent& e : events) all.emplace_back(e.sensor.index, e.part, e.particle);
  return all;
}

// Particles on a sensor's outline may count either way: single precision keeps them.
void expect_alike(const std::vector<Within>& told, const std::vector<Within>& want, std::size_t& unlike) {
  std::vector<Within> apart;
  std::ranges::set_symmetric_difference(told, want, std::back_inserter(apart));
  unlike += apart.size();
}

TEST(FluidEvents, TellWhoEntersAndLeavesAsBruteForceDoes) {
  for (const char* boundary : {"walls", "periodic"}) {
    Tank tank(boundary);
    std::set<Within> before;
    std::size_t begun = 0, ended = 0, unlike = 0;
    for (int frame = 0; frame < 150; ++frame) {
      tank.world->step();
      const Events events = tank.world->events();
      ASSERT_TRUE(std::ranges::is_sorted(told(events.fluid_begin)));
      ASSERT_TRUE(std::ranges::is_sorted(told(events.fluid_end)));
      const std::set<Within> now = tank.within();
      expect_alike(told(events.fluid_begin), those_not_in(now, before), unlike);
      expect_alike(told(events.fluid_end), those_not_in(before, now), unlike);
      begun += events.fluid_begin.size();
      ended += events.fluid_end.size();
      before = now;
    }
    EXPECT_GT(begun, 1000u) << boundary;
    EXPECT_GT(ended, 500u) << boundary;
    EXPECT_LE(unlike, 2u) << boundary;
  }
}

// What is gone has left: a particle that was drained, all that were in a sensor that was removed or a world that was emptied.
TEST(FluidEvents, WhatIsGoneHasLeft) {
  Tank tank;
  for (int frame = 0; frame < 60; ++frame) tank.world->step();
  const std::set<Within> before = tank.within();
  const auto inside = [&](std::uint32_t body) {
    return static_cast<std::size_t>(
        std::ranges::count_if(before, [&](const Within& w) { return std::get<0>(w) == body; }));
  };
  ASSERT_GT(inside(0), 50u);
  const BodyId disc = tank.world->id_of(0);
  ASSERT_TRUE(tank.world->remove_body(disc));
  tank.world->step();
  std::size_t left = 0;
  for (const FluidEvent& e : tank.world->events().fluid_end) left += e.sensor == disc;
  EXPECT_EQ(left, inside(0));
  std::string error;
  ASSERT_NE(tank.world->add_drain({0, 0, 4, 3}, error), kNoDrain) << error;
  const std::size_t rest = tank.within().size();
  ASSERT_GT(rest, 10u);
  tank.world->step();
  ASSERT_EQ(tank.world->fluid_report().particles, 0u);
  EXPECT_EQ(tank.world->events().fluid_end.size(), rest);
  EXPECT_TRUE(tank.world->events().fluid_begin.empty());
  tank.world->step();
  EXPECT_TRUE(tank.world->events().fluid_end.empty());
}

TEST(FluidEvents, OnlyThoseWhoAskAreTold) {
  Tank tank;
  tank.world->set_event_options({.sensors = true});
  for (int frame = 0; frame < 60; ++frame) {
    tank.world->step();
    ASSERT_TRUE(tank.world->events().fluid_begin.empty());
  }
  tank.world->set_event_options({.fluids = true});
  tank.world->step();
  EXPECT_EQ(tank.world->events().fluid_begin.size(), tank.within().size()) << "the first step tells of all";
  BodyTraits traits = *tank.world->traits(tank.world->id_of(0));
  traits.filter.mask = 0;
  ASSERT_TRUE(tank.world->set_traits(tank.world->id_of(0), traits));
  tank.world->step();
  for (const FluidEvent& e : tank.world->events().fluid_begin)
    EXPECT_NE(e.sensor.index, 0u) << "a mask of 0 feels nothing";
}

std::vector<FluidEvent> events_of(World& world) {
  const Events events = world.events();
  std::vector<FluidEvent> all(events.fluid_begin.begin(), events.fluid_begin.end());
  all.insert(all.end(), events.fluid_end.begin(), events.fluid_end.end());
  return all;
}

TEST(FluidEvents, AreTheSameEverywhereAndGoOnFromASavedState) {
  Tank first;
  std::string error;
  std::vector<std::unique_ptr<Tank>> others;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) others.push_back(std::make_unique<Tank>("walls", isa, threads));
  }
  std::unique_ptr<World> restored;
  for (int frame = 0; frame < 90; ++frame) {
    if (frame == 45) {
      std::vector<std::byte> state;
      first.world->save(state);
      restored = World::from_state(state, {}, error);
      ASSERT_NE(restored, nullptr) << error;
    }
    first.world->step();
    const std::vector<FluidEvent> want = events_of(*first.world);
    for (const auto& other : others) {
      other->world->step();
      ASSERT_EQ(events_of(*other->world), want) << frame;
    }
    if (!restored) continue;
    restored->step();
    ASSERT_EQ(events_of(*restored), want) << frame;
  }
}

}  // namespace
}  // namespace psim
