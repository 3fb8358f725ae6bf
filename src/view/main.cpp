// psim-view: a window on a running world. Exit status: 0 done, 2 the user has something to put
// right (one line says what).
#define SDL_MAIN_HANDLED
#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <optional>

#include "options/scene_choice.h"
#include "output/atomic_file.h"
#include "output/user_error.h"
#include "psim/version.h"
#include "window/view.h"

namespace psim::view {
namespace {

void print_times(const FrameTimes& t) {
  fmt::print(stderr,
             "psim-view: {} pictures, CPU p50 {:.2f} p99 {:.2f} ms (snapshot and lines {:.2f}, "
             "upload {:.2f}, panels {:.2f}), drawing by OpenGL p50 {:.2f} ms\n",
             t.all.count(), t.all.percentile(50), t.all.percentile(99), t.prepare.percentile(50),
             t.upload.percentile(50), t.panels.percentile(50), t.gl.percentile(50));
}

int run(const ViewOptions& options) {
  if (options.version) {
    fmt::print("psim-view {}\n", PSIM_VERSION_STRING);
    return 0;
  }
  if (!options.shot.empty()) cli::AtomicFile("--shot", options.shot);  // refused now, not at the end
  View view(options, std::make_unique<Simulation>(cli::choose_scene(options.settings), options.settings.isa,
                                                  options.settings.threads));
  view.run();
  if (options.stats) print_times(view.times());
  return 0;
}

}  // namespace
}  // namespace psim::view

int main(int argc, char** argv) {
  constexpr int kUserErrorStatus = 2;
  try {
    const auto options = psim::view::parse_view_options(argc, argv);
    return options ? psim::view::run(*options) : 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "psim-view: {}\n", error.what());
  }
  return kUserErrorStatus;
}
