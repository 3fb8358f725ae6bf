// Narrow phase of bodies that are not discs: hulls against hulls, and what may be kept from before.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "manifolds.h"
#include "rotor.h"
#include "tasks.h"

namespace psim {
namespace {

// A manifold lasts while its bodies have moved and turned by less than this share of the smaller one's
// inner radius, at any of their points.
constexpr float kLasting = 0.02f;
constexpr float kThin = 0.2f;       // of the reach: what counts as the inner radius at least
constexpr float kNearby = 0.02f;    // of the inner radius: how far apart contacts are looked for
constexpr float kMarginFrames = 1.25f;
constexpr float kApart = 0.0005f;   // of the inner radius: gap above which bodies are apart
constexpr float kStep = 0.02f;      // how far a piece may stand out of a plane and count as below it
constexpr float kAlike = 0.9999f;   // cosine between normals that say the same

// B against the plane through the point (0, 0) at distance `offset` along the inward normal.
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

// rad/s
float turn_of(const BodyStore& b, std::size_t slot) { return b.spin[slot] / b.radius[slot]; }

}  // namespace

// Looks at one pair: keeps its manifold if it lasts, or finds it anew.
void Manifolds::look(const BodyStore& b, const ManifoldParams& params, ManifoldPair& pair) const {
  pair.column = ManifoldPair::kLoose;
  if (pair.rest_frames != 0) --pair.rest_frames;
  const Lattice& lattice = *params.lattice;
  const bool fixed = pair.a == ManifoldPair::kNone;
  const std::size_t j = pair.b, i = fixed ? 0 : pair.a;
  const auto hull_of = [&](std::size_t slot, std::uint16_t part, Hull& disc) -> const Hull& {
    if ((kind_[slot] & kShape) == 0) return disc = disc_hull(b.radius[slot]);
    return b.hulls[b.make(b.id[slot]).first_hull + part];
  };
  const auto rotor_of = [&](std::size_t slot) {
    return (kind_[slot] & kShape) == 0 ? Rotor{} : rotor(static_cast<std::uint32_t>(slot));
  };
  // From A to B now, and how far from where it was.
  const std::int32_t x = fixed ? b.pos[2 * j] : wrap_sub(b.pos[2 * j], b.pos[2 * i]);
  const std::int32_t y = fixed ? b.pos[2 * j + 1] : wrap_sub(b.pos[2 * j + 1], b.pos[2 * i + 1]);
  const float rest_x = fixed ? b.disp[2 * j] : b.disp[2 * j] - b.disp[2 * i];
  const float rest_y = fixed ? b.disp[2 * j + 1] : b.disp[2 * j + 1] - b.disp[2 * i + 1];
  const double px = lattice.pitch_x(), py = lattice.pitch_y();
  const Rotor qb = rotor_of(j), qa = fixed ? Rotor{} : rotor_of(i);
  const float move_x = static_cast<float>(wrap_sub(x, pair.base_x) * px +
                                          (static_cast<double>(rest_x) - static_cast<double>(pair.base_dx)));
  const float move_y = static_cast<float>(wrap_sub(y, pair.base_y) * py +
                                          (static_cast<double>(rest_y) - static_cast<double>(pair.base_dy)));
  // How far apart they may be and still touch within the step.
  const float g = static_cast<float>(std::sqrt(params.gravity.x * params.gravity.x +
                                               params.gravity.y * params.gravity.y));
  const auto dt = static_cast<float>(params.dt);
  float vx = b.vel[2 * j], vy = b.vel[2 * j + 1], spin = std::fabs(b.spin[j]);
  if (!fixed) {
    vx -= b.vel[2 * i];
    vy -= b.vel[2 * i + 1];
    spin += std::fabs(b.spin[i]);
  }
  const auto inner_of = [&](std::size_t slot) {
    const float reach = b.radius[slot];
    return (kind_[slot] & kShape) == 0 ? reach : std::fmax(b.make(b.id[slot]).inner, kThin * reach);
  };
  const float inner = fixed ? inner_of(j) : std::fmin(inner_of(i), inner_of(j));
  const float closing = std::sqrt(vx * vx + vy * vy) + spin + g * dt;
  const float wanted = kNearby * inner + kMarginFrames * dt * closing;

  const auto turned = [](Rotor now, Rotor then) { return std::fabs(then.c * now.s - then.s * now.c); };
  const float moved = std::sqrt(move_x * move_x + move_y * move_y) + b.radius[j] * turned(qb, pair.turn_b) +
                      (fixed ? 0.0f : b.radius[i] * turned(qa, pair.turn_a));
  const bool serves = pair.margin >= 0 && wanted + moved <= pair.margin &&
                      moved < kLasting * inner;
  if (serves && (pair.lasting || pair.manifold.count == 0)) {
    const Manifold& m = pair.manifold;
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint& p = m.point[k];
      // Of the arms, all but the rounding has turned with its body since.
      const auto swung = [&](Rotor now, Rotor then, float rx, float ry) {
        const float c = then.c * now.c + then.s * now.s - 1, s = then.c * now.s - then.s * now.c;
        return m.nx * (c * rx - s * ry) + m.ny * (s * rx + c * ry);
      };
      float s = p.gap + (m.nx * move_x + m.ny * move_y);
      s += swung(qb, pair.turn_b, p.bx + pair.round_b * m.nx, p.by + pair.round_b * m.ny);
      if (!fixed) {
        s -= swung(qa, pair.turn_a, p.ax - pair.round_a * m.nx, p.ay - pair.round_a * m.ny);
      }
      pair.gap[k] = s;
    }
    judge(b, params, pair, inner, vx, vy);
    if (!pair.ahead) return;
  }

  const float margin = wanted + 2 * kLasting * inner;
  const Manifold old = pair.manifold;
  Hull disc_a, disc_b, piece;
  const Hull& hull_b = hull_of(j, pair.part_b, disc_b);
  pair.round_b = hull_b.radius;
  pair.round_a = 0;
  if (!fixed) {
    const Hull& hull_a = hull_of(i, pair.part_a, disc_a);
    pair.round_a = hull_a.radius;
    const auto dx = static_cast<float>(x * px + static_cast<double>(rest_x));
    const auto dy = static_cast<float>(y * py + static_cast<double>(rest_y));
    pair.manifold = collide(hull_a, qa, hull_b, qb, dx, dy, margin);
  } else if (pair.shape >= kWallLeft) {
    const auto off = [](std::int32_t a, std::int32_t w, float rest_a, float rest_w, double pitch) {
      return static_cast<float>(wrap_sub(a, w) * pitch + (static_cast<double>(rest_a) - static_cast<double>(rest_w)));
    };
    const Walls& w = params.walls;
    switch (pair.shape) {
      case kWallLeft:
        pair.manifold = meet_plane(hull_b, qb, 1, 0, off(x, w.low.x, rest_x, w.low.dx, px), margin);
        break;
      case kWallRight:
        pair.manifold = meet_plane(hull_b, qb, -1, 0, -off(x, w.high.x, rest_x, w.high.dx, px), margin);
        break;
      case kWallBottom:
        pair.manifold = meet_plane(hull_b, qb, 0, 1, off(y, w.low.y, rest_y, w.low.dy, py), margin);
        break;
      default:
        pair.manifold = meet_plane(hull_b, qb, 0, -1, -off(y, w.high.y, rest_y, w.high.dy, py), margin);
    }
  } else {
    const StaticShape& s = (*params.shapes)[pair.shape];
    piece = params.shapes->seen_from(pair.shape, b.pos[2 * j], b.pos[2 * j + 1],
                                     4 * static_cast<double>(b.radius[j] + margin + s.radius),
                                     rest_x, rest_y);
    pair.round_a = piece.radius;
    pair.manifold = collide(piece, Rotor{}, hull_b, qb, 0, 0, margin);
    if (s.segment) smooth_joint(params, pair, hull_b, qb, piece, margin);
  }
  pair.base_x = x;
  pair.base_y = y;
  pair.base_dx = rest_x;
  pair.base_dy = rest_y;
  pair.turn_a = qa;
  pair.turn_b = qb;
  pair.margin = margin;
  pair.changed = true;
  // What rolls does not last: its normal turns with every step.
  const Manifold& m = pair.manifold;
  pair.lasting = m.count == 2 || (pair.round_a == 0 && pair.round_b == 0);
  float impulse[2] = {}, friction[2] = {};
  for (int k = 0; k < m.count; ++k) {
    pair.gap[k] = m.point[k].gap;
    for (int o = 0; o < old.count; ++o) {
      if (old.point[o].feature != m.point[k].feature) continue;
      impulse[k] = pair.impulse[o];
      friction[k] = pair.friction[o];
    }
  }
  std::copy(impulse, impulse + 2, pair.impulse);
  std::copy(friction, friction + 2, pair.friction);
  judge(b, params, pair, inner, vx, vy);
  if (pair.ahead && !fixed) {
    Hull disc_i, disc_j;
    foresee(b, params, pair, hull_of(i, pair.part_a, disc_i), qa, hull_of(j, pair.part_b, disc_j),
            static_cast<float>(x * px + static_cast<double>(rest_x)),
            static_cast<float>(y * py + static_cast<double>(rest_y)), vx * dt, vy * dt, inner);
  }
}

// Where a segment of a chain goes on into the next one without falling away from the body's side, a
// body meets the segment's face, never its end: a normal that leans towards such an end is wrong.
// (fx, fy) becomes the face's normal, on the side of the body, whose centre is the piece's origin.
bool Manifolds::end_on(const ManifoldParams& params, const ManifoldPair& pair, const Hull& piece,
                       const Manifold& m, double& fx, double& fy) {
  const StaticShapes& shapes = *params.shapes;
  const double x0 = static_cast<double>(piece.x[0]), y0 = static_cast<double>(piece.y[0]);
  const double ux = static_cast<double>(piece.x[1]) - x0, uy = static_cast<double>(piece.y[1]) - y0;
  const double length = std::sqrt(ux * ux + uy * uy);
  fx = -uy / length;
  fy = ux / length;
  const double side = x0 * fx + y0 * fy > 0 ? -1 : 1;
  fx *= side;
  fy *= side;
  const double nx = static_cast<double>(m.nx), ny = static_cast<double>(m.ny);
  const double lean = (nx * ux + ny * uy) / length;  // towards q: > 0
  if (std::fabs(lean) < 1e-3 && nx * fx + ny * fy > 0) return false;
  const StaticShape* beyond = shapes.chain_neighbour(pair.shape, lean > 0);
  if (beyond == nullptr) return false;
  const double px = params.lattice->pitch_x(), py = params.lattice->pitch_y();
  const double wx = wrap_sub(beyond->q.x, beyond->p.x) * px;
  const double wy = wrap_sub(beyond->q.y, beyond->p.y) * py;
  // The neighbour's normal on the same side; it leans onwards where the corner is convex.
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
  const Manifold face = meet_plane(hull, q, static_cast<float>(fx), static_cast<float>(fy),
                                   offset - piece.radius, margin);
  m = face;
  m.count = 0;
  for (int k = 0; k < face.count; ++k) {  // what lies over the segment
    const double rx = static_cast<double>(face.point[k].bx) - x0;
    const double ry = static_cast<double>(face.point[k].by) - y0;
    const double along = (rx * ux + ry * uy) / (ux * ux + uy * uy);
    if (along < 0 || along > 1 || face.point[k].gap < -hull.inner) continue;
    m.point[m.count++] = face.point[k];
  }
}

// Whether a contact counts in this step, and whether it lies ahead: the bodies are apart, and may
// close the gap within the step. Its normal is that of the nearest points now, which says nothing of
// where they will meet.
void Manifolds::judge(const BodyStore& b, const ManifoldParams& params, ManifoldPair& pair, float inner,
                      float vx, float vy) const {
  const Manifold& m = pair.manifold;
  pair.active = m.count != 0;
  pair.ahead = pair.ghost = false;
  if (m.count == 0 || (pair.shape >= kWallLeft && pair.shape != PairName::kNone)) return;
  const float least = m.count == 2 ? std::fmin(pair.gap[0], pair.gap[1]) : pair.gap[0];
  if (!(least > kApart * inner)) return;
  const float g = static_cast<float>(std::sqrt(params.gravity.x * params.gravity.x +
                                               params.gravity.y * params.gravity.y));
  const auto dt = static_cast<float>(params.dt);
  const float spin = std::fabs(b.spin[pair.b]) +
                     (pair.a == PairName::kNone ? 0.0f : std::fabs(b.spin[pair.a]));
  const float closing = spin + g * dt - (m.nx * vx + m.ny * vy);
  pair.ahead = kMarginFrames * dt * closing >= least;
  if (!pair.ahead && least > inner) pair.active = false;
}

// The contact that lies ahead: where B will meet A if both go on as they do, by (mx, my) and B's
// turning. Its normal and points are of that moment, its gaps of now. None if they never meet.
void Manifolds::foresee(const BodyStore& b, const ManifoldParams& params, ManifoldPair& pair, const Hull& a,
                        Rotor qa, const Hull& hull, float dx, float dy, float mx, float my,
                        float inner) const {
  const float slack = 0.4f * kApart * inner;
  const double angle = b.angle.empty() ? 0 : b.angle[pair.b];
  const double turn = static_cast<double>(turn_of(b, pair.b)) * params.dt;
  Manifold& m = pair.manifold;
  const Manifold now = m;
  const float share = time_of_impact(a, qa, hull, angle, turn, dx, dy, mx, my, slack);
  pair.margin = -1;  // it is so for this step alone
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
      m = now;  // the face of a chain's segment, if there is one
      pair.active = m.count != 0;
      return;
    }
    for (int k = 0; k < m.count; ++k) {
      ManifoldPoint& p = m.point[k];
      const float x = p.bx + hull.radius * m.nx, y = p.by + hull.radius * m.ny;  // turns with B
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

// The fixed pieces that one body is near, all of them: pairs [begin, end). A body that rests on one of
// them cannot meet another that lies wholly below the plane it rests on, but for that plane: a contact
// that says so is of a corner sunk by a hair, or of one that a frozen normal makes out. So tiles and
// chains are slid over without a bump.
void Manifolds::see_fixed(const BodyStore& b, const ManifoldParams& params, std::uint32_t begin,
                          std::uint32_t end, std::vector<std::uint64_t>& ghosts) {
  const std::uint32_t slot = pairs_[begin].b;
  const auto piece_of = [&](const ManifoldPair& pair) {
    const StaticShape& s = (*params.shapes)[pair.shape];
    return params.shapes->seen_from(pair.shape, b.pos[2 * std::size_t{slot}],
                                    b.pos[2 * std::size_t{slot} + 1],
                                    4 * static_cast<double>(b.radius[slot] + s.radius + std::fmax(pair.margin, 0.0f)),
                                    b.disp[2 * std::size_t{slot}], b.disp[2 * std::size_t{slot} + 1]);
  };
  const auto wall = [](const ManifoldPair& pair) { return pair.shape >= kWallLeft; };
  const float inner = b.make(b.id[slot]).inner, near = kStep * inner;
  for (std::uint32_t k = begin; k < end; ++k) {
    ManifoldPair& pair = pairs_[k];
    if (pair.manifold.count == 0 || wall(pair)) continue;
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
    foresee(b, params, pair, piece_of(pair), Rotor{},
            b.hulls[b.make(b.id[slot]).first_hull + pair.part_b], 0, 0,
            b.vel[2 * std::size_t{slot}] * dt + fall(params.gravity.x),
            b.vel[2 * std::size_t{slot} + 1] * dt + fall(params.gravity.y), inner);
  }
}

void Manifolds::refresh(BodyStore& b, const ManifoldParams& params, const PairTable& table,
                        WorkerPool& pool) {
  const std::size_t strips = table.strips.size();
  keep_impulses(pool);
  pool.run((shaped_.size() + 1023) / 1024, [&](std::size_t t) {
    const std::size_t end = std::min(shaped_.size(), (t + 1) * 1024);
    for (std::size_t n = t * 1024; n < end; ++n) {
      const std::size_t i = shaped_[n];
      const SineCosine q = sine_cosine(b.angle[i]);
      rotor_[2 * i] = static_cast<float>(q.cosine);
      rotor_[2 * i + 1] = static_cast<float>(q.sine);
    }
  });
  pool.run(strips, [&](std::size_t index) {
    bool stale = stale_[index] != 0;
    for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) {
      ManifoldPair& pair = pairs_[k];
      look(b, params, pair);
    }
    std::vector<std::uint64_t>& ghosts = found_[index].ghosts;
    ghosts.clear();
    for (std::uint32_t k = begin_[index]; k < begin_[index + 1];) {
      std::uint32_t end = k + 1;
      if (pairs_[k].a == PairName::kNone) {
        while (end < begin_[index + 1] && pairs_[end].a == PairName::kNone && pairs_[end].b == pairs_[k].b) ++end;
        see_fixed(b, params, k, end, ghosts);
      }
      k = end;
    }
    std::vector<std::uint32_t>& active = strips_[index].active;
    active.clear();
    for (std::uint32_t k = begin_[index]; k < begin_[index + 1]; ++k) {
      ManifoldPair& pair = pairs_[k];
      stale |= pair.active != (pair.lane != PairName::kNone);
      if (pair.active) active.push_back(k);
    }
    stale_[index] = stale;
  });
  ghosts_.clear();
  for (std::size_t s = 0; s < strips; ++s) {
    ghosts_.insert(ghosts_.end(), found_[s].ghosts.begin(), found_[s].ghosts.end());
  }
  std::sort(ghosts_.begin(), ghosts_.end());
}

void Manifolds::lay_out(const BodyStore& b, const HeavyLoads& loads, const ManifoldParams& params,
                        std::uint32_t dummies, WorkerPool& pool) {
  const std::size_t strips = begin_.size() - 1;
  const std::size_t grid = strips - 1;  // the last one is the large bodies' group
  for (std::size_t parity = 0; parity < 2; ++parity) {
    pool.run((grid + 1 - parity) / 2, [&](std::size_t k) {
      lay_out_strip(b, loads, params, dummies, 2 * k + parity);
    });
  }
  lay_out_strip(b, loads, params, dummies, grid);
  points_ = 0;
  colours_ = blocks_ = 0;
  loaded_ = false;
  for (std::size_t s = 0; s < strips; ++s) {
    points_ += strips_[s].points;
    colours_ = std::max(colours_, strips_[s].colours);
    blocks_ += strips_[s].end[3];
    loaded_ |= strips_[s].end[1] != strips_[s].end[0] || strips_[s].end[3] != strips_[s].end[2];
  }
}

float Manifolds::deepest() const {
  float most = 0;
  for (const ManifoldPair& pair : pairs_) {
    for (int k = 0; pair.active && k < pair.manifold.count; ++k) most = std::fmax(most, -pair.gap[k]);
  }
  return most;
}

}  // namespace psim
