// What a run prints: the text report, the JSON report, the verdict of --verify, and Ctrl-C.
#include <nlohmann/json.hpp>
#include <regex>

#include "cli_runner.h"

namespace psim::test {
namespace {

using Json = nlohmann::json;

Json json_report(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--report", "json"});
  const Outcome outcome = run_psim(std::move(arguments));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return Json::parse(outcome.out, nullptr, false);
}

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> names;
  for (const auto& item : object.items()) names.push_back(item.key());
  std::sort(names.begin(), names.end());
  return names;
}

TEST(CliReport, TextHasItsLines) {
  const Outcome outcome = run_psim({"--particles", "1200", "--frames", "3", "--threads", "1"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  const std::string ms = "\\s+\\d+\\.\\d+", share = "\\s+\\d+\\.\\d %";
  const std::vector<std::string> patterns = {
      "psim \\S+  scene discs  1,200 bodies  \\w+ \\(\\d lanes\\)  1 threads  dt 16\\.67 ms x 4 "
      "substeps",
      "Phase                    mean ms    p99 ms   budget",
      "Broad-phase" + ms + ms + share,
      "Narrow-phase" + ms + ms + share,
      "Constraint resolution" + ms + ms + share,
      "Integration" + ms + ms + share,
      "Rendering sync" + ms + ms + share,
      "Total physics" + ms + ms + share,
      "Frames 3, over budget \\d+, p50 \\S+ p95 \\S+ p99 \\S+ max \\S+ ms, \\d+ fps",
      "Pairs [\\d,]+  contacts [\\d,]+  hit ratio \\S+ %  colours \\S+  neighbour lists rebuilt "
      "\\d+ of 3 frames",
      "SIMD: [\\d,]+ lane operations, [\\d,]+ scalar fallbacks \\(\\S+ %\\)",
      "Energy \\S+ -> \\S+ J  momentum \\(\\S+, \\S+\\)  max penetration \\S+ m",
      "Skipped: .+",
      "Ledger: asleep 0 of 1,200 bodies \\(mean\\), lists kept in \\d of 3 frames, pairs reused \\S+ %, "
      "nobody fast in 3, 0 substeps saved",
      "State 0x[0-9a-f]{16}",
  };
  const std::vector<std::string> lines = lines_of(outcome.out);
  ASSERT_EQ(lines.size(), patterns.size()) << outcome.out;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_TRUE(std::regex_match(lines[i], std::regex(patterns[i]))) << lines[i];
  }
}

// Two points of a box make one pair. Only a part of the budget may be more than all of it.
TEST(CliReport, NoShareIsMoreThanTheWhole) {
  for (const char* scene : {"vertical_stack", "pyramid", "rain", "hourglass", "newtons_cradle", "spinner", "cloth"}) {
    const Outcome outcome = run_psim({"--scene", scene, "--particles", "600", "--frames", "40", "--profile"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    int shares = 0;
    const std::regex share("(\\d+\\.\\d+) %");
    for (const std::string& line : lines_of(outcome.out)) {
      const bool of_budget = std::regex_match(line, std::regex("[A-Z][a-z -]+( +\\d+\\.\\d+){3} %"));
      for (std::sregex_iterator at(line.begin(), line.end(), share), end; !of_budget && at != end; ++at, ++shares) {
        EXPECT_LE(std::stod((*at)[1]), 100) << scene << ": " << line;
      }
    }
    EXPECT_GT(shares, 10) << scene << "\n" << outcome.out;
  }
}

TEST(CliReport, ProfileNamesTheBottleneckAndTheThreads) {
  const Outcome outcome = run_psim({"--particles", "3000", "--frames", "20", "--threads", "2", "--profile"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(std::regex_search(
      outcome.out, std::regex("Bottleneck: \\w+, \\S+ % of the time; threads busy \\S+ %, the busiest \\S+ x")))
      << outcome.out;
  const Json profile = json_report({"--particles", "3000", "--frames", "20", "--threads", "2", "--profile"})["profile"];
  double shares = 0, longest = 0;
  std::string bottleneck;
  for (const auto& [stage, row] : profile["stages"].items()) {
    shares += row["share"].get<double>();
    EXPECT_GT(row["threads_busy"], 0) << stage;
    EXPECT_LE(row["threads_busy"], 1) << stage;
    if (row["mean"].get<double>() > longest) {
      longest = row["mean"];
      bottleneck = stage;
    }
  }
  EXPECT_NEAR(shares, 1, 1e-9);
  EXPECT_EQ(profile["bottleneck"], bottleneck);
  EXPECT_GE(profile["imbalance"], 1);
}

// Of a long run an eighth of the frames has spans: what threads did is told of those alone.
TEST(CliReport, ProfileOfALongRunIsThatOfTheFramesLookedAt) {
  const Json profile = json_report({"--scene", "pile", "--particles", "400", "--frames", "600", "--sleep", "off",
                                    "--threads", "2", "--profile"})["profile"];
  EXPECT_GT(profile["threads_busy"], 0.15);  // over all frames it were 1 / 8 at most
  EXPECT_LE(profile["threads_busy"], 1);
  EXPECT_GT(profile["stages"]["solver"]["threads_busy"], 0.15);
}

TEST(CliReport, ProfileHasRecentTimesAndTheUseOfLanes) {
  const std::vector<std::string> words = {"--scene", "pile",      "--particles", "3000",     "--frames",
                                          "20",      "--threads", "1",           "--profile"};
  const Json profile = json_report(words)["profile"];
  EXPECT_EQ(profile["recent_frames"], 240);
  for (const auto& [stage, row] : profile["stages"].items()) {  // fewer frames than are recent
    EXPECT_NEAR(row["recent_mean"], row["mean"].get<double>(), 1e-9) << stage;
    EXPECT_EQ(row["recent_p99"], row["p99"]) << stage;
  }
  if (json_report(words)["lanes"] == 1) GTEST_SKIP() << "no lanes";
  for (const char* kernels : {"bodies", "substeps", "contacts"}) {
    ASSERT_TRUE(profile["lanes"].contains(kernels)) << kernels;
    const Json use = profile["lanes"][kernels];
    EXPECT_GT(use["used"], 0) << kernels;
    EXPECT_LE(use["used"], use["lanes"]) << kernels;
  }
  EXPECT_FALSE(profile["lanes"].contains("joints"));
  EXPECT_TRUE(std::regex_search(run_psim(words).out, std::regex("Lanes used: bodies \\S+ %, .*contacts \\S+ %")));
}

TEST(CliReport, JsonHasItsKeys) {
  const Json report = json_report({"--particles", "500", "--frames", "4", "--seed", "7"});
  EXPECT_EQ(keys(report), (std::vector<std::string>{"bodies",       "budget_ms",
                                                    "compiler",     "counts",
                                                    "dt",           "energy",
                                                    "escaped",      "frame_ms",
                                                    "frames",       "frames_over_budget",
                                                    "isa",          "lanes",
                                                    "ledger",       "max_penetration",
                                                    "memory_bytes", "momentum",
                                                    "phase_ms",     "scene",
                                                    "seed",         "simd",
                                                    "skipped",      "state_hash",
                                                    "substeps",     "threads",
                                                    "version",      "virial"}));
  EXPECT_EQ(keys(report["bodies"]), (std::vector<std::string>{"asleep", "awake", "dynamic", "static", "total"}));
  EXPECT_EQ(keys(report["ledger"]),
            (std::vector<std::string>{"asleep_mean", "bodies_renewed", "fast_frames", "fast_mean", "lists_kept_frames",
                                      "lists_renewed_frames", "pairs_reused_mean", "stages", "substeps_saved"}));
  for (const auto& [stage, frames] : report["ledger"]["stages"].items()) {
    EXPECT_EQ(frames["run"].get<int>() + frames["skipped"].get<int>(), 4) << stage;
  }
  EXPECT_EQ(report["ledger"]["stages"]["joints"]["skipped"], 4);
  EXPECT_EQ(report["ledger"]["stages"]["solver.restitution"]["run"], 4);
  EXPECT_EQ(keys(report["frame_ms"]), (std::vector<std::string>{"max", "mean", "p50", "p95", "p99"}));
  EXPECT_EQ(keys(report["phase_ms"]),
            (std::vector<std::string>{"broad_phase", "constraints", "integration", "narrow_phase", "publish"}));
  for (const Json& phase : report["phase_ms"]) {
    EXPECT_EQ(keys(phase), (std::vector<std::string>{"max", "mean", "p99"}));
  }
  EXPECT_EQ(keys(report["counts"]), (std::vector<std::string>{"colours", "contacts", "neighbour_rebuilds", "pairs"}));
  EXPECT_EQ(keys(report["simd"]), (std::vector<std::string>{"lanes_scalar", "lanes_vector"}));
  EXPECT_EQ(keys(report["energy"]),
            (std::vector<std::string>{"kinetic", "kinetic_start", "potential", "potential_start"}));
  EXPECT_EQ(keys(report["momentum"]), (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(report["frames"], 4);
  EXPECT_EQ(report["seed"], 7);
  EXPECT_EQ(report["budget_ms"], 16.67);
  EXPECT_EQ(report["bodies"]["total"], 500);
  EXPECT_LE(report["frame_ms"]["p50"], report["frame_ms"]["max"]);
}

TEST(CliReport, OptionsOverrideTheScene) {
  const ScratchFolder folder;
  const std::string scene = folder.write("small.json", kSmallScene);
  const Json report = json_report({"--scene", scene, "--frames", "2", "--dt", "0.01", "--substeps", "3", "--threads",
                                   "2", "--isa", "scalar", "--budget", "1e-6"});
  EXPECT_EQ(report["scene"], "small");
  EXPECT_EQ(report["dt"], 0.01);
  EXPECT_EQ(report["substeps"], 3);
  EXPECT_EQ(report["threads"], 2);
  EXPECT_EQ(report["isa"], "scalar");
  EXPECT_EQ(report["lanes"], 1);
  EXPECT_EQ(report["frames_over_budget"], 2);
  EXPECT_EQ(report["bodies"]["static"], 1);
}

TEST(CliReport, ASeedGivesTheSameRunAgainAndAnotherSeedAnotherRun) {
  const auto hash = [](const char* seed) {
    return json_report({"--particles", "300", "--frames", "3", "--seed", seed})["state_hash"];
  };
  EXPECT_EQ(hash("5"), hash("5"));
  EXPECT_NE(hash("5"), hash("6"));
}

TEST(CliReport, NoBodiesAndNoFramesAreAValidRun) {
  const ScratchFolder folder;
  const std::string scene = folder.write(
      "empty.json", R"({"psim": 1, "name": "empty", "world": {"bounds": [0, 0, 1, 1], "boundary": "walls"}})");
  const Json report = json_report(
      {"--scene", scene, "--frames", "5", "--state", folder.file("s.csv"), "--image", folder.file("i.png")});
  EXPECT_EQ(report["bodies"]["total"], 0);
  EXPECT_EQ(report["frames"], 5);
  EXPECT_EQ(read_file(folder.file("s.csv")), "id,x,y,angle,vx,vy,omega\n");
  EXPECT_EQ(json_report({"--particles", "20", "--frames", "0"})["frames"], 0);
  EXPECT_EQ(run_psim({"--particles", "20", "--frames", "0"}).status, 0);
}

TEST(CliReport, VerifyFindsTheSameBitsEverywhere) {
  const Outcome outcome = run_psim({"--verify", "--particles", "300", "--frames", "5"});
  EXPECT_EQ(outcome.status, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("the same bits"), std::string::npos) << outcome.out;
}

TEST(CliReport, BenchmarkPrintsThreeTables) {
  const ScratchFolder folder;
  const std::string scene = folder.write("small.json", kSmallScene);
  const Outcome outcome = run_psim({"--benchmark", "--scene", scene, "--frames", "3"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const char* word : {"By particle count", "By threads", "efficiency", "By instruction set", "whole frame"}) {
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
  }
}

TEST(CliReport, CtrlCEndsTheRunAndStillReports) {
  const ScratchFolder folder;
  Process psim(PSIM_PROGRAM,
               {"--particles", "100", "--frames", "1000000000", "--report", "json", "--state", folder.file("s.csv")});
  ASSERT_TRUE(psim.waits_for(SIGINT));
  psim.signal(SIGINT);
  const Outcome outcome = psim.wait();
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("interrupted"), std::string::npos) << outcome.err;
  const Json report = Json::parse(outcome.out, nullptr, false);
  ASSERT_FALSE(report.is_discarded()) << outcome.out;
  EXPECT_LT(report["frames"], 1000000000);
  EXPECT_EQ(lines_of(read_file(folder.file("s.csv"))).size(), 101u);
}

}  // namespace
}  // namespace psim::test
