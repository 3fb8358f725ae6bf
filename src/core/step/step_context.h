// What the parts of a step work on: references to the owners of a world, and the settings that this step goes by.
#pragma once

#include <cstdint>
#include <functional>

#include "base/machine.h"
#include "base/trace.h"
#include "base/worker_pool.h"
#include "bodies/population.h"
#include "joints/joint_store.h"
#include "lists/neighbour_lists.h"
#include "manifolds/contacts.h"
#include "psim/desc.h"
#include "sleep/sleepers.h"
#include "solver/dynamics.h"
#include "step/governor.h"
#include "step/ledger.h"
#include "step/plan.h"
#include "step/step_progress.h"

namespace psim {

struct StepContext {
  // The world as it is described, and what follows from that.
  const WorldDesc& desc;
  const Plan& plan;
  const Lattice& lattice;
  const Walls& walls;
  // Who does the work, and who counts it.
  const kernels::KernelTable& kernels;
  WorkerPool& pool;
  Tracer& tracer;
  Ledger& ledger;
  const Governor& governor;
  // Who is there.
  const Population& population;
  BodyStore& bodies;
  StaticShapes& statics;
  JointStore& joints;
  Sleepers& sleepers;
  // What a step makes of them.
  NeighbourLists& neighbours;
  Contacts& contacts;
  Dynamics& dynamics;
  StepProgress& progress;
  std::uint64_t steps;  ///< that are over
  bool detailed;        ///< the step follows a given detail: its lists are cut as with a governor
  std::function<void()> keep_touches_of_woken;  ///< contacts with sleepers that woke become pairs

  /// Whether pairs leave the lists of discs: manifolds, and pairs that must not collide.
  bool sorts_out() const { return plan.manifolds || plan.filters || joints.any_exclusions(); }
  /// What manifolds need to know of a step of dt seconds.
  ManifoldParams manifold_params(double dt) const;
};

}  // namespace psim
