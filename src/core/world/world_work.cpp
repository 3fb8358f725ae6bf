// The world's side of the work of a step (step/step_work.h): what the host's changes do to it, and what saved states
// must know of it.
#include <algorithm>

#include "bodies/body_store.h"
#include "world/world_impl.h"

namespace psim {

StepContext World::Impl::context() {
  const auto keep_touches = [this] {
    if (sleepers.woke) sleep.keep_touches_of_woken(sleep_source(), contacts.impulses_valid);
  };
  return {desc,       plan,     lattice,     walls,  kernels,  pool,       tracer,   ledger,   governor,
          population, bodies,   statics,     joints, sleepers, neighbours, contacts, dynamics, step_work.progress,
          steps,      detailed, keep_touches};
}

// What was made for this step is thrown away.
void World::Impl::spoil_lists() {
  step_work.spoil(context());
  saved.done.clear();
}

// The contacts of this step count from now on.
void World::Impl::accept_work() {
  if (step_work.progress.lays_out()) saved.bare = false;
  step_work.accept(context());
  saved.done.clear();
}

// A body's velocity was changed by the host: lists and manifolds that were made for this step do not serve it
// if it is much faster now.
void World::Impl::pushed(std::uint32_t id, const Motion& before) {
  const StepProgress& now = step_work.progress;
  if (now.untouched()) return;
  neighbours.renewal.doubt();
  if (now.lists == ListState::begun) return spoil_lists();  // the body may be copied already
  const std::uint32_t slot = bodies.info[id].slot;
  const double gain = static_cast<double>(population.speed_of(slot) - before.fastest());
  const double way = kMarginFrames * desc.dt * std::max<int>(now.horizon, now.waits + 1) * gain;
  if (!(way <= 0.02 * static_cast<double>(bodies.radius[slot]))) return spoil_lists();
  Saved::Done push;
  push.id = id;
  push.vx = before.vx;
  push.vy = before.vy;
  push.rim_speed = before.rim_speed;
  saved.done.push_back(push);
}

// A frame in which time stands still ends here: saved states must know how far the work came.
void World::Impl::note_work(const Span& span) {
  if (step_work.untouched()) return;
  if (saved.done.empty() || saved.done.back().span != span.step) {
    saved.done.emplace_back();
    saved.done.back().span = span.step;
  }
  saved.done.back().part = step_work.progress.part;
  saved.done.back().at = step_work.progress.at;
}

void World::Impl::choose_detail(double dt, StepReport& report) {
  if (bodies.count == bodies.dead) return;
  governor.spend_frame(context(), step_work, dt, frame == 0, report);
  if (!report.detail.solves) note_work({dt, dt * report.detail.horizon});
}

// Does as many pieces of a step's work as the detail says.
void World::Impl::work_ahead(double dt, StepReport& report) {
  if (bodies.count == bodies.dead) return;
  const Span span{dt, dt * report.detail.horizon};
  step_work.progress.horizon = report.detail.horizon;
  step_work.progress.spread = true;
  step_work.run_pieces(context(), span, report, report.detail.pieces);
  note_work(span);
}

}  // namespace psim
