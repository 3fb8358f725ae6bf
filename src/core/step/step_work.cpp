#include "step/step_work.h"

#include <algorithm>

#include "base/trace.h"

namespace psim {

ManifoldParams StepContext::manifold_params(double dt) const {
  ManifoldParams p;
  p.dt = dt;
  p.gravity = desc.gravity;
  p.lattice = &lattice;
  p.statics = &statics;
  p.kernels = &kernels;
  p.walls = walls;
  p.wall = desc.wall;
  return p;
}

SleepSource StepContext::sleep_source() const {
  return {population,       lattice,        desc.gravity,
          neighbours.table, contacts.discs, contacts.manifolds,
          contacts.stacks,  joints,         pool,
          contacts_stand(), plan.manifolds, plan.model.model == kernels::Model::plain};
}

void StepWork::run(const StepContext& c, const Span& span, StepReport& report, std::size_t end) {
  const StepPart& now = part();
  const StageTimer timer(report, c.tracer, now.stage);
  now.run(c, span, report, {progress.at, end});
  progress.at = static_cast<std::uint32_t>(end);
  if (end != now.pieces(c)) return;
  progress.part = next_part(c, static_cast<std::uint8_t>(progress.part + 1));
  progress.at = 0;
}

void StepWork::finish(const StepContext& c, const Span& span, StepReport& report) {
  while (!done()) run(c, span, report, part().pieces(c));
}

void StepWork::run_pieces(const StepContext& c, const Span& span, StepReport& report, std::size_t left) {
  while (left != 0 && !done()) {
    const std::size_t end = std::min(part().pieces(c), progress.at + left);
    left -= end - progress.at;
    run(c, span, report, end);
  }
}

void StepWork::turn_back(const StepContext& c) {
  c.contacts.discs.turn_back();
  c.contacts.manifolds.turn_back();
  if (progress.contacts == ContactState::replaced) c.neighbours.table.swap(c.neighbours.old_table);
}

void StepWork::accept(const StepContext& c) {
  c.contacts.discs.accept();
  c.contacts.manifolds.accept();
  if (progress.lays_out()) {
    TouchMemory& recent = c.sleep.sleepers.recent;
    if (!recent.empty()) {
      recent.clear();
      if (!c.plan.sleep) recent = TouchMemory();
    }
    c.contacts.bare = false;
    c.contacts.impulses_valid = true;
  }
  if (progress.makes_lists()) {
    c.neighbours.broad.origin.forget();
    c.neighbours.broad.finish();
  }
  begin_again();
}

void StepWork::spoil(const StepContext& c) {
  turn_back(c);
  c.contacts.discs.give_up();
  c.contacts.manifolds.accept();
  if (progress.sorted()) c.neighbours.broad.origin.keep();
  c.neighbours.stale = true;
  if (progress.waits != 0 && (!untouched() || progress.at != 0)) ++progress.spoiled;
  begin_again();
}

void StepWork::begin_again() {
  progress.part = 0;
  progress.at = 0;
  progress.lists = ListState::kept;
  progress.contacts = ContactState::kept;
  done_so_far.clear();
}

void StepWork::note(const Span& span) {
  if (untouched()) return;
  if (done_so_far.empty() || done_so_far.back().span != span.step) done_so_far.push_back({.span = span.step});
  done_so_far.back().part = progress.part;
  done_so_far.back().at = progress.at;
}

void StepWork::pushed(const StepContext& c, std::uint32_t id, const Motion& before) {
  if (untouched()) return;
  c.neighbours.renewal.doubt();
  if (progress.lists == ListState::begun) return spoil(c);  // the body may be copied already
  const std::uint32_t slot = c.bodies.info[id].slot;
  const double gain = static_cast<double>(c.population.speed_of(slot) - before.fastest());
  const double way = kMarginFrames * c.desc.dt * std::max<int>(progress.horizon, progress.waits + 1) * gain;
  if (!(way <= 0.02 * static_cast<double>(c.bodies.radius[slot]))) return spoil(c);
  done_so_far.push_back({.id = id, .vx = before.vx, .vy = before.vy, .rim_speed = before.rim_speed});
}

bool put_renewed(const StepContext& c) {
  ListRenewal& renewal = c.neighbours.renewal;
  Manifolds& manifolds = c.contacts.manifolds;
  if (c.sorts_out()) {
    const Joined joined = [&c](std::uint32_t a, std::uint32_t b) { return c.joints.joined(a, b); };
    manifolds.sort_out_renewed(c.bodies, c.statics, c.joints.any_exclusions() ? &joined : nullptr, renewal.pairs(),
                               renewal.near(), c.pool);
  }
  if (!renewal.put(c.neighbours.table)) return false;
  if (c.sorts_out()) manifolds.put_renewed([&renewal](std::uint32_t slot) { return renewal.found(slot); });
  renewal.finish();
  c.contacts.discs.renew(renewal.statics_changed(), c.neighbours.table);
  return true;
}

}  // namespace psim
