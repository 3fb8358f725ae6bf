#include "pixel_packer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>

namespace psim::cli {
namespace {

constexpr int kHashBits = 15;
constexpr std::size_t kPixel = 3, kLongest = 258, kFarthest = 32768, kEnd = 256;

// A token is a pixel, a byte, or a repeat: length << 16 | distance.
constexpr std::uint32_t kIsPixel = 1u << 31, kIsByte = 1u << 30, kPixelMask = 0xFFFFFF;

// A number as deflate writes it: a symbol, and bits that say how much more than the symbol's least.
struct Part {
  std::uint16_t symbol;
  std::uint16_t extra_bits;
  std::uint32_t extra;
};

// Symbols from `first` on, four or two (1 << fine) a power of two.
Part part_of(std::uint32_t number, std::uint32_t fine) {
  if (number < 2u << fine) return {static_cast<std::uint16_t>(number), 0, 0};
  const auto bits = static_cast<std::uint32_t>(std::bit_width(number)) - 1 - fine;
  return {static_cast<std::uint16_t>((bits << fine) + (number >> bits)), static_cast<std::uint16_t>(bits),
          number & ((1u << bits) - 1)};
}

Part distance_part(std::uint32_t distance) { return part_of(distance - 1, 1); }

std::array<Part, kLongest + 1> make_length_parts() {
  std::array<Part, kLongest + 1> parts{};
  for (std::uint32_t length = 3; length < kLongest; ++length) {
    parts[length] = part_of(length - 3, 2);
    parts[length].symbol = static_cast<std::uint16_t>(parts[length].symbol + 257);
  }
  parts[kLongest] = {285, 0, 0};
  return parts;
}

const std::array<Part, kLongest + 1>& length_parts() {
  static const auto kParts = make_length_parts();
  return kParts;
}

std::uint64_t load8(const std::uint8_t* at) {
  std::uint64_t value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

// Equal bytes at a and b, `known` of them known, `most` looked at.
std::size_t equal_bytes(const std::uint8_t* a, const std::uint8_t* b, std::size_t known, std::size_t most) {
  std::size_t n = known;
  for (; n + 8 <= most; n += 8) {
    const std::uint64_t differ = load8(a + n) ^ load8(b + n);
    if (differ != 0) return n + static_cast<std::size_t>(std::countr_zero(differ)) / 8;
  }
  while (n < most && a[n] == b[n]) ++n;
  return n;
}

class BitWriter {
 public:
  explicit BitWriter(char* out) : at_(out) {}
  /// At most 57 bits between two calls of flush().
  void add(std::uint64_t bits, unsigned count) {
    bits_ |= bits << count_;
    count_ += count;
  }
  void add(PrefixCode code) { add(code.bits, code.length); }
  /// Writes 8 bytes, of which those that are whole stay.
  void flush() {
    std::memcpy(at_, &bits_, 8);
    at_ += count_ / 8;
    bits_ >>= count_ & ~7u;
    count_ &= 7;
  }
  void fill_byte() {
    count_ = (count_ + 7) & ~7u;
    flush();
  }
  char* at() const { return at_; }

 private:
  char* at_;
  std::uint64_t bits_ = 0;
  unsigned count_ = 0;
};

// The lengths of both codes, runs of zeros as one symbol (RFC 1951, 3.2.7).
void write_codes(BitWriter& out, std::span<const PrefixCode> symbols, std::span<const PrefixCode> distances) {
  constexpr std::uint32_t kShortRun = 17, kLongRun = 18;
  constexpr std::array<std::size_t, 19> kOrder = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
  std::vector<std::uint16_t> lengths;
  for (const PrefixCode& c : symbols) lengths.push_back(c.length);
  for (const PrefixCode& c : distances) lengths.push_back(c.length);
  std::vector<Part> parts;
  for (std::size_t i = 0; i < lengths.size();) {
    std::size_t zeros = 0;
    while (i + zeros < lengths.size() && zeros < 138 && lengths[i + zeros] == 0) ++zeros;
    if (zeros < 3) {
      parts.push_back({lengths[i++], 0, 0});
      continue;
    }
    const bool is_long = zeros > 10;
    parts.push_back({static_cast<std::uint16_t>(is_long ? kLongRun : kShortRun),
                     static_cast<std::uint16_t>(is_long ? 7 : 3),
                     static_cast<std::uint32_t>(zeros - (is_long ? 11 : 3))});
    i += zeros;
  }
  std::array<std::uint32_t, kOrder.size()> counts{};
  for (const Part& part : parts) ++counts[part.symbol];
  std::array<PrefixCode, kOrder.size()> code;
  make_code(counts, 7, code);
  out.add(symbols.size() - 257, 5);
  out.add(distances.size() - 1, 5);
  out.add(kOrder.size() - 4, 4);
  for (const std::size_t symbol : kOrder) {
    out.flush();
    out.add(code[symbol].length, 3);
  }
  for (const Part& part : parts) {
    out.flush();
    out.add(code[part.symbol]);
    out.add(part.extra, part.extra_bits);
  }
  out.flush();
}

}  // namespace

PixelPacker::PixelPacker()
    : seen_(std::size_t{1} << kHashBits), counts_(kSymbols), distance_counts_(kDistances) {}

void PixelPacker::pack(const std::vector<std::uint8_t>& rows, std::size_t row_bytes, bool last, std::string& out) {
  find_repeats(rows.data(), rows.size() - kSpare, row_bytes);
  write(last, out);
}

void PixelPacker::find_repeats(const std::uint8_t* rows, std::size_t size, std::size_t row_bytes) {
  constexpr std::size_t kTwoPixels = 2 * kPixel;
  const auto& lengths = length_parts();
  std::ranges::fill(seen_, 0u);
  std::ranges::fill(counts_, 0u);
  std::ranges::fill(distance_counts_, 0u);
  if (tokens_.size() < size / 2 + 2) tokens_.resize(size / 2 + 2);  // a row's filter byte and one pixel: two of 4 bytes
  std::uint32_t* token = tokens_.data();
  std::size_t row_end = 0;
  for (std::size_t at = 0; at < size;) {
    if (at == row_end) {
      ++counts_[rows[at]];
      *token++ = kIsByte | rows[at++];
      row_end += row_bytes;
      continue;
    }
    const std::uint64_t here = load8(rows + at);
    const std::size_t most = std::min(kLongest, size - at);
    std::size_t length = 0, distance = 0;
    if (at > kPixel && ((here ^ load8(rows + at - kPixel)) << 16) == 0 && most >= kTwoPixels) {
      distance = kPixel;
    } else {
      std::uint32_t& seen = seen_[(here << 16) * 0x9E3779B97F4A7C15u >> (64 - kHashBits)];
      const std::size_t before = seen;
      seen = static_cast<std::uint32_t>(at);
      const bool is_same = before != 0 && ((here ^ load8(rows + before)) << 16) == 0;
      if (is_same && at - before <= kFarthest && most >= kTwoPixels) distance = at - before;
    }
    if (distance == 0) {
      const auto pixel = static_cast<std::uint32_t>(here & kPixelMask);
      ++counts_[pixel & 0xFF];
      ++counts_[pixel >> 8 & 0xFF];
      ++counts_[pixel >> 16];
      *token++ = kIsPixel | pixel;
      at += kPixel;
      continue;
    }
    length = equal_bytes(rows + at, rows + at - distance, kTwoPixels, most);
    std::size_t in_row = at + length + row_bytes - row_end;
    if (in_row > row_bytes) in_row %= row_bytes;
    if (in_row > 0) length -= (in_row - 1) % kPixel;
    ++counts_[lengths[length].symbol];
    ++distance_counts_[distance_part(static_cast<std::uint32_t>(distance)).symbol];
    *token++ = static_cast<std::uint32_t>(length << 16 | distance);
    at += length;
    while (at > row_end) row_end += row_bytes;
  }
  counts_[kEnd] = 1;
  token_count_ = static_cast<std::size_t>(token - tokens_.data());
}

void PixelPacker::write(bool last, std::string& out) const {
  constexpr int kLongestCode = 15;
  const auto& lengths = length_parts();
  std::array<PrefixCode, kSymbols> code;
  std::array<PrefixCode, kDistances> distance_code;
  make_code(counts_, kLongestCode, code);
  make_code(distance_counts_, kLongestCode, distance_code);
  std::uint64_t bits = 0;
  constexpr std::uint64_t kMostExtra = 13;  // bits beside a length's or a distance's code
  for (std::size_t s = 0; s < kSymbols; ++s) bits += counts_[s] * (code[s].length + (s > kEnd ? kMostExtra : 0));
  for (std::size_t s = 0; s < kDistances; ++s) bits += distance_counts_[s] * (distance_code[s].length + kMostExtra);
  constexpr std::size_t kHeadAndTail = 512;
  out.resize(bits / 8 + kHeadAndTail);

  BitWriter writer(out.data());
  writer.add(last ? 1 : 0, 1);
  writer.add(2, 2);  // with codes of its own
  write_codes(writer, code, distance_code);
  for (const std::uint32_t token : std::span(tokens_.data(), token_count_)) {
    if (token & kIsPixel) {
      writer.add(code[token & 0xFF]);
      writer.add(code[token >> 8 & 0xFF]);
      writer.add(code[token >> 16 & 0xFF]);
    } else if (token & kIsByte) {
      writer.add(code[token & 0xFF]);
    } else {
      const Part length = lengths[token >> 16], distance = distance_part(token & 0xFFFF);
      writer.add(code[length.symbol]);
      writer.add(length.extra, length.extra_bits);
      writer.add(distance_code[distance.symbol]);
      writer.add(distance.extra, distance.extra_bits);
    }
    writer.flush();
  }
  writer.add(code[kEnd]);
  if (!last) {  // an empty block of plain bytes: the next part begins on a whole byte
    writer.add(0, 3);
    writer.fill_byte();
    writer.add(0xFFFF0000u, 32);
  }
  writer.fill_byte();
  out.resize(static_cast<std::size_t>(writer.at() - out.data()));
}

}  // namespace psim::cli
