// Tables that move the chosen lanes of a register to its front, by mask. Plain arrays: members of
// std::array would leave weak symbols in unoptimised builds (docs/kernels.md).
#pragma once

#include <cstdint>

namespace psim::kernels {
namespace {

struct Compact8 {
  std::uint8_t lane[256][8];  // the chosen lane numbers, then lane 0s
  std::uint8_t count[256];    // how many were chosen
};

constexpr Compact8 make_compact8() {
  Compact8 table{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    unsigned to = 0;
    for (unsigned lane = 0; lane < 8; ++lane) {
      if (mask >> lane & 1u) table.lane[mask][to++] = static_cast<std::uint8_t>(lane);
    }
    table.count[mask] = static_cast<std::uint8_t>(to);
  }
  return table;
}

struct Compact4 {
  std::uint8_t byte[16][16];  // byte shuffle control that packs the chosen 32-bit lanes
  std::uint8_t count[16];
};

constexpr Compact4 make_compact4() {
  Compact4 table{};
  for (unsigned mask = 0; mask < 16; ++mask) {
    unsigned to = 0;
    for (unsigned lane = 0; lane < 4; ++lane) {
      if ((mask >> lane & 1u) == 0) continue;
      for (unsigned byte = 0; byte < 4; ++byte) {
        table.byte[mask][4 * to + byte] = static_cast<std::uint8_t>(4 * lane + byte);
      }
      ++to;
    }
    table.count[mask] = static_cast<std::uint8_t>(to);
  }
  return table;
}

}  // namespace
}  // namespace psim::kernels
