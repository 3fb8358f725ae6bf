// Which bodies and segments of a scene overlap before it has run. O(n log n) for n bodies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "bodies/body_properties.h"
#include "bodies/hull.h"
#include "collide/collide.h"
#include "psim/desc.h"
#include "psim/types.h"

namespace psim {

/// A body of the scene and whose it is: `owner` counts bodies, then groups.
struct PlacedBody {
  double x = 0, y = 0, radius = 0;  ///< the circle that holds it
  std::uint32_t owner = 0;
  std::uint32_t place = 0;  ///< in its group
  std::uint32_t id = 0;
  bool moves = false;
  std::shared_ptr<const HullSet> hulls = nullptr;  ///< about its place; none: a disc
  Rotor turn = {};
  Filter filter = {};
  std::shared_ptr<const std::vector<PartProperties>> parts = nullptr;  ///< of a compound whose parts differ
};

struct PlacedSegment {
  Vec2 p, q;
  std::uint32_t owner = 0;  ///< a body: its id
  Filter filter = {};
};

/// The deepest overlap, and how many there are. Two bodies of which none moves never count.
struct Overlaps {
  std::size_t count = 0;
  double depth = 0;       ///< metres, of the deepest
  std::size_t body = 0;   ///< index of its body
  std::size_t other = 0;  ///< index of the other body or segment
  bool other_is_segment = false;
};

/// Whether joints let two bodies overlap, by id.
using MayOverlap = std::function<bool(std::uint32_t, std::uint32_t)>;

/// `tolerance`: depth up to this is no overlap, m.
Overlaps find_overlaps(const std::vector<PlacedBody>& bodies, const std::vector<PlacedSegment>& segments,
                       double tolerance, const MayOverlap& may_overlap);

}  // namespace psim
