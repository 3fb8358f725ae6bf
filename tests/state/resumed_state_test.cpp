// A world that was saved and brought back beside one that never was: the same bits, and the same choices of a
// governor, in the middle of a step that takes several frames, too. Found by fuzz_world, but for the first two.
#include "psim/saved_state.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

using Bytes = std::vector<std::byte>;

/// What comes of a world's state, as a world of its own.
std::unique_ptr<World> copy_of(World& world, Isa isa = best_isa()) {
  Bytes state;
  std::string error;
  world.save(state);
  auto copy = World::from_state(state, {isa, 1}, error);
  if (!copy) throw std::runtime_error("from_state: " + error);
  return copy;
}

enum class Bodies { heap, boxes, gas };

std::unique_ptr<World> crowd(Bodies bodies) {
  auto world = make(walled({0, 0, 24, 40}, {0, bodies == Bodies::gas ? 0 : -kG}, kGrip));
  Random random(5);
  for (int k = 0; k < 220; ++k) {
    const Vec2 at{1.0 + 1.1 * (k % 20) + random.uniform(-0.05, 0.05), 1.0 + 1.1 * (k / 20)};
    const double speed = bodies == Bodies::gas ? 8 : 0.3;
    const Vec2 v{random.uniform(-speed, speed), random.uniform(-speed, speed)};
    const bool corners = bodies == Bodies::boxes && k % 2 == 0;
    add(*world, corners ? moving(box(at, 0.8, 0.8, kGrip), v) : disc(at, v, 0.4, kGrip));
  }
  return world;
}

const char* name_of(Bodies b) { return b == Bodies::heap ? "heap" : b == Bodies::boxes ? "boxes" : "gas"; }

TEST(ResumedState, AGovernedWorldChoosesAsIfItHadNeverBeenAway) {
  GovernorDesc governor;
  governor.on = true;
  for (const Bodies bodies : {Bodies::heap, Bodies::boxes, Bodies::gas}) {
    int waits = 0;
    for (const double budget : {0.02, 0.04}) {
      governor.budget_ms = budget;
      auto world = crowd(bodies);
      ASSERT_TRUE(world->set_governor(governor));
      std::unique_ptr<World> copy = copy_of(*world);
      for (int frame = 0; frame < 90; ++frame) {
        if (frame % 2 == 0) copy = copy_of(frame % 4 == 0 ? *world : *copy, frame % 3 == 0 ? Isa::scalar : best_isa());
        ASSERT_TRUE(copy->set_governor(governor));
        const StepReport one = world->step(), other = copy->step();
        ASSERT_EQ(one.detail, other.detail) << name_of(bodies) << ", " << budget << " ms, frame " << frame;
        ASSERT_EQ(one.predicted_ms, other.predicted_ms) << name_of(bodies) << ", " << budget << " ms, frame " << frame;
        ASSERT_EQ(world->state_hash(), copy->state_hash())
            << name_of(bodies) << ", " << budget << " ms, frame " << frame;
        waits += one.detail.waits();
      }
    }
    EXPECT_GT(waits, 20) << name_of(bodies) << ": no step took several frames";
  }
}

// What was made for three frames and for one, with bodies pushed gently in between, is made again just so.
TEST(ResumedState, WhatWasDoneOfAStepIsDoneAgainAsItWas) {
  for (const Bodies bodies : {Bodies::heap, Bodies::boxes, Bodies::gas}) {
    for (std::uint32_t pieces = 1; pieces < 30; pieces += pieces < 16 ? 1 : 5) {
      auto world = crowd(bodies);
      for (int k = 0; k < 20; ++k) world->step();
      const auto ahead = [&](World& w, std::uint8_t horizon) {
        StepDetail detail;
        detail.solves = false;
        detail.pieces = pieces;
        detail.horizon = horizon;
        w.replay(detail);
      };
      ahead(*world, 3);
      for (std::uint32_t id = 0; id < 40; ++id) world->apply_impulse(world->id_of(id), {0, 1e-3});
      auto copy = copy_of(*world);
      for (World* w : {world.get(), copy.get()}) {
        ahead(*w, 1);
        w->apply_impulse(w->id_of(50), {1e-3, 0});
      }
      copy = copy_of(*copy);
      for (int k = 0; k < 6; ++k) {
        const StepReport one = world->step(), other = copy->step();
        ASSERT_EQ(one.pairs, other.pairs) << name_of(bodies) << ", " << pieces << " pieces, " << k;
        ASSERT_EQ(world->state_hash(), copy->state_hash()) << name_of(bodies) << ", " << pieces << " pieces, " << k;
      }
    }
  }
}

TEST(ResumedState, IdsThatWereUsedSinceAreAsIfTheyNeverWere) {
  auto world = make(walled({0, 0, 20, 20}));
  add(*world, disc({3, 3}));
  Bytes state;
  std::string error;
  world->save(state);
  const BodyId fresh = add(*copy_of(*world), disc({6, 3}));
  for (int k = 0; k < 3; ++k) world->remove_body(add(*world, disc({6, 3})));
  ASSERT_TRUE(world->restore(state, error)) << error;
  EXPECT_EQ(add(*world, disc({6, 3})), fresh);
}

// Manifolds of bodies that the state does not have are gone before its lists are made. (What went wrong was a write
// beyond an array: the sanitizers see it.)
TEST(ResumedState, AStateOfFewerBodiesComesBack) {
  auto world = make(walled({0, 0, 60, 10}, {0, -kG}, kGrip));
  for (int k = 0; k < 3; ++k) add(*world, box({2.0 + k, 0.5}, 1, 1, kGrip));
  for (int k = 0; k < 5; ++k) world->step();
  Bytes state;
  std::string error;
  world->save(state);
  auto beside = copy_of(*world);
  for (int k = 0; k < 40; ++k) add(*world, box({8.0 + k, 0.5}, 1, 1, kGrip));
  for (int k = 0; k < 5; ++k) world->step();
  ASSERT_TRUE(world->restore(state, error)) << error;
  EXPECT_EQ(hashes(*world, 20), hashes(*beside, 20));
}

TEST(ResumedState, SleepIsForgottenWhereItWasSwitchedOff) {
  auto world = make(walled({0, 0, 20, 20}, {0, 0}));
  for (int k = 0; k < 30; ++k) add(*world, disc({1.0 + 2 * (k % 6), 1.0 + 2 * (k / 6)}));
  run(*world, 24);  // watched, but not for long enough
  world->set_sleeping(false);
  auto copy = copy_of(*world);
  for (int frame = 0; frame < 120; ++frame) {
    for (World* w : {world.get(), copy.get()}) w->set_sleeping(frame >= 8);
    const StepReport one = world->step(), other = copy->step();
    ASSERT_EQ(one.asleep, other.asleep) << frame;
  }
  EXPECT_EQ(world->step().asleep, 30u);
}

// A range that is 0 to a step is 0 to what is made when a state comes back.
// Which joined bodies do not collide comes back, whichever do since.
TEST(ResumedState, JointsThatLetCollideComeBackAsTheyWere) {
  for (const bool collide : {false, true}) {
    auto world = make(walled({-10, -10, 10, 10}, {0, -kG}, kGrip));
    JointDesc joint;
    joint.type = JointType::revolute;
    joint.a = add(*world, moving(box({0, -8}, 1, 1, kGrip), {}));
    joint.b = add(*world, moving(box({0.9, -8}, 1, 1, kGrip), {}));
    joint.collide = collide;
    std::string error;
    const JointId id = world->add_joint(joint, error);
    ASSERT_NE(id, kNoJoint) << error;
    run(*world, 5);
    const auto copy = copy_of(*world);
    Bytes state;
    world->save(state);
    ASSERT_TRUE(world->remove_joint(id));
    joint.collide = !collide;
    ASSERT_NE(world->add_joint(joint, error), kNoJoint) << error;
    run(*world, 5);
    ASSERT_TRUE(world->restore(state, error)) << error;
    for (int frame = 0; frame < 40; ++frame) {
      world->step();
      copy->step();
      ASSERT_EQ(world->state_hash(), copy->state_hash()) << collide << ", frame " << frame;
    }
  }
}

TEST(ResumedState, FieldsAreMadeAsInAStep) {
  WorldDesc desc = unbounded(50, {0, 0});
  WellField well;
  well.strength = 100;
  well.softening = 0.5;
  well.range = 1e-320;
  desc.fields.push_back(well);
  auto world = make(desc);
  add(*world, disc({5, 0}));
  run(*world, 3);
  auto copy = copy_of(*world);
  EXPECT_EQ(hashes(*world, 5), hashes(*copy, 5));
}

// Whoever listens makes no new plan of who turns.
TEST(ResumedState, WhoLooksAndListensChangesNothing) {
  const auto build = [] {
    auto world = pile(200);
    BodyDesc turned_disc = disc({5, 5});
    turned_disc.angle = 1;
    turned_disc.fixed_rotation = true;
    const BodyId id = add(*world, turned_disc);
    run(*world, 20);
    world->set_transform(id, {5, 5}, 0);
    run(*world, 10);
    return world;
  };
  auto one = build(), other = build();
  other->enable_snapshots(true);
  other->set_event_options({true, true, 1, true});
  EXPECT_EQ(hashes(*one, 20), hashes(*other, 20));
}

}  // namespace
}  // namespace psim::test
