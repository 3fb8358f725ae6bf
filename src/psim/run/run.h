// The run: scene, outputs, frames, report.
#pragma once

#include "options/options.h"

namespace psim::cli {

/// Runs the scene, writes the files and prints the report. Returns the exit status; throws
/// UserError before anything is written if the run cannot begin.
int run_scene(const Options& options);

}  // namespace psim::cli
