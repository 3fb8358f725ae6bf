// The terminal, the words of the command line and what the machine has to give.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace psim::os {

/// From construction to destruction: what the program writes is UTF-8, byte for byte as on any other system.
class Console {
 public:
  Console();
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

 private:
  unsigned code_page_ = 0;  // that the console had before, on Windows
};

/// The words of the command line in UTF-8, the program's name first.
std::vector<std::string> command_line(int argc, const char* const* argv);

bool stderr_is_terminal();

/// The memory that this process may still take: of the machine, of its control group, of its own limit.
std::uint64_t available_bytes();

/// How often this process touched a page of memory that the system had not given it yet; 0 where the system does not count.
std::uint64_t page_faults();

/// Why no file can be written into this folder, as errno has it; 0 if one can.
int folder_error(const std::string& folder);

}  // namespace psim::os
