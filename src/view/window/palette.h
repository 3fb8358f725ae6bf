// The colours of numbers, for the shaders.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace psim::view {

/// The middle and upper part of viridis, as in the pictures of psim: nine colours of three channels, 0 to 1.
inline std::array<float, 27> palette() {
  constexpr std::array<std::uint32_t, 9> kPalette = {0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884,
                                                     0x44bf70, 0x7ad151, 0xbddf26, 0xfde725};
  std::array<float, 27> channels{};
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const std::uint32_t rgb = kPalette[k / 3] >> (16 - 8 * (k % 3));
    channels[k] = static_cast<float>(rgb & 0xFF) / 255;
  }
  return channels;
}

}  // namespace psim::view
