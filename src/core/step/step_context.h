// What the parts of a step work on: the owners of its rooms, the settings that it goes by, and how far its work has
// come. A governor may spread that work over several frames, so StepProgress is part of the world's state between
// frames, and of its saved states.
#pragma once

#include <cstdint>
#include <vector>

#include "base/machine.h"
#include "base/trace.h"
#include "base/worker_pool.h"
#include "bodies/population.h"
#include "fluid/fluids.h"
#include "joints/joint_store.h"
#include "lists/neighbour_lists.h"
#include "manifolds/contacts.h"
#include "psim/desc.h"
#include "sleep/sleep.h"
#include "solver/dynamics.h"
#include "step/governor.h"
#include "step/ledger.h"
#include "step/plan.h"

namespace psim {

/// What the neighbour lists are within a step.
enum class ListState : std::uint8_t {
  kept,    ///< those of an earlier step
  begun,   ///< new ones are being made for this step
  sorted,  ///< the same, and the bodies lie in an order that the contacts of the last step do not know
};

/// What the contacts are within a step.
enum class ContactState : std::uint8_t {
  kept,      ///< those of the last step stay as they lie
  due,       ///< they will be laid out anew; until then they are those of the last step, and so is the pair table
  replaced,  ///< the pair table is the new one; the contacts of the last step lie by the old table
};

struct StepProgress {
  std::uint8_t part = 0;  ///< the present row of step_parts() (step/step_table.h)
  ListState lists = ListState::kept;
  ContactState contacts = ContactState::kept;
  bool spread = false;       ///< the work may take more than one frame
  std::uint8_t waits = 0;    ///< frames of this step in which time stood still
  std::uint8_t spoiled = 0;  ///< how often the host made the work begin again
  std::uint8_t horizon = 1;  ///< frames that lists made in this step are to serve
  std::uint32_t at = 0;      ///< pieces of the present part that are done

  /// Nothing was done of this step yet.
  bool untouched() const { return part == 0; }
  bool sorted() const { return lists == ListState::sorted; }
  bool makes_lists() const { return lists != ListState::kept; }
  bool lays_out() const { return contacts != ContactState::kept; }
};

/// Seconds of a frame, and of the step that the lists are to serve.
struct Span {
  double frame = 0, step = 0;
};

/// One entry of the work that was done for a step so far, which may take several frames: all work up to a piece of a
/// part, or a body that the host pushed in between. A saved state holds the list, and its work is done again from it.
struct WorkDone {
  std::uint32_t part = 0, at = 0;  ///< part: row of the step table (step/step_table.h)
  double span = 0;                 ///< s: that the work was for; 0: a push
  std::uint32_t id = 0;            ///< of the body
  Motion before = {};              ///< how it moved
};

struct StepContext {
  StepContext(const WorldDesc& d, const RunOptions& o);  // step_work.cpp has the members that are not inline

  // The world as it is described, and what follows from that.
  WorldDesc desc;
  RunOptions options;
  Lattice lattice{desc.bounds, desc.boundary == Boundary::periodic};
  Walls walls;
  Plan plan;
  // Who does the work, and who counts it.
  kernels::KernelTable kernels = kernels_of(options.isa);
  MemoryMeter memory;
  Tracer tracer;
  WorkerPool pool{options.threads, &tracer};
  Ledger ledger;
  Governor governor;
  PreSolve pre_solve;  ///< the host's, or empty
  // Who is there.
  Population population{desc, lattice, memory};
  BodyStore& bodies = population.bodies;
  StaticShapes& statics = population.statics;
  Surroundings surroundings{memory,      lattice,  bodies, statics, kernels, pool, population.kinematics,
                            desc.mixing, desc.wall};
  JointStore joints{surroundings};
  // What a step makes of them.
  NeighbourLists neighbours{surroundings};
  Contacts contacts{surroundings, desc.wall};
  Sleep sleep{surroundings};
  Fluids fluids{memory, kernels, pool};
  Dynamics dynamics;
  StepProgress progress;
  std::vector<WorkDone> done_so_far;
  bool detailed = false;  ///< this step follows a given detail: its lists are cut as with a governor

  /// Whether pairs leave the lists of discs: manifolds, and pairs that must not collide.
  bool sorts_out() const { return plan.manifolds || plan.filters || joints.any_exclusions(); }
  /// Whether the table, the contacts and the bodies' slots belong together.
  bool contacts_stand() const {
    return progress.contacts != ContactState::replaced && !progress.sorted() && !neighbours.broad.origin.moved_on();
  }
  SleepSource sleep_source();
  /// What manifolds need to know of a step of dt seconds.
  ManifoldParams manifold_params(double dt) const;
};

}  // namespace psim
