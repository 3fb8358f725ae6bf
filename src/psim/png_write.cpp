#include "png_write.h"

#include <libdeflate.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "user_error.h"

namespace psim::cli {
namespace {

std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(number >> shift & 0xFF));
  return bytes;
}

// Length, type, data, checksum of type and data (PNG specification, 5.3).
void write_chunk(AtomicFile& file, std::string_view type, std::string_view data) {
  const std::uint32_t of_type = libdeflate_crc32(0, type.data(), type.size());
  file.write(big_endian(static_cast<std::uint32_t>(data.size())));
  file.write(type);
  file.write(data);
  file.write(big_endian(libdeflate_crc32(of_type, data.data(), data.size())));
}

std::vector<char> packed(const std::vector<std::uint8_t>& rows) {
  // Of those tried on pictures of discs the quickest; filters cost more than they save (docs/pictures.md).
  constexpr int kFastest = 1;
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kFastest), libdeflate_free_compressor);
  if (!compressor) throw UserError("PNG: out of memory");
  std::vector<char> out(libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  out.resize(libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(), out.data(), out.size()));
  return out;
}

}  // namespace

void write_png(AtomicFile& file, int width, int height, std::span<const std::uint8_t> rgb) {
  using namespace std::string_view_literals;
  constexpr std::uint8_t kNoFilter = 0;
  const std::size_t row = 3 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> rows(static_cast<std::size_t>(height) * (row + 1));
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    rows[y * (row + 1)] = kNoFilter;
    std::copy_n(rgb.data() + y * row, row, rows.data() + y * (row + 1) + 1);
  }
  const std::vector<char> pixels = packed(rows);
  file.write("\x89PNG\r\n\x1a\n"sv);
  write_chunk(file, "IHDR", big_endian(static_cast<std::uint32_t>(width)) + big_endian(static_cast<std::uint32_t>(height)) +
                                std::string("\x08\x02\0\0\0"sv));  // 8 bits, RGB, deflate, filters, no interlace
  write_chunk(file, "sRGB", "\0"sv);  // perceptual
  constexpr std::size_t kMost = std::size_t{1} << 30;  // of a chunk; 2^31 - 1 by the specification
  for (std::size_t at = 0; at < pixels.size(); at += kMost) {
    write_chunk(file, "IDAT", {pixels.data() + at, std::min(kMost, pixels.size() - at)});
  }
  write_chunk(file, "IEND", {});
}

}  // namespace psim::cli
