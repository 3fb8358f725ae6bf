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
      : list(out), at_(position), lattice_(lattice) {
    list.clear();
    const SineCosine turn = sine_cosine(angle);
    c_ = turn.cosine;
    s_ = turn.sine;
  }

  void disc(double radius) {
    Piece piece;
    piece.shape.p = lattice_.to_lattice(at_);
    piece.shape.radius = static_cast<float>(radius);
    list.push_back(piece);
  }

  void segment(Vec2 p, Vec2 q, double radius, bool face) {
    Piece piece;
    piece.shape.segment = true;
    piece.shape.face = face;
    piece.shape.radius = static_cast<float>(radius);
    const Vec2 whole[2] = {place(p), place(q)};
    Vec2 from = whole[0], to = whole[1];
    lattice_.clip(from, to);
    const bool cut = from.x != whole[0].x || from.y != whole[0].y || to.x != whole[1].x || to.y != whole[1].y;
    piece.shape.p = cut ? lattice_.to_lattice(from) : lattice_.to_lattice(at_, turned(p));
    piece.shape.q = cut ? lattice_.to_lattice(to) : lattice_.to_lattice(at_, turned(q));
    list.push_back(piece);
  }

  void solid(const Hull& hull) {
    const auto n = static_cast<std::size_t>(hull.count);
    const auto vertex = [&](std::size_t k) {
      return Vec2{static_cast<double>(hull.x[k % n]), static_cast<double>(hull.y[k % n])};
    };
    const auto radius = static_cast<double>(hull.radius);
    if (n == 1) {
      Piece piece;
      piece.shape.p = lattice_.to_lattice(at_, turned(vertex(0)));
      piece.shape.radius = hull.radius;
      list.push_back(piece);
      return;
    }
    if (n == 2) return segment(vertex(0), vertex(1), radius, false);
    for (std::size_t k = 0; k < n; ++k) segment(vertex(k), vertex(k + 1), radius, true);
    Piece piece;
    piece.shape.p = lattice_.to_lattice(at_);
    piece.shape.whole = true;
    piece.hull = hull;
    for (std::size_t k = 0; k < n; ++k) {
      const Vec2 v = vertex(k);
      piece.hull.x[k] = static_cast<float>(c_ * v.x - s_ * v.y);
      piece.hull.y[k] = static_cast<float>(s_ * v.x + c_ * v.y);
    }
    finish_hull(piece.hull);
    list.push_back(piece);
  }

  std::vector<Piece>& list;

 private:
  Vec2 turned(Vec2 p) const { return {c_ * p.x - s_ * p.y, s_ * p.x + c_ * p.y}; }
  Vec2 place(Vec2 p) const { return {at_.x + turned(p).x, at_.y + turned(p).y}; }

  Vec2 at_;
  double c_ = 1, s_ = 0;
  const Lattice& lattice_;
};

}  // namespace psim
