// A saved state of a world in which bodies sleep goes on with the same bits, and takes few bytes a sleeper.
#include "psim/scene.h"
#include "sanitized.h"
#include "saved_support.h"

namespace psim::test {
namespace {

TEST(SavedState, BringsSleepersBackAndWakesThem) {
  auto world = make(walled({0, 0, 20, 20}, {0, -kG}, kGrip));
  std::vector<BodyId> ids;
  for (int k = 0; k < 60; ++k) {
    BodyDesc body = disc({1 + 0.3 * k, 0.5 + 0.02 * (k % 7)}, {}, 0.14, kGrip);
    if (k % 3 == 0) body = box({1 + 0.3 * k, 0.3}, 0.28, 0.28, kGrip);
    body.fixed_rotation = k % 2 == 0;
    ids.push_back(add(*world, body));
  }
  for (int frame = 0; frame < 400 && world->step().asleep < 40; ++frame) {
    if (frame % 37 == 0) expect_resumes(*world, 5, ("frame " + std::to_string(frame)).c_str());
  }
  ASSERT_GE(world->step().asleep, 40u);
  expect_resumes(*world, 5, "asleep");
  Bytes state;
  world->save(state);
  auto other = resumed(state, Isa::scalar, 1);
  for (World* w : {world.get(), other.get()}) {
    w->remove_body(ids[7]);
    add(*w, disc({10, 6}, {0, -5}, 0.5, kGrip));
  }
  for (int frame = 0; frame < 200; ++frame) {
    ASSERT_EQ(step(*other), step(*world)) << frame;
    if (frame % 31 == 3) expect_resumes(*world, 3, "woken");
    if (frame % 31 == 3) world->save(state), other = resumed(state, best_isa(), 2);
  }
}

// Asleep, and on the way there: some sleep, others are watched.
TEST(SavedState, OfADiscOfASleepingPileTakesAtMost96Bytes) {
  constexpr std::size_t kDiscs = kSanitized ? 5000 : 20000;
  constexpr std::size_t kRoll = kDiscs / 1000;  // as many may roll to and fro under arches without end
  // Some 90 KB are the world's own, whoever lives in it: under a sanitizer there are too few discs to share them.
  constexpr std::size_t kMostOfWorld = kSanitized ? 100'000 : 0;
  struct Pile {
    const char* name;
    std::size_t bytes, asleep;  // a disc, while some sleep and once all do
  };
  for (const Pile& pile : {Pile{"pile", 96, 96}, Pile{"rough-pile", 96, 96}}) {
    std::string error;
    const auto scene = make_builtin(pile.name, kDiscs, 2, error);
    ASSERT_TRUE(scene) << error;
    const auto world = build_world(*scene, {best_isa(), 2}, error);
    ASSERT_TRUE(world) << error;
    Bytes state;
    std::uint64_t asleep = 0;
    bool half = false;
    for (int frame = 0; frame < 3000 && asleep + kRoll < kDiscs; ++frame) {
      const std::uint64_t now = world->step().asleep;
      const bool look = now != asleep || frame % 16 == 0;
      asleep = now;
      if (asleep == 0 || !look) continue;
      half = half || (10 * asleep > 3 * kDiscs && 10 * asleep < 7 * kDiscs);
      world->save(state);
      EXPECT_LE(state.size(), pile.bytes * kDiscs + kMostOfWorld)
          << pile.name << ", frame " << frame << ", " << asleep << " asleep";
    }
    ASSERT_GE(asleep + kRoll, kDiscs) << pile.name;
    EXPECT_TRUE(half) << pile.name;
    EXPECT_LE(state.size(), pile.asleep * kDiscs) << pile.name;
  }
}

// More sleepers than are packed together, of discs and boxes that touch each other.
std::unique_ptr<World> long_row() {
  constexpr int kBodies = 9000;
  auto world = make(walled({0, 0, kBodies + 10.0, 30}, {0, -kG}, kGrip));
  for (int k = 0; k < kBodies; ++k) {
    const Vec2 at{1 + 0.999 * k, 0.4995};
    add(*world, k % 50 == 7 ? box(at, 1, 1, kGrip) : disc(at, {}, 0.5, kGrip));
  }
  return world;
}

// Of what sleeps only what is another is restored; what is saved is made anew only where it changed.
TEST(SavedState, RollsBackOverSleepAndWaking) {
  const int end = kSanitized ? 120 : 400;
  auto straight = long_row(), world = long_row();
  Random random(5);
  Bytes state, later, whole;
  std::string error;
  std::uint64_t most = 0;
  for (int frame = 0; frame < end; ++frame) {
    if (frame % 60 == 59) {
      for (World* w : {straight.get(), world.get()}) add(*w, disc({20.0 * frame + 3, 4}, {0, -8}, 0.5, kGrip));
    }
    if (frame % 9 == 4) {  // somebody else's future
      world->save(state);
      for (int k = 0; k < 3; ++k) {
        const auto id = static_cast<std::uint32_t>(random.below(8000));
        if (random.chance(0.3)) {
          world->remove_body(world->id_of(id));
          add(*world, disc({random.uniform(5, 8000), 5}, {}, 0.4, kGrip));
        } else {
          world->apply_impulse(world->id_of(id), {0.5, 3});
        }
      }
      for (int k = 0; k < static_cast<int>(random.below(20)); ++k) world->step();
      world->save(later);
      if (random.chance(0.5)) {
        ASSERT_TRUE(world->restore(state, error)) << error;
        ASSERT_TRUE(world->restore(later, error)) << error;
      }
      ASSERT_TRUE(world->restore(state, error)) << error;
    }
    const Told told = step(*straight);
    ASSERT_EQ(step(*world), told) << frame;
    most = std::max(most, told.asleep);
  }
  EXPECT_GT(most, 8192u);
  straight->save(whole);  // for the first time
  world->save(state);
  EXPECT_TRUE(state == whole);
  EXPECT_EQ(world->contacts().size(), straight->contacts().size());
  expect_resumes(*world, 5, "the row");
}

}  // namespace
}  // namespace psim::test
