// A program that a test starts, where there is posix_spawn and /proc.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "scratch_folder.h"

namespace psim::test {

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

}  // namespace psim::test
