// Truths of structures: hanging chains that swing or stretch, soft cantilevers, a rocking block. Closed forms, or one
// unknown found by bisection, in double precision. It sees no engine code.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "closed_forms.h"

namespace reference {

/// The `count` smallest zeros of the Laguerre polynomial of degree n, ascending. A chain of n alike masses on rods of length l that hangs
/// from a point swings at w^2 = x g/l, x one of these; in mode x the k-th mass from below is off by L_k(x).
std::vector<double> laguerre_zeros(int n, std::size_t count);
/// L_n(x).
double laguerre(int n, double x);

/// How far the middle of a chain of `links` springs (an even number) with masses of `weight` N between them hangs below
/// its ends, `span` apart. A spring is `link` long without load and gets longer by load x link / `stretch_load`.
double elastic_chain_sag(int links, double link, double stretch_load, double weight, double span);

/// A cantilever of straight links, each joined to the one before by a spring of `stiffness` N m/rad, the first to a wall;
/// clamped level, loaded by its own weight and a weight at its end. The elastica as the links become short.
struct Cantilever {
  int links = 10;
  double link = 0.1;
  double stiffness = 1;    ///< N m/rad
  double link_weight = 0;  ///< N, each
  double tip_weight = 1;   ///< N

  /// How far the tip is below the wall's point.
  double drop() const;
};

/// A block of `width` x `height` that rocks about its lower corners without slip or bounce (Housner 1963).
struct RockingBlock {
  double width = 0.5;
  double height = 2;

  double slenderness() const;  ///< angle of the diagonal from the vertical
  /// Largest angle after so many impacts, if it was let go at `start`.
  double amplitude(double start, int impacts) const;
};

/// A disc slides without friction over a line of short pieces and does not bounce: at a vertex that turns the way towards
/// it, it loses the part of its velocity that points into the next piece; from one that turns away it flies and lands.
/// Steps of 20 microseconds; the disc may be on either side of the line, but stays near it.
class Track {
 public:
  struct State {
    Vec x, v;
  };

  Track(std::vector<Vec> line, double radius, double g) : line_(std::move(line)), radius_(radius), g_(g) {}

  State after(double time, State s) const;

 private:
  void keep_off(std::size_t piece, State& s) const;
  std::size_t nearest_piece(Vec x) const;

  std::vector<Vec> line_;
  double radius_;
  double g_;
};

}  // namespace reference
