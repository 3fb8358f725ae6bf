// All that a world holds: what steps work on (step/step_context.h), who looks at it, and what Quarantine puts right.
// The functions of this room take Owners, since World::Impl is private to World.
#pragma once

#include <string>
#include <vector>

#include "base/machine.h"
#include "base/room.h"
#include "bodies/quarantine.h"
#include "psim/world.h"
#include "query/observers.h"
#include "step/step_table.h"

namespace psim {

/// One line of what is wrong with a description, or empty.
std::string check(const WorldDesc& desc, const RunOptions& options);
std::string check(const std::vector<Field>& fields);

struct Owners : StepContext {
  using StepContext::StepContext;

  Quarantine quarantine;
  Observers observers;
  bool plan_stale = true;             // traits changed since the plan was made
  Plan applied;                       // the plan that the arrays were made for
  bool sorted_out = false;            // whether manifolds had something then
  std::vector<std::byte> unprepared;  // the state before prepare(), until the first step
  bool broken = false;                // there was no memory in the midst of a change: no call does anything any more

  Observed observed() { return {desc, lattice, walls, population, sleep, neighbours.table, contacts, pool}; }
  /// The world without what prepare() made, which holds only as long as the host changes nothing and reads no lists.
  /// All that changes the world or reads its lists goes through this.
  Owners& settled();
  /// Bodies fell asleep or woke if `changed`.
  bool note_sleep(bool changed);
  /// Back to a state that was saved here, whatever is in the world now. If there is no memory for it, even beyond the
  /// budget, the world is broken and has no bodies, and std::bad_alloc is thrown.
  void go_back_or_lose(std::span<const std::byte> state);
  /// A call found no memory: what was made of lists and grids will be made again.
  void recover();
  /// The same, and the answer of the call.
  template <class Answer>
  Answer ran_out(Answer none) {
    recover();
    return none;
  }
};

struct World::Impl : Owners {
  using Owners::Owners;
};

/// One line: there is no room for `what`. Shorter, if there is none for the line either.
void say_no_room(const Owners& w, std::string_view what, std::string& error);
/// A call that changes nothing found no memory. This is its answer.
template <class Answer>
Answer nothing_found() {
  ran_out_of_memory() = true;
  return Answer();
}

/// A step with the detail that is given; else the governor chooses one, if it is on. The steps of a world: step.cpp.
StepReport step(Owners& w, double dt, const StepDetail* given = nullptr);

// world_plan.cpp
void replan(Owners& w);
void apply_plan(Owners& w);

// world_bodies.cpp
void remove_body(Owners& w, std::uint32_t id);
/// Tells all others of a body that came, or that goes out of the simulation. `same`: it keeps its id; `tied`: and its
/// joints.
void body_came(Owners& w, std::uint32_t id);
void body_goes(Owners& w, std::uint32_t id, bool same, bool tied = false);
/// The impulses of the lists are nobody's once no body is awake.
void forget_impulses_of_nobody(Owners& w);
void freeze_body(Owners& w, const BodyState& last);
/// The host moves or pushes a body, or what is joined to it.
void disturb(Owners& w, std::uint32_t id);
/// Whether the host may move or push a body. From now on it is awake and its slot is known.
bool can_move(Owners& w, BodyId id);
/// From the centre of mass of a body that moves to the nearest of the repeated copies of a point (world_forces.cpp).
Vec2 arm_to(Owners& w, BodyId id, Vec2 point);
/// A body gets an angle or an angular velocity.
void let_turn(Owners& w);

// world_forces.cpp
/// Adds to what pushes a body in the next step. False, and nothing changes, if the body does not move.
bool add_force(Owners& w, BodyId id, Vec2 force, double torque);
/// The same to a body that moves. It may fall asleep nevertheless.
void push_body(Owners& w, BodyId id, Vec2 force, double torque);

// world_fluid_bodies.cpp
/// Moves the fluids of a world by dt seconds in so many parts at most (0: as many as it takes), around its bodies; then drains and emitters have their turn. False if there
/// was no memory for all that emitters let out.
bool step_fluids(Owners& w, double dt, int most_parts);
/// Gives bodies what the fluids' last step did to them.
void push_by_fluids(Owners& w);
/// Bodies fell asleep: fluids push those of them no more that they bore.
void lay_down_in_fluids(Owners& w);

// world_joints.cpp
void disturb_joined(Owners& w, std::uint32_t body);
void remove_joints_of(Owners& w, std::uint32_t body);
/// Joints that the step loaded too much go, and events say so.
void break_joints(Owners& w);

// world_queries.cpp
/// What the contacts of a step are like that has just been done.
LastStep last_step(const Owners& w);

// state_keeper.cpp
void save(Owners& w, std::vector<std::byte>& out);
/// Back to a state that was saved here.
void go_back(Owners& w, std::span<const std::byte> state);

}  // namespace psim
