// The truths of structures that the accuracy laboratory leans on, against known values and limits.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reference/pendulums.h"
#include "reference/structures.h"

namespace reference {
namespace {

TEST(Structures, HangingChainsSwayWithTheZerosOfLaguerrePolynomials) {
  const auto zeros = laguerre_zeros(20, 20);
  ASSERT_EQ(zeros.size(), 20u);
  EXPECT_NEAR(zeros[0], 0.0705398896919887, 1e-12);
  // Of a rope of 1 m: 4 pi / j sqrt(L/g), j the zeros of the Bessel function J0.
  const auto fine = laguerre_zeros(300, 3);
  for (const auto& [mode, period] : {std::pair{0u, 1.668368}, {1u, 0.726825}, {2u, 0.463631}}) {
    EXPECT_NEAR(2 * std::numbers::pi / std::sqrt(fine[mode] * 9.81 * 300), period, 3e-3);
  }
}

TEST(Structures, ElasticChainsHaveTheirKnownSag) {
  for (const auto& [ratio, sag] : {std::pair{10.0, 0.333842}, {100.0, 0.297014}, {1e12, 0.292344}}) {
    EXPECT_NEAR(elastic_chain_sag(1000, 1.2e-3, ratio, 1e-3, 1), sag, 1e-3) << ratio;
  }
  EXPECT_NEAR(elastic_chain_sag(20, 0.6, 1e12, 9.81, 10), chain_sag(20, 0.6, 10), 1e-9);
}

TEST(Structures, CantileversOfManyLinksAreTheElastica) {
  for (const auto& [load, drop] : {std::pair{1.0, 0.301721}, {2.0, 0.493457}, {5.0, 0.713792}, {10.0, 0.810609}}) {
    EXPECT_NEAR((Cantilever{1000, 1e-3, 1000 / load, 0, 1}.drop()), drop, 1e-3) << load;
  }
}

TEST(Structures, RockingBlocksLoseTheSameShareAtEveryImpact) {
  const RockingBlock block{0.5, 2};
  const double alpha = block.slenderness(), start = 0.5 * alpha;
  EXPECT_NEAR(alpha, 0.244979, 1e-6);
  EXPECT_NEAR(block.amplitude(start, 0), start, 1e-12);
  const double kept = std::pow(1 - 1.5 * std::pow(std::sin(alpha), 2), 2);
  const auto height = [&](double tilt) { return std::cos(alpha - tilt) - std::cos(alpha); };
  EXPECT_NEAR(height(block.amplitude(start, 3)), kept * height(block.amplitude(start, 2)), 1e-12);
}

TEST(Structures, TracksTakeWhatPointsIntoTheNextPiece) {
  const Track corner({{-5, 0}, {0, 0}, {5, 1}}, 0.5, 0);
  const double turn = std::atan(0.2);
  const auto up = corner.after(1, {{-2, 0.5}, {3, 0}});
  EXPECT_NEAR(length(up.v), 3 * std::cos(turn), 1e-6);
  EXPECT_NEAR(up.v.y / up.v.x, 0.2, 1e-6);
  // A circle of many pieces turns a disc round and takes little.
  std::vector<Vec> bowl;
  for (int k = 0; k <= 2000; ++k) {
    const double a = -std::numbers::pi * (1 - k / 2000.0);
    bowl.push_back({2 * std::cos(a), 2 * std::sin(a)});
  }
  const auto through = Track(bowl, 0.5, 9.81).after(0.3, {{0, -1.5}, {4, 0}});
  EXPECT_NEAR(0.5 * dot(through.v, through.v) + 9.81 * (through.x.y + 1.5), 8, 0.02);
  EXPECT_NEAR(length(through.x), 1.5, 1e-4);
}

}  // namespace
}  // namespace reference
