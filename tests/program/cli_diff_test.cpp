// psim diff: two files, or two settings; what differs first, and what cannot be compared.
#include "cli_runner.h"

namespace psim::test {
namespace {

using Words = std::vector<std::string>;

constexpr const char* kState = "id,x,y,angle,vx,vy,omega\n";
constexpr const char* kTrajectory = "frame,id,x,y,angle,vx,vy,omega\n";

void expect_words(const Outcome& outcome, int status, const Words& words) {
  EXPECT_EQ(outcome.status, status) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  for (const std::string& word : words) {
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word << " is not in:\n" << outcome.out;
  }
}

class CliDiff : public ::testing::Test {
 protected:
  Outcome diff(std::string_view a, std::string_view b) {
    return run_psim({"diff", folder_.write("a.csv", a), folder_.write("b.csv", b)});
  }
  Outcome diff_states(const std::string& a, const std::string& b) { return diff(kState + a, kState + b); }
  Outcome diff_courses(const std::string& a, const std::string& b) { return diff(kTrajectory + a, kTrajectory + b); }
  Outcome diff_settings(Words more) {
    Words arguments = {"diff", "--scene", scene_, "--frames", "9"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_psim(std::move(arguments));
  }
  ScratchFolder folder_;
  std::string scene_ = folder_.write("small.json", kSmallScene);
};

TEST_F(CliDiff, AStateIsTheSameAsItself) {
  ASSERT_EQ(run_psim({"--scene", scene_, "--frames", "30", "--state", folder_.file("s.csv"), "--trajectory",
                      folder_.file("t.csv")})
                .status,
            0);
  expect_words(run_psim({"diff", folder_.file("s.csv"), folder_.file("s.csv")}), 0, {"The same bits: 4 bodies"});
  expect_words(run_psim({"diff", folder_.file("t.csv"), folder_.file("t.csv")}), 0,
               {"The same bits: 31 frames, 4 bodies"});
}

TEST_F(CliDiff, TheFirstNumberThatDiffersIsNamedWithItsBits) {
  expect_words(diff_states("0,1,2,0,0,0,0\n7,1,2,0,0.1,0,0\n9,5,0,0,0,0,0\n",
                           "0,1,2,0,0,0,0\n7,1,2,0,0.10000000000000002,3,0\n9,5,0,0,0,0,1e-300\n"),
               1,
               {"First difference: body 7 vx: 0.1 (0x3fb999999999999a) against "
                "0.10000000000000002 (0x3fb999999999999b)\n",
                "Bodies that differ: 2 of 3\n"});
}

TEST_F(CliDiff, TheTotalsHoldTheLargestDifferenceOfEveryField) {
  const Outcome outcome = diff_courses("0,1,0,0,0,0,0,0\n0,2,0,0,0,0,0,0\n5,1,0,0,0,0,0,0\n5,2,0,0,0,0,0,0\n",
                                       "0,1,0,0,0,0,0,0\n0,2,0,0,0.25,0,0,0\n5,1,0,0,-1.5,0,0,0\n5,2,0,0,1,0,0,0\n");
  expect_words(
      outcome, 1,
      {"First difference in frame 0: body 2 angle: 0 (", "Frames that differ: 2 of 2\n", "Bodies that differ: 2 of 2\n",
       "angle                 1.5          5          1\n", "x                       0\n"});
}

TEST_F(CliDiff, NanIsComparedByItsBits) {
  expect_words(diff_states("0,nan,2,0,0,0,0\n", "0,nan,2,0,0,0,0\n"), 0, {"The same bits"});
  expect_words(diff_states("0,nan,2,0,0,0,0\n", "0,-nan,2,0,0,0,0\n"), 1,
               {"x: nan (0x7ff8000000000000) against -nan (0xfff8000000000000)"});
  expect_words(diff_states("0,1,2,0,0,0,0\n", "0,1,2,nan,0,0,0\n"), 1,
               {"angle: 0 (0x0000000000000000) against nan", "inf"});
}

TEST_F(CliDiff, SignedZerosAreAlikeAndDenormalsAreNot) {
  expect_words(diff_states("0,-0,2,0,0,0,0\n", "0,0,2,0,0,0,0\n"), 0, {"The same bits"});
  expect_words(diff_states("0,0,2,0,0,0,0\n", "0,5e-324,2,0,0,0,0\n"), 1, {"against 5e-324 (0x0000000000000001)"});
}

TEST_F(CliDiff, ABodyThatLeftOneSideIsADifference) {
  expect_words(diff_courses("0,0,0,0,0,0,0,0\n0,1,9,0,0,0,0,0\n1,0,0,0,0,0,0,0\n1,1,9,0,0,0,0,0\n",
                            "0,0,0,0,0,0,0,0\n0,1,9,0,0,0,0,0\n1,0,0,0,0,0,0,0\n"),
               1, {"First difference in frame 1: body 1 is only in ", "a.csv\n"});
}

TEST_F(CliDiff, AFileThatEndsEarlyIsADifference) {
  expect_words(diff_courses("0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n", "0,0,0,0,0,0,0,0\n"), 1,
               {"The same bits: 1 frames", "Frame 1 is only in ", "a.csv"});
}

TEST_F(CliDiff, WhatCannotBeComparedIsRefused) {
  const std::string row = "0,1,2,0,0,0,0\n";
  expect_refused(diff_states(row, row + "1,1,2,0,0,0,0\n"), {"a.csv has 1 bodies", "b.csv has 2"});
  expect_refused(diff_states(row, "1,1,2,0,0,0,0\n"), {"body 0 is only in", "a.csv"});
  expect_refused(diff(kState + row, kTrajectory), {"b.csv is a trajectory", "like with like"});
  expect_refused(diff_courses("0,0,0,0,0,0,0,0\n2,0,0,0,0,0,0,0\n", "0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n"),
                 {"a.csv has frame 2", "b.csv has frame 1", "--every"});
}

TEST_F(CliDiff, ABadFileIsRefusedWithItsPlace) {
  const std::string row = "0,1,2,0,0,0,0\n";
  const std::vector<std::pair<std::string, Words>> mistakes = {
      {"", {"a.csv:1: not a state or trajectory file"}},
      {"frame,total_ms\n", {"a.csv:1: not a state or trajectory file"}},
      {std::string(3'000'000, 'x'), {"a.csv:1: a line of over 1 MiB"}},
      {kState + row + "1,1,2,0\n", {"a.csv:3: vx is missing"}},
      {kState + row + "\n", {"a.csv:3: id is missing"}},
      {kState + row + "1,1,2,0,0,0,0,5\n", {"a.csv:3: has more values"}},
      {kState + row + "1,1,2m,0,0,0,0\n", {"a.csv:3: y: '2m' is not a number"}},
      {kState + row + "1,1,1e999,0,0,0,0\n", {"a.csv:3: y: '1e999'"}},
      {kState + row + "-1,1,2,0,0,0,0\n", {"a.csv:3: id: '-1'"}},
      {kState + row + row, {"a.csv:3: id 0 after 0"}},
      {kTrajectory + std::string("3,0,0,0,0,0,0,0\n2,0,0,0,0,0,0,0\n"), {"a.csv:3: frame 2 after 3"}},
  };
  for (const auto& [text, words] : mistakes) {
    SCOPED_TRACE(words.front());
    const std::string good = text.starts_with("frame") ? kTrajectory + ("3," + row) : kState + row;
    expect_refused(diff(text, good + (good.starts_with("frame") ? "4," + row : "")), words);
  }
  const std::string there = folder_.write("there.csv", kState), none = folder_.file("none.csv");
  expect_refused(run_psim({"diff", there, none}), {"none.csv: No such file"});
  expect_refused(run_psim({"diff", none, there}), {"none.csv: No such file"});
}

TEST_F(CliDiff, MistakesOnTheCommandLineAreNamed) {
  const std::vector<std::pair<Words, Words>> mistakes = {
      {{"diff"}, {"two files", "--a and --b"}},
      {{"diff", "a.csv"}, {"diff a.csv", "second file"}},
      {{"diff", "a.csv", "b.csv", "c.csv"}, {"c.csv", "unexpected word"}},
      {{"diff", "a.csv", "b.csv", "--a", "--isa scalar"}, {"two files or settings"}},
      {{"diff", "a.csv", "b.csv", "--frames", "3"}, {"two files or settings"}},
      {{"diff", "--a"}, {"--a", "needs a value"}},
      {{"diff", "--b", "--trheads 2"}, {"--b: --trheads", "did you mean --threads?"}},
      {{"diff", "--b", "--threads 0"}, {"--b: --threads 0", "1 to 256"}},
      {{"diff", "--b", "--threads"}, {"--b: --threads", "needs a value"}},
      {{"diff", "--verify"}, {"--verify", "unknown option"}},
      {{"diff", "--a", "--frames 3", "--b", "--frames 4"}, {"3 against 4 frames"}},
      {{"--threads", "2", "diff", "--a", ""}, {"--threads", "behind"}},
  };
  for (const auto& [arguments, words] : mistakes) {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    expect_refused(run_psim(arguments), words);
  }
  expect_refused(run_psim({"diff", "--particles", "10", "--b", "--particles 20"}),
                 {"side A has 10 bodies", "side B has 20"});
}

TEST_F(CliDiff, SettingsThatChangeNoBitAreTheSame) {
  expect_words(diff_settings({"--a", "--isa auto --threads 2", "--b", "--isa=scalar --threads=1"}), 0,
               {"A: ", "2 threads", "B: ", "scalar, 1 threads", "The same bits: 10 frames"});
}

TEST_F(CliDiff, SettingsThatDifferAreNamedWithFrameAndStage) {
  expect_words(diff_settings({"--substeps", "4", "--b", "--substeps 8"}), 1,
               {"First difference in frame 1, stage ", "body 1 y: 0.49", "hash 0x", "Frames that differ: 9 of 10"});
  expect_words(run_psim({"diff", "--particles", "50", "--frames", "1", "--b", "--seed 2"}), 1,
               {"First difference before any step: body 0 x: ", "Frames that differ: 2 of 2"});
}

TEST_F(CliDiff, IntegratorsDifferWhereThereAreFieldsAndOnlyThere) {
  const auto world = [this](const char* name, const char* fields) {
    return folder_.write(name, R"({"psim": 1,
      "world": {"bounds": [-99, -99, 99, 99], "boundary": "open", "gravity": [0, -9.81]},
      "bodies": [{"shape": {"disc": {"radius": 0.5}}, "position": [0, 50]}], "fields": [)" +
                                   std::string(fields) + "]}");
  };
  const auto compared = [](const std::string& scene) {
    return run_psim({"diff", "--scene", scene, "--frames", "5", "--b", "--integrator rk4"});
  };
  expect_words(compared(world("uniform.json", "")), 0, {", verlet\n", ", rk4\n", "The same bits"});
  expect_words(compared(world("well.json", R"({"type": "well", "position": [0, 0], "strength": 9})")), 1,
               {"First difference in frame 1, stage "});
}

TEST_F(CliDiff, WhereNothingTouchesTheStageIsIntegrate) {
  const std::string flight = folder_.write("flight.json", R"({"psim": 1,
    "world": {"bounds": [-99, -99, 99, 99], "boundary": "open", "gravity": [0, -9.81]},
    "bodies": [{"shape": {"disc": {"radius": 0.5}}, "position": [0, 50]}]})");
  const Outcome outcome = run_psim({"diff", "--scene", flight, "--frames", "5", "--b", "--dt 0.01"});
  expect_words(outcome, 1, {"First difference in frame 1, stage integrate: body 0 y: "});
}

TEST_F(CliDiff, WhatTheFilesSayIsWhatTheSettingsSay) {
  const auto course = [this](const char* substeps) {
    const std::string file = folder_.file(std::string(substeps) + ".csv");
    EXPECT_EQ(run_psim({"--scene", scene_, "--frames", "9", "--substeps", substeps, "--trajectory", file}).status, 0);
    return file;
  };
  const Outcome files = run_psim({"diff", course("2"), course("3")});
  const Outcome settings = diff_settings({"--a", "--substeps 2", "--b", "--substeps 3"});
  EXPECT_EQ(files.status, 1);
  EXPECT_EQ(settings.status, 1);
  const auto totals = [](const std::string& text) { return text.substr(text.find("Frames that")); };
  EXPECT_EQ(totals(files.out), totals(settings.out));
}

TEST_F(CliDiff, HelpShowsBothForms) {
  expect_words(run_psim({"diff", "--help"}), 0, {"psim diff a.csv b.csv", "--a", "--b", "--seed"});
  expect_words(run_psim({"--help"}), 0, {"diff"});
}

}  // namespace
}  // namespace psim::test
