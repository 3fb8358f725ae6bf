// How fast impacts may make bodies, by how much velocities differ nearby.
#include "lists/impact_speeds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "base/machine.h"
#include "support.h"

namespace psim::test {
namespace {

// Strips of a row of bodies each, and large bodies behind them.
class SegmentSpeedsTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kSegment = 4, kHops = 2;

  void add_strip(std::uint32_t n) {
    Strip strip;
    strip.body_begin = bodies.count;
    for (std::uint32_t k = 0; k < n; ++k) {
      const std::uint32_t at = bodies.count++;
      bodies.id[at] = at;
      bodies.radius[at] = 0.5f + static_cast<float>(k);
      push(at, 3, -20);
    }
    strip.body_end = bodies.count;
    table.strips.push_back(strip);
  }
  SegmentSpeedsTest() {
    bodies.reserve_slots(4096);
    table.other.reserve(100'000);
    table.owner.reserve(100'000);
  }
  void push(std::uint32_t at, float vx, float vy) {
    bodies.vel[2 * std::size_t{at}] = vx;
    bodies.vel[2 * std::size_t{at} + 1] = vy;
  }
  // Pairs must come by strip, in the order of their owners.
  void add_pair(std::size_t strip, std::uint32_t owner, std::uint32_t other) {
    Strip& s = table.strips[strip];
    if (s.pair_end == 0) s.pair_begin = s.pair_end = pairs_;
    table.owner[pairs_] = owner;
    table.other[pairs_] = other;
    s.pair_end = ++pairs_;
  }
  // Each body with the one beside it, and with the one above it in the next strip.
  void add_rows(std::size_t strips, std::uint32_t each) {
    for (std::size_t s = 0; s < strips; ++s) add_strip(each);
    table.large_begin = bodies.count;
    for (std::uint32_t i = 0; i < bodies.count; ++i) {
      if ((i + 1) % each != 0) add_pair(i / each, i, i + 1);
      if (i + each < bodies.count) add_pair(i / each, i, i + each);
    }
    add_strip(0);
  }
  double at(std::uint32_t slot) const { return speeds.at(table.strip_of(slot), slot); }
  void measure() {
    table.body_count = bodies.count;
    speeds.measure(table);
  }

  MemoryMeter memory;
  WorkerPool pool{2};
  KinematicBodies kinematics;
  MixingRules mixing;
  Material wall;
  Lattice lattice;
  BodyStore bodies{memory};
  StaticShapes shapes{memory, lattice};
  const kernels::KernelTable kernels = kernels_of(best_isa());
  PairTable table{memory};
  SegmentSpeeds speeds{{memory, lattice, bodies, shapes, kernels, pool, kinematics, mixing, wall}};
  std::uint32_t pairs_ = 0;
};

TEST_F(SegmentSpeedsTest, ACommonFallIsNoSpeed) {
  add_rows(5, 40);
  measure();
  for (std::uint32_t i = 0; i < bodies.count; ++i) EXPECT_EQ(at(i), 0);
  speeds.find_reach(100, 0.1);
  for (std::uint32_t i = 0; i < bodies.count; ++i) EXPECT_EQ(speeds.reach()[i], bodies.radius[i]);
}

TEST_F(SegmentSpeedsTest, OneThatIsFasterCountsForItsNeighboursAlone) {
  add_rows(9, 40);
  push(4 * 40 + 20, 6, -16);  // 5 m/s against the others
  measure();
  EXPECT_EQ(at(4 * 40 + 20), 5);
  for (std::uint32_t row = 0; row < 9; ++row) {
    for (std::uint32_t k = 0; k < 40; ++k) {
      const std::uint32_t up = row > 4 ? row - 4 : 4 - row;
      const std::uint32_t beside = std::max(k / kSegment, 5u) - std::min(k / kSegment, 5u);
      EXPECT_EQ(at(row * 40 + k), up + beside <= kHops ? 5 : 0) << row << " " << k;
    }
  }
}

TEST_F(SegmentSpeedsTest, TheReachIsTheWayAfterAReboundAndNoMoreThanSpeedsInTheWorld) {
  add_rows(3, 12);
  push(3, 3, -15);
  measure();
  speeds.find_reach(100, 0.1);
  EXPECT_FLOAT_EQ(speeds.reach()[3], bodies.radius[3] + 2 * 5 * 0.1f / 2);
  speeds.find_reach(4, 0.1);
  EXPECT_FLOAT_EQ(speeds.reach()[3], bodies.radius[3] + 4 * 0.1f / 2);
}

TEST_F(SegmentSpeedsTest, ALargeBodyCountsForAllThatItsPairsName) {
  add_strip(40);
  add_strip(40);
  table.large_begin = bodies.count;
  add_strip(2);
  push(81, 3, 20);
  for (const std::uint32_t other : {1u, 39u, 60u}) add_pair(2, 81, other);
  measure();
  for (const std::uint32_t i : {0u, 3u, 36u, 60u, 63u, 81u}) EXPECT_EQ(at(i), 40) << i;
  for (const std::uint32_t i : {4u, 35u, 40u, 59u, 64u, 80u}) EXPECT_EQ(at(i), 0) << i;
}

TEST_F(SegmentSpeedsTest, RemovedBodiesDoNotCount) {
  add_rows(2, 8);
  push(5, 300, 300);
  bodies.id[5] = kNoSlot;
  measure();
  for (std::uint32_t i = 0; i < bodies.count; ++i) EXPECT_EQ(at(i), 0);
}

// The oracle walks over the bodies of all segments that few pairs lead to.
TEST_F(SegmentSpeedsTest, TheSpeedIsTheBoxOfTheVelocitiesThatFewPairsLeadTo) {
  std::mt19937 random(7);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  const std::uint32_t sizes[] = {37, 1, 64, 0, 5, 130};
  for (const std::uint32_t n : sizes) add_strip(n);
  table.large_begin = bodies.count;
  add_strip(9);
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    push(i, static_cast<float>(below(1000)) / 100, static_cast<float>(below(1000)) / 100);
  }
  const std::uint32_t all = bodies.count;
  std::vector<std::vector<std::uint32_t>> partners(all);
  for (std::size_t s = 0; s < table.strips.size(); ++s) {
    const std::uint32_t begin = table.strips[s].body_begin, end = table.strips[s].body_end;
    // A strip's pairs reach into the next one, those of the group of large bodies and of a round world anywhere.
    const std::uint32_t beyond = s + 1 < table.strips.size() ? table.strips[s + 1].body_end : all;
    for (std::uint32_t i = begin; i < end; ++i) {
      for (int n = 0; n < 3; ++n) {
        const std::uint32_t j =
            i >= table.large_begin ? below(all) : begin + below(std::min(beyond, table.large_begin) - begin);
        if (i == j) continue;
        add_pair(s, i, j);
        partners[i].push_back(j);
        partners[j].push_back(i);
      }
    }
  }
  measure();
  const auto segment_of = [&](std::uint32_t i) {  // its first body
    const std::uint32_t begin = table.strips[table.strip_of(i)].body_begin;
    return i >= table.large_begin ? i : begin + (i - begin) / kSegment * kSegment;
  };
  std::vector<std::vector<std::uint32_t>> members(all);
  for (std::uint32_t i = 0; i < all; ++i) members[segment_of(i)].push_back(i);
  for (std::uint32_t i = 0; i < all; ++i) {
    std::vector<std::uint32_t> near = members[segment_of(i)];
    for (std::uint32_t hop = 0; hop < kHops; ++hop) {
      std::vector<std::uint32_t> more = near;
      for (const std::uint32_t a : near) {
        for (const std::uint32_t b : partners[a]) {
          more.insert(more.end(), members[segment_of(b)].begin(), members[segment_of(b)].end());
        }
      }
      std::sort(more.begin(), more.end());
      more.erase(std::unique(more.begin(), more.end()), more.end());
      near = more;
    }
    Vec2 low{1e9, 1e9}, high{-1e9, -1e9};
    for (const std::uint32_t a : near) {
      low = {std::min(low.x, bodies.velocity(a).x), std::min(low.y, bodies.velocity(a).y)};
      high = {std::max(high.x, bodies.velocity(a).x), std::max(high.y, bodies.velocity(a).y)};
    }
    EXPECT_NEAR(at(i), length_of(high - low), 1e-5) << i;
  }
}

TEST_F(SegmentSpeedsTest, MemoryIsGivenBack) {
  add_rows(4, 40);
  measure();
  speeds.find_reach(1, 0.1);
  EXPECT_GE(speeds.bytes(), 160 / kSegment * 32);
  EXPECT_GE(speeds.column_bytes(), 160 * sizeof(float));
  speeds.release();
  EXPECT_EQ(speeds.bytes() + speeds.column_bytes(), 0u);
}

}  // namespace
}  // namespace psim::test
