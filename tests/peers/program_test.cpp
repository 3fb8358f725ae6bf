// The peers program and its tables as a user meets them.
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "cli_runner.h"

namespace psim::test {
namespace {

const std::string kHeader =
    "engine,version,setting,recommended,threads,scene,bodies,frames,repeats,ms_mean,ms_p50,ms_p99,"
    "overlap_max_m,overlap_p99_m,passed_walls,energy_drift,rest_speed_m_s,sway_m,sink_m,joint_gap_"
    "m,note";

constexpr std::string_view kRod = R"({
  "psim": 1, "name": "rod", "world": {"bounds": [-10, -10, 10, 10], "boundary": "open"},
  "bodies": [
    {"name": "peg", "type": "static", "shape": {"disc": {"radius": 0.1}}, "position": [0, 0]},
    {"name": "bob", "type": "dynamic", "shape": {"disc": {"radius": 0.1}}, "position": [2, 0]}],
  "joints": [{"type": "distance", "a": "peg", "b": "bob"}]})";

Outcome run_peers(std::vector<std::string> arguments) { return Process(PSIM_PEERS, std::move(arguments)).wait(); }

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::string field;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.push_back(std::exchange(field, {}));
    else
      field += c;
  }
  fields.push_back(field);
  return fields;
}

TEST(Peers, WritesARowForEveryEngineAndSetting) {
  const ScratchFolder folder;
  const std::string file = folder.file("peers.csv");
  const auto result = run_peers({"--quick", "--scenes", "stack,gas", "--engines", "psim", "--csv", file});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto lines = lines_of(read_file(file));
  ASSERT_GE(lines.size(), 3u);
  EXPECT_EQ(lines[0], kHeader);
  std::set<std::string> scenes;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    ASSERT_EQ(fields.size(), 21u) << lines[k];
    EXPECT_EQ(fields[0], "psim");
    EXPECT_EQ(fields[3], "yes");
    scenes.insert(fields[5]);
    for (const std::size_t ms : {9u, 10u, 11u}) EXPECT_GT(std::stod(fields[ms]), 0) << lines[k];
    EXPECT_LE(std::stod(fields[10]), std::stod(fields[11]));
    EXPECT_EQ(fields[5] == "gas", !fields[15].empty()) << lines[k];
    EXPECT_EQ(fields[5] == "stack", !fields[17].empty()) << lines[k];
    if (fields[5] == "gas") {
      EXPECT_LT(std::abs(std::stod(fields[15])), 1e-4);
    }
    if (fields[5] == "stack") {
      EXPECT_LT(std::stod(fields[17]), 0.01);
    }
  }
  EXPECT_EQ(scenes, (std::set<std::string>{"stack", "gas"}));
  EXPECT_NE(result.out.find("sway, m"), std::string::npos);
}

TEST(Peers, RunsASceneFileAndSaysWhatIsNotSupported) {
  const ScratchFolder folder;
  const std::string scene = folder.write("rod.json", kRod), file = folder.file("peers.csv");
  const auto result = run_peers({"--quick", "--scenes", scene, "--csv", file});
  ASSERT_EQ(result.status, 0) << result.err;
  int told = 0;
  const auto lines = lines_of(read_file(file));
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    ASSERT_EQ(fields.size(), 21u) << lines[k];
    EXPECT_EQ(fields[5], "rod");
    if (fields[0] == "bullet") {
      ++told;
      EXPECT_EQ(fields[20], "not supported: rod");
      EXPECT_EQ(fields[9], "");
      EXPECT_EQ(fields[19], "");
    } else {
      EXPECT_EQ(fields[20], "");
      EXPECT_LT(std::stod(fields[19]), 0.1) << lines[k];
    }
  }
  const bool has_bullet = result.err.find("bullet not built in") == std::string::npos;
  EXPECT_EQ(told > 0, has_bullet);
  EXPECT_EQ(result.out.find("not supported: rod") != std::string::npos, has_bullet);
}

TEST(Peers, ListsAndRunsNothing) {
  const auto result = run_peers({"--list"});
  EXPECT_EQ(result.status, 0);
  for (const char* word : {"psim", "box2d", "box2d3", "chipmunk", "bullet", "ode", "4 substeps *", "falling-pile",
                           "settled-pile", "mixed-radii", "gas", "stack", "pyramid", "many-pyramids",
                           "sleeping-pyramids", "bridge", "joint-grid", "cloth", "tumbler"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word;
  }
}

void expect_refusal(std::vector<std::string> arguments, const std::vector<std::string>& words) {
  const auto result = run_peers(std::move(arguments));
  EXPECT_EQ(result.status, 2) << result.err;
  EXPECT_EQ(result.out, "");
  ASSERT_FALSE(result.err.empty());
  const auto lines = lines_of(result.err);
  EXPECT_TRUE(lines.back().starts_with("peers: ")) << result.err;
  for (const std::string& word : words) {
    EXPECT_NE(lines.back().find(word), std::string::npos) << word << " is not in: " << result.err;
  }
}

TEST(Peers, RefusesWhatItDoesNotKnow) {
  const ScratchFolder folder;
  expect_refusal({"--scenes", "nonesuch"}, {"nonesuch", "falling-pile", ".json"});
  expect_refusal({"--scenes", folder.file("absent.json")}, {"absent.json"});
  expect_refusal({"--scenes", folder.write("bad.json", "{\"psim\": 2}")}, {"bad.json:1:"});
  expect_refusal({"--engines", "psim,nonesuch"}, {"nonesuch", "chipmunk"});
  expect_refusal({"--repeats", "0"}, {"--repeats"});
  expect_refusal({"--quick", "--full"}, {"--quick", "--full"});
  expect_refusal({"--plot", "a.png"}, {"--plot", "--csv"});
  expect_refusal({"--quick", "--csv", folder.file("no/such.csv")}, {"--csv", "no/such.csv"});
  expect_refusal({"--nonesuch"}, {"--nonesuch"});
}

TEST(Peers, WritesOverNoScene) {
  const ScratchFolder folder;
  const std::string scene = folder.write("rod.json", kRod), link = folder.file("link.csv"), csv = folder.file("a.csv");
  std::filesystem::create_symlink("rod.json", link);
  const std::vector<std::string> run = {"--quick", "--engines", "psim", "--scenes", scene};
  const auto refused = [&](std::vector<std::string> more, const std::vector<std::string>& words) {
    more.insert(more.begin(), run.begin(), run.end());
    expect_refusal(more, words);
  };
  refused({"--csv", scene}, {"--csv " + scene, "--scenes"});
  refused({"--csv", link}, {"--csv " + link, "--scenes"});
  refused({"--csv", csv, "--plot", scene}, {"--plot " + scene, "--scenes"});
  refused({"--csv", csv, "--plot", csv}, {"--plot"});
  refused({"--csv", folder.file("a.png"), "--plot", folder.file("./a.png")}, {"--plot", "--csv"});
  refused({"--csv", csv, "--plot", folder.file("no/such.png")}, {"--plot", "No such file"});
  refused({"--csv", csv, "--plot", folder.file("a.txt")}, {"--plot", ".png or .svg"});
  EXPECT_EQ(read_file(scene), kRod);
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"link.csv", "rod.json"}));
}

TEST(Peers, ARunThatIsInterruptedLeavesTheOldFile) {
  const ScratchFolder folder;
  const std::string file = folder.write("peers.csv", "old");
  Process peers(PSIM_PEERS, {"--repeats", "99", "--engines", "psim", "--scenes", "stack,gas", "--csv", file});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  peers.signal(SIGINT);
  EXPECT_EQ(peers.wait().status, -SIGINT);
  EXPECT_EQ(read_file(file), "old");
  EXPECT_EQ(folder.names(), std::vector<std::string>{"peers.csv"});
}

TEST(PeersTables, AreMadeFromTheRows) {
  const ScratchFolder folder;
  const std::string rows = kHeader +
                           "\npsim,1,4 substeps,yes,1,stack,20,60,3,0.5,0.4,0.9,0.001,0.0005,,,1e-05,0.002,0.003,,\n"
                           "box2d,2,8 + 3 iterations,yes,1,stack,20,60,3,0.25,0.2,0.3,0.002,0.001,,,0.1,0.05,0.06,,\n"
                           "box2d,2,8 + 3 iterations x 4 steps,no,1,stack,20,60,3,2,2,2,0,0,,,0,0.001,0.001,,\n"
                           "bullet,3,10 iterations,yes,1,stack,20,0,0,,,,,,,,,,,,not supported: rod\n";
  const auto result = Process(PSIM_SOURCE_DIR "/tools/plot-peers", {folder.write("peers.csv", rows), "--table"}).wait();
  ASSERT_EQ(result.status, 0) << result.err;
  for (const char* line : {"| stack | 20 | 0.500 (0.900) | 0.250 (0.300) | not supported: rod |",
                           "| stack | sway, mm | **2.0** | 50 | – |",
                           "| stack | sway, mm 2.0 | 0.500 | 2.00 (8 + 3 iterations x 4 steps) | – |"}) {
    EXPECT_NE(result.out.find(line), std::string::npos) << line << "\n" << result.out;
  }
  const auto bad = Process(PSIM_SOURCE_DIR "/tools/plot-peers", {folder.file("absent.csv"), "--table"}).wait();
  EXPECT_NE(bad.status, 0);
  EXPECT_EQ(lines_of(bad.err).size(), 1u) << bad.err;
}

}  // namespace
}  // namespace psim::test
