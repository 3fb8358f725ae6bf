// How static bodies enter a world: as pieces in the grid of fixed shapes.
#include <cmath>

#include "bodies/hull.h"
#include "bodies/population.h"
#include "bodies/static_pieces.h"

namespace psim {
namespace {

// One line that says what is wrong with the points of a line, or nothing.
std::string check_line(const std::vector<Vec2>& points, bool loop) {
  const auto finite = [](Vec2 p) { return std::isfinite(p.x) && std::isfinite(p.y); };
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!finite(points[k])) return "segment points must be finite";
    if (k + 1 == points.size() && !loop) break;
    const Vec2 next = points[(k + 1) % points.size()];
    if (points[k].x == next.x && points[k].y == next.y) return "segment points must differ";
  }
  return {};
}

std::string cut_chain(const ChainShape& chain, Pieces& pieces) {
  const std::size_t n = chain.vertices.size();
  if (n < (chain.loop ? 3u : 2u)) {
    return chain.loop ? "a chain loop needs at least 3 vertices" : "a chain needs at least 2 vertices";
  }
  for (std::size_t k = 0; k + 1 < n; ++k) pieces.segment(chain.vertices[k], chain.vertices[k + 1], 0, false);
  if (chain.loop) pieces.segment(chain.vertices[n - 1], chain.vertices[0], 0, false);
  return check_line(chain.vertices, chain.loop);
}

// Makes the pieces of a static body. One line that says what is wrong with its shape, or nothing.
std::string cut_into_pieces(const BodyDesc& d, Pieces& pieces) {
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    pieces.disc(disc->radius);
    return {};
  }
  if (const auto* line = std::get_if<SegmentShape>(&d.shape)) {
    pieces.segment(line->p1, line->p2, 0, false);
    return check_line({line->p1, line->p2}, false);
  }
  if (const auto* chain = std::get_if<ChainShape>(&d.shape)) return cut_chain(*chain, pieces);
  HullSet hulls;
  std::string error;
  if (make_hulls(d.shape, false, hulls, error)) {
    for (const Hull& hull : hulls.parts) pieces.solid(hull);
  }
  return error;
}

}  // namespace

BodyId Population::add_fixed(const BodyDesc& d, std::string& error) {
  std::vector<Piece> list;
  Pieces pieces(d.position, d.angle, lattice_, list);
  error = cut_into_pieces(d, pieces);
  if (!error.empty()) return kNoBody;
  BodyKind kind;
  kind.filter = d.filter;
  kind.sensor = d.sensor;
  if (d.sensor) {  // a sensor stops nothing: only queries and events know it
    HullSet hulls;
    if (!make_hulls(d.shape, false, hulls, error)) return kNoBody;
    kind.first_hull = bodies.hulls.acquire(hulls.parts);
    kind.hull_count = static_cast<std::uint32_t>(hulls.parts.size());
    list.clear();
  }
  const std::uint32_t entry = bodies.kinds.acquire(kind);
  if (entry > BodyKindTable::kMost) {
    error = "too many kinds of body: at most 16,777,215";
    return kNoBody;
  }
  BodyProperties properties;
  properties.type = BodyType::static_body;
  properties.kind = entry & BodyKindTable::kMost;
  const auto* disc = std::get_if<DiscShape>(&d.shape);
  properties.radius = disc != nullptr ? static_cast<float>(disc->radius) : 0;
  properties.restitution = coefficient(d.material.restitution);
  properties.friction = coefficient(d.material.friction);

  const std::uint32_t id = bodies.take_id();
  BodyInfo& info = bodies.info[id];
  info.properties = bodies.property_table.acquire(properties);
  info.place = Place::fixed;
  info.slot = static_cast<std::uint32_t>(fixed.size());
  fixed.push_back(
      {d.position.x, d.position.y, d.angle, properties.radius, id, static_cast<std::uint32_t>(statics.size())});
  for (Piece& piece : list) {
    piece.shape.owner = id;
    piece.shape.restitution = properties.restitution;
    piece.shape.friction = properties.friction;
    statics.add(piece.shape, piece.shape.whole ? &piece.hull : nullptr);
  }
  ++bodies.fixed;
  count_alike(properties, +1, traits);
  return {id, info.generation};
}

}  // namespace psim
