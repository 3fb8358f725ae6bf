#include "same_rows.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace psim::cli {
namespace {

constexpr std::uint32_t kEnd = 256, kLongest = 285;  // symbols; the latter is a match of 258 bytes
constexpr std::size_t kLongestBytes = 258;

class Bits {
 public:
  void put(std::uint32_t value, int count) {
    waiting_ |= std::uint64_t{value} << held_;
    for (held_ += count; held_ >= 8; held_ -= 8, waiting_ >>= 8)
      bytes_.push_back(static_cast<char>(waiting_));
  }
  void fill_byte() {
    if (held_ > 0) put(0, 8 - held_);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
  std::uint64_t waiting_ = 0;
  int held_ = 0;
};

// A match of 3 to 257 bytes (RFC 1951, 3.2.5).
struct Length {
  std::uint32_t symbol = kLongest - 1, extra = 0;
  int extra_bits = 0;
};

Length length_of(std::size_t bytes) {
  const auto n = static_cast<std::uint32_t>(bytes - 3);
  if (n < 8) return {kEnd + 1 + n, 0, 0};
  const int extra = static_cast<int>(std::bit_width(n)) - 3;
  return {kEnd + 1 + 4 * static_cast<std::uint32_t>(extra) + (n >> extra), n & ((1u << extra) - 1),
          extra};
}

// Codes as their bits come. Of lengths: 0, 1, 3 and runs of zeros, two bits each.
void put_no_length(Bits& to) { to.put(0, 2); }
void put_length_1(Bits& to) { to.put(2, 2); }
void put_length_3(Bits& to) { to.put(1, 2); }
void put_no_lengths(Bits& to, std::uint32_t count) {
  constexpr std::uint32_t kLeast = 11, kMost = 138;
  while (count >= kLeast) {
    const std::uint32_t n = std::min(count, kMost);
    to.put(3, 2);
    to.put(n - kLeast, 7);
    count -= n;
  }
  for (; count > 0; --count) put_no_length(to);
}

// Symbols 0, 2, the end and `rest` have codes of three bits, the longest match one of one bit, and so has the one distance.
void put_codes(Bits& to, std::uint32_t rest) {
  to.put(29, 5);  // 286 symbols
  to.put(0, 5);   // 1 distance
  to.put(14, 4);  // 18 lengths of codes of lengths, in the order of RFC 1951, 3.2.7
  for (const int symbol : {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1}) {
    to.put(symbol == 18 || symbol == 0 || symbol == 3 || symbol == 1 ? 2 : 0, 3);
  }
  put_length_3(to);
  put_no_length(to);
  put_length_3(to);
  put_no_lengths(to, kEnd - 3);
  put_length_3(to);
  put_no_lengths(to, rest - kEnd - 1);
  put_length_3(to);
  put_no_lengths(to, kLongest - rest - 1);
  put_length_1(to);
  put_length_1(to);  // of the distance 1
}

}  // namespace

std::string pack_same_rows(std::size_t bytes, std::size_t rows, bool last) {
  const std::size_t matches = (bytes - 1) / kLongestBytes, left = (bytes - 1) % kLongestBytes;
  const Length rest = left >= 3 ? length_of(left) : Length{};
  const auto put_zero = [](Bits& to) { to.put(1, 3); };
  Bits out;
  out.put(last, 1);
  out.put(2, 2);  // codes of its own
  put_codes(out, rest.symbol);
  for (std::size_t y = 0; y < rows; ++y) {
    out.put(5, 3);  // the filter
    put_zero(out);
    for (std::size_t k = 0; k < matches; ++k) out.put(0, 2);
    if (left >= 3) {
      out.put(7, 3);
      out.put(rest.extra, rest.extra_bits);
      out.put(0, 1);
    } else {
      for (std::size_t k = 0; k < left; ++k) put_zero(out);
    }
  }
  out.put(3, 3);  // the end
  if (!last) {    // nothing, stored: what follows begins with a byte
    out.put(0, 3);
    out.fill_byte();
    out.put(0xFFFF0000u, 32);
  }
  out.fill_byte();
  return out.take();
}

std::uint32_t adler_of_same_rows(std::uint32_t sum, std::size_t bytes, std::size_t rows) {
  constexpr std::uint64_t kPrime = 65521;
  std::uint64_t low = sum & 0xFFFF, high = sum >> 16;
  for (std::size_t y = 0; y < rows; ++y) {
    low = (low + kUpFilter) % kPrime;
    high = (high + (bytes + 1) * low) % kPrime;
  }
  return static_cast<std::uint32_t>(high << 16 | low);
}

}  // namespace psim::cli
