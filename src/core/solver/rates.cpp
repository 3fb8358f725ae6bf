#include "solver/rates.h"

#include <algorithm>
#include <cmath>

#include "base/elementary.h"

namespace psim {
namespace {

Vec2 speed_at(const Rates& r, Vec2 arm) { return r.along + r.turn * upright(arm); }

void push(Rates& a, Rates& b, const ImpactSurface& s, const ImpactPoint& p, Vec2 impulse) {
  a.along = a.along - s.wa * impulse;
  a.turn -= s.ia * cross(p.a, impulse);
  b.along = b.along + s.wb * impulse;
  b.turn += s.ib * cross(p.b, impulse);
}

}  // namespace

void collide_rates(Rates& a, Rates& b, const ImpactSurface& s, Vec2 n, std::span<const ImpactPoint> points) {
  const auto closing = [&](const ImpactPoint& p) { return dot(n, speed_at(b, p.b) - speed_at(a, p.a)); };
  const auto weight = [&](const ImpactPoint& p, const ImpactPoint& q, Vec2 along) {
    return s.wa + s.wb + s.ia * cross(p.a, along) * cross(q.a, along) + s.ib * cross(p.b, along) * cross(q.b, along);
  };
  double impulse[2] = {};
  const double u0 = closing(points[0]), u1 = points.size() == 2 ? closing(points[1]) : 0;
  const double factor = -lesser(u0, u1) < s.least ? 1 : 1 + s.restitution;
  if (u0 < 0 && u1 < 0) {
    const double k00 = weight(points[0], points[0], n), k01 = weight(points[0], points[1], n),
                 k11 = weight(points[1], points[1], n), det = k00 * k11 - k01 * k01;
    if (det > 1e-6 * k00 * k11) {
      impulse[0] = -factor * (k11 * u0 - k01 * u1) / det;
      impulse[1] = -factor * (k00 * u1 - k01 * u0) / det;
    }
  }
  if (!(impulse[0] > 0 && impulse[1] > 0)) {
    const std::size_t k = u1 < u0 ? 1 : 0;
    const double u = lesser(u0, u1);
    impulse[0] = impulse[1] = 0;
    if (u < 0) impulse[k] = -factor * u / weight(points[k], points[k], n);
  }
  for (std::size_t k = 0; k < points.size(); ++k) push(a, b, s, points[k], impulse[k] * n);
  const Vec2 t = upright(n);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const ImpactPoint& p = points[k];
    const double sliding = dot(t, speed_at(b, p.b) - speed_at(a, p.a)) + s.belt, most = s.friction * impulse[k];
    push(a, b, s, p, std::clamp(-sliding / weight(p, p, t), -most, most) * t);
  }
}

}  // namespace psim
