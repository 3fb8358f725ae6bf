// A picture of a scene at one moment, as PNG.
#pragma once

#include "options/picture_options.h"
#include "output/atomic_file.h"
#include "picture/moment.h"
#include "psim/scene.h"

namespace psim::cli {

/// Paints the bodies in the colours that the options choose (docs/pictures.md), segments and chains as lines,
/// joints as thin ones, the world's sides, and wells. Without a size the longer side has 1600 pixels;
/// without a view it shows the world's bounds, or the part that is in use if that is far smaller. The file does not
/// depend on the threads.
void write_image(AtomicFile& file, const Scene& scene, const Moment& moment, const PictureOptions& options,
                 int threads);

}  // namespace psim::cli
