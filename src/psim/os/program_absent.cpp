// Where no other program can be started, as in WebAssembly.
#include <system_error>

#include "os/program.h"

namespace psim::os {

bool can_start_programs() { return false; }

std::string find_program(std::string_view) { return {}; }

struct PipedProgram::Process {};

PipedProgram::PipedProgram(const std::vector<std::string>&, int) {
  throw std::system_error(std::make_error_code(std::errc::function_not_supported));
}
PipedProgram::~PipedProgram() = default;
bool PipedProgram::write(std::span<const std::uint8_t>) { return false; }
std::string PipedProgram::wait() { return "it never ran"; }

}  // namespace psim::os
