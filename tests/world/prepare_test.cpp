// World::prepare changes no result: a world that was prepared goes the way of one that was not, whatever the host does
// before the first step, and later calls do nothing at all.
#include "psim/recording.h"
#include "support.h"

namespace psim::test {
namespace {

enum class What : std::uint8_t { discs, sizes, boxes, joints, gas, periodic, sleepers };

struct Kind {
  const char* name;
  What what;
};

class Prepare : public testing::TestWithParam<Kind> {};

std::unique_ptr<World> world_of(What what, std::uint64_t seed, Isa isa = best_isa(), int threads = 1) {
  const bool flies = what == What::gas || what == What::periodic;
  WorldDesc desc = what == What::periodic ? periodic(40, 40) : walled({0, 0, 40, 40}, {0, flies ? 0 : -kG});
  desc.sleeping = what == What::sleepers;
  auto world = make(desc, isa, threads);
  Random random(seed);
  const std::size_t n = what == What::periodic ? 700 : 150;
  BodyId last;
  for (std::size_t k = 0; k < n; ++k) {
    const double speed = what == What::sleepers ? 0 : flies ? 30 : 4;
    const double radius = what == What::sizes ? random.uniform(0.05, 1.2) : 0.4;
    const Vec2 velocity{random.uniform(-speed, speed), random.uniform(-speed, speed)};
    BodyDesc b = disc({random.uniform(1, 39), random.uniform(1, 39)}, velocity, radius);
    b.material = material(flies ? 1 : 0.2, flies ? 0 : 0.5);
    if (what == What::boxes && k % 3 == 0) b.shape = BoxShape{0.7, 0.4, 0};
    const BodyId id = add(*world, b);
    if (what == What::joints && k % 4 == 1) {
      JointDesc rod;
      rod.a = last;
      rod.b = id;
      std::string error;
      EXPECT_NE(world->add_joint(rod, error), kNoJoint) << error;
    }
    last = id;
  }
  return world;
}

// The same calls for every world.
void disturb(World& world, Random& random) {
  const BodyId id = world.id_of(static_cast<std::uint32_t>(random.below(150)));
  switch (random.below(12)) {
    case 0:
      world.set_velocity(id, {random.uniform(-20, 20), random.uniform(-20, 20)}, 0);
      break;
    case 1:
      world.set_transform(id, {random.uniform(1, 39), random.uniform(1, 39)}, 0.3);
      break;
    case 2:
      world.remove_body(id);
      break;
    case 3:
      world.set_gravity({random.uniform(-3, 3), -5});
      break;
    case 4:
      world.set_skin(random.uniform(0.5, 2));
      break;
    case 5: {
      EventOptions events;
      events.contacts = random.chance(0.5);
      world.set_event_options(events);
      break;
    }
    case 6:
      world.enable_snapshots(random.chance(0.5));
      break;
    case 7:
      world.set_sleeping(random.chance(0.5));
      break;
    case 8: {
      std::vector<std::byte> state;
      std::string error;
      world.save(state);
      const bool back = !random.chance(0.5) || world.restore(state, error);
      EXPECT_TRUE(back) << error;
      break;
    }
    case 9:
      world.step(0.01);
      break;
    case 10:
      world.apply_impulse(id, {1e-6, 0});
      break;
    default:
      add(world, disc({random.uniform(1, 39), random.uniform(1, 39)}, {3, 1}, 0.3));
  }
}

TEST_P(Prepare, ChangesNoResult) {
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const auto plain = world_of(GetParam().what, seed);
    const auto prepared = world_of(GetParam().what, seed, available_isas().front(), 3);
    Random random(seed), same(seed);
    const bool host = seed % 2 == 0;
    prepared->prepare();
    for (int k = 0; k < 60; ++k) {
      if (host && k % 7 == 0) {
        disturb(*plain, random);
        disturb(*prepared, same);
      }
      if (k < 2 || k % 10 == 3) prepared->prepare();
      const StepReport a = plain->step(), b = prepared->step();
      ASSERT_EQ(prepared->state_hash(), plain->state_hash()) << "seed " << seed << " step " << k;
      ASSERT_EQ(a.pairs, b.pairs);
      ASSERT_EQ(a.rebuilt, b.rebuilt);
      ASSERT_EQ(a.skipped, b.skipped);
    }
  }
}

TEST_P(Prepare, LeavesAGovernorItsChoices) {
  for (const double budget_ms : {0.001, 0.02, 100.0}) {
    const auto plain = world_of(GetParam().what, 5), prepared = world_of(GetParam().what, 5);
    for (World* const world : {plain.get(), prepared.get()}) ASSERT_TRUE(world->set_governor({true, budget_ms, {}}));
    prepared->prepare();
    for (int k = 0; k < 40; ++k) {
      const StepReport a = plain->step(), b = prepared->step();
      ASSERT_EQ(prepared->state_hash(), plain->state_hash()) << budget_ms << " ms, step " << k;
      ASSERT_EQ(a.detail, b.detail) << budget_ms << " ms, step " << k;
      ASSERT_EQ(a.rebuilt, b.rebuilt);
      if (k == 0) {
        EXPECT_TRUE(a.detail.solves) << "the first step's lists belong to making ready";
      }
    }
  }
}

TEST_P(Prepare, IsNothingThatARecordingMustKnow) {
  const auto world = world_of(GetParam().what, 9);
  Recorder recorder(*world, 1);
  for (int k = 0; k < 40; ++k) {
    if (k % 5 != 1) world->prepare();
    recorder.step();
  }
  std::string error;
  const auto bytes = recorder.recording();
  const auto replay = Replay::open(bytes, {}, error);
  ASSERT_TRUE(replay) << error;
  while (replay->next()) {
  }
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_EQ(replay->world().state_hash(), world->state_hash());
}

INSTANTIATE_TEST_SUITE_P(Of, Prepare,
                         testing::Values(Kind{"Discs", What::discs}, Kind{"Sizes", What::sizes},
                                         Kind{"Boxes", What::boxes}, Kind{"Joints", What::joints},
                                         Kind{"Gas", What::gas}, Kind{"Periodic", What::periodic},
                                         Kind{"Sleepers", What::sleepers}),
                         [](const auto& test) { return test.param.name; });

TEST(Prepare, OfARestoredWorldChangesNothing) {
  for (const What what : {What::discs, What::boxes, What::gas, What::sleepers}) {
    const auto world = world_of(what, 4);
    for (int k = 0; k < 37; ++k) world->step();
    std::vector<std::byte> state;
    world->save(state);
    std::string error;
    const auto other = World::from_state(state, {.threads = 2}, error);
    ASSERT_TRUE(other) << error;
    other->prepare();
    for (int k = 0; k < 30; ++k) {
      world->step();
      other->step();
      ASSERT_EQ(other->state_hash(), world->state_hash()) << static_cast<int>(what) << " step " << k;
    }
  }
}

}  // namespace
}  // namespace psim::test
