// The owners of a world. Each stage takes what it needs of them; none takes the world.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/machine.h"
#include "bodies/quarantine.h"
#include "psim/world.h"
#include "query/observers.h"
#include "query/queries.h"
#include "step/step_work.h"

namespace psim {

/// One line of what is wrong with a description, or empty.
std::string check(const WorldDesc& desc, const RunOptions& options);

struct World::Impl {
  Impl(const WorldDesc& d, const RunOptions& o);

  WorldDesc desc;
  RunOptions options;
  kernels::KernelTable kernels;
  Lattice lattice;
  MemoryMeter memory;
  Population population;
  Quarantine quarantine;
  NeighbourLists neighbours;
  Contacts contacts;
  JointStore joints;
  Sleep sleep;
  Dynamics dynamics;
  Observers observers;
  Tracer tracer;
  WorkerPool pool;
  Walls walls;

  Plan plan, applied;       // applied: that the arrays are of
  bool sorted_out = false;  // manifolds had something
  bool plan_stale = true;
  StepWork step_work;  // what was done of the present step
  Governor governor;
  bool detailed = false;    // this step goes by a detail: in pieces as they were with a governor
  std::uint64_t steps = 0;  // that did not wait
  bool placed = true;       // the host added or moved bodies since the last step

  std::uint64_t frame = 0;
  Ledger ledger;

  // What the owners need of each other.
  StepContext context() {
    return {desc,     plan,       lattice, walls, kernels,    pool,     tracer,   ledger,
            governor, population, joints,  sleep, neighbours, contacts, dynamics, step_work.progress,
            steps,    detailed};
  }
  SleepSource sleep_source() { return context().sleep_source(); }
  Observed observed() { return {desc, lattice, walls, population, sleep, neighbours.table, contacts, pool}; }
  Queries ask() { return {observers.queries, observed()}; }
  BodyState state_of(std::uint32_t id) const { return sleep.state_of(population, lattice, id); }

  // world_plan.cpp
  void replan();
  void apply_plan();
  bool anyone_turns() const;
  Traits present_traits() const;

  // world_bodies.cpp
  void body_came(std::uint32_t id);
  void body_goes(std::uint32_t id, bool same);
  void remove(std::uint32_t id);
  void freeze(std::uint32_t id, const BodyState& last);
  Quarantine::Freeze freezer() {
    return [this](std::uint32_t id, const BodyState& last) { freeze(id, last); };
  }
  bool note_sleep(bool changed);
  bool can_move(BodyId id);
  void let_turn();
  /// The host moves or pushes a body, or what is joined to it.
  void disturb(std::uint32_t id) { note_sleep(sleep.disturb(sleep_source(), id)); }
  /// What was made for this step is thrown away.
  void spoil_lists() { step_work.spoil(context()); }

  // state_keeper.cpp
  class StateKeeper;
  void save(std::vector<std::byte>& out);
  void go_back(std::span<const std::byte> state);  ///< to a state that was saved here

  // world_prepare.cpp
  void prepare();
  void spare_room();
  bool prepared() const { return !unprepared.empty(); }
  /// The world without what prepare() made, which holds only as long as the host changes nothing and reads no lists.
  /// All that changes the world or reads its lists goes through this.
  Impl& settled();
  std::vector<std::byte> unprepared;  // the state before prepare(), until the first step

  // world_joints.cpp
  void count_joints();
  void remove_joints_of(std::uint32_t body);
  void disturb_joined(JointId id);

  // world_queries.cpp
  void find_moved();

  // step.cpp
  StepReport step(double dt);
  StepReport step(double dt, const StepDetail& detail, bool choose);
  void take_prepared(double dt, bool choose, StepReport& report);
  void look_around();
  void work_on_lists(double dt, bool choose, StepReport& report);
  void advance(double frame_dt, bool choose, StepReport& report);
  bool meet(double dt, const Span& span, bool governed, StepReport& report);
  void finish_contacts(double dt, const Span& span, StepReport& report);
  void move(double dt, StepReport& report);
  void collect_events(StepReport& report);
  void stand_still(StepReport& report);
  void publish(StepReport& report);
  void fall_asleep(double dt, StepReport& report);
  void count_contacts(StepReport& report);
};

}  // namespace psim
