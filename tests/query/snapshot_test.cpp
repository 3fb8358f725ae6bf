// What a renderer reads: whole frames only, from another thread, with the frame before for
// interpolation.
#include <atomic>
#include <map>
#include <thread>

#include "support.h"

namespace psim::test {
namespace {

TEST(Snapshots, AreOffUntilAskedFor) {
  auto world = pile(20);
  run(*world, 5);
  EXPECT_EQ(world->latest_snapshot(), nullptr);
  world->enable_snapshots(true);
  world->step();
  EXPECT_NE(world->latest_snapshot(), nullptr);
}

TEST(Snapshots, HoldTheStateOfTheirFrame) {
  auto world = pile(100, material(0.2, 0.3));
  world->enable_snapshots(true);
  for (int k = 0; k < 30; ++k) {
    world->step();
    const Snapshot* shot = world->latest_snapshot();
    ASSERT_NE(shot, nullptr);
    ASSERT_EQ(shot->frame, world->frame());
    const PublishedState s = world->published();
    ASSERT_EQ(shot->id.size(), s.id.size());
    for (std::size_t row = 0; row < s.id.size(); ++row) {
      ASSERT_EQ(shot->id[row], s.id[row]);
      ASSERT_NEAR(shot->origin.x + static_cast<double>(shot->x[row]), s.x[row], 1e-5);
      ASSERT_NEAR(shot->origin.y + static_cast<double>(shot->y[row]), s.y[row], 1e-5);
      ASSERT_NEAR(static_cast<double>(shot->angle[row]), s.angle[row], 1e-5);
      ASSERT_NEAR(static_cast<double>(shot->radius[row]), s.radius[row], 1e-6);
      ASSERT_NEAR(static_cast<double>(shot->speed[row]), std::hypot(s.vx[row], s.vy[row]), 1e-4);
    }
  }
}

TEST(Snapshots, InterpolateBetweenThisFrameAndTheOneBefore) {
  // Bodies come and go: the pairs must stay those of one and the same body.
  auto world = pile(100, material(0.2, 0.3));
  world->enable_snapshots(true);
  std::map<std::uint32_t, std::pair<float, float>> before;
  for (int k = 0; k < 60; ++k) {
    if (k == 20) world->remove_body(world->id_of(11));
    if (k == 30) add(*world, disc({3, 20}));
    world->step();
    const Snapshot* shot = world->latest_snapshot();
    ASSERT_NE(shot, nullptr);
    std::map<std::uint32_t, std::pair<float, float>> now;
    for (std::size_t row = 0; row < shot->id.size(); ++row) {
      const auto old = before.find(shot->id[row]);
      if (old != before.end()) {
        ASSERT_EQ(shot->x_prev[row], old->second.first) << "frame " << k << " row " << row;
        ASSERT_EQ(shot->y_prev[row], old->second.second) << "frame " << k << " row " << row;
      }
      now[shot->id[row]] = {shot->x[row], shot->y[row]};
    }
    before = std::move(now);
  }
}

TEST(Snapshots, DoNotJumpAcrossAPeriodicSeam) {
  auto world = make(periodic(20, 20));
  add(*world, disc({19, 1}, {6, -6}));
  world->enable_snapshots(true);
  for (int k = 0; k < 120; ++k) {
    world->step();
    const Snapshot* shot = world->latest_snapshot();
    ASSERT_NE(shot, nullptr);
    ASSERT_NEAR(shot->x[0] - shot->x_prev[0], 0.1, 1e-4) << "frame " << k;
    ASSERT_NEAR(shot->y[0] - shot->y_prev[0], -0.1, 1e-4) << "frame " << k;
  }
}

TEST(Snapshots, ReadFromAnotherThreadAreWholeFrames) {
  // Everything flies at one velocity, in steps that are whole in binary: in a whole frame every
  // body has come equally far, and exactly as far as the frame's number says.
  WorldDesc desc = unbounded(512, {0, 0});
  desc.dt = 1.0 / 64;
  auto world = make(desc, best_isa(), 2);
  Discs discs;
  for (int j = 0; j < 40; ++j) {
    for (int i = 0; i < 40; ++i) discs.push(-256.0 + 4 * i, -256.0 + 4 * j, 0.5, 1, 0.5);
  }
  add(*world, discs);
  world->enable_snapshots(true);
  std::atomic<bool> done{false};
  std::atomic<int> torn{0}, seen{0};
  std::thread renderer([&] {
    std::uint64_t last = 0;
    while (!done.load(std::memory_order_acquire)) {
      const Snapshot* shot = world->latest_snapshot();
      if (!shot || shot->frame == last) continue;
      bool whole = shot->frame > last && shot->id.size() == discs.size();
      last = shot->frame;
      const double flown = static_cast<double>(shot->frame) / 64;
      for (std::size_t row = 0; whole && row < shot->id.size(); ++row) {
        const std::size_t id = shot->id[row];
        const double x = shot->origin.x + static_cast<double>(shot->x[row]);
        const double y = shot->origin.y + static_cast<double>(shot->y[row]);
        const double x_prev = shot->origin.x + static_cast<double>(shot->x_prev[row]);
        const double y_prev = shot->origin.y + static_cast<double>(shot->y_prev[row]);
        whole = x == discs.x[id] + flown && y == discs.y[id] + 0.5 * flown && x_prev == x - 1.0 / 64 &&
                y_prev == y - 0.5 / 64;
      }
      if (!whole) ++torn;
      ++seen;
    }
  });
  run(*world, 2000);
  while (seen.load() < 1) std::this_thread::yield();
  done.store(true, std::memory_order_release);
  renderer.join();
  EXPECT_EQ(torn.load(), 0);
  EXPECT_GE(seen.load(), 1);
}

TEST(Snapshots, ChangeNoBitOfTheState) {
  auto with = pile(200, material(0.2, 0.3));
  auto without = pile(200, material(0.2, 0.3));
  with->enable_snapshots(true);
  EXPECT_EQ(hashes(*with, 60), hashes(*without, 60));
}

}  // namespace
}  // namespace psim::test
