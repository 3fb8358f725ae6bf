// A picture of the final state.
#pragma once

#include "atomic_file.h"
#include "psim/scene.h"

namespace psim::cli {

/// Paints the bodies (colour = speed, dark for slow to bright for fast; static grey; sensors faint),
/// segments and chains as lines, joints as thin ones, the world's sides, and wells, and writes a PNG whose longer side has 1600
/// pixels. Shows the world's bounds, or the part that is in use if that is far smaller.
void write_image(AtomicFile& file, const Scene& scene, const PublishedState& state);

}  // namespace psim::cli
