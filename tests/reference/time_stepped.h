// Elastic hard discs in a walled box by brute force: all pairs and walls are asked anew after every
// event, and no event is kept. Far slower than EventDriven, and so simple that it can judge it.
// Double precision; nothing here includes engine code.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "closed_forms.h"

namespace reference {

class TimeStepped {
 public:
  TimeStepped(double width, double height, std::vector<Disc> discs)
      : width_(width), height_(height), discs_(std::move(discs)) {}

  const std::vector<Disc>& discs() const { return discs_; }
  int collisions() const { return collisions_; }

  /// In steps of dt, each cut at every exact time of contact within it.
  void advance(double duration, double dt) {
    const auto steps = static_cast<int>(std::lround(duration / dt));
    for (int k = 0; k < steps; ++k) step(duration / steps);
  }

 private:
  struct Contact {
    double in = 0;
    std::size_t a = 0, b = 0;  ///< a == b: a wall
    bool sideways = false;
  };

  void step(double dt) {
    for (double left = dt;;) {
      Contact next{left, 0, 0, false};
      const bool found = find_before(left, next);
      for (Disc& d : discs_) d.x = d.x + next.in * d.v;
      left -= next.in;
      if (!found) return;
      resolve(next);
      ++collisions_;
    }
  }

  bool find_before(double limit, Contact& next) const {
    bool found = false;
    const auto offer = [&](double in, std::size_t a, std::size_t b, bool sideways) {
      if (!(in >= 0 && in < limit && in <= next.in)) return;
      next = {in, a, b, sideways};
      found = true;
    };
    for (std::size_t a = 0; a < discs_.size(); ++a) {
      const Disc& d = discs_[a];
      offer(wall_time(d.x.x, d.v.x, d.radius, width_), a, a, true);
      offer(wall_time(d.x.y, d.v.y, d.radius, height_), a, a, false);
      for (std::size_t b = a + 1; b < discs_.size(); ++b)
        offer(pair_time(d, discs_[b]), a, b, false);
    }
    return found;
  }

  static double wall_time(double x, double v, double radius, double size) {
    if (v == 0) return -1;
    return std::max(0.0, (v > 0 ? size - radius - x : x - radius) / std::abs(v));
  }

  // The smaller root of |d + u t|^2 = reach^2, in the textbook's form.
  static double pair_time(const Disc& a, const Disc& b) {
    const Vec d = b.x - a.x, u = b.v - a.v;
    const double half_b = dot(d, u), reach = a.radius + b.radius;
    if (half_b >= 0) return -1;
    const double root2 = half_b * half_b - dot(u, u) * (dot(d, d) - reach * reach);
    return root2 < 0 ? -1 : std::max(0.0, (-half_b - std::sqrt(root2)) / dot(u, u));
  }

  void resolve(const Contact& c) {
    Disc& a = discs_[c.a];
    if (c.a == c.b) {
      (c.sideways ? a.v.x : a.v.y) *= -1;
      return;
    }
    Disc& b = discs_[c.b];
    const Vec d = b.x - a.x;
    const double j = 2 * dot(b.v - a.v, d) / dot(d, d) / (1 / a.mass + 1 / b.mass);
    a.v = a.v + (j / a.mass) * d;
    b.v = b.v - (j / b.mass) * d;
  }

  double width_;
  double height_;
  std::vector<Disc> discs_;
  int collisions_ = 0;
};

}  // namespace reference
