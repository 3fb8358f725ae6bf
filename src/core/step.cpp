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

double ms_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// Margin around bodies in the lists: a tenth of the radius suits piles (docs/performance.md).
constexpr double kSkinOfRadius = 0.1;
// Sideways motion within a step after which a contact's normal is computed anew, of the radius.
constexpr float kRefreshOfRadius = 0.02f;
constexpr double kMarginFrames = 1.25;  // frames of motion that the margin adds
constexpr double kStiffening = 0.98;    // a step, of the substep that contact stiffness is for
constexpr double kSoftening = 1.1;
constexpr double kMostWarm = 4;  // on stored impulses where a step is longer than the last

}  // namespace

StepReport World::Impl::step(double dt) { return step(dt, {}, true); }

// With the detail given, or one that the governor chooses.
StepReport World::Impl::step(double dt, const StepDetail& given, bool choose) {
  const FloatSettings settings;
  const Clock::time_point begin = Clock::now();
  StepReport report;
  if (!(dt > 0 && dt <= 10)) return report;  // as World::create has it
  const std::uint64_t growths = memory.growths;
  const WorkerPool::Awake awake(pool);
  settle_lists();
  freeze_doubtful(report);
  replan();
  report.detail = choose ? choose_detail(dt) : given;
  dt *= report.detail.frames;
  if (plan.publish && placed) publisher.look(bodies, fixed, frozen, sleepers.list, lattice);
  placed = false;
  if (report.detail.waits()) {
    make_ahead(dt, report);
  } else {
    advance(dt, report, choose && governor.on());
  }
  ++frame;
  if (plan.publish) {
    const StageTimer timer(report, tracer, Stage::publish);
    publisher.publish(bodies, fixed, frozen, sleepers.list, lattice, frame, pool);
  }
  if (!report.detail.waits()) rest(dt, report);
  report.arena_growths = memory.growths - growths;
  report.asleep = bodies.asleep;
  report.total_ms = ms_since(begin);
  return report;
}

// Everything moves on by dt seconds.
void World::Impl::advance(double dt, StepReport& report, bool choose) {
  substeps = report.detail.substeps != 0 ? report.detail.substeps : desc.substeps;
  choosing = choose;
  ++steps;
  if (bodies.count != bodies.dead) {
    refresh_lists(dt, report);
    report.detail.substeps = static_cast<std::uint8_t>(substeps);
    // The lists name who may be met in this step, those of the last one did not.
    if (!sleepers.empty() && wake_reached(dt)) refresh_lists(dt, report);
    solve(dt, report);
    if (plan.continuous) {
      const StageTimer timer(report, tracer, Stage::solver);
      bodies.find_slots();
      report.stopped = continuous.stop(bodies, manifolds, table, shapes, lattice, bullets,
                                       plan.filters, pool);
    }
    integrate(dt, report);
    report.awake = bodies.count - bodies.dead;
  }
  queries.forget_moving();
  if (plan.events) {
    const StageTimer timer(report, tracer, Stage::publish);
    events.collect(event_source(), queries, query_source());
    sleepers.changed = false;
  }
  if (report.awake != 0) count_contacts(report);
}

// Parts of a step of dt seconds that ends in a later frame; time stands still.
void World::Impl::make_ahead(double dt, StepReport& report) {
  events.clear();
  if (bodies.count == bodies.dead) return;
  prepare_lists(dt, report);
  if ((report.detail.parts & StepDetail::kContacts) != 0) make_contacts(dt, report);
  report.awake = bodies.count - bodies.dead;
}

// How the next step is spread over frames, from the counts of the last one; how many substeps there are is
// known only once the contacts are (refresh_lists).
StepDetail World::Impl::choose_detail(double dt) {
  if (spread_at < spread.frames) return {0, spread.parts[spread_at++], spread.frames};
  if (!governor.on() || bodies.count == bodies.dead) return {};
  WorkCounts work = count_work();
  work.builds = work.lays_out = true;
  if (governor.spread(work).frames == 1) return {};
  work.builds = lists_stale || once || !broad.lists_serve(bodies, reach_time(dt), kernels, pool);
  work.lays_out = work.builds || loose;
  spread = governor.spread(work);
  spread_at = 1;
  return {0, spread.parts[0], spread.frames};
}

WorkCounts World::Impl::count_work() const {
  WorkCounts work;
  work.bodies = bodies.count - bodies.dead;
  work.solved = solved.count();
  if (loose) {
    for (const Strip& s : candidates.strips) work.candidates += s.pair_end - s.pair_begin;
  }
  work.contacts = contacts.pair_count() + contacts.single_count();
  work.manifolds = manifolds.pair_count();
  work.joints = joints.count();
  work.bounces = plan.restitution;
  return work;
}

float World::Impl::reach_time(double dt) const {
  return static_cast<float>((loose ? 1.0 : kMarginFrames) * dt);
}

void World::Impl::prepare() {
  if (bodies.count == bodies.dead || !doubtful.empty()) return;
  const FloatSettings settings;
  const auto counted = skipped_frames;
  StepReport ignored;
  const WorkerPool::Awake awake(pool);
  settle_lists();
  replan();
  refresh_lists(desc.dt, ignored);
  skipped_frames = counted;
}

// The plan follows the traits; arrays of what left the plan are given back.
void World::Impl::replan() {
  if (!plan_stale) return;
  plan_stale = false;
  traits.mass_ratio = traits.same_mass == traits.moving ? 1 : bodies.surfaces.mass_ratio();
  const Plan next = make_plan(traits);
  if (next.model != plan.model) impulses_valid = false;
  Plan same = next;
  same.events = plan.events;  // who listens or looks changes no result
  same.publish = plan.publish;
  if (same != plan) spoil_lists();
  // While all radii are alike the column stays as it is when bodies move to other slots, those of bodies that are
  // gone, too.
  if (!next.radii) std::fill_n(bodies.radius.data(), bodies.count, first_radius);
  if (plan.shapes && !next.shapes) manifolds.clear();  // pairs may be sorted out on, without contacts of shapes
  plan = next;
  apply_plan();
}

void World::Impl::apply_plan() {
  if (plan.rotation && bodies.spin.empty()) bodies.add_rotation();
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
  if (!sorts_out()) manifolds.clear();
  if (!plan.shapes) columns.forget();
  if (!plan.scales) bodies.pull.release();
  if (!plan.restitution) bodies.event_time.release();
  forces_stale = true;
}

// How the lists of a build should be made.
struct World::Impl::ListPlan {
  double outer = 0;    ///< m: a typical distance up to which two bodies are candidates
  bool loose = false;  ///< bodies fly: select from the candidates every step
  kernels::ReachParams margin;
  double frames = 0;      ///< that loose lists are made for; 0: one, looking ahead
  float ahead = 0;        ///< s: not 0 for lists of one step, see BroadPhaseParams
  double speed = 0;       ///< m/s, root mean square of the sample about its mean
  double impacts = 0;     ///< 1/s: of a body, if all were in flight
  double crowding = 0.1;  ///< 0.1 to 1: how likely one impact leads to another within a step
};

namespace {

// Radii and velocities of some bodies, by slot; of those that are gone nothing counts, nor is it saved.
struct Sample {
  double radius = 0;                    // mean, m
  double mean_x = 0, mean_y = 0;        // m/s
  double square = 0;                    // mean |v|^2
  double fastest = 0, fastest_off = 0;  // largest |v| and |v - mean|, m/s
  double off() const { return std::sqrt(std::fmax(square - mean_x * mean_x - mean_y * mean_y, 0)); }
};

Sample sample_bodies(const BodyStore& b, double least_radius) {
  const std::uint32_t stride = std::max(1u, b.count / 2048);
  Sample s;
  double n = 0;
  const auto velocity = [&](std::uint32_t i) {
    return Vec2{static_cast<double>(b.vel[2 * std::size_t{i}]),
                static_cast<double>(b.vel[2 * std::size_t{i} + 1])};
  };
  for (std::uint32_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    n += 1;
    const Vec2 v = velocity(i);
    s.square += v.x * v.x + v.y * v.y;
    s.mean_x += v.x;
    s.mean_y += v.y;
    s.radius += static_cast<double>(b.radius[i]);
    s.fastest = std::fmax(s.fastest, std::sqrt(v.x * v.x + v.y * v.y));
  }
  if (n == 0) {  // all that were looked at: as if at rest
    s.radius = least_radius;
    return s;
  }
  s.square /= n;
  s.mean_x /= n;
  s.mean_y /= n;
  s.radius /= n;
  for (std::uint32_t i = 0; i < b.count; i += stride) {
    if (b.id[i] == kNoSlot) continue;
    const Vec2 v = velocity(i);
    const double x = v.x - s.mean_x, y = v.y - s.mean_y;
    s.fastest_off = std::fmax(s.fastest_off, std::sqrt(x * x + y * y));
  }
  return s;
}

}  // namespace

// What impacts within a step do to velocities moves bodies by this much, m: little in a thin gas of
// equals, more where discs are close, much where a heavy body meets a light one.
double World::Impl::impact_slack(double speed, double close, double dt) const {
  const double g = std::sqrt(desc.gravity.x * desc.gravity.x + desc.gravity.y * desc.gravity.y);
  return 0.02 * static_cast<double>(least_radius) + g * dt * dt +
         (plan.uneven ? 1.0 : close) * speed * dt;
}

// Bodies at rest or creeping: a thin skin, and the candidates are the contacts while it lasts.
// Bodies in flight: margins for several frames, of which each step selects the pairs that can meet;
// or, where they would soon be used up, lists for this step alone. The choice is by cost: building
// takes kBuild a body and kTest a body looked at, selecting kSelect a candidate, and both counts
// follow from the number density.
World::Impl::ListPlan World::Impl::plan_lists(double dt) const {
  constexpr double kBuild = 25, kTest = 0.25, kSelect = 5;  // ns, measured (docs/performance.md)
  const Sample s = sample_bodies(bodies, static_cast<double>(least_radius));
  const double r = s.radius;
  ListPlan out;
  out.margin.skin = static_cast<float>(kSkinOfRadius * r);
  out.margin.time = static_cast<float>(kMarginFrames * dt);
  out.outer = 2 * (1 + kSkinOfRadius) * r;
  out.speed = s.off();
  // Of a gas in two dimensions, 2 D n v g(c) sqrt(pi), with c the share of the area that is covered.
  const double covered = std::fmin(broad.density() * 3.14159 * r * r, 0.8);
  out.impacts =
      7 * r * broad.density() * out.speed * (1 - 0.44 * covered) / ((1 - covered) * (1 - covered));
  const double speed = std::sqrt(s.square);
  const double frame = kMarginFrames * dt * speed;  // m a frame, with reserve
  if (!(frame > kSkinOfRadius * r) || !std::isfinite(speed)) return out;
  const double area =
      broad.area_about(bodies, r, (desc.bounds.xmax - desc.bounds.xmin) *
                                      (desc.bounds.ymax - desc.bounds.ymin));
  // Where bodies lie in heaps their number a box says little: the last grid says more.
  const double density = std::fmax(bodies.count / area, broad.density());
  // Without restitution impacts only slow bodies down.
  if (plan.restitution) {
    out.crowding = std::clamp(3 * bodies.count / area * 3.14159 * r * r, 0.1, 1.0);
  }
  out.loose = true;
  // Candidates of a body up to `outer` away: hard discs leave 2 r around it empty, but where they
  // are packed all but itself is there.
  const auto pairs = [&](double outer) {
    return std::fmax(1.5708 * density * (outer * outer - 4 * r * r),
                     1.5708 * density * outer * outer - 0.5);
  };
  const auto build = [&](double reach) {
    const double edge = std::fmax(2 * reach, std::sqrt(0.7 * area / bodies.count));
    return kBuild + kTest * 4.5 * density * edge * edge;
  };
  const double half = kMarginFrames * dt / 2;
  const double skin = 0.505 * impact_slack(out.speed, out.crowding, dt);
  // The last choice is kept if it is nearly as good: every change of mind needs room of its own.
  const auto favour = [&](double frames) { return loose && frames == list_frames ? 0.97 : 1.0; };
  out.outer = 2 * (r + skin + 1.2 * half * out.speed);
  double best = favour(0) * (build(r + skin + half * s.fastest_off) + kSelect * pairs(out.outer));
  out.margin = {static_cast<float>(skin), static_cast<float>(half), static_cast<float>(s.mean_x),
                static_cast<float>(s.mean_y)};
  out.ahead = static_cast<float>(half);
  for (const double k : {1.0, 2.0, 3.0, 4.0, 6.0, 8.0}) {
    const double reach = r + k * (1.2 * frame + 0.3 * kMarginFrames * dt * s.fastest);
    const double outer = 2 * r + 3 * k * frame;
    const double cost = favour(k) * (build(reach) / k + kSelect * pairs(outer));
    if (!(cost < best)) continue;
    best = cost;
    out.outer = outer;
    out.margin = {static_cast<float>(0.02 * r + k * 1.2 * frame),
                  static_cast<float>(k * kMarginFrames * dt * 0.3), 0, 0};
    out.ahead = 0;
    out.frames = k;
  }
  return out;
}

// Broad phase: bodies in cell order and candidates, made anew if the old ones no longer serve.
void World::Impl::make_candidates(double dt, StepReport& report) {
  const StageTimer timer(report, tracer, Stage::broad_phase);
  if (!lists_stale) lists_stale = once || !broad.lists_serve(bodies, reach_time(dt), kernels, pool);
  if (!lists_stale) {
    ++skipped_frames[1];
    return;
  }
  // Lists that no step took, and that a change of the world spoiled: where the impulses' bodies lie now is lost.
  if (unused_lists) impulses_valid = false;
  unused_lists = true;
  if (!bodies.spin.empty()) bodies.add_rotation();
  const ListPlan lists = plan_lists(dt);
  const bool changed = broad.density() == 0 || lists.loose != loose || lists.frames != list_frames;
  loose = lists.loose;
  once = lists.ahead != 0;
  list_frames = lists.frames;
  sampled_speed = lists.speed;
  crowding = lists.crowding;
  impact_rate = lists.impacts;
  BroadPhaseParams p;
  p.margin = lists.margin;
  p.ahead = lists.ahead;
  p.outer = changed ? lists.outer : 0;
  p.walls = desc.boundary == Boundary::walls;
  p.periodic = desc.boundary == Boundary::periodic;
  p.mixed_radii = plan.radii;
  p.link_all = plan.fields;
  const Vec2 c = lattice.centre();
  p.bounds = {desc.bounds.xmin - c.x, desc.bounds.ymin - c.y, desc.bounds.xmax - c.x,
              desc.bounds.ymax - c.y};
  if (!loose) table.swap(old_table);
  broad.build(bodies, shapes, p, kernels, pool, loose ? candidates : table);
  if (plan.fields) move_rests(bodies, broad.from(), pool);
  report.rebuilt = true;
}

// Broad phase: who may meet. Sets lists_stale to whether there are new lists.
void World::Impl::prepare_lists(double dt, StepReport& report) {
  if (laid_ahead || lists_ahead) return;
  carry_woken();
  bodies.pad_tail();
  make_candidates(dt, report);
  lists_ahead = true;
}

// Colouring: which contacts there are, in blocks.
void World::Impl::make_contacts(double dt, StepReport& report) {
  if (laid_ahead) return;
  laid_ahead = true;
  lists_ahead = false;
  saved.bare = false;
  if (loose) {
    const StageTimer timer(report, tracer, Stage::narrow_phase);
    table.swap(old_table);
    const auto slack = static_cast<float>(impact_slack(sampled_speed, crowding, dt));
    broad.select(bodies, static_cast<float>(kMarginFrames * dt), slack, plan.fields, candidates,
                 table, kernels, pool);
  }
  if (!lists_stale && !loose) {
    ++skipped_frames[3];
    return;
  }
  if (!held.empty()) {  // kinematic bodies are the solver's
    bodies.find_slots();
    for (const auto& [id, velocity] : held) bodies.linked[bodies.info[id].slot] = 0xFF;
  }
  if (!joints.empty()) {  // so are joined ones
    bodies.find_slots();
    for (const std::uint32_t id : joints.bodies()) {
      if (bodies.info[id].place == Place::moving) bodies.linked[bodies.info[id].slot] = 0xFF;
    }
  }
  const StageTimer timer(report, tracer, Stage::colouring);
  if (!impulses_valid) {
    old_table.body_count = 0;
    manifolds.forget();
  }
  if (plan.turns) bodies.keep_turns(true);
  solved.choose(bodies, table, loose && !plan.forces && !plan.turns, plan.restitution, pool);
  if (plan.loads) {
    loads.find(bodies, table, pool);
  } else {
    loads.forget();
  }
  if (sorts_out()) sort_out_pairs();
  contacts.build(bodies, solved, shapes, desc.wall, plan.model,
                 plan.surfaces ? nullptr : &first_surface, loads, table, old_table,
                 lists_stale ? broad.from() : nullptr, sleepers.recent, pool);
  sleepers.recent.clear();
  impulses_valid = true;
  if (lists_stale) forces_stale = true;
  lists_stale = false;
}

// Broad phase, narrow phase and colouring, as far as they were not done ahead: contacts with normals and
// gaps for this step.
void World::Impl::refresh_lists(double dt, StepReport& report) {
  WorkCounts work;
  work.lays_out = !laid_ahead;
  prepare_lists(dt, report);
  work.lays_out = work.lays_out && (lists_stale || loose);
  make_contacts(dt, report);
  laid_ahead = unused_lists = false;
  kept_contacts = !work.lays_out && !report.detail.waits() && report.detail.frames == 1;
  if (choosing) {
    choosing = false;
    const WorkCounts counts = count_work();
    const bool builds = report.rebuilt, lays_out = work.lays_out;
    work = counts;
    work.builds = builds;
    work.lays_out = lays_out;
    // No substep is longer than a frame: contacts would come too late.
    substeps = governor.substeps(work, std::min<int>(report.detail.frames, desc.substeps), desc.substeps);
    report.predicted_ms = (governor.fixed_ns(work) + substeps * governor.substep_ns(work)) * 1e-6;
  }
  const StageTimer timer(report, tracer, Stage::narrow_phase);
  if (plan.shapes) refresh_manifolds(dt);
  if (contacts.pair_blocks() + contacts.single_blocks() == 0) {
    if (!manifolds.any()) ++skipped_frames[2];
    return;
  }
  narrow_phase(bodies, solved, shapes, walls, lattice, kRefreshOfRadius * least_radius, table,
               contacts, kernels, pool);
}

bool World::Impl::sorts_out() const {
  return plan.shapes || plan.filters || joints.any_exclusions();
}

// Takes manifolds, and pairs that must not collide, out of the lists for discs.
void World::Impl::sort_out_pairs() {
  const Joined joined = [this](std::uint32_t a, std::uint32_t b) { return joints.joined(a, b); };
  manifolds.collect(bodies, shapes, joints.any_exclusions() ? &joined : nullptr, plan.filters, table,
                    lists_stale, sleepers.recent, pool);
}

// Hulls against hulls, at the frame's start.
void World::Impl::refresh_manifolds(double dt) {
  const double h = dt / substeps;
  ManifoldParams p;
  p.dt = dt;
  p.gravity = desc.gravity;
  p.lattice = &lattice;
  p.shapes = &shapes;
  p.kernels = &kernels;
  p.walls = walls;
  p.wall = desc.wall;
  Solver::manifold_softness(h, next_stiff_substep(h), p);
  p.changed = !std::equal(p.soft, p.soft + 4, manifold_soft.begin());
  std::copy(p.soft, p.soft + 4, manifold_soft.begin());
  manifolds.refresh(bodies, p, table, pool);
  lanes.scalar += manifolds.pair_count();  // hulls are looked at one pair at a time
  columns.find(bodies, manifolds, p, table, pool);
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
  if (plan.turns) {
    pool.run(stream_tasks(bodies.blocks()), [&](std::size_t t) {
      const BlockRange r = stream_range(t, bodies.blocks());
      std::fill(bodies.turn.data() + std::size_t{r.begin} * 2 * kBlock,
                bodies.turn.data() + std::size_t{r.end} * 2 * kBlock, 0.0f);
      std::fill(bodies.swing.data() + std::size_t{r.begin} * kBlock,
                bodies.swing.data() + std::size_t{r.end} * kBlock, 0.0f);
    });
  }
  joints.prepare(bodies, fixed, solved, lattice, h, pool);
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
      (std::uint64_t{contacts.pair_blocks()} + contacts.single_blocks() + manifolds.blocks());
  if (options.isa == Isa::scalar) {
    lanes.scalar += work;
  } else {
    lanes.vector += work;
    lanes.scalar += contacts.single_count();  // their geometry is found one by one
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
