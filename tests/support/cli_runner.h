// Starts the psim program the way a user does, and looks at what came out.
#pragma once

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "sanitized.h"
#include "scratch_folder.h"
#ifdef _WIN32
#include "process_windows.h"
#else
#include "process_posix.h"
#endif

namespace psim::test {

inline Outcome run_psim(std::vector<std::string> arguments) {
  return Process(PSIM_PROGRAM, std::move(arguments)).wait();
}

/// Sets a variable of the environment, which the programs that this process starts inherit.
inline void set_variable(const char* name, const std::string& value) {
#ifdef _WIN32
  ::_putenv_s(name, value.c_str());
#else
  ::setenv(name, value.c_str(), 1);
#endif
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
