// Runs that begin in a saved state, and recordings run again.
#pragma once

#include <memory>

#include "options/options.h"
#include "psim/world.h"

namespace psim::cli {

/// The world that --restore names. Throws UserError.
std::unique_ptr<World> restored_world(const Options& options);

/// Runs a recording and compares its hashes. 0: all the same, to the last state; 1: the first hash that differs is
/// named, or the run was interrupted. Throws UserError.
int replay_recording(const Options& options);

}  // namespace psim::cli
