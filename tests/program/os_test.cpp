// What psim promises of files, names and other programs is the same on every system (src/core/base/os.h, src/psim/os).
#include <cstdlib>

#include "base/os.h"
#include "cli_runner.h"

namespace psim::test {
namespace {

bool is_there(const std::string& name) { return exists(os::path_of(name)); }

TEST(Systems, NamesOfFilesAreUtf8) {
  const ScratchFolder folder;
  const std::string scene = folder.file("größe 大.json"), state = folder.file("straße.csv"),
                    save = folder.file("снимок.psim");
  std::ofstream(os::path_of(scene)) << kSmallScene;
  const Outcome outcome = run_psim({"--scene", scene, "--frames", "3", "--state", state, "--save", save});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_TRUE(is_there(state));
  EXPECT_TRUE(is_there(save));
  EXPECT_EQ(run_psim({"--scene", scene, "--frames", "3", "--restore", save}).status, 0);
  EXPECT_EQ(run_psim({"diff", state, state}).status, 0);
  expect_refused(run_psim({"--scene", folder.file("größer 大.json")}), {"größer 大.json: no such file"});
}

TEST(Systems, WhatIsWrittenHasPlainLineEnds) {
  const ScratchFolder folder;
  const Outcome outcome = run_psim({"--scene", folder.write("s.json", kSmallScene), "--frames", "2", "--report", "json",
                                    "--state", folder.file("s.csv")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out.find('\r'), std::string::npos);
  EXPECT_EQ(read_file(folder.file("s.csv")).find('\r'), std::string::npos);
}

class Films : public ::testing::Test {
 protected:
  Films() {
    set_variable("PATH", PSIM_STAND_IN_FOLDER);
    set_variable("PSIM_STAND_IN", "film");
  }
  ~Films() override { set_variable("PATH", path_); }

  Outcome film_by(const std::string& mode) {
    set_variable("PSIM_STAND_IN", mode);
    return run_psim({"--scene", scene_, "--frames", "3", "--fps", "60", "--image-size", "64x48", "--video", film_});
  }

  ScratchFolder folder_;
  const std::string path_ = std::getenv("PATH"), scene_ = folder_.write("s.json", kSmallScene),
                    film_ = folder_.file("fälle.mp4");
};

TEST_F(Films, GoThroughAPipeIntoAFileThatTakesItsName) {
  for (int k = 0; k < 2; ++k) {  // a new file, and one that is replaced
    const Outcome outcome = film_by("film");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(read_file(os::path_of(film_)), std::to_string(4 * 64 * 48 * 3));
    EXPECT_EQ(folder_.names().size(), 2u);
  }
}

TEST_F(Films, ThatFailSayWhyAndLeaveNoFile) {
  for (const auto& [mode, why] : {std::pair("fail", "out of paper"), std::pair("nothing", "ended without a film")}) {
    const Outcome outcome = film_by(mode);  // the run itself comes to its end
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find(std::string("ffmpeg failed: ") + why + '\n'), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(folder_.names().size(), 1u);
}

}  // namespace
}  // namespace psim::test
