// Writes an 8-bit RGB picture as PNG.
#pragma once

#include <cstdint>
#include <span>

#include "output/atomic_file.h"

namespace psim::cli {

/// `rgb` holds height rows from the top, 3 * width bytes each; less than 2^31 bytes in all. Without filters, packed in
/// parts of rows: the same file on any number of threads (and on any CPU that has SSE4.2; without, other bytes of the
/// same pixels).
void write_png(AtomicFile& file, int width, int height, std::span<const std::uint8_t> rgb, int threads = 1);

}  // namespace psim::cli
