// Where bodies turn against each other, a contact holds for the middle of the time for which it serves: normal and arms
// that stand still would lag behind by half of what the bodies turn meanwhile, and what pivots on a corner would lose energy.
#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "manifolds/manifold_look.h"

namespace psim {
namespace {

constexpr float kMostTurn = 0.2f;  // rad: they meet anew before
constexpr float kMostFrames = 8;   // a manifold of slow bodies lasts for longer than their motion can be foretold
constexpr float kMostWay = 0.2f;   // share of the inner radius: they slide elsewhere

// Sine and cosine of an angle below kMostTurn, by the first terms of their series.
SineCosine small_turn(double angle) {
  const double square = angle * angle;
  return {angle * (1 - square / 6), 1 - square / 2 * (1 - square / 12)};
}

}  // namespace

float Manifolds::half_time(const ManifoldPair& pair, float dt) const {
  const BodyStore& b = s_.bodies;
  const float inner = pair.of_piece() ? inner_of(pair.b) : std::min(inner_of(pair.a), inner_of(pair.b));
  float x = b.vel[2 * pair.b], y = b.vel[2 * pair.b + 1], rim = std::fabs(b.rim_speed[pair.b]);
  if (!pair.of_piece()) {
    x -= b.vel[2 * pair.a], y -= b.vel[2 * pair.a + 1];
    rim += std::fabs(b.rim_speed[pair.a]);
  }
  const float lasts = kLasting * inner, speed = std::sqrt(x * x + y * y) + rim;
  if (!pair.lasting || speed * dt >= lasts) return 0.5f * dt;
  return 0.5f * dt * std::min(std::ceil(lasts / (speed * dt)), kMostFrames);
}

// The corner of one body turns with it, and the face of the other one with that. False if the contact as it is now serves.
bool Manifolds::halfway(const ManifoldPair& pair, float dt, Manifold& m, float (&lead)[2]) const {
  const BodyStore& b = s_.bodies;
  const bool fixed = pair.of_piece();
  const std::size_t j = pair.b, i = fixed ? j : pair.a;
  const float spin_b = b.rim_speed[j] / b.radius[j], spin_a = fixed ? 0.0f : b.rim_speed[i] / b.radius[i];
  if (!(dt * std::fabs(spin_b - spin_a) > kRocking)) return false;
  const float touching = kTouching * inner_of(j);
  if (pair.manifold.count == 0 || pair.least_gap() > touching) return false;
  const double time = half_time(pair, dt), turn_a = time * spin_a, turn_b = time * spin_b;
  Vec2 u{b.vel[2 * j], b.vel[2 * j + 1]};
  if (!fixed) u = u - Vec2{b.vel[2 * i], b.vel[2 * i + 1]};
  if (!(greater(std::fabs(turn_a), std::fabs(turn_b)) < kMostTurn) || time * length_of(u) > kMostWay * inner_of(j)) {
    return false;
  }
  const int kind = pair.of_wall() ? 0 : (pair.manifold.point[0].feature >> 6) & 3;
  if (kind > 1) return false;  // two corners
  m = pair.manifold;
  const SineCosine q_a = small_turn(turn_a), q_b = small_turn(turn_b);
  const Vec2 n{m.nx, m.ny}, ahead = turned(kind == 1 ? q_b : q_a, n);
  const ManifoldPoint& near = m.point[m.count == 2 && pair.gap[1] < pair.gap[0] ? 1 : 0];
  const Vec2 slip = u + spin_b * upright({near.bx, near.by}) - spin_a * upright({near.ax, near.ay});
  if (std::fabs(dot(n, slip)) * dt > touching) return false;  // an impact
  for (int k = 0; k < m.count; ++k) {
    ManifoldPoint& p = m.point[k];
    const Vec2 of_a{p.ax, p.ay}, of_b{p.bx, p.by};
    const double round_a = pair.round_a, round_b = pair.round_b;
    const Vec2 change = kind == 1 ? turned(q_a, of_a - round_a * n) + round_a * ahead - of_a - time * u
                                  : turned(q_b, of_b + round_b * n) - round_b * ahead - of_b;
    const Vec2 to_a = of_a + change + time * u, to_b = of_b + change;
    p.ax = static_cast<float>(to_a.x), p.ay = static_cast<float>(to_a.y);
    p.bx = static_cast<float>(to_b.x), p.by = static_cast<float>(to_b.y);
  }
  m.nx = static_cast<float>(ahead.x), m.ny = static_cast<float>(ahead.y);
  lead[0] = static_cast<float>(turn_a), lead[1] = static_cast<float>(turn_b);
  return true;
}

}  // namespace psim
