// The plan in force: made anew when traits change, arrays of what left it given back, and what of it owns
// how much memory.
#include <algorithm>
#include <string_view>

#include "world_impl.h"

namespace psim {

// Whether a body has an angle or a spin. Where many do the first few tell: O(bodies) only if none does.
bool World::Impl::anyone_turns() const {
  if (bodies.spin.empty()) return traits.turning;
  for (std::uint32_t i = 0; i < bodies.count; ++i) {
    if (bodies.id[i] != kNoSlot && (bodies.spin[i] != 0 || bodies.angle[i] != 0)) return true;
  }
  return std::any_of(sleepers.list.begin(), sleepers.list.end(), [](const Sleeper& s) { return s.angle != 0; });
}

// With those that are looked up, not counted.
Traits World::Impl::present_traits() const {
  Traits now = traits;
  now.mass_ratio = traits.same_mass == traits.moving ? 1 : bodies.surfaces.mass_ratio();
  now.turning = anyone_turns();
  return now;
}

void World::Impl::replan() {
  if (!plan_stale) {
    if (plan.events == traits.events && plan.publish == traits.snapshots) return;
    plan.events = traits.events;  // who listens or looks changes no result
    plan.publish = traits.snapshots;
    return apply_plan();
  }
  plan_stale = false;
  traits = present_traits();
  const Plan next = make_plan(traits);
  if (next.model != plan.model) impulses_valid = false;
  Plan same = next;
  same.events = plan.events;
  same.publish = plan.publish;
  if (same != plan) spoil_lists();
  // While all radii are alike the column stays as it is when bodies move to other slots, those of bodies that are
  // gone, too.
  if (!next.radii) std::fill_n(bodies.radius.data(), bodies.count, first_radius);
  if (plan.shapes && !next.shapes) manifolds.clear();  // pairs may be sorted out on, without contacts of shapes
  plan = next;
  apply_plan();
}

// Arrays of what is not in the plan give their memory back. Those of contacts do when the next are built.
void World::Impl::apply_plan() {
  const auto left = [this](bool Plan::*what) { return applied.*what && !(plan.*what); };
  if (plan.rotation && bodies.spin.empty()) bodies.add_rotation();
  if (!plan.rotation) bodies.drop_rotation();
  broad.sorter().forget(!plan.radii, !plan.rotation);
  solved.forget(!plan.rotation, !plan.restitution);
  if (plan.forces) {
    if (!forces) forces = std::make_unique<Forces>(desc, lattice);
  } else {
    forces.reset();
    bodies.acc.release();
  }
  if (plan.fields) {
    bodies.add_rests(plan.integrator != Integrator::verlet);
  } else {
    bodies.vel_rest.release();
    bodies.disp_rest.release();
    bodies.bend.release();
    bodies.spare.release();
  }
  if (!plan.turns) bodies.keep_turns(false);
  shapes.find_whole(plan.shapes);
  if (sorted_out && !sorts_out()) manifolds.release();
  sorted_out = sorts_out();
  if (left(&Plan::shapes)) {
    columns.release();
    if (bodies.hulls.empty()) bodies.hulls.clear();
  }
  if (left(&Plan::joints)) joints.release_blocks();
  if (left(&Plan::continuous)) continuous.release();
  if (left(&Plan::loads)) loads.release();
  if (left(&Plan::sleep) && sleepers.empty()) sleepers.release();
  if (left(&Plan::publish)) publisher.release();
  if (left(&Plan::events)) events = EventList();
  if (!plan.scales) bodies.pull.release();
  if (!plan.restitution) {
    bodies.event_time.release();
    solver.forget_impacts();
  }
  forces_stale = true;
  applied = plan;
}

namespace {

template <class... Columns>
std::size_t sum(const Columns&... columns) {
  return (columns.bytes() + ...);
}

}  // namespace

std::vector<PlanEntry> World::plan() const {
  const Impl& w = *impl_;
  const Traits traits = w.present_traits();
  const Plan plan = make_plan(traits);
  std::vector<PlanEntry> entries = explain(plan, traits);
  const auto count = [&entries](std::string_view stage, std::size_t bytes) {
    for (PlanEntry& e : entries) {
      if (e.stage == stage) e.bytes += bytes;
    }
  };
  const BodyStore& b = w.bodies;
  const ContactStore& c = w.contacts;
  count("forces", sum(b.acc, b.pull, b.vel_rest, b.spare) + (w.forces ? sizeof(Forces) : 0));
  count("forces.integrator", sum(b.bend, b.disp_rest));
  count("broad_phase.mixed_radii", w.broad.sorter().radii_bytes());
  count("solver.restitution", sum(b.event_time, c.e, c.impact, c.start, c.s_e, c.s_impact, c.s_start) +
                                  w.solved.impact_bytes() + w.solver.impact_bytes());
  // Contacts with friction have masses, too.
  count(plan.friction && !plan.masses ? "solver.friction" : "solver.masses",
        sum(c.mass, c.wa, c.wb, c.s_mass, c.s_wb));
  count("solver.friction", c.friction_bytes());
  count("solver.heavy_loads", w.loads.bytes());
  count("rotation", b.rotation_bytes() + w.broad.sorter().rotation_bytes() + w.solved.rotation_bytes());
  // What shapes have joints want, too, and what takes pairs out of the lists serves filters.
  count(plan.joints && !plan.shapes ? "joints" : "manifolds", sum(b.turn, b.swing));
  count(plan.shapes || !w.sorts_out() ? "manifolds" : plan.filters ? "filters" : "joints",
        w.manifolds.bytes() + w.manifolds.column_bytes());
  count("manifolds", w.columns.bytes() + b.hulls.bytes());
  count("joints", w.joints.bytes() + w.joints.column_bytes());
  count("continuous", w.continuous.bytes());
  count("sleep", w.sleepers.bytes() + w.sleepers.column_bytes());
  count("events", w.events.bytes());
  count("publish", w.publisher.bytes());
  return entries;
}

}  // namespace psim
