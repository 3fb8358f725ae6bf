// emitters[] and drains[] of scene files: what they make, how they are written again, and what is wrong with some.
#include <psim/scene.h>

#include "support.h"

namespace psim::test {
namespace {

std::string tap_scene(const std::string& rest) {
  return R"({"psim": 1, "world": {"bounds": [0, 0, 4, 4]}, )" + rest + "}";
}

std::string tap_refusal(const std::string& rest) {
  std::string error;
  EXPECT_FALSE(parse_scene(tap_scene(rest), "f", error)) << rest;
  EXPECT_EQ(error.find('\n'), error.npos) << error;
  return error;
}

constexpr const char* kTap = R"("fluids": [{"spacing": 0.1}, {"spacing": 0.05, "region": [0, 0, 1, 1]}],
    "emitters": [{"segment": [[1, 2], [2, 2]], "speed": 1.5},
                 {"segment": [[3, 3], [3, 2.5]], "speed": -2, "fluid": 1, "start": 0.5, "end": 2, "limit": 40}],
    "drains": [{"region": [0, 0, 4, 0.2]}])";

TEST(SceneTaps, AFluidThatATapFeedsMayBeginEmpty) {
  std::string error;
  const auto scene = parse_scene(tap_scene(kTap), "f", error);
  ASSERT_TRUE(scene) << error;
  ASSERT_EQ(scene->emitters.size(), 2u);
  EXPECT_EQ(scene->emitters[0].fluid, 0u);
  EXPECT_EQ(scene->emitters[1].limit, 40u);
  EXPECT_EQ(scene->emitters[1].end, 2);
  ASSERT_EQ(scene->drains.size(), 1u);
  const auto world = build_world(*scene, {}, error);
  ASSERT_NE(world, nullptr) << error;
  EXPECT_EQ(world->fluid_report().particles, 400u);
  for (int k = 0; k < 60; ++k) world->step();
  EXPECT_GE(world->fluid_report().emitted, 150u);  // 1.5 m^2 of the first, and 40 of the second
  EXPECT_GT(world->fluid_report().drained, 40u);
}

TEST(SceneTaps, AreWrittenAgain) {
  std::string error;
  const auto scene = parse_scene(tap_scene(kTap), "f", error);
  ASSERT_TRUE(scene) << error;
  const std::string text = scene_to_json(*scene);
  const auto again = parse_scene(text, "f", error);
  ASSERT_TRUE(again) << error << text;
  EXPECT_EQ(scene_to_json(*again), text);
  const auto world = build_world(*scene, {}, error), other = build_world(*again, {}, error);
  for (int k = 0; k < 40; ++k) world->step(), other->step();
  EXPECT_EQ(world->state_hash(), other->state_hash());
}

TEST(SceneTaps, SayWhatIsWrong) {
  const std::string water = R"("fluids": [{"spacing": 0.1, "region": [0, 0, 1, 1]}], )";
  const auto tap = [&](const std::string& of) { return tap_refusal(water + "\"emitters\": [" + of + "]"); };
  const std::pair<std::string, const char*> wrong[] = {
      {tap(R"({"speed": 1})"), "emitters[0]: the key \"segment\" is missing"},
      {tap(R"({"segment": [[0, 0], [1, 0]]})"), "emitters[0]: the key \"speed\" is missing"},
      {tap(R"({"segment": [[0, 0], [0, 0]], "speed": 1})"), "emitters[0].segment: its two points are the same"},
      {tap(R"({"segment": [[0, 0], [5, 0]], "speed": 1})"), "emitters[0].segment[1]: "},
      {tap(R"({"segment": [[0, 0]], "speed": 1})"), "emitters[0].segment: has 1 element"},
      {tap(R"({"segment": [[0, 0], [1, 0]], "speed": 1, "fluid": 1})"), "emitters[0].fluid: "},
      {tap(R"({"segment": [[0, 0], [1, 0]], "speed": 1, "start": 2, "end": 1})"), "emitters[0].end: "},
      {tap(R"({"segment": [[0, 0], [1, 0]], "speed": 1, "limit": -1})"), "emitters[0].limit: "},
      {tap(R"({"segment": [[0, 0], [1, 0]], "speed": 1, "flow": 1})"), "emitters[0].flow: unknown key"},
      {tap_refusal(R"("emitters": [{"segment": [[0, 0], [1, 0]], "speed": 1}])"), "emitters[0]: lets out a fluid"},
      {tap_refusal(R"("fluids": [{"spacing": 0.1}])"), "fluids[0]: one of the keys"},
      {tap_refusal(R"("fluids": [{"spacing": 0.1}, {"spacing": 0.1}],
                      "emitters": [{"segment": [[0, 0], [1, 0]], "speed": 1}])"),
       "fluids[1]: one of the keys"},
      {tap_refusal(R"("drains": [{}])"), "drains[0]: the key \"region\" is missing"},
      {tap_refusal(R"("drains": [{"region": [0, 0, 0, 1]}])"), "drains[0].region"},
      {tap_refusal(R"("drains": 3)"), "drains: "},
  };
  for (const auto& [error, expected] : wrong) EXPECT_NE(error.find(expected), error.npos) << error;
}

}  // namespace
}  // namespace psim::test
