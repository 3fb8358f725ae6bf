// Static bodies: what is refused, and how they enter the grid of fixed shapes.
#include <cmath>

#include "static_pieces.h"
#include "world_impl.h"

namespace psim {
namespace {

// One line of what is wrong with the points of a line, or empty.
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

}  // namespace

BodyId World::Impl::add_fixed(const BodyDesc& d, std::string& error) {
  std::vector<Piece> list;
  Pieces pieces(d.position, d.angle, lattice, list);
  float radius = 0;
  Make make;
  make.filter = d.filter;
  make.sensor = d.sensor;
  if (const auto* disc = std::get_if<DiscShape>(&d.shape)) {
    radius = static_cast<float>(disc->radius);
    pieces.disc(disc->radius);
  } else if (const auto* line = std::get_if<SegmentShape>(&d.shape)) {
    error = check_line({line->p1, line->p2}, false);
    pieces.segment(line->p1, line->p2, 0, false);
  } else if (const auto* chain = std::get_if<ChainShape>(&d.shape)) {
    const std::size_t n = chain->vertices.size();
    if (n < (chain->loop ? 3u : 2u)) {
      error = chain->loop ? "a chain loop needs at least 3 vertices"
                          : "a chain needs at least 2 vertices";
      return kNoBody;
    }
    error = check_line(chain->vertices, chain->loop);
    for (std::size_t k = 0; k + 1 < n; ++k) {
      pieces.segment(chain->vertices[k], chain->vertices[k + 1], 0, false);
    }
    if (chain->loop) pieces.segment(chain->vertices[n - 1], chain->vertices[0], 0, false);
  } else {
    HullSet hulls;
    if (make_hulls(d.shape, false, hulls, error)) {
      for (const Hull& hull : hulls.parts) pieces.solid(hull);
    }
  }
  if (!error.empty()) return kNoBody;
  if (d.sensor) {  // it stops nothing: only questions and events know it
    HullSet hulls;
    if (!make_hulls(d.shape, false, hulls, error)) return kNoBody;
    make.first_hull = bodies.hulls.acquire(hulls.parts);
    make.hull_count = static_cast<std::uint32_t>(hulls.parts.size());
    pieces.list.clear();
  }
  const std::uint32_t made = bodies.makes.acquire(make);
  if (made > MakeTable::kMost) {
    error = "too many kinds of body: at most 16,777,215";
    return kNoBody;
  }

  const std::uint32_t id = bodies.take_id();
  Surface surface;
  surface.type = BodyType::static_body;
  surface.make = made & MakeTable::kMost;
  surface.radius = radius;
  surface.restitution = coefficient(d.material.restitution);
  surface.friction = coefficient(d.material.friction);
  BodyInfo& info = bodies.info[id];
  const std::uint32_t generation = info.generation;
  info.surface = bodies.surfaces.acquire(surface);
  info.place = Place::fixed;
  bodies.roster_changed = true;
  info.slot = static_cast<std::uint32_t>(fixed.size());
  FixedBody f;
  f.x = d.position.x;
  f.y = d.position.y;
  f.angle = d.angle;
  f.radius = radius;
  f.id = id;
  f.first_shape = static_cast<std::uint32_t>(shapes.size());
  for (Piece& piece : pieces.list) {
    piece.shape.owner = id;
    piece.shape.restitution = surface.restitution;
    piece.shape.friction = surface.friction;
    shapes.add(piece.shape, piece.shape.whole ? &piece.hull : nullptr);
  }
  fixed.push_back(f);
  ++bodies.fixed;
  ++traits.fixed;
  if (d.sensor) ++traits.sensors;
  if (surface.restitution > 0) ++traits.fixed_bounce;
  if (surface.friction > 0) ++traits.fixed_rough;
  if (d.filter != Filter{}) ++traits.filtered;
  spoil_lists();
  plan_stale = placed = true;
  queries.forget_fixed();
  if (!sleepers.empty()) {
    wake_touching_pieces(f.first_shape, id);
    wake(sleepers.queue);
  }
  return {id, generation};
}

}  // namespace psim
