// Cuts a static or sleeping body into the pieces that enter the grid of fixed shapes. Discs collide with the edges of a
// polygon one by one, as with segments; shapes with corners collide with the whole polygon.
#pragma once

#include <vector>

#include "base/lattice.h"
#include "base/rotor.h"
#include "bodies/hull.h"
#include "bodies/static_shapes.h"

namespace psim {

/// The pieces of a body at `position`, m, turned by `angle`.
class Pieces {
 public:
  /// The pieces go into `out`, which is emptied first.
  Pieces(Vec2 position, double angle, const Lattice& lattice, std::vector<Piece>& out)
      : list(out), at_(position), turn_(sine_cosine(angle)), lattice_(lattice) {
    list.clear();
  }

  void disc(Vec2 centre, float radius) {
    StaticShape& shape = list.emplace_back().shape;
    shape.p = lattice_.to_lattice(at_, turned(turn_, centre));
    shape.radius = radius;
  }

  void segment(Vec2 p, Vec2 q, float radius, bool face) {
    StaticShape& shape = list.emplace_back().shape;
    shape.segment = true;
    shape.face = face;
    shape.radius = radius;
    const Vec2 whole[2] = {at_ + turned(turn_, p), at_ + turned(turn_, q)};
    Vec2 from = whole[0], to = whole[1];
    lattice_.clip(from, to);
    const bool cut = from.x != whole[0].x || from.y != whole[0].y || to.x != whole[1].x || to.y != whole[1].y;
    shape.p = cut ? lattice_.to_lattice(from) : lattice_.to_lattice(at_, turned(turn_, p));
    shape.q = cut ? lattice_.to_lattice(to) : lattice_.to_lattice(at_, turned(turn_, q));
  }

  void solid(const Hull& hull) {
    const auto n = static_cast<std::size_t>(hull.count);
    const auto vertex = [&](std::size_t k) {
      return Vec2{static_cast<double>(hull.x[k % n]), static_cast<double>(hull.y[k % n])};
    };
    if (n == 1) return disc(vertex(0), hull.radius);
    if (n == 2) return segment(vertex(0), vertex(1), hull.radius, false);
    for (std::size_t k = 0; k < n; ++k) segment(vertex(k), vertex(k + 1), hull.radius, true);
    Piece& piece = list.emplace_back();
    piece.shape.p = lattice_.to_lattice(at_);
    piece.shape.whole = true;
    piece.hull = hull;
    for (std::size_t k = 0; k < n; ++k) {
      const Vec2 v = turned(turn_, vertex(k));
      piece.hull.x[k] = static_cast<float>(v.x);
      piece.hull.y[k] = static_cast<float>(v.y);
    }
    finish_hull(piece.hull);
  }

  std::vector<Piece>& list;

 private:
  Vec2 at_;
  SineCosine turn_;
  const Lattice& lattice_;
};

}  // namespace psim
