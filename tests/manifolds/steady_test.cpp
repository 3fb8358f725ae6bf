// Contacts that kernels look at while they last (steady_lanes.h): a world that knows them goes on as one that does not.
// A state that comes back knows none.
#include "psim/saved_state.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr Material kRubs{1, 0, 0.5};

WorldDesc yard_world() { return walled({-40, -10, 40, 30}, {0, -kG}, kRubs); }

/// What tests call a world of boxes, and how it is pushed in each frame.
struct Yard {
  const char* name;
  void (*fill)(World&);
  void (*push)(World&, int frame);
};

void nothing(World&, int) {}

void pyramid(World& world) {
  add(world, fixed(box({0, -0.5}, 60, 1, kRubs)));
  for (int row = 0; row < 8; ++row) {
    for (int k = 0; k < 8 - row; ++k) add(world, box({1.02 * k + 0.51 * row, 0.5 + row}, 1, 1, kRubs));
  }
}

void heap(World& world) {
  add(world, fixed(box({0, -0.5}, 20, 1, kRubs)));
  add(world, fixed(box({-6, 3}, 1, 8, kRubs)));
  add(world, fixed(box({6, 3}, 1, 8, kRubs)));
  Random random(7);
  for (int k = 0; k < 60; ++k) {
    const Vec2 at{-4.0 + 1.3 * (k % 7) + random.uniform(-0.1, 0.1), 1.0 + 1.3 * (k / 7)};
    BodyDesc body = box(at, 1, random.uniform(0.5, 1.1), kRubs);
    if (k % 3 == 0) body = polygon(regular(5, 0.6), at, kRubs);
    if (k % 7 == 0) body = disc(at, {}, 0.5, kRubs);
    add(world, turned(body, random.uniform(-0.3, 0.3)));
  }
}

void towers(World& world) {
  add(world, fixed(box({0, -0.5}, 60, 1, kRubs)));
  for (int tower = 0; tower < 4; ++tower) {
    for (int k = 0; k < 9; ++k) add(world, box({3.0 * tower, 0.5 + k}, 1, 1, kRubs, tower == 3 && k == 8 ? 50 : 1));
  }
}

// Gently, so that contacts come and go while most last.
void shake(World& world, int frame) {
  if (frame % 9 != 0) return;
  for (std::uint32_t id = 5; id < 30; id += 6) {
    world.apply_impulse(world.id_of(id), {frame % 18 == 0 ? 0.02 : -0.02, 0.01});
  }
}

void tilt(World& world, int frame) { world.set_gravity({0.05 * (frame / 40 % 3), -kG}); }

const Yard kYards[] = {{"pyramid", pyramid, nothing}, {"pyramid, shaken", pyramid, shake},
                       {"heap", heap, nothing},       {"heap, shaken", heap, shake},
                       {"towers", towers, nothing},   {"towers, tilted", towers, tilt},
                       {"heap, tilted", heap, tilt}};

TEST(Steady, AWorldThatKnowsNoneGoesOnInTheSameBits) {
  for (const Yard& yard : kYards) {
    for (const bool sleeping : {false, true}) {
      auto world = make(yard_world()), other = make(yard_world(), Isa::scalar, 2);
      for (World* w : {world.get(), other.get()}) {
        w->set_sleeping(sleeping);
        yard.fill(*w);
      }
      std::vector<std::byte> state;
      std::string error;
      for (int frame = 0; frame < 240; ++frame) {
        for (World* w : {world.get(), other.get()}) {
          yard.push(*w, frame);
          w->step();
        }
        ASSERT_EQ(world->state_hash(), other->state_hash()) << yard.name << ", frame " << frame;
        if (frame % 7 == 3) continue;  // some steps know what was noted in one or two steps
        other->save(state);
        ASSERT_TRUE(other->restore(state, error)) << error;
      }
    }
  }
}

// What a host asks for between steps is that of pairs that no step read.
TEST(Steady, ContactsAreThoseOfAWorldThatKnowsNone) {
  auto world = make(yard_world()), other = make(yard_world());
  for (World* w : {world.get(), other.get()}) pyramid(*w);
  std::vector<std::byte> state;
  std::string error;
  for (int frame = 0; frame < 120; ++frame) {
    for (World* w : {world.get(), other.get()}) w->step();
    other->save(state);
    ASSERT_TRUE(other->restore(state, error)) << error;
    if (frame % 10 != 9) continue;
    const auto mine = world->contacts(), theirs = other->contacts();
    ASSERT_EQ(mine.size(), theirs.size()) << frame;
    for (std::size_t k = 0; k < mine.size(); ++k) {
      ASSERT_EQ(mine[k].impulse, theirs[k].impulse) << frame << ", " << k;
      ASSERT_EQ(mine[k].friction, theirs[k].friction) << frame << ", " << k;
      ASSERT_EQ(mine[k].separation, theirs[k].separation) << frame << ", " << k;
    }
  }
}

// A contact that opens for some steps keeps its lane, and tells nothing meanwhile.
TEST(Steady, AContactThatOpensCarriesNothing) {
  auto world = make(yard_world());
  add(*world, fixed(box({0, -0.5}, 20, 1, kRubs)));
  const BodyId lower = add(*world, box({0, 0.5}, 1, 1, kRubs)), upper = add(*world, box({0, 1.5}, 1, 1, kRubs));
  run(*world, 60);
  const auto carries = [&](BodyId id) {
    double sum = 0;
    for (const Contact& c : world->contacts()) sum += c.a == id || c.b == id ? c.impulse : 0;
    return sum;
  };
  EXPECT_GT(carries(upper), 0);
  for (int hop = 0; hop < 5; ++hop) {
    world->set_velocity(upper, {0, 0.6}, 0);  // 18 mm high, for 0.12 s
    run(*world, 4);
    EXPECT_EQ(carries(upper), 0) << hop;
    EXPECT_NEAR(world->body(lower)->y, 0.5, 0.002) << hop;
    run(*world, 40);
    EXPECT_GT(carries(upper), 0) << hop;
    EXPECT_NEAR(world->body(upper)->y, 1.5, 0.004) << hop;
  }
}

}  // namespace
}  // namespace psim::test
