#include "step/motion.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/elementary.h"
#include "base/tasks.h"
#include "base/trace.h"
#include "bodies/quarantine.h"
#include "least.h"
#include "solver/applied_forces.h"

namespace psim {
namespace {

using kernels::kBlock;

// Sideways motion within a step after which a contact's normal is computed anew, as a share of the least radius.
constexpr float kRefreshOfRadius = 0.02f;
constexpr double kMostWarm = 4;  // factor on stored impulses where a step is longer than the last

// Where lanes are counted: with one lane a register everything is done one at a time.
std::uint64_t& lanes_counted(StepContext& c) {
  return c.kernels.width == 1 ? c.ledger.lanes.scalar : c.ledger.lanes.vector;
}

// Accelerations that differ from body to body, after the bodies were sorted.
void prepare_forces(StepContext& c, StepReport& report) {
  Dynamics& dynamics = c.dynamics;
  BodyStore& bodies = c.bodies;
  if (!dynamics.forces || !(dynamics.forces_stale || bodies.acc.empty())) return;
  const StageTimer timer(report, c.tracer, Stage::forces);
  dynamics.forces_stale = true;  // until all is there
  const std::size_t padded = kernels::round_up_block(bodies.count);
  const std::size_t all = std::max(2 * padded, bodies.vel0.capacity());  // padding lanes read it
  bodies.acc.reserve(all);
  std::fill(bodies.acc.data() + 2 * padded, bodies.acc.data() + all, 0.0f);
  if (c.plan.integrator != Integrator::verlet) bodies.drift_correction.reserve(2 * padded);
  if (c.plan.scales) {
    bodies.pull.reserve(padded);
    dynamics.forces->scale_gravity(bodies, c.pool);
  }
  dynamics.forces_stale = false;
}

SolverParams solver_params(const StepContext& c, double dt, const StepDetail& detail) {
  SolverParams p;
  p.dt = dt;
  p.substeps = c.dynamics.substeps;
  p.gravity = c.desc.gravity;
  p.damping = c.desc.linear_damping + linear_drag(c.desc.fields);
  p.restitution_threshold = c.desc.restitution_threshold;
  p.refresh = kRefreshOfRadius * c.population.least_radius;
  const double h = dt / c.dynamics.substeps;
  p.impacts = c.neighbours.made.impact_rate * h;
  p.stiff_substep = c.dynamics.next_stiff_substep(h);
  // Loads grow with the step, but impacts do not: not many times over.
  p.warm = c.dynamics.last_substep > 0 ? static_cast<float>(lesser(h / c.dynamics.last_substep, kMostWarm)) : 1.0f;
  p.model = c.plan.model;
  p.turns = c.plan.turns;
  p.surfaces = c.plan.surfaces;
  p.most_sweeps = detail.sweeps;
  return p;
}

kernels::StreamParams stream_params(const StepContext& c, double dt) {
  const WorldDesc& desc = c.desc;
  const double damping = desc.linear_damping + linear_drag(desc.fields);
  // x(t) = x + v (1-e^-ct)/c + g (t - (1-e^-ct)/c)/c,  v(t) = v e^-ct + g (1-e^-ct)/c
  const double span = coast_time(damping, dt);
  const double fall = damping * dt > 1e-4 ? (dt - span) / damping : dt * dt / 2 * (1 - damping * dt / 3);
  kernels::StreamParams p = kick_params(desc.gravity, damping, dt);
  p.drop = static_cast<float>(fall);
  p.fall_x = kernels::snapped(desc.gravity.x * fall, kernels::kLeastOffset);
  p.fall_y = kernels::snapped(desc.gravity.y * fall, kernels::kLeastOffset);
  p.pitch_x = static_cast<float>(c.lattice.pitch_x());
  p.pitch_y = static_cast<float>(c.lattice.pitch_y());
  p.inv_pitch_x = static_cast<float>(1 / c.lattice.pitch_x());
  p.inv_pitch_y = static_cast<float>(1 / c.lattice.pitch_y());
  const double limit = speed_limit(c.lattice, dt);
  p.speed_limit2 = static_cast<float>(limit * limit);
  p.far_x = static_cast<float>(kFarSteps * c.lattice.pitch_x());
  p.far_y = static_cast<float>(kFarSteps * c.lattice.pitch_y());
  return p;
}

// Says to the ledger what the plan leaves out.
void note_skips(StepContext& c) {
  c.ledger.skip(Skip::forces, !c.dynamics.forces);
  c.ledger.skip(Skip::restitution, !c.plan.restitution);
  c.ledger.skip(Skip::masses, !c.plan.masses);
  c.ledger.skip(Skip::friction, !c.plan.friction);
  c.ledger.skip(Skip::rotation, !c.plan.rotation);
  c.ledger.skip(Skip::publish, !c.plan.publish);
  c.ledger.skip(Skip::heavy_loads, !c.contacts.loads.any());
  c.ledger.skip(Skip::events, !c.plan.events);
  c.ledger.skip(Skip::manifolds, !c.plan.manifolds);
  c.ledger.skip(Skip::joints, !c.plan.joints);
  c.ledger.skip(Skip::filters, !c.plan.filters);
  c.ledger.skip(Skip::continuous, !c.plan.continuous);
}

}  // namespace

void lay_out_manifolds(StepContext& c, double dt) {
  const double h = dt / c.dynamics.substeps;
  ManifoldParams p = c.manifold_params(dt);
  Solver::manifold_softness(h, c.dynamics.next_stiff_substep(h), p);
  const std::array<float, 4> soft{p.plain[0].soft, p.plain[0].rate, p.plain[2].soft,
                                  p.plain[2].rate};  // the others follow from these
  p.changed = soft != c.contacts.softness_laid;
  c.contacts.softness_laid = soft;
  p.asleep = !c.sleep.sleepers.empty();
  c.ledger.lanes.vector += c.contacts.manifolds.looks().used;
  c.ledger.lanes.scalar += c.contacts.manifolds.looks().alone;
  c.contacts.manifolds.lay_out(c.contacts.loads, p, c.contacts.solved.dummies());
  c.contacts.stacks.place();
}

void narrow_phase(StepContext& c, double dt) {
  if (c.plan.manifolds) lay_out_manifolds(c, dt);
  if (c.contacts.discs.pass_blocks() == 0) {
    c.ledger.skip(Skip::narrow_phase, !c.contacts.manifolds.any());
    c.contacts.solved.load();  // bodies may be linked by pairs that must not collide
    return;
  }
  c.contacts.discs.find_gaps(c.walls, kRefreshOfRadius * c.population.least_radius, dt, c.neighbours.table);
}

namespace {

// Substeps. If nobody is near anything there are none: then the closed form of integrate() is all.
void solve(StepContext& c, const ForcesOfStep& pushes, double dt, StepReport& report) {
  prepare_forces(c, report);
  if (pushes.any()) pushes.add(c.bodies);
  const StageTimer timer(report, c.tracer, Stage::solver);
  note_skips(c);
  if (c.contacts.discs.pass_blocks() == 0 && !c.sorts_out() && !c.plan.fields && c.population.kinematics.empty() &&
      c.joints.empty() && !c.plan.restraints) {
    c.ledger.skip(Skip::solver);
    c.dynamics.solver.skip();
    return;
  }
  const SolverParams p = solver_params(c, dt, report.detail);
  const double h = dt / p.substeps;
  if (c.plan.turns) {
    run_stream(c.bodies.blocks(), c.pool, [&](BlockRange r) {
      std::fill(c.bodies.arm_change.data() + std::size_t{r.begin} * 2 * kBlock,
                c.bodies.arm_change.data() + std::size_t{r.end} * 2 * kBlock, 0.0f);
      std::fill(c.bodies.angle_change.data() + std::size_t{r.begin} * kBlock,
                c.bodies.angle_change.data() + std::size_t{r.end} * kBlock, 0.0f);
    });
  }
  Contacts& contacts = c.contacts;
  if (c.plan.joints)
    c.joints.prepare(c.population.fixed, contacts.solved, h, p.substeps, coast_time(p.damping, h), c.plan.sleep,
                     c.desc.fields);
  const SolverInput input{
      contacts, c.neighbours.table, c.joints, c.dynamics.forces.get(), c.population.kinematics, c.population.restraints,
      pushes};
  const SolverReport done = c.dynamics.solver.run(input, p, c.dynamics.moving);
  c.dynamics.last_substep = h;
  c.dynamics.stiff_substep = p.stiff_substep;
  const bool per_mass = c.plan.model.model == kernels::Model::plain;  // impulses are divided by the common mass
  report.virial = done.virial * (per_mass ? double{c.population.first_properties.mass} : 1.0) + done.shapes;
  report.stage_ms[static_cast<std::size_t>(Stage::forces)] += done.forces_ms;
  report.stage_ms[static_cast<std::size_t>(Stage::solver)] -= done.forces_ms;
  const auto substeps = static_cast<std::uint64_t>(p.substeps);
  const std::uint64_t blocks = contacts.discs.pass_blocks() + contacts.manifolds.totals().blocks;
  lanes_counted(c) += (2u * substeps + 2) * kBlock * blocks + c.joints.lane_operations(p.substeps);
  if (c.kernels.width == 1) return;
  // The geometry of contacts with fixed shapes and the contacts of stacks and of squeezed bodies are done one by one.
  c.ledger.lanes.scalar += contacts.discs.fixed.count;
  c.ledger.lanes.scalar += 2u * substeps * (contacts.stacks.link_count() + contacts.squeezed.row_count());
}

ContinuousInput continuous_input(const StepContext& c, const ManifoldParams& p, double dt) {
  const Walls* const walls = c.desc.boundary == Boundary::walls ? &p.walls : nullptr;
  return {c.contacts,
          c.neighbours.table,
          c.joints,
          c.population.kinematics,
          c.population.bullets,
          c.plan.filters,
          dt,
          p.gravity,
          c.desc.restitution_threshold,
          walls,
          p.surfaces};
}

// Bodies that went far for their size do not pass what is solid.
void stop_fast_bodies(StepContext& c, double dt, StepReport& report) {
  if (!c.plan.continuous) return;
  const StageTimer timer(report, c.tracer, Stage::solver);
  Continuous& continuous = c.dynamics.continuous;
  if (c.plan.bullets || !c.population.kinematics.empty()) c.bodies.find_slots();
  const ManifoldParams p = c.manifold_params(dt);
  report.stopped = continuous.stop(continuous_input(c, p, dt));
  report.fast = continuous.fast();
}

// Free bodies take the closed form of the frame; every body's offset folds into its lattice place.
Moved integrate(StepContext& c, double dt, StepReport& report) {
  const StageTimer timer(report, c.tracer, Stage::integrate);
  const kernels::StreamParams p = stream_params(c, dt);
  BodyStore& bodies = c.bodies;
  const kernels::BodyView view = bodies.view();
  const bool bounded = c.desc.boundary != Boundary::periodic, turning = !bodies.rim_speed.empty();
  std::atomic<bool> fine{true}, inside{true};  // relaxed: read after the run
  run_stream(bodies.blocks(), c.pool, [&](BlockRange r) {
    bool sound = c.kernels.integrate(view, p, r.begin, r.end);
    const std::size_t end = std::min<std::size_t>(std::size_t{r.end} * kBlock, bodies.count);
    for (std::size_t i = std::size_t{r.begin} * kBlock; turning && i < end; ++i) {
      bodies.rim_speed[i] = kernels::snapped(bodies.rim_speed[i]);
      if (bodies.linked[i] == 0) {  // others turned with the substeps
        bodies.angle[i] += dt * (static_cast<double>(bodies.rim_speed[i]) / static_cast<double>(bodies.radius[i]));
      }
      sound = sound && std::isfinite(bodies.angle[i]) && (!c.plan.turns || std::isfinite(bodies.rim_speed[i]));
    }
    if (!sound) fine.store(false, std::memory_order_relaxed);
    if (bounded && !Quarantine::walls_hold(bodies, c.walls, c.kernels, r)) {
      inside.store(false, std::memory_order_relaxed);
    }
  });
  lanes_counted(c) += std::uint64_t{bodies.blocks()} * kBlock;
  return {fine.load(), inside.load()};
}

}  // namespace

Moved move_bodies(StepContext& c, double dt, StepReport& report) {
  if (c.plan.continuous) c.dynamics.continuous.make_room(continuous_input(c, c.manifold_params(dt), dt));
  Dynamics& dynamics = c.dynamics;
  if (c.population.traits.media) dynamics.media.find(c.desc, c.lattice, c.bodies, c.pool, dt);
  const ForcesOfStep pushes(c.population, c.lattice, dt / report.detail.frames, dt, dynamics.media, dynamics.pushes);
  solve(c, pushes, dt, report);
  c.dynamics.moving = true;
  stop_fast_bodies(c, dt, report);
  if (c.plan.restraints) c.dynamics.solver.put_back(c.bodies, c.population.restraints);
  if (!pushes.any()) return integrate(c, dt, report);
  // Free bodies turn by the mean of their rim speeds before and after.
  pushes.spin(c.bodies, dt / 2, false);
  const Moved moved = integrate(c, dt, report);
  pushes.spin(c.bodies, dt / 2, false);
  pushes.put_back(c.bodies, c.desc.gravity);
  c.population.applied.clear();
  return moved;
}

}  // namespace psim
