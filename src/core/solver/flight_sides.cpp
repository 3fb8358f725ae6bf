// With which side a body of a flight meets another one: sides that let it through, and ends of segments that are none.
#include <cmath>

#include "base/rotor.h"
#include "solver/flight.h"

namespace psim {

// The direction of a side of a body that moves, turned by `angle`.
Vec2 Flight::one_way_of(std::uint32_t id, std::uint32_t part, double angle) const {
  const Vec2 way = b_.one_way_of(b_.kind(id), part);
  return way == Vec2{} ? way : turned(sine_cosine(angle), way);
}

// Whether hulls that meet do so at a side that is solid (manifold_crossing.cpp).
bool Flight::is_solid(const Approach& pair, const Other& other, const Hull& mine, double share) const {
  const Vec2 own = one_way_of(b_.id[slot_], number_of(mine), leg().facing(share));
  if (other.one_way == Vec2{} && own == Vec2{}) return true;
  const Manifold m = pair.touch(share, 1e30);
  const auto meets = [&](Vec2 way, double sign) {
    return way == Vec2{} || sign * dot({m.nx, m.ny}, way) > Manifolds::kSolidSide;
  };
  return meets(other.one_way, 1) && meets(own, -1);
}

// Where another segment goes on from the end of one without falling away from the body's side, the body meets the face of
// the segment, never its end.
Vec2 Flight::smoothed(Vec2 n, std::span<const std::uint32_t> near) const {
  const Hull& piece = first_.hull;
  if (first_.other.piece == kNoSlot || piece.count != 2) return n;
  const Vec2 u = piece.vertex(1) - piece.vertex(0);
  const double length = length_of(u), lean = dot(n, u) / length, same = kTolerance * double{inner_};
  if (std::fabs(lean) < 1e-3) return n;
  const Vec2 corner = piece.vertex(lean > 0 ? 1 : 0), out = (lean > 0 ? 1 / length : -1 / length) * u;
  const Vec2 middle = at_ + first_.mine->middle_at(angle_);
  const double side = cross(u, middle - piece.vertex(0)) < 0 ? -1 : 1;
  const Vec2 up = (side / length) * upright(u);
  for (const std::uint32_t k : near) {
    const StaticShape& s = s_.statics[k];
    if (k == first_.other.piece || !s.segment || s.asleep || s.radius != piece.radius) continue;
    const Hull next = seen(k, 0);
    for (const int end : {0, 1}) {
      const Vec2 way = next.vertex(1 - end) - corner;
      if (length_of(next.vertex(end) - corner) > same || !(dot(out, way) > 0)) continue;
      if (dot(up, way) > -1e-3 * length_of(way)) return up;
    }
  }
  return n;
}

}  // namespace psim
