// The command line: what is refused, how it is said, and what needs no run.
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli_runner.h"
#include "psim/isa.h"

namespace psim::test {
namespace {

using Words = std::vector<std::string>;

TEST(CliOptions, MistakesAreOneLineThatNamesWhatWouldBeRight) {
  const std::vector<std::pair<Words, Words>> mistakes = {
      {{"--nonsense"}, {"--nonsense", "unknown option"}},
      {{"--trheads", "4"}, {"--trheads", "did you mean --threads?"}},
      {{"--frames=3", "-x"}, {"-x", "unknown option"}},
      {{"discs"}, {"discs", "--scene"}},
      {{"--frames"}, {"--frames", "needs a value"}},
      {{"--frames", "x"}, {"--frames x", "whole number"}},
      {{"--frames", "1.5"}, {"--frames 1.5", "whole number"}},
      {{"--frames", "-1"}, {"--frames -1", "0 to 1000000000"}},
      {{"--frames", "1000000001"}, {"--frames", "0 to 1000000000"}},
      {{"--particles", "0"}, {"--particles 0", "1 to 10000000"}},
      {{"--particles", "0x10"}, {"--particles 0x10", "1 to 10000000"}},
      {{"--particles", "99999999999999999999999"}, {"--particles", "1 to 10000000"}},
      {{"--seed", "-1"}, {"--seed -1", "whole number"}},
      {{"--threads", "0"}, {"--threads 0", "1 to 256"}},
      {{"--threads", "-1"}, {"--threads -1", "1 to 256"}},
      {{"--threads", "257"}, {"--threads 257", "1 to 256"}},
      {{"--dt", "0"}, {"--dt 0", "seconds"}},
      {{"--dt", "nan"}, {"--dt nan", "seconds"}},
      {{"--dt", "inf"}, {"--dt inf", "seconds"}},
      {{"--dt", "1e-7"}, {"--dt 1e-7", "seconds"}},
      {{"--substeps", "65"}, {"--substeps 65", "1 to 64"}},
      {{"--integrator", "rk5"}, {"--integrator rk5", "verlet, euler, rk4 or symplectic4"}},
      {{"--isa", "mmx"}, {"--isa mmx", "auto, scalar, sse, avx2, neon or simd128"}},
      {{"--report", "xml"}, {"--report xml", "text or json"}},
      {{"--budget", "0"}, {"--budget 0", "above 0"}},
      {{"--budget", "-nan"}, {"--budget", "above 0"}},
      {{"--sleep", "maybe"}, {"--sleep maybe", "on or off"}},
      {{"--skin", "0.2"}, {"--skin 0.2", "0.25 to 4"}},
      {{"--skin", "nan"}, {"--skin nan", "0.25 to 4"}},
      {{"--memory", "0"}, {"--memory 0", "whole number of million bytes, 1 to 1000000000"}},
      {{"--memory", "1.5"}, {"--memory 1.5", "whole number of million bytes, 1 to 1000000000"}},
      {{"--memory", "1", "--particles", "100000"}, {"100,000 bodies need", "976.6 KiB are allowed by --memory"}},
      {{"--governor", "maybe"}, {"--governor maybe", "on or off"}},
      {{"--every", "0", "--trajectory", "t.csv"}, {"--every 0", "1 to"}},
      {{"--every", "5"}, {"--every", "--trajectory"}},
      {{"--scene", "pyle"}, {"pyle", "did you mean pile?"}},
      {{"--scene", "/nonexistent/a.json"}, {"/nonexistent/a.json", "no such file"}},
      {{"--scene", ""}, {"--scene", "needs"}},
      {{"--scene", "two\nlines"}, {"two\\x0alines"}},
      {{"--verify", "--check"}, {"--verify", "--check", "one at a time"}},
      {{"--verify", "--report", "json"}, {"--report"}},
      {{"--verify=3"}, {"--verify", "takes no value"}},
  };
  for (const auto& [arguments, words] : mistakes) {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    expect_refused(run_psim(arguments), words);
  }
}

TEST(CliOptions, ParticlesBelongToBuiltInScenes) {
  const ScratchFolder folder;
  const std::string scene = folder.write("small.json", kSmallScene);
  expect_refused(run_psim({"--scene", scene, "--particles", "10"}), {"--particles", "built-in"});
}

TEST(CliOptions, ABadSceneIsOneLineWithItsPlace) {
  const ScratchFolder folder;
  const std::string scene = folder.write("bad.json", "{\n  \"psim\": 1,\n  \"wrld\": {}\n}\n");
  expect_refused(run_psim({"--scene", scene, "--state", folder.file("s.csv")}), {scene + ":3:", "wrld"});
  EXPECT_EQ(folder.names(), Words{"bad.json"});
}

TEST(CliOptions, TheLastOfARepeatedOptionCounts) {
  const Outcome outcome = run_psim({"--particles", "10", "--frames", "9", "--frames", "2", "--report", "json"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["frames"], 2);
}

TEST(CliOptions, HelpNamesEveryOption) {
  const Outcome outcome = run_psim({"--help"});
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.err, "");
  for (const char* option :
       {"--scene",        "--list-scenes", "--particles",  "--seed",        "--frames",  "--dt",         "--substeps",
        "--threads",      "--isa",         "--report",     "--state",       "--metrics", "--trajectory", "--every",
        "--image",        "--trace",       "--explain",    "--verify",      "--check",   "--benchmark",  "--budget",
        "--governor",     "--sleep",       "--memory",     "--skin",        "--version", "--help",       "--integrator",
        "--target-error", "--target-ms",   "--frames-dir", "--video",       "--fps",     "--image-size", "--view",
        "--colour",       "--fluid-state", "--fluid-look", "--fluid-colour"}) {
    EXPECT_NE(outcome.out.find(option), std::string::npos) << option;
  }
}

TEST(CliOptions, VersionNamesCompilerBuildAndIsas) {
  const Outcome outcome = run_psim({"--version"});
  EXPECT_EQ(outcome.status, 0);
  for (const char* word : {"psim ", "compiler ", "build ", "scalar"}) {
    EXPECT_NE(outcome.out.find(word), std::string::npos) << word;
  }
  for (const Isa isa : kAllIsas) {
    EXPECT_EQ(outcome.out.find(isa_name(isa)) != std::string::npos, isa_lanes(isa) != 0) << isa_name(isa);
  }
}

TEST(CliOptions, AnInstructionSetOfAnotherProcessorIsRefusedWithThoseOfTheBuild) {
  for (const Isa isa : kAllIsas) {
    if (isa_lanes(isa) != 0) continue;
    const std::string name(isa_name(isa));
    expect_refused(run_psim({"--isa", name, "--frames", "1"}), {"--isa " + name, "this build", "scalar"});
  }
}

TEST(CliOptions, EveryListedSceneCanBeExplained) {
  const Outcome list = run_psim({"--list-scenes"});
  ASSERT_EQ(list.status, 0);
  const std::vector<std::string> scenes = lines_of(list.out);
  for (const char* name :
       {"discs", "pile", "hourglass", "galton", "billiard", "orbits", "mixed-sizes", "dam", "million"}) {
    EXPECT_TRUE(std::any_of(scenes.begin(), scenes.end(), [name](const std::string& line) {
      return line.substr(0, line.find(' ')) == name;
    })) << name;
  }
  const Outcome explained = run_psim({"--explain", "--particles", "10"});
  EXPECT_EQ(explained.status, 0) << explained.err;
  EXPECT_NE(explained.out.find("broad_phase"), std::string::npos);
  EXPECT_NE(explained.out.find("integrate"), std::string::npos);
}

// A stage that is needed never reads as if it took no memory, and the numbers add up to the last line's.
TEST(CliOptions, ExplainTellsTheBytesOfEachStage) {
  for (const char* scene : {"discs", "rain", "cloth", "hourglass"}) {
    const Outcome explained = run_psim({"--explain", "--scene", scene, "--particles", "200"});
    ASSERT_EQ(explained.status, 0) << explained.err;
    const std::vector<std::string> lines = lines_of(explained.out);
    const auto number = [](std::string text) {
      std::erase(text, ',');
      return std::stoull(text);
    };
    unsigned long long sum = 0;
    int shared = 0;
    for (std::size_t k = 2; k + 1 < lines.size(); ++k) {
      std::istringstream words(lines[k]);
      std::string stage, needed, bytes;
      words >> stage >> needed >> bytes;
      EXPECT_FALSE(needed == "yes" && bytes == "0") << lines[k];
      if (bytes == "-") {
        EXPECT_EQ(needed, "yes") << lines[k];
        ++shared;
      } else {
        sum += number(bytes);
      }
    }
    EXPECT_GE(shared, 4) << scene;
    EXPECT_EQ(sum, number(lines.back().substr(0, lines.back().find(' ')))) << lines.back();
  }
}

TEST(CliOptions, CheckFailsOnASceneThatWillGoWrong) {
  const ScratchFolder folder;
  const Outcome good = run_psim({"--check", "--scene", folder.write("small.json", kSmallScene)});
  EXPECT_EQ(good.status, 0) << good.out << good.err;
  std::string fast(kSmallScene);
  fast.replace(fast.find("[1, 0]"), 6, "[900000, 0]");
  const Outcome bad = run_psim({"--check", "--scene", folder.write("fast.json", fast)});
  EXPECT_EQ(bad.status, 1) << bad.err;
  EXPECT_NE(bad.out, "");
}

TEST(CliOptions, TooManyBodiesForTheMemoryAreNamedWithTheBytesNeeded) {
  if (kSanitized) GTEST_SKIP() << "a sanitizer takes the address space for itself";
  Process shell("/bin/sh", {"-c", "ulimit -v 400000; exec \"$0\" --particles 10000000", PSIM_PROGRAM});
  expect_refused(shell.wait(), {"10,000,000 bodies", "bytes"});
}

}  // namespace
}  // namespace psim::test
