// What a manifold means for a body that moves: whether it counts in this step, where bodies will meet that are still
// apart, and how a body slides over chains and tiles without a bump.
#include <algorithm>
#include <cmath>

#include "base/rotor.h"
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

constexpr float kApart = 0.0005f;  // share of the inner radius: bodies with a larger gap are apart
constexpr float kStep = 0.02f;     // a piece counts as below a plane if it stands out of it by no more than this
constexpr float kAlike = 0.9999f;  // normals with a larger cosine between them count as equal

Vec2 vertex(const Hull& hull, int k) { return {hull.x[k], hull.y[k]}; }

}  // namespace

// Where a segment of a chain goes on into the next one without falling away from the body's side, a
// body meets the face of the segment, never its end: a normal that leans towards such an end is wrong.
// `face` becomes the normal of the face on the side of the body. The piece is relative to the centre of the body.
bool Manifolds::Look::end_on(const ManifoldPair& pair, const Hull& piece, const Manifold& m, Vec2& face) const {
  const Vec2 p = vertex(piece, 0), u = vertex(piece, 1) - p;
  const double length = length_of(u);
  face = {-u.y / length, u.x / length};
  const double side = dot(p, face) > 0 ? -1 : 1;
  face = side * face;
  const Vec2 n{m.nx, m.ny};
  const double lean = dot(n, u) / length;  // above 0 if the normal leans towards q
  if (std::fabs(lean) < 1e-3 && dot(n, face) > 0) return false;
  const StaticShape* beyond = statics.chain_neighbour(pair.shape, lean > 0);
  if (beyond == nullptr) return false;
  // The normal of the neighbour on the same side leans away from this segment if the corner is convex.
  const Vec2 w{wrap_sub(beyond->q.x, beyond->p.x) * lattice.pitch_x(),
               wrap_sub(beyond->q.y, beyond->p.y) * lattice.pitch_y()};
  const double far = length_of(w);
  return dot({-w.y / far * side, w.x / far * side}, u) / length * (lean > 0 ? 1 : -1) <= 1e-3;
}

void Manifolds::Look::smooth_joint(ManifoldPair& pair, const Hull& hull, Rotor q, const Hull& piece,
                                   float margin) const {
  Manifold& m = pair.manifold;
  Vec2 normal;
  if (m.count == 0 || piece.count != 2 || !end_on(pair, piece, m, normal)) return;
  const Vec2 p = vertex(piece, 0), u = vertex(piece, 1) - p;
  const auto offset = static_cast<float>(-dot(p, normal));
  const Manifold face =
      meet_plane(hull, q, static_cast<float>(normal.x), static_cast<float>(normal.y), offset - piece.radius, margin);
  m = face;
  m.count = 0;
  for (int k = 0; k < face.count; ++k) {  // points that lie over the segment stay
    const ManifoldPoint& point = face.point[k];
    const double along = dot(Vec2{point.bx, point.by} - p, u) / dot(u, u);
    if (along >= 0 && along <= 1 && point.gap >= -hull.inner) m.point[m.count++] = point;
  }
}

// Whether a contact counts in this step, and whether it lies ahead: the bodies are apart, and may
// close the gap within the step. Its normal is that of the points that are nearest now, which need not be those
// where the bodies will meet.
void Manifolds::Look::judge(ManifoldPair& pair, const Stand& now) const {
  const Manifold& m = pair.manifold;
  pair.active = m.count != 0;
  pair.ahead = pair.ghost = false;
  if (m.count == 0 || (pair.shape >= kWallLeft && pair.shape != PairName::kNone)) return;
  const float least = m.count == 2 ? (pair.gap[0] < pair.gap[1] ? pair.gap[0] : pair.gap[1]) : pair.gap[0];
  if (!(least > kApart * now.inner)) return;
  const float rim_speed =
      std::fabs(b.rim_speed[pair.b]) + (pair.a == PairName::kNone ? 0.0f : std::fabs(b.rim_speed[pair.a]));
  const float closing = rim_speed + g * dt - (m.nx * now.vx + m.ny * now.vy);
  pair.ahead = kAheadFrames * dt * closing >= least;
  if (!pair.ahead && least > now.inner) pair.active = false;
}

// Makes the contact that lies ahead: where B will meet A if B moves by (mx, my) relative to A and turns on as it does.
// Normal and points are those of that moment, gaps those of now. There is no contact if they never meet.
void Manifolds::Look::foresee(ManifoldPair& pair, const Hull& a, Rotor qa, const Hull& hull, Vec2 way, float mx,
                              float my, float inner) const {
  const auto dx = static_cast<float>(way.x), dy = static_cast<float>(way.y);
  const float slack = 0.4f * kApart * inner;
  const double angle = b.angle_of(pair.b);
  const double turn = b.rim_speed[pair.b] / b.radius[pair.b] * params.dt;
  Manifold& m = pair.manifold;
  const Manifold now = m;
  const float share = time_of_impact(a, qa, hull, angle, turn, dx, dy, mx, my, slack);
  pair.margin = -1;  // the manifold serves this step alone
  pair.lasting = false;
  pair.changed = true;
  m.count = 0;
  if (share < 1) {
    const double turned = share * turn;
    const Rotor back = rotor_of(-turned);
    m = collide(a, qa, hull, rotor_of(angle + turned), dx + share * mx, dy + share * my, inner);
    Vec2 face;
    if (pair.a == PairName::kNone && a.count == 2 && end_on(pair, a, m, face)) {
      m = now;  // or the face of a segment of a chain, if there is one
      pair.active = m.count != 0;
      return;
    }
    for (int k = 0; k < m.count; ++k) {
      ManifoldPoint& p = m.point[k];
      const float x = p.bx + hull.radius * m.nx, y = p.by + hull.radius * m.ny;  // this point turns with B
      const float now_x = back.c * x - back.s * y, now_y = back.s * x + back.c * y;
      p.gap += m.nx * (now_x - x - share * mx) + m.ny * (now_y - y - share * my);
      p.bx += now_x - x;
      p.by += now_y - y;
      pair.gap[k] = p.gap;
      pair.impulse[k] = pair.friction[k] = 0;
    }
  }
  pair.active = m.count != 0;
}

// Looks at all fixed pieces near one body, which are its `pairs`. A body that rests on one piece cannot collide with
// another piece that lies wholly below the plane on which it rests. A contact with such a piece comes from a corner
// that sank a little, or from a normal that is kept from before, and is left out. So bodies slide over tiles and chains
// without a bump.
void Manifolds::Look::see_fixed(std::span<ManifoldPair> pairs) const {
  const std::uint32_t slot = pairs[0].b;
  const auto piece_of = [&](const ManifoldPair& pair) {
    const float size = b.radius[slot] + statics[pair.shape].radius + std::fmax(pair.margin, 0.0f);
    return statics.seen_from(pair.shape, b.point(slot), 4.0 * size);
  };
  const auto wall = [](const ManifoldPair& pair) { return pair.shape >= kWallLeft; };
  const float inner = b.kind(b.id[slot]).inner, near = kStep * inner;
  for (ManifoldPair& pair : pairs) {
    if (pair.manifold.count == 0 || pair.moved || wall(pair)) continue;
    const Manifold& m = pair.manifold;
    Hull piece;
    for (const ManifoldPair& other : pairs) {
      if (pair.ghost) break;
      const Manifold& rest = other.manifold;
      if (&other == &pair || !other.active || other.ahead || rest.count == 0) continue;
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
      if (piece.count == 0) piece = piece_of(pair);
      float highest = above(piece.x[0], piece.y[0]);
      for (int n = 1; n < piece.count; ++n) highest = std::fmax(highest, above(piece.x[n], piece.y[n]));
      if (highest + piece.radius <= near) pair.ghost = true;
    }
    if (pair.ghost) pair.active = false;
  }
  const auto fall = [&](double gravity) { return static_cast<float>(gravity * params.dt * params.dt / 2); };
  for (ManifoldPair& pair : pairs) {
    if (!pair.ahead || pair.ghost) continue;
    foresee(pair, piece_of(pair), Rotor{}, b.hulls[b.kind(b.id[slot]).first_hull + pair.part_b], {},
            b.vel[2 * std::size_t{slot}] * dt + fall(params.gravity.x),
            b.vel[2 * std::size_t{slot} + 1] * dt + fall(params.gravity.y), inner);
  }
}

}  // namespace psim
