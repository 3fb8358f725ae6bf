// Surface tension: where the surface of a fluid is curved, pressure at it is surface tension times curvature.
//
// Each function does a part of the work for a tile; all tiles have done the one before. The fields kGainU, kGainV, kShiftU
// and kShiftV, which are free then, hold what lies between.
#pragma once

#include <cstdint>
#include <span>

#include "fluid/fluid_bodies.h"
#include "fluid/fluid_solver.h"

namespace psim {

/// What is the same for all tiles.
struct SurfaceTension {
  float jump = 0;                ///< solution of the equations for pressure at a surface of curvature 1/m; m^3/s
  bool by_fluid = false;         ///< fluids have different ones: kWay holds sums of their shares of `jump`
  float cell_x = 1, cell_y = 1;  ///< m
};

/// Smooths a share of fluid, as far as kGainV, what is open of a cell, lets it. It is done twice, from kGainU by kShiftU to
/// kShiftV: surfaces of particles are rough, and once leaves twice the noise, which makes waves grow.
void smooth_share(FluidGrid& grid, std::size_t tile, FluidSolver::Field from, FluidSolver::Field to);
/// The curvature of the surface as each cell sees it, times a weight, in kGainU, and the weight, in kShiftU. It is the sixth
/// power of the slope: with a lower one, rough surfaces seem less curved.
void find_curvature(FluidGrid& grid, std::size_t tile, const SurfaceTension& by);
/// Finds the slope of the share of fluid times `jump`, in kChange and kOther. Needs the smoothed share, in kShiftV.
void find_slopes(FluidGrid& grid, std::size_t tile, const SurfaceTension& by);
/// Where the surface of a fluid ends on a body it pulls the body, by the tension, along the surface and out of the body. The slope
/// from find_slopes() adds up to `jump` along the body's outline at each such end, so that no end has to be searched for.
void pull_bodies(const FluidGrid& grid, std::span<const std::uint32_t> tiles, FluidBodies& bodies);
/// What pressure is in cells that are not full, as far as the surface lies beside them: in kShiftV.
void find_surface_pressure(FluidGrid& grid, std::size_t tile, const SurfaceTension& by);

}  // namespace psim
