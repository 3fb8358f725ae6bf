// Packs rows of pixels as deflate (RFC 1951), for PNG: a general compressor's fastest level spends most of its time on
// looking for what begins in the midst of a pixel (docs/pictures.md).
//
// Looked for are repetitions of the pixel before and, by a hash of two pixels, of what was there before; they end where a pixel
// ends. One Huffman code a part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "huffman.h"

namespace psim::cli {

class PixelPacker {
 public:
  PixelPacker();

  /// `rows` is whole rows of a filter byte and pixels of 3 bytes, `row_bytes` each, at most 2^24 bytes, and 8 bytes more that
  /// are not packed. Replaces `out` by whole bytes that follow those of the part before; with `last` the data end. Depends on
  /// nothing but its arguments. About 5 ns a pixel of a crowded picture.
  void pack(const std::vector<std::uint8_t>& rows, std::size_t row_bytes, bool last, std::string& out);

  static constexpr std::size_t kSpare = 8;

 private:
  static constexpr std::size_t kSymbols = 286, kDistances = 30;

  void find_repeats(const std::uint8_t* rows, std::size_t size, std::size_t row_bytes);
  void write(bool last, std::string& out) const;

  std::vector<std::uint32_t> seen_;    // by hash: where; 0 nowhere, there is a filter byte
  std::vector<std::uint32_t> tokens_;  // pixel_packer.cpp
  std::size_t token_count_ = 0;
  std::vector<std::uint32_t> counts_, distance_counts_;
};

}  // namespace psim::cli
