// Narrow phase of discs: normals and separations of all candidate contacts at the start of a step, from lattice
// positions. A kernel computes pairs of discs; contacts with walls, segments and fixed discs are computed here.
// O(candidates).
#pragma once

#include "base/lattice.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "contacts/contact_store.h"
#include "kernel_table.h"

namespace psim {

/// Fills nx and ny and gap of every lane, and base and refresh of static contacts. `refresh` is the
/// sideways motion, m, after which a normal is computed anew within the step.
void narrow_phase(BodyStore& bodies, SolverBodies& solved, const StaticShapes& statics, const Walls& walls,
                  const Lattice& lattice, float refresh, PairTable& table, ContactStore& contacts,
                  const kernels::KernelTable& k, WorkerPool& pool);

}  // namespace psim
