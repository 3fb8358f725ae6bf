// A saved state goes on with the same bits: in the world that it came from, in a new one, on every ISA and
// number of threads, whatever is in the world.
#include <numbers>

#include "psim/scene.h"
#include "sanitized.h"
#include "saved_support.h"

namespace psim::test {
namespace {

struct SceneCase {
  const char* name;
  std::uint64_t bodies;
  int frames, each;
};

class SavedScene : public testing::TestWithParam<SceneCase> {};
INSTANTIATE_TEST_SUITE_P(Scenes, SavedScene,
                         testing::Values(SceneCase{"discs", 2000, 60, 13}, SceneCase{"pile", 2000, 200, 31},
                                         SceneCase{"rough-pile", 1000, 200, 31}, SceneCase{"hourglass", 600, 100, 17},
                                         SceneCase{"galton", 200, 200, 37}, SceneCase{"mixed-sizes", 1000, 100, 17},
                                         SceneCase{"billiard", 0, 200, 23}, SceneCase{"orbits", 300, 40, 13},
                                         SceneCase{"gas-periodic", 1000, 60, 19}, SceneCase{"joint_grid", 100, 40, 13},
                                         SceneCase{"tumbler", 0, 24, 11}, SceneCase{"card_house", 0, 200, 41},
                                         SceneCase{"arch", 0, 200, 47}, SceneCase{"pyramid", 0, 200, 47},
                                         SceneCase{"high_mass_ratio_2", 0, 200, 29},
                                         SceneCase{"overlap_recovery", 0, 200, 29},
                                         SceneCase{"far_pyramid", 0, 100, 29}, SceneCase{"ball_and_chain", 0, 60, 19},
                                         SceneCase{"bridge", 0, 100, 29}, SceneCase{"newtons_cradle", 0, 100, 29},
                                         SceneCase{"domino_run", 0, 200, 41}, SceneCase{"cloth", 0, 20, 9},
                                         SceneCase{"spinner", 0, 12, 5}),
                         [](const auto& info) {
                           std::string name = info.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST_P(SavedScene, GoesOnWithTheSameBits) {
  std::string error;
  const auto scene = make_builtin(GetParam().name, GetParam().bodies, 1, error);
  ASSERT_TRUE(scene) << error;
  auto world = build_world(*scene, {}, error);
  ASSERT_TRUE(world) << error;
  world->set_event_options({true, true, 0.5, true});
  for (int k = 0; k <= GetParam().frames; ++k) {
    if (k % GetParam().each == 0) {
      expect_resumes(*world, 4, ("frame " + std::to_string(k)).c_str());
      if (testing::Test::HasFatalFailure()) return;
    }
    world->step();
  }
}

// ---- what the host did since the last step ------------------------------------------------------------

TEST(SavedState, KeepsWhatTheHostDidSinceTheLastStep) {
  auto world = make(walled({0, 0, 30, 60}, {0, -kG}, kGrip));
  Random random(3);
  std::vector<BodyId> ids;
  std::vector<JointId> joints;
  const auto put = [&] {
    const Vec2 at{random.uniform(2, 28), random.uniform(5, 55)};
    const double r = random.uniform(0.2, 0.5);
    BodyDesc body =
        random.chance(0.5) ? disc(at, {}, r, kGrip) : turned(box(at, 2 * r, r, kGrip), random.uniform(0, 3));
    if (random.chance(0.1)) body.type = BodyType::static_body;
    if (random.chance(0.1)) body.filter.group = -1;
    ids.push_back(add(*world, body));
  };
  for (int k = 0; k < 150; ++k) put();
  world->set_event_options({true, true, 0.5, false});
  std::string error;
  for (int frame = 0; frame < 240; ++frame) {
    const std::size_t k = random.below(ids.size()), j = random.below(ids.size());
    switch (frame % 12) {
      case 1:
        put();
        break;
      case 3:
        world->remove_body(ids[k]);
        ids[k] = ids.back();
        ids.pop_back();
        break;
      case 5:
        world->apply_impulse_at(ids[k], {random.uniform(-1, 1), 2}, {10, 10});
        break;
      case 7: {
        JointDesc d;
        d.type = random.chance(0.5) ? JointType::rope : JointType::revolute;
        d.a = ids[k];
        d.b = ids[j];
        const JointId id = world->add_joint(d, error);
        if (id != kNoJoint) joints.push_back(id);
        break;
      }
      case 9:
        if (!joints.empty()) {
          world->remove_joint(joints.back());
          joints.pop_back();
        }
        break;
      case 11:
        world->set_transform(ids[k], {random.uniform(2, 28), 40}, 1);
        break;
      default:
        break;
    }
    if (frame % 5 == 0 || frame % 12 == 1 || frame % 12 == 3) {
      expect_resumes(*world, 3, ("frame " + std::to_string(frame)).c_str());
      if (testing::Test::HasFatalFailure()) return;
    }
    world->step();
  }
}

// Restored and changed before a step: what the lists were made from is not there any more.
TEST(SavedState, TakesChangesRightAfterItCameBack) {
  using Change = void (*)(World&);
  const Change changes[] = {[](World& w) { w.remove_body(w.id_of(30)); },
                            [](World& w) {
                              add(w, disc({10, 30}, {}, 0.5, kGrip));
                            },
                            [](World& w) {
                              add(w, static_disc({10, 30}, 0.5));
                            },
                            [](World& w) {
                              w.set_transform(w.id_of(7), {3, 30}, 0);
                            },
                            [](World& w) {
                              w.set_gravity({1, -5});
                            },
                            [](World& w) { w.set_skin(2); },
                            [](World& w) {
                              JointDesc d;
                              d.a = w.id_of(3);
                              d.b = w.id_of(40);
                              std::string error;
                              w.add_joint(d, error);
                            }};
  for (const Change change : changes) {
    for (const bool once_more : {false, true}) {
      auto world = make(walled({0, 0, 20, 40}, {0, -kG}, kGrip));
      Random random(11);
      for (int k = 0; k < 200; ++k) add(*world, disc({random.uniform(1, 19), random.uniform(1, 39)}, {}, 0.4, kGrip));
      for (int k = 0; k < 90; ++k) world->step();
      Bytes state;
      world->save(state);
      auto other = resumed(state, best_isa(), 1);
      if (once_more) change(*world), change(*other), world->step(), other->step();
      if (once_more) world->save(state), other = resumed(state, best_isa(), 2);
      change(*world);
      change(*other);
      for (int k = 0; k < 5; ++k) ASSERT_EQ(step(*other), step(*world)) << k;
    }
  }
}

// Back and forth in one world, as a game does that hears of its players' inputs late.
TEST(SavedState, RollsBackAndForth) {
  auto build = [] {
    auto world = make(walled({0, 0, 40, 40}, {0, -kG}, kGrip));
    Random random(9);
    for (int k = 0; k < 500; ++k) add(*world, disc({random.uniform(1, 39), random.uniform(1, 39)}, {}, 0.4, kGrip));
    return world;
  };
  auto world = build(), straight = build();
  const BodyId pushed = straight->id_of(17);
  std::array<Bytes, 8> ring;
  std::string error;
  for (int frame = 0; frame < 120; ++frame) {
    // The push of frame 20k + 3 is heard of five frames late.
    if (frame % 20 == 3) straight->apply_impulse(pushed, {1, 2});
    const Told told = step(*straight);
    world->save(ring[static_cast<std::size_t>(frame % 8)]);
    Told mine = step(*world);
    if (frame % 20 == 8) {
      ASSERT_TRUE(world->restore(ring[static_cast<std::size_t>((frame - 5) % 8)], error)) << error;
      world->apply_impulse(pushed, {1, 2});
      for (int k = 0; k <= 5; ++k) mine = step(*world);
    }
    if (frame % 20 < 3 || frame % 20 >= 8) {
      ASSERT_EQ(mine, told) << frame;
    }
  }
}

TEST(SavedState, OfADiscOfAPileTakesAtMost96Bytes) {
  constexpr std::size_t kDiscs = kSanitized ? 5000 : 20000;
  std::string error;
  const auto scene = make_builtin("pile", kDiscs, 1, error);
  for (const bool sleeping : {false, true}) {
    const auto world = build_world(*scene, {}, error);
    world->set_sleeping(sleeping);
    Bytes state;
    for (int frame = 0; frame < 500; ++frame) {  // falling, landing, at rest; watched, but awake
      if (world->step().asleep != 0) break;
      if (frame % 5 != 0) continue;
      world->save(state);
      EXPECT_LE(state.size(), 96u * kDiscs) << frame;
    }
  }
}

// ---- what is refused ------------------------------------------------------------------------------------

TEST(SavedState, RefusesWhatIsNone) {
  auto world = make(walled({0, 0, 10, 10}, {0, -kG}));
  add(*world, disc({5, 5}));
  world->step();
  Bytes state;
  world->save(state);
  std::string error;
  const std::uint64_t hash = world->state_hash();
  EXPECT_FALSE(world->restore({}, error));
  EXPECT_EQ(error, "it is cut short");
  Bytes bad(state.begin(), state.end() - 64);
  EXPECT_FALSE(world->restore(bad, error));
  EXPECT_NE(error.find("bytes of"), std::string::npos) << error;
  bad = state;
  bad[0] = std::byte{0};
  EXPECT_FALSE(world->restore(bad, error));
  EXPECT_EQ(error, "it is no saved state of psim");
  bad = state;
  bad[8] = std::byte{99};
  EXPECT_FALSE(world->restore(bad, error));
  EXPECT_EQ(error, "its format is 99, this psim reads 33");
  bad = state;
  bad[200] ^= std::byte{1};
  EXPECT_FALSE(world->restore(bad, error));
  EXPECT_EQ(error, "it is damaged");
  auto wide = make(walled({0, 0, 11, 10}, {0, -kG}));
  EXPECT_FALSE(wide->restore(state, error));
  EXPECT_EQ(error, "the saved world has other bounds or another boundary");
  EXPECT_EQ(world->state_hash(), hash);
  EXPECT_TRUE(world->restore(state, error)) << error;
}

TEST(SavedState, KeepsManyContactsOfOneBody) {
  WorldDesc desc = walled({-30, -30, 30, 30}, {0, 0});
  desc.fields = {WellField{{0, 0}, 20, 0, 0, 0}};  // 20 m/s^2 towards the middle
  auto world = make(desc);
  add(*world, disc({0, 0}, {}, 10));
  for (int k = 0; k < 500; ++k) {
    const double turn = 2 * std::numbers::pi * k / 500;
    add(*world, disc({10.05 * std::cos(turn), 10.05 * std::sin(turn)}, {}, 0.05));
  }
  std::uint64_t most = 0;
  for (int frame = 0; frame < 8; ++frame) {
    most = std::max<std::uint64_t>(most, world->step().contacts);
    const BodyId last = add(*world, disc({0, 20}));
    ASSERT_TRUE(world->remove_body(last));  // lists with a gap are not made again: pairs have names
    expect_resumes(*world, 4, ("frame " + std::to_string(frame)).c_str());
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(most, 400u);
}

// Of a body of many parts the lists take those near another body, as it lay when they were made; a state is saved when
// it has turned since. The number of their pairs was found again as the body lies now.
TEST(SavedState, KeepsContactsOfABodyOfManyPartsThatTurns) {
  Random random(20261126);
  for (int world_number = 0; world_number < 12; ++world_number) {
    auto world = make(walled({-30, -30, 30, 30}, {0, -1}));
    ChainShape chain;
    for (int k = 0; k < 400; ++k) chain.vertices.push_back({-20 + 0.1 * k, random.uniform(-0.3, 0.3)});
    BodyDesc mill = disc({0, 0});
    mill.type = BodyType::kinematic_body;
    mill.shape = chain;
    mill.angular_velocity = random.uniform(-0.02, 0.02);
    add(*world, mill);
    for (int k = 0; k < 60; ++k) {
      add(*world, disc({random.uniform(-18, 18), random.uniform(0.5, 1.5)}, {}, random.uniform(0.1, 0.4)));
    }
    for (int frame = 0; frame < 30; ++frame) {
      world->step();
      if (frame % 3 == 2) expect_resumes(*world, 2, ("frame " + std::to_string(frame)).c_str());
      if (HasFatalFailure()) return;
    }
  }
}

// A step is spread over frames, bodies go, are sorted and pushed, so that the work begins anew: whose slots the contacts
// of the last step name is remembered through all of it.
TEST(SavedState, OfWorkThatBeginsAnewAfterBodiesWereSorted) {
  Random random(7);
  for (int world_number = 0; world_number < 20; ++world_number) {
    auto world = make(walled({0, 0, 20, 20}));
    std::vector<BodyId> all;
    const auto drop = [&] {
      all.push_back(add(*world, disc({random.uniform(1, 19), random.uniform(1, 19)}, {random.uniform(-5, 5), 0}, 0.2)));
    };
    for (int k = 0; k < 250; ++k) drop();
    for (int k = 0; k < 30; ++k) world->step();
    for (int round = 0; round < 40; ++round) {
      for (std::size_t k = random.below(6); k > 0 && all.size() > 50; --k) {
        std::swap(all[random.below(all.size())], all.back());
        world->remove_body(all.back());
        all.pop_back();
      }
      const auto pieces = static_cast<std::uint16_t>(1 + random.below(12));
      world->replay({4, false, 1, 1, pieces});
      if (random.chance(0.5)) drop();
      if (random.chance(0.3)) world->set_velocity(all[random.below(all.size())], {1, 3}, 0);
      std::vector<std::byte> state;
      world->save(state);
      std::string error;
      const auto other = World::from_state(state, {}, error);
      ASSERT_NE(other, nullptr) << error << ", world " << world_number << ", round " << round;
      if (random.chance(0.6)) continue;
      world->step();
      other->step();
      ASSERT_EQ(other->state_hash(), world->state_hash()) << "world " << world_number << ", round " << round;
    }
  }
}

// Slots in a strip and the next one are further apart than 16 bits count.
TEST(SavedState, KeepsContactsOfRowsOfManyBodies) {
  if (kSanitized) GTEST_SKIP() << "70,000 bodies";
  constexpr std::size_t kDiscs = 70'000;
  auto world = make(walled({0, 0, 0.99 * kDiscs + 1, 10}, {0, -kG}));
  std::vector<double> x, y, radius{0.5};
  for (std::size_t k = 0; k < kDiscs; ++k) {
    x.push_back(0.5 + 0.99 * static_cast<double>(k));
    y.push_back(0.5);
  }
  DiscBatch batch;
  batch.x = x;
  batch.y = y;
  batch.radius = radius;
  std::uint32_t first = 0;
  std::string error;
  ASSERT_EQ(world->add_discs(batch, first, error), kDiscs) << error;
  for (int frame = 0; frame < 3; ++frame) world->step();
  ASSERT_TRUE(world->remove_body(world->id_of(first + 7)));  // lists with a gap are not made again: pairs have names
  Bytes state;
  world->save(state);
  auto other = resumed(state, best_isa(), 2);
  ASSERT_TRUE(other);
  for (int frame = 0; frame < 3; ++frame) ASSERT_EQ(step(*other), step(*world)) << frame;
  EXPECT_GT(world->step().contacts, kDiscs);
}

// Where bodies crowd all at once, a strip's pairs are more than the room that they were given, and lie behind
// those of the others.
TEST(SavedState, KeepsContactsOfASuddenCrowd) {
  auto world = make(walled({0, 0, 200, 200}, {0, 0}));
  std::vector<BodyId> ids;
  for (int k = 0; k < 6400; ++k) {
    ids.push_back(
        add(*world, disc({3.0 + 2.4 * (k % 80), 3.0 + 2.4 * (k / 80)}, {0.1 * (k % 7), -0.1 * (k % 5)}, 0.5)));
  }
  for (int frame = 0; frame < 3; ++frame) world->step();
  std::uint64_t most = 0;
  for (const double y : {40.0, 120.0}) {
    for (int k = 0; k < 300; ++k) {
      const std::size_t id = static_cast<std::size_t>(y * 20 + k);
      ASSERT_TRUE(world->set_transform(ids[id], {60 + 0.6 * (k % 60), y + 0.6 * (k / 60)}, 0));
    }
    most = std::max<std::uint64_t>(most, world->step().contacts);
    const BodyId last = add(*world, disc({199, 199}));
    ASSERT_TRUE(world->remove_body(last));  // pairs have names
    expect_resumes(*world, 4, "crowd");
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(most, 1000u);
}

// What a host chose after the save is gone, and the deepest overlap is that of the save, also where only the pairs'
// names were saved.
TEST(SavedState, WhatStepsTellComesBackAndTheDeepestOverlapToo) {
  auto world = make(walled({0, 0, 10, 10}, {0, -kG}));
  for (int k = 0; k < 8; ++k) add(*world, disc({1.0 + k, 0.45}));
  world->set_sleeping(false);
  world->step();
  const double deepest = world->diagnostics().max_penetration;
  ASSERT_GT(deepest, 0.01);
  Bytes before, after;
  world->save(before);
  world->set_event_options({.contacts = true, .hits = false, .hit_speed = 1, .sensors = false});
  world->save(after);
  std::string error;
  BodyId last;
  for (const Bytes* state : {&before, &after}) {
    ASSERT_TRUE(world->restore(*state, error)) << error;
    EXPECT_EQ(world->diagnostics().max_penetration, deepest);
    std::size_t told = 0;
    for (int k = 0; k < 3; ++k) {
      last = add(*world, disc({1.5 + k, 9.6}));  // touches the top
      world->step();
      told += world->events().begin.size();
    }
    EXPECT_EQ(told > 0, state == &after);
    EXPECT_GT(world->diagnostics().max_penetration, 0.01);
  }
  ASSERT_TRUE(world->remove_body(last));  // so that pairs are saved
  const double removed = world->diagnostics().max_penetration;
  EXPECT_GT(removed, 0.01);
  world->save(after);
  ASSERT_TRUE(world->restore(after, error)) << error;
  EXPECT_EQ(world->diagnostics().max_penetration, removed);
}

TEST(SavedState, FilesThatWereCutOrDamagedAreRefused) {
  auto world = make(walled({0, 0, 10, 10}, {0, -kG}));
  for (int k = 0; k < 50; ++k) add(*world, disc({1 + 0.15 * k, 5}, {}, 0.07));
  for (int k = 0; k < 20; ++k) world->step();
  Bytes state, read;
  world->save(state);
  const std::string path = testing::TempDir() + "saved_state_test.state";
  std::string error;
  ASSERT_TRUE(write_state(path, state, error)) << error;
  ASSERT_TRUE(read_state(path, read, error)) << error;
  EXPECT_EQ(read, state);
  const Bytes packed = pack_state(state);
  for (std::size_t cut = 0; cut < packed.size(); cut += 61) {
    EXPECT_FALSE(unpack_state({packed.data(), cut}, read, error)) << cut;
  }
  for (std::size_t at = 0; at < packed.size(); at += 7) {
    Bytes bad = packed;
    bad[at] ^= std::byte{0x10};
    EXPECT_FALSE(unpack_state(bad, read, error)) << at;
  }
  EXPECT_FALSE(read_state(path + ".none", read, error));
  EXPECT_EQ(error, path + ".none: No such file or directory");
  EXPECT_FALSE(write_state("/nowhere/at/all", state, error));
  EXPECT_EQ(error, "/nowhere/at/all: No such file or directory");
  std::remove(path.c_str());
}

}  // namespace
}  // namespace psim::test
