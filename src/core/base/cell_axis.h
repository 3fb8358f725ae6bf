// Cells of one width along an axis of the lattice, by integers alone: place x lies in cell (x - low) per / 2^32.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/lattice.h"

namespace psim {

struct CellRange {
  std::uint64_t first = 0, end = 0;
  std::uint64_t size() const { return end - first; }
};

struct CellAxis {
  std::int32_t low = 0;   ///< lattice coordinate where cell 0 begins
  std::uint64_t per = 0;  ///< cells in 2^32 lattice steps
  std::uint64_t cells = 0;
  double width = 1;  ///< lattice steps a cell

  std::uint64_t at(std::int32_t place) const {
    return (std::uint64_t{static_cast<std::uint32_t>(wrap_sub(place, low))} * per) >> 32;
  }

  /// The cells within `half` steps of a place, and one step more, because distances are rounded: one run, or two where
  /// the axis wraps around.
  std::array<CellRange, 2> around(std::int32_t place, double half, bool wraps) const {
    const double here = static_cast<std::uint32_t>(wrap_sub(place, low));
    const double from = std::floor(here - half) - 1, to = std::ceil(here + half) + 1;
    const auto cell = [this](double steps) {
      const auto k = static_cast<std::uint64_t>(std::clamp(steps, 0.0, 0x1p32 - 1));
      return std::min((k * per) >> 32, cells - 1);
    };
    if (wraps && to - from + 2 * width >= 0x1p32) return {CellRange{0, cells}, CellRange{}};
    if (wraps && from < 0) return {CellRange{0, cell(to) + 1}, CellRange{cell(from + 0x1p32), cells}};
    if (wraps && to >= 0x1p32) return {CellRange{0, cell(to - 0x1p32) + 1}, CellRange{cell(from), cells}};
    return {CellRange{cell(from), cell(to) + 1}, CellRange{}};
  }
};

}  // namespace psim
