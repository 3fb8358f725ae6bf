// What the parts of a step work on: the owners of its rooms, the settings that it goes by, and how far its work has come.
#pragma once

#include "base/machine.h"
#include "base/trace.h"
#include "base/worker_pool.h"
#include "bodies/population.h"
#include "joints/joint_store.h"
#include "lists/neighbour_lists.h"
#include "manifolds/contacts.h"
#include "psim/desc.h"
#include "sleep/sleep.h"
#include "solver/dynamics.h"
#include "step/governor.h"
#include "step/ledger.h"
#include "step/plan.h"
#include "step/step_work.h"

namespace psim {

struct StepContext {
  StepContext(const WorldDesc& d, const RunOptions& o);

  // The world as it is described, and what follows from that.
  WorldDesc desc;
  RunOptions options;
  Lattice lattice;
  Walls walls;
  Plan plan;
  // Who does the work, and who counts it.
  kernels::KernelTable kernels;
  MemoryMeter memory;
  Tracer tracer;
  WorkerPool pool;
  Ledger ledger;
  Governor governor;
  // Who is there.
  Population population;
  BodyStore& bodies = population.bodies;
  StaticShapes& statics = population.statics;
  JointStore joints;
  // What a step makes of them.
  NeighbourLists neighbours;
  Contacts contacts;
  Sleep sleep;
  Dynamics dynamics;
  StepWork step_work;
  StepProgress& progress = step_work.progress;

  /// Whether pairs leave the lists of discs: manifolds, and pairs that must not collide.
  bool sorts_out() const { return plan.manifolds || plan.filters || joints.any_exclusions(); }
  /// Whether the table, the contacts and the bodies' slots belong together.
  bool contacts_stand() const {
    return progress.contacts != ContactState::replaced && !progress.sorted() && !neighbours.broad.has_moved_on();
  }
  SleepSource sleep_source();
  /// What manifolds need to know of a step of dt seconds.
  ManifoldParams manifold_params(double dt) const;
};

}  // namespace psim
