// The tree of samples: every built-in scene is in it, with a line that helps.
#include "builtin/samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "psim/scene.h"

namespace psim {
namespace {

TEST(SceneSamples, EveryBuiltInSceneIsThereOnce) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    EXPECT_EQ(std::ranges::count(samples(), scene.name, &Sample::scene), 1)
        << scene.name << " belongs into src/scene/builtin/samples.cpp";
  }
  EXPECT_EQ(samples().size(), builtin_scenes().size());
}

// A line says what to look for: it is no copy of what the scene is.
TEST(SceneSamples, EachHasOneSentenceOfItsOwn) {
  std::set<std::string_view> lines;
  for (const BuiltinScene& scene : builtin_scenes()) {
    const std::string_view line = look_for(scene.name);
    EXPECT_GE(line.size(), 30u) << scene.name;
    EXPECT_LE(line.size(), 100u) << scene.name;
    EXPECT_TRUE(line.ends_with('.')) << scene.name;
    EXPECT_EQ(line.find('\n'), std::string_view::npos) << scene.name;
    EXPECT_NE(line, scene.description);
    EXPECT_TRUE(lines.insert(line).second) << scene.name;
  }
  EXPECT_EQ(look_for("no-such-scene"), "");
}

TEST(SceneSamples, TopicsAreFewAndTogether) {
  std::vector<std::string_view> topics;
  for (const Sample& sample : samples()) {
    if (topics.empty() || sample.topic != topics.back()) topics.push_back(sample.topic);
  }
  EXPECT_EQ(topics.front(), "Discs");
  EXPECT_LE(topics.size(), 12u);
  EXPECT_EQ(std::set(topics.begin(), topics.end()).size(), topics.size());  // no topic comes twice
}

}  // namespace
}  // namespace psim
