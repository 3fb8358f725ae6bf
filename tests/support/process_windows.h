// A program that a test starts, on Windows. windows.h, which makes macros of common words, stays in the .cpp.
#pragma once

#include <string>
#include <vector>

#include "scratch_folder.h"

namespace psim::test {

/// Windows has no such signal. Tests send it to a Process alone, which then ends the program.
inline constexpr int SIGKILL = 9;

/// A program that is running.
class Process {
 public:
  Process(const std::string& program, std::vector<std::string> arguments);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// SIGKILL ends the program, any other number is Ctrl-Break.
  void signal(int number) const;

  /// Gives the program time to begin to listen; false if it ended before.
  bool waits_for(int number) const;

  Outcome wait();

 private:
  ScratchFolder scratch_;
  void* process_ = nullptr;
  unsigned long id_ = 0;
};

}  // namespace psim::test
