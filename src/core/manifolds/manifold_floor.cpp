// Floors of several pieces. A body that lies on fixed pieces of one plane touches this plane in two points, the outermost
// ones, as if it were one piece: they belong to one manifold, and the pairs of the other pieces are ghosts. Swept one
// after the other, the pieces would tip a box that lands flat.
//
// The manifold is that of a piece with an outermost point. Its second point may be one of another piece, marked in its
// feature. Such a manifold is found anew in every step, and its impulses are handed on.
#include <algorithm>
#include <cmath>
#include <span>

#include "base/elementary.h"
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

constexpr float kParallel = 2e-4f;  // sine between normals of one plane
constexpr float kLevel = 1e-4f;     // share of the inner radius: planes that are nearer than this are one
constexpr float kShort = 1e-3f;     // share of the inner radius: points that are nearer than this are one

struct End {
  ManifoldPair* pair = nullptr;
  int point = 0;
  float at = 0;  // m, along the plane
};

// The height of a hull above the centre of the body, along a normal.
float top_of(const Hull& hull, float nx, float ny) {
  float top = nx * hull.x[0] + ny * hull.y[0];
  for (int k = 1; k < hull.count; ++k) top = greater(nx * hull.x[k] + ny * hull.y[k], top);
  return top + hull.radius;
}

float along(const Manifold& m, float x, float y) { return m.nx * y - m.ny * x; }

void drop_impulses(ManifoldPair& pair) {
  for (int k = 0; k < 2; ++k) pair.impulse[k] = pair.friction[k] = 0;
}

// Joins the manifolds of pieces of one plane, unless an inner point is nearer than the line between the outermost ones.
bool join(std::span<ManifoldPair* const> group, float inner, const auto& arm_on_a) {
  const Manifold& any = group[0]->manifold;
  End low{nullptr, 0, 1e30f}, high{nullptr, 0, -1e30f};
  const auto each_point = [&](const auto& each) {
    for (ManifoldPair* const pair : group) {
      for (int k = 0; k < pair->manifold.count; ++k) {
        each(End{pair, k, along(any, pair->manifold.point[k].bx, pair->manifold.point[k].by)});
      }
    }
  };
  each_point([&](const End& e) {
    if (e.at < low.at) low = e;
    if (e.at > high.at) high = e;
  });
  const float length = high.at - low.at, from = low.pair->gap[low.point], to = high.pair->gap[high.point];
  if (length < kShort * inner) return false;
  bool level = true;
  each_point([&](const End& e) {
    const float share = (e.at - low.at) / length;
    level &= e.pair->gap[e.point] >= from + share * (to - from) - kApart * inner;
  });
  if (!level) return false;
  const bool turned = low.pair->manifold.count < 2 && high.pair->manifold.count == 2;
  const End mine = turned ? high : low, far = turned ? low : high;
  ManifoldPair& holder = *mine.pair;
  float impulse[2] = {}, friction[2] = {};
  const auto take = [&](const ManifoldPair& from_pair, int k, float share) {  // share: of the far point
    const float weight[2] = {1 - share, share};
    for (int n = 0; n < 2; ++n) {
      impulse[n] += weight[n] * greater(from_pair.impulse[k], 0.0f);
      friction[n] += weight[n] * from_pair.friction[k];
    }
  };
  each_point([&](const End& e) {
    const bool carries = (e.pair->manifold.point[e.point].feature & kCarriesFar) != 0;
    take(*e.pair, e.point, carries ? 1 : std::fabs(e.at - mine.at) / length);
  });
  if (holder.manifold.count == 1) take(holder, 1, 1);
  ManifoldPoint points[2] = {holder.manifold.point[mine.point], far.pair->manifold.point[far.point]};
  const float gaps[2] = {holder.gap[mine.point], far.pair->gap[far.point]};
  if (mine.point != 0) std::swap(holder.offset[0], holder.offset[1]);
  if (far.pair != &holder) {
    points[1].feature |= kOfAnotherPiece;
    arm_on_a(holder, points[1]);
  }
  for (ManifoldPair* const pair : group) {
    drop_impulses(*pair);
    pair->ghost = pair != &holder;
    pair->active = !pair->ghost;
  }
  holder.manifold.count = 2;
  holder.changed = true;
  for (int k = 0; k < 2; ++k) {
    holder.manifold.point[k] = points[k];
    holder.gap[k] = gaps[k];
    holder.impulse[k] = impulse[k];
    holder.friction[k] = friction[k];
  }
  return true;
}

}  // namespace

void Manifolds::Look::carry_far(ManifoldPair& pair, const Manifold& old, float (&impulse)[2],
                                float (&friction)[2]) const {
  Manifold& m = pair.manifold;
  if (m.count == 0 || old.count != 2 || (old.point[1].feature & kOfAnotherPiece) == 0) return;
  const int k = m.count == 2 && m.point[1].feature == old.point[0].feature ? 0 : 1;
  impulse[k] = pair.impulse[1];
  friction[k] = pair.friction[1];
  m.point[k].feature |= kCarriesFar;
}

// Whether the material of two fixed sides is one, and whether they stand still against each other.
bool Manifolds::Look::alike(const ManifoldPair& p, const ManifoldPair& q) const {
  const Sides of_p = manifolds.sides_of(p), of_q = manifolds.sides_of(q);
  const bool decided = of_p.decided != nullptr && of_q.decided != nullptr;
  const bool same = decided ? *of_p.decided == *of_q.decided : of_p.a == of_q.a && of_p.decided == of_q.decided;
  if (p.of_piece() != q.of_piece() || !same) return false;
  if (p.of_piece() || p.a == q.a) return true;
  const auto turns = [&](std::uint32_t slot) { return b.rim_speed[slot] != 0; };
  return !turns(p.a) && !turns(q.a) && b.vel[2 * p.a] == b.vel[2 * q.a] && b.vel[2 * p.a + 1] == b.vel[2 * q.a + 1];
}

// Whether the piece of a pair has its top in a plane.
bool Manifolds::Look::lies_in(const ManifoldPair& pair, const Manifold& plane, float height) const {
  const Manifold& m = pair.manifold;
  if (m.count == 0 || m.nx * plane.nx + m.ny * plane.ny < 0) return false;
  if (std::fabs(m.nx * plane.ny - m.ny * plane.nx) > kParallel) return false;
  const float near = kLevel * manifolds.inner_of(pair.b) + 4 * static_cast<float>(lattice.pitch_x());
  return std::fabs(top_of(seen_from_b(pair), plane.nx, plane.ny) - height) < near;
}

bool Manifolds::Look::may_join(const ManifoldPair& pair) const {
  return pair.active && !pair.moved && !pair.of_wall() && !pair.of_sleeper(statics) && !manifolds.turns_fast(pair, dt);
}

// Makes one manifold of those of a body with fixed pieces of one plane.
void Manifolds::Look::join_floors(std::span<ManifoldPair* const> pairs) const {
  const auto arm_on_a = [&](const ManifoldPair& holder, ManifoldPoint& p) {
    const Vec2 way = holder.of_piece() ? Vec2{} : lattice.way(b.point(holder.a), b.point(holder.b));
    p.ax = p.bx + static_cast<float>(way.x);
    p.ay = p.by + static_cast<float>(way.y);
  };
  for (std::size_t k = 0; k + 1 < pairs.size(); ++k) {
    ManifoldPair& first = *pairs[k];
    if (!first.active) continue;
    ManifoldPair* group[kMostPieces] = {&first};
    std::size_t size = 1;
    float height = 0;
    for (ManifoldPair* const other : pairs.subspan(k + 1)) {
      if (!other->active || other->part_b != first.part_b || !alike(first, *other)) continue;
      if (size == 1) height = top_of(seen_from_b(first), first.manifold.nx, first.manifold.ny);
      if (lies_in(*other, first.manifold, height)) group[size++] = other;
    }
    if (size > 1) join({group, size}, manifolds.inner_of(first.b), arm_on_a);
  }
}

// The floor of a manifold of several pieces, as a segment from the centre of A, in A's axes.
Hull Manifolds::floor_of(const ManifoldPair& pair) const {
  const ManifoldParams none;
  const Look look{*this, none};
  const Manifold& m = pair.manifold;
  const float height = top_of(look.seen_from_b(pair), m.nx, m.ny);
  float low = 1e30f, high = -1e30f;
  const auto add = [&](const ManifoldPair& other) {
    const Hull hull = look.seen_from_b(other);
    for (int k = 0; k < hull.count; ++k) {
      if (m.nx * hull.x[k] + m.ny * hull.y[k] + hull.radius < height - kLevel * inner_of(pair.b)) continue;
      low = lesser(along(m, hull.x[k], hull.y[k]), low);
      high = greater(along(m, hull.x[k], hull.y[k]), high);
    }
  };
  add(pair);
  look.each_fixed(pair, [&](const ManifoldPair& other) {
    if (look.alike(pair, other) && look.lies_in(other, m, height)) add(other);
  });
  const Vec2 way = pair.of_piece() ? Vec2{} : s_.lattice.way(s_.bodies.point(pair.a), s_.bodies.point(pair.b));
  const Rotor q = pair.of_piece() || !has_corners(pair.a) ? Rotor{} : rotor(pair.a);
  Hull floor;
  floor.count = 2;
  for (int k = 0; k < 2; ++k) {
    const double x = k == 0 ? low : high;
    const Vec2 v = way + Vec2{m.nx * height - x * m.ny, m.ny * height + x * m.nx};
    floor.set_vertex(k, turned({-q.s, q.c}, v));
  }
  finish_hull(floor);
  return floor;
}

}  // namespace psim
