// Starts the psim program the way a user does, and looks at what came out.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "sanitized.h"

namespace psim::test {

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A folder of its own, gone with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "psim-test.XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string file(std::string_view name) const { return (path_ / name).string(); }
  std::string write(std::string_view name, std::string_view text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
  }
  /// Names of everything in it, sorted.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_)) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  std::filesystem::path path_;
};

struct Outcome {
  int status = -1;  ///< exit status, or minus the signal that ended it
  std::string out, err;
};

/// A program that is running.
class Process {
 public:
  Process(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    constexpr int kCreate = O_WRONLY | O_CREAT | O_TRUNC;
    const std::string out = scratch_.file("out"), err = scratch_.file("err");
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kCreate, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), kCreate, 0600);
    const int error = posix_spawn(&pid_, program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error(program + " does not start");
  }
  ~Process() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const { ::kill(pid_, number); }

  /// Waits until the program has its own handler for the signal; false if it ended before.
  bool waits_for(int number) const {
    for (int attempt = 0; attempt < 10'000; ++attempt) {
      for (const std::string& line : lines_of(read_file(proc_file("status")))) {
        if (line.starts_with("State:") && line.find('Z') != std::string::npos) return false;
        if (!line.starts_with("SigCgt:")) continue;
        const auto caught = std::strtoull(line.c_str() + 7, nullptr, 16);
        if ((caught >> (number - 1)) & 1) return true;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }

  Outcome wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    Outcome outcome;
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    outcome.out = read_file(scratch_.file("out"));
    outcome.err = read_file(scratch_.file("err"));
    return outcome;
  }

 private:
  std::string proc_file(std::string_view name) const {
    return "/proc/" + std::to_string(pid_) + "/" + std::string(name);
  }

  ScratchFolder scratch_;
  pid_t pid_ = -1;
};

inline Outcome run_psim(std::vector<std::string> arguments) {
  return Process(PSIM_PROGRAM, std::move(arguments)).wait();
}

/// What a user's mistake must look like: status 2, nothing on stdout, one line on stderr that
/// holds every one of `words`.
inline void expect_refused(const Outcome& outcome, const std::vector<std::string>& words) {
  EXPECT_EQ(outcome.status, 2) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_TRUE(outcome.err.starts_with("psim: ")) << outcome.err;
  EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
  for (const std::string& word : words) {
    EXPECT_NE(outcome.err.find(word), std::string::npos) << word << " is not in: " << outcome.err;
  }
}

/// Three discs over a floor, ids 1 to 3; the floor is 0.
inline constexpr std::string_view kSmallScene = R"({
  "psim": 1, "name": "small",
  "world": {"bounds": [-10, -10, 10, 10], "boundary": "open", "gravity": [0, -9.81]},
  "bodies": [
    {"type": "static", "shape": {"segment": {"p1": [-9, 0], "p2": [9, 0]}}, "position": [0, 0]},
    {"type": "dynamic", "shape": {"disc": {"radius": 0.5}}, "position": [0, 0.5]},
    {"type": "dynamic", "shape": {"disc": {"radius": 0.5}}, "position": [2, 3]},
    {"type": "dynamic", "shape": {"disc": {"radius": 0.5}}, "position": [-2, 3],
     "velocity": [1, 0]}]})";

}  // namespace psim::test
