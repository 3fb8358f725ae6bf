// The files that psim writes: their form, and that there is never half a file.
#include <nlohmann/json.hpp>

#include <charconv>
#include <map>

#include "cli_runner.h"

namespace psim::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

std::vector<double> numbers_of(const std::string& line) {
  std::vector<double> numbers;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    double value = 0;
    const char* const end = field.data() + field.size();
    const auto [stopped, error] = std::from_chars(field.data(), end, value);
    EXPECT_TRUE(error == std::errc() && stopped == end) << field;
    char again[40];
    const auto written = std::to_chars(again, again + sizeof again, value).ptr;
    EXPECT_EQ(field, std::string(again, written)) << "not the shortest form";
    numbers.push_back(value);
  }
  return numbers;
}

class CliFiles : public ::testing::Test {
 protected:
  Outcome run(std::vector<std::string> more) {
    std::vector<std::string> arguments = {"--scene", scene_, "--frames", "7"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_psim(std::move(arguments));
  }
  ScratchFolder folder_;
  std::string scene_ = folder_.write("small.json", kSmallScene);
};

TEST_F(CliFiles, StateHasARowPerBodyById) {
  ASSERT_EQ(run({"--state", folder_.file("s.csv")}).status, 0);
  const auto lines = lines_of(read_file(folder_.file("s.csv")));
  ASSERT_EQ(lines.size(), 5u);
  EXPECT_EQ(lines[0], "id,x,y,angle,vx,vy,omega");
  for (std::size_t id = 0; id < 4; ++id) {
    const std::vector<double> row = numbers_of(lines[id + 1]);
    ASSERT_EQ(row.size(), 7u);
    EXPECT_EQ(row[0], static_cast<double>(id));
  }
  EXPECT_NEAR(numbers_of(lines[4])[1], -2 + 7 / 60.0, 1e-5);
}

TEST_F(CliFiles, MetricsHaveARowPerFrame) {
  ASSERT_EQ(run({"--metrics", folder_.file("m.csv")}).status, 0);
  const auto lines = lines_of(read_file(folder_.file("m.csv")));
  ASSERT_EQ(lines.size(), 8u);
  EXPECT_EQ(lines[0],
            "frame,total_ms,broad_phase_ms,narrow_phase_ms,constraints_ms,integration_ms,"
            "publish_ms,pairs,contacts,awake,kinetic,potential,max_penetration,"
            "asleep,pairs_reused,rebuilt,substeps,waited,predicted_ms,substeps_saved,fast,stopped,"
            "skipped_forces,skipped_broad_phase,skipped_narrow_phase,skipped_colouring,skipped_solver,"
            "skipped_solver_restitution,skipped_solver_masses,skipped_solver_friction,skipped_rotation,"
            "skipped_publish,skipped_solver_heavy_loads,skipped_events,skipped_manifolds,skipped_joints,"
            "skipped_filters,skipped_continuous,skipped_fluid,most_sweeps,renewed,page_faults");
  for (std::size_t frame = 1; frame <= 7; ++frame) {
    const std::vector<double> row = numbers_of(lines[frame]);
    ASSERT_EQ(row.size(), 42u);
    EXPECT_EQ(row[35], 1) << "joints";
    EXPECT_EQ(row[0], static_cast<double>(frame));
    EXPECT_GT(row[1], 0);
  }
}

TEST_F(CliFiles, TrajectoryHasTheStartAndEveryKthFrame) {
  ASSERT_EQ(run({"--trajectory", folder_.file("t.csv"), "--every", "3"}).status, 0);
  const auto lines = lines_of(read_file(folder_.file("t.csv")));
  ASSERT_EQ(lines.size(), 1 + 3 * 4u);
  EXPECT_EQ(lines[0], "frame,id,x,y,angle,vx,vy,omega");
  for (std::size_t i = 0; i < 12; ++i) {
    const std::vector<double> row = numbers_of(lines[i + 1]);
    ASSERT_EQ(row.size(), 8u);
    EXPECT_EQ(row[0], static_cast<double>(i / 4 * 3));
    EXPECT_EQ(row[1], static_cast<double>(i % 4));
  }
}

TEST_F(CliFiles, ImageIsAPng) {
  ASSERT_EQ(run({"--image", folder_.file("i.png")}).status, 0);
  const std::string png = read_file(folder_.file("i.png"));
  ASSERT_GT(png.size(), 1000u);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png.substr(12, 4), "IHDR");
  EXPECT_EQ(png.substr(png.size() - 8, 4), "IEND");
  const auto side = [&png](std::size_t at) {
    unsigned value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(png[at + i]);
    return value;
  };
  EXPECT_EQ(std::max(side(16), side(20)), 1600u);
}

TEST_F(CliFiles, TraceHasNamedThreadsAndEveryFrame) {
  ASSERT_EQ(run({"--trace", folder_.file("t.json"), "--threads", "2"}).status, 0);
  const Json trace = Json::parse(read_file(folder_.file("t.json")), nullptr, false);
  ASSERT_FALSE(trace.is_discarded());
  std::map<int, std::string> tracks;
  std::map<std::string, int> spans;
  for (const Json& event : trace["traceEvents"]) {
    if (event["name"] == "thread_name") tracks[event["tid"]] = event["args"]["name"];
    if (event["ph"] != "X") continue;
    ++spans[event["name"]];
    EXPECT_TRUE(tracks.contains(event["tid"])) << event;
    EXPECT_GE(event["dur"], 0) << event;
  }
  EXPECT_EQ(tracks[0], "main");
  EXPECT_EQ(tracks[1], "worker 1");
  for (int frame = 1; frame <= 7; ++frame) EXPECT_EQ(spans["frame " + std::to_string(frame)], 1);
  EXPECT_GE(spans["integrate"], 7);
}

TEST_F(CliFiles, WhatCannotBeWrittenIsRefusedBeforeTheRun) {
  for (const char* option : {"--state", "--metrics", "--trajectory", "--image", "--trace"}) {
    SCOPED_TRACE(option);
    expect_refused(run({option, folder_.file("none/x.png")}), {option, "none/x.png", "No such file"});
    expect_refused(run({option, folder_.file("")}), {option, "directory"});
    expect_refused(run({option, folder_.file(std::string(300, 'x') + ".png")}), {option, "too long"});
  }
  EXPECT_EQ(folder_.names(), Words{"small.json"});
}

TEST_F(CliFiles, ARefusedRunLeavesOldFilesAsTheyWere) {
  const std::string old = folder_.write("s.csv", "old");
  expect_refused(run({"--state", old, "--metrics", folder_.file("none/m.csv")}), {"--metrics"});
  EXPECT_EQ(read_file(old), "old");
  EXPECT_EQ(folder_.names(), (Words{"s.csv", "small.json"}));
}

TEST_F(CliFiles, TwoOptionsCannotShareAFile) {
  expect_refused(run({"--state", folder_.file("a"), "--metrics", folder_.file("./a")}), {"--metrics", "--state"});
  expect_refused(run({"--state", scene_}), {"--state", "--scene"});
  EXPECT_EQ(read_file(scene_), kSmallScene);
  // By links, too, also while the file is not there yet.
  std::filesystem::create_symlink("new.csv", folder_.file("link.csv"));
  std::filesystem::create_symlink("link.csv", folder_.file("link to it.csv"));
  for (const std::string other : {"link.csv", "link to it.csv"}) {
    expect_refused(run({"--state", folder_.file("new.csv"), "--trajectory", folder_.file(other)}),
                   {"--trajectory", other, "--state"});
    expect_refused(run({"--state", folder_.file(other), "--metrics", folder_.file("new.csv")}),
                   {"--metrics", "new.csv", "--state"});
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.file("new.csv")));
}

TEST_F(CliFiles, AnOldFileIsReplacedAndALinkFollowed) {
  const std::string old = folder_.write("real.csv", "old");
  std::filesystem::create_symlink(old, folder_.file("link.csv"));
  ASSERT_EQ(run({"--state", folder_.file("link.csv")}).status, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(folder_.file("link.csv")));
  EXPECT_EQ(lines_of(read_file(old)).size(), 5u);
}

TEST_F(CliFiles, DevicesAreWrittenStraight) {
  ASSERT_EQ(run({"--state", "/dev/null"}).status, 0);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  const Outcome full = run({"--state", "/dev/full"});
  EXPECT_EQ(full.status, 2);
  EXPECT_NE(full.err.find("No space left"), std::string::npos) << full.err;
}

TEST_F(CliFiles, AKilledRunLeavesTheOldFileAsItWas) {
  const std::string old = folder_.write("m.csv", "old");
  Process psim(PSIM_PROGRAM, {"--scene", scene_, "--frames", "1000000000", "--metrics", old});
  ASSERT_TRUE(psim.waits_for(SIGINT));
  psim.signal(SIGKILL);
  EXPECT_EQ(psim.wait().status, -SIGKILL);
  EXPECT_EQ(read_file(old), "old");
}

}  // namespace
}  // namespace psim::test
