// What the parts of a body are and where, and how fast its points move.
#include <cmath>

#include "base/elementary.h"
#include "geometry/convex.h"
#include "query/body_parts.h"
#include "world/world_impl.h"

namespace psim {
namespace {

Vec2 centre_of(const Observed& seen, const BodyState& s) {
  if (s.type == BodyType::static_body) return {s.x, s.y};
  return Vec2{s.x, s.y} + arm_of(seen.bodies.kind(s.id.index), s.angle);
}

// In a periodic world the copies that are nearest to its place.
void add_pieces(const Observed& seen, const BodyState& body, Grown& grown) {
  const PieceRun run = pieces_of(seen, body.id.index);
  for (std::uint32_t k = run.first; k < run.end; ++k) {
    const StaticShape& s = seen.statics[k];
    const Vec2 p = Vec2{body.x, body.y} + way_from(seen, body, s.p);
    if (s.whole) {
      grown.add(outline_of(seen.statics.hull(s), {0, 1}, p));
    } else {
      grown.add(p, wide(s.radius));
      if (s.segment) grown.add(p + seen.lattice.way(s.p, s.q), wide(s.radius));
    }
  }
}

}  // namespace

std::optional<Vec2> World::centre_of_mass(BodyId id) const {
  const FloatSettings settings;
  if (!is_valid(id)) return std::nullopt;
  return centre_of(impl_->observed(), impl_->observed().state_of(id.index));
}

std::optional<Vec2> World::velocity_at(BodyId id, Vec2 point) const {
  const FloatSettings settings;
  if (!is_valid(id)) return std::nullopt;
  const Observed seen = impl_->observed();
  const BodyState s = seen.state_of(id.index);
  const Vec2 about = s.type == BodyType::kinematic_body ? Vec2{s.x, s.y} : centre_of(seen, s);
  const Vec2 arm = nearest_copy(point - about, seen.period());
  return Vec2{s.vx - s.omega * arm.y, s.vy + s.omega * arm.x};
}

std::optional<Bounds> World::bounds_of(BodyId id) const {
  const FloatSettings settings;
  if (!is_valid(id)) return std::nullopt;
  const Observed seen = impl_->observed();
  const BodyState s = seen.state_of(id.index);
  const BodyKind& kind = seen.bodies.kind(id.index);
  Grown grown;
  if (s.type == BodyType::static_body) add_pieces(seen, s, grown);
  const Vec2 centre = centre_of(seen, s);
  const SineCosine turn = sine_cosine(std::isfinite(s.angle) ? s.angle : 0);
  for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
    grown.add(outline_of(seen.bodies.hulls[kind.first_hull + k], turn, centre));
  }
  if (s.type != BodyType::static_body && kind.hull_count == 0) grown.add(centre, s.radius);
  if (!(grown.box.xmin <= grown.box.xmax)) grown.add(centre, 0);  // a forged state may have bodies without pieces
  return grown.box;
}

std::vector<ShapePart> World::shapes_of(BodyId id) const try {
  const FloatSettings settings;
  if (!is_valid(id)) return {};
  return parts_of(impl_->observed(), id.index);
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<ShapePart>>();
}

std::optional<Bounds> World::bounds_of_part(BodyId id, std::size_t number) const try {
  const FloatSettings settings;
  if (!is_valid(id)) return std::nullopt;
  const Observed seen = impl_->observed();
  const std::vector<ShapePart> parts = parts_of(seen, id.index);
  if (number >= parts.size()) return std::nullopt;
  const BodyState s = seen.state_of(id.index);
  const SineCosine turn = sine_cosine(std::isfinite(s.angle) ? s.angle : 0);
  Grown grown;
  each_point(parts[number], [&](Vec2 point, double radius) {
    grown.add(Vec2{s.x, s.y} + turned(turn, point), radius);
  });
  return grown.box;
} catch (const std::bad_alloc&) {
  return nothing_found<std::optional<Bounds>>();
}

}  // namespace psim
