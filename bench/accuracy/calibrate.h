// The table behind psim --target-error and --target-ms: for each kind of scene, what substeps and
// integrators reach in a reference scene, and what they cost.
#pragma once

#include <string>

#include "engines/engine.h"

namespace psim::accuracy {

/// As CSV.
std::string calibrate(Effort effort);

}  // namespace psim::accuracy
