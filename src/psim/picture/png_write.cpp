#include "picture/png_write.h"

#include <zlib.h>

#include <algorithm>
#include <initializer_list>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "picture/parallel.h"

namespace psim::cli {
namespace {

constexpr std::size_t kPartBytes = 1 << 18;  // docs/pictures.md
constexpr std::uint8_t kNoFilter = 0;
constexpr int kLevel = 1;                // zlib's fastest
constexpr std::size_t kFlushBytes = 16;  // what a full flush adds at most

std::uint32_t crc_after(std::uint32_t sum, std::string_view text) {
  return static_cast<std::uint32_t>(crc32_z(sum, reinterpret_cast<const Bytef*>(text.data()), text.size()));
}

std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(number >> shift & 0xFF));
  return bytes;
}

// Length, type, data, checksum of type and data (PNG specification, 5.3).
template <class Pieces>
void write_chunk(AtomicFile& file, std::string_view type, const Pieces& pieces) {
  std::uint32_t sum = crc_after(0, type);
  std::size_t size = 0;
  for (const std::string_view piece : pieces) {
    size += piece.size();
    sum = crc_after(sum, piece);
  }
  file.write(big_endian(static_cast<std::uint32_t>(size)));
  file.write(type);
  for (const std::string_view piece : pieces) file.write(piece);
  file.write(big_endian(sum));
}

struct Worker {
  std::vector<std::uint8_t> rows;

  /// The rows as whole bytes of deflate that follow those of the part before; with `last` the data end.
  std::string packed(bool last) {
    z_stream stream{};
    if (deflateInit2(&stream, kLevel, Z_DEFLATED, -MAX_WBITS, MAX_MEM_LEVEL, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();  // the settings are right
    std::string bytes(deflateBound(&stream, static_cast<uLong>(rows.size())) + kFlushBytes, '\0');
    stream.next_in = rows.data();
    stream.avail_in = static_cast<uInt>(rows.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<uInt>(bytes.size());
    deflate(&stream, last ? Z_FINISH : Z_FULL_FLUSH);
    bytes.resize(stream.total_out);
    deflateEnd(&stream);
    return bytes;
  }
};

std::vector<std::string> packed(std::size_t width, std::size_t height, std::span<const std::uint8_t> rgb, int threads) {
  const std::size_t row = 3 * width, row_bytes = row + 1;
  const std::size_t part_rows = std::max<std::size_t>(1, kPartBytes / row_bytes);
  std::vector<std::string> parts((height + part_rows - 1) / part_rows);
  std::vector<Worker> workers(std::min<std::size_t>(static_cast<std::size_t>(threads), parts.size()));
  share_out(parts.size(), threads, [&](std::size_t number, std::size_t by) {
    std::vector<std::uint8_t>& rows = workers[by].rows;
    const std::size_t first = number * part_rows, count = std::min(part_rows, height - first);
    rows.resize(count * row_bytes);
    for (std::size_t y = 0; y < count; ++y) {
      rows[y * row_bytes] = kNoFilter;
      std::copy_n(rgb.data() + (first + y) * row, row, rows.data() + y * row_bytes + 1);
    }
    parts[number] = workers[by].packed(number + 1 == parts.size());
  });
  return parts;
}

std::uint32_t adler_of_rows(std::size_t width, std::span<const std::uint8_t> rgb) {
  uLong sum = 1;
  for (std::size_t at = 0; at < rgb.size(); at += 3 * width) {
    sum = adler32_z(sum, &kNoFilter, 1);
    sum = adler32_z(sum, rgb.data() + at, 3 * width);
  }
  return static_cast<std::uint32_t>(sum);
}

}  // namespace

void write_png(AtomicFile& file, int width, int height, std::span<const std::uint8_t> rgb, int threads) {
  using namespace std::string_view_literals;
  using Pieces = std::initializer_list<std::string_view>;
  const auto w = static_cast<std::uint32_t>(width), h = static_cast<std::uint32_t>(height);
  const std::vector<std::string> parts = packed(w, h, rgb, threads);
  const std::string sum = big_endian(adler_of_rows(w, rgb));
  std::vector<std::string_view> data = {"\x78\x01"sv};  // deflate, 32 KiB, quickly (RFC 1950, 2.2)
  data.insert(data.end(), parts.begin(), parts.end());
  data.push_back(sum);
  file.write("\x89PNG\r\n\x1a\n"sv);
  constexpr std::string_view kFormat = "\x08\x02\0\0\0"sv;  // 8 bits, RGB, deflate, filters, no interlace
  const std::string head = big_endian(w) + big_endian(h) + std::string(kFormat);
  write_chunk(file, "IHDR", Pieces{head});
  write_chunk(file, "sRGB", Pieces{"\0"sv});  // perceptual
  write_chunk(file, "IDAT", data);
  write_chunk(file, "IEND", Pieces{});
}

}  // namespace psim::cli
