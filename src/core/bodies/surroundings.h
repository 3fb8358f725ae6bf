// What the owners of a world work on and with. They keep references to it for as long as they live.
#pragma once

#include "base/column.h"
#include "base/lattice.h"
#include "base/worker_pool.h"
#include "bodies/body_store.h"
#include "bodies/static_shapes.h"
#include "kernel_table.h"

namespace psim {

struct Surroundings {
  MemoryMeter& memory;
  const Lattice& lattice;
  BodyStore& bodies;
  StaticShapes& statics;
  const kernels::KernelTable& kernels;
  WorkerPool& pool;
  const KinematicBodies& kinematics;
  const MixingRules& mixing;
  const Material& wall;  ///< of the walls of the world
};

}  // namespace psim
