// Writes a contact as World::contacts gives it, from where its bodies are now. Reads bodies and shapes, owns nothing;
// O(1) a contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/elementary.h"
#include "collide/collide.h"
#include "manifolds/manifolds.h"
#include "psim/contact.h"
#include "query/observed.h"

namespace psim {

class ContactWriter {
 public:
  /// A normal and the separation along it, m.
  struct Meeting {
    Vec2 normal;
    double gap = 0;
  };

  /// What a contact carried. `times` turns the impulses of a lane or a touch into N s.
  struct Load {
    double times = 1;
    float impulse = 0, friction = 0;
  };

  explicit ContactWriter(const Observed& world) : world_(world) {}

  /// Who touches: a body, or kNoSlot for a wall, and which part of it.
  struct Side {
    std::uint32_t id = kNoSlot;
    std::uint32_t part = 0;
  };

  /// The normal goes from first to second.
  Contact contact(const Side& first, const Side& second, Vec2 point, const Meeting& m, const Load& load) const {
    const bool swap = second.id < first.id;
    const Side &a = swap ? second : first, &b = swap ? first : second;
    Contact c;
    c.a = world_.handle(a.id);
    c.b = world_.handle(b.id);
    c.part_a = a.part;
    c.part_b = b.part;
    c.point = point;
    c.normal = (swap ? -1.0 : 1.0) * m.normal;
    c.separation = m.gap;
    c.impulse = load.times * wide(load.impulse) + 0.0;  // -0 becomes 0
    c.friction = load.times * wide(load.friction);
    return c;
  }

  /// The contact of a disc at `at`. Along the normal its surface lies at `arm`, m, from its centre: the arm is negative
  /// where the disc is the second body.
  Contact of_disc(const Side& first, const Side& second, const LatticePoint& at, double arm, const Meeting& m,
                  const Load& load) const {
    const double midway = arm < 0 ? arm - m.gap / 2 : arm + m.gap / 2;
    return contact(first, second, world_.lattice.to_world(at) + midway * m.normal, m, load);
  }

  /// How two discs meet. `normal` is the normal where their centres coincide.
  static Meeting discs(Vec2 to, double reach, Vec2 normal) {
    const double far = length_of(to);
    if (far > 0) return {{to.x / far, to.y / far}, far - reach};
    return {normal, -reach};
  }

  /// How a disc meets a fixed shape. The normal points towards the disc; `normal` is the one that the contact had.
  Meeting fixed(const LatticePoint& at, double r, std::uint32_t shape, Vec2 normal) const {
    const Lattice& lattice = world_.lattice;
    if (shape >= kWallLeft) {
      const auto [nx, ny, height] = world_.walls.face(shape, at, lattice);
      return {{nx, ny}, height - r};
    }
    const StaticShape& s = statics_[shape];
    const Vec2 a = lattice.way(s.p, at);
    const double reach = r + wide(s.radius);
    if (!s.segment) return discs(a, reach, normal);
    const Vec2 u = lattice.way(s.p, s.q);
    const double uu = dot(u, u), along = dot(a, u);
    if (along < 0) return discs(a, reach, normal);
    if (along > uu) return discs(a - u, reach, normal);
    const double length = std::sqrt(uu), side = cross(u, a) / length;  // left of p->q is positive
    double sign = side < 0 || s.face ? -1 : 1;
    if (!s.face && (normal.x != 0 || normal.y != 0)) sign = cross(u, normal) < 0 ? -1 : 1;
    return {{-u.y / length * sign, u.x / length * sign}, side * sign - reach};
  }

  /// Whether a piece is there, or belonged to a sleeper that woke after the step.
  bool stands(std::uint32_t shape) const {
    if (shape >= kWallLeft) return true;
    const StaticShape& s = statics_[shape];
    return s.alive || (s.asleep && b_.info[s.owner].place == Place::moving);
  }
  Side side(std::uint32_t shape) const {
    if (shape >= kWallLeft) return {};
    return {statics_[shape].owner, statics_[shape].part};
  }
  /// The sides of a manifold.
  Side first_of(const ManifoldPair& pair) const {
    return pair.of_piece() ? side(pair.shape) : Side{pair.id_a, pair.part_a};
  }
  Side second_of(const ManifoldPair& pair) const { return {pair.id_b, pair.part_b}; }

  /// A point of a manifold and its gap, from where the bodies are now.
  Meeting manifold(const ManifoldPair& pair, std::uint32_t slot_a, std::uint32_t slot_b, int k, Vec2& point) const {
    const ManifoldPoint& p = pair.manifold.point[k];
    const Vec2 normal{wide(pair.manifold.nx), wide(pair.manifold.ny)};
    const bool fixed = pair.a == PairName::kNone;
    const LatticePoint b = b_.point(slot_b), a = fixed ? LatticePoint{} : b_.point(slot_a);
    const Lattice& lattice = world_.lattice;
    const Vec2 moved{
        wrap_sub(wrap_sub(b.x, a.x), pair.base.x) * lattice.pitch_x() + (wide(b.dx) - wide(a.dx) - wide(pair.base.dx)),
        wrap_sub(wrap_sub(b.y, a.y), pair.base.y) * lattice.pitch_y() + (wide(b.dy) - wide(a.dy) - wide(pair.base.dy))};
    // The arm from a centre to its point. All of it but the rounding has turned with the body since.
    const auto turned_since = [&](Rotor from, std::uint32_t slot, Vec2 arm) {
      const Rotor to = b_.kind(b_.id[slot]).hull_count == 0 ? Rotor{} : rotor_of(b_.angle[slot]);
      const double s = wide(from.c) * wide(to.s) - wide(from.s) * wide(to.c);
      return turned({s, wide(from.c) * wide(to.c) + wide(from.s) * wide(to.s)}, arm);
    };
    double gap = wide(p.gap) + normal.x * moved.x + normal.y * moved.y;
    const Vec2 old_b = Vec2{wide(p.bx), wide(p.by)} + wide(pair.round_b) * normal;
    const Vec2 arm_b = turned_since(pair.turn_b, slot_b, old_b);
    gap += dot(normal, arm_b - old_b);
    if (!fixed) {
      const Vec2 old_a = Vec2{wide(p.ax), wide(p.ay)} - wide(pair.round_a) * normal;
      gap -= dot(normal, turned_since(pair.turn_a, slot_a, old_a) - old_a);
    }
    // The arm ends midway between the surfaces as they were; of a contact that lay ahead it ends where they meet.
    const double back = wide(pair.round_b) + (gap - (pair.ahead ? 0 : wide(p.gap))) / 2;
    point = lattice.to_world(b) + arm_b - back * normal;
    return {normal, gap};
  }

  /// m: between the surfaces of a pair, as its bodies stand now; negative where they overlap.
  double distance(const ManifoldPair& pair) const {
    const Still b = still(pair.id_b);
    const Hull hull_b = b.part(pair.part_b);
    constexpr float kAny = 1e30f;
    if (pair.of_wall()) {
      const auto [normal, height] = fixed(b.at, 0, pair.shape, {});
      const auto nx = static_cast<float>(normal.x), ny = static_cast<float>(normal.y);
      const Manifold m = meet_plane(hull_b, b.q, nx, ny, static_cast<float>(height), kAny);
      return wide(m.count == 2 ? lesser(m.point[0].gap, m.point[1].gap) : m.point[0].gap);
    }
    if (pair.of_piece()) {
      const double reach = wide(b_.properties(pair.id_b).radius) + wide(statics_[pair.shape].radius);
      return wide(nearest(statics_.seen_from(pair.shape, b.at, 4 * reach), {}, hull_b, b.q, 0, 0).distance);
    }
    const Still a = still(pair.id_a);
    const Vec2 to = world_.lattice.way(a.at, b.at);
    const auto x = static_cast<float>(to.x), y = static_cast<float>(to.y);
    return wide(nearest(a.part(pair.part_a), a.q, hull_b, b.q, x, y).distance);
  }

  /// Appends the contacts of two bodies that lie still, or of one and fixed geometry, with what they carried, if they
  /// still touch.
  void keep(const Touch& touch, std::vector<Contact>& out) const {
    touch.of_fixed() ? keep_fixed(touch, out) : keep_pair(touch, out);
  }

 private:
  static constexpr double kStill = 0.02;  // share of the inner radius: bodies that lie still touch up to this gap

  // A body that lies still: its hulls about its centre, or a disc.
  struct Still {
    LatticePoint at;
    Rotor q;
    double radius = 0;            // m: of a disc; else 0
    double margin = 0;            // m: the gap up to which it touches
    const Hull* hulls = nullptr;  // of a body that is no disc
    std::uint32_t parts = 1;
    Hull part(std::uint32_t k) const {
      if (hulls == nullptr) return disc_hull(static_cast<float>(radius));
      return hulls[k < parts ? k : 0];
    }
  };

  Still still(std::uint32_t id) const {
    const auto [at, angle] = world_.stand(id);
    const BodyKind& kind = b_.kind(id);
    const double radius = wide(b_.properties(id).radius);
    if (kind.hull_count == 0) return {at, {}, radius, kStill * radius};
    const double inner = greater(wide(kind.inner), 0.2 * radius);
    return {at, rotor_of(angle), 0, kStill * inner, &b_.hulls[kind.first_hull], kind.hull_count};
  }

  // The factor that converts what a touch carried to N s. `disc` is the disc that touches, if there is one.
  double times(const Touch& touch, std::uint32_t disc) const {
    return world_.desc.substeps * wide(touch.times(false, b_.properties(disc).mass));
  }

  void keep_pair(const Touch& touch, std::vector<Contact>& out) const {
    const std::uint32_t a = touch.first(), b = touch.second();
    const Still sa = still(a), sb = still(b);
    const double factor = times(touch, sa.hulls == nullptr ? a : b);
    const Vec2 to = world_.lattice.way(sa.at, sb.at);
    const double margin = lesser(sa.margin, sb.margin);
    if (sa.hulls == nullptr && sb.hulls == nullptr) {
      const Meeting m = discs(to, sa.radius + sb.radius, {0, 1});
      const Load load{factor, touch.impulse[0], touch.friction[0]};
      if (m.gap <= margin) out.push_back(of_disc({a}, {b}, sa.at, sa.radius, m, load));
      return;
    }
    const Manifold found = collide(sa.part(touch.parts.first), sa.q, sb.part(touch.parts.second), sb.q,
                                   static_cast<float>(to.x), static_cast<float>(to.y), static_cast<float>(margin));
    share(touch, found, {a, touch.parts.first}, {b, touch.parts.second}, sa.at, true, factor, out);
  }

  void keep_fixed(const Touch& touch, std::vector<Contact>& out) const {
    const std::uint32_t id = touch.first(), shape = touch.second();
    const Still s = still(id);
    const double factor = times(touch, id);
    if (s.hulls == nullptr) {
      const Meeting m = fixed(s.at, s.radius, shape, {});
      const Load load{factor, touch.impulse[0], touch.friction[0]};
      if (m.gap <= s.margin) out.push_back(of_disc(side(shape), {id}, s.at, -s.radius, m, load));
      return;
    }
    const auto margin = static_cast<float>(s.margin);
    const Hull hull = s.part(touch.parts.first);
    Manifold manifold;
    if (shape >= kWallLeft) {
      const Meeting m = fixed(s.at, 0, shape, {});
      manifold = meet_plane(hull, s.q, static_cast<float>(m.normal.x), static_cast<float>(m.normal.y),
                            static_cast<float>(m.gap), margin);
    } else {
      const double reach = wide(b_.properties(id).radius) + s.margin + wide(statics_[shape].radius);
      manifold = collide(statics_.seen_from(shape, s.at, 4 * reach), {}, hull, s.q, 0, 0, margin);
    }
    share(touch, manifold, side(shape), {id, touch.parts.first}, s.at, false, factor, out);
  }

  // Gives the impulses of a touch to the points of a manifold, in order along the edge. The arms of side A (`of_a`) or
  // B start at `at`.
  void share(const Touch& touch, const Manifold& m, const Side& a, const Side& b, const LatticePoint& at, bool of_a,
             double times, std::vector<Contact>& out) const {
    const Vec2 centre = world_.lattice.to_world(at);
    const bool flip = m.count == 2 && runs_backwards(m);
    const int nearest = m.count == 2 && m.point[1].gap < m.point[0].gap ? 1 : 0;
    for (int k = 0; k < m.count; ++k) {
      const int from = flip ? 1 - k : k;
      float impulse = touch.impulse[from], friction = touch.friction[from];
      if (static_cast<int>(touch.points) != m.count) {  // the bodies touch with another number of points now
        if (k != nearest) continue;
        impulse = touch.impulse[0] + touch.impulse[1];
        friction = touch.friction[0] + touch.friction[1];
      }
      const ManifoldPoint& p = m.point[k];
      const Vec2 arm{wide(of_a ? p.ax : p.bx), wide(of_a ? p.ay : p.by)};
      out.push_back(contact(a, b, centre + arm, {{m.nx, m.ny}, p.gap}, {times, impulse, friction}));
    }
  }

  const Observed& world_;
  const BodyStore& b_ = world_.bodies;
  const StaticShapes& statics_ = world_.statics;
};

}  // namespace psim
