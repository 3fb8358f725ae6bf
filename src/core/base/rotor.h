// Vectors and boxes of the plane, and rotations. Sine and cosine are polynomials of our own, because those of C libraries
// differ from one platform to another.
#pragma once

#include <cmath>

#include "least.h"
#include "psim/types.h"

namespace psim {

struct SineCosine {
  double sine = 0, cosine = 1;
};

/// Sine and cosine of a finite angle in radians, to a relative error of 1e-15 for |angle| < 1e6 (of larger angles, to what
/// a double of them tells of the direction).
SineCosine sine_cosine(double angle);

/// A rotation in single precision: cosine and sine.
struct Rotor {
  float c = 1, s = 0;
};
inline Rotor rotor_of(double angle) {
  const SineCosine q = sine_cosine(angle);
  return {kernels::snapped(q.cosine), kernels::snapped(q.sine)};
}

inline Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
inline Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
inline Vec2 operator*(double f, Vec2 a) { return {f * a.x, f * a.y}; }
inline double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
inline double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
inline Vec2 upright(Vec2 v) { return {-v.y, v.x}; }  ///< turned by a quarter turn to the left
inline double length_of(Vec2 v) { return std::sqrt(dot(v, v)); }
inline Vec2 turned(SineCosine q, Vec2 v) { return {q.cosine * v.x - q.sine * v.y, q.sine * v.x + q.cosine * v.y}; }

inline bool contains(const Bounds& b, Vec2 p) {
  return p.x >= b.xmin && p.x <= b.xmax && p.y >= b.ymin && p.y <= b.ymax;
}
inline bool overlap(const Bounds& a, const Bounds& b) {
  return a.xmin <= b.xmax && a.xmax >= b.xmin && a.ymin <= b.ymax && a.ymax >= b.ymin;
}

}  // namespace psim
