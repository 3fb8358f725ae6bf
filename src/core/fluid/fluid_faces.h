// What a step's pressure makes of the velocities at the faces of cells, for particles to take.
#pragma once

#include "fluid/fluid_solver.h"

namespace psim {

/// New velocities and displacements on the faces of full cells, from the solutions kPressure and kEven. Returns the
/// fastest of faces between two of them, m/s.
float correct_faces(FluidGrid& grid, std::size_t tile, const FluidSpace& space);
/// Fetches from the neighbours what extend_faces() reads, before any tile is extended.
void pull_faces(FluidGrid& grid, std::size_t tile, bool viscous);
/// Faces that belong to no full cell gain as much as those beside them that do, on the mean. Farther away nothing changes.
/// `viscous`: kDragU and kDragV, too.
void extend_faces(FluidGrid& grid, std::size_t tile, bool viscous);

/// Faces within bodies move along their surface as the fluid does, and against it as the body: finds these velocities,
/// and then sets them, when all tiles have theirs.
void find_slip(FluidGrid& grid, std::size_t tile);
void set_slip(FluidGrid& grid, std::size_t tile);

}  // namespace psim
