// What a scene will take, told before it is built, beside what its world takes.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "psim/scene.h"
#include "psim/world.h"

namespace psim::test {
namespace {

// The forecast of a scene over what its world takes after a step.
double share_of(const Scene& scene) {
  std::string error;
  const auto world = build_world(scene, {.threads = 1}, error);
  if (world == nullptr) throw std::runtime_error(error);
  world->step();
  return static_cast<double>(forecast(scene).bytes) / static_cast<double>(world->memory_bytes());
}

class Forecast : public ::testing::TestWithParam<const char*> {};

TEST_P(Forecast, OfABuiltInSceneIsRightWithinAFactorOfTwoAndAHalf) {
  std::string error;
  const auto scene = make_builtin(GetParam(), 20000, 1, error);
  ASSERT_TRUE(scene) << error;
  const double share = share_of(*scene);
  EXPECT_GT(share, 0.4);
  EXPECT_LT(share, 2.5);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Forecast,
                         ::testing::Values("discs", "pile", "rough-pile", "mixed-sizes", "gas-periodic", "hourglass",
                                           "boxes_into_discs", "smash", "orbits", "cloth", "joint_grid", "rain",
                                           "large_pyramid"),
                         [](const auto& of) {
                           std::string name = of.param;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

// n discs of one radius, each so far from the one before, on a line.
Scene line(std::size_t n, double apart) {
  Scene scene;
  scene.world.bounds = {-1e5, -1e5, 1e5, 1e5};
  GroupDesc group;
  group.layout = Layout::explicit_list;
  group.count = n;
  group.radius.assign(1, 0.5);
  for (std::size_t k = 0; k < n; ++k) {
    group.x.push_back(apart * static_cast<double>(k));
    group.y.push_back(0);
  }
  scene.groups.push_back(group);
  return scene;
}

TEST(ForecastOfHeaps, FollowsThePairs) {
  for (const double apart : {1.0, 0.1, 0.01, 0.001}) {
    const double share = share_of(line(3000, apart));
    EXPECT_GT(share, 0.4) << apart;
    EXPECT_LT(share, 2.5) << apart;
  }
}

TEST(ForecastOfHeaps, TellsWhatListsDoNotHold) {
  EXPECT_GT(forecast(line(60000, 0)).pairs, SceneForecast::kMostPairs);
  EXPECT_LT(forecast(line(60000, 1)).pairs, 1'000'000u);
}

}  // namespace
}  // namespace psim::test
