#include "step/step_table.h"

#include <algorithm>
#include <new>

#include "base/trace.h"
#include "solver/applied_forces.h"

namespace psim {

StepContext::StepContext(const WorldDesc& d, const RunOptions& o) : desc(d), options(o) {
  const Lattice edges(d.bounds, false);  // walls never wrap
  walls = {edges.to_lattice({d.bounds.xmin, d.bounds.ymin}), edges.to_lattice({d.bounds.xmax, d.bounds.ymax})};
  take_traits(d, population.traits);
  if (d.max_bytes != 0) memory.most = d.max_bytes;
}

ManifoldParams StepContext::manifold_params(double dt) const {
  ManifoldParams p;
  p.dt = dt;
  p.gravity = desc.gravity;
  p.walls = walls;
  p.locks = plan.restraints;
  p.surfaces = plan.surfaces;
  p.asking = plan.surfaces && population.traits.asking != 0;
  p.pre_solve = &pre_solve;
  return p;
}

SleepSource StepContext::sleep_source() {
  return {population, lattice, desc.gravity,     dynamics.substeps, neighbours.table,
          contacts,   joints,  contacts_stand(), plan.manifolds,    plan.model.model == kernels::Model::plain};
}

namespace {

void begin_again(StepContext& c) {
  StepProgress& now = c.progress;
  now = {.spread = now.spread, .waits = now.waits, .spoiled = now.spoiled, .horizon = now.horizon};
  c.done_so_far.clear();
}

// There is no memory to remember which slots the contacts of the last step speak of: the next ones begin without what
// these carried.
void forget_contacts(StepContext& c) {
  c.neighbours.broad.origin.forget();
  c.neighbours.table.body_count = c.neighbours.old_table.body_count = 0;
  c.neighbours.table.strips.clear();
  c.neighbours.renewal.forget();
  c.contacts.manifolds.forget();
  c.contacts.stacks.forget();
  c.contacts.impulses_valid = false;
  c.contacts.bare = true;
}

}  // namespace

void run_part(StepContext& c, const Span& span, StepReport& report, std::size_t end) {
  const StepPart& now = step_parts()[c.progress.part];
  const StageTimer timer(report, c.tracer, now.stage);
  const bool finds_pairs = now.stage != Stage::colouring && !now.in_place;
  if (finds_pairs && !c.population.applied.empty()) {
    const LentSpeeds lent(c.population, c.lattice, span.frame, span.step);
    now.run(c, span, report, {c.progress.at, end});
  } else {
    now.run(c, span, report, {c.progress.at, end});
  }
  c.progress.at = static_cast<std::uint32_t>(end);
  if (end != now.pieces(c)) return;
  c.progress.part = next_part(c, static_cast<std::uint8_t>(c.progress.part + 1));
  c.progress.at = 0;
}

void run_parts(StepContext& c, const Span& span, StepReport& report, std::size_t left) {
  while (left != 0 && !all_done(c.progress)) {
    const std::size_t now = std::min(step_parts()[c.progress.part].pieces(c) - c.progress.at, left);
    left -= now;
    run_part(c, span, report, c.progress.at + now);
  }
}

void turn_back(StepContext& c) {
  c.contacts.discs.turn_back();
  c.contacts.manifolds.turn_back();
  if (c.progress.contacts == ContactState::replaced) std::swap(c.neighbours.table, c.neighbours.old_table);
}

void accept_work(StepContext& c) {
  c.contacts.discs.accept();
  c.contacts.manifolds.accept();
  if (c.progress.lays_out()) {
    TouchMemory& recent = c.sleep.sleepers.recent;
    if (!recent.empty()) {
      recent.clear();
      if (!c.plan.sleep) recent = TouchMemory();
    }
    c.contacts.bare = false;
    c.contacts.impulses_valid = true;
  }
  if (c.progress.makes_lists()) {
    c.neighbours.broad.origin.forget();
    c.neighbours.broad.finish();
  }
  begin_again(c);
}

void spoil_work(StepContext& c) {
  turn_back(c);
  c.contacts.discs.give_up();
  c.contacts.manifolds.accept();
  if (c.progress.sorted()) {
    try {
      c.neighbours.broad.origin.keep();
    } catch (const std::bad_alloc&) {
      forget_contacts(c);
    }
  }
  c.neighbours.stale = true;
  if (c.progress.waits != 0 && (!c.progress.untouched() || c.progress.at != 0)) ++c.progress.spoiled;
  begin_again(c);
}

void note_work(StepContext& c, const Span& span) {
  if (c.progress.untouched()) return;
  if (c.done_so_far.empty() || c.done_so_far.back().span != span.step) c.done_so_far.push_back({.span = span.step});
  c.done_so_far.back().part = c.progress.part;
  c.done_so_far.back().at = c.progress.at;
}

void note_push(StepContext& c, std::uint32_t id, const Motion& before) {
  if (c.progress.untouched()) return;
  c.neighbours.renewal.doubt();
  if (c.progress.lists == ListState::begun) return spoil_work(c);  // the body may be copied already
  const std::uint32_t slot = c.bodies.info[id].slot;
  const double gain = static_cast<double>(c.population.speed_of(slot) - before.fastest());
  const double way = kMarginFrames * c.desc.dt * std::max<int>(c.progress.horizon, c.progress.waits + 1) * gain;
  if (!(way <= 0.02 * static_cast<double>(c.bodies.radius[slot]))) return spoil_work(c);
  c.done_so_far.push_back({.id = id, .before = before});
}

bool put_renewed(StepContext& c, const kernels::ReachParams& margin) {
  ListRenewal& renewal = c.neighbours.renewal;
  Manifolds& manifolds = c.contacts.manifolds;
  if (c.sorts_out()) {
    const Joined joined = [&c](std::uint32_t a, std::uint32_t b) { return c.joints.joined(a, b); };
    manifolds.note_renewed(renewal.bodies(), margin);
    manifolds.sort_out_renewed(c.joints.any_exclusions() ? &joined : nullptr, renewal.pairs(), renewal.near());
  }
  if (!renewal.put(c.neighbours.table)) return false;
  if (c.sorts_out()) manifolds.put_renewed([&renewal](std::uint32_t slot) { return renewal.found(slot); });
  renewal.finish();
  c.contacts.discs.renew(renewal.statics_changed(), c.neighbours.table);
  return true;
}

}  // namespace psim
