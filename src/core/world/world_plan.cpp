// The plan in force: made anew when traits change, arrays of what left it given back, and what of it owns
// how much memory.
#include <algorithm>
#include <string_view>

#include "world/world_impl.h"

namespace psim {
namespace {

// Whether a body has an angle or a spin. Where many do the first few tell: O(bodies) only if none does.
bool anyone_turns(const Owners& w) {
  const BodyStore& bodies = w.bodies;
  if (bodies.rim_speed.empty()) return w.population.traits.turning;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] != kNoSlot && (bodies.rim_speed[i] != 0 || bodies.angle[i] != 0)) return true;
  }
  const std::vector<Sleeper>& sleepers = w.sleep.sleepers.list;
  return std::any_of(sleepers.begin(), sleepers.end(), [](const Sleeper& s) { return s.angle != 0; });
}

// With those that are looked up, not counted.
Traits present_traits(const Owners& w) {
  Traits now = w.population.traits;
  now.mass_ratio = now.same_mass == now.moving ? 1 : w.bodies.property_table.mass_ratio();
  now.turning = anyone_turns(w);
  return now;
}

template <class... Arrays>
std::size_t sum(const Arrays&... arrays) {
  return (arrays.bytes() + ...);
}

}  // namespace

void replan(Owners& w) {
  Traits& traits = w.population.traits;
  Plan& plan = w.plan;
  if (!w.plan_stale && plan.events == traits.events && plan.publish == traits.snapshots) return;
  Plan next = plan;
  if (w.plan_stale) {
    w.population.recount_if_changed();
    traits = present_traits(w);
    next = make_plan(traits);
  }
  w.plan_stale = false;
  if (next.model != plan.model) w.contacts.impulses_valid = false;
  next.events = plan.events;  // who listens or looks changes no result
  next.publish = plan.publish;
  if (next != plan) spoil_work(w);
  next.events = traits.events;
  next.publish = traits.snapshots;
  BodyStore& bodies = w.bodies;
  // While all radii are alike the column stays as it is when bodies move to other slots, those of bodies that are
  // gone, too.
  if (!next.radii) std::fill_n(bodies.radius.data(), bodies.count, w.population.first_radius);
  // Pairs may be sorted out on, without contacts of shapes.
  if (plan.manifolds && !next.manifolds) w.contacts.manifolds.clear();
  plan = next;
  apply_plan(w);
}

// Arrays of what is not in the plan give their memory back. Those of contacts do when the next are built.
void apply_plan(Owners& w) {
  const Plan& plan = w.plan;
  BodyStore& bodies = w.bodies;
  const auto left = [&](bool Plan::*what) { return w.applied.*what && !(plan.*what); };
  bodies.keep_rotation(plan.rotation);
  w.neighbours.broad.mover().forget(!plan.radii, !plan.rotation);
  w.contacts.solved.forget(!plan.rotation, !plan.restitution);
  if (plan.forces) {
    if (!w.dynamics.forces) w.dynamics.forces = std::make_unique<Forces>(w.desc, w.lattice);
  } else {
    w.dynamics.forces.reset();
    bodies.acc.release();
  }
  if (!w.population.traits.media) w.dynamics.media.release();
  if (!plan.scales) give_back(w.dynamics.pushes);
  bodies.keep_remainders(plan.fields, plan.fields && plan.integrator != Integrator::verlet);
  if (!plan.fields) give_back(bodies.drift_correction, bodies.spare);
  if (!plan.turns) bodies.keep_turns(false);
  w.statics.find_whole(plan.manifolds);
  if (w.sorted_out && !w.sorts_out()) w.contacts.manifolds.release();
  w.sorted_out = w.sorts_out();
  if (left(&Plan::uneven)) w.neighbours.thrown.release();
  if (left(&Plan::manifolds)) {
    w.contacts.stacks.release();
    bodies.hulls.give_back();
    bodies.parts.give_back();
  }
  if (left(&Plan::joints)) w.joints.release_blocks();
  if (left(&Plan::continuous)) w.dynamics.continuous.release();
  if (left(&Plan::loads)) {
    w.contacts.loads.release();
    w.contacts.squeezed.release();
  }
  // Sleepers may outlast the plan that let them sleep: their columns go once the last one is awake.
  Sleepers& sleepers = w.sleep.sleepers;
  if (!plan.sleep && sleepers.empty() && sleepers.column_bytes() != 0) sleepers.release();
  if (left(&Plan::publish)) w.observers.publisher.release();
  if (left(&Plan::events)) w.observers.events = EventList();
  if (!plan.scales) bodies.pull.release();
  if (!plan.restitution) {
    bodies.event_time.release();
    w.dynamics.solver.forget_impacts();
  }
  if (!plan.restitution || !plan.rotation) bodies.rim_way.release();
  w.dynamics.forces_stale = true;
  w.applied = plan;
}

std::vector<PlanEntry> World::plan() const try {
  Owners& w = *impl_;
  Traits traits = present_traits(w);
  traits.fluids = w.fluids.active();
  const Plan plan = make_plan(traits);
  std::vector<PlanEntry> entries = explain(plan, traits);
  const auto count = [&entries](std::string_view stage, std::size_t bytes) {
    for (PlanEntry& e : entries) {
      if (e.stage == stage) e.bytes += bytes;
    }
  };
  const BodyStore& b = w.bodies;
  const ContactStore& c = w.contacts.discs;
  count("forces", sum(b.acc, b.pull, b.vel_remainder, b.spare, w.dynamics.media) + bytes_of(w.dynamics.pushes) +
                      (w.dynamics.forces ? sizeof(Forces) : 0));
  count("forces.integrator", sum(b.drift_correction, b.disp_remainder));
  count("restraints", w.population.restraints.bytes());
  count("broad_phase.mixed_radii", w.neighbours.broad.mover().radii_bytes());
  count("solver.restitution", sum(b.event_time, b.rim_way) + c.pairs.bounce_bytes() + c.fixed.bounce_bytes() +
                                  w.contacts.solved.impact_bytes() + w.dynamics.solver.impact_bytes());
  // Contacts with friction have masses, too.
  count(plan.friction && !plan.masses ? "solver.friction" : "solver.masses",
        c.pairs.mass_bytes() + c.fixed.mass_bytes());
  count(plan.masses ? "solver.masses" : "manifolds", w.neighbours.thrown.bytes() + w.neighbours.thrown.column_bytes());
  count("solver.friction", c.pairs.friction_bytes() + c.fixed.friction_bytes());
  count("solver.heavy_loads", w.contacts.loads.bytes() + w.contacts.squeezed.bytes());
  count("rotation",
        b.rotation_bytes() + w.neighbours.broad.mover().rotation_bytes() + w.contacts.solved.rotation_bytes());
  // What shapes have joints want, too, and what takes pairs out of the lists serves filters.
  count(plan.joints && !plan.manifolds ? "joints" : "manifolds", sum(b.arm_change, b.angle_change));
  count(plan.manifolds || !w.sorts_out() ? "manifolds"
        : plan.filters                   ? "filters"
                                         : "joints",
        w.contacts.manifolds.bytes() + w.contacts.manifolds.column_bytes());
  count("manifolds", w.contacts.stacks.bytes() + b.hulls.bytes() + b.parts.bytes());
  count("joints", w.joints.bytes() + w.joints.column_bytes());
  count("continuous", w.dynamics.continuous.bytes());
  count("fluid", w.fluids.bytes());
  count("sleep", w.sleep.sleepers.bytes() + w.sleep.sleepers.column_bytes());
  count("events", w.observers.events.bytes());
  count("publish", w.observers.publisher.bytes());
  return entries;
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<PlanEntry>>();
}

}  // namespace psim
