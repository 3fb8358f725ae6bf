// What PNG files are packed with: zlib's format reads back what went in, whatever the pixels.
#include "../src/psim/pixel_packer.h"

#include <gtest/gtest.h>
#include <libdeflate.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace psim::cli {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Size {
  std::size_t width, rows;
};

std::string packed(PixelPacker& packer, const Bytes& rows, std::size_t row_bytes, bool last) {
  Bytes input = rows;
  input.resize(rows.size() + PixelPacker::kSpare, 0xAA);
  std::string out;
  packer.pack(input, row_bytes, last, out);
  return out;
}

Bytes unpacked(const std::string& data, std::size_t size) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> reader(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  Bytes out(size);
  std::size_t taken = 0, made = 0;
  const auto result =
      libdeflate_deflate_decompress_ex(reader.get(), data.data(), data.size(), out.data(), out.size(), &taken, &made);
  EXPECT_EQ(result, LIBDEFLATE_SUCCESS);
  EXPECT_EQ(taken, data.size());
  EXPECT_EQ(made, size);
  return out;
}

// Rows of a filter byte and pixels, each(pixel's number) of three bytes.
template <class Each>
Bytes picture(Size size, const Each& each) {
  Bytes rows;
  for (std::size_t y = 0; y < size.rows; ++y) {
    rows.push_back(0);
    for (std::size_t x = 0; x < size.width; ++x) {
      const std::uint32_t pixel = each(y * size.width + x);
      for (const int shift : {0, 8, 16}) rows.push_back(static_cast<std::uint8_t>(pixel >> shift));
    }
  }
  return rows;
}

std::size_t expect_back(const Bytes& rows, Size size) {
  PixelPacker packer;
  const std::size_t row_bytes = 3 * size.width + 1;
  const std::string one = packed(packer, rows, row_bytes, true);
  EXPECT_EQ(unpacked(one, rows.size()), rows) << size.width << " x " << size.rows;
  // In three parts of rows, by a packer that has packed another picture before.
  std::string parts;
  for (std::size_t part = 0; part < 3; ++part) {
    const std::size_t from = size.rows * part / 3, to = size.rows * (part + 1) / 3;
    if (from == to) continue;
    const auto at = [&](std::size_t row) { return rows.begin() + static_cast<std::ptrdiff_t>(row * row_bytes); };
    parts += packed(packer, Bytes(at(from), at(to)), row_bytes, part == 2);
  }
  EXPECT_EQ(unpacked(parts, rows.size()), rows) << size.width << " x " << size.rows;
  return one.size();
}

constexpr Size kSizes[] = {{1, 1}, {1, 500}, {2, 3}, {3, 90}, {16, 16}, {85, 40}, {86, 40}, {640, 30}, {8192, 10}};

TEST(PixelPacker, PlainPicturesComeBack) {
  for (const Size size : kSizes) {
    expect_back(picture(size, [](std::size_t) { return 0u; }), size);
    const std::size_t bytes = expect_back(picture(size, [](std::size_t) { return 0x3B2A19u; }), size);
    EXPECT_LT(bytes, 120 + size.width * size.rows / 20);
  }
}

TEST(PixelPacker, NoiseComesBackAndGrowsLittle) {
  std::mt19937 random(1);
  for (const Size size : kSizes) {
    const Bytes rows = picture(size, [&](std::size_t) { return static_cast<std::uint32_t>(random()); });
    EXPECT_LT(expect_back(rows, size), rows.size() + rows.size() / 100 + 400);
  }
}

TEST(PixelPacker, RepeatsOfEveryLengthAndDistanceComeBack) {
  std::mt19937 random(2);
  for (const Size size : kSizes) {
    for (const std::uint32_t period : {2u, 3u, 5u, 80u, 640u, 10922u, 10923u, 20000u}) {
      const Bytes alike = picture(size, [&](std::size_t k) {
        return static_cast<std::uint32_t>(k % period) * 2654435761u >> (random() % 40 == 0 ? 9 : 8);
      });
      expect_back(alike, size);
    }
  }
}

// Counts that grow as Fibonacci's numbers would give codes of more than 15 bits.
TEST(PixelPacker, CodesStayWithinFifteenBits) {
  std::vector<std::uint8_t> bytes;
  std::size_t a = 1, b = 1;
  for (std::uint8_t value = 0; value < 25; ++value) {
    bytes.insert(bytes.end(), a, value);
    b += a;
    a = b - a;
  }
  std::shuffle(bytes.begin(), bytes.end(), std::mt19937(3));
  const Size size{100, bytes.size() / 300};
  const auto pixel = [&](std::size_t k) {
    return static_cast<std::uint32_t>(bytes[3 * k] | bytes[3 * k + 1] << 8 | bytes[3 * k + 2] << 16);
  };
  expect_back(picture(size, pixel), size);
}

TEST(PixelPacker, CodesAreHuffmans) {
  const std::vector<std::uint32_t> counts = {5, 0, 9, 12, 13, 16, 45};
  std::vector<PrefixCode> code(counts.size());
  make_code(counts, 15, code);
  std::uint64_t bits = 0;
  for (std::size_t s = 0; s < counts.size(); ++s) bits += std::uint64_t{counts[s]} * code[s].length;
  EXPECT_EQ(bits, 224u);  // the textbook's example: 45 x 1 + 41 x 3 + 14 x 4
  EXPECT_EQ(code[1].length, 0);
  make_code(std::vector<std::uint32_t>{0, 0, 7}, 15, std::span(code).first(3));
  EXPECT_EQ(code[0].length + code[2].length, 2);  // two at least
}

}  // namespace
}  // namespace psim::cli
