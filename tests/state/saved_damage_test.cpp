// Saved states whose bytes are not what a world wrote, though their checksum holds: refused, and then nothing has
// changed; or a world goes on from them.
#include <cstring>

#include "fuzz/world_promises.h"
#include "psim/saved_state.h"
#include "psim/scene.h"
#include "rigid_support.h"
#include "sanitized.h"
#include "state/archive.h"

namespace psim::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kHeader = sizeof(ArchiveHeader);

// With the size and the checksum that the bytes have now.
Bytes repaired(Bytes bytes) {
  ArchiveHeader header;
  header.seal(std::span(bytes).subspan(kHeader));
  std::memcpy(bytes.data(), &header, kHeader);
  return bytes;
}

std::unique_ptr<World> mixed_world(int frames) {
  auto world = make(walled({-20, -20, 20, 20}, {0, -kG}));
  world->set_event_options({true, true, 1, true});
  add(*world, ground(material(0.5, 0.4), 15));
  std::vector<BodyId> bodies;
  for (int k = 0; k < 40; ++k) {
    BodyDesc body = disc({-12 + (k % 10) * 2.4, -10 + (k / 10) * 2.0}, {}, 0.5, material(k % 3 == 0 ? 0.3 : 0, 0.4));
    if (k % 4 == 1) body.shape = BoxShape{1, 0.5, 0};
    if (k % 9 == 2) body.bullet = true;
    bodies.push_back(add(*world, body));
  }
  for (int k = 0; k < 6; ++k) {
    JointDesc joint;
    joint.type = static_cast<JointType>(k);
    joint.a = bodies[static_cast<std::size_t>(5 * k)];
    joint.b = bodies[static_cast<std::size_t>(5 * k + 1)];
    joint.stiffness = 10;
    std::string error;
    EXPECT_NE(world->add_joint(joint, error), kNoJoint) << error;
  }
  run(*world, frames);
  world->remove_body(bodies[7]);
  run(*world, 3);
  return world;
}

// What `state` does to a world of 5 discs that it is offered to, and to one that is made of it.
std::string fault_of(const Bytes& state) {
  auto other = make(walled({-20, -20, 20, 20}, {0, -kG}));
  for (int k = 0; k < 5; ++k) add(*other, disc({2.0 * k, 0}));
  run(*other, 2);
  std::string error;
  const std::uint64_t before = other->state_hash();
  if (!other->restore(state, error)) {
    if (error.empty() || error.find('\n') != error.npos) return "refused with: " + error;
    if (other->state_hash() != before || other->body_count() != 5) return "it changed the world";
    other->step();
    return fuzz::broken_promise(*other);
  }
  run(*other, 3);
  return fuzz::broken_promise(*other);
}

TEST(SavedDamage, AStateWithoutItsEndChangesNothing) {
  const auto world = mixed_world(60);
  Bytes state;
  world->save(state);
  auto other = make(walled({-20, -20, 20, 20}, {0, -kG}));
  for (int k = 0; k < 10; ++k) add(*other, disc({1.5 * k, 0}));
  run(*other, 5);
  const std::uint64_t before = other->state_hash();
  for (const std::size_t cut : {64u, 128u, 1024u}) {
    std::string error;
    EXPECT_FALSE(other->restore(repaired({state.begin(), state.end() - static_cast<std::ptrdiff_t>(cut)}), error));
    EXPECT_EQ(error, "it is damaged");
    EXPECT_EQ(other->body_count(), 10u);
    EXPECT_EQ(other->state_hash(), before);
  }
  run(*other, 5);
}

// Manifolds of a state that came back wait for its lists: what is refused meanwhile leaves them there.
TEST(SavedDamage, ARefusedStateLeavesOneThatJustCameBack) {
  const auto world = mixed_world(60);
  Bytes state, later;
  world->save(state);
  run(*world, 20);
  world->save(later);
  std::string error;
  ASSERT_TRUE(world->restore(state, error)) << error;
  EXPECT_FALSE(world->restore(repaired({later.begin(), later.end() - 64}), error));
  Bytes again;
  world->save(again);
  EXPECT_EQ(again, state);
  ASSERT_TRUE(world->restore(later, error)) << error;
  ASSERT_TRUE(world->restore(state, error)) << error;
  run(*world, 20);
  world->save(again);
  EXPECT_EQ(again, later);
}

std::unique_ptr<World> scene_world(const BuiltinScene& of, int threads) {
  std::string error;
  const auto scene = make_builtin(
      of.name, of.sized ? std::min<std::uint64_t>(of.default_particles, 120) : of.default_particles, 1, error);
  if (!scene || scene->body_count() > 2500) return nullptr;
  RunOptions options;
  options.threads = threads;
  auto world = build_world(*scene, options, error);
  EXPECT_NE(world, nullptr) << of.name << ": " << error;
  return world;
}

TEST(SavedDamage, TheStateOfAnySceneAtAnyMomentIsSound) {
  int states = 0;
  for (const BuiltinScene& of : builtin_scenes()) {
    const auto world = scene_world(of, 1 + states % 2);
    if (!world) continue;
    world->set_event_options({true, true, 1, true});
    Bytes state;
    std::string error;
    for (int frame = 0; frame < (kSanitized ? 40 : 130); ++frame) {
      if (frame < 4 || frame % 13 == 0) {
        world->save(state);
        ASSERT_NE(World::from_state(state, {}, error), nullptr) << of.name << ", frame " << frame << ": " << error;
        ++states;
      }
      world->step();
    }
  }
  EXPECT_GT(states, 100);
}

TEST(SavedDamage, WrongNumbersOfScenesAreRefusedOrServed) {
  Random random(7);
  int served = 0, refused = 0;
  for (const BuiltinScene& of : builtin_scenes()) {
    const auto world = scene_world(of, 1);
    if (!world) continue;
    run(*world, 30);
    Bytes state;
    world->save(state);
    for (int k = 0; k < (kSanitized ? 5 : 25); ++k) {
      Bytes bad = state;
      const std::size_t at = kHeader + random.below(bad.size() - kHeader - 4);
      const std::uint32_t values[] = {0,          1,          0x7FFFFFFF,
                                      0xFFFFFFFF, 0x7F800000, static_cast<std::uint32_t>(random.below(1000))};
      const std::uint32_t value = values[random.below(6)];
      std::memcpy(bad.data() + at, &value, 4);
      std::string error;
      const auto other = World::from_state(repaired(bad), {}, error);
      ++(other ? served : refused);
      if (!other) continue;
      run(*other, 3);
      ASSERT_EQ(fuzz::broken_promise(*other), "")
          << of.name << ", byte " << at << " of " << bad.size() << ": " << value;
    }
  }
  EXPECT_GT(8 * served, served + refused);  // both happen: neither to fewer than one in eight
  EXPECT_GT(8 * refused, served + refused);
}

TEST(SavedDamage, NumbersThatAreWrongAreRefusedOrServed) {
  for (const int frames : {3, 60, 500}) {
    const auto world = mixed_world(frames);
    Bytes state;
    world->save(state);
    EXPECT_EQ(fault_of(repaired(state)), "");
    Random random(static_cast<std::uint64_t>(frames));
    for (int k = 0; k < (kSanitized ? 150 : 500); ++k) {
      Bytes bad = state;
      const std::size_t at = kHeader + random.below(bad.size() - kHeader);
      const std::uint64_t how = random.below(3);
      bad[at] = how == 0   ? std::byte{255}
                : how == 1 ? bad[at] ^ std::byte{1}
                           : static_cast<std::byte>(random.below(256));
      ASSERT_EQ(fault_of(repaired(bad)), "") << frames << " frames, byte " << at << " is " << static_cast<int>(bad[at]);
    }
  }
}

// Tables of several parts, some of which still tumble.
std::unique_ptr<World> tables(int frames) {
  auto world = make(walled({-20, -20, 20, 20}, {0, -kG}));
  for (int k = 0; k < 30; ++k) {
    BodyDesc table;
    table.shape = CompoundShape{{{BoxShape{1.5, 0.15}, {0, 0.5}, 0}, {BoxShape{0.15, 0.5}, {-1.2, 0}, 0}}};
    table.position = {3.2 * (k % 10) - 15, 3.0 * (k / 10) - 17};
    add(*world, turned(table, 0.7 * k));
  }
  run(*world, frames);
  return world;
}

// Puts some numbers to a place of a state, in turn: small and large ones, of either sign, as floats and as the high half
// of doubles. What comes of it is refused, or served.
void forge(const Bytes& state, std::size_t at) {
  for (const std::uint32_t value : {0u, 1u, 500u, 0x58A00000u, 0xD8A00000u, 0x7F800000u, 0x7FFFFFFFu, 0xFFFFFFFFu}) {
    Bytes bad = state;
    std::memcpy(bad.data() + at, &value, 4);
    std::string error;
    const auto other = World::from_state(repaired(bad), {best_isa(), 1}, error);
    if (!other) continue;
    run(*other, 3);
    ASSERT_EQ(fuzz::broken_promise(*other, false), "") << "byte " << at << ": " << value;
  }
}

// The first numbers of a state say how far the world is, how its lists were made, and what follows.
TEST(SavedDamage, TheFirstNumbersAreRefusedOrServed) {
  std::string error;
  for (const char* name : {"gas-periodic", "tumbler"}) {
    const auto scene = make_builtin(name, 60, 1, error);
    ASSERT_TRUE(scene) << error;
    const auto world = build_world(*scene, {best_isa(), 1}, error);
    ASSERT_TRUE(world) << error;
    run(*world, 30);
    Bytes state;
    world->save(state);
    for (std::size_t at = kHeader; at < kHeader + 300 && !HasFatalFailure(); ++at) forge(state, at);
  }
}

// Every number of a state is forged in turn: all of a small one, of others about 1,500.
TEST(SlowSavedDamage, AnyNumberAnywhereIsRefusedOrServed) {
  std::vector<std::unique_ptr<World>> worlds;
  std::string error;
  for (const char* name : {"gas-periodic", "pile", "tumbler", "spinner"}) {
    const auto scene = make_builtin(name, 60, 1, error);
    ASSERT_TRUE(scene) << error;
    RunOptions options;
    options.threads = 1;
    worlds.push_back(build_world(*scene, options, error));
    ASSERT_TRUE(worlds.back()) << error;
    run(*worlds.back(), 30);
  }
  for (const int frames : {3, 60, 400}) worlds.push_back(mixed_world(frames));
  for (const int frames : {20, 150, 500}) worlds.push_back(tables(frames));
  for (std::size_t n = 0; n < worlds.size(); ++n) {
    Bytes state;
    worlds[n]->save(state);
    // Every byte of the first numbers, which say how far the world is and what follows.
    const std::size_t step = n == 0 && !kSanitized ? 1 : (state.size() - kHeader) / (kSanitized ? 100 : 1500);
    for (std::size_t at = kHeader; at + 4 <= state.size();
         at += at < kHeader + 300 ? 1 : std::max<std::size_t>(1, step)) {
      forge(state, at);
      if (HasFatalFailure()) FAIL() << "world " << n;
    }
  }
}

}  // namespace
}  // namespace psim::test
