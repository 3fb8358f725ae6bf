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
    if (!c.sleepers.recent.empty()) {
      c.sleepers.recent.clear();
      if (!c.plan.sleep) c.sleepers.recent = TouchMemory();
    }
    c.contacts.impulses_valid = true;
  }
  if (progress.makes_lists()) {
    c.neighbours.broad.forget_origin();
    c.neighbours.broad.finish();
  }
  begin_again();
}

void StepWork::spoil(const StepContext& c) {
  turn_back(c);
  c.contacts.discs.give_up();
  c.contacts.manifolds.accept();
  if (progress.sorted()) c.neighbours.broad.keep_origin();
  c.neighbours.stale = true;
  if (progress.waits != 0 && (!untouched() || progress.at != 0)) ++progress.spoiled;
  begin_again();
}

void StepWork::begin_again() {
  progress.part = 0;
  progress.at = 0;
  progress.lists = ListState::kept;
  progress.contacts = ContactState::kept;
}

}  // namespace psim
