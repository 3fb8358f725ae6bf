#include "solver/solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/tasks.h"
#include "solver/solver_run.h"

namespace psim {
namespace {

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
// Contacts of bodies that are not discs: weight goes down by half-reactions (manifold_layout.cpp), so that stiffer
// contacts stay quiet (docs/decisions/007-manifolds.md).
constexpr double kManifoldStiffness = 0.25;
constexpr double kManifoldDamping = 10;
constexpr double kLoadedManifoldStiffness = 0.9;
constexpr double kBouncingStiffness = 0.16;  // contacts with restitution have no half-reactions
// Stacks are solved exactly: their contacts are stiff, but overlaps are pushed out gently.
constexpr double kColumnStiffness = 0.34, kFixedColumnStiffness = 4, kColumnPush = 0.1;
constexpr double kPush = 3;     // m/s: the fastest push-out
constexpr double kSlices = 20;  // a substep has so many slices for each impact of a body
constexpr int kMostSlices = 4;
constexpr int kSweeps = 6;  // most impact sweeps in a substep; usually the third finds nothing

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

}  // namespace

Solver::Run::Run(Solver& solver, const SolverInput& in, const SolverParams& params)
    : SolverInput(in),
      solver_(solver),
      view_(solved.view()),
      pairs_(contacts.pairs()),
      statics_(contacts.static_contacts()),
      h_(params.dt / params.substeps),
      gravity_(length_of(params.gravity)),
      threshold_(params.restitution_threshold),
      model_(static_cast<std::size_t>(params.model.model)),
      bounce_(params.model.bounce ? 1 : 0),
      rough_(params.model.model == kernels::Model::rough),
      turns_(params.turns),
      slices_(1 + static_cast<int>(std::fmin(kSlices * params.impacts, kMostSlices - 1))),
      loaded_sweeps_(solver.loaded_.empty() && !manifolds.totals().loaded ? 0 : HeavyLoads::kSweeps),
      impact_sweeps_(kSweeps + slices_ - 1),
      varying_(forces != nullptr && forces->varying()) {
  if (params.most_sweeps != 0 && params.most_sweeps < impact_sweeps_) {
    limited_ = true;
    impact_sweeps_ = params.most_sweeps;
    slices_ = std::min(slices_, std::max(impact_sweeps_ / 2, 1));  // the last sweeps look for all impacts that are left
  }
  set_motion(params);
  set_contacts(params);
  if (forces) field_ = forces->params(h_);
  const bool drag = field_.quadratic != 0;
  accelerate_ = kernels.accelerate[drag];
  if (varying_ && forces->method()) {
    advance_ = kernels.advance[static_cast<std::size_t>(*forces->method())][drag || field_.linear != 0];
  }
  if (!kinematics.empty()) bodies.find_slots();
  solver.kinematic_at_.resize(std::max(solver.kinematic_at_.size(), 2 * kinematics.size()));
}

// Sets how a substep kicks, damps and moves bodies.
void Solver::Run::set_motion(const SolverParams& params) {
  stream_.h = static_cast<float>(h_);
  stream_.damp = static_cast<float>(std::exp(-params.damping * h_));
  stream_.damp_remainder = static_cast<float>(std::exp(-params.damping * h_) - static_cast<double>(stream_.damp));
  // With damping c: dv = g (1 - exp(-ch))/c, and the drift covers (1 - exp(-ch))/c at the velocity
  // before damping, which v0 has already lost.
  const double c = params.damping;
  const double span = c > 0 ? -std::expm1(-c * h_) / c : h_;
  stream_.kick_x = static_cast<float>(params.gravity.x * span);
  stream_.kick_y = static_cast<float>(params.gravity.y * span);
  stream_.coast = static_cast<float>(span);
  drift_ = stream_;
  constexpr double kMostDamped = 80;  // what exp(-80) leaves of a velocity is nothing to a float
  drift_.h = static_cast<float>(c > 0 ? span / std::exp(-std::fmin(c * h_, kMostDamped)) : h_);
  drift_.smooth_limit2 = forces != nullptr ? 0.0f : static_cast<float>(4 * gravity_ * gravity_ * h_ * h_);
}

// Sets stiffness and limits of the contacts of discs.
void Solver::Run::set_contacts(const SolverParams& params) {
  pair_.h = stream_.h;
  pair_.inv_h = static_cast<float>(1 / h_);
  pair_.pitch_x = static_cast<float>(params.pitch_x);
  pair_.pitch_y = static_cast<float>(params.pitch_y);
  pair_.push = static_cast<float>(kPush);
  pair_.refresh = params.refresh;
  pair_.warm = params.warm;
  pair_.gravity_x = static_cast<float>(params.gravity.x);
  pair_.gravity_y = static_cast<float>(params.gravity.y);
  static_ = loaded_pair_ = loaded_static_ = pair_;
  const double stiff = kStiffness / params.stiff_substep, loaded = kLoadedStiffness / params.stiff_substep;
  set_soft(pair_, h_, stiff, kDamping);
  set_soft(static_, h_, kFixedStiffness * stiff, kDamping);
  set_soft(loaded_pair_, h_, loaded, kLoadedDamping);
  set_soft(loaded_static_, h_, kFixedStiffness * loaded, kLoadedDamping);
}

void Solver::Run::substep(bool first_of_step) {
  const bool first = first_of_step || varying_;
  if (varying_ && (!advance_ || bounce_)) force(accelerate_);
  if (bounce_ && first_of_step) set_floors();
  if (bounce_) impacts();
  if (advance_) force(advance_);
  kick(first);
  if (!kinematics.empty()) hold();
  if (first) warm(first_of_step);
  solve();
  if (stacks.any()) stacks.solve(view_, pair_, gravity_, true);
  if (joined_) joints.hold(view_, kernels, 1, pool);
  drift();
  if (!kinematics.empty()) carry_kinematics();
  if (joined_) joints.hold(view_, kernels, -1, pool);
  if (stacks.any()) stacks.solve(view_, pair_, gravity_, false);
  relax();
  if (bounce_) spend();
}

void Solver::Run::force(FieldPass kernel) {
  const Clock::time_point start = Clock::now();
  for_bodies([&](std::uint32_t begin, std::uint32_t end) { kernel(view_, field_, begin, end); });
  forces_time_ += Clock::now() - start;
}

// Applies gravity and, in the later substeps of a frame, the impulses of contacts in the substep before.
void Solver::Run::kick(bool first) {
  for_bodies([&](std::uint32_t begin, std::uint32_t end) {
    if (!advance_) (first ? kernels.kick_first : kernels.kick_again)(view_, stream_, begin, end);
    if (!rough_ && !turns_) return;
    for (std::size_t i = std::size_t{begin} * 8; i < std::size_t{end} * 8; ++i) {
      const float u = view_.rim_speed[i];
      view_.rim_speed[i] = first ? u : u + (u - view_.rim_speed0[i]);
      view_.rim_speed0[i] = u;
    }
  });
}

// Kinematic bodies keep their velocities; the centre of one that turns about another point goes round.
void Solver::Run::hold() {
  for (std::size_t n = 0; n < kinematics.size(); ++n) {
    const std::uint32_t id = kinematics[n].first;
    const std::size_t i = bodies.info[id].slot;
    Vec2 v = kinematics[n].second;
    if (!bodies.rim_speed.empty()) {
      const double omega = static_cast<double>(bodies.rim_speed[i]) / static_cast<double>(bodies.radius[i]);
      const Vec2 arm = arm_of(bodies.kind(id), bodies.angle[i] + omega * h_ / 2);
      v = {v.x - omega * arm.y, v.y + omega * arm.x};
    }
    bodies.vel[2 * i] = bodies.vel0[2 * i] = static_cast<float>(v.x);
    bodies.vel[2 * i + 1] = bodies.vel0[2 * i + 1] = static_cast<float>(v.y);
    solver_.kinematic_at_[2 * n] = bodies.disp[2 * i];
    solver_.kinematic_at_[2 * n + 1] = bodies.disp[2 * i + 1];
  }
}

void Solver::Run::warm(bool first_of_step) {
  ContactParams warm_pair = pair_, warm_static = static_;
  if (!first_of_step) warm_pair.warm = warm_static.warm = 1;
  for_pairs(
      [&](std::size_t, const Strip& s) { kernels.warm[model_](view_, pairs_, warm_pair, s.block_begin, s.block_end); });
  for_all_manifolds([&](bool fixed, ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
    kernels.warm_manifolds[fixed](view_, blocks, warm_pair.warm, begin, end);
  });
  for_statics([&](std::size_t, const Strip& s) {
    kernels.warm_static[model_](view_, statics_, warm_static, s.static_begin, s.static_end);
  });
  if (joined_) joints.warm(view_, kernels, warm_pair.warm, pool);
}

// One pass over all contacts: those of discs, then of shapes; sweeps over those under heavy loads; then those with
// fixed shapes. The tables are of kernels; all sweeps but the `outer`-th one are inner ones.
template <class Pairs, class Statics, class Blocks>
void Solver::Run::pass(const Pairs& pass_pairs, const Statics& pass_statics, const Blocks& pass_blocks, int outer) {
  for_pairs(
      [&](std::size_t, const Strip& s) { pass_pairs[bounce_](view_, pairs_, pair_, s.block_begin, s.loaded_begin); });
  const auto pass_manifolds = [&](bool fixed, bool loaded, bool inner) {
    for_manifolds(fixed, loaded, [&](ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
      pass_blocks[fixed][bounce_][inner](view_, blocks, loaded ? loaded_pair_ : pair_, begin, end);
    });
  };
  pass_manifolds(false, false, false);
  for (int sweep = 0; sweep < loaded_sweeps_; ++sweep) {
    const bool inner = sweep != outer;
    const std::size_t kind = bounce_ << inner;
    for_loaded([&](const Strip& s) { pass_pairs[kind](view_, pairs_, loaded_pair_, s.loaded_begin, s.block_end); },
               [&](const Strip& s) {
                 pass_statics[kind](view_, statics_, loaded_static_, s.static_loaded_begin, s.static_end);
               });
    pass_manifolds(false, true, inner);
    pass_manifolds(true, true, inner);
  }
  pass_manifolds(true, false, false);
  for_statics([&](std::size_t, const Strip& s) {
    pass_statics[bounce_](view_, statics_, static_, s.static_begin, s.static_loaded_begin);
  });
}

void Solver::Run::solve() {
  if (joined_) joints.solve(view_, kernels, pool);
  pass(kernels.solve[model_], kernels.solve_static[model_], kernels.solve_manifolds, 0);
}

void Solver::Run::relax() {
  if (joined_) joints.relax(view_, kernels, pool);
  pass(kernels.relax[model_], kernels.relax_static[model_], kernels.relax_manifolds, loaded_sweeps_ - 1);
}

void Solver::Run::drift() {
  for_bodies([&](std::uint32_t begin, std::uint32_t end) {
    if (advance_) {
      kernels.drift_corrected(view_, field_, begin, end);
    } else {
      kernels.drift(view_, drift_, begin, end);
    }
    if (turns_) kernels.turn_bodies(view_, bodies.radius.data(), stream_.h, begin, end);
    if (bodies.rim_speed.empty()) return;
    for (std::uint32_t n = begin * 8; n < std::min(end * 8, solved.count()); ++n) {
      if (view_.linked[n] == 0) continue;
      if (view_.rim_speed[n] == 0) continue;
      const std::size_t i = solved.slot(n);
      bodies.angle[i] += h_ * (static_cast<double>(view_.rim_speed[n]) / static_cast<double>(bodies.radius[i]));
    }
  });
}

// The places of kinematic bodies go straight on, since nothing damps them.
void Solver::Run::carry_kinematics() {
  for (std::size_t n = 0; n < kinematics.size(); ++n) {
    const std::uint32_t id = kinematics[n].first;
    const std::size_t i = bodies.info[id].slot;
    bodies.clear_remainders(i);
    float way_x = stream_.h * bodies.vel[2 * i], way_y = stream_.h * bodies.vel[2 * i + 1];
    if (!bodies.rim_speed.empty()) {
      const double omega = static_cast<double>(bodies.rim_speed[i]) / static_cast<double>(bodies.radius[i]);
      const BodyKind& kind = bodies.kind(id);
      const Vec2 now = arm_of(kind, bodies.angle[i]);
      const Vec2 before = arm_of(kind, bodies.angle[i] - omega * h_);
      if (now.x != before.x || now.y != before.y) {
        way_x = static_cast<float>(h_ * kinematics[n].second.x + (now.x - before.x));
        way_y = static_cast<float>(h_ * kinematics[n].second.y + (now.y - before.y));
      }
    }
    bodies.disp[2 * i] = solver_.kinematic_at_[2 * n] + way_x;
    bodies.disp[2 * i + 1] = solver_.kinematic_at_[2 * n + 1] + way_y;
  }
}

// Lists the strips with contacts under heavy loads: even strips, odd strips, then the group of large bodies.
void Solver::find_loaded(const PairTable& table) {
  loaded_.clear();
  const std::size_t strips = table.strips.size() - 1;
  for (std::size_t parity = 0; parity < 2; ++parity) {
    for (std::size_t k = parity; k < strips; k += 2) {
      if (table.strips[k].loaded) loaded_.push_back(static_cast<std::uint32_t>(k));
    }
    (parity == 0 ? loaded_odd_ : loaded_large_) = loaded_.size();
  }
  if (table.strips[strips].loaded) loaded_.push_back(static_cast<std::uint32_t>(strips));
}

// Counts closed contacts and sums impulse times distance. The impulses are those of the last substep; the sum over a
// step counts them once for each substep.
void Solver::sum_up(const SolverInput& in, int substeps) {
  const ContactStore& c = in.contacts;
  in.pool.run(in.table.strips.size(), [&](std::size_t index) {
    const Strip& s = in.table.strips[index];
    double sum = 0;
    std::uint64_t closed = 0;
    for (std::size_t l = std::size_t{s.block_begin} * 8; l < std::size_t{s.block_end} * 8; ++l) {
      closed += std::signbit(c.impulse[l]) ? 0 : 1;  // an impulse of -0 marks an open contact
      const std::uint32_t pressing = std::bit_cast<std::uint32_t>(c.impulse[l]) & mask_from(c.impulse[l], kTiniest);
      sum += static_cast<double>(std::bit_cast<float>(pressing)) * static_cast<double>(c.rsum[l]);
    }
    for (std::size_t l = std::size_t{s.static_begin} * 8; l < std::size_t{s.static_end} * 8; ++l) {
      closed += std::signbit(c.s_impulse[l]) ? 0 : 1;
      if (c.s_impulse[l] > 0 && c.s_refresh[l] < 1e30f) {  // the shape is round
        sum += static_cast<double>(c.s_impulse[l]) * static_cast<double>(c.s_rsum[l]);
      }
    }
    virial_[index] += sum * substeps;
    closed_by_strip_[index] = closed;
  });
}

void Solver::manifold_softness(double h, double stiff_substep, ManifoldParams& p) {
  const double stiffness[2] = {kManifoldStiffness, kLoadedManifoldStiffness};
  for (std::size_t k = 0; k < 4; ++k) {
    const double times = k % 2 == 1 ? kFixedStiffness : 1;
    set_softness(h, times * stiffness[k / 2] / stiff_substep, p.plain[k]);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const double times = k == 1 ? kFixedStiffness : 1;
    set_softness(h, times * kBouncingStiffness / stiff_substep, p.bouncing[k]);
  }
  const double stacks[2] = {kColumnStiffness, kFixedColumnStiffness};
  for (std::size_t k = 0; k < 2; ++k) {
    set_softness(h, stacks[k] / stiff_substep, p.in_stacks[k]);
    p.in_stacks[k].rate = std::min(p.in_stacks[k].rate, static_cast<float>(kColumnPush / h));
  }
}

SolverReport Solver::run(const SolverInput& in, const SolverParams& params) {
  virial_.assign(in.table.strips.size(), 0.0);
  closed_by_strip_.assign(in.table.strips.size(), 0);
  find_loaded(in.table);
  if (params.model.bounce) mark_impacts(in);
  Run run(*this, in, params);
  for (int substep = 0; substep < params.substeps; ++substep) run.substep(substep == 0);
  if (params.model.bounce) sweeps_ = run.swept() / params.substeps;
  in.solved.store();
  sum_up(in, params.substeps);
  SolverReport report;
  report.forces_ms = run.forces_ms();
  closed_ = 0;
  for (std::size_t s = 0; s < in.manifolds.strip_count(); ++s) closed_ += in.manifolds.closed(s);
  for (std::size_t s = 0; s < virial_.size(); ++s) {
    report.virial += virial_[s];
    closed_ += closed_by_strip_[s];
  }
  return report;
}

}  // namespace psim
