// Runs a scene on every ISA of this CPU with 1, 2 and as many threads as there are cores, and says
// whether all of them gave the same bits in every frame.
#pragma once

#include "options/options.h"

namespace psim::cli {

/// Prints a line a variant; returns 1 if any differs (naming the first frame, the stage, the body
/// and the bits) or if the check was interrupted, else 0.
int verify_scene(const Options& options);

}  // namespace psim::cli
