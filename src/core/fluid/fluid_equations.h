// The equations of a step, from what particles gave to the grid: which cells are full, where the surface lies between
// them, what pressure must undo and how uneven the density is.
#pragma once

#include "fluid/fluid_solver.h"

namespace psim {

/// Sums up the full cells of a tile.
struct FluidSurvey {
  double error = 0;         ///< sum of |error of the density|, relative, over its full cells
  float worst = 0;          ///< the largest
  std::uint32_t cells = 0;  ///< full ones
  float largest = 0;        ///< right side of the equations for pressure
  float largest_even = 0;   ///< and of those for an even density
  double uneven = 0;        ///< sum of these
  double pressure = 0;      ///< sum of what it was in the last step
  std::uint32_t full = 0;   ///< cells that have an equation
  bool surface = false;     ///< whether one of them lies beside a cell without pressure
};

/// A cell whose kernel sees less that bodies leave open is none.
inline constexpr float kLeastSeen = 0.02f;
/// A face of which bodies leave less is closed.
inline constexpr float kLeastOpen = 0.01f;

/// Share of a cell beyond which it counts as full: then it has an equation.
inline constexpr float kFullCell = 0.53f;

/// What a kernel sees of water whose flat surface is t kernel widths above its middle: the sum over rows of particles, the
/// first of which lies half a spacing below the surface. A kernel is `spacings` wide: 2 that of a cell.
float share_below(float t, float spacings);

/// Whether a cell of a tile is full, where there are no bodies.
bool has_full_cell(const FluidGrid& grid, std::size_t tile, const FluidSpace& space);

/// Makes the equations of a tile: its links and its diagonal; in kRight what pressure must undo, m^2/s, and in kUneven
/// what a displacement must, m^2. All tiles have their sums then (fluid_transfer.h).
/// `bodies`: there are some; they are drawn (fluid_cut.h), and all tiles have their shares.
/// `densities`: fluids have different ones; kLightU and kLightV hold how light they are at faces (fluid_mixture.h).
FluidSurvey make_equations(FluidGrid& grid, std::size_t tile, const FluidSpace& space, bool bodies, bool densities,
                           bool tension = false);
/// Shows for fluid_tension.h how full cells are, in kGainU, and what is open of them, in kGainV.
void show_shares(FluidGrid& grid, std::size_t tile, const FluidSpace& space, bool bodies);

/// Adds a little to the equations for an even density, so that they have a solution where bodies shut in some cells: no
/// displacement can bring these together or apart. The displacement fades over a hundred cells there.
void soften(FluidGrid& grid, std::size_t tile);
/// Takes a mean from the cells of a field that have an equation; the others get 0.
void take_mean_out(FluidGrid& grid, std::size_t tile, FluidSolver::Field field, float mean);

/// Finds how full the cells of a tile are, where there are bodies.
void find_shares(FluidGrid& grid, std::size_t tile, const FluidSpace& space);

/// Adds walls to what particles feel as dense. Once a step, after sum_up().
void fill_walls(FluidGrid& grid, std::size_t tile, const FluidSpace& space);

/// Whether the cells beside a cell of a tile lie within walls.
struct WallsBeside {
  bool left, right, below, above;
};
WallsBeside walls_beside(const FluidSpace& space, const FluidTile& tile, std::int32_t i, std::int32_t j);

}  // namespace psim
