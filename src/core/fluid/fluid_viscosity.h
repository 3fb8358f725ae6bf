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
  float rate = 0;                    ///< theta dt nu / cell^2
  float drawn = 0;                   ///< m/s: the speed of the body there that the equations have
  float arm = 0;                     ///< m: times the body's spin, rad/s, what that adds to its speed there
};

/// Makes the equations of a tile for one component; kEven begins with the present velocity, which is the right side
/// (kUneven), too. Returns the largest speed, m/s. make_equations() was called for all tiles.
/// `holds`: of the bodies around the tile.
float make_viscous_equations(FluidGrid& grid, std::size_t tile, const FluidSpace& space, const Viscosity& by,
                             Component of, FluidBodies& bodies, std::vector<FluidHold>& holds);
/// Gives each body beside the fluid the velocity in the equations that it will have if the fluid goes on as it does: a light
/// one goes with honey. `holds`: by tile. `cell`: kg, the mass of a full one.
void expect_bodies(FluidGrid& grid, std::span<std::vector<FluidHold>> holds, Component of, const FluidBodies& bodies,
                   double cell);
/// Changes the velocity of a tile's faces by what was found in kEven, and keeps the change in kDragU or kDragV.
void drag_faces(FluidGrid& grid, std::size_t tile, const Viscosity& by, Component of);
/// Bodies bear what they gave to faces.
void drag_bodies(const FluidGrid& grid, std::span<const std::vector<FluidHold>> holds, const Viscosity& by,
                 Component of, FluidBodies& bodies, double cell);

}  // namespace psim
