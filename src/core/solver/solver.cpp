#include "solver/solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/tasks.h"
#include "contacts/softness.h"
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
void set_softness(double h, double frequency, float& soft, float& rate) {
  const double omega = 2 * std::numbers::pi * frequency;
  const double a1 = 2 * kManifoldDamping + h * omega;
  soft = static_cast<float>(1 / (h * omega * a1));
  rate = static_cast<float>(omega / a1);
}

}  // namespace

Solver::Run::Run(Solver& solver, BodyStore& bodies, SolverBodies& solved, const PairTable& table,
                 ContactStore& contacts, Manifolds& manifolds, Stacks& stacks, JointStore& joints,
                 const SolverParams& params, const Forces* forces, const KinematicBodies& kinematics,
                 const kernels::KernelTable& k, WorkerPool& pool)
    : solver_(solver),
      bodies_(bodies),
      solved_(solved),
      table_(table),
      manifolds_(manifolds),
      columns_(stacks),
      joints_(joints),
      kinematics_(kinematics),
      k_(k),
      pool_(pool),
      view_(solved.view(bodies)),
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
      loaded_sweeps_(solver.loaded_.empty() && !manifolds.loaded() ? 0 : HeavyLoads::kSweeps),
      impact_sweeps_(kSweeps + slices_ - 1),
      varying_(forces != nullptr && forces->varying()) {
  if (params.most_sweeps != 0 && params.most_sweeps < impact_sweeps_) {
    limited_ = true;
    impact_sweeps_ = params.most_sweeps;
    slices_ = std::min(slices_, std::max(impact_sweeps_ / 2, 1));  // the last sweeps look for all impacts that are left
  }
  set_motion(params, forces != nullptr);
  set_contacts(params);
  if (forces) field_ = forces->params(h_);
  const bool drag = field_.quadratic != 0;
  accelerate_ = k.accelerate[drag];
  if (varying_ && forces->method()) {
    advance_ = k.advance[static_cast<std::size_t>(*forces->method())][drag || field_.linear != 0];
  }
  if (!kinematics.empty()) bodies.find_slots();
  solver.kinematic_at_.resize(std::max(solver.kinematic_at_.size(), 2 * kinematics.size()));
}

// Sets how a substep kicks, damps and moves bodies.
void Solver::Run::set_motion(const SolverParams& params, bool has_forces) {
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
  drift_.smooth_limit2 = has_forces ? 0.0f : static_cast<float>(4 * gravity_ * gravity_ * h_ * h_);
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
  if (!kinematics_.empty()) hold();
  if (first) warm(first_of_step);
  solve();
  if (columns_.any()) columns_.solve(view_, manifolds_, pair_, gravity_, true, pool_);
  if (joined_) joints_.hold(view_, k_, 1, pool_);
  drift();
  if (!kinematics_.empty()) carry_kinematics();
  if (joined_) joints_.hold(view_, k_, -1, pool_);
  if (columns_.any()) columns_.solve(view_, manifolds_, pair_, gravity_, false, pool_);
  relax();
  if (bounce_) spend();
}

template <class Kernel>
void Solver::Run::force(Kernel kernel) {
  const Clock::time_point start = Clock::now();
  for_bodies([&](std::uint32_t begin, std::uint32_t end) { kernel(view_, field_, begin, end); });
  forces_time_ += Clock::now() - start;
}

// Applies gravity and, in the later substeps of a frame, the impulses of contacts in the substep before.
void Solver::Run::kick(bool first) {
  for_bodies([&](std::uint32_t begin, std::uint32_t end) {
    if (!advance_) (first ? k_.kick_first : k_.kick_again)(view_, stream_, begin, end);
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
  for (std::size_t n = 0; n < kinematics_.size(); ++n) {
    const std::uint32_t id = kinematics_[n].first;
    const std::size_t i = bodies_.info[id].slot;
    Vec2 v = kinematics_[n].second;
    if (!bodies_.rim_speed.empty()) {
      const double omega = static_cast<double>(bodies_.rim_speed[i]) / static_cast<double>(bodies_.radius[i]);
      const Vec2 arm = arm_of(bodies_.kind(id), bodies_.angle[i] + omega * h_ / 2);
      v = {v.x - omega * arm.y, v.y + omega * arm.x};
    }
    bodies_.vel[2 * i] = bodies_.vel0[2 * i] = static_cast<float>(v.x);
    bodies_.vel[2 * i + 1] = bodies_.vel0[2 * i + 1] = static_cast<float>(v.y);
    solver_.kinematic_at_[2 * n] = bodies_.disp[2 * i];
    solver_.kinematic_at_[2 * n + 1] = bodies_.disp[2 * i + 1];
  }
}

void Solver::Run::warm(bool first_of_step) {
  ContactParams warm_pair = pair_, warm_static = static_;
  if (!first_of_step) warm_pair.warm = warm_static.warm = 1;
  for_pairs(
      [&](std::size_t, const Strip& s) { k_.warm[model_](view_, pairs_, warm_pair, s.block_begin, s.block_end); });
  for (const bool fixed : {false, true}) {
    for (const bool loaded : {false, true}) {
      for_manifolds(fixed, loaded, [&](kernels::ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
        k_.warm_manifolds[fixed](view_, blocks, warm_pair.warm, begin, end);
      });
    }
  }
  for_statics([&](std::size_t, const Strip& s) {
    k_.warm_static[model_](view_, statics_, warm_static, s.static_begin, s.static_end);
  });
  if (joined_) joints_.warm(view_, k_, warm_pair.warm, pool_);
}

void Solver::Run::solve() {
  if (joined_) joints_.solve(view_, k_, pool_);
  for_pairs([&](std::size_t, const Strip& s) {
    k_.solve[model_][bounce_](view_, pairs_, pair_, s.block_begin, s.loaded_begin);
  });
  const auto solve_manifolds = [&](bool fixed, bool loaded, bool inner) {
    for_manifolds(fixed, loaded, [&](kernels::ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
      k_.solve_manifolds[fixed][bounce_][inner](view_, blocks, loaded ? loaded_pair_ : pair_, begin, end);
    });
  };
  solve_manifolds(false, false, false);
  for (int sweep = 0; sweep < loaded_sweeps_; ++sweep) {
    const bool inner = sweep != 0;
    for_loaded(
        [&](const Strip& s) {
          k_.solve[model_][bounce_ << inner](view_, pairs_, loaded_pair_, s.loaded_begin, s.block_end);
        },
        [&](const Strip& s) {
          k_.solve_static[model_][bounce_ << inner](view_, statics_, loaded_static_, s.static_loaded_begin,
                                                    s.static_end);
        });
    solve_manifolds(false, true, inner);
    solve_manifolds(true, true, inner);
  }
  solve_manifolds(true, false, false);
  for_statics([&](std::size_t, const Strip& s) {
    k_.solve_static[model_][bounce_](view_, statics_, static_, s.static_begin, s.static_loaded_begin);
  });
}

void Solver::Run::drift() {
  for_bodies([&](std::uint32_t begin, std::uint32_t end) {
    if (advance_) {
      k_.drift_corrected(view_, field_, begin, end);
    } else {
      k_.drift(view_, drift_, begin, end);
    }
    if (turns_) k_.turn_bodies(view_, bodies_.radius.data(), stream_.h, begin, end);
    if (bodies_.rim_speed.empty()) return;
    for (std::uint32_t n = begin * 8; n < std::min(end * 8, solved_.count()); ++n) {
      if (view_.linked[n] == 0) continue;
      if (view_.rim_speed[n] == 0) continue;
      const std::size_t i = solved_.slot(n);
      bodies_.angle[i] += h_ * (static_cast<double>(view_.rim_speed[n]) / static_cast<double>(bodies_.radius[i]));
    }
  });
}

// The places of kinematic bodies go straight on, since nothing damps them.
void Solver::Run::carry_kinematics() {
  for (std::size_t n = 0; n < kinematics_.size(); ++n) {
    const std::uint32_t id = kinematics_[n].first;
    const std::size_t i = bodies_.info[id].slot;
    bodies_.clear_remainders(i);
    float way_x = stream_.h * bodies_.vel[2 * i], way_y = stream_.h * bodies_.vel[2 * i + 1];
    if (!bodies_.rim_speed.empty()) {
      const double omega = static_cast<double>(bodies_.rim_speed[i]) / static_cast<double>(bodies_.radius[i]);
      const BodyKind& kind = bodies_.kind(id);
      const Vec2 now = arm_of(kind, bodies_.angle[i]);
      const Vec2 before = arm_of(kind, bodies_.angle[i] - omega * h_);
      if (now.x != before.x || now.y != before.y) {
        way_x = static_cast<float>(h_ * kinematics_[n].second.x + (now.x - before.x));
        way_y = static_cast<float>(h_ * kinematics_[n].second.y + (now.y - before.y));
      }
    }
    bodies_.disp[2 * i] = solver_.kinematic_at_[2 * n] + way_x;
    bodies_.disp[2 * i + 1] = solver_.kinematic_at_[2 * n + 1] + way_y;
  }
}

void Solver::Run::relax() {
  if (joined_) joints_.relax(view_, k_, pool_);
  for_pairs([&](std::size_t, const Strip& s) {
    k_.relax[model_][bounce_](view_, pairs_, pair_, s.block_begin, s.loaded_begin);
  });
  const auto relax_manifolds = [&](bool fixed, bool loaded, bool inner) {
    for_manifolds(fixed, loaded, [&](kernels::ManifoldBlock* blocks, std::uint32_t begin, std::uint32_t end) {
      k_.relax_manifolds[fixed][bounce_][inner](view_, blocks, loaded ? loaded_pair_ : pair_, begin, end);
    });
  };
  relax_manifolds(false, false, false);
  for (int sweep = 0; sweep < loaded_sweeps_; ++sweep) {
    const bool inner = sweep + 1 != loaded_sweeps_;
    for_loaded(
        [&](const Strip& s) {
          k_.relax[model_][bounce_ << inner](view_, pairs_, loaded_pair_, s.loaded_begin, s.block_end);
        },
        [&](const Strip& s) {
          k_.relax_static[model_][bounce_ << inner](view_, statics_, loaded_static_, s.static_loaded_begin,
                                                    s.static_end);
        });
    relax_manifolds(false, true, inner);
    relax_manifolds(true, true, inner);
  }
  relax_manifolds(true, false, false);
  for_statics([&](std::size_t, const Strip& s) {
    k_.relax_static[model_][bounce_](view_, statics_, static_, s.static_begin, s.static_loaded_begin);
  });
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
void Solver::sum_up(const PairTable& table, const ContactStore& c, int substeps, WorkerPool& pool) {
  pool.run(table.strips.size(), [&](std::size_t index) {
    const Strip& s = table.strips[index];
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
    set_softness(h, times * stiffness[k / 2] / stiff_substep, p.soft[k], p.rate[k]);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const double times = k == 1 ? kFixedStiffness : 1;
    set_softness(h, times * kBouncingStiffness / stiff_substep, p.bouncing_soft[k], p.bouncing_rate[k]);
  }
  const double stacks[2] = {kColumnStiffness, kFixedColumnStiffness};
  for (std::size_t k = 0; k < 2; ++k) {
    set_softness(h, stacks[k] / stiff_substep, p.stack_soft[k], p.stack_rate[k]);
    p.stack_rate[k] = std::min(p.stack_rate[k], static_cast<float>(kColumnPush / h));
  }
}

SolverReport Solver::run(BodyStore& b, SolverBodies& solved, PairTable& table, ContactStore& contacts,
                         Manifolds& manifolds, Stacks& stacks, JointStore& joints, const SolverParams& params,
                         const Forces* forces, const KinematicBodies& kinematics, const kernels::KernelTable& k,
                         WorkerPool& pool) {
  virial_.assign(table.strips.size(), 0.0);
  closed_by_strip_.assign(table.strips.size(), 0);
  find_loaded(table);
  if (params.model.bounce) mark_impacts(solved, table, contacts, pool);
  Run run(*this, b, solved, table, contacts, manifolds, stacks, joints, params, forces, kinematics, k, pool);
  for (int substep = 0; substep < params.substeps; ++substep) run.substep(substep == 0);
  if (params.model.bounce) sweeps_ = run.swept() / params.substeps;
  solved.store(b, pool);
  sum_up(table, contacts, params.substeps, pool);
  SolverReport report;
  report.forces_ms = run.forces_ms();
  closed_ = 0;
  for (std::size_t s = 0; s < manifolds.strips(); ++s) closed_ += manifolds.closed(s);
  for (std::size_t s = 0; s < virial_.size(); ++s) {
    report.virial += virial_[s];
    closed_ += closed_by_strip_[s];
  }
  return report;
}

}  // namespace psim
