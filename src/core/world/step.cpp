// One step, in order: read World::Impl::step from top to bottom. What its stages read and write is in docs/step.md; the
// work of lists and contacts is a table of parts (step/step_table.h).
#include <algorithm>
#include <chrono>
#include <limits>

#include "base/machine.h"
#include "base/trace.h"
#include "step/motion.h"
#include "world/world_impl.h"

namespace psim {

StepReport World::Impl::step(double dt) { return step(dt, {}, true); }

// With the detail given, or with one that the governor chooses.
StepReport World::Impl::step(double dt, const StepDetail& given, bool choose) {
  StepReport report;
  if (!(dt > 0 && dt <= 10)) return report;               // World::create has the same limits
  dt = std::max(dt, std::numeric_limits<double>::min());  // FloatSettings would make a shorter one zero
  const FloatSettings settings;
  const Tracer::Clock::time_point begin = tracer.begin();
  const WorkerPool::Awake awake(pool);
  ledger.begin_step(memory);
  report.detail = given;
  if (given.frames == 0) report.detail.frames = 1;
  take_prepared(dt, choose, report);
  settled();
  report.quarantined += quarantine.freeze_doubtful(population, freezer());
  replan();
  look_around();
  work_on_lists(dt, choose, report);
  if (report.detail.solves || report.detail.wakes) advance(dt, choose, report);
  if (report.detail.solves) {
    step_work.progress = {};
  } else {
    stand_still(report);
  }
  publish(report);
  if (report.detail.solves) fall_asleep(dt * report.detail.frames, report);
  report.asleep = sleep.sleepers.list.size();
  ledger.end_step(memory, report);
  report.total_ms = std::chrono::duration<double, std::milli>(tracer.begin() - begin).count();
  return report;
}

// The work of prepare() counts if the step is the one that it was done for.
void World::Impl::take_prepared(double dt, bool choose, StepReport& report) {
  report.rebuilt = prepared() && choose && dt == desc.dt;
  if (report.rebuilt) unprepared = std::vector<std::byte>();
}

// A renderer sees where bodies are before they move, if the host placed some.
void World::Impl::look_around() {
  if (plan.publish && placed) observers.publisher.look(observed());
  placed = false;
}

// Lists and contacts, as far as a governor or the given detail lets them.
void World::Impl::work_on_lists(double dt, bool choose, StepReport& report) {
  detailed = !choose;
  if (population.bodies.awake() == 0) return;
  const StepDetail& detail = report.detail;
  if (choose && governor.on()) {
    governor.spend_frame(context(), step_work, dt, frame == 0, report);
    if (detail.solves) return;
  } else if (detail.waits() && !detail.wakes) {
    step_work.progress.horizon = detail.horizon;
    step_work.progress.spread = true;
    step_work.run_pieces(context(), {dt, dt * detail.horizon}, report, detail.pieces);
  } else {
    return;
  }
  step_work.note({dt, dt * detail.horizon});
}

// Everything moves on; or time stands still, if bodies woke and there is no time for new lists.
void World::Impl::advance(double frame_dt, bool choose, StepReport& report) {
  const double dt = frame_dt * report.detail.frames;
  const Span span{step_work.untouched() ? dt : frame_dt,
                  frame_dt * std::max(report.detail.frames, report.detail.horizon)};
  dynamics.substeps = report.detail.substeps != 0 ? report.detail.substeps : desc.substeps;
  report.detail.substeps = static_cast<std::uint8_t>(dynamics.substeps);
  const bool anyone = population.bodies.awake() != 0;
  if (anyone && !meet(dt, span, choose && governor.on(), report)) return;
  report.detail.wakes = false;
  report.detail.solves = true;
  ++steps;
  if (anyone) {
    move(dt, report);
  } else {
    ledger.skip_all(plan.publish, plan.events);
  }
  observers.queries.forget(QueryIndex::kMoving);
  collect_events(report);
  if (report.awake != 0) count_contacts(report);
}

// Finds the contacts of a step of dt seconds. False if bodies woke that would be met and there is no time to look for
// their contacts: then the next frame does.
bool World::Impl::meet(double dt, const Span& span, bool governed, StepReport& report) {
  finish_contacts(dt, span, report);
  // The lists name the bodies that may be met in this step, those of the last step did not.
  if (sleep.sleepers.empty() || !note_sleep(sleep.wake_reached(sleep_source(), dt))) return true;
  if (report.detail.wakes || (governed && !governor.fits_again(context(), report))) {
    report.detail.wakes = true;
    report.detail.solves = false;
    return false;
  }
  finish_contacts(dt, span, report);
  return true;
}

// All that is left of the work on lists and contacts; then normals and gaps.
void World::Impl::finish_contacts(double dt, const Span& span, StepReport& report) {
  // Lists that last were found to serve one frame; this step may make up for more.
  const bool lasting = !step_work.untouched() && !step_work.progress.lays_out();
  if (lasting && report.detail.frames > 1 && !neighbours.serve(dt)) spoil_lists();
  step_work.finish(context(), span, report);
  contacts.kept = !step_work.progress.lays_out();
  step_work.accept(context());
  const StageTimer timer(report, tracer, Stage::narrow_phase);
  prepare_contacts(context(), dt);
}

// Substeps, continuous collision, the rest of the way.
void World::Impl::move(double dt, StepReport& report) {
  const StepContext c = context();
  if (const std::optional<SolverParams> params = prepare_substeps(c, dt, report)) {
    if (plan.events) observers.events.approach(observed(), dt);
    run_substeps(c, *params, report);
  }
  stop_fast_bodies(c, report);
  const Integrated moved = integrate(c, dt, report);
  if (!moved.sound) report.quarantined += quarantine.settle(population, lattice, dt, freezer());
  if (!moved.inside && desc.boundary == Boundary::open) {
    report.escaped += quarantine.remove_escaped(population, desc.bounds, [this](std::uint32_t id) { remove(id); });
  } else if (!moved.inside && Quarantine::bring_back(population, lattice, desc)) {
    dynamics.forces_stale = true;
  }
  if (ledger.surveys(steps)) survey_lanes(c, report.rebuilt);
  report.awake = population.bodies.awake();
}

void World::Impl::collect_events(StepReport& report) {
  if (!plan.events) return;
  const StageTimer timer(report, tracer, Stage::publish);
  observers.events.collect(observed(), observers.queries);
  sleep.sleepers.changed = false;
}

// Time stands still in this frame: the work goes on in the next one.
void World::Impl::stand_still(StepReport& report) {
  observers.events.clear();
  if (step_work.progress.waits < 255) ++step_work.progress.waits;
  report.awake = population.bodies.awake();
}

void World::Impl::publish(StepReport& report) {
  ++frame;
  if (!plan.publish) return;
  const StageTimer timer(report, tracer, Stage::publish);
  observers.publisher.publish(observed(), frame);
}

void World::Impl::fall_asleep(double dt, StepReport& report) {
  if (!plan.sleep || population.bodies.awake() == 0) return;
  const StageTimer timer(report, tracer, Stage::sleep);
  note_sleep(sleep.step(sleep_source(), steps, dt));
}

void World::Impl::count_contacts(StepReport& report) {
  report.pairs = contacts.discs.pair_count() + contacts.discs.static_count() + contacts.manifolds.pair_count();
  report.pairs_reused = contacts.kept ? report.pairs : 0;
  report.contacts = dynamics.solver.closed();
  report.colours = std::max(contacts.discs.colours(), contacts.manifolds.colours());
}

}  // namespace psim
