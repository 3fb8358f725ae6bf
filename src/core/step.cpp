// One step, in order. Read World::Impl::step from top to bottom: each call is a stage, or a group
// of stages, in a file of its own name. docs/step.md is the same list with what each reads and
// writes.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "float_settings.h"
#include "stage_timer.h"
#include "tasks.h"
#include "world_impl.h"

namespace psim {
namespace {

using Clock = std::chrono::steady_clock;
using kernels::kBlock;

double ms_between(Clock::time_point begin, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - begin).count();
}

// Sideways motion within a step after which a contact's normal is computed anew, of the radius.
constexpr float kRefreshOfRadius = 0.02f;
constexpr double kStiffening = 0.98;    // a step, of the substep that contact stiffness is for
constexpr double kSoftening = 1.1;
constexpr double kMostWarm = 4;  // on stored impulses where a step is longer than the last

}  // namespace

StepReport World::Impl::step(double dt) { return step(dt, {}, true); }

// With the detail given, or one that the governor chooses.
StepReport World::Impl::step(double dt, const StepDetail& given, bool choose) {
  const FloatSettings settings;
  const Clock::time_point begin = tracer.begin();
  StepReport report;
  if (!(dt > 0 && dt <= 10)) return report;  // as World::create has it
  const std::uint64_t growths = memory.growths;
  const auto skips = skipped_frames;
  const WorkerPool::Awake awake(pool);
  report.rebuilt = prepared() && choose && dt == desc.dt;
  if (report.rebuilt) unprepared = std::vector<std::byte>();
  settle_lists();
  freeze_doubtful(report);
  replan();
  detailed = !choose;
  report.detail = given;
  if (given.frames == 0) report.detail.frames = 1;
  if (plan.publish && placed) publisher.look(bodies, fixed, frozen, sleepers.list, lattice);
  placed = false;
  if (choose && governor.on()) {
    choose_detail(dt, report);
  } else if (!given.solves && !given.wakes) {
    work_ahead(dt, report);
  }
  if (report.detail.solves || report.detail.wakes) {
    const double frame_dt = dt;
    dt *= report.detail.frames;
    const Span span{ahead.part == Part::check ? dt : frame_dt,
                    frame_dt * std::max(report.detail.frames, report.detail.horizon)};
    advance(dt, span, choose && governor.on(), report);
  }
  if (report.detail.solves) {
    ahead = {};
  } else {
    events.clear();
    if (ahead.waits < 255) ++ahead.waits;
    report.awake = bodies.count - bodies.dead;
  }
  ++frame;
  if (plan.publish) {
    const StageTimer timer(report, tracer, Stage::publish);
    publisher.publish(bodies, fixed, frozen, sleepers.list, lattice, frame, pool);
  }
  if (plan.sleep && report.detail.solves) rest(dt, report);
  report.arena_growths = memory.growths - growths;
  report.asleep = bodies.asleep;
  report.skipped = settle_skips(skips, report.rebuilt);
  report.total_ms = ms_between(begin, tracer.begin());
  return report;
}

// What was left out in a step, a bit each; whatever was passed over more than once counts once, and lists that
// were made again do not count as kept.
std::uint32_t World::Impl::settle_skips(const std::array<std::uint64_t, kSkipCount>& before, bool rebuilt) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < kSkipCount; ++k) {
    const bool skipped = skipped_frames[k] != before[k] && !(rebuilt && (k == 1 || k == 3));
    skipped_frames[k] = before[k] + (skipped ? 1 : 0);
    bits |= (skipped ? 1u : 0u) << k;
  }
  return bits;
}

// Everything moves on by dt seconds; or waits, if bodies woke and there is no time for new lists.
void World::Impl::advance(double dt, const Span& span, bool choose, StepReport& report) {
  substeps = report.detail.substeps != 0 ? report.detail.substeps : desc.substeps;
  report.detail.substeps = static_cast<std::uint8_t>(substeps);
  if (bodies.count != bodies.dead) {
    refresh_lists(dt, span, report);
    // The lists name who may be met in this step, those of the last one did not.
    if (!sleepers.empty() && wake_reached(dt)) {
      if (report.detail.wakes || (choose && !fits_again(report))) {
        report.detail.wakes = true;
        report.detail.solves = false;
        return;
      }
      refresh_lists(dt, span, report);
    }
  }
  report.detail.wakes = false;
  report.detail.solves = true;
  ++steps;
  if (bodies.count != bodies.dead) {
    solve(dt, report);
    if (plan.continuous) {
      const StageTimer timer(report, tracer, Stage::solver);
      bodies.find_slots();
      report.stopped = continuous.stop(bodies, manifolds, table, shapes, lattice, bullets,
                                       plan.filters, pool);
      report.fast = continuous.fast();
    }
    integrate(dt, report);
    if (counting_lanes && steps % kLaneSteps == 0) count_lanes(report);
    report.awake = bodies.count - bodies.dead;
  } else {  // nobody moves: all is left out but what somebody asked for
    for (std::size_t k = 0; k < kSkipCount; ++k) {
      skipped_frames[k] += kSkipNames[k] == "publish" ? !plan.publish : kSkipNames[k] == "events" ? !plan.events : 1;
    }
  }
  queries.forget_moving();
  if (plan.events) {
    const StageTimer timer(report, tracer, Stage::publish);
    events.collect(event_source(), queries, query_source());
    sleepers.changed = false;
  }
  if (report.awake != 0) count_contacts(report);
}

// Broad phase, narrow phase and colouring, as far as they were not done ahead: contacts with normals and
// gaps for a step of dt seconds.
void World::Impl::refresh_lists(double dt, const Span& span, StepReport& report) {
  const bool lasting = ahead.part != Part::check && !ahead.laid;  // lists were found to serve one frame
  if (lasting && report.detail.frames > 1 && !lists_serve(dt)) spoil_lists();
  finish_work(span, report);
  kept_contacts = !ahead.laid;
  accept_work();
  const StageTimer timer(report, tracer, Stage::narrow_phase);
  if (plan.shapes) lay_out_manifolds(dt);
  if (contacts.pair_blocks() + contacts.single_blocks() == 0) {
    if (!manifolds.any()) ++skipped_frames[2];
    solved.load(bodies, pool);  // those that were linked by pairs that must not collide
    return;
  }
  narrow_phase(bodies, solved, shapes, walls, lattice, kRefreshOfRadius * least_radius, table,
               contacts, kernels, pool);
}

bool World::Impl::sorts_out() const {
  return plan.shapes || plan.filters || joints.any_exclusions();
}

// What manifolds need to know of a step of dt seconds.
ManifoldParams World::Impl::manifold_params(double dt) const {
  ManifoldParams p;
  p.dt = dt;
  p.gravity = desc.gravity;
  p.lattice = &lattice;
  p.shapes = &shapes;
  p.kernels = &kernels;
  p.walls = walls;
  p.wall = desc.wall;
  return p;
}

// Colours and blocks of the manifolds that were found.
void World::Impl::lay_out_manifolds(double dt) {
  const double h = dt / substeps;
  ManifoldParams p = manifold_params(dt);
  Solver::manifold_softness(h, next_stiff_substep(h), p);
  const std::array<float, 4> soft{p.soft[0], p.rate[0], p.soft[2], p.rate[2]};  // the others follow from these
  p.changed = soft != manifold_soft;
  manifold_soft = soft;
  p.asleep = !sleepers.empty();
  lanes.vector += manifolds.batches().used;
  lanes.scalar += manifolds.batches().alone;
  manifolds.lay_out(bodies, loads, p, solved.dummies(), pool);
  columns.place(manifolds);
}

// Contacts stiffen and soften by and by where the length of steps changes: what rests on a soft
// contact's overlap would be thrown off by a stiff one, and what rests on a stiff one sink in.
double World::Impl::next_stiff_substep(double h) const {
  return stiff_substep > 0 ? std::clamp(h, kStiffening * stiff_substep, kSoftening * stiff_substep)
                           : h;
}

void World::Impl::solve(double dt, StepReport& report) {
  if (forces && (forces_stale || bodies.acc.empty())) {
    const StageTimer timer(report, tracer, Stage::forces);
    const std::size_t padded = kernels::round_up_block(bodies.count);
    const std::size_t all = std::max(2 * padded, bodies.vel0.capacity());  // padding lanes read it
    bodies.acc.reserve(all);
    std::fill(bodies.acc.data() + 2 * padded, bodies.acc.data() + all, 0.0f);
    if (plan.integrator != Integrator::verlet) bodies.bend.reserve(2 * padded);
    if (plan.scales) {
      bodies.pull.reserve(padded);
      forces->scale_gravity(bodies, pool);
    }
    forces_stale = false;
  }
  if (!forces) ++skipped_frames[0];
  if (!plan.restitution) ++skipped_frames[5];
  if (!plan.masses && !plan.friction) ++skipped_frames[6];
  if (!plan.friction) ++skipped_frames[7];
  if (!plan.rotation) ++skipped_frames[8];
  if (!plan.publish) ++skipped_frames[9];
  if (!loads.any()) ++skipped_frames[10];
  if (!plan.events) ++skipped_frames[11];
  if (!plan.shapes) ++skipped_frames[12];
  if (!plan.joints) ++skipped_frames[13];
  if (!sorts_out()) ++skipped_frames[14];
  if (!plan.continuous) ++skipped_frames[15];
  const StageTimer timer(report, tracer, Stage::solver);
  if (contacts.pair_blocks() + contacts.single_blocks() == 0 && !sorts_out() && !plan.fields &&
      held.empty() && joints.empty()) {
    ++skipped_frames[4];
    solver.pass();
    return;  // nobody is near anything: the closed form of integrate is all
  }
  SolverParams p;
  p.dt = dt;
  p.substeps = substeps;
  p.gravity = desc.gravity;
  p.damping = desc.linear_damping + linear_drag(desc.fields);
  p.pitch_x = lattice.pitch_x();
  p.pitch_y = lattice.pitch_y();
  p.restitution_threshold = desc.restitution_threshold;
  p.refresh = kRefreshOfRadius * least_radius;
  const double h = dt / substeps;
  p.impacts = impact_rate * h;
  stiff_substep = next_stiff_substep(h);
  p.stiff_substep = stiff_substep;
  // Loads grow with the step, but impacts do not: not many times over.
  p.warm = last_substep > 0 ? static_cast<float>(std::fmin(h / last_substep, kMostWarm)) : 1.0f;
  p.model = plan.model;
  p.turns = plan.turns;
  p.most_sweeps = report.detail.sweeps;
  if (plan.turns) {
    pool.run(stream_tasks(bodies.blocks()), [&](std::size_t t) {
      const BlockRange r = stream_range(t, bodies.blocks());
      std::fill(bodies.turn.data() + std::size_t{r.begin} * 2 * kBlock,
                bodies.turn.data() + std::size_t{r.end} * 2 * kBlock, 0.0f);
      std::fill(bodies.swing.data() + std::size_t{r.begin} * kBlock,
                bodies.swing.data() + std::size_t{r.end} * kBlock, 0.0f);
    });
  }
  if (plan.joints) joints.prepare(bodies, fixed, solved, lattice, h, pool);
  last_substep = h;
  if (plan.events) events.approach(event_source(), dt);
  const SolverReport done =
      solver.run(bodies, solved, table, contacts, manifolds, columns, joints, p, forces.get(), held, kernels, pool);
  report.virial =
      done.virial *
      (plan.model.model == kernels::Model::plain ? static_cast<double>(first_mass) : 1.0);
  report.stage_ms[static_cast<std::size_t>(Stage::forces)] += done.forces_ms;
  report.stage_ms[static_cast<std::size_t>(Stage::solver)] -= done.forces_ms;
  const std::uint64_t passes = 2u * static_cast<std::uint64_t>(substeps) + 2;
  const std::uint64_t work =
      passes * kBlock *
          (std::uint64_t{contacts.pair_blocks()} + contacts.single_blocks() + manifolds.blocks()) +
      joints.lane_operations(substeps);
  if (options.isa == Isa::scalar) {
    lanes.scalar += work;
  } else {
    lanes.vector += work;
    // The geometry of the first and the columns' contacts are done one by one.
    lanes.scalar += contacts.single_count() + 2u * static_cast<std::uint64_t>(substeps) * columns.link_count();
  }
}

// Free bodies take the closed form of the frame; every body's offset folds into its lattice place.
void World::Impl::integrate(double dt, StepReport& report) {
  const StageTimer timer(report, tracer, Stage::integrate);
  const double c = desc.linear_damping + linear_drag(desc.fields);
  // x(t) = x + v (1-e^-ct)/c + g (t - (1-e^-ct)/c)/c,  v(t) = v e^-ct + g (1-e^-ct)/c
  const double span = c > 0 ? -std::expm1(-c * dt) / c : dt;
  const double fall = c * dt > 1e-4 ? (dt - span) / c : dt * dt / 2 * (1 - c * dt / 3);
  kernels::StreamParams p;
  p.h = static_cast<float>(dt);
  p.damp = static_cast<float>(std::exp(-c * dt));
  p.kick_x = static_cast<float>(desc.gravity.x * span);
  p.kick_y = static_cast<float>(desc.gravity.y * span);
  p.coast = static_cast<float>(span);
  p.drop = static_cast<float>(fall);
  p.fall_x = static_cast<float>(desc.gravity.x * fall);
  p.fall_y = static_cast<float>(desc.gravity.y * fall);
  p.pitch_x = static_cast<float>(lattice.pitch_x());
  p.pitch_y = static_cast<float>(lattice.pitch_y());
  p.inv_pitch_x = static_cast<float>(1 / lattice.pitch_x());
  p.inv_pitch_y = static_cast<float>(1 / lattice.pitch_y());
  const double limit = speed_limit(dt);
  p.speed_limit2 = static_cast<float>(limit * limit);
  const std::uint32_t blocks = bodies.blocks();
  const kernels::BodyView view = bodies.view();
  p.far_x = static_cast<float>(kFarSteps * lattice.pitch_x());
  p.far_y = static_cast<float>(kFarSteps * lattice.pitch_y());
  const bool bounded = desc.boundary != Boundary::periodic;
  std::atomic<bool> fine{true}, inside{true};
  const bool turning = !bodies.spin.empty();
  pool.run(stream_tasks(blocks), [&](std::size_t t) {
    const BlockRange r = stream_range(t, blocks);
    if (!kernels.integrate(view, p, r.begin, r.end)) fine.store(false, std::memory_order_relaxed);
    if (bounded && !walls_hold(r)) inside.store(false, std::memory_order_relaxed);
    if (!turning) return;
    for (std::size_t i = std::size_t{r.begin} * kBlock;
         i < std::min<std::size_t>(std::size_t{r.end} * kBlock, bodies.count); ++i) {
      if (bodies.linked[i] == 0) {  // others turned with the substeps
        bodies.angle[i] +=
            dt * (static_cast<double>(bodies.spin[i]) / static_cast<double>(bodies.radius[i]));
      }
      if ((plan.turns && !std::isfinite(bodies.spin[i])) || !std::isfinite(bodies.angle[i])) {
        fine.store(false, std::memory_order_relaxed);
      }
    }
  });
  (options.isa == Isa::scalar ? lanes.scalar : lanes.vector) += std::uint64_t{blocks} * kBlock;
  if (!fine.load()) settle_bad_bodies(dt, report);
  if (inside.load()) return;
  if (desc.boundary == Boundary::open) {
    remove_escaped(report);
  } else {
    bring_back();
  }
}

void World::Impl::count_contacts(StepReport& report) {
  report.pairs = contacts.pair_count() + contacts.single_count() + manifolds.pair_count();
  report.pairs_reused = kept_contacts ? report.pairs : 0;
  report.contacts = solver.closed();
  report.colours = std::max(contacts.colours(), manifolds.colours());
}

}  // namespace psim
