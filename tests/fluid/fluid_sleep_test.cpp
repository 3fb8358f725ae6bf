// Water that lies still is left as it is until something stirs it, and bodies that float fall asleep.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"
#include "scene_text.h"
#include "support.h"

namespace psim {
namespace {

using test::available_isas;
using test::parsed_scene;

// A tank of 4 m x 1 m of water in which a box lies on the floor and another one floats.
class StillTank {
 public:
  explicit StillTank(bool sleeping = true, Isa isa = best_isa(), int threads = 1) {
    std::string error;
    const Scene scene = parsed_scene(R"({"psim": 1, "world": {"bounds": [0, 0, 4, 3], "gravity": [0, -9.81]},
      "step": {"sleeping": )" + std::string(sleeping ? "true" : "false") +
                                     R"(}, "fluids": [{"region": [0, 0, 4, 1], "spacing": 0.04}], "bodies": [
      {"type": "static", "shape": {"box": {"size": [0.5, 0.4]}}, "position": [0.7, 0.2]},
      {"shape": {"box": {"size": [1, 0.6]}}, "position": [2.5, 1.125], "density": 500, "friction": 0.5}]})");
    RunOptions options;
    options.isa = isa;
    options.threads = threads;
    world = build_world(scene, options, error);
    EXPECT_NE(world, nullptr) << error;
    floor_box = world->id_of(0);
    floating = world->id_of(1);
  }
  bool step() {
    const StepReport report = world->step(1.0 / 60);
    return (report.skipped >> static_cast<unsigned>(Skip::fluid) & 1) != 0;
  }
  // Frames until it lies still; `most` if it does not.
  int settle(int most = 3000) {
    for (int frame = 0; frame < most; ++frame) {
      if (step()) return frame;
    }
    return most;
  }
  double height() const { return world->body(floating)->y; }
  double speed() const {
    std::vector<FluidParticleState> particles;
    world->fluid_particles(particles);
    double fastest = 0;
    for (const FluidParticleState& p : particles) fastest = std::max(fastest, std::hypot(p.velocity.x, p.velocity.y));
    return fastest;
  }

  std::unique_ptr<World> world;
  BodyId floor_box, floating;
};

TEST(FluidSleep, StillWaterIsLeftAsItIs) {
  StillTank tank;
  ASSERT_LT(tank.settle(), 3000);
  EXPECT_FALSE(tank.world->is_awake(tank.floating));
  const std::uint64_t hash = tank.world->state_hash();
  for (int frame = 0; frame < 100; ++frame) EXPECT_TRUE(tank.step());
  EXPECT_EQ(tank.world->state_hash(), hash);
  EXPECT_EQ(tank.speed(), 0);
  EXPECT_NEAR(tank.height(), 1.125, 0.01);
  // All is as it would be: nothing moves when it goes on.
  tank.world->set_sleeping(false);
  for (int frame = 0; frame < 120; ++frame) EXPECT_FALSE(tank.step());
  EXPECT_LT(tank.speed(), 0.06);
  EXPECT_NEAR(tank.height(), 1.125, 0.015);
}

TEST(FluidSleep, WhatStirsItWakesIt) {
  const auto add_disc = [](StillTank& tank, Vec2 at, BodyType type, Vec2 velocity) {
    BodyDesc d;
    d.shape = DiscShape{0.1};
    d.type = type;
    d.position = at;
    d.velocity = velocity;
    d.mass = 20;
    std::string error;
    const BodyId id = tank.world->add_body(d, error);
    EXPECT_EQ(error, "");
    return id;
  };
  const std::vector<std::pair<const char*, std::function<void(StillTank&)>>> changes = {
      {"a body is added in it",
       [&](StillTank& t) {
         add_disc(t, {1.5, 0.5}, BodyType::static_body, {});
       }},
      {"a body moves in it",
       [&](StillTank& t) {
         add_disc(t, {1.5, 0.5}, BodyType::kinematic_body, {0.1, 0});
       }},
      {"a body is taken out of it", [](StillTank& t) { EXPECT_TRUE(t.world->remove_body(t.floor_box)); }},
      {"what floats is moved",
       [](StillTank& t) {
         EXPECT_TRUE(t.world->set_transform(t.floating, {2.6, 1.125}, 0));
       }},
      {"what floats is pushed",
       [](StillTank& t) {
         EXPECT_TRUE(t.world->apply_impulse(t.floating, {0, -100}));
       }},
      {"gravity changes",
       [](StillTank& t) {
         EXPECT_TRUE(t.world->set_gravity({1, -9.81}));
       }},
      {"particles come",
       [](StillTank& t) {
         std::string error;
         const Vec2 at{1.5, 2};
         EXPECT_TRUE(t.world->add_particles(0, {&at, 1}, {}, error)) << error;
       }},
      {"a drain is opened",
       [](StillTank& t) {
         std::string error;
         t.world->add_drain({1, 0, 1.2, 0.2}, error);
         EXPECT_EQ(error, "");
       }},
  };
  for (const auto& [what, change] : changes) {
    StillTank tank;
    ASSERT_LT(tank.settle(), 3000);
    change(tank);
    tank.step();
    for (int frame = 0; frame < 30; ++frame) EXPECT_FALSE(tank.step()) << what << " " << frame;
    EXPECT_GT(tank.speed(), 1e-4) << what;
  }
}

// What moved while nobody slept does not lie still because it did before.
TEST(FluidSleep, MovingWaterGoesOnWhenSleepIsTurnedOn) {
  StillTank tank;
  ASSERT_LT(tank.settle(), 3000);
  tank.world->set_sleeping(false);
  EXPECT_TRUE(tank.world->apply_impulse(tank.floating, {0, -250}));
  for (int frame = 0; frame < 20; ++frame) EXPECT_FALSE(tank.step());
  tank.world->set_sleeping(true);
  for (int frame = 0; frame < 20; ++frame) EXPECT_FALSE(tank.step());
}

// A float that sleeps does not stay in the air when all water goes at once.
TEST(FluidSleep, AFloatFallsWhenTheWaterGoes) {
  for (const bool stays : {true, false}) {
    StillTank tank;
    ASSERT_LT(tank.settle(), 3000);
    ASSERT_FALSE(tank.world->is_awake(tank.floating));
    std::string error;
    const DrainId drain = tank.world->add_drain({-1, -1, 5, 4}, error);
    ASSERT_EQ(error, "");
    tank.step();
    ASSERT_EQ(tank.world->fluid_report().particles, 0u);
    EXPECT_TRUE(stays || tank.world->remove_drain(drain));
    for (int frame = 0; frame < 90; ++frame) tank.step();
    EXPECT_NEAR(tank.height(), 0.3, 0.05);
    EXPECT_EQ(tank.world->fluid_report().particles, 0u);
  }
}

TEST(FluidSleep, WhatIsFarAwayDoesNot) {
  StillTank tank;
  ASSERT_LT(tank.settle(), 3000);
  BodyDesc d;
  d.shape = DiscShape{0.1};
  d.position = {1.5, 2.9};
  d.mass = 20;
  std::string error;
  tank.world->add_body(d, error);
  ASSERT_EQ(error, "");
  int still = 0;
  while (still < 60 && tank.step()) ++still;
  EXPECT_GT(still, 5);  // it is seen in the tiles above the water, half a metre below
  EXPECT_LT(still, 40);
  for (int frame = 0; frame < 60; ++frame) EXPECT_FALSE(tank.step());
  EXPECT_GT(tank.speed(), 0.3);
}

// A float that is pushed moves as it does in a world where nobody sleeps. It falls for a step when it wakes.
TEST(FluidSleep, AFloatWakesAsIfItHadNotSlept) {
  StillTank asleep(true), awake(false);
  const int frames = asleep.settle();
  ASSERT_LT(frames, 3000);
  for (int frame = 0; frame <= frames; ++frame) awake.step();
  for (StillTank* tank : {&asleep, &awake}) EXPECT_TRUE(tank->world->apply_impulse(tank->floating, {0, -250}));
  double apart = 0, swing = 0;
  for (int frame = 0; frame < 90; ++frame) {
    asleep.step();
    awake.step();
    apart = std::max(apart, std::fabs(asleep.height() - awake.height()));
    swing = std::max(swing, std::fabs(awake.height() - 1.125));
  }
  EXPECT_GT(swing, 0.05);
  EXPECT_LT(apart, 0.2 * swing);
}

// A float that sleeps wakes when the water that bears it moves.
TEST(FluidSleep, AWaveWakesAFloat) {
  StillTank tank;
  ASSERT_LT(tank.settle(), 3000);
  ASSERT_FALSE(tank.world->is_awake(tank.floating));
  std::vector<Vec2> drop;
  for (int k = 0; k < 400; ++k) drop.push_back({0.2 + 0.04 * (k % 20), 1.6 + 0.04 * (k / 20)});
  std::string error;
  ASSERT_TRUE(tank.world->add_particles(0, drop, {}, error)) << error;
  int frame = 0;
  while (frame < 300 && !tank.world->is_awake(tank.floating)) tank.step(), ++frame;
  EXPECT_LT(frame, 90);
  double highest = 0;
  for (frame = 0; frame < 120; ++frame) {
    tank.step();
    highest = std::max(highest, tank.height());
  }
  EXPECT_GT(highest, 1.2);
}

TEST(FluidSleep, SameBits) {
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      StillTank tank(true, isa, threads);
      EXPECT_LT(tank.settle(), 3000);
      tank.world->apply_impulse(tank.floating, {10, -150});
      for (int frame = 0; frame < 60; ++frame) tank.step();
      hashes.push_back(tank.world->state_hash());
    }
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

TEST(FluidSleep, SavedAndLoaded) {
  StillTank tank;
  ASSERT_LT(tank.settle(), 3000);
  std::vector<std::byte> saved;
  tank.world->save(saved);
  StillTank other;
  std::string error;
  ASSERT_TRUE(other.world->restore(saved, error)) << error;
  for (StillTank* of : {&tank, &other}) {
    for (int frame = 0; frame < 5; ++frame) EXPECT_TRUE(of->step());
    EXPECT_TRUE(of->world->apply_impulse(of->floating, {0, -150}));
    for (int frame = 0; frame < 60; ++frame) of->step();
  }
  EXPECT_EQ(tank.world->state_hash(), other.world->state_hash());
}

}  // namespace
}  // namespace psim
