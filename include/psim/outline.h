// Outlines: simple polygons, concave ones too, as the parts of a body.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "psim/api.h"
#include "psim/desc.h"

namespace psim {

/// Of an outline.
inline constexpr std::size_t kMostOutlineVertices = 10'000;

/// Cuts a simple polygon, concave or not, into convex polygons: the parts of a CompoundShape. Either way round; the last
/// vertex is joined to the first. A vertex that repeats the one before it, to 1e-10 of the way to the next one, or where
/// the outline turns by less than 1e-6 of a radian, is left out. A convex outline of at most kMostPolygonVertices becomes
/// one part in its own frame; of several, each has its first vertex as `position`, so that a large static outline is as
/// precise as a small one. Cuts lead from vertex to vertex; where that leaves too thin parts, long edges get vertices of
/// their own.
///
/// `radius`, metres, >= 0, rounds each part, which together are the rounded outline. Near the cuts roundings overlap, and
/// the body's mass counts them with each part (BodyDesc::mass wins over it).
///
/// No parts, and a line in `error`, for fewer than 3 vertices or more than kMostOutlineVertices, numbers out of their
/// ranges (psim/limits.h), no area, an outline that crosses or touches itself, or is so thin that a part would be no
/// PolygonShape. The same bits on all platforms. The time grows with the square of the vertices, about 0.1 to 0.3 s for
/// 10,000.
PSIM_API std::vector<ShapePart> cut_outline(std::span<const Vec2> vertices, double radius, std::string& error);

}  // namespace psim
