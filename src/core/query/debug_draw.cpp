#include "query/debug_draw.h"

#include <algorithm>
#include <tuple>

namespace psim {

DebugDraw::~DebugDraw() = default;

namespace {

DrawKind kind_of(const Observed& world, const QueryItem& item) {
  const BodyStore& b = world.bodies;
  if (b.is_sensor(b.kind(item.body), item.part)) return DrawKind::sensor;
  const Place place = b.info[item.body].place;
  if (place == Place::frozen) return DrawKind::frozen;
  if (place == Place::asleep) return DrawKind::asleep;
  const BodyType type = b.properties(item.body).type();
  if (type == BodyType::static_body) return DrawKind::static_body;
  return type == BodyType::kinematic_body ? DrawKind::kinematic_body : DrawKind::dynamic_body;
}

}  // namespace

void draw_bodies(const QueryIndex& index, const Observed& world, const std::optional<Bounds>& region, DebugDraw& to) {
  struct Piece {
    const QueryIndex::Part* part;
    const QueryItem* item;
    Vec2 at;  // m, world: of the copy that is meant
  };
  std::vector<Piece> pieces;
  const Vec2 centre = world.lattice.centre();
  for (const QueryIndex::Who who : {QueryIndex::kMoving, QueryIndex::kSleeping, QueryIndex::kFixed}) {
    const QueryIndex::Part& part = index.part(world, who);
    if (!region) {
      for (const QueryItem& item : part.grid.items()) pieces.push_back({&part, &item, centre + item.at});
      continue;
    }
    const Vec2 low = Vec2{region->xmin, region->ymin} - centre, high = Vec2{region->xmax, region->ymax} - centre;
    part.grid.in_box(low, high, [&](const QueryItem& item, Vec2 shift) {
      const Vec2 at = item.at + shift;
      const double r = wide(item.radius);
      if (at.x + r < low.x || at.x - r > high.x || at.y + r < low.y || at.y - r > high.y) return;
      pieces.push_back({&part, &item, centre + at});
    });
  }
  const auto order = [](const Piece& p) {
    return std::tuple(p.item->body, p.item->part, p.item->piece, p.at.x, p.at.y);
  };
  // Total order: no two pieces of a body have one number, no two copies one place.
  std::ranges::sort(pieces, {}, order);
  for (const Piece& p : pieces) {
    const BodyId body = world.handle(p.item->body);
    const DrawKind kind = kind_of(world, *p.item);
    if (p.item->piece == QueryIndex::kDisc) {
      to.circle(p.at, wide(p.item->radius), world.state_of(p.item->body).angle, kind, body);
      continue;
    }
    const Outline outline = QueryIndex::outline(world, *p.part, *p.item, p.at);
    if (outline.count == 1) {
      to.circle(outline.v[0], outline.radius, world.state_of(p.item->body).angle, kind, body);
    } else {
      to.polygon({outline.v, static_cast<std::size_t>(outline.count)}, outline.radius, kind, body);
    }
  }
}

}  // namespace psim
