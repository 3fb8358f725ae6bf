#include "query/blast.h"

#include "base/elementary.h"
#include "geometry/convex.h"
#include "query/query_grid.h"

namespace psim {
namespace {

// The width of an outline across a direction of length 1, m.
double width_across(const Outline& outline, Vec2 direction) {
  double low = cross(direction, outline.v[0]), high = low;
  for (std::int32_t k = 1; k < outline.count; ++k) {
    const double at = cross(direction, outline.v[k]);
    low = lesser(low, at), high = greater(high, at);
  }
  return high - low + 2 * outline.radius;
}

// The mean of the vertices.
Vec2 middle_of(const Outline& outline) {
  Vec2 sum;
  for (std::int32_t k = 0; k < outline.count; ++k) sum = sum + outline.v[k];
  return (1.0 / outline.count) * sum;
}

// The blow on one outline, seen from the explosion. None on one that lies around its place evenly.
void strike(const Explosion& explosion, const Outline& outline, BodyId body, std::vector<Blow>& blows) {
  const NearPoint near = near_point(outline);
  const double beyond = near.distance - explosion.radius;
  if (beyond > 0 && !(beyond < explosion.falloff)) return;
  const double share = beyond > 0 ? 1 - beyond / explosion.falloff : 1;
  const Vec2 way = near.distance > 0 ? near.point : middle_of(outline);
  const double length = length_of(way);
  if (!(length > 0)) return;
  const Vec2 direction = (1 / length) * way;
  const double impulse = explosion.impulse_per_length * share * width_across(outline, direction);
  blows.push_back({body, impulse * direction, explosion.position + way});
}

}  // namespace

std::vector<Blow> blows_of(const Explosion& explosion, const Observed& world, const std::vector<BodyId>& near) {
  std::vector<Blow> blows;
  const Vec2 period = world.period();
  for (const BodyId id : near) {
    const BodyProperties& properties = world.bodies.properties(id.index);
    if (!(properties.inv_mass > 0)) continue;
    const auto [place, angle] = world.stand(id.index);
    const Vec2 at = nearest_copy(world.lattice.to_world(place) - explosion.position, period);
    const BodyKind& kind = world.bodies.kinds[properties.kind];
    if (kind.hull_count == 0) strike(explosion, {{at}, 1, wide(properties.radius)}, id, blows);
    const SineCosine turn = sine_cosine(angle);
    for (std::uint32_t k = 0; k < kind.hull_count; ++k) {
      strike(explosion, outline_of(world.bodies.hulls[kind.first_hull + k], turn, at), id, blows);
    }
  }
  return blows;
}

}  // namespace psim
