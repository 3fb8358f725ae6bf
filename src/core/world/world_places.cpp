// Where the parts of a body are, and how fast its points move.
#include <cmath>

#include "base/elementary.h"
#include "query/query_shapes.h"
#include "world/world_impl.h"

namespace psim {
namespace {

Vec2 centre_of(const Observed& seen, const BodyState& s) {
  if (s.type == BodyType::static_body) return {s.x, s.y};
  return Vec2{s.x, s.y} + arm_of(seen.bodies.kind(s.id.index), s.angle);
}

// A box that grows.
struct Grown {
  Bounds box{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

  void add(Vec2 at, double radius) {
    box.xmin = lesser(box.xmin, at.x - radius), box.ymin = lesser(box.ymin, at.y - radius);
    box.xmax = greater(box.xmax, at.x + radius), box.ymax = greater(box.ymax, at.y + radius);
  }
  void add(const Outline& outline) {
    for (std::int32_t k = 0; k < outline.count; ++k) add(outline.v[k], outline.radius);
  }
};

// The pieces of a static body: a run of numbers.
struct Run {
  std::uint32_t first = 0, end = 0;
};
Run pieces_of(const Observed& seen, std::uint32_t id) {
  const BodyInfo& info = seen.bodies.info[id];
  if (info.place == Place::disabled) {
    const DisabledBody& body = seen.population.disabled[info.slot];
    return {body.first_shape, body.first_shape + body.pieces};
  }
  const std::uint32_t first = seen.population.fixed[info.slot].first_shape;
  std::uint32_t end = first;
  while (end < seen.statics.size() && seen.statics[end].alive && seen.statics[end].owner == id) ++end;
  return {first, end};
}

void add_pieces(const Observed& seen, std::uint32_t id, Grown& grown) {
  const Run run = pieces_of(seen, id);
  for (std::uint32_t k = run.first; k < run.end; ++k) {
    const StaticShape& s = seen.statics[k];
    const Vec2 p = seen.lattice.to_world(s.p);
    if (s.whole) {
      grown.add(outline_of(seen.statics.hull(s), {0, 1}, p));
    } else {
      grown.add(p, wide(s.radius));
      if (s.segment) grown.add(seen.lattice.to_world(s.q), wide(s.radius));
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
  if (s.type == BodyType::static_body) add_pieces(seen, id.index, grown);
  const Vec2 centre = centre_of(seen, s);
  const SineCosine turn = sine_cosine(std::isfinite(s.angle) ? s.angle : 0);
  for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
    grown.add(outline_of(seen.bodies.hulls[kind.first_hull + k], turn, centre));
  }
  if (s.type != BodyType::static_body && kind.hull_count == 0) grown.add(centre, s.radius);
  if (!(grown.box.xmin <= grown.box.xmax)) grown.add(centre, 0);  // a forged state may have bodies without pieces
  return grown.box;
}

}  // namespace psim
