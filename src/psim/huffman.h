// Prefix codes as deflate has them (RFC 1951, 3.2.2).
#pragma once

#include <cstdint>
#include <span>

namespace psim::cli {

struct PrefixCode {
  std::uint16_t bits = 0;   ///< the first bit of the code lowest: the order in which deflate writes
  std::uint16_t length = 0; ///< 0: the symbol does not occur
};

/// Huffman's code for symbols that occur this often, none longer than `longest` (at most 15) bits. At least two symbols
/// get a code, since readers differ about less. O(n log n).
void make_code(std::span<const std::uint32_t> counts, int longest, std::span<PrefixCode> code);

}  // namespace psim::cli
