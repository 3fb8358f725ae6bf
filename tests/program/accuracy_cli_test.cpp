// The accuracy program as a user meets it: its rows, its lists, its refusals.
#include <psim/scene.h>

#include <map>
#include <set>
#include <utility>

#include "cli_runner.h"
#include "support.h"

namespace psim::test {
namespace {

Outcome run_accuracy(std::vector<std::string> arguments) { return Process(PSIM_ACCURACY, std::move(arguments)).wait(); }

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

TEST(Accuracy, WritesOneTidyRowAPoint) {
  const auto result = run_accuracy({"--quick", "--case", "free-fall", "--engine", "psim"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_GT(lines.size(), 3u);
  EXPECT_EQ(lines[0], "case,engine,setting,h,iterations,seconds_per_sim_second,row_visits,error,unit,reference");
  int defaults = 0;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    ASSERT_EQ(fields.size(), 10u) << lines[k];
    EXPECT_EQ(fields[0], "free-fall");
    EXPECT_EQ(fields[1], "psim");
    EXPECT_GT(std::stod(fields[3]), 0);
    EXPECT_GT(std::stod(fields[5]), 0);
    EXPECT_GE(std::stod(fields[7]), 0);
    EXPECT_EQ(fields[9], "analytic");
    defaults += fields[2].ends_with(" default") ? 1 : 0;
  }
  EXPECT_EQ(defaults, 1);
}

TEST(Accuracy, ListsEnginesAndCasesAndRunsNothing) {
  const auto result = run_accuracy({"--list"});
  EXPECT_EQ(result.status, 0);
  for (const char* word : {"psim", "box2d", "box2d3", "chipmunk", "kepler", "pile-penetration"}) {
    EXPECT_NE(result.out.find(word), std::string::npos) << word;
  }
}

TEST(Accuracy, ListsCasesOfBoxesAndJoints) {
  const auto result = run_accuracy({"--list"});
  EXPECT_EQ(result.status, 0);
  for (const char* name : {"stack-20-height", "stack-100-sideways", "staggered-20-height", "pyramid-20-way",
                           "loaded-10-height", "loaded-100-height", "loaded-1000-height", "two-legs-height",
                           "box-slide-distance", "box-hold-threshold", "box-hold-creep", "box-tip-threshold",
                           "pendulum-period", "double-pendulum", "double-rods", "oscillator-amplitude", "chain-sag"}) {
    EXPECT_NE(result.out.find(name), std::string::npos) << name;
  }
}

TEST(Accuracy, ListsCasesOfShapesTerrainAndStructures) {
  const auto result = run_accuracy({"--list"});
  EXPECT_EQ(result.status, 0);
  for (const char* name : {"shape-gas-energy",   "box-impact",         "rocking-block",    "leaning-cards-threshold",
                           "card-house-sinks",   "arch-sinks",         "stone-wall-sinks", "level-chain-speed",
                           "hill-speed",         "valley-speed",       "loop-threshold",   "rods-gain",
                           "chain-gap-100-1000", "chain-modes-period", "truss-sag",        "bridge-sag",
                           "elastica-drop",      "ring-radius",        "crank-slider",     "stack-load-100",
                           "legs-10000-share",   "silo-load"}) {
    EXPECT_NE(result.out.find(name), std::string::npos) << name;
  }
}

// Welds, a slide, and loads that contacts report.
TEST(Accuracy, EveryEngineGetsTheSameWeldsSlidesAndLoads) {
  const auto result = run_accuracy({"--quick", "--case", "cantilever", "--case", "crank", "--case", "stack-load-10"});
  EXPECT_EQ(result.status, 0) << result.err;
  std::map<std::string, std::set<std::string>> engines;
  const auto lines = lines_of(result.out);
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    if (!fields[2].ends_with(" default")) continue;
    engines[fields[0]].insert(fields[1]);
    // Ten boxes stand in every engine, and loads are off by little in what stands.
    if (fields[0] == "stack-load-10") {
      EXPECT_LT(std::stod(fields[7]), 0.01) << lines[k];
    }
  }
  ASSERT_EQ(engines.size(), 3u);
  for (const auto& [name, ran] : engines) EXPECT_EQ(ran, engines["crank-slider"]) << name;
}

TEST(Accuracy, ABoxStackStandsWithinItsLimits) {
  const auto result = run_accuracy({"--quick", "--case", "stack-20", "--engine", "psim"});
  ASSERT_EQ(result.status, 0) << result.err;
  std::map<std::string, double> errors;
  const auto lines = lines_of(result.out);
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    if (!fields[2].ends_with(" default")) continue;
    errors[fields[0]] = std::stod(fields[7]);
    EXPECT_GT(std::stod(fields[6]), 0) << lines[k];
  }
  ASSERT_EQ(errors.size(), 3u);
  EXPECT_LT(errors["stack-20-height"], 0.004);
  EXPECT_LT(errors["stack-20-sideways"], 1e-4);
  EXPECT_LT(errors["stack-20-speed"], 1e-3);
}

// Coarse: no engine is accurate here, but none may get another box or another joint.
TEST(Accuracy, EveryEngineGetsTheSameBoxesAndJoints) {
  const auto result = run_accuracy({"--quick", "--case", "box-slide", "--case", "double-rods", "--case", "chain"});
  ASSERT_EQ(result.status, 0) << result.err;
  const std::map<std::string, double> limits = {{"box-slide-distance", 0.05}, {"double-rods", 0.2}, {"chain-sag", 0.1}};
  std::map<std::string, std::set<std::string>> engines;
  const auto lines = lines_of(result.out);
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    const auto limit = limits.find(fields[0]);
    if (limit == limits.end() || !fields[2].ends_with(" default")) continue;
    engines[fields[0]].insert(fields[1]);
    EXPECT_LT(std::stod(fields[7]), limit->second) << lines[k];
  }
  ASSERT_EQ(engines.size(), limits.size());
  for (const auto& [name, ran] : engines) EXPECT_EQ(ran, engines["chain-sag"]) << name;
  EXPECT_TRUE(engines["chain-sag"].contains("psim"));
}

TEST(Accuracy, KindKeepsDiscsOrRigidBodies) {
  for (const auto& [kind, other] : {std::pair{"discs", "stack-20"}, {"rigid", "column"}}) {
    const auto result = run_accuracy({"--kind", kind, "--case", other});
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find(other), std::string::npos) << result.err;
  }
  EXPECT_EQ(run_accuracy({"--kind", "nonesuch"}).status, 2);
}

TEST(SlowAccuracy, StressGradesEveryStress) {
  const ScratchFolder folder;
  const auto result = run_accuracy({"--stress", "--quick", "--engine", "psim", "--output", folder.file("stress.csv")});
  EXPECT_TRUE(result.status == 0 || result.status == 1) << result.err;
  const auto lines = lines_of(read_file(folder.file("stress.csv")));
  ASSERT_GT(lines.size(), 20u);
  EXPECT_EQ(lines[0], "stress,figure,engine,value,unit,limit,grade,what");
  std::set<std::string> stresses;
  bool all_hold = true;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    ASSERT_GE(fields.size(), 8u) << lines[k];
    stresses.insert(fields[0]);
    EXPECT_TRUE(fields[6] == "holds" || fields[6] == "misses") << lines[k];
    all_hold = all_hold && fields[6] == "holds";
    EXPECT_NE(result.out.find(fields[1]), std::string::npos) << fields[1];
  }
  EXPECT_EQ(stresses.size(), 14u);
  EXPECT_EQ(result.status == 0, all_hold);
}

TEST(Accuracy, StressAndCasesExcludeEachOther) {
  const ScratchFolder folder;
  const auto result = run_accuracy({"--stress", "--case", "kepler", "--output", folder.file("stress.csv")});
  EXPECT_EQ(result.status, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(folder.names().empty());
}

TEST(SlowAccuracy, CalibratesEveryKindOfScene) {
  const ScratchFolder folder;
  const std::string file = folder.file("calibration.csv");
  const auto result = run_accuracy({"--calibrate", "--quick", "--output", file});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto lines = lines_of(read_file(file));
  const auto shipped = lines_of(read_file(std::string(PSIM_SOURCE_DIR) + "/docs/data/calibration.csv"));
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines[0], shipped.at(0));
  std::set<std::string> kinds, shipped_kinds;
  for (std::size_t k = 1; k < shipped.size(); ++k) shipped_kinds.insert(fields_of(shipped[k])[0]);
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const auto fields = fields_of(lines[k]);
    ASSERT_EQ(fields.size(), 10u) << lines[k];
    kinds.insert(fields[0]);
    for (const std::size_t positive : {3u, 4u, 5u, 6u, 7u, 9u}) {
      EXPECT_GT(std::stod(fields[positive]), 0) << lines[k];
    }
  }
  EXPECT_EQ(kinds, shipped_kinds);
  EXPECT_EQ(kinds.size(), 8u);
}

TEST(Accuracy, CalibrationStandsAlone) {
  const ScratchFolder folder;
  const auto result = run_accuracy({"--calibrate", "--case", "pile", "--output", folder.file("calibration.csv")});
  EXPECT_EQ(result.status, 2);
  EXPECT_TRUE(folder.names().empty());
}

// All cases with discs take minutes.
TEST(Accuracy, AnInterruptedRunLeavesTheOldFile) {
  const ScratchFolder folder;
  const std::string file = folder.write("rows.csv", "old");
  const auto result = Process("/usr/bin/env", {"timeout", "-s", "KILL", "0.3", PSIM_ACCURACY, "--kind", "discs",
                                               "--engine", "psim", "--output", file})
                          .wait();
  EXPECT_NE(result.status, 0);
  EXPECT_EQ(read_file(file), "old");
  EXPECT_EQ(folder.names().size(), 1u);
}

TEST(Accuracy, WhatCannotBeWrittenIsToldBeforeTheRun) {
  const auto result = run_accuracy({"--kind", "discs", "--output", "/nowhere/rows.csv"});
  EXPECT_EQ(result.status, 2);
  EXPECT_NE(result.err.find("--output /nowhere/rows.csv"), std::string::npos) << result.err;
}

TEST(Accuracy, RefusesWhatItDoesNotKnow) {
  for (const char* option : {"--case", "--engine"}) {
    const auto result = run_accuracy({option, "nonesuch"});
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find("nonesuch"), std::string::npos);
  }
}

TEST(Accuracy, ItsScenesAreSceneFiles) {
  const ScratchFolder folder;
  const auto result = run_accuracy({"--write-scenes", folder.file("scenes")});
  ASSERT_EQ(result.status, 0) << result.err;
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.file("scenes"))) {
    std::string error;
    EXPECT_TRUE(load_scene(entry.path().string(), error)) << error;
    ++scenes;
  }
  EXPECT_GT(scenes, 20);
}

}  // namespace
}  // namespace psim::test
