#include "solver/approach.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

constexpr int kMostAdvances = 128;

Rotor as_rotor(SineCosine q) { return {static_cast<float>(q.cosine), static_cast<float>(q.sine)}; }

}  // namespace

Approach::Frame Approach::frame(double share) const {
  const double facing = of_a_.facing(share);
  const SineCosine forward = facing != 0 ? sine_cosine(facing) : SineCosine{}, back{-forward.sine, forward.cosine};
  return {back, turned(back, of_b_.place(share) - of_a_.place(share)), turned(back, way_),
          of_b_.facing(share) - facing};
}

// In the frame of A, the centre of B goes with u = w - turn_A x p, which changes no faster than
// |turn_A| (2 |w| + |turn_A| |p|), since the frame turns. A point of B turns about its centre on top of that: no faster
// than |turn| reach, and along the normal as fast as now, changed by at most turn^2 reach for what the rotation adds.
// The distance is no less than what parts A from the vertex of B that lies lowest along the normal of now. Each of them
// has its own height and its own speed.
Approach::Stand Approach::stand(double share, double limit) const {
  const Frame f = frame(share);
  const Vec2 centre = f.pivot - of_a_.arm;
  const SineCosine qb = sine_cosine(f.angle);
  const Nearest near =
      nearest(a_, Rotor{}, b_, as_rotor(qb), static_cast<float>(centre.x), static_cast<float>(centre.y));
  const Vec2 n{near.nx, near.ny};
  const double spin = std::fabs(of_a_.turn), span = length_of(f.way), reach = double{b_.reach} - b_.radius;
  const double growth = spin * (2 * span + spin * (length_of(f.pivot) + span));
  const double closing = -dot(n, f.way - of_a_.turn * upright(f.pivot));
  Stand s{near.distance, 0};
  const double gap = s.distance - limit;
  if (!(gap > 0)) return s;
  s.advance = time_to_close(gap, closing + std::fabs(turn_) * reach, growth);
  if (turn_ == 0 || reach == 0) return s;
  s.advance = greater(time_above(b_, qb, n, gap, closing, turn_, growth + turn_ * turn_ * reach), s.advance);
  return s;
}

double Approach::falls_to(double limit, double tolerance, double from) const {
  double share = from;
  for (int k = 0; k < kMostAdvances; ++k) {
    const Stand now = stand(share, limit);
    if (now.distance <= limit + tolerance) return share;
    share += now.advance;
    if (!(share < 1)) return kNever;
  }
  return share;
}

Manifold Approach::touch(double share, double margin) const {
  const Frame f = frame(share);
  const Vec2 centre = f.pivot - of_a_.arm;
  Manifold m = collide(a_, Rotor{}, b_, rotor_of(f.angle), static_cast<float>(centre.x), static_cast<float>(centre.y),
                       static_cast<float>(margin));
  const SineCosine forward{-f.back.sine, f.back.cosine};
  const auto turn = [&](float& x, float& y) {
    const Vec2 v = turned(forward, {x, y});
    x = static_cast<float>(v.x), y = static_cast<float>(v.y);
  };
  turn(m.nx, m.ny);
  for (int k = 0; k < m.count; ++k) {
    turn(m.point[k].ax, m.point[k].ay);
    turn(m.point[k].bx, m.point[k].by);
  }
  return m;
}

Vec2 Approach::entry(double share) const {
  const Frame first = frame(0), last = frame(share);
  const Vec2 before = b_.middle_at(first.angle), after = b_.middle_at(last.angle);
  const Vec2 from = first.pivot - of_a_.arm + before, way = last.pivot - first.pivot + (after - before);
  const RayCast path = cast_ray(a_, Rotor{}, from.x, from.y, way.x, way.y);
  if (path.fraction > 1) return {};
  return turned({-first.back.sine, first.back.cosine}, {path.nx, path.ny});
}

}  // namespace psim
