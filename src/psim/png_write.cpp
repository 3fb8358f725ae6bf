#include "png_write.h"

#include <libdeflate.h>

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "parallel.h"
#include "pixel_packer.h"

namespace psim::cli {
namespace {

constexpr std::size_t kPartBytes = 1 << 18;  // docs/pictures.md

std::string big_endian(std::uint32_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(number >> shift & 0xFF));
  return bytes;
}

// Length, type, data, checksum of type and data (PNG specification, 5.3).
template <class Pieces>
void write_chunk(AtomicFile& file, std::string_view type, const Pieces& pieces) {
  std::uint32_t sum = libdeflate_crc32(0, type.data(), type.size());
  std::size_t size = 0;
  for (const std::string_view piece : pieces) {
    size += piece.size();
    sum = libdeflate_crc32(sum, piece.data(), piece.size());
  }
  file.write(big_endian(static_cast<std::uint32_t>(size)));
  file.write(type);
  for (const std::string_view piece : pieces) file.write(piece);
  file.write(big_endian(sum));
}

// Adler's checksum of one piece after another: a = 1 + sum of bytes, b = sum of all a (RFC 1950, 9).
std::uint32_t joined_adler(std::uint32_t first, std::uint32_t second, std::size_t size_of_second) {
  constexpr std::uint64_t kPrime = 65521;
  const std::uint64_t a1 = first & 0xFFFF, b1 = first >> 16, a2 = second & 0xFFFF, b2 = second >> 16;
  const std::uint64_t a = (a1 + a2 + kPrime - 1) % kPrime;
  const std::uint64_t b = (b1 + b2 + (a1 + kPrime - 1) * (size_of_second % kPrime)) % kPrime;
  return static_cast<std::uint32_t>(b << 16 | a);
}

struct Packed {
  std::string bytes;
  std::uint32_t adler = 1;
  std::size_t size = 0;  // before
};

struct Worker {
  std::vector<std::uint8_t> rows;
  PixelPacker packer;
};

std::vector<Packed> packed(std::size_t width, std::size_t height, std::span<const std::uint8_t> rgb, int threads) {
  constexpr std::uint8_t kNoFilter = 0;
  const std::size_t row = 3 * width, row_bytes = row + 1;
  const std::size_t part_rows = std::max<std::size_t>(1, kPartBytes / row_bytes);
  std::vector<Packed> parts((height + part_rows - 1) / part_rows);
  std::vector<Worker> workers(std::min<std::size_t>(static_cast<std::size_t>(threads), parts.size()));
  share_out(parts.size(), threads, [&](std::size_t number, std::size_t by) {
    auto& [rows, packer] = workers[by];
    Packed& part = parts[number];
    const std::size_t first = number * part_rows, count = std::min(part_rows, height - first);
    part.size = count * row_bytes;
    rows.resize(part.size + PixelPacker::kSpare);
    for (std::size_t y = 0; y < count; ++y) {
      rows[y * row_bytes] = kNoFilter;
      std::copy_n(rgb.data() + (first + y) * row, row, rows.data() + y * row_bytes + 1);
    }
    part.adler = libdeflate_adler32(1, rows.data(), part.size);
    packer.pack(rows, row_bytes, number + 1 == parts.size(), part.bytes);
  });
  return parts;
}

}  // namespace

void write_png(AtomicFile& file, int width, int height, std::span<const std::uint8_t> rgb, int threads) {
  using namespace std::string_view_literals;
  using Pieces = std::initializer_list<std::string_view>;
  const std::vector<Packed> parts =
      packed(static_cast<std::size_t>(width), static_cast<std::size_t>(height), rgb, threads);
  std::vector<std::string_view> data = {"\x78\x01"sv};  // deflate, 32 KiB, quickly (RFC 1950, 2.2)
  std::uint32_t adler = 1;
  for (const Packed& part : parts) {
    data.push_back(part.bytes);
    adler = joined_adler(adler, part.adler, part.size);
  }
  const std::string sum = big_endian(adler);
  data.push_back(sum);
  file.write("\x89PNG\r\n\x1a\n"sv);
  const std::string head = big_endian(static_cast<std::uint32_t>(width)) + big_endian(static_cast<std::uint32_t>(height)) +
                           std::string("\x08\x02\0\0\0"sv);  // 8 bits, RGB, deflate, filters, no interlace
  write_chunk(file, "IHDR", Pieces{head});
  write_chunk(file, "sRGB", Pieces{"\0"sv});  // perceptual
  write_chunk(file, "IDAT", data);
  write_chunk(file, "IEND", Pieces{});
}

}  // namespace psim::cli
