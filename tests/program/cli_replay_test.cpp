// --save and --restore, --record and --replay, the way a user types them.
#include "cli_runner.h"
#include "forged.h"
#include "psim/recording.h"

namespace psim::test {
namespace {

using Words = std::vector<std::string>;

std::string state_line(const Outcome& run) {
  for (const std::string& line : lines_of(run.out)) {
    if (line.starts_with("State 0x")) return line;
  }
  return "no state:\n" + run.out + run.err;
}

class CliReplay : public ::testing::Test {
 protected:
  static Outcome pile(Words more) {
    Words words = {"--scene", "rough-pile", "--particles", "400"};
    words.insert(words.end(), more.begin(), more.end());
    return run_psim(words);
  }
  void expect_refused(const Words& words, const std::string& line) {
    const Outcome run = run_psim(words);
    EXPECT_EQ(run.status, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_EQ(run.err, "psim: " + line + "\n");
  }
  ScratchFolder folder_;
  std::string state_ = folder_.file("a.state"), recording_ = folder_.file("a.record");
};

TEST_F(CliReplay, ARestoredRunEndsWhereTheWholeOneDoes) {
  const std::string whole = state_line(pile({"--frames", "90"}));
  const Outcome first = pile({"--frames", "50", "--save", state_});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_NE(state_line(first), whole);
  EXPECT_EQ(state_line(pile({"--frames", "40", "--restore", state_, "--isa", "scalar", "--threads", "3"})), whole);
}

// Shapes, columns, joints, fields, and lists for one step.
TEST_F(CliReplay, ARestoredRunOfAnySceneEndsWhereTheWholeOneDoes) {
  for (const char* const scene :
       {"tumbler", "card_house", "stack_100", "high_mass_ratio_1", "bridge", "orbits", "galton"}) {
    const auto run = [&](Words more) {
      more.insert(more.begin(), {"--scene", scene});
      return run_psim(more);
    };
    const std::string whole = state_line(run({"--frames", "45", "--threads", "2"}));
    ASSERT_EQ(run({"--frames", "30", "--save", state_}).status, 0) << scene;
    EXPECT_EQ(state_line(run({"--frames", "15", "--restore", state_})), whole) << scene;
  }
}

// glibc fills what is allocated with bytes of MALLOC_PERTURB_. None of them may reach a file: two runs of one world
// would save different ones, and a file would hold what the memory of a host held before.
TEST_F(CliReplay, FilesDoNotDependOnWhatMemoryHeld) {
  for (const char* const scene : {"joint_grid", "bridge", "spinner", "rough-pile", "orbits"}) {
    std::vector<std::string> files;
    for (const char* const filling : {"85", "170"}) {
      set_variable("MALLOC_PERTURB_", filling);
      for (const char* const option : {"--save", "--record"}) {
        ASSERT_EQ(run_psim({"--scene", scene, "--frames", "4", option, state_}).status, 0) << scene;
        files.push_back(read_file(state_));
      }
    }
    set_variable("MALLOC_PERTURB_", "0");
    EXPECT_TRUE(files[0] == files[2]) << scene << ": saved states";
    EXPECT_TRUE(files[1] == files[3]) << scene << ": recordings";
  }
}

TEST_F(CliReplay, ARecordingReplaysElsewhere) {
  const Outcome run = pile({"--frames", "70", "--record", recording_});
  ASSERT_EQ(run.status, 0) << run.err;
  const Outcome replay = run_psim({"--replay", recording_, "--isa", "scalar", "--threads", "2"});
  EXPECT_EQ(replay.status, 0) << replay.err;
  EXPECT_EQ(replay.out,
            recording_ + ": 70 steps on scalar x 2 threads, 2 hashes, all as recorded\n" + state_line(run) + "\n");
}

TEST_F(CliReplay, AGovernedRunReplaysFromItsLogAndCountsWhatWasCut) {
  const std::string log = folder_.file("log.csv"), metrics = folder_.file("m.csv");
  const Words scene = {"--scene", "rough-pile", "--particles", "400", "--frames", "60"};
  const auto with = [&](Words more) {
    more.insert(more.begin(), scene.begin(), scene.end());
    return run_psim(more);
  };
  const Words cut = {"--governor", "on", "--budget", "0.02", "--governor-log", log, "--metrics", metrics};
  const Outcome run = with(cut);
  ASSERT_EQ(run.status, 0) << run.err;
  int few = 0;
  const auto last = [](const std::string& row) { return row.substr(row.rfind(',') + 1); };
  const auto without_last = [](const std::string& row) { return row.substr(0, row.rfind(',')); };
  const auto rows = lines_of(read_file(log));
  ASSERT_EQ(rows.size(), 61u);
  EXPECT_EQ(rows[0], "frame,solves,substeps,frames,horizon,pieces,wakes,sweeps,fluid_parts");
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const std::string sweeps = last(without_last(rows[k]));
    few += sweeps != "0";
    const std::string row = lines_of(read_file(metrics))[k];  // most_sweeps, renewed, page_faults
    EXPECT_EQ(last(without_last(without_last(row))), sweeps);
    EXPECT_EQ(last(rows[k]), "0");  // no fluids
  }
  EXPECT_GT(few, 0);
  const std::string said = std::to_string(few).append(" frames with few sweeps over impacts, ");
  EXPECT_NE(run.out.find(said), std::string::npos) << run.out;
  EXPECT_EQ(state_line(with({"--governor-replay", log, "--isa", "scalar", "--threads", "3"})), state_line(run));
}

// Before there was a limit on sweeps.
TEST_F(CliReplay, AnOldGovernorsLogIsReadWithAllSweeps) {
  const std::string old = folder_.write("old.csv",
                                        "frame,solves,substeps,frames,horizon,pieces,wakes\n"
                                        "1,1,2,1,1,0,0\n2,1,2,1,1,0,0\n");
  const std::string same = folder_.write("new.csv",
                                         "frame,solves,substeps,frames,horizon,pieces,wakes,sweeps\n"
                                         "1,1,2,1,1,0,0,0\n2,1,2,1,1,0,0,0\n");
  EXPECT_EQ(state_line(pile({"--frames", "2", "--governor-replay", old})),
            state_line(pile({"--frames", "2", "--governor-replay", same})));
  const std::string wrong = folder_.write("wrong.csv",
                                          "frame,solves,substeps,frames,horizon,pieces,wakes,sweeps\n"
                                          "1,1,2,1,1,0,0\n");
  expect_refused({"--governor-replay", wrong}, "--governor-replay " + wrong +
                                                   ": line 2: must be frame,solves,substeps,frames,horizon,pieces,"
                                                   "wakes,sweeps");
}

TEST_F(CliReplay, OneLineSaysWhatIsWrong) {
  ASSERT_EQ(pile({"--frames", "5", "--save", state_, "--record", recording_}).status, 0);
  expect_refused({"--replay", state_}, "--replay " + state_ + ": it is no recording of psim");
  expect_refused({"--scene", "rough-pile", "--restore", recording_},
                 "--restore " + recording_ + ": it is no saved state of psim");
  expect_refused({"--restore", state_},
                 "--restore " + state_ + ": is no state of --scene discs: its bounds are others");
  expect_refused({"--replay", state_ + ".none"}, "--replay " + state_ + ".none: No such file or directory");
  expect_refused({"--scene", "rough-pile", "--restore", state_, "--dt", "0.1"}, "--dt: the state of --restore says it");
  expect_refused({"--replay", recording_, "--frames", "3"}, "--frames: the recording of --replay says it");
  expect_refused({"--replay", recording_, "--state", "x.csv"},
                 "--state: belongs to a run, and nothing is run for a report here");
  expect_refused({"--scene", "rough-pile", "--restore", state_, "--save", state_},
                 "--save " + state_ + ": is the file of --restore too");
  for (const char* name : {"--governor", "--governor=off"}) {
    Words words = {"--replay", recording_, name};
    if (words.back() == "--governor") words.push_back("on");
    expect_refused(words, "--governor: the recording of --replay says it");
  }
  expect_refused({"--replay", recording_, "--budget", "3"},
                 "--budget: belongs to a run, and a replay has none to keep");
  expect_refused({"--scene", "rough-pile", "--restore", state_, "--seed", "3"},
                 "--seed: the state of --restore says it");
  for (const char* option : {"--replay", "--restore"}) {
    expect_refused({option, "/dev/null"}, std::string(option) + " /dev/null: is a device; a file or a pipe is read");
  }
  const std::string whole = read_file(recording_), cut = whole.substr(0, whole.size() / 2);
  const std::string half = folder_.write("half.record", cut);
  expect_refused({"--replay", half}, "--replay " + half + ": it has " + std::to_string(cut.size()) + " bytes of " +
                                         std::to_string(whole.size()));
}

TEST_F(CliReplay, ARecordingThatBreaksOffIsDamaged) {
  ASSERT_EQ(pile({"--frames", "5", "--record", recording_}).status, 0);
  std::vector<std::byte> bytes;
  std::string error;
  ASSERT_TRUE(read_bytes(recording_, bytes, error)) << error;
  using Log = std::vector<std::byte>;
  const auto replay = [&](const auto& change) {
    const std::string name = folder_.file("forged.record");
    ASSERT_TRUE(write_bytes(name, forged(bytes, change), error)) << error;
    const Outcome run = run_psim({"--replay", name});
    test::expect_refused(run, {"--replay " + name + ": it is damaged: it says 5 steps and breaks off after "});
  };
  replay([](Log& log, std::uint64_t&) { log[0] = std::byte{99}; });
  replay([](Log& log, std::uint64_t&) { log.clear(); });
  replay([](Log& log, std::uint64_t&) { log.resize(log.size() - kBytesOfAHash); });
  replay([](Log& log, std::uint64_t&) { log.resize(log.size() - 20); });
}

TEST_F(CliReplay, AnInterruptedReplayHasNotComparedAll) {
  const std::string scene = folder_.write("small.json", kSmallScene);
  ASSERT_EQ(run_psim({"--scene", scene, "--sleep", "off", "--frames", "200000", "--record", recording_}).status, 0);
  Process psim(PSIM_PROGRAM, {"--replay", recording_, "--threads", "1"});
  ASSERT_TRUE(psim.waits_for(SIGINT));
  psim.signal(SIGINT);
  const Outcome outcome = psim.wait();
  EXPECT_EQ(outcome.status, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
  EXPECT_TRUE(outcome.err.starts_with("psim: interrupted after step ")) << outcome.err;
  EXPECT_TRUE(outcome.err.ends_with(" of 200000\n")) << outcome.err;
}

}  // namespace
}  // namespace psim::test
