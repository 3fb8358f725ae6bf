// The command line of psim-view as a checked value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "options/options.h"

namespace psim::view {

struct ViewOptions {
  cli::Options settings;               ///< scene to sleep, as in psim
  std::string shot;                    ///< picture to write; empty: none
  std::string play;                    ///< input script; empty: none
  std::optional<std::uint64_t> after;  ///< frames after which to end
  int width = 1280, height = 800;      ///< pixels
  bool stats = false;                  ///< times on stderr at the end
  bool version = false;

  /// A step a picture, whatever the clock says: the same pictures in every run.
  bool lockstep() const { return !shot.empty() || !play.empty() || after; }
};

/// Nothing if --help was asked for and printed. Throws UserError.
std::optional<ViewOptions> parse_view_options(int argc, const char* const* argv);

}  // namespace psim::view
