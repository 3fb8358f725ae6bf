// What a body is made of, as parts that make such a body again. Fixed bodies are told from their pieces, moving ones from
// their hulls. O(parts).
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "psim/desc.h"
#include "query/observed.h"

namespace psim {

/// The pieces of a static body: a run of numbers in StaticShapes.
struct PieceRun {
  std::uint32_t first = 0, end = 0;
};
PieceRun pieces_of(const Observed& world, std::uint32_t id);
/// From the place of a body to a point, m: to its nearest copy in a periodic world.
Vec2 way_from(const Observed& world, const BodyState& body, const LatticePoint& point);

/// The parts of a body in its own frame. Each has its first point as its position, a disc its centre, and no angle. Segments
/// that follow one another, of one part of a static body or of a kinematic one, are a chain.
std::vector<ShapePart> parts_of(const Observed& world, std::uint32_t id);

/// Calls each(point, radius) for the corners of a part that was told.
template <class Each>
void each_point(const ShapePart& part, const Each& each) {
  if (const auto* disc = std::get_if<DiscShape>(&part.shape)) each(part.position, disc->radius);
  if (const auto* line = std::get_if<SegmentShape>(&part.shape)) {
    for (const Vec2 p : {line->p1, line->p2}) each(part.position + p, 0.0);
  }
  if (const auto* capsule = std::get_if<CapsuleShape>(&part.shape)) {
    for (const Vec2 p : {capsule->p1, capsule->p2}) each(part.position + p, capsule->radius);
  }
  if (const auto* chain = std::get_if<ChainShape>(&part.shape)) {
    for (const Vec2 p : chain->vertices) each(part.position + p, 0.0);
  }
  if (const auto* polygon = std::get_if<PolygonShape>(&part.shape)) {
    for (const Vec2 p : polygon->vertices) each(part.position + p, polygon->radius);
  }
}

}  // namespace psim
