// What the fuzzers found in the engine, each as the shortest course of calls that showed it.
#include "support.h"

namespace psim::test {
namespace {

BodyDesc box(Vec2 position, double size = 1) {
  BodyDesc body = disc(position);
  body.shape = BoxShape{size, size, 0};
  return body;
}

// The list of shapes outlived the last shape, and the continuous stage read columns that were gone.
TEST(Hardening, ABulletFliesOnWhenTheLastShapeIsGone) {
  auto world = make(walled({-20, -20, 20, 20}));
  add(*world, ground({}, 15));
  const BodyId crate = add(*world, box({0, 3}));
  BodyDesc bullet = disc({0.5, 1}, {30, -30}, 0.2);
  bullet.bullet = true;
  for (int k = 0; k < 6; ++k) {
    bullet.position.x = 0.5 + k;
    add(*world, bullet);
  }
  run(*world, 2);
  ASSERT_TRUE(world->remove_body(crate));
  run(*world, 30);
  EXPECT_TRUE(all_finite(*world));
}

// With filters the pairs are still sorted out, and the last contacts of shapes were solved on.
TEST(Hardening, ContactsOfShapesEndWithTheLastShape) {
  auto world = make(walled({-20, -20, 20, 20}));
  add(*world, ground(material(0.5, 0.5), 15));
  for (int k = 0; k < 30; ++k) {
    BodyDesc other = disc({-10 + 0.7 * k, 0.4}, {1, 0}, 0.3, material(0.3, 0.5));
    other.filter.category = 2;
    add(*world, other);
  }
  const BodyId crate = add(*world, box({5, 1.2}));
  run(*world, 20);
  ASSERT_TRUE(world->remove_body(crate));
  run(*world, 20);
  EXPECT_TRUE(all_finite(*world));
}

// Its place among the sleepers was taken for a slot: another body was stopped like a bullet.
TEST(Hardening, ASleepingBulletIsNobodysBusiness) {
  std::uint64_t hashes[2] = {};
  for (const bool bullet : {false, true}) {
    auto world = make(walled({-60, 0, 60, 40}));
    BodyDesc sleeper = disc({-50, 0.5});
    sleeper.bullet = bullet;
    const BodyId id = add(*world, sleeper);
    run(*world, 200);
    ASSERT_FALSE(world->is_awake(id));
    BodyDesc splinter = box({0, 20}, 0.1);
    splinter.velocity = {800, 0};
    splinter.gravity_scale = 0;
    add(*world, splinter);
    BodyDesc pole = box({6.6, 20}, 0.1);
    pole.gravity_scale = 0;
    pole.angular_velocity = 40;
    pole.shape = BoxShape{0.1, 6, 0};
    add(*world, pole);
    run(*world, 3);
    hashes[bullet] = world->state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// A frame that only makes lists published bodies whom the publisher did not know yet.
TEST(Hardening, FramesThatWaitShowNewBodies) {
  auto world = make(walled({-20, -20, 20, 20}));
  world->enable_snapshots(true);
  world->step();
  for (int k = 0; k < 50; ++k) add(*world, disc({-15.0 + 0.6 * k, 5}, {1, 0}, 0.2));
  StepDetail waits;
  waits.solves = false;
  waits.pieces = 4;
  world->replay(waits);
  const Snapshot* snapshot = world->latest_snapshot();
  ASSERT_NE(snapshot, nullptr);
  ASSERT_EQ(snapshot->id.size(), 50u);
  for (std::size_t k = 0; k < 50; ++k) EXPECT_EQ(snapshot->x[k], snapshot->x_prev[k]) << k;
}

// The id was remembered without its generation.
TEST(Hardening, NaNGivenToARemovedBodyDoesNotFreezeItsSuccessor) {
  auto world = make(walled({-20, -20, 20, 20}));
  const BodyId first = add(*world, disc({0, 0}));
  ASSERT_TRUE(world->set_velocity(first, {kNan, 0}, 0));
  ASSERT_TRUE(world->remove_body(first));
  const BodyId second = add(*world, disc({0, 0}, {1, 0}));
  ASSERT_EQ(second.index, first.index);
  EXPECT_EQ(world->step().quarantined, 0u);
  EXPECT_GT(state(*world, second).x, 0);
}

// Lists that were made ahead and then spoiled took the impulses of the lists before with them, by slots
// that had moved.
TEST(Hardening, BodiesMayComeBetweenTheFramesOfOneStep) {
  std::vector<std::uint64_t> seen;
  for (const Isa isa : available_isas()) {
    auto world = pile(200, material(0, 0.4), isa, isa == Isa::scalar ? 1 : 3);
    run(*world, 120);
    for (int k = 0; k < 10; ++k) {
      StepDetail waits;
      waits.solves = false;
      waits.horizon = 3;
      waits.pieces = static_cast<std::uint32_t>(3 * k);
      world->replay(waits);
      add(*world, disc({2.0 + k, 30}, {0, -3}, 0.4));
      world->step();
      world->remove_body(world->id_of(static_cast<std::uint32_t>(7 * k)));
    }
    run(*world, 10);
    EXPECT_TRUE(all_finite(*world));
    seen.push_back(world->state_hash());
  }
  for (const std::uint64_t hash : seen) EXPECT_EQ(hash, seen.front());
}

TEST(Hardening, AStateIsSavedBetweenTheFramesOfOneStep) {
  auto world = pile(100, material(0, 0.4));
  run(*world, 60);
  StepDetail waits;
  waits.solves = false;
  waits.pieces = 7;
  world->replay(waits);
  add(*world, disc({3, 30}, {0, -3}, 0.4));  // spoils the lists
  std::vector<std::byte> state;
  std::string error;
  world->save(state);
  auto again = World::from_state(state, {}, error);
  ASSERT_TRUE(again) << error;
  for (int k = 0; k < 20; ++k) {
    world->step();
    again->step();
    ASSERT_EQ(world->state_hash(), again->state_hash()) << k;
  }
}

// The recorder leaves out a call that adds nothing, but the call began the step anew, and the replay was another run.
TEST(Hardening, ABatchOfNoDiscsDoesNotBeginAStepAnew) {
  auto world = pile(100, material(0, 0.4)), other = pile(100, material(0, 0.4));
  StepDetail waits;
  waits.solves = false;
  waits.horizon = 2;
  waits.pieces = 3;
  for (int k = 0; k < 40; ++k) {
    world->replay(waits);
    other->replay(waits);
    std::uint32_t first = 0;
    std::string error;
    EXPECT_EQ(other->add_discs({}, first, error), 0u);
    EXPECT_EQ(error, "");
    world->step();
    other->step();
    ASSERT_EQ(world->state_hash(), other->state_hash()) << k;
  }
}

// A state named the slot that a long chain had before the bodies were sorted, and was refused where a disc had it now.
TEST(Hardening, AStateIsSavedAfterADiscTookTheSlotOfALongChain) {
  auto world = make(walled({-20, -2, 30, 60}));
  for (int k = 0; k < 20; ++k) add(*world, disc({1.0 + k, 20}));
  BodyDesc chain = disc({5, 5});
  chain.type = BodyType::kinematic_body;
  ChainShape many;
  for (int k = 0; k < 30; ++k) many.vertices.push_back({0.2 * k, 0.1 * (k % 2)});
  chain.shape = many;
  std::string error;
  ASSERT_NE(world->add_body(chain, error), kNoBody) << error;
  run(*world, 3);
  for (int k = 0; k < 20; ++k) add(*world, disc({-15.0 + k, -1}));
  StepDetail waits;
  waits.solves = false;
  waits.frames = 3;
  waits.horizon = 4;
  for (std::uint32_t pieces = 1; pieces < 20; ++pieces) {
    waits.pieces = pieces;
    world->replay(waits);
    std::vector<std::byte> state;
    world->save(state);
    ASSERT_TRUE(World::from_state(state, {}, error)) << error << " after " << pieces << " pieces";
  }
}

// The watch over who falls asleep multiplied the angle, and the product was infinite.
TEST(Hardening, ABodyWithTheLargestAngleFallsAsleep) {
  auto world = make(walled({-10, 0, 10, 20}));
  BodyDesc body = box({3, 3});
  body.shape = CapsuleShape{{-2, 0}, {2, 0}, 0.5};
  ASSERT_TRUE(world->set_transform(add(*world, body), {3, 3}, std::numeric_limits<double>::max()));
  run(*world, 600);
  EXPECT_TRUE(all_finite(*world));
}

// The angle went to infinity, which nobody looked for.
TEST(Hardening, AJointOnABodyThatSpinsAbsurdlyLeavesFiniteStates) {
  auto world = make(walled({-20, -20, 20, 20}));
  std::string error;
  for (const double spin : {1e30, -1e30, 1e300}) {
    JointDesc joint;
    joint.type = JointType::weld;
    joint.a = add(*world, disc({0, 0}));
    world->apply_angular_impulse(joint.a, spin);
    joint.b = add(*world, disc({1, 3}));
    ASSERT_NE(world->add_joint(joint, error), kNoJoint) << error;
  }
  for (int k = 0; k < 20; ++k) {
    world->step();
    ASSERT_TRUE(all_finite(*world)) << k;
  }
}

// With a mass of its own such a disc was taken, and its radius was zero as a float.
TEST(Hardening, ADiscTooSmallForFloatsIsRefused) {
  auto world = make(walled({-20, -20, 20, 20}));
  BodyDesc speck = disc({0, 0});
  speck.mass = 1;
  std::string error;
  for (const double radius : {1e-320, 1e-45, 0.9e-9}) {
    speck.shape = DiscShape{radius};
    EXPECT_EQ(world->add_body(speck, error), kNoBody) << radius;
    EXPECT_TRUE(error.starts_with("radius must be from 1e-9 to 40, not ")) << error;
  }
  speck.shape = DiscShape{1e-9};
  EXPECT_NE(world->add_body(speck, error), kNoBody) << error;
}

// While radii are alike the column does not move with the bodies: one that was gone left its own behind.
TEST(Hardening, ARemovedBodyLeavesItsRadiusToNobody) {
  auto world = make(walled({-20, -20, 20, 20}, {0, 0}));
  const BodyId large = add(*world, disc({0, 0}, {}, 3));
  world->step();
  world->remove_body(large);
  for (int k = 0; k < 7; ++k) add(*world, disc({0.7 * k, 5}, {0.5, 0}, 0.1));  // each 0.5 m from the next
  run(*world, 10);
  for (std::uint32_t k = 0; k < 7; ++k) {
    const BodyState s = state(*world, world->id_of(k));
    EXPECT_EQ(s.vx, 0.5) << k;
    EXPECT_EQ(s.vy, 0) << k;
  }
}

TEST(Hardening, PlacesAndSpeedsBeyondFloatsAreFiniteAtOnce) {
  for (const Boundary boundary : {Boundary::open, Boundary::periodic}) {
    WorldDesc desc = unbounded(20);
    desc.boundary = boundary;
    auto world = make(desc);
    const BodyId thrown = add(*world, disc({0, 0}));
    ASSERT_TRUE(world->set_transform(thrown, {0, 1e100}, 0));
    BodyDesc gate = box({5, 5});
    gate.type = BodyType::kinematic_body;
    gate.shape = CapsuleShape{{0, 0}, {2, 0}, 0.3};
    gate.velocity = {1e6, 0};
    add(*world, gate);
    EXPECT_TRUE(all_finite(*world));
    world->step();
    EXPECT_TRUE(all_finite(*world));
  }
}

TEST(Hardening, ManyStaticDiscsTakeTheirMassAlong) {
  auto world = make(walled({-20, -20, 20, 20}));
  const double x[] = {1, 2}, y[] = {1, 2}, radius[] = {1e-9};
  DiscBatch batch{.x = x,
                  .y = y,
                  .radius = radius,
                  .angle = {},
                  .vx = {},
                  .vy = {},
                  .angular_velocity = {},
                  .type = BodyType::static_body,
                  .material = {1e-9, 0, 0},
                  .mass = 1,
                  .filter = {}};
  std::uint32_t first = 0;
  std::string error;
  EXPECT_EQ(world->add_discs(batch, first, error), 2u) << error;
  EXPECT_EQ(world->body_count(), 2u);
}

// exp(-c h) was zero, and what was divided by it infinite.
TEST(Hardening, TheStrongestDampingStopsBodiesWhereTheyAre) {
  for (const double damping : {1e4, 1e5, 1e6}) {
    WorldDesc desc = walled({-20, -20, 20, 20});
    desc.linear_damping = damping;
    auto world = make(desc);
    for (int k = 0; k < 5; ++k) add(*world, disc({0.7 * k, 0}, {5, 0}));  // overlapping: the solver's
    run(*world, 10);
    ASSERT_TRUE(all_finite(*world)) << damping;
    EXPECT_TRUE(all_inside(*world));
  }
}

// The nearest image of a place very far off was itself very far off: beyond the index's arrays.
TEST(Hardening, QuestionsFromVeryFarAreAnsweredInAPeriodicWorld) {
  WorldDesc desc = periodic(24, 36);
  auto world = make(desc);
  for (int k = 0; k < 20; ++k) add(*world, disc({1.0 + k, 5}, {1, 0}, 0.3));
  world->step();
  for (const double far : {1e10, 1e20, 3e38, -1e90}) {
    EXPECT_LE(world->overlap(DiscShape{1}, {far, far}, 0).size(), 20u);
    EXPECT_LE(world->in_region({far, far, far + 1, far + 1}).size(), 20u);
    EXPECT_LE(world->ray_cast_all({far, far}, {0, 0}).size(), 20u);
    world->closest({far, -far}, 5);
  }
}

TEST(Hardening, StepsOfAbsurdLengthsDoNotHappen) {
  auto world = pile(20);
  run(*world, 3);
  const std::uint64_t before = world->state_hash();
  for (const double dt : {0.0, -1.0, kNan, kInf, 10.1, 1e300}) {
    world->step(dt);
    EXPECT_EQ(world->state_hash(), before) << dt;
    EXPECT_EQ(world->frame(), 3u) << dt;
  }
}

TEST(Hardening, DetailsThatNoGovernorChoosesDoNothing) {
  auto world = pile(20);
  run(*world, 3);
  const std::uint64_t before = world->state_hash();
  for (const StepDetail detail :
       {StepDetail{4, true, 0, 1}, StepDetail{65, true, 1, 1}, StepDetail{4, true, 9, 1}, StepDetail{4, true, 1, 0},
        StepDetail{4, true, 1, 9}, StepDetail{4, true, 1, 1, 0, true}}) {
    world->replay(detail);
    EXPECT_EQ(world->frame(), 3u);
    EXPECT_EQ(world->state_hash(), before);
  }
}

TEST(Hardening, AGovernorWithBrokenNumbersIsRefused) {
  auto world = pile(20);
  GovernorDesc desc{true, 5, {}};
  EXPECT_TRUE(world->set_governor(desc));
  for (const double bad : {0.0, -1.0, kNan}) {
    desc.budget_ms = bad;
    EXPECT_FALSE(world->set_governor(desc)) << bad;
  }
  desc.budget_ms = 5;
  for (const double bad : {-1.0, kNan, kInf}) {
    CostModel::Numbers numbers = CostModel().numbers();
    numbers[numbers.size() / 2] = bad;
    desc.costs = CostModel(numbers);
    EXPECT_FALSE(world->set_governor(desc)) << bad;
  }
  run(*world, 3);
  EXPECT_TRUE(all_finite(*world));
}

// Copies of bodies that the solver makes had no room for the spin of the first that turns, between two steps.
TEST(Hardening, TheFirstBodyThatTurnsMayBeLookedAtBeforeTheNextStep) {
  auto world = make(walled({-60, -60, 60, 60}));
  for (int k = 0; k < 400; ++k) {  // fast and thin: few are linked, so there are copies
    add(*world, disc({-55.0 + 5.5 * (k % 20), -55.0 + 5.5 * (k / 20)}, {20.0 - k % 41, 20.0 - (7 * k) % 41}, 0.5));
  }
  for (int k = 0; k < 60; ++k) {
    world->step();
    if (k % 10 != 9) continue;
    const BodyId id = world->id_of(static_cast<std::uint32_t>(k));
    const BodyState s = state(*world, id);
    ASSERT_TRUE(world->set_velocity(id, {s.vx, s.vy}, 3));
    EXPECT_TRUE(std::isfinite(world->diagnostics().kinetic));
    ASSERT_TRUE(world->set_velocity(id, {s.vx, s.vy}, 0));
  }
  EXPECT_TRUE(all_finite(*world));
}

// A step takes such numbers for 0, and whoever counted bodies by them outside of one did not.
TEST(Hardening, RestitutionAndFrictionTooSmallForAFloatAreNone) {
  WorldDesc desc = walled({0, 0, 20, 20});
  auto tiny = make(desc), none = make(desc);
  for (World* world : {tiny.get(), none.get()}) {
    const Material m = world == tiny.get() ? material(1e-40, 1e-42) : Material{};
    BodyDesc floor = box({5, 1});
    floor.type = BodyType::static_body;
    floor.material = m;
    add(*world, floor);
    add(*world, disc({5, 5}, {}, 0.5, m));
    run(*world, 1);
  }
  const std::vector<PlanEntry> has = tiny->plan(), wanted = none->plan();
  ASSERT_EQ(has.size(), wanted.size());
  for (std::size_t k = 0; k < has.size(); ++k) EXPECT_EQ(has[k].needed, wanted[k].needed) << has[k].stage;
}

// A step takes such numbers for 0: a share of a time step was 0 / 0, and what was saved then was refused as damaged.
TEST(Hardening, AfterATimeStepTooShortForADoubleWorldsAreSavedAndRestored) {
  for (const double dt : {5e-324, 1e-320, 1e-309, 3e-308, 1e-200}) {
    auto world = make(walled({-30, -30, 30, 30}));
    for (int k = 0; k < 40; ++k) {
      add(*world, disc({-20.0 + 5 * (k % 8), -20.0 + 5 * (k / 8)}, {40.0 - 9 * (k % 9), 30.0 - 7 * (k % 8)}, 0.5));
    }
    for (int k = 0; k < 20; ++k) {
      world->step(k % 3 == 1 ? dt : 1.0 / 60);
      std::vector<std::byte> saved;
      world->save(saved);
      std::string error;
      ASSERT_TRUE(World::from_state(saved, {}, error)) << dt << " s, step " << k << ": " << error;
    }
    EXPECT_TRUE(all_finite(*world));
  }
}

// The traits of a world were judged outside of a step, where 1e-320 is more than 0, and again at a restore, where it is
// not: the state was refused as damaged.
TEST(Hardening, AWallWithAFrictionOf1em320IsSavedAndRestored) {
  WorldDesc desc = walled({-20, -20, 20, 20});
  desc.wall.friction = desc.wall.restitution = desc.linear_damping = 1e-320;
  auto world = make(desc);
  add(*world, disc({0, 1}));
  run(*world, 2);
  std::vector<std::byte> state;
  world->save(state);
  std::string error;
  EXPECT_TRUE(world->restore(state, error)) << error;
}

}  // namespace
}  // namespace psim::test
