// WorldDesc::skin: how long lists last is the host's, what touches is not.
#include <psim/recording.h>

#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr double kSkins[] = {0.25, 0.5, 1, 2, 4};

std::unique_ptr<World> with_skin(WorldDesc desc, double skin) {
  desc.skin = skin;
  return make(desc);
}

/// The way from i to j, by the shorter way round.
Vec2 way(const World& world, const PublishedState& s, std::size_t i, std::size_t j) {
  const Bounds& b = world.desc().bounds;
  Vec2 d{s.x[j] - s.x[i], s.y[j] - s.y[i]};
  if (world.desc().boundary != Boundary::periodic) return d;
  d.x -= (b.xmax - b.xmin) * std::round(d.x / (b.xmax - b.xmin));
  d.y -= (b.ymax - b.ymin) * std::round(d.y / (b.ymax - b.ymin));
  return d;
}

// A gas goes the same way with any skin, until its bits make a difference: as many impacts, none seen late.
TEST(Skin, NoImpactIsMissed) {
  for (const double speed : {3.0, 8.0}) {
    double impacts = 0, deepest = 0;  // with the usual skin
    for (const double skin : {1.0, 0.25, 0.5, 2.0, 4.0}) {
      auto world = with_skin(periodic(80, 80), skin);
      add(*world, lattice(400, world->desc().bounds, 0.5, speed, material(1)));
      const double before = energy(*world);
      double virial = 0, most = 0;
      for (int k = 0; k < 50; ++k) {
        virial += world->step().virial;
        const PublishedState s = world->published();
        for (std::size_t i = 0; i < s.id.size(); ++i) {
          for (std::size_t j = i + 1; j < s.id.size(); ++j) {
            const Vec2 d = way(*world, s, i, j);
            if (d.x * d.x + d.y * d.y < 1) most = std::max(most, 1 - std::hypot(d.x, d.y));
          }
        }
      }
      EXPECT_NEAR(energy(*world), before, 1e-4 * before);
      if (skin == 1) impacts = virial, deepest = most;
      EXPECT_GT(virial, 0);
      EXPECT_NEAR(virial, impacts, 0.005 * impacts) << speed << ", skin " << skin;
      EXPECT_LE(most, deepest + 0.005) << speed << ", skin " << skin;
    }
  }
}

// Whatever overlaps in a pile is a contact, and the floor bears all.
TEST(Skin, NoContactOfAPileIsMissed) {
  for (const double skin : kSkins) {
    WorldDesc desc = walled({0, 0, 20, 60}, {0, -kG}, material(0, 0.5));
    desc.sleeping = false;
    auto world = with_skin(desc, skin);
    add(*world, lattice(200, {0, 0, 20, 20}, 0.5, 1, material(0, 0.5)));
    run(*world, 600);
    for (int k = 0; k < 5; ++k) {
      world->step();
      std::vector<std::pair<std::uint32_t, std::uint32_t>> named;
      double up = 0;
      for (const Contact& c : world->contacts()) {
        named.emplace_back(c.a.index, c.b.index);
        if (c.b == kNoBody) up -= c.impulse * c.normal.y + c.friction * c.normal.x;
      }
      EXPECT_NEAR(up, 200 * kPi / 4 * kG / 60, 0.02 * 200 * kPi / 4 * kG / 60) << skin;
      const PublishedState s = world->published();
      for (std::size_t i = 0; i < s.id.size(); ++i) {
        for (std::size_t j = i + 1; j < s.id.size(); ++j) {
          const Vec2 d = way(*world, s, i, j);
          if (std::hypot(d.x, d.y) > 1 - 1e-3) continue;
          EXPECT_TRUE(std::ranges::binary_search(named, std::pair(s.id[i], s.id[j])))
              << skin << ": " << s.id[i] << " and " << s.id[j] << ", " << std::hypot(d.x, d.y);
        }
      }
    }
  }
}

TEST(Skin, MoreMakesListsLessOftenOfMorePairs) {
  std::uint64_t rebuilt[5] = {}, pairs[5] = {};
  for (std::size_t n = 0; n < 5; ++n) {
    WorldDesc desc = walled({0, 0, 40, 60});
    desc.sleeping = false;
    auto world = with_skin(desc, kSkins[n]);
    add(*world, lattice(600, {0.5, 0.5, 39.5, 24}, 0.5, 0.5, {}));
    for (int k = 0; k < 200; ++k) {
      const StepReport report = world->step();
      rebuilt[n] += report.rebuilt ? 1 : 0;
      pairs[n] += report.pairs;
    }
  }
  for (std::size_t n = 1; n < 5; ++n) {
    EXPECT_LT(rebuilt[n], rebuilt[n - 1]) << kSkins[n];
  }
  EXPECT_GT(pairs[4], pairs[0]);
  EXPECT_GT(rebuilt[4], 0u);
}

TEST(Skin, OfAGasIsTheFramesThatListsLast) {
  std::uint64_t rebuilt[3] = {};
  for (std::size_t n = 0; n < 3; ++n) {
    WorldDesc desc = periodic(200, 200);
    auto world = with_skin(desc, n == 0 ? 0.25 : n == 1 ? 1 : 4);
    add(*world, lattice(1000, desc.bounds, 0.5, 8, material(1)));
    for (int k = 0; k < 60; ++k) rebuilt[n] += world->step().rebuilt ? 1 : 0;
  }
  EXPECT_GT(rebuilt[0], rebuilt[1]);
  EXPECT_GT(rebuilt[1], rebuilt[2]);
}

TEST(Skin, IsSetWhileItRuns) {
  WorldDesc steady = walled({0, 0, 20, 60});
  steady.sleeping = false;
  auto world = make(steady);
  add(*world, lattice(100, {0.5, 0.5, 19.5, 10}, 0.5, 0, {}));
  run(*world, 20);
  EXPECT_EQ(world->desc().skin, 1);
  for (const double wrong : {0.0, 0.2, 4.1, -1.0, kNan, kInf}) EXPECT_FALSE(world->set_skin(wrong)) << wrong;
  EXPECT_EQ(world->desc().skin, 1);
  run(*world, 400);
  EXPECT_TRUE(world->set_skin(1));  // nothing changes
  EXPECT_FALSE(world->step().rebuilt);
  EXPECT_TRUE(world->set_skin(2));
  EXPECT_EQ(world->desc().skin, 2);
  EXPECT_TRUE(world->step().rebuilt);
  EXPECT_FALSE(world->step().rebuilt);
  WorldDesc desc;
  desc.skin = 0.2;
  std::string error;
  EXPECT_EQ(World::create(desc, {}, error), nullptr);
  EXPECT_EQ(error, "skin must be from 0.25 to 4, not 0.2");
}

// The same bits on every ISA and number of threads, from a saved state on and in a recording.
TEST(Skin, IsPartOfWhatIsReplayed) {
  std::uint64_t first = 0;
  std::vector<std::byte> recording;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      WorldDesc desc = walled({0, 0, 30, 60}, {0, -kG}, material(0, 0.3));
      desc.skin = 0.5;
      auto world = make(desc, isa, threads);
      add(*world, lattice(300, {0.5, 0.5, 29.5, 20}, 0.5, 2, material(0.2, 0.3)));
      for (int k = 0; k < 10; ++k) add(*world, box({1.5 + 2 * k, 24}, 1.2, 0.8, material(0, 0.3)));
      Recorder recorder(*world, 10);
      for (int k = 0; k < 120; ++k) {
        if (k == 40) {
          EXPECT_TRUE(recorder.set_skin(3));
        }
        if (k == 80) {
          EXPECT_TRUE(recorder.set_skin(0.25));
        }
        recorder.step();
      }
      recording = recorder.recording();
      std::vector<std::byte> state;
      world->save(state);
      std::string error;
      auto other = World::from_state(state, {}, error);
      ASSERT_TRUE(other) << error;
      EXPECT_EQ(other->desc().skin, 0.25);
      run(*world, 60);
      run(*other, 60);
      EXPECT_EQ(other->state_hash(), world->state_hash());
      if (first == 0) first = world->state_hash();
      EXPECT_EQ(world->state_hash(), first);
    }
  }
  std::string error;
  auto replay = Replay::open(recording, {}, error);
  ASSERT_TRUE(replay) << error;
  while (replay->next()) ASSERT_EQ(replay->differs_at(), 0u) << replay->steps();
  EXPECT_EQ(replay->world().desc().skin, 0.25);
}

}  // namespace
}  // namespace psim::test
