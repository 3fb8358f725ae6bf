#include "solver/solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>

#include "base/elementary.h"
#include "base/tasks.h"
#include "least.h"
#include "solver/solver_run.h"

namespace psim {
namespace {

constexpr float kLeastSquare = 1e-36f;  // of kLeastOffset

using kernels::ContactParams;

// Contact stiffness: frequency kStiffness / h, damping ratio kDamping. This is the highest frequency at which deep
// piles stay quiet with one solve pass a substep. The damping keeps high piles from swinging for seconds
// (docs/decisions/003-contact-scheme.md).
constexpr double kStiffness = 0.2;
constexpr double kDamping = 15;
// Contacts under heavy loads are stiffer, and a pass sweeps over them as often as they need to converge
// (HeavyLoads::kSweeps).
constexpr double kLoadedStiffness = 0.9;
constexpr double kLoadedDamping = 10;
// Light bodies between heavy ones are solved exactly, so that they may be stiff.
constexpr double kSqueezedStiffness = 4;
// Contacts of bodies that are not discs: weight goes down by half-reactions (manifold_layout.cpp), so that stiffer
// contacts stay quiet (docs/decisions/007-manifolds.md).
constexpr double kManifoldStiffness = 0.25;
constexpr double kManifoldDamping = 10;
constexpr double kLoadedManifoldStiffness = 0.9;
constexpr double kBouncingStiffness = 0.16;  // contacts with restitution have no half-reactions
// Stacks are solved exactly: their contacts are stiff, but overlaps are pushed out gently.
constexpr double kStackStiffness = 0.34, kFixedStackStiffness = 4, kStackPush = 0.1;
constexpr double kPush = 3;  // m/s: the fastest push-out
// A sweep carries a load one contact on. Where bodies were put on each other, their contacts carry nothing yet, and the
// first substep sweeps over them until they carry: an arch would slip meanwhile. Large scenes get fewer sweeps, so that a
// pass visits no more blocks than this.
constexpr std::uint32_t kColdSweeps = 128, kColdVisits = 20'000;

void set_soft(ContactParams& p, double h, double frequency, double damping) {
  const double omega = 2 * std::numbers::pi * frequency;
  const double a1 = 2 * damping + h * omega;
  const double a2 = h * omega * a1;
  const double a3 = 1 / (1 + a2);
  p.soft_rate = static_cast<float>(a2 * a3 * omega / a1);
  p.soft_mass = static_cast<float>(a2 * a3);
  p.soft_impulse = static_cast<float>(a3);
}

// The same stiffness as compliance and rate of an overlap, see ManifoldBlock.
void set_softness(double h, double frequency, Stiffness& of) {
  const double omega = 2 * std::numbers::pi * frequency;
  const double a1 = 2 * kManifoldDamping + h * omega;
  of.soft = static_cast<float>(1 / (h * omega * a1));
  of.rate = static_cast<float>(omega / a1);
}

// The virial of the last substep: of contacts of shapes with dynamic and kinematic bodies.
double virial_of(const Manifolds::StripBlocks& strip) {
  double sum = 0;
  for (const kernels::ManifoldBlock& c : strip.blocks) {
    float part[kernels::kBlock];
    for (std::uint32_t l = 0; l < kernels::kBlock; ++l) {
      part[l] = (std::max(c.point[0].impulse[l], 0.0f) + std::max(c.point[1].impulse[l], 0.0f)) * c.apart[l];
    }
    for (const float of : part) sum += double{of};
  }
  return sum;
}

}  // namespace

double coast_time(double damping, double h) { return damping > 0 ? -exponential_less_one(-damping * h) / damping : h; }

kernels::StreamParams kick_params(Vec2 gravity, double damping, double h, int again) {
  const double span = coast_time(damping, h), kept = exponential(-damping * h);
  kernels::StreamParams p;
  p.again = static_cast<float>(again);
  p.h = static_cast<float>(h);
  p.damp = kernels::snapped(kept);
  p.damp_remainder = kernels::snapped(kept - static_cast<double>(p.damp));
  p.kick_x = kernels::snapped(gravity.x * span);
  p.kick_y = kernels::snapped(gravity.y * span);
  p.coast = static_cast<float>(span);
  return p;
}

Solver::Run::Run(Solver& solver, const SolverInput& in, const SolverParams& params)
    : SolverInput(in),
      solver_(solver),
      params_(params),
      stream_(kick_params(params.gravity, params.damping, h_, params.substeps - 1)),
      loaded_sweeps_(solver.loaded_.empty() && !contacts.manifolds.totals().loaded ? 0 : HeavyLoads::kSweeps) {
  constexpr double kMostDamped = 80;  // what exp(-80) leaves of a velocity is nothing to a float
  // The drift covers coast_time() at the velocity before damping, which v0 has already lost.
  const double kept = exponential(-lesser(params.damping * h_, kMostDamped));
  drift_.h = static_cast<float>(coast_time(params.damping, h_) / kept);
  drift_.smooth_limit2 = forces != nullptr ? 0.0f : kernels::snapped(4 * gravity_ * gravity_ * h_ * h_, kLeastSquare);
  turn_.smooth_limit2 = drift_.smooth_limit2;
  constexpr double kTrembles = 1e-3;  // rad in a step
  turn_.least_spin2 = static_cast<float>(kTrembles * kTrembles / (params.dt * params.dt));
  set_contacts();
  contacts.squeezed.find(s_.bodies, table, squeezed_);
  set_sweeps();
  if (forces != nullptr) {
    fields_.params = forces->params(h_);
    fields_.varying = forces->varying();
    const bool drag = fields_.params.quadratic != 0;
    fields_.accelerate = s_.kernels.accelerate[drag];
    if (fields_.varying && forces->method()) {
      const bool damped = drag || fields_.params.linear != 0;
      fields_.advance = s_.kernels.advance[static_cast<std::size_t>(*forces->method())][damped];
      drift_.h = stream_.h;  // damping is part of the change of velocity then
    }
  }
  if (!kinematics.empty() || !restraints.empty()) s_.bodies.find_slots();
  if (!restraints.empty()) find_restrained();
  if (contacts.manifolds.cold() && params.most_sweeps == 0) {
    const std::uint32_t fitting = kColdVisits / std::max(contacts.manifolds.totals().blocks, 1u);
    sweeps_of_shapes_ = static_cast<int>(std::clamp(fitting, 1u, kColdSweeps));
  }
  solver.kinematic_at_.resize(std::max(solver.kinematic_at_.size(), kinematics.size()));
}

// Sets stiffness and limits of the contacts of discs.
void Solver::Run::set_contacts() {
  ContactParams p;
  p.h = stream_.h;
  p.inv_h = static_cast<float>(1 / h_);
  p.pitch_x = static_cast<float>(s_.lattice.pitch_x());
  p.pitch_y = static_cast<float>(s_.lattice.pitch_y());
  p.push = static_cast<float>(kPush);
  p.refresh = params_.refresh;
  p.warm = params_.warm;
  p.gravity_x = kernels::snapped(params_.gravity.x);
  p.gravity_y = kernels::snapped(params_.gravity.y);
  const auto soft = [&](double stiffness, double damping) {
    OfDiscs of{p, p};
    set_soft(of.pair, h_, stiffness / params_.stiff_substep, damping);
    set_soft(of.fixed, h_, kFixedStiffness * (stiffness / params_.stiff_substep), damping);
    return of;
  };
  discs_ = soft(kStiffness, kDamping);
  loaded_ = soft(kLoadedStiffness, kLoadedDamping);
  squeezed_ = soft(kSqueezedStiffness, kLoadedDamping).pair;
}

void Solver::Run::substep(bool first_of_step) {
  const bool first = first_of_step || fields_.varying;
  Stacks& stacks = contacts.stacks;
  if (fields_.varying && (fields_.advance == nullptr || bounce_ != 0)) {
    force(fields_.accelerate);
    if (pushes.any()) pushes.add(s_.bodies);
  }
  if (bounce_ && first_of_step) set_floors();
  if (bounce_) impacts();
  if (contacts.manifolds.any()) meet_shapes();
  if (fields_.advance) {
    force(fields_.advance);
    if (pushes.any()) push_advanced();
  }
  kick(first);
  if (pushes.any()) spin(first);
  if (!restraints.empty()) restrain(first);
  if (!kinematics.empty()) hold();
  if (joined_) joints.press(view_);
  if (first) warm(first_of_step);
  contacts.discs.follow_edges(view_, h_);
  if (contacts.manifolds.any()) contacts.manifolds.follow_turning(view_, h_ / 2);
  solve();
  if (stacks.any()) stacks.solve(view_, discs_.pair, gravity_, true);
  if (contacts.squeezed.any()) contacts.squeezed.solve(view_, squeezed_, true);
  if (joined_) joints.hold(view_, drift_);
  if (!restraints.empty()) hold_locked();
  drift();
  if (!kinematics.empty()) carry_kinematics();
  if (joined_) joints.let_go(view_);
  if (joined_) joints.press(view_);
  if (stacks.any()) stacks.solve(view_, discs_.pair, gravity_, false);
  if (contacts.squeezed.any()) contacts.squeezed.solve(view_, squeezed_, false);
  if (contacts.manifolds.any()) contacts.manifolds.follow_turning(view_, 0);
  relax();
  if (!restraints.empty()) let_run_on();
  if (bounce_) spend();
  sweeps_of_shapes_ = 1;
}

void Solver::Run::force(FieldPass kernel) {
  const Clock::time_point start = Clock::now();
  for_bodies([&](BlockRange r) { kernel(view_, fields_.params, r.begin, r.end); });
  fields_.time += Clock::now() - start;
}

// Applies gravity and, in the later substeps of a frame, the impulses of contacts in the substep before.
void Solver::Run::kick(bool first) {
  const auto kernel = first ? s_.kernels.kick_first : s_.kernels.kick_again;
  for_bodies([&](BlockRange r) {
    if (!fields_.advance) kernel(view_, stream_, r.begin, r.end);
    if (!params_.model.rough() && !params_.turns) return;
    for (std::size_t i = std::size_t{r.begin} * 8; i < std::size_t{r.end} * 8; ++i) {
      const float u = kernels::snapped(view_.rim_speed[i]);
      view_.rim_speed[i] = first ? u : u + (u - view_.rim_speed0[i]);
      view_.rim_speed0[i] = u;
    }
  });
}

// Applied forces where an integrator moves bodies on: the drift takes the mean of the speeds before and after.
void Solver::Run::push_advanced() {
  pushes.add(s_.bodies);
  pushes.kick(s_.bodies, h_);
}

// Applied torques. Later kicks repeat the change of the first one, where they keep the rim speeds of before.
void Solver::Run::spin(bool first) {
  if (first || !(params_.model.rough() || params_.turns)) pushes.spin(s_.bodies, h_, true);
}

// Kinematic bodies keep their velocities; the centre of one that turns about another point goes round.
void Solver::Run::hold() {
  BodyStore& b = s_.bodies;
  for (std::size_t n = 0; n < kinematics.size(); ++n) {
    auto [id, v] = kinematics[n];
    const std::size_t i = b.info[id].slot;
    if (!b.rim_speed.empty()) {
      const double omega = b.omega_of(i);
      const Vec2 arm = arm_of(b.kind(id), b.angle[i] + omega * h_ / 2);
      v = {v.x - omega * arm.y, v.y + omega * arm.x};
    }
    b.vel[2 * i] = b.vel0[2 * i] = static_cast<float>(v.x);
    b.vel[2 * i + 1] = b.vel0[2 * i + 1] = static_cast<float>(v.y);
    solver_.kinematic_at_[n] = {b.disp[2 * i], b.disp[2 * i + 1]};
  }
}

void Solver::Run::warm(bool first_of_step) {
  ContactParams p = discs_.pair;
  if (!first_of_step) p.warm = 1;
  const auto warm_blocks = [&](bool fixed, ManifoldBlock* blocks, SurfaceBlock* surfaces, std::uint32_t begin,
                               std::uint32_t end) {
    s_.kernels.warm_manifolds[fixed](view_, blocks, surfaces, p.warm, begin, end);
  };
  once(p, s_.kernels.warm, s_.kernels.warm_static, warm_blocks);
  if (joined_) joints.warm(view_, p.warm);
}

// One pass over all contacts: those of discs, then of shapes; sweeps over those under heavy loads; then those with
// fixed shapes. The tables are of kernels, and pass_blocks runs those of shapes. All sweeps over contacts under heavy
// loads but the `outer`-th one are inner ones, as are all others but the first one (`outer` is 0) or the last one.
template <class Pairs, class Statics, class Blocks>
void Solver::Run::pass(const Pairs& pass_pairs, const Statics& pass_statics, const Blocks& pass_blocks, int outer) {
  const auto pass_manifolds = [&](bool fixed, bool loaded, bool inner) {
    for_manifolds(fixed, loaded,
                  [&](ManifoldBlock* blocks, SurfaceBlock* surfaces, std::uint32_t begin, std::uint32_t end) {
                    pass_blocks(fixed, inner, blocks, surfaces, loaded ? loaded_.pair : discs_.pair, begin, end);
                  });
  };
  for_pairs([&](const ContactBlocks& b, std::size_t) {
    pass_pairs[model_][bounce_](view_, pairs_, discs_.pair, b.begin, b.loaded);
  });
  const int last = sweeps_of_shapes_ - 1;
  for (int sweep = 0; sweep <= last; ++sweep) {
    const bool inner = sweep != (outer == 0 ? 0 : last);
    pass_manifolds(false, false, inner);
    if (sweep != last) pass_manifolds(true, false, inner);
  }
  const auto for_loaded = [&](std::size_t begin, std::size_t end, const auto& each) {
    s_.pool.run(end - begin, [&](std::size_t k) { each(table.strips[solver_.loaded_[begin + k]]); });
  };
  for (int sweep = 0; sweep < loaded_sweeps_; ++sweep) {
    const bool inner = sweep != outer;
    const auto pass_loaded = pass_pairs[model_][bounce_ << inner];
    const auto pass_loaded_statics = pass_statics[model_][bounce_ << inner];
    std::size_t begin = 0;
    for (const std::size_t end : solver_.loaded_end_) {
      for_loaded(begin, end,
                 [&](const Strip& s) { pass_loaded(view_, pairs_, loaded_.pair, s.blocks.loaded, s.blocks.end); });
      begin = end;
    }
    for_loaded(0, begin, [&](const Strip& s) {
      pass_loaded_statics(view_, statics_, loaded_.fixed, s.static_blocks.loaded, s.static_blocks.end);
    });
    pass_manifolds(false, true, inner);
    pass_manifolds(true, true, inner);
  }
  pass_manifolds(true, false, outer == 0 && last != 0);
  for_statics([&](const ContactBlocks& b, std::size_t) {
    pass_statics[model_][bounce_](view_, statics_, discs_.fixed, b.begin, b.loaded);
  });
}

void Solver::Run::solve() {
  if (joined_) joints.solve(view_, drift_.h, drift_.smooth_limit2);
  const auto blocks = [&](bool fixed, bool inner, ManifoldBlock* of, SurfaceBlock*, const ContactParams& p,
                          std::uint32_t begin, std::uint32_t end) {
    s_.kernels.solve_manifolds[fixed][bounce_][inner](view_, of, p, begin, end);
  };
  pass(s_.kernels.solve, s_.kernels.solve_static, blocks, 0);
}

void Solver::Run::relax() {
  if (joined_) joints.relax(view_);
  const auto blocks = [&](bool fixed, bool inner, ManifoldBlock* of, SurfaceBlock* surfaces, const ContactParams& p,
                          std::uint32_t begin, std::uint32_t end) {
    s_.kernels.relax_manifolds[fixed][bounce_][inner](view_, of, surfaces, p, begin, end);
  };
  pass(s_.kernels.relax, s_.kernels.relax_static, blocks, loaded_sweeps_ - 1);
}

void Solver::Run::drift() {
  BodyStore& b = s_.bodies;
  for_bodies([&](BlockRange r) {
    if (fields_.advance) {
      s_.kernels.drift_corrected(view_, fields_.params, r.begin, r.end);
    } else {
      s_.kernels.drift(view_, drift_, r.begin, r.end);
    }
    if (bounce_ != 0 && view_.rim_way != nullptr) turn_by_impacts(r);
    if (params_.turns) s_.kernels.turn_bodies(view_, b.radius.data(), turn_, r.begin, r.end);
    if (!b.rim_speed.empty()) turn_angles(r);
  });
}

// The places of kinematic bodies go straight on, since nothing damps them.
void Solver::Run::carry_kinematics() {
  BodyStore& b = s_.bodies;
  for (std::size_t n = 0; n < kinematics.size(); ++n) {
    const auto& [id, velocity] = kinematics[n];
    const std::size_t i = b.info[id].slot;
    b.clear_remainders(i);
    float way_x = stream_.h * b.vel[2 * i], way_y = stream_.h * b.vel[2 * i + 1];
    if (!b.rim_speed.empty()) {
      const Vec2 arm = arm_of(b.kind(id), b.angle[i]) - arm_of(b.kind(id), b.angle[i] - b.omega_of(i) * h_);
      if (arm.x != 0 || arm.y != 0) {
        way_x = static_cast<float>(h_ * velocity.x + arm.x);
        way_y = static_cast<float>(h_ * velocity.y + arm.y);
      }
    }
    b.disp[2 * i] = solver_.kinematic_at_[n][0] + way_x;
    b.disp[2 * i + 1] = solver_.kinematic_at_[n][1] + way_y;
  }
}

// Lists the strips with contacts under heavy loads, phase by phase as run_phases goes over them.
void Solver::find_loaded(const PairTable& table) {
  loaded_.clear();
  const std::size_t large = table.strips.size() - 1;
  for (std::size_t phase = 0; phase < loaded_end_.size(); ++phase) {
    for (std::size_t k = 0; k <= large; ++k) {
      if (table.strips[k].loaded && phase == (k == large ? 2 : k % 2)) loaded_.push_back(static_cast<std::uint32_t>(k));
    }
    loaded_end_[phase] = loaded_.size();
  }
}

// Counts closed contacts and sums impulse times distance. The impulses are those of the last substep; the sum over a
// step counts them once for each substep.
void Solver::sum_up(const SolverInput& in, int substeps) {
  const StaticLanes& fixed = in.contacts.discs.fixed;
  in.contacts.surroundings.pool.run(in.table.strips.size(), [&](std::size_t index) {
    double sum = 0;
    std::uint64_t closed = 0;
    const auto add = [&](const ContactLanes& c, const ContactBlocks& blocks, const auto& mask) {
      for (std::size_t l = std::size_t{blocks.begin} * 8; l < std::size_t{blocks.end} * 8; ++l) {
        closed += std::signbit(c.impulse[l]) ? 0 : 1;  // an impulse of -0 marks an open contact
        const std::uint32_t presses = mask_from(c.impulse[l], kTiniest) & mask(l);
        const auto pressing = std::bit_cast<float>(std::bit_cast<std::uint32_t>(c.impulse[l]) & presses);
        sum += double{pressing} * double{c.rsum[l]};
      }
    };
    const Strip& s = in.table.strips[index];
    add(in.contacts.discs.pairs, s.blocks, [](std::size_t) { return ~0u; });
    add(fixed, s.static_blocks, [&](std::size_t l) { return fixed.refresh[l] < 1e30f ? ~0u : 0u; });  // round shapes
    sums_[index].virial += sum * substeps;
    sums_[index].closed = sums_[index].touching = closed;
    Manifolds& manifolds = in.contacts.manifolds;
    if (!manifolds.any() || index >= manifolds.strip_count()) return;
    const Manifolds::Closed of_shapes = manifolds.closed(index);
    sums_[index].closed += of_shapes.points;
    sums_[index].touching += of_shapes.pairs;
    sums_[index].shapes += substeps * virial_of(manifolds.strip(index));
  });
}

void Solver::manifold_softness(double h, double stiff_substep, ManifoldParams& p) {
  for (std::size_t fixed = 0; fixed < 2; ++fixed) {
    const double times = fixed != 0 ? kFixedStiffness : 1;
    const auto set = [&](double stiffness, Stiffness& of) { set_softness(h, stiffness / stiff_substep, of); };
    set(times * kManifoldStiffness, p.plain[fixed]);
    set(times * kLoadedManifoldStiffness, p.plain[2 + fixed]);
    set(times * kBouncingStiffness, p.bouncing[fixed]);
    set(fixed != 0 ? kFixedStackStiffness : kStackStiffness, p.in_stacks[fixed]);
    p.in_stacks[fixed].rate = std::min(p.in_stacks[fixed].rate, static_cast<float>(kStackPush / h));
  }
}

SolverReport Solver::run(const SolverInput& in, const SolverParams& params, bool& moving) {
  sums_.assign(in.table.strips.size(), {});
  find_loaded(in.table);
  if (params.model.bounce) mark_impacts(in);
  if (in.contacts.manifolds.any()) list_rocking(in, params.dt, length_of(params.gravity) * params.dt / params.substeps);
  if (params.model.bounce) last_sweep_.reserve(in.table.strips.size());
  Run run(*this, in, params);
  moving = true;
  for (int substep = 0; substep < params.substeps; ++substep) run.substep(substep == 0);
  in.contacts.squeezed.finish();
  if (params.model.bounce) sweeps_ = run.swept() / params.substeps;
  in.contacts.solved.store();
  sum_up(in, params.substeps);
  SolverReport report;
  report.forces_ms = run.forces_ms();
  closed_ = touching_ = 0;
  for (const StripSum& strip : sums_) {
    report.virial += strip.virial;
    report.shapes += strip.shapes;
    closed_ += strip.closed;
    touching_ += strip.touching;
  }
  return report;
}

}  // namespace psim
