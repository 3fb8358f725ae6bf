// The plan in force: made anew when traits change, arrays of what left it given back, and what of it owns
// how much memory.
#include <algorithm>
#include <string_view>

#include "world/world_impl.h"

namespace psim {

// Whether a body has an angle or a spin. Where many do the first few tell: O(bodies) only if none does.
bool World::Impl::anyone_turns() const {
  const BodyStore& bodies = population.bodies;
  if (bodies.rim_speed.empty()) return population.traits.turning;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] != kNoSlot && (bodies.rim_speed[i] != 0 || bodies.angle[i] != 0)) return true;
  }
  const std::vector<Sleeper>& sleepers = sleep.sleepers.list;
  return std::any_of(sleepers.begin(), sleepers.end(), [](const Sleeper& s) { return s.angle != 0; });
}

// With those that are looked up, not counted.
Traits World::Impl::present_traits() const {
  Traits now = population.traits;
  now.mass_ratio =
      population.traits.same_mass == population.traits.moving ? 1 : population.bodies.property_table.mass_ratio();
  now.turning = anyone_turns();
  return now;
}

void World::Impl::replan() {
  Traits& traits = population.traits;
  if (!plan_stale) {
    if (plan.events == traits.events && plan.publish == traits.snapshots) return;
    plan.events = traits.events;  // who listens or looks changes no result
    plan.publish = traits.snapshots;
    return apply_plan();
  }
  plan_stale = false;
  traits = present_traits();
  const Plan next = make_plan(traits);
  if (next.model != plan.model) contacts.impulses_valid = false;
  Plan same = next;
  same.events = plan.events;
  same.publish = plan.publish;
  if (same != plan) spoil_lists();
  // While all radii are alike the column stays as it is when bodies move to other slots, those of bodies that are
  // gone, too.
  if (!next.radii) std::fill_n(population.bodies.radius.data(), population.bodies.count, population.first_radius);
  if (plan.manifolds && !next.manifolds)
    contacts.manifolds.clear();  // pairs may be sorted out on, without contacts of shapes
  plan = next;
  apply_plan();
}

// Arrays of what is not in the plan give their memory back. Those of contacts do when the next are built.
void World::Impl::apply_plan() {
  BodyStore& bodies = population.bodies;
  const auto left = [this](bool Plan::*what) { return applied.*what && !(plan.*what); };
  if (plan.rotation && bodies.rim_speed.empty()) bodies.add_rotation();
  if (!plan.rotation) bodies.drop_rotation();
  neighbours.broad.mover().forget(!plan.radii, !plan.rotation);
  contacts.solved.forget(!plan.rotation, !plan.restitution);
  if (plan.forces) {
    if (!dynamics.forces) dynamics.forces = std::make_unique<Forces>(desc, lattice);
  } else {
    dynamics.forces.reset();
    bodies.acc.release();
  }
  if (plan.fields) {
    bodies.add_remainders(plan.integrator != Integrator::verlet);
  } else {
    bodies.vel_remainder.release();
    bodies.disp_remainder.release();
    bodies.drift_correction.release();
    bodies.spare.release();
  }
  if (!plan.turns) bodies.keep_turns(false);
  population.statics.find_whole(plan.manifolds);
  const bool sorts_out = context().sorts_out();
  if (sorted_out && !sorts_out) contacts.manifolds.release();
  sorted_out = sorts_out;
  if (left(&Plan::manifolds)) {
    contacts.stacks.release();
    if (bodies.hulls.empty()) bodies.hulls.clear();
  }
  if (left(&Plan::joints)) joints.release_blocks();
  if (left(&Plan::continuous)) dynamics.continuous.release();
  if (left(&Plan::loads)) contacts.loads.release();
  if (left(&Plan::sleep) && sleep.sleepers.empty()) sleep.sleepers.release();
  if (left(&Plan::publish)) observers.publisher.release();
  if (left(&Plan::events)) observers.events = EventList();
  if (!plan.scales) bodies.pull.release();
  if (!plan.restitution) {
    bodies.event_time.release();
    dynamics.solver.forget_impacts();
  }
  dynamics.forces_stale = true;
  applied = plan;
}

namespace {

template <class... Arrays>
std::size_t sum(const Arrays&... arrays) {
  return (arrays.bytes() + ...);
}

}  // namespace

std::vector<PlanEntry> World::plan() const {
  Impl& w = *impl_;
  const Traits traits = w.present_traits();
  const Plan plan = make_plan(traits);
  std::vector<PlanEntry> entries = explain(plan, traits);
  const auto count = [&entries](std::string_view stage, std::size_t bytes) {
    for (PlanEntry& e : entries) {
      if (e.stage == stage) e.bytes += bytes;
    }
  };
  const BodyStore& b = w.population.bodies;
  const ContactStore& c = w.contacts.discs;
  count("forces", sum(b.acc, b.pull, b.vel_remainder, b.spare) + (w.dynamics.forces ? sizeof(Forces) : 0));
  count("forces.integrator", sum(b.drift_correction, b.disp_remainder));
  count("broad_phase.mixed_radii", w.neighbours.broad.mover().radii_bytes());
  count("solver.restitution", sum(b.event_time, c.e, c.impact, c.start, c.s_e, c.s_impact, c.s_start) +
                                  w.contacts.solved.impact_bytes() + w.dynamics.solver.impact_bytes());
  // Contacts with friction have masses, too.
  count(plan.friction && !plan.masses ? "solver.friction" : "solver.masses", sum(c.mass, c.wa, c.wb, c.s_mass, c.s_wb));
  count("solver.friction", c.friction_bytes());
  count("solver.heavy_loads", w.contacts.loads.bytes());
  count("rotation",
        b.rotation_bytes() + w.neighbours.broad.mover().rotation_bytes() + w.contacts.solved.rotation_bytes());
  // What shapes have joints want, too, and what takes pairs out of the lists serves filters.
  count(plan.joints && !plan.manifolds ? "joints" : "manifolds", sum(b.arm_change, b.angle_change));
  count(plan.manifolds || !w.context().sorts_out() ? "manifolds"
        : plan.filters                             ? "filters"
                                                   : "joints",
        w.contacts.manifolds.bytes() + w.contacts.manifolds.column_bytes());
  count("manifolds", w.contacts.stacks.bytes() + b.hulls.bytes());
  count("joints", w.joints.bytes() + w.joints.column_bytes());
  count("continuous", w.dynamics.continuous.bytes());
  count("sleep", w.sleep.sleepers.bytes() + w.sleep.sleepers.column_bytes());
  count("events", w.observers.events.bytes());
  count("publish", w.observers.publisher.bytes());
  return entries;
}

}  // namespace psim
