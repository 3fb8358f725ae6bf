// Where the bodies of a group stand: lattices, random places, lists.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "place/placement.h"
#include "psim/scene.h"

namespace psim::test {
namespace {

GroupDesc group_of(Layout layout, std::uint64_t count, Bounds region, double radius = 0.5) {
  GroupDesc group;
  group.layout = layout;
  group.count = count;
  group.region = region;
  group.radius_min = group.radius_max = radius;
  return group;
}

PlacedGroup placed(const GroupDesc& group) {
  std::string error;
  auto result = place_group(group, error);
  EXPECT_TRUE(result) << error;
  return result.value_or(PlacedGroup{});
}

std::string refusal(const GroupDesc& group) {
  std::string error;
  EXPECT_FALSE(place_group(group, error));
  EXPECT_EQ(error.find('\n'), std::string::npos) << error;
  return error;
}

double smallest_gap(const PlacedGroup& g) {
  double gap = 1e300;
  for (std::size_t i = 0; i < g.x.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double dx = g.x[i] - g.x[j], dy = g.y[i] - g.y[j];
      gap = std::min(gap, std::sqrt(dx * dx + dy * dy) - g.radius[i] - g.radius[j]);
    }
  }
  return gap;
}

bool inside(const PlacedGroup& g, const Bounds& b) {
  for (std::size_t k = 0; k < g.x.size(); ++k) {
    const double r = g.radius[k] * (1 - 1e-9);
    if (g.x[k] - r < b.xmin || g.x[k] + r > b.xmax) return false;
    if (g.y[k] - r < b.ymin || g.y[k] + r > b.ymax) return false;
  }
  return true;
}

TEST(ScenePlacement, LatticeFillsRowsFromTheBottomAtCellCentres) {
  // 7 bodies over 8 x 4 m: ceil(sqrt(14)) = 4 columns, 2 rows, the upper one short of a body.
  const PlacedGroup g = placed(group_of(Layout::lattice, 7, {10, 20, 18, 24}));
  ASSERT_EQ(g.x.size(), 7u);
  for (std::size_t k = 0; k < 7; ++k) {
    EXPECT_DOUBLE_EQ(g.x[k], 11 + 2.0 * static_cast<double>(k % 4));
    EXPECT_DOUBLE_EQ(g.y[k], k < 4 ? 21 : 23);
    EXPECT_EQ(g.radius[k], 0.5);
    EXPECT_EQ(g.vx[k], 0);
    EXPECT_EQ(g.vy[k], 0);
  }
}

TEST(ScenePlacement, HexShiftsOddRowsByHalfACellAndStaysInTheRegion) {
  const Bounds region{0, 0, 9, 9};
  const PlacedGroup g = placed(group_of(Layout::hex, 36, region));
  const double cell = 9 / 6.5;
  EXPECT_DOUBLE_EQ(g.x[0], cell / 2);
  EXPECT_DOUBLE_EQ(g.x[6], cell);
  EXPECT_DOUBLE_EQ(g.x[12], cell / 2);
  EXPECT_TRUE(inside(g, region));
  EXPECT_GE(smallest_gap(g), cell - 1 - 1e-12);
}

TEST(ScenePlacement, RingStandsOnTheEllipseThatTouchesTheSidesOfItsRegion) {
  const PlacedGroup round = placed(group_of(Layout::ring, 12, {-3, 1, 3, 7}));
  ASSERT_EQ(round.x.size(), 12u);
  for (std::size_t k = 0; k < 12; ++k) {
    const double angle = std::acos(-1) * static_cast<double>(k) / 6;
    EXPECT_NEAR(round.x[k], 3 * std::cos(angle), 1e-14);
    EXPECT_NEAR(round.y[k], 4 + 3 * std::sin(angle), 1e-14);
  }
  const PlacedGroup flat = placed(group_of(Layout::ring, 4, {0, 0, 8, 2}));
  EXPECT_NEAR(flat.x[2], 0, 1e-14);
  EXPECT_NEAR(flat.y[1], 2, 1e-14);
}

TEST(ScenePlacement, RingWhoseBodiesOverlapNamesThem) {
  const std::string error = refusal(group_of(Layout::ring, 13, {0, 0, 4, 4}));
  EXPECT_NE(error.find("bodies 0 and 1 of the ring"), std::string::npos) << error;
  placed(group_of(Layout::ring, 12, {0, 0, 4, 4}));
  placed(group_of(Layout::ring, 1, {0, 0, 4, 4}));
}

TEST(ScenePlacement, CellThatJustFitsIsNoError) {
  // Side and cell are not representable: rounding must not refuse the last of the hundred columns.
  const PlacedGroup g = placed(group_of(Layout::lattice, 10000, {0.1, 0.1, 20.1, 20.1}, 0.1));
  EXPECT_EQ(std::count_if(g.y.begin(), g.y.end(), [](double y) { return y < 0.3; }), 100);
}

TEST(ScenePlacement, CellSmallerThanTheBodyNamesBothAndTheCure) {
  GroupDesc group = group_of(Layout::lattice, 100, {0, 0, 8, 8});
  const std::string error = refusal(group);
  EXPECT_NE(error.find("0.8 x 0.8 m"), std::string::npos) << error;
  EXPECT_NE(error.find("body of 1 m"), std::string::npos) << error;
  EXPECT_NE(error.find("region at least 10 x 10 m"), std::string::npos) << error;
  group.region = {0, 0, 10, 10};
  placed(group);
}

TEST(ScenePlacement, JitterNeverBringsBodiesIntoContact) {
  for (const Layout layout : {Layout::lattice, Layout::hex}) {
    GroupDesc group = group_of(layout, 900, {-20, -20, 20, 20});
    group.radius_min = 0.1;
    group.jitter = 1;
    const PlacedGroup g = placed(group);
    EXPECT_GT(smallest_gap(g), 0);
    EXPECT_TRUE(inside(g, group.region));
  }
}

TEST(ScenePlacement, JitterIsAFractionOfTheFreeGap) {
  GroupDesc group = group_of(Layout::lattice, 2500, {0, 0, 100, 100});
  const PlacedGroup still = placed(group);
  group.jitter = 0.25;
  const PlacedGroup moved = placed(group);
  double most = 0, sum = 0;
  for (std::size_t k = 0; k < still.x.size(); ++k) {
    most = std::max({most, std::fabs(moved.x[k] - still.x[k]), std::fabs(moved.y[k] - still.y[k])});
    sum += moved.x[k] - still.x[k];
  }
  EXPECT_LE(most, 0.125);  // the gap in a 2 m cell is 0.5 m on either side
  EXPECT_GT(most, 0.12);
  EXPECT_NEAR(sum / 2500, 0, 0.01);
}

TEST(ScenePlacement, RandomBodiesNeverTouch) {
  GroupDesc group = group_of(Layout::random, 2000, {0, 0, 60, 60});
  group.radius_min = 0.1;
  const PlacedGroup g = placed(group);
  ASSERT_EQ(g.x.size(), 2000u);
  EXPECT_GT(smallest_gap(g), 0);
  EXPECT_TRUE(inside(g, group.region));
}

TEST(ScenePlacement, RandomGroupThatDoesNotFitSaysHowManyDid) {
  const std::string error = refusal(group_of(Layout::random, 1000, {0, 0, 35, 35}));
  EXPECT_NE(error.find(" of 1000 bodies"), std::string::npos) << error;
  EXPECT_NE(error.find("region larger"), std::string::npos) << error;
  refusal(group_of(Layout::random, 1, {0, 0, 0.9, 5}));
}

TEST(ScenePlacement, RadiiAndSpeedsAreUniformWithinTheirRange) {
  GroupDesc group = group_of(Layout::lattice, 10000, {0, 0, 200, 200});
  group.radius_min = 0.2;
  group.radius_max = 0.6;
  group.velocity = {3, -1};
  group.velocity_spread = 2;
  const PlacedGroup g = placed(group);
  const auto looks_uniform = [](const std::vector<double>& v, double low, double high) {
    double sum = 0, square = 0;
    for (const double a : v) {
      EXPECT_GE(a, low);
      EXPECT_LE(a, high);
      sum += a;
      square += a * a;
    }
    const double n = static_cast<double>(v.size()), mean = sum / n, width = high - low;
    EXPECT_NEAR(mean, (low + high) / 2, 0.02 * width);
    EXPECT_NEAR(square / n - mean * mean, width * width / 12, 0.005 * width * width);
  };
  looks_uniform(g.radius, 0.2, 0.6);
  looks_uniform(g.vx, 1, 5);
  looks_uniform(g.vy, -3, 1);
}

TEST(ScenePlacement, SameSeedSamePlacesOtherSeedOthers) {
  GroupDesc group = group_of(Layout::random, 500, {0, 0, 60, 60});
  group.velocity_spread = 1;
  const PlacedGroup a = placed(group), b = placed(group);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.vy, b.vy);
  group.seed = 2;
  const PlacedGroup c = placed(group);
  EXPECT_NE(a.x, c.x);
  EXPECT_NE(a.vy, c.vy);
}

TEST(ScenePlacement, NumbersAreTheSameWithEveryCompiler) {
  GroupDesc group = group_of(Layout::lattice, 3, {0, 0, 30, 10});
  group.jitter = 0.5;
  group.velocity_spread = 1;
  const PlacedGroup g = placed(group);
  EXPECT_EQ(g.x[1], 0x1.dbef36bd3fbep+3);
  EXPECT_EQ(g.vy[2], -0x1.594a7d146feb8p-3);
}

TEST(ScenePlacement, ListsAreTakenAsTheyAre) {
  GroupDesc group;
  group.layout = Layout::explicit_list;
  group.x = {1, 2, 3};
  group.y = {4, 5, 6};
  group.radius = {0.25};
  group.vy = {7, 8, 9};
  const PlacedGroup g = placed(group);
  EXPECT_EQ(g.x, group.x);
  EXPECT_EQ(g.y, group.y);
  EXPECT_EQ(g.radius, (std::vector<double>{0.25, 0.25, 0.25}));
  EXPECT_EQ(g.vx, (std::vector<double>{0, 0, 0}));
  EXPECT_EQ(g.vy, group.vy);
  group.vy.pop_back();
  EXPECT_NE(refusal(group).find("vy has 2 entries"), std::string::npos);
}

TEST(ScenePlacement, NothingToPlaceIsNoError) {
  EXPECT_TRUE(placed(group_of(Layout::lattice, 0, {0, 0, 1, 1})).x.empty());
  EXPECT_EQ(placed(group_of(Layout::hex, 1, {0, 0, 1, 1})).x.size(), 1u);
}

TEST(ScenePlacement, ImpossibleNumbersAreRefused) {
  refusal(group_of(Layout::lattice, 4, {0, 0, 0, 5}));
  refusal(group_of(Layout::lattice, 4, {0, 0, 5, 5}, 0));
  refusal(group_of(Layout::lattice, 5'000'000'000, {0, 0, 1e6, 1e6}));
  GroupDesc group = group_of(Layout::lattice, 4, {0, 0, 5, 5});
  group.jitter = 1.5;
  refusal(group);
}

}  // namespace
}  // namespace psim::test
