// The brute-force pair finder against cases counted by hand and against explicit periodic copies.
#include "reference/pairs.h"

#include <gtest/gtest.h>

#include <random>

namespace reference {
namespace {

TEST(ReferencePairs, FindsWhatIsCloserThanTheMargin) {
  const std::vector<double> x{0, 1.1, 3, 3}, y{0, 0, 0, 0.5}, r{0.5, 0.5, 0.5, 0.5};
  const auto touching = pairs_closer_than(x, y, r, 0);
  ASSERT_EQ(touching.size(), 1u);
  EXPECT_EQ(touching[0].a, 2u);
  EXPECT_EQ(touching[0].b, 3u);
  EXPECT_NEAR(touching[0].gap, -0.5, 1e-15);
  EXPECT_EQ(pairs_closer_than(x, y, r, 0.11).size(), 2u);
  EXPECT_EQ(pairs_closer_than(x, y, r, 100).size(), 6u);
}

TEST(ReferencePairs, NearestImageIsTheShortest) {
  EXPECT_DOUBLE_EQ(nearest_image(0.75, 0), 0.75);
  EXPECT_DOUBLE_EQ(nearest_image(9, 10), -1);
  EXPECT_DOUBLE_EQ(nearest_image(-9, 10), 1);
  EXPECT_DOUBLE_EQ(nearest_image(3, 10), 3);
}

TEST(ReferencePairs, SeesAcrossTheSeamLikeExplicitCopies) {
  std::mt19937_64 random(7);
  const double width = 20, height = 12, margin = 0.3;
  std::uniform_real_distribution<double> ux(0, width), uy(0, height), ur(0.1, 0.9);
  std::vector<double> x, y, r;
  for (int i = 0; i < 80; ++i) {
    x.push_back(ux(random));
    y.push_back(uy(random));
    r.push_back(ur(random));
  }
  std::size_t by_copies = 0;
  for (std::size_t a = 0; a < x.size(); ++a) {
    for (std::size_t b = a + 1; b < x.size(); ++b) {
      bool close = false;
      for (int i = -1; i <= 1; ++i) {
        for (int j = -1; j <= 1; ++j) {
          const double dx = x[b] + i * width - x[a], dy = y[b] + j * height - y[a];
          close = close || std::hypot(dx, dy) - r[a] - r[b] < margin;
        }
      }
      by_copies += close ? 1 : 0;
    }
  }
  EXPECT_GT(by_copies, 20u);
  EXPECT_EQ(pairs_closer_than(x, y, r, margin, {width, height}).size(), by_copies);
  EXPECT_LT(pairs_closer_than(x, y, r, margin).size(), by_copies);
}

}  // namespace
}  // namespace reference
