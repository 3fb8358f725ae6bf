// What the user has to put right, as one line: main prints it after "psim: " and exits with 2.
#pragma once

#include <stdexcept>
#include <string>

namespace psim::cli {

struct UserError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace psim::cli
