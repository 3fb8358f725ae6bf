// Three tables about one scene: time by particle count, by threads, by instruction set.
#pragma once

#include "options/options.h"

namespace psim::cli {

/// Prints each row as soon as it is measured. Returns the exit status.
int benchmark_scene(const Options& options);

}  // namespace psim::cli
