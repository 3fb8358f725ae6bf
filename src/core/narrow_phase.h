// Narrow phase: normals and separations of all candidate contacts at the start of a step, from
// lattice positions. Pairs of discs by kernel; contacts with walls, segments and fixed discs here.
// O(candidates).
#pragma once

#include "body_store.h"
#include "contact_store.h"
#include "kernel_table.h"
#include "lattice.h"
#include "static_shapes.h"
#include "worker_pool.h"

namespace psim {

/// The four walls as lattice coordinates.
struct Walls {
  LatticePoint low, high;
};

/// Fills nx, ny, gap (and base, refresh of single contacts) of every lane. `refresh` is the
/// sideways motion, m, after which a normal is computed anew within the step.
void narrow_phase(BodyStore& bodies, SolverBodies& solved, const StaticShapes& shapes, const Walls& walls,
                  const Lattice& lattice, float refresh, PairTable& table, ContactStore& contacts,
                  const kernels::KernelTable& k, WorkerPool& pool);

}  // namespace psim
