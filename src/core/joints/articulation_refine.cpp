// Where a substep does not resolve how the rows of an articulation turn, the articulation goes through it in several steps
// of its own, each of them as the substep would be.
#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "joints/articulation_solve.h"

namespace psim {
namespace {

constexpr std::uint32_t kFinest = 4096;   // of the shortest step: the substep has so many
constexpr std::uint32_t kMostTries = 96;  // steps that are tried in a substep, and
constexpr std::uint32_t kPatience = 8;    // tries after which twice as much will do
constexpr double kFine = 2e-5;            // as kResolved, of these steps
constexpr double kMostRowTries = 2048;    // these times rows in a frame of 1/60 s, however many substeps it has,
constexpr double kFewestRowTries = 1280;  // but no fewer than so many in a substep: no frame shall take long

// Behind a step that ends at `at`: steps grow again where they began to be halved.
void grow(std::uint32_t at, std::uint32_t& size) {
  if (size < kFinest / 2 && at % (2 * size) == 0) size *= 2;
}

// The fewest steps to the end of the substep.
std::uint32_t fewest_steps(std::uint32_t at, std::uint32_t size) {
  std::uint32_t steps = 0;
  for (; at < kFinest; ++steps) grow(at += size, size);
  return steps;
}

}  // namespace

// Springs and motors for steps of h seconds, which are `share` of those before.
void Articulations::Solve::set_length(double h, double share) {
  h_ = h;
  for_joints([&](Joint& j) {
    if (j.mass > 0) j.set_spring(h);
    j.motor_most = lesser(j.motor_most * share, 1e30);
  });
}

// A step from velocities that keep to the rows to such ones, for a share of the substep. `most`: as kResolved. If it
// fails, all is as it was.
bool Articulations::Solve::step_alone(double drift, double share, double most) {
  const double gained = gained_, h = h_;
  set_length(share * h, share);
  for_bodies([&](Body& b) {
    b.mark = b.now;
    b.idle = 0.5 * share * b.pull;
    b.now.velocity = b.now.velocity + b.idle;
    b.start = b.now;
  });
  find_rows_now();
  for_rows([](Row& row, const Joint& j) {
    row.start = row.now;
    if (row.use == Use::spring && j.spring.drag > 0) row.state = State::bound;
    if (row.use == Use::spring) row.softness = j.spring.drag > 0 ? 1 / j.spring.drag : 0;
    row.mark = row.state;
  });
  begin_springs();
  const JointedMotion common = moving_with();
  const double energy = begin_impulses(common);
  const bool found = find_impulses(share * drift, true) && from_tangent(common).square <= most * energy;
  if (!found) {
    for_bodies([](Body& b) { b.now = b.mark; });
    for_rows([](Row& row, const Joint&) { row.state = row.mark; });
    gained_ = gained;
    set_length(h, 1 / share);
    return false;
  }
  go_along_start();
  move_on(share * drift);
  find_rows_now();
  for_bodies([](Body& b) {
    b.now.velocity = b.now.velocity + b.idle;
    b.idle = {};
  });
  push_springs();
  see_limits();
  stop_errors(1);
  push_wanted();
  for_rows([](Row& row, const Joint&) { row.sum += row.impulse + row.wanted; });
  end_springs();
  set_length(h, 1 / share);
  return true;
}

// An articulation of many rows may try fewer steps in a substep than one of few.
std::uint32_t Articulations::Solve::most_tries() const {
  const double most = greater(kMostRowTries * 60 * all_.h_, kFewestRowTries) / (island_.rows.end - island_.rows.begin);
  return static_cast<std::uint32_t>(lesser(most, kMostTries));
}

// Goes through the substep in steps that are halved where they do not resolve the motion.
bool Articulations::Solve::step_on(double drift) {
  for_bodies([](Body& b) {
    b.now = b.begin;
    b.now.velocity = b.now.velocity - b.pull;
    b.idle_omega = 0;
  });
  for_rows([](Row& row, const Joint&) { row.sum = 0; });
  gained_ = 0;
  const std::uint32_t most_tries = this->most_tries();
  std::uint32_t size = kFinest / 2, tries = 0;
  double most = kFine;
  for (std::uint32_t at = 0; at < kFinest;) {
    if (tries + fewest_steps(at, size) > most_tries) return false;
    ++tries;
    if (tries % kPatience == 0) most = std::min(2 * most, kMostGain);
    if (step_alone(drift, static_cast<double>(size) / kFinest, size > 1 ? most : kMostGain)) {
      grow(at += size, size);
    } else if (size == 1) {
      return false;
    } else {
      size /= 2;
    }
  }
  return true;
}

// The drift shall lead to where these steps end. `after`: by how much the velocities there differ from what the drift and
// the other half of the kick leave.
bool Articulations::Solve::refine(double drift) {
  const bool found = step_on(drift);
  if (!found) return false;
  for_bodies([&](Body& b) {
    const JointedMotion end = b.now;
    b.now = b.begin;
    b.now.velocity = (1 / drift) * (end.at - b.begin.at);
    b.now.omega = (end.angle - b.begin.angle) / h_;
    b.after = end.velocity - b.now.velocity - 0.5 * b.pull;
    b.after_omega = end.omega - b.now.omega;
  });
  for_rows([](Row& row, const Joint&) { row.impulse = row.sum; });
  return true;
}

}  // namespace psim
