// The bodies of a world as circles and polygons, for a host that draws them.
//
// In: the grids of QueryIndex. Out: calls of DebugDraw, ordered by id, then part. O(bodies), or those near the region.
#pragma once

#include "psim/debug_draw.h"
#include "query/query_index.h"

namespace psim {

void draw_bodies(const QueryIndex& index, const Observed& world, const std::optional<Bounds>& region, DebugDraw& to);

}  // namespace psim
