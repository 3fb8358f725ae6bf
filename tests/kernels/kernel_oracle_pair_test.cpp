// Pair search (pair_kernel.h) against all pairs.
#include <set>

#include "kernel_grid.h"
#include "kernel_oracle.h"

namespace psim::test {
namespace {

using PairSet = std::multiset<std::pair<std::uint32_t, std::uint32_t>>;

PairSet close_pairs(const Grid& g) {
  PairSet pairs;
  for (std::uint32_t i = 0; i < g.size(); ++i) {
    for (std::uint32_t j = i + 1; j < g.size(); ++j) {
      double d2 = 0;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        double d = double(g.pos[2 * j + axis]) - double(g.pos[2 * i + axis]);
        if (g.periodic) d -= std::round(d * 0x1p-32) * 0x1p32;
        d2 += d * d * double{g.pitch} * double{g.pitch};
      }
      const double sum = double{g.reach[i]} + double{g.reach[j]};
      if (d2 < sum * sum) pairs.insert({i, j});
    }
  }
  return pairs;
}

TEST(KernelOracle, PairSearchFindsEveryClosePairOnce) {
  for (const bool periodic : {false, true}) {
    for (const std::size_t bodies : {2u, 30u, 150u, 400u}) {
      Random random(bodies);
      const Grid g(random, 6, 6, bodies, periodic);
      Found f(50000, g.size());
      kernels::PairList list = f.list();
      PairSet found;
      for (std::uint32_t r = 0; r < g.rows; ++r) {
        ASSERT_TRUE(scalar().find_pairs(g.row(r), g.row_begin[r], g.row_begin[r + 1], list));
      }
      for (std::uint32_t p = 0; p < list.count; ++p) {
        const std::uint32_t i = f.owner[p], j = f.other[p];
        found.insert({std::min(i, j), std::max(i, j)});
        ASSERT_LE(f.first[i], p);
        ASSERT_GT(i + 1 < g.size() ? f.first[i + 1] : list.count, p);
      }
      EXPECT_EQ(found, close_pairs(g)) << bodies << (periodic ? " periodic" : "");
      EXPECT_TRUE(bodies < 150 || found.size() > 20);
    }
  }
}

TEST(KernelOracle, FindNearSearchesARun) {
  Random random(8);
  const Grid g(random, 2, 2, 40, false);
  const PairSet close = close_pairs(g);
  for (std::uint32_t i = 0; i < 10; ++i) {
    Found f(100, g.size());
    kernels::PairList list = f.list();
    EXPECT_TRUE(scalar().find_near(g.row(0), i, 10, 37, list));
    std::uint32_t at = 0;
    for (std::uint32_t j = 10; j < 37; ++j) {
      if (!close.contains({i, j})) continue;
      ASSERT_LT(at, list.count);
      EXPECT_EQ(f.owner[at], i);
      EXPECT_EQ(f.other[at++], j);
    }
    EXPECT_EQ(at, list.count);
  }
}

TEST(KernelOracle, SelectPairsKeepsThoseThatCanMeet) {
  Random random(9);
  Bodies b(random, 40);
  std::vector<std::uint32_t> owner, other, want_i, want_j;
  const double time = 0.02, slack = 0.05;
  for (std::uint32_t i = 0; i < 40; ++i) {
    for (std::uint32_t j = i + 1; j < 40; ++j) {
      owner.push_back(i);
      other.push_back(j);
      const double far = length(double{kPitch} * (record(b.pos, j) - record(b.pos, i)));
      const double speed = length(record(b.vel, j) - record(b.vel, i));
      if (far < double{b.radius[i]} + double{b.radius[j]} + slack + speed * time) {
        want_i.push_back(i);
        want_j.push_back(j);
      }
    }
  }
  std::vector<std::uint32_t> out_i(owner.size() + kBlock), out_j(owner.size() + kBlock);
  kernels::PairSelection s;
  s.owner = owner.data();
  s.other = other.data();
  s.radius = b.radius.data();
  s.pitch_x = s.pitch_y = kPitch;
  s.time = 0.02f;
  s.slack = 0.05f;
  s.out_owner = out_i.data();
  s.out_other = out_j.data();
  const std::uint32_t n = scalar().select_pairs(b.view(), s, 0, static_cast<std::uint32_t>(owner.size()));
  out_i.resize(n);
  out_j.resize(n);
  EXPECT_EQ(out_i, want_i);
  EXPECT_EQ(out_j, want_j);
  EXPECT_GT(n, 50u);
  EXPECT_LT(n, owner.size() - 50);
}

}  // namespace
}  // namespace psim::test
