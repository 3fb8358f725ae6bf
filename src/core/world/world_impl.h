// The owners of a world, which are all that it holds. Each stage takes what it needs of them; none takes the world.
#pragma once

#include <string>
#include <vector>

#include "base/machine.h"
#include "bodies/quarantine.h"
#include "psim/world.h"
#include "query/observers.h"
#include "step/step_work.h"

namespace psim {

/// One line of what is wrong with a description, or empty.
std::string check(const WorldDesc& desc, const RunOptions& options);
/// The traits that follow from the description alone.
void take_traits(const WorldDesc& desc, Traits& traits);

struct Owners {
  Owners(const WorldDesc& d, const RunOptions& o);

  WorldDesc desc;
  RunOptions options;
  kernels::KernelTable kernels;
  Lattice lattice;
  Walls walls;
  MemoryMeter memory;
  Tracer tracer;
  WorkerPool pool;
  Population population;
  Quarantine quarantine;
  NeighbourLists neighbours;
  Contacts contacts;
  JointStore joints;
  Sleep sleep;
  Dynamics dynamics;
  Observers observers;
  Plan plan;
  bool plan_stale = true;  // traits changed since
  StepWork step_work;      // what was done of the present step
  Governor governor;
  Ledger ledger;
  std::vector<std::byte> unprepared;  // the state before prepare(), until the first step

  // What the owners need of each other.
  StepContext context() {
    return {desc,
            plan,
            lattice,
            walls,
            kernels,
            pool,
            tracer,
            ledger,
            governor,
            population,
            joints,
            sleep,
            neighbours,
            contacts,
            dynamics,
            step_work.progress,
            step_work.detailed};
  }
  SleepSource sleep_source() { return context().sleep_source(); }
  Observed observed() { return {desc, lattice, walls, population, sleep, neighbours.table, contacts, pool}; }

  /// The world without what prepare() made, which holds only as long as the host changes nothing and reads no lists.
  /// All that changes the world or reads its lists goes through this.
  Owners& settled();
  /// What was made for this step is thrown away.
  void spoil_lists() { step_work.spoil(context()); }
  /// Bodies fell asleep or woke if `changed`.
  bool note_sleep(bool changed);
};

struct World::Impl : Owners {
  using Owners::Owners;
};

/// A step with the detail that is given; else the governor chooses one, if it is on. The steps of a world: step.cpp.
StepReport step(Owners& w, double dt, const StepDetail* given = nullptr);
/// All that is left of the work on lists and contacts; then normals and gaps.
void finish_contacts(Owners& w, double dt, const Span& span, StepReport& report);

// world_plan.cpp
void replan(Owners& w);
void apply_plan(Owners& w);

// world_bodies.cpp
void remove_body(Owners& w, std::uint32_t id);
void freeze_body(Owners& w, std::uint32_t id, const BodyState& last);
/// The host moves or pushes a body, or what is joined to it.
void disturb(Owners& w, std::uint32_t id);

// world_joints.cpp
void remove_joints_of(Owners& w, std::uint32_t body);

// state_keeper.cpp
void save(Owners& w, std::vector<std::byte>& out);
/// Back to a state that was saved here.
void go_back(Owners& w, std::span<const std::byte> state);

}  // namespace psim
