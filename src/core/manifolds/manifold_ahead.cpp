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

// The angular velocity of a body, rad/s.
float turn_of(const BodyStore& b, std::size_t slot) { return b.rim_speed[slot] / b.radius[slot]; }

}  // namespace

Manifold meet_plane(const Hull& hull, Rotor q, float nx, float ny, float offset, float margin) {
  Manifold m;
  m.nx = nx;
  m.ny = ny;
  float x[Hull::kMost] = {}, y[Hull::kMost] = {}, gap[Hull::kMost] = {};
  int first = 0;
  for (int k = 0; k < hull.count; ++k) {
    x[k] = q.c * hull.x[k] - q.s * hull.y[k];
    y[k] = q.s * hull.x[k] + q.c * hull.y[k];
    gap[k] = (nx * x[k] + ny * y[k]) + offset - hull.radius;
    if (gap[k] < gap[first]) first = k;
  }
  const auto add = [&](int k) {
    if (!(gap[k] <= margin)) return;
    ManifoldPoint& p = m.point[m.count++];
    const float middle = hull.radius + 0.5f * gap[k];
    p.bx = x[k] - nx * middle;
    p.by = y[k] - ny * middle;
    p.gap = gap[k];
    p.feature = static_cast<std::uint16_t>(k);
  };
  add(first);
  if (hull.count == 1) return m;
  const int next = (first + 1) % hull.count, before = (first + hull.count - 1) % hull.count;
  const int second = gap[before] < gap[next] ? before : next;
  if (second != first) add(second);
  return m;
}

// Where a segment of a chain goes on into the next one without falling away from the body's side, a
// body meets the face of the segment, never its end: a normal that leans towards such an end is wrong.
// (fx, fy) becomes the normal of the face on the side of the body. The piece is relative to the centre of the body.
bool Manifolds::end_on(const ManifoldParams& params, const ManifoldPair& pair, const Hull& piece, const Manifold& m,
                       double& fx, double& fy) {
  const StaticShapes& statics = *params.statics;
  const double x0 = static_cast<double>(piece.x[0]), y0 = static_cast<double>(piece.y[0]);
  const double ux = static_cast<double>(piece.x[1]) - x0, uy = static_cast<double>(piece.y[1]) - y0;
  const double length = std::sqrt(ux * ux + uy * uy);
  fx = -uy / length;
  fy = ux / length;
  const double side = x0 * fx + y0 * fy > 0 ? -1 : 1;
  fx *= side;
  fy *= side;
  const double nx = static_cast<double>(m.nx), ny = static_cast<double>(m.ny);
  const double lean = (nx * ux + ny * uy) / length;  // above 0 if the normal leans towards q
  if (std::fabs(lean) < 1e-3 && nx * fx + ny * fy > 0) return false;
  const StaticShape* beyond = statics.chain_neighbour(pair.shape, lean > 0);
  if (beyond == nullptr) return false;
  const double px = params.lattice->pitch_x(), py = params.lattice->pitch_y();
  const double wx = wrap_sub(beyond->q.x, beyond->p.x) * px;
  const double wy = wrap_sub(beyond->q.y, beyond->p.y) * py;
  // The normal of the neighbour on the same side leans away from this segment if the corner is convex.
  const double far = std::sqrt(wx * wx + wy * wy);
  const double ox = -wy / far * side, oy = wx / far * side;
  return (ox * ux + oy * uy) / length * (lean > 0 ? 1 : -1) <= 1e-3;
}

void Manifolds::smooth_joint(const ManifoldParams& params, ManifoldPair& pair, const Hull& hull, Rotor q,
                             const Hull& piece, float margin) {
  Manifold& m = pair.manifold;
  double fx = 0, fy = 0;
  if (m.count == 0 || piece.count != 2 || !end_on(params, pair, piece, m, fx, fy)) return;
  const double x0 = static_cast<double>(piece.x[0]), y0 = static_cast<double>(piece.y[0]);
  const double ux = static_cast<double>(piece.x[1]) - x0, uy = static_cast<double>(piece.y[1]) - y0;
  const auto offset = static_cast<float>(-(x0 * fx + y0 * fy));
  const Manifold face =
      meet_plane(hull, q, static_cast<float>(fx), static_cast<float>(fy), offset - piece.radius, margin);
  m = face;
  m.count = 0;
  for (int k = 0; k < face.count; ++k) {  // points that lie over the segment stay
    const double rx = static_cast<double>(face.point[k].bx) - x0;
    const double ry = static_cast<double>(face.point[k].by) - y0;
    const double along = (rx * ux + ry * uy) / (ux * ux + uy * uy);
    if (along < 0 || along > 1 || face.point[k].gap < -hull.inner) continue;
    m.point[m.count++] = face.point[k];
  }
}

// Whether a contact counts in this step, and whether it lies ahead: the bodies are apart, and may
// close the gap within the step. Its normal is that of the points that are nearest now, which need not be those
// where the bodies will meet.
void Manifolds::judge(const BodyStore& b, const ManifoldParams& params, ManifoldPair& pair, float inner, float vx,
                      float vy) const {
  const Manifold& m = pair.manifold;
  pair.active = m.count != 0;
  pair.ahead = pair.ghost = false;
  if (m.count == 0 || (pair.shape >= kWallLeft && pair.shape != PairName::kNone)) return;
  const float least = m.count == 2 ? (pair.gap[0] < pair.gap[1] ? pair.gap[0] : pair.gap[1]) : pair.gap[0];
  if (!(least > kApart * inner)) return;
  const auto dt = static_cast<float>(params.dt);
  const float rim_speed =
      std::fabs(b.rim_speed[pair.b]) + (pair.a == PairName::kNone ? 0.0f : std::fabs(b.rim_speed[pair.a]));
  const float closing = rim_speed + g_ * dt - (m.nx * vx + m.ny * vy);
  pair.ahead = kAheadFrames * dt * closing >= least;
  if (!pair.ahead && least > inner) pair.active = false;
}

// Makes the contact that lies ahead: where B will meet A if B moves by (mx, my) relative to A and turns on as it does.
// Normal and points are those of that moment, gaps those of now. There is no contact if they never meet.
void Manifolds::foresee(const BodyStore& b, const ManifoldParams& params, ManifoldPair& pair, const Hull& a, Rotor qa,
                        const Hull& hull, float dx, float dy, float mx, float my, float inner) const {
  const float slack = 0.4f * kApart * inner;
  const double angle = b.angle.empty() ? 0 : b.angle[pair.b];
  const double turn = static_cast<double>(turn_of(b, pair.b)) * params.dt;
  Manifold& m = pair.manifold;
  const Manifold now = m;
  const float share = time_of_impact(a, qa, hull, angle, turn, dx, dy, mx, my, slack);
  pair.margin = -1;  // the manifold serves this step alone
  pair.lasting = false;
  pair.changed = true;
  m.count = 0;
  if (share < 1) {
    const double turned = static_cast<double>(share) * turn;
    const SineCosine then = sine_cosine(angle + turned), back = sine_cosine(-turned);
    const Rotor q{static_cast<float>(then.cosine), static_cast<float>(then.sine)};
    const auto c = static_cast<float>(back.cosine), s = static_cast<float>(back.sine);
    m = collide(a, qa, hull, q, dx + share * mx, dy + share * my, inner);
    double fx = 0, fy = 0;
    if (pair.a == PairName::kNone && a.count == 2 && end_on(params, pair, a, m, fx, fy)) {
      m = now;  // or the face of a segment of a chain, if there is one
      pair.active = m.count != 0;
      return;
    }
    for (int k = 0; k < m.count; ++k) {
      ManifoldPoint& p = m.point[k];
      const float x = p.bx + hull.radius * m.nx, y = p.by + hull.radius * m.ny;  // this point turns with B
      const float now_x = c * x - s * y, now_y = s * x + c * y;
      p.gap += m.nx * (now_x - x - share * mx) + m.ny * (now_y - y - share * my);
      p.bx += now_x - x;
      p.by += now_y - y;
      pair.gap[k] = p.gap;
      pair.impulse[k] = pair.friction[k] = 0;
    }
  }
  pair.active = m.count != 0;
}

// Looks at all fixed pieces near one body: pairs [begin, end). A body that rests on one piece cannot collide with
// another piece that lies wholly below the plane on which it rests. A contact with such a piece comes from a corner
// that sank a little, or from a normal that is kept from before, and is left out. So bodies slide over tiles and chains
// without a bump.
void Manifolds::see_fixed(const BodyStore& b, const ManifoldParams& params, std::uint32_t begin, std::uint32_t end,
                          std::vector<std::uint64_t>& ghosts) {
  const std::uint32_t slot = pairs_[begin].b;
  const auto piece_of = [&](const ManifoldPair& pair) {
    const StaticShape& s = (*params.statics)[pair.shape];
    return params.statics->seen_from(pair.shape, b.pos[2 * std::size_t{slot}], b.pos[2 * std::size_t{slot} + 1],
                                     4 * static_cast<double>(b.radius[slot] + s.radius + std::fmax(pair.margin, 0.0f)),
                                     b.disp[2 * std::size_t{slot}], b.disp[2 * std::size_t{slot} + 1]);
  };
  const auto wall = [](const ManifoldPair& pair) { return pair.shape >= kWallLeft; };
  const float inner = b.kind(b.id[slot]).inner, near = kStep * inner;
  for (std::uint32_t k = begin; k < end; ++k) {
    ManifoldPair& pair = pairs_[k];
    if (pair.manifold.count == 0 || pair.moved || wall(pair)) continue;
    const Manifold& m = pair.manifold;
    Hull piece;
    for (std::uint32_t o = begin; o < end && !pair.ghost; ++o) {
      const ManifoldPair& other = pairs_[o];
      const Manifold& rest = other.manifold;
      if (o == k || !other.active || other.ahead || rest.count == 0) continue;
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
    if (pair.ghost) {
      pair.active = false;
      ghosts.push_back(std::uint64_t{slot} << 32 | pair.shape);
    }
  }
  const auto dt = static_cast<float>(params.dt);
  const auto fall = [&](double gravity) { return static_cast<float>(gravity * params.dt * params.dt / 2); };
  for (std::uint32_t k = begin; k < end; ++k) {
    ManifoldPair& pair = pairs_[k];
    if (!pair.ahead || pair.ghost) continue;
    foresee(b, params, pair, piece_of(pair), Rotor{}, b.hulls[b.kind(b.id[slot]).first_hull + pair.part_b], 0, 0,
            b.vel[2 * std::size_t{slot}] * dt + fall(params.gravity.x),
            b.vel[2 * std::size_t{slot} + 1] * dt + fall(params.gravity.y), inner);
  }
}

}  // namespace psim
