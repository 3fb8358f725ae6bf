// Bodies on ground that has several pieces, static or kinematic: they slide over lines of segments, tiles and polygons as
// over one piece.
//
//   segments   a body meets the end of a segment only where the other segments at this end leave room for the normal
//   ghosts     a body that rests on one piece does not meet another one that lies wholly below the plane of this rest
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/elementary.h"
#include "base/sort_keys.h"
#include "base/tasks.h"
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

constexpr double kUpright = 1e-3;  // cosine: a normal that leans less is that of a face
constexpr double kSharp = 0.5;     // cosine of the turn at a corner in which a body may be stuck
constexpr double kSame = 1e-4;     // share of the inner radius: points that are nearer than this are one

Vec2 seen(Rotor q, Vec2 v) { return turned({q.s, q.c}, v); }

// A pair whose manifold was found anew keeps its own impulses from now on.
void keep_own(ManifoldPair& pair) {
  for (int k = 0; k < 2; ++k) {
    std::uint16_t& feature = pair.manifold.point[k].feature;
    if ((feature & kCarriesFar) == 0) continue;
    feature &= static_cast<std::uint16_t>(~kCarriesFar);
    if (k >= pair.manifold.count) pair.impulse[k] = pair.friction[k] = 0;
  }
}

}  // namespace

// The hull of a fixed piece in world axes, from the centre of the body that it meets.
Hull Manifolds::Look::seen_from_b(const PairName& pair) const {
  const LatticePoint at = b.point(pair.b);
  if (pair.of_piece()) {
    const double size = static_cast<double>(b.radius[pair.b]) + static_cast<double>(statics[pair.shape].radius);
    return statics.seen_from(pair.shape, at, 16 * size);
  }
  std::optional<Hull> disc;
  Hull hull = hull_of(pair.a, pair.part_a, disc);
  const Rotor q = manifolds.has_corners(pair.a) ? manifolds.rotor(pair.a) : Rotor{};
  const Vec2 way = lattice.way(at, b.point(pair.a));
  for (int k = 0; k < hull.count; ++k) hull.set_vertex(k, seen(q, hull.vertex(k)) + way);
  finish_hull(hull);
  return hull;
}

// What lies beyond the end of a segment, as for discs (edge_contact.h): of all edges there the one that rises most on the
// side of the body. `out` leads along the segment and out at this end, `up` to the body.
EdgeCorner Manifolds::Look::corner_at(const ManifoldPair& pair, Vec2 corner, Vec2 out, Vec2 up, float radius) const {
  const double same = kSame * static_cast<double>(manifolds.inner_of(pair.b)) + 4 * lattice.pitch_x();
  EdgeCorner best;
  double most = -3;
  const auto edge = [&](Vec2 p, Vec2 q, bool one_sided) {
    const Vec2 u = q - p, a = corner - p;
    const double share = lesser(greater(dot(a, u) / dot(u, u), 0.0), 1.0);
    if (length_of(a - share * u) > same) return;
    for (const Vec2 far : {p, q}) {
      const Vec2 way = far - corner;
      const double length = length_of(way);
      if (!(length > same)) continue;
      const double cosine = dot(out, way) / length, sine = dot(up, way) / length;
      if (cosine < -0.9999) continue;  // the same line again
      // An edge of a polygon has one side, which must be that of the body.
      const Vec2 outside{u.y, -u.x}, left{-way.y, way.x};
      if (one_sided && dot(outside, left) * cross(out, up) < 0) continue;
      const double rise = sine > 0 ? 1 - cosine : cosine - 1;
      if (rise <= most) continue;
      most = rise;
      best = {static_cast<float>(cosine), static_cast<float>(sine), static_cast<float>(length), false};
    }
  };
  each_fixed(pair, [&](const ManifoldPair& other) {
    if (other.of_piece() && statics[other.shape].segment) {
      const StaticShape& s = statics[other.shape];
      if (s.radius == radius) edge(lattice.way(b.point(pair.b), s.p), lattice.way(b.point(pair.b), s.q), false);
      return;
    }
    const Hull hull = seen_from_b(other);
    if (hull.count < 2 || hull.radius != radius) return;
    for (int k = 0; k < (hull.count == 2 ? 1 : hull.count); ++k) {
      edge(hull.vertex(k), hull.vertex(hull.next(k)), hull.count > 2);
    }
  });
  return best;
}

// `face` becomes the normal of the segment on the side of the middle of the hull that meets it.
Manifolds::Look::Meets Manifolds::Look::at_segment(const ManifoldPair& pair, const Hull& a, Rotor qa, Vec2 way,
                                                   Vec2 middle, const Manifold& m, Vec2& face) const {
  const Vec2 p = seen(qa, a.vertex(0)) - way, q = seen(qa, a.vertex(1)) - way;  // from the centre of the body
  const Vec2 along = 1 / length_of(q - p) * (q - p);
  face = {-along.y, along.x};
  if (dot(p - middle, face) > 0) face = -1 * face;
  const Vec2 n{m.nx, m.ny};
  const double lean = dot(n, along);
  if (std::fabs(lean) < kUpright && dot(n, face) > 0) return Meets::what_was_found;
  const Vec2 out = lean > 0 ? along : -1 * along;
  const EdgeCorner beyond = corner_at(pair, lean > 0 ? q : p, out, face, a.radius);
  if (!(beyond.length > 0)) return Meets::what_was_found;
  const double cosine = static_cast<double>(beyond.cos), sine = static_cast<double>(beyond.sin);
  if (sine > -kUpright) return cosine < kSharp ? Meets::what_was_found : Meets::face;  // driven into a corner
  // Between two segments that fall away from each other all normals are right; the others are those of the next one.
  return dot(n, cosine * out + sine * face) < kUpright ? Meets::what_was_found : Meets::nothing;
}

// Makes of a manifold with the end of a segment that with its face, or none. `start` and `way` lead from A to B, at the
// start of the step and now.
void Manifolds::Look::fit_to_segment(const ManifoldPair& pair, Manifold& m, const Hull& a, Rotor qa, const Hull& hull_b,
                                     Rotor qb, Vec2 start, Vec2 way, float margin) const {
  Vec2 face;
  const Meets meets = at_segment(pair, a, qa, start, seen(qb, hull_b.middle()), m, face);
  if (meets == Meets::what_was_found) return;
  m.count = 0;
  if (meets == Meets::nothing) return;
  const Vec2 p = seen(qa, a.vertex(0)) - way, u = seen(qa, a.vertex(1)) - way - p;
  const auto offset = static_cast<float>(-dot(p, face));
  m = meet_plane(hull_b, qb, static_cast<float>(face.x), static_cast<float>(face.y), offset - a.radius, margin);
  const int found = std::exchange(m.count, 0);
  for (int k = 0; k < found; ++k) {  // points that lie over the segment stay
    ManifoldPoint point = m.point[k];
    const double along = dot(Vec2{point.bx, point.by} - p, u) / dot(u, u);
    if (along < 0 || along > 1 || point.gap < -hull_b.inner) continue;
    point.ax = point.bx + static_cast<float>(way.x);
    point.ay = point.by + static_cast<float>(way.y);
    m.point[m.count++] = point;
  }
}

void Manifolds::fit_within_step(const ManifoldPair& pair, Manifold& m, const Hull& a, const Hull& hull_b, Rotor qb,
                                Vec2 start, Vec2 way) const {
  const ManifoldParams none;
  const Rotor qa = pair.of_piece() ? Rotor{} : rotor(pair.a);
  Look{*this, none}.fit_to_segment(pair, m, a, qa, hull_b, qb, start, way, std::numeric_limits<float>::infinity());
}

// Makes the contact with a fixed piece that lies ahead.
void Manifolds::Look::foresee_fixed(ManifoldPair& pair) const {
  const std::size_t j = pair.b;
  std::optional<Hull> disc;
  const Hull& hull = hull_of(j, pair.part_b, disc);
  const auto fall = [&](double gravity) {
    return kernels::snapped(gravity * params.dt * params.dt / 2, kernels::kLeastOffset);
  };
  float mx = b.vel[2 * j] * dt + fall(params.gravity.x), my = b.vel[2 * j + 1] * dt + fall(params.gravity.y);
  const float inner = manifolds.has_corners(j) ? b.kind(b.id[j]).inner : b.radius[j];
  if (pair.of_piece()) return foresee(pair, seen_from_b(pair), Rotor{}, hull, {}, mx, my, inner);
  const std::size_t i = pair.a;
  mx -= b.vel[2 * i] * dt;
  my -= b.vel[2 * i + 1] * dt;
  std::optional<Hull> own;
  const Hull& a = hull_of(i, pair.part_a, own);
  const Rotor q = manifolds.has_corners(i) ? manifolds.rotor(i) : Rotor{};
  foresee(pair, a, q, hull, lattice.way(b.point(i), b.point(j)), mx, my, inner);
}

// Looks at all fixed pieces near one body. A convex part of it that rests on one piece cannot collide with
// another piece that lies wholly below the plane on which it rests. A contact with such a piece comes from a corner
// that sank a little, or from a normal that is kept from before, and is left out. So bodies slide over tiles and chains
// without a bump.
template <class At>
void Manifolds::see_fixed(const ManifoldParams& params, std::size_t count, const At& at) const {
  bool near_any = false;
  for (std::size_t k = 0; k < count && !near_any; ++k) near_any = at(k).manifold.count != 0;
  if (!near_any) return;
  const Look look{*this, params};
  const BodyStore& b = s_.bodies;
  const std::uint32_t slot = at(0).b;
  const float inner = has_corners(slot) ? b.kind(b.id[slot]).inner : b.radius[slot], near = kStep * inner;
  for (std::size_t k = 0; k < count; ++k) {
    ManifoldPair& pair = at(k);
    if (pair.manifold.count == 0 || pair.moved || pair.of_wall()) continue;
    const Manifold& m = pair.manifold;
    Hull piece;
    for (std::size_t o = 0; o < count && !pair.ghost; ++o) {
      const ManifoldPair& other = at(o);
      const Manifold& rest = other.manifold;
      if (o == k || !other.active || other.ahead || rest.count == 0 || other.part_b != pair.part_b) continue;
      int lowest = 0;
      if (rest.count == 2 && other.gap[1] < other.gap[0]) lowest = 1;
      if (other.gap[lowest] > near || m.nx * rest.nx + m.ny * rest.ny > kAlike) continue;
      const ManifoldPoint& p = rest.point[lowest];
      const float plane = rest.nx * p.bx + rest.ny * p.by + 0.5f * p.gap - other.gap[lowest];
      const auto above = [&](float x, float y) { return rest.nx * x + rest.ny * y - plane; };
      bool at_plane = true;
      for (int n = 0; n < m.count && !pair.ahead; ++n) {
        at_plane &= std::fabs(above(m.point[n].bx, m.point[n].by)) <= 2 * near;
      }
      if (!at_plane) continue;
      if (piece.count == 0) piece = look.seen_from_b(pair);
      float highest = above(piece.x[0], piece.y[0]);
      for (int n = 1; n < piece.count; ++n) highest = greater(above(piece.x[n], piece.y[n]), highest);
      if (highest + piece.radius <= near) pair.ghost = true;
    }
    if (pair.ghost) pair.active = false;
  }
  ManifoldPair* floor[kMostPieces];
  std::size_t pieces = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (at(k).ahead && !at(k).ghost && !turns_fast(at(k), look.dt)) look.foresee_fixed(at(k));
    if (pieces < kMostPieces && look.may_join(at(k))) floor[pieces++] = &at(k);
  }
  if (pieces > 1) look.join_floors({floor, pieces});
  for (std::size_t k = 0; k < count; ++k) keep_own(at(k));
}

// Looks at the fixed pieces near each body of a strip.
void Manifolds::see_ground(const ManifoldParams& params, std::size_t index) {
  for (auto [k, last] : pieces_of(index)) {
    while (k != last) {
      std::uint32_t end = k + 1;
      while (end != last && pairs_[end].b == pairs_[k].b) ++end;
      see_fixed(params, end - k, [this, k = k](std::size_t n) -> ManifoldPair& { return pairs_[k + n]; });
      k = end;
    }
  }
}

// The same where some fixed pieces are kinematic: the pairs of a body lie in several strips.
void Manifolds::see_all_ground(const ManifoldParams& params) {
  constexpr std::size_t kPairs = 256;  // in a job, which takes the bodies whose pairs begin there
  const auto starts = [&](std::size_t k) { return k == 0 || fixed_[k] >> 32 != fixed_[k - 1] >> 32; };
  s_.pool.run(jobs_for(fixed_.size(), kPairs), [&](std::size_t job) {
    const std::size_t last = std::min(fixed_.size(), (job + 1) * kPairs);
    for (std::size_t k = job * kPairs; k < last; ++k) {
      if (!starts(k)) continue;
      std::size_t end = k + 1;
      while (end < fixed_.size() && !starts(end)) ++end;
      see_fixed(params, end - k,
                [&](std::size_t n) -> ManifoldPair& { return pairs_[static_cast<std::uint32_t>(fixed_[k + n])]; });
    }
  });
}

}  // namespace psim
