// psim diff: where do two files, or two ways to run a scene, part?
#pragma once

#include "options/options.h"

namespace psim::cli {

/// Compares options.files, or else options.sides, frame by frame to the end. Prints the first
/// difference (frame, stage where two settings ran, body, field, both numbers and their bits) and
/// totals. Returns 1 if anything differs or if the comparison was interrupted, else 0. Throws
/// UserError if the two cannot be compared.
int diff(const Options& options);

}  // namespace psim::cli
