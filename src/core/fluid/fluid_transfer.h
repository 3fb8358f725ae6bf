// Between the particles and the tiles of a grid.
#pragma once

#include "fluid/fluid_particles.h"
#include "fluid/fluid_solver.h"

namespace psim {

/// Sums mass, momentum and volume of a tile's particles, at its own nodes and in its halo.
void scatter_particles(FluidGrid& grid, std::size_t tile, const FluidParticles& particles,
                       const kernels::KernelTable& kernels, const kernels::FluidMotion& motion);
/// Adds what the neighbours' particles gave to the nodes of a tile; then momenta become velocities.
void sum_up(FluidGrid& grid, std::size_t tile);
/// Adds to one field of a tile what the neighbours' particles gave to its nodes.
void add_spills(FluidGrid& grid, std::size_t tile, FluidSolver::Field field);
/// Gives the particles of a tile what its faces gained, and moves them where the density is even.
void gather_particles(FluidGrid& grid, std::size_t tile, FluidParticles& particles, const kernels::KernelTable& kernels,
                      const kernels::FluidMotion& motion, bool viscous);

}  // namespace psim
