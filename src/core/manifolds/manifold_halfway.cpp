// Where bodies turn against each other, a contact holds for the middle of the time for which it serves: normal and arms
// that stand still would lag behind by half of what the bodies turn meanwhile, and what pivots on a corner would lose energy.
#include <algorithm>
#include <cmath>

#include "manifolds/manifold_look.h"

namespace psim {
namespace {

constexpr float kLeastTurn = 1e-3f;  // rad in a step: bodies that turn less
constexpr float kMostTurn = 0.2f;    // rad: they meet anew before
constexpr float kMostFrames = 8;     // a manifold of slow bodies lasts for longer than their motion can be foretold
constexpr float kMostWay = 0.2f;     // share of the inner radius: they slide elsewhere

Vec2 turned_by(double angle, Vec2 v) { return turned(sine_cosine(angle), v); }

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

// The corner of one body turns with it, and the face of the other one with that.
Manifold Manifolds::halfway(const ManifoldPair& pair, float dt, float (&lead)[2]) const {
  const BodyStore& b = s_.bodies;
  lead[0] = lead[1] = 0;
  Manifold m = pair.manifold;
  if (m.count == 0 || (pair.impulse[0] > 0 && pair.impulse[1] > 0)) return m;
  const std::size_t i = pair.of_piece() ? pair.b : pair.a, j = pair.b;
  const float spin_b = b.rim_speed[j] / b.radius[j], spin_a = pair.of_piece() ? 0.0f : b.rim_speed[i] / b.radius[i];
  if (!(dt * std::fmax(std::fabs(spin_a), std::fabs(spin_b)) > kLeastTurn)) return m;
  const double time = half_time(pair, dt), turn_a = time * spin_a, turn_b = time * spin_b;
  if (!(std::fmax(std::fabs(turn_a), std::fabs(turn_b)) < kMostTurn)) return m;
  const ManifoldPoint& near = m.point[m.count == 2 && pair.gap[1] < pair.gap[0] ? 1 : 0];
  const float vx = b.vel[2 * j] - spin_b * near.by, vy = b.vel[2 * j + 1] + spin_b * near.bx;
  float vn = m.nx * vx + m.ny * vy;
  if (!pair.of_piece()) vn -= m.nx * (b.vel[2 * i] - spin_a * near.ay) + m.ny * (b.vel[2 * i + 1] + spin_a * near.ax);
  if (pair.least_gap() > kTouching * inner_of(j) || std::fabs(vn) * dt > kTouching * inner_of(j)) return m;
  const bool of_b = !pair.of_wall() && ((m.point[0].feature >> 6) & 3) == 1;  // the face is that of B
  if (!pair.of_wall() && ((m.point[0].feature >> 6) & 3) > 1) return m;
  const Vec2 u = pair.of_piece() ? Vec2{b.vel[2 * j], b.vel[2 * j + 1]}
                                 : Vec2{b.vel[2 * j] - b.vel[2 * i], b.vel[2 * j + 1] - b.vel[2 * i + 1]};
  if (time * length_of(u) > kMostWay * inner_of(j)) return m;
  lead[0] = static_cast<float>(turn_a), lead[1] = static_cast<float>(turn_b);
  const Vec2 n{m.nx, m.ny}, ahead = turned_by(of_b ? turn_b : turn_a, n);
  for (int k = 0; k < m.count; ++k) {
    ManifoldPoint& p = m.point[k];
    const Vec2 a{p.ax, p.ay}, c{p.bx, p.by};
    Vec2 change;  // of the arm of B
    if (of_b) {
      const double round = pair.round_a;
      const Vec2 to = turned_by(turn_a, a - round * n) + round * ahead;
      change = to - a - time * u;
    } else {
      const double round = pair.round_b;
      change = turned_by(turn_b, c + round * n) - round * ahead - c;
    }
    const Vec2 to_a = a + change + time * u, to_b = c + change;
    p.ax = static_cast<float>(to_a.x), p.ay = static_cast<float>(to_a.y);
    p.bx = static_cast<float>(to_b.x), p.by = static_cast<float>(to_b.y);
  }
  m.nx = static_cast<float>(ahead.x), m.ny = static_cast<float>(ahead.y);
  return m;
}

}  // namespace psim
