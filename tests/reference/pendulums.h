// Pendulums, double pendulums and a hanging chain that joints have to agree with: closed forms, or
// Runge-Kutta in double precision. Angles from straight down. It sees no engine code.
#pragma once

#include <array>

namespace reference {

/// The period of a mass on a rod without mass that is let go at rest at `angle`.
double pendulum_period(double length, double angle, double g);

/// Two alike bodies, one hung on the other: masses on rods without mass, or rods.
struct DoublePendulum {
  double length = 1;   ///< from joint to joint
  double centre = 1;   ///< from a joint to the centre of mass below it
  double inertia = 0;  ///< about the centre of mass, over the mass
  double g = 9.81;

  /// Angles and their rates.
  using State = std::array<double, 4>;

  State slope(const State& y) const;
  State after(double time, State start) const;
};

/// How far the middle of a chain of `links` rods (an even number) with alike masses between them
/// hangs below its ends.
double chain_sag(int links, double link, double span);

}  // namespace reference
