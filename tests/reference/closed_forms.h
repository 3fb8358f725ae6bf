// Closed forms of mechanics that the engine has to agree with. Double precision, SI, y up; a disc's
// inertia is m r^2 / 2. Written apart from the engine: this library sees the standard library and itself alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace reference {

struct Vec {
  double x = 0;
  double y = 0;
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y}; }
inline Vec operator*(double s, Vec a) { return {s * a.x, s * a.y}; }
inline double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }
inline double cross(Vec a, Vec b) { return a.x * b.y - a.y * b.x; }
inline double length(Vec a) { return std::sqrt(dot(a, a)); }

// ---- one body in flight -----------------------------------------------------------------------

/// y0 + vy0 t - g t^2 / 2
inline double fall_height(double y0, double vy0, double g, double t) { return y0 + vy0 * t - 0.5 * g * t * t; }

/// dv/dt = (0, -g) - k v, from the origin.
inline Vec linear_drag_velocity(Vec v0, double g, double k, double t) {
  const double decay = std::exp(-k * t);
  return {v0.x * decay, (v0.y + g / k) * decay - g / k};
}
inline Vec linear_drag_position(Vec v0, double g, double k, double t) {
  const double grown = -std::expm1(-k * t) / k;
  return {v0.x * grown, -g * t / k + (v0.y + g / k) * grown};
}

/// dv/dt = -q |v| v: speed and distance along the straight path.
inline double quadratic_drag_speed(double v0, double q, double t) { return v0 / (1 + q * v0 * t); }
inline double quadratic_drag_distance(double v0, double q, double t) { return std::log1p(q * v0 * t) / q; }

/// dv/dt = -g - q |v| v from rest: height lost, with the terminal speed w = sqrt(g/q).
inline double quadratic_drag_drop(double g, double q, double t) {
  return std::log(std::cosh(std::sqrt(g * q) * t)) / q;
}

// ---- a disc that bounces on a floor -----------------------------------------------------------

/// Let go at rest `gap` above the floor. Bounces count from 0.
struct Bounces {
  double gap = 1;
  double restitution = 0.8;
  double g = 9.81;

  double first() const { return std::sqrt(2 * gap / g); }
  double time(int bounce) const;
  /// Height of the flight after the bounce.
  double apex(int bounce) const { return gap * std::pow(restitution, 2 * (bounce + 1)); }
  double rest_time() const { return first() * (1 + restitution) / (1 - restitution); }
};

// ---- two discs that hit -----------------------------------------------------------------------

struct Disc {
  Vec x;
  Vec v;
  double radius = 0.5;
  double mass = 1;  ///< infinity: static
  double omega = 0;
};

struct Impact {
  bool hit = false;
  double time = 0;
  Disc a, b;  ///< at the time of impact, velocities after it
};

/// Two free discs up to and through their impact: normal impulse m_r (1 + e) u_n, tangential one
/// what sticking asks for (1 / m_t = 3 (1 / m1 + 1 / m2)), clipped to the cone of friction.
Impact collide(Disc a, Disc b, double restitution, double friction);

// ---- a disc that hits a wall ------------------------------------------------------------------

/// vt' / vt of a disc without spin, `angle` from the wall's normal.
inline double wall_tangential_ratio(double angle, double restitution, double friction) {
  return std::max(1 - friction * (1 + restitution) / std::tan(angle), 2.0 / 3);
}

/// Spin (absolute) after that impact.
inline double wall_spin(double tangential_speed, double ratio, double radius) {
  return 2 * (1 - ratio) * tangential_speed / radius;
}

// ---- friction ---------------------------------------------------------------------------------

/// A body that slides without turning until friction stops it.
struct Slide {
  double speed = 5;
  double friction = 0.5;
  double g = 9.81;

  double time() const { return speed / (friction * g); }
  double distance() const { return speed * speed / (2 * friction * g); }
};

/// A disc set down sliding without spin on level ground: friction slows and spins it up to rolling.
struct SlideToRoll {
  double speed = 5;
  double friction = 0.2;
  double g = 9.81;

  double time() const { return speed / (3 * friction * g); }
  double rolling_speed() const { return 2 * speed / 3; }
  double distance() const { return speed * time() - 0.5 * friction * g * time() * time(); }
  double position(double t) const;
};

/// A disc on an incline of `angle` radians.
struct Incline {
  double angle = 0;
  double friction = 0;
  double radius = 0.5;
  double g = 9.81;

  bool rolls() const { return std::tan(angle) <= 3 * friction; }
  double acceleration() const {
    return rolls() ? 2.0 / 3 * g * std::sin(angle) : g * (std::sin(angle) - friction * std::cos(angle));
  }
  double angular_acceleration() const {
    return rolls() ? acceleration() / radius : 2 * friction * g * std::cos(angle) / radius;
  }
};

/// Least friction with which one disc rests on two that touch each other on level ground.
struct ThreeDiscs {
  static double between_discs() { return std::tan(std::numbers::pi / 12); }
  static double on_ground() { return between_discs() / 3; }
};

// ---- an orbit about a fixed centre ------------------------------------------------------------

/// Kepler ellipse from its pericentre on the +x axis, counter-clockwise.
struct Orbit {
  double gm = 1000;
  double semi_axis = 10;
  double eccentricity = 0.5;

  double period() const { return 2 * std::numbers::pi * std::sqrt(semi_axis * semi_axis * semi_axis / gm); }
  double energy() const { return -gm / (2 * semi_axis); }
  double angular_momentum() const { return std::sqrt(gm * semi_axis * (1 - eccentricity * eccentricity)); }
  Vec start() const { return {semi_axis * (1 - eccentricity), 0}; }
  Vec start_velocity() const { return {0, angular_momentum() / start().x}; }
  /// Position at time t by Newton's iteration of Kepler's equation M = E - e sin E.
  Vec position(double t) const;
  double energy_of(Vec x, Vec v) const { return 0.5 * dot(v, v) - gm / length(x); }
};

}  // namespace reference
