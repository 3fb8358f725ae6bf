// write_bytes and read_bytes: never half a file, nothing of others disturbed, nothing left behind. What could do harm
// is done by a child, and to files of a folder of its own.
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <csignal>

#include "cli_runner.h"
#include "psim/recording.h"
#include "psim/saved_state.h"

namespace psim::test {
namespace {

using Bytes = std::vector<std::byte>;
using Words = std::vector<std::string>;
namespace fs = std::filesystem;

Bytes some(std::size_t size, int value) { return Bytes(size, static_cast<std::byte>(value)); }

// What the child's work gave, at most 254; 255 if it did not end by itself.
template <class Work>
int in_child(const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 255;
}

mode_t mode_of(const std::string& path) {
  struct stat file = {};
  EXPECT_EQ(::stat(path.c_str(), &file), 0);
  return file.st_mode & 0777;
}

class OutputFiles : public ::testing::Test {
 protected:
  void expect_written(const std::string& path, int value = 7) {
    const Bytes bytes = some(1000, value);
    Bytes read;
    ASSERT_TRUE(write_bytes(path, bytes, error_)) << error_;
    ASSERT_TRUE(read_bytes(path, read, error_)) << error_;
    EXPECT_EQ(read, bytes);
  }
  ScratchFolder folder_;
  std::string error_;
  const std::string file_ = folder_.file("a");
};

TEST_F(OutputFiles, AUsersOwnFilesStay) {
  folder_.write("a", "old");
  folder_.write("a.part", "mine");
  expect_written(file_);
  EXPECT_EQ(read_file(folder_.file("a.part")), "mine");
  EXPECT_EQ(folder_.names(), (Words{"a", "a.part"}));
}

TEST_F(OutputFiles, ALinkIsFollowedAlsoOneThatLeadsNowhereYet) {
  fs::create_directory(folder_.file("there"));
  fs::create_symlink("there/b", folder_.file("link"));
  fs::create_symlink("link", folder_.file("link to it"));
  for (int k = 0; k < 2; ++k) {
    expect_written(folder_.file("link to it"), k);
    EXPECT_TRUE(fs::is_symlink(folder_.file("link")));
    EXPECT_TRUE(fs::is_symlink(folder_.file("link to it")));
    EXPECT_EQ(read_file(folder_.file("there/b")), std::string(1000, static_cast<char>(k)));
  }
  EXPECT_EQ(folder_.names(), (Words{"link", "link to it", "there"}));
}

TEST_F(OutputFiles, ItKeepsTheModeAndANewOneFollowsTheUmask) {
  const mode_t before = ::umask(027);
  expect_written(file_);
  EXPECT_EQ(mode_of(file_), 0640u);
  ::chmod(file_.c_str(), 0600);
  ::umask(0);
  expect_written(file_);
  EXPECT_EQ(mode_of(file_), 0600u);
  ::umask(before);
}

TEST_F(OutputFiles, APipeIsWrittenAsItIs) {
  ASSERT_EQ(::mkfifo(file_.c_str(), 0600), 0);
  const int pipe = ::open(file_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(pipe, 0);
  EXPECT_TRUE(write_bytes(file_, some(100, 3), error_)) << error_;
  EXPECT_TRUE(fs::is_fifo(file_));
  char read[200];
  EXPECT_EQ(::read(pipe, read, sizeof read), 100);
  ::close(pipe);
  EXPECT_EQ(folder_.names(), Words{"a"});
}

TEST_F(OutputFiles, ADeviceIsWrittenAsItIs) {
  const int null =
      ::mknod(file_.c_str(), S_IFCHR | 0600, ::makedev(1, 3)) == 0 ? ::open(file_.c_str(), O_WRONLY | O_CLOEXEC) : -1;
  if (null < 0) GTEST_SKIP() << "may make no device that can be opened";
  ::close(null);
  EXPECT_TRUE(write_state(file_, some(100, 3), error_)) << error_;
  EXPECT_TRUE(fs::is_character_file(file_));
  EXPECT_EQ(folder_.names(), Words{"a"});
}

TEST_F(OutputFiles, TwoProcessesDisturbNeitherEachOtherNorWhoReads) {
  constexpr int kWrites = 100;
  constexpr std::size_t kBytes = 1 << 17;
  expect_written(file_);
  const auto work = [&](int value) {
    int wrong = 0;
    const Bytes mine = some(kBytes, value);
    for (int k = 0; k < kWrites; ++k) {
      Bytes read;
      wrong += !write_bytes(file_, mine, error_);
      wrong +=
          !read_bytes(file_, read, error_) || read.size() != kBytes || read != some(kBytes, static_cast<int>(read[0]));
    }
    return std::min(wrong, 254);
  };
  EXPECT_EQ(in_child([&] {
              const pid_t other = ::fork();
              if (other == 0) ::_exit(work(1));
              int status = 0;
              const int wrong = work(2);
              ::waitpid(other, &status, 0);
              return std::min(wrong + (WIFEXITED(status) ? WEXITSTATUS(status) : 254), 254);
            }),
            0);
  EXPECT_EQ(folder_.names(), Words{"a"});
}

TEST_F(OutputFiles, OneThatFailsLeavesTheOldOneAndNothingElse) {
  folder_.write("a", "old");
  EXPECT_EQ(in_child([&] {
              std::signal(SIGXFSZ, SIG_IGN);
              const rlimit limit{1 << 16, 1 << 16};
              ::setrlimit(RLIMIT_FSIZE, &limit);
              return write_bytes(file_, some(1 << 18, 1), error_) ? 1 : error_ == file_ + ": File too large" ? 0 : 2;
            }),
            0);
  EXPECT_EQ(read_file(file_), "old");
  EXPECT_FALSE(write_bytes(folder_.file(""), some(1, 1), error_));
  EXPECT_EQ(error_, folder_.file("") + ": Is a directory");
  EXPECT_EQ(folder_.names(), Words{"a"});
}

TEST_F(OutputFiles, OneThatTheCallerMayNotWriteIsRefused) {
  folder_.write("a", "old");
  ::chmod(file_.c_str(), 0444);
  ::chmod(folder_.file("").c_str(), 0777);
  EXPECT_EQ(in_child([&] {
              if (::geteuid() == 0 && ::setuid(65534) != 0) return 3;
              return write_bytes(file_, some(10, 1), error_) ? 1 : error_ == file_ + ": Permission denied" ? 0 : 2;
            }),
            0);
  EXPECT_EQ(read_file(file_), "old");
  EXPECT_EQ(folder_.names(), Words{"a"});
}

// There is no /proc then, through which a nameless file gets its name.
TEST_F(OutputFiles, ItNeedsNoNamelessFiles) {
  folder_.write("a", "old");
  ::chmod(file_.c_str(), 0604);
  folder_.write("b.part", "mine");
  const int result = in_child([&] {
    if (::chroot(folder_.file("").c_str()) != 0 || ::chdir("/") != 0) return 3;
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{1 << 16, 1 << 16};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    if (!write_bytes("a", some(1000, 1), error_) || !write_bytes("b", some(1000, 1), error_)) return 1;
    return write_bytes("b", some(1 << 18, 2), error_) ? 2 : 0;
  });
  if (result == 3) GTEST_SKIP() << "may not change the root";
  EXPECT_EQ(result, 0);
  EXPECT_EQ(read_file(file_), std::string(1000, '\1'));
  EXPECT_EQ(read_file(folder_.file("b")), std::string(1000, '\1'));
  EXPECT_EQ(mode_of(file_), 0604u);
  EXPECT_EQ(folder_.names(), (Words{"a", "b", "b.part"}));
}

TEST_F(OutputFiles, DevicesAndFoldersAreNotReadPipesAre) {
  Bytes read;
  EXPECT_FALSE(read_bytes("/dev/null", read, error_));
  EXPECT_EQ(error_, "/dev/null: is a device; a file or a pipe is read");
  EXPECT_FALSE(read_state(folder_.file(""), read, error_));
  EXPECT_EQ(error_, folder_.file("") + ": Is a directory");
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  ASSERT_EQ(::write(ends[1], "psim", 4), 4);
  ::close(ends[1]);
  EXPECT_TRUE(read_bytes("/dev/fd/" + std::to_string(ends[0]), read, error_)) << error_;
  EXPECT_EQ(read.size(), 4u);
  ::close(ends[0]);
  const Bytes large = some((3 << 20) + 17, 9);
  ASSERT_TRUE(write_bytes(file_, large, error_)) << error_;
  ASSERT_TRUE(read_bytes(file_, read, error_)) << error_;
  EXPECT_EQ(read, large);
}

}  // namespace
}  // namespace psim::test
