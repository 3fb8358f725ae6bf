// Descriptions of worlds and bodies out of bytes.
#pragma once

#include <cstddef>

#include <array>
#include <bit>
#include <cstdint>

#include "byte_source.h"
#include "psim/psim.h"

namespace psim::fuzz {

// Bytes that follow from a place. Traits that worlds got later are drawn from them, so that inputs from before still make
// much the same worlds.
class Digits {
 public:
  explicit Digits(Vec2 place) {
    std::uint64_t seed = std::bit_cast<std::uint64_t>(place.x) * 0x9E3779B97F4A7C15u;
    seed ^= std::bit_cast<std::uint64_t>(place.y);
    for (std::uint8_t& byte : bytes_) {  // splitmix64 (Steele, Lea and Flood 2014)
      std::uint64_t z = (seed += 0x9E3779B97F4A7C15u);
      z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
      byte = static_cast<std::uint8_t>((z ^ (z >> 27)) * 0x94D049BB133111EBu >> 56);
    }
  }
  operator Bytes() const { return bytes_; }

 private:
  std::array<std::uint8_t, 64> bytes_;
};

inline constexpr double kHalf = 12;  // m: bodies are placed within, whatever the bounds

template <class T, std::size_t N>
T one_of(ByteSource& in, const T (&values)[N]) {
  return values[in.below(N)];
}

WorldDesc world(ByteSource& in);
Material material(ByteSource& in);
Shape shape(ByteSource& in);
Filter filter(ByteSource& in);
BodyDesc body(ByteSource& in);

}  // namespace psim::fuzz
