// Files that are broken: each is still a scene, or is refused in one line that says where. Never a
// crash, never a hang, never memory without end.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "cli_runner.h"
#include "inputs.h"
#include "psim/scene.h"
#include "scene_damage.h"
#include "support.h"

namespace psim::test {
namespace {

struct Whole {
  std::string name, text;
};

// The files of scenes/ and the built-in scenes, small.
std::vector<Whole> whole_scenes() {
  std::vector<Whole> scenes;
  for (const auto& file : std::filesystem::directory_iterator(PSIM_SOURCE_DIR "/scenes")) {
    scenes.push_back({file.path().filename().string(), read_file(file.path())});
  }
  for (const BuiltinScene& builtin : builtin_scenes()) {
    std::string error;
    const auto scene = make_builtin(builtin.name, builtin.sized ? 60 : 0, 1, error);
    if (scene) scenes.push_back({std::string(builtin.name), scene_to_json(*scene)});
  }
  std::erase_if(scenes, [](const Whole& scene) { return scene.text.size() > 100'000; });
  std::ranges::sort(scenes, {}, [](const Whole& scene) { return std::pair(scene.name, scene.text.size()); });
  return scenes;
}

std::size_t peak_mib() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) / 1024;
}

// 2,000 in all, in shards that each take about a second.
class Malformed : public testing::TestWithParam<std::uint64_t> {};
constexpr std::uint64_t kShards = 8, kAll = 2000;

TEST_P(Malformed, SceneIsStillOneOrIsRefusedInOneLine) {
  const std::vector<Whole> scenes = whole_scenes();
  ASSERT_GT(scenes.size(), 40u);
  const std::size_t before = peak_mib();
  std::size_t accepted = 0, refused = 0;
  std::chrono::duration<double> longest{};
  for (std::uint64_t seed = GetParam(); seed < kAll; seed += kShards) {
    const Whole& whole = scenes[seed % scenes.size()];
    const Damage damage = damaged(whole.text, seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << whole.name << ": " << damage.what);
    std::string error;
    const auto begin = std::chrono::steady_clock::now();
    const auto scene = parse_scene(damage.text, "f.json", error);
    longest = std::max(longest, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin));
    if (scene) {
      ++accepted;
      EXPECT_EQ(error, "");
      if (scene->body_count() > 500 || scene->joints.size() > 500) continue;
      check_scene(*scene);
      const auto world = build_world(*scene, {}, error);
      EXPECT_EQ(error.find('\n'), std::string::npos) << error;
      EXPECT_EQ(world == nullptr, !error.empty());
      if (world) world->step();
    } else {
      ++refused;
      EXPECT_EQ(fuzz::refusal_fault(error, "f.json"), "");
      EXPECT_LT(error.size(), 600u) << error.substr(0, 600);
    }
  }
  EXPECT_GT(refused, 100u);
  EXPECT_GT(accepted, 10u);
  EXPECT_LT(longest.count(), kSanitized ? 60.0 : 10.0);  // a hang, not a speed
  if (!kSanitized) {
    EXPECT_LT(peak_mib() - before, 600u);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Malformed, testing::Range<std::uint64_t>(0, kShards));

TEST(MalformedFile, TheProgramSaysItInOneLine) {
  const std::vector<Whole> scenes = whole_scenes();
  const ScratchFolder folder;
  int refused = 0;
  for (std::uint64_t seed = 5000; seed < 5012; ++seed) {
    const Damage damage = damaged(scenes[seed % scenes.size()].text, seed);
    const std::string file = folder.write("broken.json", damage.text);
    std::string error;
    if (parse_scene(damage.text, file, error)) continue;
    SCOPED_TRACE(testing::Message() << "seed " << seed << ": " << damage.what);
    const Outcome outcome = run_psim({"--scene", file, "--frames", "1"});
    expect_refused(outcome, {});
    EXPECT_EQ(outcome.err, "psim: " + error + "\n");
    ++refused;
  }
  EXPECT_GE(refused, 5);
}

}  // namespace
}  // namespace psim::test
