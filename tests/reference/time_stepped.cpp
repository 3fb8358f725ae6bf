#include "time_stepped.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace reference {

void TimeStepped::advance(double duration, double dt) {
  const auto steps = static_cast<int>(std::lround(duration / dt));
  for (int k = 0; k < steps; ++k) step(duration / steps);
}

void TimeStepped::step(double dt) {
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

bool TimeStepped::find_before(double limit, Contact& next) const {
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
    for (std::size_t b = a + 1; b < discs_.size(); ++b) offer(pair_time(d, discs_[b]), a, b, false);
  }
  return found;
}

double TimeStepped::wall_time(double x, double v, double radius, double size) {
  if (v == 0) return -1;
  return std::max(0.0, (v > 0 ? size - radius - x : x - radius) / std::abs(v));
}

double TimeStepped::pair_time(const Disc& a, const Disc& b) {
  const Vec d = b.x - a.x, u = b.v - a.v;
  const double half_b = dot(d, u), reach = a.radius + b.radius;
  if (half_b >= 0) return -1;
  const double root2 = half_b * half_b - dot(u, u) * (dot(d, d) - reach * reach);
  return root2 < 0 ? -1 : std::max(0.0, (-half_b - std::sqrt(root2)) / dot(u, u));
}

void TimeStepped::resolve(const Contact& c) {
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

}  // namespace reference
