// psim, the command line. Data goes to stdout, talk to stderr. Exit status: 0 done, 1 a check
// failed, 2 the user has something to put right (one line says what).
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "options/about.h"
#include "options/options.h"
#include "os/console.h"
#include "output/user_error.h"
#include "run/benchmark.h"
#include "run/diff.h"
#include "run/replay.h"
#include "run/run.h"
#include "run/verify.h"

namespace psim::cli {
namespace {

int run_mode(const Options& options) {
  switch (options.mode) {
    case Mode::version:
      return print_version();
    case Mode::list_scenes:
      return print_scenes();
    case Mode::explain:
      return explain_scene(options);
    case Mode::check:
      return check_scene_file(options);
    case Mode::verify:
      return verify_scene(options);
    case Mode::benchmark:
      return benchmark_scene(options);
    case Mode::replay:
      return replay_recording(options);
    case Mode::diff:
      return diff(options);
    case Mode::run:
      break;
  }
  return run_scene(options);
}

}  // namespace
}  // namespace psim::cli

int main(int argc, char** argv) {
  constexpr int kUserErrorStatus = 2;
  try {
    const psim::os::Console console;
    const std::vector<std::string> words = psim::os::command_line(argc, argv);
    std::vector<const char*> utf8;
    utf8.reserve(words.size() + 1);
    for (const std::string& word : words) utf8.push_back(word.c_str());
    const auto options = psim::cli::parse_options(static_cast<int>(utf8.size()), utf8.data());
    if (!options) return 0;
    return psim::cli::run_mode(*options);
  } catch (const psim::cli::UserError& error) {
    fmt::print(stderr, "psim: {}\n", error.what());
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "psim: out of memory; a smaller scene or a larger machine would do\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "psim: {}\n", error.what());
  }
  return kUserErrorStatus;
}
