// Saved states whose bytes are not what a world wrote, though their checksum holds: refused, and then nothing has
// changed; or a world goes on from them.
#include <cstring>

#include "fuzz/world_promises.h"
#include "psim/saved_state.h"
#include "rigid_support.h"
#include "sanitized.h"

namespace psim::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kHeader = 40, kSize = 16, kFirst = 24, kHash = 32;

std::uint64_t number_at(const Bytes& bytes, std::size_t at) {
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// With the size and the checksum that the bytes have now.
Bytes repaired(Bytes bytes) {
  const std::uint64_t size = bytes.size(), first = number_at(bytes, kFirst);
  std::memcpy(bytes.data() + kSize, &size, sizeof size);
  const Bytes packed = pack_state(std::span(bytes).subspan(kHeader, first));
  std::memcpy(bytes.data() + kHash, packed.data() + 24, 8);
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

TEST(SavedDamage, NumbersThatAreWrongAreRefusedOrServed) {
  for (const int frames : {3, 60, 500}) {
    const auto world = mixed_world(frames);
    Bytes state;
    world->save(state);
    EXPECT_EQ(fault_of(repaired(state)), "");
    const std::uint64_t first = number_at(state, kFirst);
    Random random(static_cast<std::uint64_t>(frames));
    for (int k = 0; k < (kSanitized ? 150 : 500); ++k) {
      Bytes bad = state;
      const std::size_t at = kHeader + random.below(k % 4 == 0 ? bad.size() - kHeader : first);
      const std::uint64_t how = random.below(3);
      bad[at] = how == 0 ? std::byte{255} : how == 1 ? bad[at] ^ std::byte{1} : static_cast<std::byte>(random.below(256));
      ASSERT_EQ(fault_of(repaired(bad)), "") << frames << " frames, byte " << at << " is " << static_cast<int>(bad[at]);
    }
  }
}

}  // namespace
}  // namespace psim::test
