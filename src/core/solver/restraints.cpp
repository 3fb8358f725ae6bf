// Damping and locks of single bodies. In and out: velocities, between the passes of a substep (solver.cpp). O(restrained
// bodies).
//
// A body without forces goes f v h in a substep of h seconds, where f = (1 - e) / (c h), and keeps e v, where
// e = exp(-c h). So its velocity is f v while it drifts, and is multiplied by e / f then. What gravity adds is multiplied
// by f^2 / e, so that it falls as fast in the end as it should, by g / c. All of that grows with c h. Where c h > 1/2 the
// velocity fades before the drift alone: the velocity after the substep is still exact.
#include <cmath>

#include "base/elementary.h"
#include "solver/solver_run.h"

namespace psim {
namespace {

Fading fading_of(double damping, double h) {
  constexpr double kMostSplit = 0.5;
  if (!(damping > 0)) return {};
  const double kept = exponential(-damping * h), mean = coast_time(damping, h) / h;
  const auto less_one = [](double factor) { return kernels::snapped(factor - 1); };
  if (damping * h > kMostSplit) return {less_one(kept), less_one(mean), 0};
  return {less_one(mean), less_one(mean * mean / kept), less_one(kept / mean)};
}

float changed(float v, float by) { return kernels::snapped(v + v * by); }

}  // namespace

// Notes where restrained bodies are, and what their damping does in this step.
void Solver::Run::find_restrained() {
  const BodyStore& b = s_.bodies;
  solver_.fading_.clear();
  solver_.locked_at_.clear();
  const Restraint* last = nullptr;
  for (const Restraint& r : restraints) {
    if (last == nullptr || r.linear_damping != last->linear_damping || r.angular_damping != last->angular_damping) {
      solver_.fading_.push_back({fading_of(double{r.linear_damping}, h_), fading_of(double{r.angular_damping}, h_)});
    } else {
      solver_.fading_.push_back(solver_.fading_.back());
    }
    last = &r;
    const std::size_t i = b.info[r.id].slot;
    const bool here = b.info[r.id].place == Place::moving;
    solver_.locked_at_.push_back(here ? Stand{b.disp[2 * i], b.disp[2 * i + 1], b.angle_of(i)} : Stand{});
  }
}

// After the kick: what is left of the velocity before it fades, and what the kick added stays, since later kicks add it
// again.
void Solver::Run::restrain(bool first) {
  BodyStore& b = s_.bodies;
  const bool spins = !b.rim_speed.empty(), kicked = !fields_.advance;
  const bool spin_kicked = params_.model.rough() || params_.turns;
  for (std::size_t n = 0; n < restraints.size(); ++n) {
    const Restraint& r = restraints[n];
    if (b.info[r.id].place != Place::moving) continue;
    const std::size_t i = b.info[r.id].slot;
    const auto& [linear, angular] = solver_.fading_[n];
    for (const std::size_t k : {2 * i, 2 * i + 1}) {
      const float added = kicked ? changed(b.vel[k] - b.vel0[k], first ? linear.kick : 0.0f) : 0.0f;
      b.vel0[k] = changed(b.vel0[k], linear.before);
      b.vel[k] = kicked ? kernels::snapped(b.vel0[k] + added) : changed(b.vel[k], linear.before);
    }
    if (!spins) continue;
    const float added = spin_kicked ? b.rim_speed[i] - b.rim_speed0[i] : 0.0f, faded = b.rim_speed[i] - added;
    b.rim_speed0[i] = changed(faded, angular.before);
    b.rim_speed[i] = b.rim_speed0[i] + added;
  }
}

// Before the drift: who is locked stands still.
void Solver::Run::hold_locked() {
  BodyStore& b = s_.bodies;
  for (const Restraint& r : restraints) {
    if (r.locks == Locks{} || b.info[r.id].place != Place::moving) continue;
    const std::size_t i = b.info[r.id].slot;
    for (const std::size_t k : {2 * i, 2 * i + 1}) {
      if (!(k == 2 * i ? r.locks.x : r.locks.y)) continue;
      b.vel[k] = b.vel0[k] = 0;
      if (!b.vel_remainder.empty()) b.vel_remainder[k] = 0;
      if (!b.drift_correction.empty()) b.drift_correction[k] = 0;
    }
    if (r.locks.angle && !b.rim_speed.empty()) b.rim_speed[i] = b.rim_speed0[i] = 0;
  }
}

// At the end of the substep: the rest of the damping.
void Solver::Run::let_run_on() {
  BodyStore& b = s_.bodies;
  const auto fade = [](float& now, float& before, float after) {
    const float added = now - before;
    now = changed(now, after);
    before = now - added;
  };
  hold_locked();
  for (std::size_t n = 0; n < restraints.size(); ++n) {
    const Restraint& r = restraints[n];
    if (b.info[r.id].place != Place::moving) continue;
    const std::size_t i = b.info[r.id].slot;
    const auto& [linear, angular] = solver_.fading_[n];
    if (linear.after != 0) {
      fade(b.vel[2 * i], b.vel0[2 * i], linear.after);
      fade(b.vel[2 * i + 1], b.vel0[2 * i + 1], linear.after);
    }
    if (angular.after != 0 && !b.rim_speed.empty()) fade(b.rim_speed[i], b.rim_speed0[i], angular.after);
  }
}

void Solver::put_back(BodyStore& bodies, const Restraints& restraints) const {
  for (std::size_t n = 0; n < restraints.size(); ++n) {
    const Restraint& r = restraints[n];
    if (r.locks == Locks{} || bodies.info[r.id].place != Place::moving) continue;
    const std::size_t i = bodies.info[r.id].slot;
    for (const std::size_t k : {2 * i, 2 * i + 1}) {
      if (!(k == 2 * i ? r.locks.x : r.locks.y)) continue;
      bodies.disp[k] = k == 2 * i ? locked_at_[n].x : locked_at_[n].y;
      bodies.vel[k] = 0;
      if (!bodies.disp_remainder.empty()) bodies.disp_remainder[k] = 0;
    }
    if (!r.locks.angle || bodies.rim_speed.empty()) continue;
    bodies.angle[i] = locked_at_[n].angle;
    bodies.rim_speed[i] = 0;
  }
}

}  // namespace psim
