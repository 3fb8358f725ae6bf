// Looks at pairs of hulls. For the files of manifolds alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "base/elementary.h"
#include "base/rotor.h"
#include "collide/collide_batch.h"
#include "contacts/contact_model.h"
#include "contacts/edge_contact.h"
#include "manifolds/manifolds.h"

namespace psim {

// A manifold lasts while no point of its bodies has moved, relative to the other body, by more than this share of the
// smaller inner radius.
inline constexpr float kLasting = 0.02f;
inline constexpr float kLanding = 0.01f;  // rad in a step: bodies that turn less meet others with the arms of its start
inline constexpr float kFading = 0.95f;   // factor on offsets in a frame
inline constexpr float kNearby = 0.02f;   // contacts are looked for up to this share of the inner radius
inline constexpr float kApart = 0.0005f;  // share of the inner radius: bodies with a larger gap are apart
inline constexpr float kFallen = 0.1f;    // at most this share counts as a gap that gravity closes within the step
inline constexpr float kPlaced =
    0.2f;                              // bodies that are put on each other have no more than this way to go in the step
inline constexpr float kDeep = 0.2f;   // contacts that are deeper, in shares of the inner radius, are watched
inline constexpr float kFlying = 1;    // way in a step, in shares of the inner radius: see flies()
inline constexpr float kSlow = 0.99f;  // bodies whose points move by less cannot fly
inline constexpr float kUnsure = 1e-5f;   // share of the sizes of two hulls: what rounding may make of their gap
inline constexpr float kStep = 0.02f;     // a piece counts as below a plane if it stands out of it by no more than this
inline constexpr float kAlike = 0.9999f;  // normals with a larger cosine between them count as equal
inline constexpr auto kAheadFrames =
    static_cast<float>(kMarginFrames);  // of motion within which contacts are looked for

inline constexpr std::size_t kMostPieces = 64;  // of a floor
// Marks the feature of a point of a manifold that was found anew: its impulse is that of the far point of a floor.
inline constexpr std::uint16_t kCarriesFar = 0x4000;

// Gives recalled impulses to the points of the manifold that was found.
void take_recalled(ManifoldPair& pair);

// Looks at the pairs of a step.
struct Manifolds::Look {
  const Manifolds& manifolds;
  const ManifoldParams& params;
  const BodyStore& b = manifolds.s_.bodies;
  const StaticShapes& statics = manifolds.s_.statics;
  const Lattice& lattice = manifolds.s_.lattice;
  const float g = manifolds.g_;
  const float dt = static_cast<float>(params.dt);

  // How the two sides of a pair stand now.
  struct Stand {
    LatticePoint at;  // from A (or 0) to B
    Rotor qa, qb;
    float vx, vy;   // m/s: the velocity of B relative to A
    float rim;      // m/s: how fast their rims turn, together
    float closing;  // m/s: how fast points of theirs come together at most
    float inner;    // m: the smaller inner radius
    float wanted;   // m: bodies with a smaller gap may touch within the step
  };
  // Pairs of one kind that wait until a kernel has a full batch.
  struct Waiting {
    struct Lane {
      ManifoldPair* pair;
      Stand now;
      const Hull* a;
      const Hull* b;
      std::optional<Hull> own_a, own_b;  // hulls that are made for the pair
    };
    CollideBatch batch;
    Lane lane[kernels::kBlock];
  };

  // The hull of a body. That of a disc is made in `disc`.
  const Hull& hull_of(std::size_t slot, std::uint32_t part, std::optional<Hull>& disc) const {
    if (!manifolds.has_corners(slot)) return disc.emplace(disc_hull(b.radius[slot]));
    return b.hulls[b.kind(b.id[slot]).first_hull + part];
  }

  // No less than the way of a point at a distance of one when it turns from one rotation to another by any angle.
  static float most_swung(Rotor to, Rotor from) {
    const float c = from.c * to.c + from.s * to.s, s = from.c * to.s - from.s * to.c;
    return c > 0 ? 1.42f * std::fabs(s) : 2.0f;  // twice the sine of half the angle
  }

  // m: so many lattice steps and a rest, as lasting_kernel.h computes it.
  static float moved_by(std::int32_t to, std::int32_t from, double pitch, float rest) {
    return static_cast<float>(wrap_sub(to, from)) * static_cast<float>(pitch) + rest;
  }

  // Whether the manifold of a pair still holds. If so, its gaps are computed anew. Fills in how the pair stands.
  bool lasts(ManifoldPair& pair, Stand& now) const {
    const bool fixed = pair.of_piece();
    const std::size_t j = pair.b, i = fixed ? 0 : pair.a;
    const auto rotor = [&](std::size_t slot) { return manifolds.has_corners(slot) ? manifolds.rotor(slot) : Rotor{}; };
    const auto inner_of = [&](std::size_t slot) {
      return manifolds.has_corners(slot) ? manifolds.inner_[slot] : b.radius[slot];
    };
    // The vector from A to B now, and how far it moved since the hulls were looked at.
    now.at = b.point(j);
    if (!fixed) {
      const LatticePoint a = b.point(i);
      now.at = {wrap_sub(now.at.x, a.x), wrap_sub(now.at.y, a.y), now.at.dx - a.dx, now.at.dy - a.dy};
    }
    now.qb = rotor(j);
    now.qa = fixed ? Rotor{} : rotor(i);
    const float move_x = moved_by(now.at.x, pair.base.x, lattice.pitch_x(), now.at.dx - pair.base.dx);
    const float move_y = moved_by(now.at.y, pair.base.y, lattice.pitch_y(), now.at.dy - pair.base.dy);
    // Bodies with a smaller gap may touch within the step.
    now.vx = b.vel[2 * j], now.vy = b.vel[2 * j + 1];
    float rim_speed = std::fabs(b.rim_speed[j]);
    now.inner = inner_of(j);
    if (!fixed) {
      now.vx -= b.vel[2 * i];
      now.vy -= b.vel[2 * i + 1];
      rim_speed += std::fabs(b.rim_speed[i]);
      if (!pair.fixed_a) now.inner = std::min(now.inner, inner_of(i));
    }
    now.rim = rim_speed;
    const float closing = now.closing = std::sqrt(now.vx * now.vx + now.vy * now.vy) + rim_speed + g * dt;
    now.wanted = wanted_of(now.inner, dt, closing);

    const auto turned = [](Rotor to, Rotor from) { return std::fabs(from.c * to.s - from.s * to.c); };
    const float gone = std::sqrt(move_x * move_x + move_y * move_y);
    const float moved =
        gone + b.radius[j] * turned(now.qb, pair.turn_b) + (fixed ? 0.0f : b.radius[i] * turned(now.qa, pair.turn_a));
    if (pair.is_apart()) {
      const float swung = b.radius[j] * most_swung(now.qb, pair.turn_b) +
                          (fixed ? 0.0f : b.radius[i] * most_swung(now.qa, pair.turn_a));
      if (margin_of(now) + gone + swung <= pair.gap[0]) return true;
    }
    const bool serves = pair.margin >= 0 && now.wanted + moved <= pair.margin && moved < kLasting * now.inner;
    if (!serves || pair.of_floor() || (!pair.lasting && pair.manifold.count != 0)) return false;
    const Manifold& m = pair.manifold;
    for (int k = 0; k < m.count; ++k) {
      const ManifoldPoint& p = m.point[k];
      // The arms turned with their bodies since then, all but the part that is rounding.
      const auto swung = [&](Rotor to, Rotor from, float rx, float ry) {
        const float c = from.c * to.c + from.s * to.s - 1, s = from.c * to.s - from.s * to.c;
        return m.nx * (c * rx - s * ry) + m.ny * (s * rx + c * ry);
      };
      float s = p.gap + (m.nx * move_x + m.ny * move_y);
      s += swung(now.qb, pair.turn_b, p.bx + pair.round_b * m.nx, p.by + pair.round_b * m.ny);
      if (!fixed) {
        s -= swung(now.qa, pair.turn_a, p.ax - pair.round_a * m.nx, p.ay - pair.round_a * m.ny);
      }
      pair.gap[k] = s;
    }
    return true;
  }

  // Points are looked for up to this gap, m.
  static float margin_of(float inner, float wanted) { return wanted + 2 * kLasting * inner; }
  static float margin_of(const Stand& now) { return margin_of(now.inner, now.wanted); }
  // Bodies with a smaller gap may touch within a step in which points of theirs come together at most so fast, m/s.
  static float wanted_of(float inner, float dt, float closing) { return kNearby * inner + kAheadFrames * dt * closing; }

  // Looks at the hulls of a pair: at once, or together with others of its kind.
  void find(ManifoldPair& pair, const Stand& now, Waiting* waiting, Looks& looks) const {
    const std::size_t j = pair.b;
    const float margin = margin_of(now);
    std::optional<Hull> own_a, own_b;
    const Hull& hull_b = hull_of(j, pair.part_b, own_b);
    pair.round_b = hull_b.radius;
    pair.round_a = 0;
    if (pair.of_wall()) {
      ++looks.alone;
      const auto [nx, ny, height] = params.walls.face(pair.shape, now.at, lattice);
      const Manifold found = meet_plane(hull_b, now.qb, nx, ny, static_cast<float>(height), margin);
      return take(pair, now, found, nullptr, hull_b);
    }
    Vec2 way;
    if (pair.of_piece()) {
      const double size = b.radius[j] + margin + statics[pair.shape].radius;
      own_a = statics.seen_from(pair.shape, b.point(j), 4 * size);
    } else {
      way = lattice.way({}, now.at);
    }
    const auto dx = static_cast<float>(way.x), dy = static_cast<float>(way.y);
    const Hull& hull_a = own_a ? *own_a : hull_of(pair.a, pair.part_a, own_a);
    pair.round_a = hull_a.radius;
    const std::uint32_t kind = CollideBatch::kind_of(hull_a, hull_b);
    if (kind == CollideBatch::kKinds) {
      ++looks.alone;
      take(pair, now, collide(hull_a, now.qa, hull_b, now.qb, dx, dy, margin), &hull_a, hull_b);
      return;
    }
    Waiting& of_kind = waiting[kind];
    Waiting::Lane& lane = of_kind.lane[of_kind.batch.count()];
    lane.pair = &pair;
    lane.now = now;
    lane.a = own_a ? &lane.own_a.emplace(*own_a) : &hull_a;
    lane.b = own_b ? &lane.own_b.emplace(*own_b) : &hull_b;
    of_kind.batch.add(*lane.a, now.qa, *lane.b, now.qb, dx, dy, margin);
    if (of_kind.batch.full()) settle(of_kind, kind, looks);
  }

  // Finds the manifolds of the pairs that wait.
  void settle(Waiting& waiting, std::uint32_t kind, Looks& looks) const {
    const bool in_lanes = waiting.batch.solve(manifolds.s_.kernels, kind);
    const std::uint32_t alone = waiting.batch.alone();
    looks += {in_lanes ? kernels::kBlock : 0u, waiting.batch.count() - alone, alone, 0};
    for (std::uint32_t k = 0; k < waiting.batch.count(); ++k) {
      const Waiting::Lane& lane = waiting.lane[k];
      take(*lane.pair, lane.now, waiting.batch.manifold(k), lane.a, *lane.b);
    }
    waiting.batch.clear();
  }

  // Puts a manifold that was found into its pair.
  void take(ManifoldPair& pair, const Stand& now, const Manifold& found, const Hull* a, const Hull& hull_b) const {
    const float margin = margin_of(now);
    const Manifold old = pair.manifold;
    pair.manifold = found;
    if (pair.fixed_a && a != nullptr && a->count == 2 && found.count != 0) {
      const Vec2 way = pair.of_piece() ? Vec2{} : lattice.way({}, now.at);
      fit_to_segment(pair, pair.manifold, *a, now.qa, hull_b, now.qb, way, way, margin);
    }
    if (params.surfaces) see_surfaces(pair, now);
    pair.placed = pair.margin < 0 && !pair.ahead && pair.recalled == 0 && now.wanted <= kPlaced * now.inner;
    pair.base = now.at;
    pair.turn_a = now.qa;
    pair.turn_b = now.qb;
    pair.margin = margin;
    pair.changed = true;
    // The manifold of a rolling body does not last, since its normal turns in every step.
    const Manifold& m = pair.manifold;
    pair.lasting = m.count == 2 || (pair.round_a == 0 && pair.round_b == 0);
    if (found.count == 0) {
      // Look sees of a piece of fixed geometry only what is near the body.
      const float far = pair.of_piece() ? 2 * hull_b.reach : kNoGap;
      const float gap = std::min(found.point[0].gap, far), sizes = hull_b.reach + (a != nullptr ? a->reach : 0.0f);
      pair.gap[0] = gap - kUnsure * (std::fabs(gap) + sizes);
    }
    if (m.count == 0) pair.lasting = found.count == 0;
    float impulse[2] = {}, friction[2] = {};
    for (int k = 0; k < m.count; ++k) {
      pair.gap[k] = m.point[k].gap;
      for (int o = 0; o < old.count && pair.recalled == 0; ++o) {
        if (old.point[o].feature != m.point[k].feature) continue;
        impulse[k] = pair.impulse[o];
        friction[k] = pair.friction[o];
      }
    }
    if (pair.recalled != 0) {
      take_recalled(pair);
    } else {
      carry_far(pair, old, impulse, friction);
      std::copy(impulse, impulse + 2, pair.impulse);
      std::copy(friction, friction + 2, pair.friction);
    }
    judge(pair, now);
    if (pair.ahead && !pair.fixed_a) {
      foresee(pair, *a, now.qa, hull_b, lattice.way({}, now.at), now.vx * dt, now.vy * dt, now.inner);
    }
  }

  // Sides that are solid from one side (manifold_crossing.cpp).
  bool go_through(ManifoldPair& pair, const Stand& now) const;
  bool is_let_through(ManifoldPair& pair) const;
  void see_surfaces(ManifoldPair& pair, const Stand& now) const;

  // What a body meets of a segment along a normal that was found (manifold_ground.cpp).
  enum class Meets : std::uint8_t { what_was_found, face, nothing };
  Meets at_segment(const ManifoldPair& pair, const Hull& a, Rotor qa, Vec2 way, Vec2 middle, const Manifold& m,
                   Vec2& face) const;
  void fit_to_segment(const ManifoldPair& pair, Manifold& m, const Hull& a, Rotor qa, const Hull& hull_b, Rotor qb,
                      Vec2 start, Vec2 way, float margin) const;
  EdgeCorner corner_at(const ManifoldPair& pair, Vec2 corner, Vec2 out, Vec2 up, float radius) const;
  Hull seen_from_b(const PairName& pair) const;

  // Floors of several pieces (manifold_floor.cpp).
  void carry_far(ManifoldPair& pair, const Manifold& old, float (&impulse)[2], float (&friction)[2]) const;
  bool alike(const ManifoldPair& p, const ManifoldPair& q) const;
  bool lies_in(const ManifoldPair& pair, const Manifold& plane, float height) const;
  bool may_join(const ManifoldPair& pair) const;
  void join_floors(std::span<ManifoldPair* const> pairs) const;

  void foresee_fixed(ManifoldPair& pair) const;
  template <class Each>
  void each_fixed(const ManifoldPair& pair, const Each& each) const;

  // Whether the impact sweeps see to a pair, wherever its bodies are thrown within the step.
  bool is_elastic(const ManifoldPair& pair, const Stand& now) const {
    if (manifolds.sides_of(pair).restitution(manifolds.s_.mixing) != 1) return false;
    const float reach = pair.fixed_a ? b.radius[pair.b] : std::min(b.radius[pair.a], b.radius[pair.b]);
    return dt * std::sqrt(now.vx * now.vx + now.vy * now.vy) <= kMostSizes * reach;
  }

  // Whether a contact counts in this step, and whether it lies ahead: the bodies are apart, and may
  // close the gap within the step. Its normal is that of the points that are nearest now, which need not be those
  // where the bodies will meet.
  void judge(ManifoldPair& pair, const Stand& now) const {
    const Manifold& m = pair.manifold;
    pair.active = m.count != 0;
    pair.ahead = pair.ghost = pair.rocking = pair.landing = false;
    if (m.count == 0) return;
    const float least = pair.least_gap();
    if (m.count == 2 && now.rim * dt > kRocking * now.inner) {
      const float most = std::max(pair.gap[0], pair.gap[1]);
      pair.rocking = 10 * least < most && most < kAheadFrames * dt * now.closing;
    }
    const bool turns = now.rim * dt > kLanding * now.inner;
    pair.landing = turns && pair.of_wall() && least > 0;
    if (pair.of_wall()) return;
    // Gravity alone may close a small gap: what supports one body need not support the other.
    if (!(least > std::max(kApart * now.inner, std::min(g * dt * dt, kFallen * now.inner)))) return;
    const float rim_speed = std::fabs(b.rim_speed[pair.b]) + (pair.of_piece() ? 0.0f : std::fabs(b.rim_speed[pair.a]));
    const float closing = rim_speed + g * dt - (m.nx * now.vx + m.ny * now.vy);
    const bool ahead = kAheadFrames * dt * closing >= least;
    if ((!ahead && !(least > now.inner)) || is_elastic(pair, now)) return;
    pair.ahead = pair.active = ahead;
    pair.landing = turns && ahead;
  }

  // Makes the contact that lies ahead: where B will meet A if B moves by (mx, my) relative to A and turns on as it does.
  // Normal and points are those of that moment, gaps those of now. There is no contact if they never meet. But joints may
  // turn a body within the step: then the pair is open, and each substep looks whether they meet in it.
  void foresee(ManifoldPair& pair, const Hull& a, Rotor qa, const Hull& hull, Vec2 way, float mx, float my,
               float inner) const {
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
      const bool at_end = pair.fixed_a && m.count != 0 && a.count == 2;
      const Meets meets = at_end ? at_segment(pair, a, qa, way, hull.middle_at(angle), m, face) : Meets::what_was_found;
      if (meets == Meets::nothing) {
        m.count = 0;
      } else if (meets == Meets::face) {
        m = now;  // with the face of the segment, if there is one
      } else {
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
    }
    if (m.count == 0 && manifolds.is_tied(pair)) {
      m = now;
      pair.landing = true;
      std::fill_n(pair.gap, 2, kNoGap);
      std::fill_n(pair.impulse, 2, 0.0f);
      std::fill_n(pair.friction, 2, 0.0f);
    }
    pair.active = m.count != 0;
  }
};

// Calls each(name) for all other fixed pieces near the body of a pair.
template <class Each>
void Manifolds::Look::each_fixed(const ManifoldPair& pair, const Each& each) const {
  const std::vector<ManifoldPair>& pairs = manifolds.pairs_;
  const auto other = [&](const ManifoldPair& o) {
    if (&o != &pair && !o.moved && !o.of_wall()) each(o);
  };
  if (manifolds.any_kinematic_) {
    const auto [begin, end] = manifolds.fixed_of(pair.b);
    for (auto k = begin; k != end; ++k) other(pairs[static_cast<std::uint32_t>(*k)]);
    return;
  }
  const auto mine = [&](const ManifoldPair& o) { return o.of_piece() && o.b == pair.b; };
  const ManifoldPair* first = &pair;
  while (first != pairs.data() && mine(first[-1])) --first;
  for (; first != pairs.data() + pairs.size() && mine(*first); ++first) other(*first);
}

}  // namespace psim
