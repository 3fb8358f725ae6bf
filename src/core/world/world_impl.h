// The parts of a world. Each stage takes what it needs of them; none takes the world.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "base/machine.h"
#include "base/tasks.h"
#include "base/trace.h"
#include "base/worker_pool.h"
#include "bodies/population.h"
#include "bodies/quarantine.h"
#include "joints/joint_store.h"
#include "lists/neighbour_lists.h"
#include "manifolds/contacts.h"
#include "psim/world.h"
#include "query/contact_finder.h"
#include "query/observers.h"
#include "query/queries.h"
#include "sleep/sleep.h"
#include "solver/dynamics.h"
#include "state/saved.h"
#include "step/governor.h"
#include "step/ledger.h"
#include "step/plan.h"
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
  BodyStore& bodies = population.bodies;
  StaticShapes& statics = population.statics;
  std::vector<FixedBody>& fixed = population.fixed;
  std::vector<BodyState>& frozen = population.frozen;
  KinematicBodies& kinematics = population.kinematics;
  Traits& traits = population.traits;
  Quarantine quarantine;
  NeighbourLists neighbours;
  Contacts contacts;
  JointStore joints;
  Sleep sleep;
  Sleepers& sleepers = sleep.sleepers;
  Dynamics dynamics;
  Observers observers;
  QueryIndex& queries = observers.queries;
  EventList& events = observers.events;
  Tracer tracer;
  WorkerPool pool;
  Walls walls;

  Plan plan, applied;       // applied: that the arrays are of
  bool sorted_out = false;  // manifolds had something
  bool plan_stale = true;
  Saved saved;
  StepWork step_work;  // what was done of the present step
  Governor governor;
  bool detailed = false;    // this step goes by a detail: in pieces as they were with a governor
  std::uint64_t steps = 0;  // that did not wait
  bool placed = true;       // the host added or moved bodies since the last step

  std::uint64_t frame = 0;
  Ledger ledger;
  void survey_lanes(const StepReport& report);  // world_lanes.cpp

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
  SleepSource sleep_source();
  bool can_move(BodyId id);
  void disturb(std::uint32_t id);
  void let_turn();
  BodyState state_of(std::uint32_t id) const { return sleep.state_of(population, lattice, id); }

  // state_keeper.cpp
  class StateKeeper;
  void save(std::vector<std::byte>& out);
  bool restore(std::span<const std::byte> state, std::string& error);
  void go_back(std::span<const std::byte> state);  ///< to a state that was saved here
  /// After prepare(): all as it was. Before anything changes.
  void settle_lists() {
    if (prepared()) unprepare();
  }
  bool prepared() const { return !unprepared.empty(); }
  void unprepare();
  std::vector<std::byte> unprepared;  // the state before prepare(), until the first step

  // world_joints.cpp
  void count_joints();
  void remove_joints_of(std::uint32_t body);

  // world_queries.cpp
  QuerySource query_source() const;
  EventSource event_source();
  BodySource body_source() const { return {population, sleep, lattice}; }
  Queries ask() const;

  // world_contacts.cpp
  void find_moved();
  ContactListSource contact_source();

  // world_prepare.cpp
  void prepare();

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

  // world_work.cpp
  StepContext context();
  bool sorts_out() const { return plan.manifolds || plan.filters || joints.any_exclusions(); }
  bool contacts_stand() const { return step_work.contacts_stand(neighbours); }
  void turn_back() { step_work.turn_back(context()); }
  void spoil_lists();
  void accept_work();
  void pushed(std::uint32_t id, const Motion& before);
  void note_work(const Span& span);
  void choose_detail(double dt, StepReport& report);
  void work_ahead(double dt, StepReport& report);
  void spare_room();
};

}  // namespace psim
