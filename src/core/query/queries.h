// Questions about a world: what a ray meets, what overlaps a shape or a rectangle, what is nearest to a point. The
// order of the answers follows from the bodies alone: neither slots nor threads show.
//
// In: the grids of QueryIndex, which the first question after a change makes. Geometry is in doubles, seen from the
// place of the question. In a periodic world every copy of a body counts: a ray is followed for at most one length of
// the world along each axis, and the nearest copy is met first.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "psim/query.h"
#include "query/query_index.h"

namespace psim {

struct Queries {
  const QueryIndex& index;
  const Observed world;

  std::optional<RayHit> ray_cast(Vec2 from, Vec2 to, const QueryFilter& filter) const;
  std::vector<RayHit> ray_cast_all(Vec2 from, Vec2 to, const QueryFilter& filter) const;
  /// On all threads of the pool, which is awake.
  std::size_t ray_cast_batch(std::span<const RayInput> rays, std::span<RayHit> hits, const QueryFilter& filter) const;
  std::optional<ShapeCastHit> shape_cast(const Shape& shape, Vec2 from, double angle, Vec2 translation, double rotation,
                                         const QueryFilter& filter) const;
  std::size_t nearby(const Shape& shape, Vec2 position, double angle, double reach, std::span<NearHit> found,
                     const QueryFilter& filter) const;
  std::vector<BodyId> overlap(const Shape& shape, Vec2 position, double angle, const QueryFilter& filter) const;
  std::vector<BodyId> in_region(const Bounds& region, const QueryFilter& filter) const;
  std::optional<ClosestHit> closest(Vec2 point, double reach, const QueryFilter& filter) const;
};

}  // namespace psim
