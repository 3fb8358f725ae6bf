// One step, in order: read step() from top to bottom. What its stages read and write is in docs/step.md; the work of
// lists and contacts is a table of parts (step/step_table.h). World::prepare does a first step's work ahead of it.
#include <algorithm>
#include <chrono>
#include <new>

#include "psim/limits.h"
#include "step/motion.h"
#include "world/world_impl.h"

namespace psim {
namespace {

Quarantine::Freeze freezer(Owners& w) {
  return [&w](const BodyState& last) { freeze_body(w, last); };
}

// A page of the ledger, and a report that follows the given detail, if there is one.
StepReport open_page(Owners& w, const StepDetail* given) {
  w.ledger.begin_step(w.memory);
  w.observers.events.breaks.clear();
  w.detailed = given != nullptr;
  StepReport report;
  if (given != nullptr) report.detail = *given;
  return report;
}

// The work of prepare() counts if the step is the one that it was done for; else it is taken back.
void take_prepared(Owners& w, double dt, StepReport& report) {
  report.rebuilt = !w.unprepared.empty() && !w.detailed && dt == w.desc.dt;
  if (report.rebuilt) w.unprepared = std::vector<std::byte>();
  w.settled();
}

// A renderer sees where bodies are before they move, if the host placed some.
void look_around(Owners& w) {
  if (w.plan.publish && w.observers.placed) w.observers.publisher.look(w.observed());
  w.observers.placed = false;
}

// Lists and contacts, as far as a governor or the given detail lets them.
void work_on_lists(Owners& w, double dt, StepReport& report) {
  StepDetail& detail = report.detail;
  const bool governed = !w.detailed && w.governor.on();
  if (w.bodies.awake() == 0) {
    if (governed) report.predicted_ms = 1e-6 * w.governor.govern_fluids(w, dt, detail);
    return;
  }
  if (governed) {
    w.governor.spend_frame(w, dt, report);
    if (detail.solves) return;
  } else if (detail.waits() && !detail.wakes) {
    w.progress.horizon = detail.horizon;
    w.progress.spread = true;
    run_parts(w, {dt, dt * detail.horizon}, report, detail.pieces);
  } else {
    return;
  }
  note_work(w, {dt, dt * detail.horizon});
}

// All that is left of the work on lists and contacts; then normals and gaps.
void finish_contacts(Owners& w, double dt, const Span& span, StepReport& report) {
  // Lists that last were found to serve one frame; this step may make up for more.
  const bool lasting = !w.progress.untouched() && !w.progress.lays_out();
  if (lasting && report.detail.frames > 1 && !w.neighbours.serve(dt)) spoil_work(w);
  run_parts(w, span, report);
  w.contacts.kept = !w.progress.lays_out();
  accept_work(w);
  const StageTimer timer(report, w.tracer, Stage::narrow_phase);
  narrow_phase(w, dt);
}

// Finds the contacts of a step of dt seconds. False if bodies woke that would be met and there is no time to look for
// their contacts: then the next frame does.
bool meet(Owners& w, double dt, const Span& span, StepReport& report) {
  finish_contacts(w, dt, span, report);
  // The lists name the bodies that may be met in this step, those of the last step did not.
  if (w.sleep.sleepers.empty() || !w.note_sleep(w.sleep.wake_reached(w.sleep_source(), dt))) return true;
  const bool governed = !w.detailed && w.governor.on();
  report.detail.wakes = report.detail.wakes || (governed && !w.governor.fits_again(w, report));
  if (report.detail.wakes) return false;
  finish_contacts(w, dt, span, report);
  return true;
}

// The step was done, but something that comes with it found no memory: the report says so.
void lose(StepReport& report, const char* what) {
  report.no_room_for = what;
  ran_out_of_memory() = true;
}

// Substeps, continuous collision, the rest of the way; bodies that may not be where they are then.
void move(Owners& w, double dt, StepReport& report) {
  if (w.plan.events) {
    w.contacts.manifolds.catch_up();
    w.observers.events.approach(w.observed(), dt);
  }
  const Moved moved = move_bodies(w, dt, report);
  if (w.joints.any_fragile()) {
    try {
      break_joints(w);
    } catch (const std::bad_alloc&) {  // a later step breaks the others
      w.recover();
      lose(report, "breaks");
    }
  }
  if (!moved.sound) report.quarantined += w.quarantine.settle(w.population, w.lattice, dt, freezer(w));
  if (!moved.inside && w.desc.boundary == Boundary::open) {
    const auto remove = [&w](std::uint32_t id) { remove_body(w, id); };
    const std::uint64_t before = w.quarantine.escaped;
    try {
      w.quarantine.remove_escaped(w.population, w.desc.bounds, remove);
    } catch (const std::bad_alloc&) {  // the next step removes the others
      w.recover();
      lose(report, "escape");
    }
    report.escaped += static_cast<std::uint32_t>(w.quarantine.escaped - before);
  } else if (!moved.inside) {
    Quarantine::bring_back(w.population, w.lattice, w.desc);
  }
}

void move_fluids(Owners& w, double dt, StepReport& report) {
  if (!w.fluids.active()) return;
  const StageTimer timer(report, w.tracer, Stage::fluid);
  w.dynamics.moving = true;  // from now on the step cannot be taken back
  if (!step_fluids(w, dt, report.detail.fluid_parts)) lose(report, "emitters");
}

void collect_events(Owners& w, StepReport& report) {
  if (!w.plan.events) return;
  const StageTimer timer(report, w.tracer, Stage::publish);
  try {
    w.observers.events.collect(w.observed(), w.observers.queries, last_step(w), w.fluids);
  } catch (const std::bad_alloc&) {
    w.observers.events.start_over();
    lose(report, "events");
  }
  w.sleep.sleepers.changed = false;
}

void count_contacts(const Owners& w, StepReport& report) {
  const Contacts& contacts = w.contacts;
  report.pairs = contacts.discs.pairs.count + contacts.discs.fixed.count + contacts.manifolds.pair_count();
  report.pairs_reused = contacts.kept ? report.pairs : 0;
  report.contacts = w.dynamics.solver.closed();
  report.touching = w.dynamics.solver.touching();
  report.colours = std::max(contacts.discs.colours(), contacts.manifolds.totals().colours);
}

// All that comes before bodies move. Time stands still after it, if bodies woke and there is no time for new lists.
void get_ready(Owners& w, double frame_dt, StepReport& report) {
  replan(w);
  look_around(w);
  work_on_lists(w, frame_dt, report);
  StepDetail& detail = report.detail;
  if (!detail.solves && !detail.wakes) return;
  const double dt = frame_dt * detail.frames;
  const Span span{w.progress.untouched() ? dt : frame_dt, frame_dt * std::max(detail.frames, detail.horizon)};
  w.dynamics.substeps = detail.substeps != 0 ? detail.substeps : w.desc.substeps;
  detail.substeps = static_cast<std::uint8_t>(w.dynamics.substeps);
  detail.solves = w.bodies.awake() == 0 || meet(w, dt, span, report);
}

// No memory, and nothing has moved: the world is as before the step, but that its lists will be made again.
void give_up(Owners& w, StepReport& report) {
  const bool lists = !all_done(w.progress) && step_parts()[w.progress.part].stage == Stage::broad_phase;
  report.no_room_for = lists ? "pairs" : "contacts";
  w.recover();
  w.observers.events.clear();
  report.detail.solves = report.detail.wakes = false;
}

// Everything moves on.
void advance(Owners& w, double frame_dt, StepReport& report) {
  const double dt = frame_dt * report.detail.frames;
  report.detail.wakes = false;
  const bool awake = w.bodies.awake() != 0;
  if (awake) {
    move(w, dt, report);
  } else {
    w.ledger.skip_all(w.plan.publish, w.plan.events);
  }
  move_fluids(w, dt, report);
  w.ledger.skip(Skip::fluid, !w.fluids.active() || w.fluids.at_rest());
  ++w.ledger.steps;
  if (awake && w.ledger.surveys()) survey_lanes(w, report.rebuilt);
  w.observers.queries.forget(QueryIndex::kMoving);
  collect_events(w, report);
  if (w.bodies.awake() != 0) count_contacts(w, report);
  w.progress = {};
  push_by_fluids(w);
}

// Time stands still in this frame: the work goes on in the next one. Where bodies are pushed it begins again then: lists
// are made for the speeds that the forces of all frames will give.
void stand_still(Owners& w, double frame_dt) {
  for (AppliedForce& of : w.population.applied.entries()) {
    of.impulse = of.impulse + frame_dt * of.force;
    of.spin += frame_dt * of.torque;
    of.force = {};
    of.torque = 0;
  }
  if (!w.population.applied.empty()) spoil_work(w);
  w.observers.events.clear();
  if (w.progress.waits < 255) ++w.progress.waits;
}

void publish(Owners& w, StepReport& report) {
  ++w.ledger.frames;
  if (!w.plan.publish) return;
  const StageTimer timer(report, w.tracer, Stage::publish);
  try {
    w.observers.publisher.publish(w.observed(), w.ledger.frames);
  } catch (const std::bad_alloc&) {
    lose(report, "snapshot");
  }
}

// Bodies at rest fall asleep.
void fall_asleep(Owners& w, double frame_dt, StepReport& report) {
  if (!report.detail.solves || !w.plan.sleep || w.bodies.awake() == 0) return;
  const StageTimer timer(report, w.tracer, Stage::sleep);
  try {
    if (w.note_sleep(w.sleep.step(w.sleep_source(), w.ledger.steps, frame_dt * report.detail.frames))) {
      lay_down_in_fluids(w);
    }
  } catch (const std::bad_alloc&) {
    if (w.sleep.sleepers.leaving) throw;
    w.recover();
    lose(report, "sleep");
  }
}

// Bodies that fell asleep or woke, and those that moved.
void collect_sleep(Owners& w, StepReport& report) {
  if (!w.plan.events) return;
  const StageTimer timer(report, w.tracer, Stage::publish);
  try {
    w.observers.events.collect_sleep(w.observed(), report.detail.solves);
  } catch (const std::bad_alloc&) {
    w.observers.events.start_over();
    lose(report, "events");
  }
}

// Room for so many candidates and strips is made in small worlds, too: bodies come together.
constexpr std::size_t kFewPairs = 32768, kFewStrips = 256;

// Lists that serve several frames are longer. To make room for them takes longer than a frame may, so it is made before
// the first frame.
void spare_room(Owners& w) {
  const TouchedRoom touched(w.memory);
  BodyStore& bodies = w.bodies;
  NeighbourLists& lists = w.neighbours;
  Contacts& contacts = w.contacts;
  const std::size_t each = w.plan.radii ? 20 : 12;
  const std::size_t pairs = std::max<std::size_t>(2 * std::max(lists.table.pair_room, lists.candidates.pair_room),
                                                  each * bodies.count + kFewPairs);
  for (PairTable* of : {&lists.table, &lists.old_table, &lists.candidates}) of->spare(bodies.count, pairs);
  const std::size_t all = kernels::round_up_block(bodies.count) + 2 * lists.table.strips.size() + kFewStrips;
  lists.broad.spare(bodies.count, all);
  keep_if(true, lists.candidates.owner.capacity(), lists.picked_owner, lists.picked_other);
  if (bodies.count >= BroadPhase::kSmallWorld) lists.renewal.spare(bodies.count);
  if (w.plan.uneven) lists.thrown.spare(bodies.count);
  for (Column<float>* of : {&bodies.vel, &bodies.disp, &bodies.vel0}) of->reserve(2 * all);
  bodies.pos.reserve(2 * all);
  if (w.plan.manifolds && !lists.table.strips.empty()) {
    const std::size_t cornered = w.population.traits.cornered;
    const std::size_t most = std::min(24 * cornered, 12 * cornered + kFewPairs);
    contacts.manifolds.spare(std::max<std::size_t>(2 * contacts.manifolds.pair_count(), most),
                             lists.table.strips.size());
  }
  contacts.discs.spare(w.plan.materials ? bodies.count : 0,
                       std::max<std::size_t>(2 * kernels::kBlock * contacts.discs.pairs.blocks,
                                             (w.plan.radii ? 8 : 5) * std::size_t{bodies.count}),
                       2 * kernels::kBlock * contacts.discs.fixed.blocks + 1024);
  if (!w.plan.forces && !w.plan.turns && !w.plan.restraints) {
    contacts.solved.spare(kernels::round_up_block(bodies.count) + 1024, !bodies.rim_speed.empty(), w.plan.restitution);
  }
}

}  // namespace

namespace {

// s: the square of a substep of it is no denormal.
constexpr double kLeastStep = 1e-15;

StepReport try_step(Owners& w, double dt, const StepDetail* given) {
  const FloatSettings settings;
  const Tracer::Clock::time_point begin = w.tracer.begin();
  const WorkerPool::Awake awake(w.pool, WorkerPool::Work::step);
  StepReport report = open_page(w, given);
  w.dynamics.moving = false;
  bool refused = false;
  try {
    take_prepared(w, dt, report);
    report.quarantined = w.quarantine.freeze_doubtful(w.population, freezer(w));
    get_ready(w, dt, report);
    if (report.detail.solves) advance(w, dt, report);
  } catch (const std::bad_alloc&) {
    if (w.dynamics.moving) throw;
    give_up(w, report);
    refused = true;
  }
  if (!refused) {
    if (report.detail.waits()) stand_still(w, dt);
    publish(w, report);
    fall_asleep(w, dt, report);
    collect_sleep(w, report);
  }
  // At one moment, so that each body is counted once.
  report.awake = w.bodies.awake();
  report.asleep = w.sleep.sleepers.list.size();
  w.ledger.end_step(w.memory, report);
  report.total_ms = std::chrono::duration<double, std::milli>(w.tracer.begin() - begin).count();
  return report;
}

}  // namespace

StepReport step(Owners& w, double dt, const StepDetail* given) {
  if (!limits::kTimeStep.contains(dt)) return {};
  try {
    if (!w.broken) return try_step(w, std::max(dt, kLeastStep), given);
  } catch (const std::bad_alloc&) {
    w.broken = true;
    w.fluids.clear();  // they may be half sorted
  }
  ran_out_of_memory() = true;
  StepReport report;
  report.no_room_for = "motion";
  report.detail.solves = false;
  return report;
}

namespace {

void prepare_first_step(Owners& w, const Ledger& counted) {
  std::vector<std::byte> before;
  psim::save(w, before);
  const FloatSettings settings;
  const WorkerPool::Awake awake(w.pool, WorkerPool::Work::other);
  const Span span{w.desc.dt, w.desc.dt};
  StepReport ignored;
  replan(w);
  w.tracer.begin();
  finish_contacts(w, w.desc.dt, span, ignored);
  if (w.governor.on()) spare_room(w);
  if (w.plan.sleep && w.sleep.sleepers.anyone_slow()) w.sleep.make_room(w.sleep_source());
  w.ledger = counted;
  w.go_back_or_lose(before);
  replan(w);
  w.tracer.begin();
  run_parts(w, span, ignored);
  if (w.plan.manifolds) {  // a step with as many substeps leaves them as they lie
    w.dynamics.substeps = w.desc.substeps;
    lay_out_manifolds(w, w.desc.dt);
  }
  w.unprepared = std::move(before);
}

}  // namespace

// All of a first step but its substeps, for the room that it takes, and again as far as a step can be made ahead. Since
// the host may still change anything, how it was before is kept until the step.
void World::prepare() {
  Owners& w = *impl_;
  if (w.ledger.frames != 0 || !w.unprepared.empty() || w.bodies.awake() == 0 || !w.quarantine.doubtful.empty()) {
    return;
  }
  if (w.pre_solve && w.population.traits.asking != 0) return;  // the host is asked in steps alone
  const Ledger counted = w.ledger;
  try {
    prepare_first_step(w, counted);
  } catch (const std::bad_alloc&) {
    w.recover();  // the first step will tell
  }
  w.ledger = counted;
}

Owners& Owners::settled() {
  if (broken) throw std::bad_alloc();
  if (unprepared.empty()) return *this;
  std::vector<std::byte> before = std::move(unprepared);
  unprepared.clear();
  go_back_or_lose(before);
  return *this;
}

}  // namespace psim
