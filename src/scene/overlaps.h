// Which discs and segments of a scene overlap before it has run. O(n log n) for n discs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "psim/types.h"

namespace psim {

/// A disc of the scene and whose it is: `owner` counts bodies, then groups.
struct PlacedDisc {
  double x = 0, y = 0, radius = 0;
  std::uint32_t owner = 0;
  std::uint32_t place = 0;  ///< in its group
  bool moves = false;
};

struct PlacedSegment {
  Vec2 p, q;
  std::uint32_t owner = 0;
};

/// The deepest overlap, and how many there are. Two bodies of which none moves never count.
struct Overlaps {
  std::size_t count = 0;
  double depth = 0;       ///< metres, of the deepest
  std::size_t disc = 0;   ///< index of its disc
  std::size_t other = 0;  ///< index of the other disc or segment
  bool other_is_segment = false;
};

/// `tolerance`: depth up to this is no overlap, m.
Overlaps find_overlaps(const std::vector<PlacedDisc>& discs,
                       const std::vector<PlacedSegment>& segments, double tolerance);

}  // namespace psim
