// Fluids of different densities in one grid: how light what lies at each face is. Where it is lighter than the first
// fluid, the same pressure gives it more speed.
#pragma once

#include <span>

#include "fluid/fluid_particles.h"
#include "fluid/fluid_solver.h"

namespace psim {

/// Which nodes of a cell a sum is taken at: on its left face, on its lower face or in its middle.
enum class Nodes : std::uint8_t { left, lower, middle };

/// Sums an amount over a tile's particles, by the weights of the kernel, at its own nodes and in its halo.
/// `amount`: of a particle, by fluid.
void scatter_amount(FluidGrid& grid, std::size_t tile, const FluidParticles& particles, std::span<const float> amount,
                    Nodes at, FluidSolver::Field to);

/// Sums the volume of a tile's particles at its faces, in kLightU and kLightV.
void scatter_volumes(FluidGrid& grid, std::size_t tile, const FluidParticles& particles, std::span<const float> volume);
/// Then these become 1 / the density at the face, by that of the first fluid. All tiles have their sums, those of mass
/// too (fluid_transfer.h).
void find_lightness(FluidGrid& grid, std::size_t tile);

}  // namespace psim
