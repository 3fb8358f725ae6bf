// Another program that reads its input from a pipe, such as ffmpeg.
//
// What it writes to stdout is lost, the last line of its stderr is kept. It has a process group of its own, so that
// Ctrl-C in a terminal reaches psim alone, which then ends the input.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace psim::os {

/// False where no other program can be started.
bool can_start_programs();

/// The path of a program that PATH has; empty if there is none.
std::string find_program(std::string_view name);

class PipedProgram {
 public:
  /// The number that `file` has in the other program, where descriptors are handed on; no number that psim uses.
  static constexpr int kFileOfProgram = 100;

  /// Starts words[0] with the other words as its arguments. Throws std::system_error.
  PipedProgram(const std::vector<std::string>& words, int file);
  /// Without wait(): the program is stopped.
  ~PipedProgram();
  PipedProgram(const PipedProgram&) = delete;
  PipedProgram& operator=(const PipedProgram&) = delete;

  /// Waits while the program is behind. False if it has ended.
  bool write(std::span<const std::uint8_t> bytes);

  /// Ends the input and waits for the program's end. Empty if all went well, or else the last line of its stderr, or
  /// how it ended if it said nothing.
  std::string wait();

 private:
  struct Process;
  std::unique_ptr<Process> process_;
};

/// The words as one command line of Windows, as CommandLineToArgvW and the C library read it back: backslashes count
/// double before a quote. There alone.
std::string quoted(const std::vector<std::string>& words);

/// The last line of a text that has something in it.
std::string_view last_line(std::string_view text);

}  // namespace psim::os
