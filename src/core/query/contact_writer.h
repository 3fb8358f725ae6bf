// Writes a contact as World::contacts gives it, from where its bodies are now. Reads bodies and shapes, owns nothing;
// O(1) a contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "manifolds/collide.h"
#include "manifolds/manifolds.h"
#include "psim/contact.h"
#include "query/observed.h"

namespace psim {

class ContactWriter {
 public:
  /// How a body stands: its centre, its rotation, its hulls.
  struct Stand {
    LatticePoint at;
    Rotor q;
    double radius = 0;            // m: of a disc; else 0
    const Hull* hulls = nullptr;  // of a body that is no disc
    std::uint32_t count = 0;
    double inner = 0;  // m
  };

  /// A normal and the separation along it.
  struct Meeting {
    double nx = 0, ny = 0, gap = 0;
  };

  static double d(float v) { return static_cast<double>(v); }

  explicit ContactWriter(const Observed& world) : world_(world) {}

  /// `first` and `second` are ids, or kNoSlot for a wall. The normal goes from first to second.
  Contact contact(std::uint32_t first, std::uint32_t second, Vec2 point, const Meeting& m, double impulse,
                  double friction) const {
    Contact c;
    c.point = point;
    c.separation = m.gap;
    c.impulse = impulse;
    c.friction = friction;
    const double sign = first < second ? 1 : -1;
    c.a = handle(std::min(first, second));
    c.b = handle(std::max(first, second));
    c.normal = {sign * m.nx, sign * m.ny};
    return c;
  }

  /// The contact of a disc at `at`, of radius r, that lies on the side of `first` (`side` 1) or of `second` (-1).
  /// `pressed` turns its impulses into N s.
  Contact of_disc(std::uint32_t first, std::uint32_t second, const LatticePoint& at, double r, double side,
                  const Meeting& m, double pressed, float impulse, float friction) const {
    const Vec2 centre = world_.to_world(at);
    const double arm = side * (r + m.gap / 2);
    return contact(first, second, {centre.x + arm * m.nx, centre.y + arm * m.ny}, m, pressed * d(impulse),
                   pressed * d(friction));
  }

  Vec2 way(const LatticePoint& from, const LatticePoint& to) const {
    return {wrap_sub(to.x, from.x) * px_ + (d(to.dx) - d(from.dx)),
            wrap_sub(to.y, from.y) * py_ + (d(to.dy) - d(from.dy))};
  }

  /// How two discs meet. (nx, ny) is the normal where their centres coincide.
  static Meeting discs(Vec2 to, double reach, double nx, double ny) {
    const double far = std::sqrt(to.x * to.x + to.y * to.y);
    if (far > 0) return {to.x / far, to.y / far, far - reach};
    return {nx, ny, -reach};
  }

  /// How a disc meets a fixed shape. The normal points towards the disc; (nx, ny) is the normal that the contact had.
  Meeting fixed(const LatticePoint& at, double r, std::uint32_t shape, double nx, double ny) const {
    const auto off = [](std::int32_t a, std::int32_t wall, float rest_a, float rest_w, double pitch) {
      return wrap_sub(a, wall) * pitch + (d(rest_a) - d(rest_w));
    };
    const Walls& w = world_.walls;
    switch (shape) {
      case kWallLeft:
        return {1, 0, off(at.x, w.low.x, at.dx, w.low.dx, px_) - r};
      case kWallRight:
        return {-1, 0, -off(at.x, w.high.x, at.dx, w.high.dx, px_) - r};
      case kWallBottom:
        return {0, 1, off(at.y, w.low.y, at.dy, w.low.dy, py_) - r};
      case kWallTop:
        return {0, -1, -off(at.y, w.high.y, at.dy, w.high.dy, py_) - r};
      default:
        break;
    }
    const StaticShape& s = statics_[shape];
    const Vec2 a = way(s.p, at);
    const double reach = r + d(s.radius);
    if (!s.segment) return discs(a, reach, nx, ny);
    const Vec2 u = way(s.p, s.q);
    const double uu = u.x * u.x + u.y * u.y, along = a.x * u.x + a.y * u.y;
    if (along < 0) return discs(a, reach, nx, ny);
    if (along > uu) return discs({a.x - u.x, a.y - u.y}, reach, nx, ny);
    const double length = std::sqrt(uu),
                 side = (u.x * a.y - u.y * a.x) / length;  // left of p->q is positive
    double sign = side < 0 || s.face ? -1 : 1;
    if (!s.face && (nx != 0 || ny != 0)) sign = nx * -u.y + ny * u.x < 0 ? -1 : 1;
    return {-u.y / length * sign, u.x / length * sign, side * sign - reach};
  }

  /// Whether a piece is there, or belonged to a sleeper that woke after the step.
  bool stands(std::uint32_t shape) const {
    if (shape >= kWallLeft) return true;
    const StaticShape& s = statics_[shape];
    return s.alive || (s.asleep && b_.info[s.owner].place == Place::moving);
  }
  std::uint32_t owner(std::uint32_t shape) const { return shape >= kWallLeft ? kNoSlot : statics_[shape].owner; }

  /// A point of a manifold and its gap, from where the bodies are now.
  Meeting manifold(const ManifoldPair& pair, std::uint32_t slot_a, std::uint32_t slot_b, int k, Vec2& point) const {
    const Manifold& m = pair.manifold;
    const ManifoldPoint& p = m.point[k];
    const double nx = d(m.nx), ny = d(m.ny);
    const LatticePoint b = world_.place(slot_b);
    LatticePoint a;
    if (pair.a != PairName::kNone) a = world_.place(slot_a);
    const Vec2 moved{wrap_sub(wrap_sub(b.x, a.x), pair.base.x) * px_ + (d(b.dx) - d(a.dx) - d(pair.base.dx)),
                     wrap_sub(wrap_sub(b.y, a.y), pair.base.y) * py_ + (d(b.dy) - d(a.dy) - d(pair.base.dy))};
    // The arm from a centre to its point. All of it but the rounding has turned with the body since.
    const auto turned = [](Rotor to, Rotor from, double x, double y) {
      const double c = d(from.c) * d(to.c) + d(from.s) * d(to.s), s = d(from.c) * d(to.s) - d(from.s) * d(to.c);
      return Vec2{c * x - s * y, s * x + c * y};
    };
    double gap = d(p.gap) + nx * moved.x + ny * moved.y;
    const double bx = d(p.bx) + d(pair.round_b) * nx, by = d(p.by) + d(pair.round_b) * ny;
    const Vec2 arm = turned(rotor(slot_b), pair.turn_b, bx, by);
    gap += nx * (arm.x - bx) + ny * (arm.y - by);
    if (pair.a != PairName::kNone) {
      const double ax = d(p.ax) - d(pair.round_a) * nx, ay = d(p.ay) - d(pair.round_a) * ny;
      const Vec2 other = turned(rotor(slot_a), pair.turn_a, ax, ay);
      gap -= nx * (other.x - ax) + ny * (other.y - ay);
    }
    // The arm ends midway between the surfaces as they were; of a contact that lay ahead it ends where they meet.
    const double back = d(pair.round_b) + (gap - (pair.ahead ? 0 : d(p.gap))) / 2;
    const Vec2 centre = world_.to_world(b);
    point = {centre.x + arm.x - back * nx, centre.y + arm.y - back * ny};
    return {nx, ny, gap};
  }

  Stand stand(std::uint32_t id) const {
    const BodyInfo& info = b_.info[id];
    Stand s;
    double angle = 0;
    if (info.place == Place::asleep) {
      s.at = sleepers_.list[info.slot].at;
      angle = sleepers_.list[info.slot].angle;
    } else {
      s.at = world_.place(info.slot);
      if (!b_.angle.empty()) angle = b_.angle[info.slot];
    }
    const BodyKind& kind = b_.kind(id);
    s.count = kind.hull_count;
    if (kind.hull_count == 0) {
      s.radius = s.inner = d(b_.properties(id).radius);
      return s;
    }
    s.q = rotor_of(angle);
    s.hulls = &b_.hulls[kind.first_hull];
    s.inner = std::fmax(d(kind.inner), 0.2 * d(b_.properties(id).radius));
    return s;
  }

  /// Appends the contacts of two bodies that lie still, with what they carried, if they still touch.
  void keep_pair(const Touch& touch, std::uint32_t a, std::uint32_t b, double substeps,
                 std::vector<Contact>& out) const {
    const Stand sa = stand(a), sb = stand(b);
    const double times = substeps * d(touch.times(false, b_.properties(sa.count == 0 ? a : b).mass));
    const Vec2 to = way(sa.at, sb.at);
    const double margin = kStill * std::fmin(sa.inner, sb.inner);
    const Vec2 centre = world_.to_world(sa.at);
    if (sa.count == 0 && sb.count == 0) {
      const Meeting m = discs(to, sa.radius + sb.radius, 0, 1);
      if (m.gap > margin) return;
      out.push_back(of_disc(a, b, sa.at, sa.radius, 1, m, times, touch.impulse[0], touch.friction[0]));
      return;
    }
    const Hull disc_a = disc_hull(static_cast<float>(sa.radius)), disc_b = disc_hull(static_cast<float>(sb.radius));
    Manifold best;
    for (std::uint32_t i = 0; i < std::max(sa.count, 1u); ++i) {
      for (std::uint32_t j = 0; j < std::max(sb.count, 1u); ++j) {
        const Manifold m =
            collide(sa.count != 0 ? sa.hulls[i] : disc_a, sa.q, sb.count != 0 ? sb.hulls[j] : disc_b, sb.q,
                    static_cast<float>(to.x), static_cast<float>(to.y), static_cast<float>(margin));
        if (m.count > best.count || (m.count != 0 && m.count == best.count && m.point[0].gap < best.point[0].gap))
          best = m;
      }
    }
    share(touch, best, a, b, centre, true, times, out);
  }

  /// Appends the contacts of a body that lies still and fixed geometry.
  void keep_fixed(const Touch& touch, std::uint32_t id, std::uint32_t shape, double substeps,
                  std::vector<Contact>& out) const {
    const Stand s = stand(id);
    const double times = substeps * d(touch.times(false, b_.properties(id).mass));
    const Vec2 centre = world_.to_world(s.at);
    const double margin = kStill * s.inner;
    const std::uint32_t other = owner(shape);
    if (s.count == 0) {
      const Meeting m = fixed(s.at, s.radius, shape, 0, 0);
      if (m.gap > margin) return;
      out.push_back(of_disc(other, id, s.at, s.radius, -1, m, times, touch.impulse[0], touch.friction[0]));
      return;
    }
    const auto most = static_cast<float>(margin);
    if (shape >= kWallLeft) {
      const Meeting m = fixed(s.at, 0, shape, 0, 0);
      share(touch,
            meet_plane(s.hulls[0], s.q, static_cast<float>(m.nx), static_cast<float>(m.ny), static_cast<float>(m.gap),
                       most),
            other, id, centre, false, times, out);
      return;
    }
    const double reach = d(b_.properties(id).radius) + margin + d(statics_[shape].radius);
    const Hull piece = statics_.seen_from(shape, s.at, 4 * reach);
    share(touch, collide(piece, {}, s.hulls[0], s.q, 0, 0, most), other, id, centre, false, times, out);
  }

 private:
  static constexpr double kStill = 0.02;  // share of the inner radius: bodies that lie still touch up to this gap

  BodyId handle(std::uint32_t id) const { return id == kNoSlot ? kNoBody : BodyId{id, b_.info[id].generation}; }

  Rotor rotor(std::uint32_t slot) const {
    return b_.kind(b_.id[slot]).hull_count == 0 ? Rotor{} : rotor_of(b_.angle[slot]);
  }

  // Gives the impulses of a touch to the points of a manifold, in order along the edge. The arms of side A (`of_a`) or
  // B start at `centre`.
  void share(const Touch& touch, const Manifold& m, std::uint32_t a, std::uint32_t b, Vec2 centre, bool of_a,
             double times, std::vector<Contact>& out) const {
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
      const Vec2 point{centre.x + d(of_a ? p.ax : p.bx), centre.y + d(of_a ? p.ay : p.by)};
      out.push_back(contact(a, b, point, {d(m.nx), d(m.ny), d(p.gap)}, times * d(impulse), times * d(friction)));
    }
  }

  const Observed& world_;
  const BodyStore& b_ = world_.bodies;
  const StaticShapes& statics_ = world_.statics;
  const Sleepers& sleepers_ = world_.sleep.sleepers;
  const double px_ = world_.lattice.pitch_x(), py_ = world_.lattice.pitch_y();
};

}  // namespace psim
