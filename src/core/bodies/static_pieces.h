// Cuts a static or sleeping body into the pieces that enter the grid of fixed shapes. Discs collide with the edges of a
// polygon one by one, as with segments; shapes with corners collide with the whole polygon.
#pragma once

#include <span>
#include <vector>

#include "base/elementary.h"
#include "base/lattice.h"
#include "base/rotor.h"
#include "bodies/body_store.h"
#include "bodies/hull.h"
#include "bodies/static_shapes.h"

namespace psim {

/// Gives a piece what its part has.
inline void mark(StaticShape& shape, const PartProperties& has) {
  shape.restitution = has.surface.restitution;
  shape.friction = has.surface.friction;
  shape.special = has.is_special();
}

/// Counts the pieces that a moving body is cut into when it falls asleep, and those of them that have a hull.
struct PieceCount {
  std::uint32_t pieces = 0, hulls = 0;
};
inline PieceCount pieces_of(const BodyStore& bodies, const BodyKind& kind) {
  PieceCount count{kind.hull_count == 0 ? 1u : 0u, 0};
  for (std::uint32_t h = 0; h < kind.hull_count; ++h) {
    const int corners = bodies.hulls[kind.first_hull + h].count;
    count.pieces += corners > 2 ? static_cast<std::uint32_t>(corners) + 1 : 1;
    count.hulls += corners > 2;
  }
  return count;
}

/// The pieces of a body at `position`, m, turned by `angle`.
class Pieces {
 public:
  /// The pieces go into `out`, behind those that are there.
  Pieces(Vec2 position, double angle, const Lattice& lattice, std::vector<Piece>& out)
      : list(out), at_(position), turn_(sine_cosine(angle)), lattice_(lattice) {}

  /// Says of which part pieces are, and what it has.
  static void mark(std::span<Piece> pieces, std::uint32_t part, const PartProperties& has) {
    for (Piece& piece : pieces) {
      piece.shape.part = part;
      psim::mark(piece.shape, has);
    }
  }

  void disc(Vec2 centre, float radius) {
    StaticShape& shape = list.emplace_back().shape;
    shape.p = place(centre);
    shape.radius = radius;
  }

  /// In a world that wraps, a long segment is cut: of a way of half the world nobody can tell which way round it leads.
  void segment(Vec2 p, Vec2 q, float radius, bool face) {
    constexpr double kMost = 4096;
    int parts = 1;
    if (lattice_.wraps()) {
      const Vec2 way = turned(turn_, q - p);
      const double quarters =
          greater(std::fabs(way.x) / lattice_.pitch_x(), std::fabs(way.y) / lattice_.pitch_y()) / 0x1p30;
      parts = static_cast<int>(lesser(greater(std::ceil(quarters), 1.0), kMost));
    }
    for (int k = 0; k < parts; ++k) {
      const auto at = [&](int n) { return n == parts ? q : p + (1.0 * n / parts) * (q - p); };
      part_of_segment(at(k), at(k + 1), radius, face);
    }
  }

  void part_of_segment(Vec2 p, Vec2 q, float radius, bool face) {
    StaticShape& shape = list.emplace_back().shape;
    shape.segment = true;
    shape.face = face;
    shape.radius = radius;
    Vec2 from = at_ + turned(turn_, p), to = at_ + turned(turn_, q);
    const bool cut = lattice_.clip(from, to);
    shape.p = cut ? lattice_.to_lattice(from) : place(p);
    shape.q = cut ? lattice_.to_lattice(to) : place(q);
  }

  void solid(const Hull& hull) {
    if (hull.count == 1) return disc(hull.vertex(0), hull.radius);
    if (hull.count == 2) return segment(hull.vertex(0), hull.vertex(1), hull.radius, false);
    for (int k = 0; k < hull.count; ++k) segment(hull.vertex(k), hull.vertex(hull.next(k)), hull.radius, true);
    Piece& piece = list.emplace_back();
    piece.shape.p = lattice_.to_lattice(at_);
    piece.shape.whole = true;
    piece.hull = hull;
    for (int k = 0; k < hull.count; ++k) piece.hull.set_vertex(k, turned(turn_, hull.vertex(k)));
    finish_hull(piece.hull);
  }

  std::vector<Piece>& list;

 private:
  LatticePoint place(Vec2 in_body) const { return lattice_.to_lattice(at_, turned(turn_, in_body)); }

  Vec2 at_;
  SineCosine turn_;
  const Lattice& lattice_;
};

}  // namespace psim
