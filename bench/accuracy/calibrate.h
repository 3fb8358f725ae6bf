// The table behind psim --target-error and --target-ms: for each kind of scene, what substeps and
// integrators reach in a reference scene, and what they cost.
#pragma once

#include <string>

#include "engine.h"

namespace psim::accuracy {

/// Writes it as CSV when all is measured. Throws std::runtime_error if the file cannot be written.
void calibrate(const std::string& file, Effort effort);

}  // namespace psim::accuracy
