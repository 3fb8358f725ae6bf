// A world beside those that come of its saved state: all must go on with the same bits.
#pragma once

#include "psim/saved_state.h"
#include "rigid_support.h"

namespace psim::test {

using Bytes = std::vector<std::byte>;

struct Told {
  std::uint64_t hash = 0, contacts = 0, pairs = 0, asleep = 0, events = 0;
  friend bool operator==(const Told&, const Told&) = default;
};

inline void PrintTo(const Told& t, std::ostream* out) {
  *out << std::hex << t.hash << std::dec << ", contacts " << t.contacts << ", pairs " << t.pairs << ", asleep "
       << t.asleep << ", events " << t.events;
}

inline Told step(World& world) {
  const StepReport r = world.step();
  const Events e = world.events();
  std::uint64_t events = 0;
  const auto count = [&](std::uint64_t n) { events = events * 1000003 + n; };
  for (const auto& touches : {e.begin, e.end, e.sensor_begin, e.sensor_end}) {
    count(touches.size());
    for (const TouchEvent& t : touches) count((t.a.index * 31 + t.b.index) * 31 + t.part);
  }
  count(e.hits.size());
  return {world.state_hash(), r.contacts, r.pairs, r.asleep, events};
}

inline std::unique_ptr<World> resumed(const Bytes& state, Isa isa, int threads) {
  std::string error;
  RunOptions options;
  options.isa = isa;
  options.threads = threads;
  auto world = World::from_state(state, options, error);
  EXPECT_NE(world, nullptr) << error;
  return world;
}

/// `world` and what comes of its state do the same for some frames. The world itself goes on.
inline void expect_resumes(World& world, int frames, const char* what) {
  Bytes state, again;
  const std::uint64_t hash = world.state_hash();
  world.save(state);
  ASSERT_EQ(world.state_hash(), hash) << what;
  world.save(again);
  ASSERT_TRUE(again == state) << what << ": saved twice";
  auto a = resumed(state, Isa::scalar, 2);
  auto b = resumed(state, best_isa(), 1);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->state_hash(), hash) << what;
  EXPECT_EQ(a->frame(), world.frame());
  a->save(again);
  EXPECT_TRUE(again == state) << what << ": saved again, " << again.size() << " and " << state.size() << " bytes";
  for (int k = 1; k <= frames; ++k) {
    const Told told = step(world);
    ASSERT_EQ(step(*a), told) << what << ", " << k << " frames on, another ISA";
    ASSERT_EQ(step(*b), told) << what << ", " << k << " frames on";
  }
  std::string error;
  ASSERT_TRUE(a->restore(state, error)) << error;
  EXPECT_EQ(a->state_hash(), hash);
  b->save(again);
  ASSERT_TRUE(world.restore(state, error)) << error;
  for (int k = 1; k <= 3; ++k) EXPECT_EQ(step(*a), step(world)) << what << ", once more, " << k;
  ASSERT_TRUE(world.restore(again, error)) << error;
}

}  // namespace psim::test
