// Hulls that turn, and the impulses of an impact of two shapes in one or two points: for shape_impact.h alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/rotor.h"
#include "manifolds/manifolds.h"

namespace psim::shape_impact {

// How far a hull reaches along n, m.
inline double top_of(const Hull& hull, Rotor q, Vec2 n) {
  const Vec2 own = turned({-double{q.s}, q.c}, n);
  double top = dot(own, hull.vertex(0));
  for (int k = 1; k < hull.count; ++k) top = std::max(top, dot(own, hull.vertex(k)));
  return top + double{hull.radius};
}

// The corners of a turning hull: how far each lies behind the foremost one along n, and how fast the rotation moves it
// along n.
struct Corners {
  double behind[Hull::kMost] = {}, speed[Hull::kMost] = {};  // m, m/s
  Corners(const Hull& hull, Rotor q, double omega, Vec2 n) {
    const Vec2 own = turned({-double{q.s}, q.c}, n), across = omega * Vec2{own.y, -own.x};  // in the axes of the hull
    double most = -1e300;
    for (int k = 0; k < hull.count; ++k) {
      behind[k] = dot(own, hull.vertex(k));
      speed[k] = dot(across, hull.vertex(k));
      most = std::max(most, behind[k]);
    }
    for (int k = 0; k < hull.count; ++k) behind[k] = most - behind[k];
  }
};

// A body within a substep. One that is part of the world has no slot and does not move.
struct Mover {
  std::uint32_t slot = ManifoldPair::kNone;
  Vec2 v, a;                    // m/s, m/s^2
  Vec2 falls;                   // m/s^2: of a, what is not from contacts
  double angle = 0, omega = 0;  // rad, rad/s
  Rotor now;                    // of the angle
  double inv_mass = 0, inv_inertia = 0;
  double since = 0;  // s: its last impact
  double alpha = 0;  // rad/s^2: from what presses on it

  Rotor rotor(double t) const {
    const double turn = t * (omega + 0.5 * t * alpha);
    return turn == 0 ? now : rotor_of(angle + turn);
  }
  Vec2 way(double t) const { return t * v + 0.5 * t * t * a; }
  Vec2 velocity(double t, Vec2 arm) const { return v + t * a + (omega + t * alpha) * Vec2{-arm.y, arm.x}; }
  // The velocity that an impulse along n adds at a point, along m.
  double gain(Vec2 arm, Vec2 n, Vec2 arm_m, Vec2 m) const {
    return inv_mass * dot(n, m) + inv_inertia * cross(arm, n) * cross(arm_m, m);
  }
};

// The points of a pair that collide.
struct Hit {
  double time = 0;
  Manifold m;
  Vec2 n;
  int count = 0;
  Vec2 arm_a[2], arm_b[2];
  double approach[2] = {};  // m/s along n, < 0
  double gap[2] = {};       // m
  double impulse[2] = {};
  double wait = 1e30;     // s: until the first of them touches
  double parting = 1e30;  // m/s: of the slowest point that touches
  double depth = 0;       // m
};

// The impulse of all points of a hit on B, and what it does to the rotations of both.
struct Push {
  Vec2 sum;                       // N s
  double turn_a = 0, turn_b = 0;  // N m s

  explicit Push(const Hit& hit) {
    for (int k = 0; k < hit.count; ++k) add(hit, k, hit.impulse[k] * hit.n);
  }
  void add(const Hit& hit, int k, Vec2 impulse) {
    sum = sum + impulse;
    turn_a -= cross(hit.arm_a[k], impulse);
    turn_b += cross(hit.arm_b[k], impulse);
  }
};

// The velocity along m of point j that an impulse along n at point i adds.
inline double gain(const Mover& a, const Mover& b, const Hit& hit, int i, Vec2 n, int j, Vec2 m) {
  return a.gain(hit.arm_a[i], n, hit.arm_a[j], m) + b.gain(hit.arm_b[i], n, hit.arm_b[j], m);
}

// Impulses that turn the approach of each point into e times as fast a parting. Where they would have to pull, one point
// collides alone.
inline void find_impulses(const Mover& a, const Mover& b, double e, Hit& hit) {
  const auto k = [&](int i, int j) { return gain(a, b, hit, i, hit.n, j, hit.n); };
  const auto wanted = [&](int i) { return -(1 + e) * hit.approach[i]; };
  if (hit.count == 2) {
    const double k11 = k(0, 0), k12 = k(0, 1), k22 = k(1, 1), det = k11 * k22 - k12 * k12;
    hit.impulse[0] = (k22 * wanted(0) - k12 * wanted(1)) / det;
    hit.impulse[1] = (k11 * wanted(1) - k12 * wanted(0)) / det;
    if (det > 1e-6 * k11 * k22 && hit.impulse[0] >= 0 && hit.impulse[1] >= 0) return;
  }
  const int first = hit.count == 2 && hit.approach[1] < hit.approach[0] ? 1 : 0;
  hit.impulse[first] = wanted(first) / k(first, first);
  hit.impulse[1 - first] = 0;
}

// The J >= 0 with M J >= r and J (M J - r) = 0 for one point or two.
inline void solve_normals(const double (&m)[2][2], const double (&r)[2], Hit& hit) {
  const double slack = 1e-9 * (std::fabs(r[0]) + std::fabs(r[1]));
  double(&j)[2] = hit.impulse;
  const int first = hit.count == 2 && r[1] * m[0][0] > r[0] * m[1][1] ? 1 : 0;
  for (const int i : {first, 1 - first}) {
    if (i >= hit.count || !(m[i][i] > 0)) continue;
    j[i] = std::max(r[i] / m[i][i], 0.0);
    j[1 - i] = 0;
    if (hit.count == 1 || m[1 - i][i] * j[i] >= r[1 - i] - slack) return;
  }
  if (hit.count == 1) return;
  const double det = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  const double both[2] = {(m[1][1] * r[0] - m[0][1] * r[1]) / det, (m[0][0] * r[1] - m[1][0] * r[0]) / det};
  if (det > 1e-9 * m[0][0] * m[1][1] && both[0] >= 0 && both[1] >= 0) {
    j[0] = both[0], j[1] = both[1];
    return;
  }
  j[first] = std::max(r[first] / m[first][first], 0.0);
  j[1 - first] = 0;
}

// Finds the impulses of an impact in which friction acts together with the points that press: as a wedge, it changes who
// presses. Two rows of normals, M J >= r, are left once friction is put in: that which holds, else that which slips.
inline double find_rough_impulses(const Mover& a, const Mover& b, Vec2 t, int at, double vt, double mu, double e,
                                  Hit& hit) {
  const auto k = [&](int i, Vec2 n, int j, Vec2 m) { return gain(a, b, hit, i, n, j, m); };
  const double ktt = k(at, t, at, t);
  double slip = 0;
  for (const bool holds : {true, false}) {
    if (holds && !(mu > 0)) continue;
    double m[2][2] = {}, r[2] = {}, cross_of[2] = {};
    for (int i = 0; i < hit.count; ++i) cross_of[i] = k(i, hit.n, at, t);
    for (int i = 0; i < hit.count; ++i) {
      r[i] = -hit.approach[i] - e * std::min(hit.approach[i], 0.0) + (holds ? cross_of[i] * vt / ktt : 0.0);
      for (int j = 0; j < hit.count; ++j) {
        m[i][j] = k(i, hit.n, j, hit.n) + (holds ? -cross_of[i] * cross_of[j] / ktt : slip * mu * cross_of[i]);
      }
    }
    solve_normals(m, r, hit);
    const double sum = hit.impulse[0] + hit.impulse[1];
    if (!holds) return slip * mu * sum;
    const double friction = -(vt + cross_of[0] * hit.impulse[0] + cross_of[1] * hit.impulse[1]) / ktt;
    if (std::fabs(friction) <= mu * sum) return friction;
    slip = friction > 0 ? 1 : -1;
  }
  return 0;
}

}  // namespace psim::shape_impact
