#include "closed_forms.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace reference {

double Bounces::time(int bounce) const {
  double sum = 1;
  for (int k = 1; k <= bounce; ++k) sum += 2 * std::pow(restitution, k);
  return first() * sum;
}

Impact collide(Disc a, Disc b, double restitution, double friction) {
  Impact result;
  const Vec d = b.x - a.x;
  const Vec u = b.v - a.v;
  const double reach = a.radius + b.radius;
  const double closing = dot(d, u);
  const double speed2 = dot(u, u);
  const double discriminant = closing * closing - speed2 * (dot(d, d) - reach * reach);
  if (closing >= 0 || discriminant < 0) return result;
  result.hit = true;
  result.time = (dot(d, d) - reach * reach) / (-closing + std::sqrt(discriminant));
  a.x = a.x + result.time * a.v;
  b.x = b.x + result.time * b.v;

  const Vec between = b.x - a.x;
  const Vec n = (1 / length(between)) * between;
  const Vec t{-n.y, n.x};
  const double inverse = 1 / a.mass + 1 / b.mass;
  const double normal_speed = dot(u, n);
  // Surface speed of b against a at the point of contact.
  const double surface = dot(u, t) - b.omega * b.radius - a.omega * a.radius;
  const double jn = -(1 + restitution) * normal_speed / inverse;
  const double jt = std::clamp(-surface / (3 * inverse), -friction * jn, friction * jn);
  const Vec j = jn * n + jt * t;
  a.v = a.v - (1 / a.mass) * j;
  b.v = b.v + (1 / b.mass) * j;
  // Both spins feel the same torque: arms point at each other, impulses are opposite.
  a.omega -= 2 * jt / (a.mass * a.radius);
  b.omega -= 2 * jt / (b.mass * b.radius);
  result.a = a;
  result.b = b;
  return result;
}

double SlideToRoll::position(double t) const {
  if (t < time()) return speed * t - 0.5 * friction * g * t * t;
  return distance() + rolling_speed() * (t - time());
}

Vec Orbit::position(double t) const {
  const double mean = std::remainder(2 * std::numbers::pi * t / period(), 2 * std::numbers::pi);
  double anomaly = mean + eccentricity * std::sin(mean);
  for (int k = 0; k < 50; ++k) {
    anomaly -= (anomaly - eccentricity * std::sin(anomaly) - mean) / (1 - eccentricity * std::cos(anomaly));
  }
  return {semi_axis * (std::cos(anomaly) - eccentricity),
          semi_axis * std::sqrt(1 - eccentricity * eccentricity) * std::sin(anomaly)};
}

}  // namespace reference
