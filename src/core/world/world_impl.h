// All that a world holds: what steps work on (step/step_context.h), who looks at it, and what Quarantine puts right.
// The functions of this room take Owners, since World::Impl is private to World.
#pragma once

#include <string>
#include <vector>

#include "base/machine.h"
#include "bodies/quarantine.h"
#include "psim/world.h"
#include "query/observers.h"
#include "step/step_table.h"

namespace psim {

/// One line of what is wrong with a description, or empty.
std::string check(const WorldDesc& desc, const RunOptions& options);

struct Owners : StepContext {
  using StepContext::StepContext;

  Quarantine quarantine;
  Observers observers;
  bool plan_stale = true;             // traits changed since the plan was made
  Plan applied;                       // the plan that the arrays were made for
  bool sorted_out = false;            // whether manifolds had something then
  std::vector<std::byte> unprepared;  // the state before prepare(), until the first step
  bool broken = false;                // a step ran out of memory while bodies moved

  Observed observed() { return {desc, lattice, walls, population, sleep, neighbours.table, contacts, pool}; }
  /// The world without what prepare() made, which holds only as long as the host changes nothing and reads no lists.
  /// All that changes the world or reads its lists goes through this.
  Owners& settled();
  /// Bodies fell asleep or woke if `changed`.
  bool note_sleep(bool changed);
};

struct World::Impl : Owners {
  using Owners::Owners;
};

/// One line: there is no room for `what`.
std::string no_room(const Owners& w, std::string_view what);

/// A step with the detail that is given; else the governor chooses one, if it is on. The steps of a world: step.cpp.
StepReport step(Owners& w, double dt, const StepDetail* given = nullptr);

// world_plan.cpp
void replan(Owners& w);
void apply_plan(Owners& w);

// world_bodies.cpp
void remove_body(Owners& w, std::uint32_t id);
void freeze_body(Owners& w, const BodyState& last);
/// The host moves or pushes a body, or what is joined to it.
void disturb(Owners& w, std::uint32_t id);

// world_joints.cpp
void remove_joints_of(Owners& w, std::uint32_t body);

// state_keeper.cpp
void save(Owners& w, std::vector<std::byte>& out);
/// Back to a state that was saved here.
void go_back(Owners& w, std::span<const std::byte> state);

}  // namespace psim
