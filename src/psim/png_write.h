// Writes an 8-bit RGB picture as PNG.
#pragma once

#include <cstdint>
#include <span>

#include "atomic_file.h"

namespace psim::cli {

/// `rgb` holds height rows from the top, 3 * width bytes each. Level 1 of libdeflate without filters: about
/// 10 ns a pixel of a crowded picture.
void write_png(AtomicFile& file, int width, int height, std::span<const std::uint8_t> rgb);

}  // namespace psim::cli
