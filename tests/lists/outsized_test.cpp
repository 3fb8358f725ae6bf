// Bodies of very different sizes and of very many parts: pairs and bytes follow what is near.
#include "rigid_support.h"

namespace psim::test {
namespace {

std::uint64_t most_pairs(World& world, int frames) {
  std::uint64_t most = 0;
  for (int k = 0; k < frames; ++k) most = std::max(most, world.step().pairs);
  return most;
}

TEST(Outsized, APlanetIsThePartnerOfWhatIsNearIt) {
  WorldDesc desc = unbounded(5e6, {0, 0});
  auto world = make(desc);
  add(*world, disc({0, -1e6 - 60}, {}, 1e6));
  add(*world, lattice(2000, {-50, -40, 50, 50}, 0.4, 0, {}, 0.9));
  EXPECT_LE(most_pairs(*world, 30), 4000u);
  EXPECT_LE(world->memory_bytes(), 4u << 20);
}

// A million times as large and as small as the others: each size has margins of its own.
TEST(Outsized, EachSizeHasMarginsOfItsOwn) {
  auto world = make(unbounded(3000, {0, 0}));
  for (int k = 0; k < 400; ++k) {
    const double x = k % 20, y = k / 20;
    add(*world, disc({3e-3 * x, 3e-3 * y}, {}, 1e-3));
    add(*world, disc({100 + 3 * x, 3 * y}, {}, 1));
    add(*world, disc({-1000 + 30 * x, 1000 + 30 * y}, {}, 10));
  }
  add(*world, disc({0, -1500}, {}, 1000));
  EXPECT_LE(most_pairs(*world, 10), 200u);  // nobody is within a tenth of a radius of another one
}

// Far faster than the others: it has a margin of its own, in which all may be, and theirs stay as they are.
TEST(Outsized, AFastBodyHasAMarginOfItsOwn) {
  constexpr std::size_t kOthers = 1000;
  const auto with = [](double speed) {
    auto world = make(unbounded(1e5, {0, 0}));
    add(*world, disc({-40, 60}, {speed, 0}, 0.3));
    add(*world, lattice(kOthers, {-50, -40, 50, 50}, 0.4, 1, {}, 0.9));
    return std::pair{most_pairs(*world, 20), world->memory_bytes()};
  };
  const auto [pairs, bytes] = with(30'000);
  const auto [few, least] = with(0);
  EXPECT_LE(pairs, kOthers + few);
  EXPECT_LE(bytes, least + 1000 * kOthers);
}

TEST(Outsized, AHeapOfKinematicBodiesHasNoPairs) {
  for (const bool boxes : {false, true}) {
    auto world = make(unbounded(100, {0, 0}));
    for (int k = 0; k < 1000; ++k) {
      const Vec2 at{0.001 * k, 0};
      add(*world, kinematic(boxes ? box(at) : disc(at)));
    }
    const BodyId between = add(*world, disc({0.5, 0.9}));
    const std::uint64_t pairs = most_pairs(*world, 5);
    EXPECT_GE(pairs, 1u);
    EXPECT_LE(pairs, 1000u);
    EXPECT_LE(world->memory_bytes(), 8u << 20);
    for (const Contact& c : world->contacts()) EXPECT_TRUE(c.a == between || c.b == between);
  }
}

/// A closed outline of many segments that turns, with discs, boxes and capsules inside.
std::unique_ptr<World> ring(int segments, double omega, BodyId& outline, std::vector<BodyId>& inside) {
  auto world = make(unbounded(50), best_isa(), 2);
  BodyDesc ring;
  ring.shape = ChainShape{regular(segments, 10), true};
  ring.type = BodyType::kinematic_body;
  ring.material = material(0, 0.4);
  ring.angular_velocity = omega;
  outline = add(*world, ring);
  Random random(7);
  for (int k = 0; k < 120; ++k) {
    const Vec2 at{-5 + 1.0 * (k % 11), -5 + 0.9 * (k / 11)};
    const Material m = material(0.2, 0.4);
    inside.push_back(add(*world, k % 3 == 0   ? disc(at, {}, random.uniform(0.1, 0.4), m)
                                 : k % 3 == 1 ? box(at, 0.6, 0.4, m)
                                              : capsule(at, 0.4, 0.15, m)));
  }
  return world;
}

TEST(Outsized, NobodyLeavesATurningRingOfManySegments) {
  for (const int segments : {20, 500}) {
    for (const double omega : {0.0, 0.5, 6.0}) {
      BodyId outline;
      std::vector<BodyId> inside;
      auto world = ring(segments, omega, outline, inside);
      for (int frame = 0; frame < 240; ++frame) {
        const StepReport report = world->step();
        ASSERT_LE(report.pairs, 120u * 60u);
        for (const BodyId id : inside) {
          const BodyState s = state(*world, id);
          ASSERT_LT(std::hypot(s.x, s.y), 10.0) << segments << " segments, " << omega << " rad/s, frame " << frame;
        }
      }
    }
  }
}

// The host may turn it faster, stop it or place it anew between two steps.
TEST(Outsized, ARingOfManySegmentsFollowsItsHost) {
  BodyId outline;
  std::vector<BodyId> inside;
  auto world = ring(300, 0, outline, inside);
  Random random(3);
  double angle = 0;
  for (int frame = 0; frame < 300; ++frame) {
    if (frame % 20 == 10) world->set_velocity(outline, {}, random.uniform(-3, 3));
    if (frame % 50 == 30) world->set_transform(outline, {}, angle += 0.7);
    world->step();
    for (const BodyId id : inside) {
      const BodyState s = state(*world, id);
      ASSERT_LT(std::hypot(s.x, s.y), 10.1) << "frame " << frame;
    }
  }
}

TEST(Outsized, AWorldWithManyPartsGoesOnFromASavedState) {
  BodyId outline;
  std::vector<BodyId> inside;
  auto world = ring(200, 1.5, outline, inside);
  std::vector<std::byte> saved;
  std::string error;
  for (int frame = 0; frame < 120; ++frame) {
    world->step();
    if (frame % 7 != 3) continue;
    world->save(saved);
    auto other = World::from_state(saved, {best_isa(), 1}, error);
    ASSERT_NE(other, nullptr) << error;
    for (int more = 0; more < 12; ++more) {
      world->step();
      other->step();
    }
    ASSERT_EQ(world->state_hash(), other->state_hash()) << "frame " << frame;
  }
}

TEST(Outsized, AStateIsSoundAfterABodyOfManyPartsWasRemoved) {
  for (const bool alone : {false, true}) {
    BodyId outline;
    std::vector<BodyId> inside;
    auto world = ring(200, 1.5, outline, inside);
    for (const BodyId id : inside) {
      if (alone) world->remove_body(id);
    }
    for (int frame = 0; frame < 5; ++frame) world->step();
    ASSERT_TRUE(world->remove_body(outline));
    std::vector<std::byte> saved;
    world->save(saved);
    std::string error;
    auto other = World::from_state(saved, {best_isa(), 1}, error);
    ASSERT_NE(other, nullptr) << error;
    for (World* w : {world.get(), other.get()}) {
      for (int frame = 0; frame < 5; ++frame) w->step();
    }
    EXPECT_EQ(world->state_hash(), other->state_hash());
  }
}

// ---- bodies that come and go

TEST(Growth, BodiesThatComeAndGoTakeNoMoreRoomThanThereAreAtOnce) {
  for (const int steps_every : {1, 7, 1 << 30}) {
    auto world = make(unbounded(1000, {0, 0}));
    add(*world, lattice(100, {-50, -50, 50, 50}, 0.4, 0, {}, 0.9));
    std::size_t before = 0;
    std::vector<BodyId> here;
    Random random(5);
    for (int k = 0; k < 40000; ++k) {
      here.push_back(add(*world, k % 5 == 0 ? box({random.uniform(60, 90), random.uniform(-90, 90)})
                                            : disc({random.uniform(60, 90), random.uniform(-90, 90)}, {}, 0.3)));
      if (here.size() > 20) {
        const std::size_t at = random.below(here.size());
        ASSERT_TRUE(world->remove_body(here[at]));
        here.erase(here.begin() + static_cast<std::ptrdiff_t>(at));
      }
      if (k % steps_every == steps_every - 1) world->step();
      if (k == 15000) before = world->memory_bytes();
    }
    EXPECT_LE(world->memory_bytes(), before + before / 20) << "a step every " << steps_every;
    EXPECT_EQ(world->dynamic_count(), 120u);
  }
}

// Chains of any number of segments, boxes and discs; with steps after each, some, or none.
TEST(Growth, StaticBodiesThatComeAndGoTakeNoMoreRoomThanThereAreAtOnce) {
  for (const int steps_every : {1, 7, 1 << 30}) {
    auto world = make(unbounded(1000, {0, 0}));
    add(*world, disc({}));
    std::size_t before = 0, state_before = 0;
    std::vector<BodyId> here;
    std::vector<std::byte> state;
    Random random(6);
    for (int k = 0; k < 12000; ++k) {
      BodyDesc fixed = k % 3 == 0 ? box({random.uniform(60, 90), 0}) : disc({random.uniform(60, 90), 50}, {}, 0.3);
      if (k % 3 == 1) {
        ChainShape chain;
        for (std::size_t p = 0; p < 2 + random.below(40); ++p)
          chain.vertices.push_back({1.0 * static_cast<double>(p), 0});
        if (chain.vertices.size() < 2) chain.vertices.push_back({50, 0});
        fixed.shape = chain;
      }
      fixed.type = BodyType::static_body;
      here.push_back(add(*world, fixed));
      if (here.size() > 20) {
        const std::size_t at = random.below(here.size());
        ASSERT_TRUE(world->remove_body(here[at]));
        here.erase(here.begin() + static_cast<std::ptrdiff_t>(at));
      }
      if (k % steps_every == steps_every - 1) world->step();
      if (k != 6000 && k != 11999) continue;
      world->save(state);
      if (k == 6000) before = world->memory_bytes(), state_before = state.size();
    }
    EXPECT_LE(world->memory_bytes(), before + before / 20) << "a step every " << steps_every;
    EXPECT_LE(state.size(), state_before + state_before / 4) << "a step every " << steps_every;
    std::string error;
    EXPECT_NE(World::from_state(state, {}, error), nullptr) << error;
  }
}

// What a slot held before is not told to the body that gets it next.
TEST(Growth, AWorldWhoseBodiesCameAndWentGoesOnFromASavedState) {
  auto world = make(walled({0, 0, 20, 20}, {0, -kG}, material(0.2, 0.3)), best_isa(), 2);
  std::vector<BodyId> here;
  Random random(9);
  std::vector<std::byte> saved;
  std::string error;
  for (int k = 0; k < 600; ++k) {
    for (int more = 0; more < 3; ++more) {
      const Vec2 at{random.uniform(1, 19), random.uniform(1, 19)};
      here.push_back(add(*world, random.chance(0.3) ? box(at, 0.5, 0.7, material(0.2, 0.3))
                                                    : disc(at, {}, random.uniform(0.2, 0.5), material(0.2, 0.3))));
    }
    while (here.size() > 40 || (!here.empty() && random.chance(0.4))) {
      const std::size_t at = random.below(here.size());
      world->remove_body(here[at]);
      here.erase(here.begin() + static_cast<std::ptrdiff_t>(at));
    }
    if (k % 4 != 0) world->step();
    if (k % 25 != 9) continue;
    world->save(saved);
    auto other = World::from_state(saved, {best_isa(), 1}, error);
    ASSERT_NE(other, nullptr) << error;
    for (World* w : {world.get(), other.get()}) {
      add(*w, disc({3, 18}));
      w->remove_body(here.front());
      for (int step = 0; step < 5; ++step) w->step();
    }
    here.erase(here.begin());
    ASSERT_EQ(world->state_hash(), other->state_hash()) << "round " << k;
  }
}

}  // namespace
}  // namespace psim::test
