// Viscosity: (1 - theta dt nu Laplace) w = u for each component of the velocity, then u becomes u + (w - u) / theta. With
// theta = 1/2 that is the rule of Crank and Nicolson; honey takes a theta near 1, which does not swing. At a free surface
// nothing drags; walls hold what touches them.
#pragma once

#include "fluid/fluid_solver.h"

namespace psim {

enum class Component : std::uint8_t { u, v };

/// How viscosity acts in a step.
struct Viscosity {
  double by_x = 0, by_y = 0;  ///< dt nu / cell^2 along an axis
  /// The share of the new velocity in the one that drags.
  double theta() const;
};

/// Makes the equations of a tile for one component; kEven begins with the present velocity, which is the right side
/// (kUneven), too. Returns the largest speed, m/s. make_equations() was called for all tiles.
/// `bodies`: there are some, which hold what touches them.
float make_viscous_equations(FluidGrid& grid, std::size_t tile, const FluidSpace& space, const Viscosity& by,
                             Component of, bool bodies);
/// Changes the velocity of a tile's faces by what was found in kEven, and keeps the change in kDragU or kDragV.
void drag_faces(FluidGrid& grid, std::size_t tile, const Viscosity& by, Component of);

}  // namespace psim
