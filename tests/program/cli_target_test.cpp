// psim --target-error and --target-ms: what they choose, what they say, what they refuse.
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli_runner.h"

namespace psim::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

Json report_of(Words words) {
  words.insert(words.end(), {"--report", "json"});
  const Outcome outcome = run_psim(words);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return outcome.status == 0 ? Json::parse(outcome.out) : Json();
}

// One frame, so that only the choice counts.
Json choice(Words words) {
  words.insert(words.end(), {"--frames", "1"});
  const Json report = report_of(std::move(words));
  EXPECT_EQ(report["substeps"], report["target"]["chosen"]["substeps"]);
  return report["target"];
}

// A disc on an ellipse of eccentricity 0.2 about a well.
constexpr std::string_view kOrbit = R"({
  "psim": 1, "name": "orbit",
  "world": {"bounds": [-100, -100, 100, 100], "boundary": "open", "gravity": [0, 0]},
  "bodies": [{"type": "dynamic", "shape": {"disc": {"radius": 0.01}}, "position": [8, 0],
              "velocity": [0, 8.660254]}],
  "fields": [{"type": "well", "position": [0, 0], "strength": 500}]})";

TEST(Target, TheKindFollowsFromTheScene) {
  const std::vector<std::pair<const char*, const char*>> kinds = {{"orbits", "fields"},
                                                                  {"gas-periodic", "gas"},
                                                                  {"discs", "gas"},
                                                                  {"pile", "pile"},
                                                                  {"rough-pile", "rough-pile"},
                                                                  {"dam", "rough-pile"},
                                                                  {"billiard", "gas"},
                                                                  {"mixed-sizes", "mixed-masses"},
                                                                  {"pyramid", "shapes"},
                                                                  {"tumbler", "shapes"},
                                                                  {"smash", "elastic-shapes"},
                                                                  {"chain", "joints"},
                                                                  {"cloth", "joints"},
                                                                  {"rain", "joints"}};
  for (const auto& [scene, kind] : kinds) {
    SCOPED_TRACE(scene);
    const Json target = choice({"--scene", scene, "--particles", "600", "--target-ms", "1e6"});
    EXPECT_EQ(target["kind"], kind);
    EXPECT_NE(target["because"], "");
    EXPECT_NE(target["measure"], "");
    EXPECT_EQ(target["ms"], 1e6);
  }
}

TEST(Target, ErrorTakesTheCheapestThatReachIt) {
  for (const char* scene : {"pile", "rough-pile", "mixed-sizes", "orbits", "gas-periodic", "pyramid", "joint_grid"}) {
    SCOPED_TRACE(scene);
    double cost = 0;
    for (const char* error : {"0.1", "0.02", "0.005"}) {
      const Json t = choice({"--scene", scene, "--particles", "600", "--target-error", error});
      EXPECT_LE(t["chosen"]["error"], std::stod(error));
      EXPECT_GE(t["chosen"]["ms_per_frame"], cost) << "a smaller error must not cost less";
      cost = t["chosen"]["ms_per_frame"];
      if (t["refused"].is_null()) continue;
      EXPECT_LE(t["refused"]["ms_per_frame"], cost);
      if (!t["refused"]["error"].is_null()) {
        EXPECT_GT(t["refused"]["error"], std::stod(error));
      }
    }
  }
}

TEST(Target, ErrorDependsOnTheLoadAndTheFrame) {
  const Words small = {"--scene", "pile", "--particles", "600", "--target-error", "0.02"};
  const Words large = {"--scene", "pile", "--particles", "20000", "--target-error", "0.02"};
  EXPECT_GT(choice(large)["chosen"]["substeps"], choice(small)["chosen"]["substeps"]);
  Words longer = small;
  longer.insert(longer.end(), {"--dt", "0.033333333"});
  EXPECT_GT(choice(longer)["chosen"]["substeps"], choice(small)["chosen"]["substeps"]);
}

TEST(Target, ErrorLooksAtNoClock) {
  const Words words = {"--scene", "rough-pile", "--particles", "500", "--frames", "20", "--target-error", "0.01"};
  const Json first = report_of(words);
  Words other = words;
  other.insert(other.end(), {"--isa", "scalar", "--threads", "3"});
  for (const Words& again : {words, other}) {
    const Json report = report_of(again);
    EXPECT_EQ(report["target"], first["target"]);
    EXPECT_EQ(report["state_hash"], first["state_hash"]);
  }
}

TEST(Target, ErrorIsKeptOnAnOrbit) {
  const ScratchFolder folder;
  const std::string scene = folder.write("orbit.json", kOrbit);
  for (const char* error : {"1e-3", "1e-5", "1e-7", "1e-9"}) {
    SCOPED_TRACE(error);
    const Json report = report_of({"--scene", scene, "--frames", "777", "--target-error", error});
    const double start =
        report["energy"]["kinetic_start"].get<double>() + report["energy"]["potential_start"].get<double>();
    const double end = report["energy"]["kinetic"].get<double>() + report["energy"]["potential"].get<double>();
    EXPECT_LE(std::abs(end / start - 1), std::stod(error));
  }
}

TEST(Target, ErrorIsKeptInAPile) {
  for (const char* error : {"0.02", "0.004"}) {
    SCOPED_TRACE(error);
    const Json report = report_of({"--scene", "pile", "--particles", "800", "--sleep", "off", "--target-error", error});
    // Discs of 1 m; the deepest overlap of all against what 99 % stay below.
    EXPECT_LE(report["max_penetration"], 2 * std::stod(error));
  }
}

TEST(Target, ErrorIsKeptInAHeapOfBoxes) {
  for (const char* error : {"0.02", "0.002"}) {
    SCOPED_TRACE(error);
    const Json report = report_of({"--scene", "pyramid", "--sleep", "off", "--frames", "300", "--target-error", error});
    EXPECT_LE(report["max_penetration"], 2 * std::stod(error));  // boxes of 1 m
  }
}

TEST(Target, TimeTakesTheMostAccurateThatFit) {
  const Words scene = {"--scene", "pile", "--particles", "2000", "--threads", "1", "--target-ms"};
  const auto within = [&](const std::string& ms) {
    Words words = scene;
    words.push_back(ms);
    return choice(words);
  };
  const Json ample = within("1e6");
  EXPECT_EQ(ample["refused"], nullptr) << "nothing is better than what fits into an hour";
  const double slowest = ample["chosen"]["ms_per_frame"];
  const Json half = within(std::to_string(slowest / 2));
  EXPECT_LE(half["chosen"]["ms_per_frame"], half["ms"]);
  EXPECT_GT(half["refused"]["ms_per_frame"], half["ms"]);
  EXPECT_GE(half["chosen"]["error"], ample["chosen"]["error"]);
  EXPECT_LT(half["refused"]["error"], half["chosen"]["error"]);
}

TEST(Target, TheReportSaysWhatAndWhy) {
  const Outcome outcome =
      run_psim({"--scene", "rough-pile", "--particles", "500", "--frames", "2", "--target-error", "0.01"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* words : {"Target error 0.01: ", " substeps, verlet", "expected error",
                            "Target kind rough-pile (gravity and friction)", "overlap at rest"}) {
    EXPECT_NE(outcome.out.find(words), std::string::npos) << words << " in\n" << outcome.out;
  }
  const Outcome plain = run_psim({"--scene", "rough-pile", "--particles", "500", "--frames", "2"});
  EXPECT_EQ(plain.out.find("Target"), std::string::npos);
}

TEST(Target, WhatIsOutOfReachIsOneLineWithTheBestThereIs) {
  const ScratchFolder folder;
  for (const char* scene : {"pile", "gas-periodic", "mixed-sizes"}) {
    expect_refused(
        run_psim({"--scene", scene, "--particles", "500", "--target-error", "1e-12", "--state", folder.file("s.csv")}),
        {"--target-error 1e-12", "out of reach", "the least that was measured is", "substeps"});
  }
  expect_refused(run_psim({"--scene", "orbits", "--target-error", "1e-12", "--dt", "1"}),
                 {"--target-error 1e-12", "out of reach", "with 64 substeps, "});
  expect_refused(run_psim({"--scene", "pile", "--particles", "100000", "--target-error", "0.01", "--dt", "1"}),
                 {"--target-error 0.01", "out of reach", "--dt"});
  expect_refused(
      run_psim({"--scene", "pile", "--particles", "500", "--target-ms", "1e-6", "--state", folder.file("s.csv")}),
      {"--target-ms 1e-06", "out of reach", "the fastest settings", "ms a frame"});
  EXPECT_EQ(folder.names(), Words{});
}

TEST(Target, MistakesAreOneLine) {
  const std::vector<std::pair<Words, Words>> mistakes = {
      {{"--target-error"}, {"--target-error", "needs a value"}},
      {{"--target-error", "0"}, {"--target-error 0", "above 0"}},
      {{"--target-error", "-1e-3"}, {"--target-error -1e-3", "above 0"}},
      {{"--target-error", "2"}, {"--target-error 2", "at most 1"}},
      {{"--target-error", "nan"}, {"--target-error nan", "above 0"}},
      {{"--target-error", "1%"}, {"--target-error 1%", "above 0"}},
      {{"--target-ms", "0"}, {"--target-ms 0", "milliseconds"}},
      {{"--target-ms", "inf"}, {"--target-ms inf", "milliseconds"}},
      {{"--target-ms", "4ms"}, {"--target-ms 4ms", "milliseconds"}},
      {{"--target-ms", "4", "--target-error", "0.1"}, {"--target-ms", "one at a time"}},
      {{"--target-ms", "4", "--substeps", "8"}, {"--substeps", "--target-ms chooses"}},
      {{"--target-error", "0.1", "--substeps", "8"}, {"--substeps", "--target-error chooses"}},
      {{"--target-error", "0.1", "--integrator", "rk4"}, {"--integrator", "--target-error"}},
      {{"--target-error", "0.1", "--verify"}, {"--target-error", "run"}},
      {{"--target-ms", "4", "--explain"}, {"--target-ms", "run"}},
  };
  for (const auto& [arguments, words] : mistakes) {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    expect_refused(run_psim(arguments), words);
  }
}

}  // namespace
}  // namespace psim::test
