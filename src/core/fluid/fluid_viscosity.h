// Viscosity: (1 - theta dt nu Laplace) w = u for each component of the velocity, then u becomes u + (w - u) / theta. With
// theta = 1/2 that is the rule of Crank and Nicolson; honey takes a theta near 1, which does not swing. At a free surface
// nothing drags; walls and bodies hold what touches them, and bodies bear what that takes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fluid/fluid_bodies.h"
#include "fluid/fluid_solver.h"

namespace psim {

enum class Component : std::uint8_t { u, v };

/// How viscosity acts in a step.
struct Viscosity {
  double by_x = 0, by_y = 0;   ///< dt nu / cell^2 along an axis
  float per_x = 0, per_y = 0;  ///< 1/m: cells along an axis
  bool held = false;           ///< walls or bodies hold the fluid
  /// The share of the new velocity in the one that drags. It sees the pressure of the last step, so that what it gets wrong
  /// comes back in the next pressure: by s / (1 + theta s) of itself, s being the stiffness. That must be less than 1.
  double theta() const;
};

/// A face of a tile that a body beside it holds.
struct FluidHold {
  std::uint32_t node = 0, body = 0;  ///< of the face; the body's number in FluidBodies
  float rate = 0;   ///< theta dt nu / cell^2, times the density of the face, by that of the first fluid
  float drawn = 0;  ///< m/s: the speed of the body there that the equations have
  float arm = 0;    ///< m: times the body's spin, rad/s, what that adds to its speed there
};

/// Makes the equations of a tile for one component, times the density of each face; kEven begins with the present velocity.
/// Returns the largest right side (kUneven) without bodies, m/s. make_equations() was called for all tiles.
/// `holds`: of the bodies around the tile.
float make_viscous_equations(FluidGrid& grid, std::size_t tile, const FluidSpace& space, const Viscosity& by,
                             Component of, FluidBodies& bodies, std::vector<FluidHold>& holds);
/// Changes the velocity of a tile's faces by what was found in kEven, and keeps the change in kDragU or kDragV.
void drag_faces(FluidGrid& grid, std::size_t tile, const Viscosity& by, Component of);

/// The bodies that hold faces. Their velocities are unknowns of the equations, too, so that the lightest one goes with honey:
/// they are eliminated, and what is left of them adds to the matrix (apply()). Of one component; both change a body's spin.
class HeldBodies : public SolverRows {
 public:
  /// `holds`: by tile. `cell`: kg, the mass of a full one. They outlive it.
  HeldBodies(std::span<const std::vector<FluidHold>> holds, Component of, FluidBodies& bodies, double cell)
      : holds_(holds), of_(of), bodies_(bodies), cell_(cell) {}
  /// Takes the bodies' motion into the right sides, as far as it does not depend on the fluid.
  void begin(FluidGrid& grid);
  /// Whether there is one that moves.
  bool any() const { return any_; }
  double apply(FluidGrid& grid, std::size_t x, std::size_t change) override;
  /// Bodies bear what they gave to faces.
  void bear(FluidGrid& grid, const Viscosity& by);

 private:
  /// A body's speed along the component, m/s, and its spin, rad/s; or what changes them.
  struct Motion {
    double speed = 0, spin = 0;
    double at(float arm) const { return speed + spin * static_cast<double>(arm); }
  };
  /// Sums of the holds of a body: (M + K) v = M v0 + sum k w, times the inverse masses, which may be 0.
  struct Body {
    double k = 0, arm = 0, square = 0;  // of k in kg, of k times the arm, of k times its square
    Motion base;                        // v, without w
    Motion gain;                        // sum k w
  };
  void sum(const FluidGrid& grid, std::size_t field);
  Motion solve(std::size_t body, double speed, double spin) const;
  template <class Each>
  void each(const Each& visit) const;

  std::span<const std::vector<FluidHold>> holds_;
  Component of_;
  FluidBodies& bodies_;
  double cell_;
  std::vector<Body> sums_;
  bool any_ = false;
};

}  // namespace psim
