// Impulses before the drift, and what calls the passes (docs/joints.md): RATTLE (Andersen 1983) with Newton steps, in
// double precision.
#include <algorithm>
#include <cmath>

#include "base/elementary.h"

#include "joints/articulation_solve.h"

namespace psim {
namespace {

constexpr int kMostSteps = 6;        // Newton steps in a substep
constexpr int kMostChoices = 5;      // in how many of them limits may begin and cease to hold
constexpr double kMostError = 1e6;   // m or rad: beyond it steps lead nowhere
constexpr double kConverged = 1e-6;  // m or rad: where Newton's steps miss by more, speeds alone are stopped

}  // namespace

// Ropes pull or hang loose; a drive stands at a limit, or its motor runs. True if that changes. Nobody is brought back
// who was beyond a limit already.
bool Articulations::Solve::choose(Row& row, const Joint& j) const {
  const State before = row.state;
  const double error = row.now.error;
  if (row.use == Use::pull) {
    if (row.on() && row.impulse > 0) row.state = State::free;
    if (!row.on() && error > greater(row.start.error, 0) + kExact) row.state = State::bound;
  } else if (row.use == Use::drive) {
    const State motor = j.motor_most > 0 ? State::bound : State::free;
    const double ahead = error - row.start.error - h_ * j.motor_speed;
    if (error < lesser(j.lower, row.start.error) - kExact) {
      row.state = State::low;
      row.impulse = greater(row.impulse, 0);
    } else if (error > greater(j.upper, row.start.error) + kExact) {
      row.state = State::high;
      row.impulse = lesser(row.impulse, 0);
    } else if ((row.state == State::low && row.impulse < 0) || (row.state == State::high && row.impulse > 0)) {
      row.state = motor;
      row.impulse = 0;
    } else if (row.state == State::bound && std::fabs(row.impulse) > 0.5 * j.motor_most) {
      row.state = State::full;  // the other half follows after the drift
      row.impulse = std::copysign(0.5 * j.motor_most, row.impulse);
    } else if (row.state == State::full && ahead * row.impulse > kExact * std::fabs(row.impulse)) {
      row.state = State::bound;  // it gives too much
    }
  }
  if (row.state == State::free) row.impulse = 0;
  return row.state != before;
}

double Articulations::Solve::residual(const Row& row, const Joint& j) const {
  const double from = row.start.error, to = row.now.error;
  if (!row.on()) return 0;
  if (row.use == Use::pull) return to - greater(from, 0);
  if (row.use == Use::spring) return (to - from) + h_ * row.softness * (spring_rest(row, j) + row.impulse);
  if (row.use == Use::drive) {
    if (row.state == State::low) return to - lesser(j.lower, from);
    if (row.state == State::high) return to - greater(j.upper, from);
    return to - from - h_ * j.motor_speed;
  }
  return to - from;
}

// Looks for impulses with which the drift ends where the joints hold: along the rows of the start by Newton's method, as
// RATTLE has it (`exact`). Where the substep does not resolve how rows turn under their load, that may not converge; then
// each step goes along the rows of where the one before ended, which always does, and damps what is too fast.
bool Articulations::Solve::find_impulses(double drift, bool exact) {
  for_bodies([](Body& b) { b.now = b.start; });
  if (!exact) {
    for_rows([](Row& row, const Joint&) {
      row.impulse = 0;
      if (row.state == State::full) row.state = State::bound;
    });
  }
  double least = 1e300;
  for (int step = 0;; ++step) {
    if (exact) {
      for_bodies([](Body& b) { b.now = b.start; });
      push(true, [](const Row& row, const Joint&) { return row.impulse; });
    }
    move_on(drift);
    find_rows_now();
    find_middle_rows();
    bool changed = false;
    if (step < kMostChoices) {
      for_rows([&](Row& row, const Joint& j) {
        const double before = row.impulse;
        changed = choose(row, j) || changed;
        if (!exact && row.impulse != before) push_row(row.now, j, row.impulse - before);
      });
    }
    double worst = 0;
    for_rows([&](Row& row, const Joint& j) {
      const double error = residual(row, j);
      row.wanted = -error / h_;
      worst = std::fabs(error) <= worst ? worst : std::fabs(error);  // NaN counts
    });
    if (worst <= kExact && !changed) return true;
    if (step == kMostSteps || !(worst < kMostError) || (exact && step > 1 && worst > least)) return worst < kConverged;
    if (!changed) least = lesser(worst, least);
    factorise(exact, exact ? kAlike : kSturdy);
    substitute();
    for_rows([](Row& row, const Joint&) { row.impulse += row.wanted; });
    if (exact) continue;
    push_wanted();
  }
}

// The search begins with impulses that take the speeds of errors away at the start. Returns the energy of the motion
// that they leave.
double Articulations::Solve::begin_impulses(const JointedMotion& common) {
  for_rows([](Row& row, const Joint&) { row.impulse = 0; });
  stop_errors(0.5);
  for_rows([](Row& row, const Joint&) { row.tangent = row.impulse += row.wanted; });
  push(false, [](const Row& row, const Joint&) { return row.wanted; });
  for_bodies([](Body& b) { b.tangent = b.now.velocity, b.tangent_omega = b.now.omega; });
  return energy_within(common, false);
}

// How far the velocities of now are from those that begin_impulses() found: the energy of the difference, and what the
// energy against `common` changes by along it, to first order.
Articulations::Solve::Change Articulations::Solve::from_tangent(const JointedMotion& common) {
  Change sum;
  for_bodies([&](const Body& b) {
    if (b.inverse_mass == 0) return;
    const Vec2 way = b.now.velocity - b.tangent;
    const double turn = b.now.omega - b.tangent_omega;
    sum.square += 0.5 * dot(way, way) / b.inverse_mass;
    sum.slope += dot(way, b.tangent - common.velocity) / b.inverse_mass;
    if (b.inverse_inertia == 0) return;
    sum.square += 0.5 * turn * turn / b.inverse_inertia;
    sum.slope += turn * b.tangent_omega / b.inverse_inertia;
  });
  return sum;
}

// Goes from the velocities that begin_impulses() found towards those of now as far as the energy does not grow.
void Articulations::Solve::stay_within(const JointedMotion& common) {
  const Change change = from_tangent(common);
  double share = 0;
  if (change.slope < 0) share = change.square > -change.slope ? -change.slope / change.square : 1;
  for_bodies([&](Body& b) {
    b.now.velocity = b.tangent + share * (b.now.velocity - b.tangent);
    b.now.omega = b.tangent_omega + share * (b.now.omega - b.tangent_omega);
  });
  for_rows([&](Row& row, const Joint&) { row.impulse = row.tangent + share * (row.impulse - row.tangent); });
}

// Pushes the impulses that were found along the rows of the start, from where the bodies were.
void Articulations::Solve::go_along_start() {
  for_bodies([](Body& b) { b.now = b.start; });
  for_rows([](Row& row, const Joint&) { row.wanted = row.impulse, row.now = row.start; });
  push_wanted();
}

// Bodies and rows as the substep begins.
void Articulations::Solve::begin_whole() {
  for_bodies([](Body& b) {
    b.now = b.begin;
    b.now.velocity = b.now.velocity - 0.5 * b.pull;
    b.start = b.now;
    b.idle = 0.5 * b.kick;
    b.idle_omega = 0.5 * b.kick_omega;
  });
  gained_ = 0;
  load_rows();
  begin_springs();
}

// Looks for the impulses of the substep as one step. Returns what share of the energy they add to the motion that the
// rows of the start allow: the equations have other roots, far away. Infinity if none are found.
double Articulations::Solve::try_whole(double drift) {
  begin_whole();
  const JointedMotion common = moving_with();
  const double energy = begin_impulses(common);
  const bool found = find_impulses(drift, true);
  island_.apart = from_tangent(common).square;
  if (!found) return HUGE_VAL;
  return island_.apart > 0 ? island_.apart / energy : 0;
}

// The substep where no impulses are found: with less energy.
void Articulations::Solve::step_damped(double drift) {
  begin_whole();
  const JointedMotion common = moving_with();
  const double before = energy_within(common, true);
  begin_impulses(common);
  find_impulses(drift, false);
  stay_within(common);
  island_.apart = 0;
  gained_ = energy_within(common, true) - before;
}

// Whether the motion is more than what gravity and contacts change in this substep: else the bodies lie or hang still.
bool Articulations::Solve::moves() {
  double motion = 0, kick = 0;
  for_bodies([&](const Body& b) {
    if (b.inverse_mass == 0) return;
    const Vec2 before = b.begin.velocity - b.kick;
    motion += dot(before, before) / b.inverse_mass;
    kick += dot(b.kick, b.kick) / b.inverse_mass;
  });
  return motion > kick;
}

void Articulations::Solve::solve(double drift, double smooth_limit2) {
  reach_ = all_.reach_;
  for_bodies([&](Body& b) {
    load_motion(b);
    b.begin = b.now;
    const Vec2 acceleration = view_.acc != nullptr ? load_record(view_.acc, b.number) : Vec2{};
    b.kick = b.now.velocity - load_record(view_.vel0, b.number);
    b.kick_omega = b.now.omega - static_cast<double>(view_.rim_speed0[b.number]) / b.radius;
    const bool smooth = dot(b.kick, b.kick) <= smooth_limit2 + 4 * drift * drift * dot(acceleration, acceleration);
    b.pull = smooth ? b.kick : Vec2{};
  });
  double added = try_whole(drift);
  island_.refined = false;
  if (!(added <= kResolved) && most_tries() >= kFewestTries && moves()) {
    island_.refined = refine(drift);
    if (!island_.refined) added = try_whole(drift);
  }
  if (added <= kMostGain && !island_.refined) {
    go_along_start();
  } else if (!island_.refined) {
    step_damped(drift);
  }
  for_bodies([](Body& b) { b.mark.velocity = b.begin.velocity - 0.5 * b.pull, b.mark.omega = b.begin.omega; });
  store_velocities();
  island_.gained = gained_;
}

// Bodies and joints were set for the frame.
void Articulations::prepare(double h, bool calm) {
  h_ = h;
  calm_ = calm;
  for (const Island& island : islands_) {
    bodies_[island.bodies.begin].place = {};
    for (std::uint32_t k = island.walk.begin; k < island.walk.end; ++k) {
      const Joint& j = joints_[walk_[k] / 2];
      const std::uint32_t to = walk_[k] & 1;
      const double way = to == 1 ? 1 : -1;
      bodies_[j.body[to]].place = bodies_[j.body[1 - to]].place + way * j.geometry.base;
    }
  }
  for (Joint& j : joints_) {
    using kernels::JointKind;
    for (std::uint32_t k = 0; k < j.geometry.rows(); ++k) {
      Use& use = rows_[j.first_row + k].use;
      use = Use::keep;
      if (j.geometry.kind == JointKind::rod && j.rope) use = Use::pull;
      if (j.geometry.kind == JointKind::spring) use = Use::spring;
      if (j.geometry.kind == JointKind::weld && k == 2 && j.spring.drag > 0) use = Use::spring;
      const bool driven = j.geometry.kind == JointKind::driven || j.geometry.kind == JointKind::slide;
      if (driven && k == 2 && j.lower != j.upper) use = Use::drive;
    }
  }
}

void Articulations::solve(const kernels::BodyView& view, double drift, double smooth_limit2, WorkerPool& pool) {
  reach_ = drift / h_;
  pool.run(islands_.size(), [&](std::size_t n) { Solve(*this, islands_[n], view).solve(drift, smooth_limit2); });
}

void Articulations::finish(const kernels::BodyView& view, double* angle, WorkerPool& pool) {
  pool.run(islands_.size(), [&](std::size_t n) { Solve(*this, islands_[n], view).finish(angle); });
}

}  // namespace psim
