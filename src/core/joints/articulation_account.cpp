// The energy of articulations: joints give none.
#include <algorithm>
#include <cmath>

#include "base/elementary.h"
#include "joints/articulation_solve.h"

namespace psim {
namespace {

constexpr double kCalm = 0.02;        // m/s: mean speed below which a motion is damped where bodies may sleep
constexpr double kCalming = 2;        // 1/s: by how much of its energy, at rest
constexpr double kCredit = 2;         // how much less than nothing an account may hold, of the energy of turning rows
constexpr double kMostCredit = 8e-4;  // the same, of the energy of the motion
constexpr double kMostTaken = 0.5;    // of the energy: what an account takes back in a substep

}  // namespace

// Half of the work that the impulses `wanted` do at the velocities of now, without the kick: called before and after they
// are pushed, it adds up to their work. Motors may work.
double Articulations::Solve::half_work() {
  double sum = 0;
  for_rows([&](const Row& row, const Joint& j) {
    if (row.use == Use::drive && row.state != State::low && row.state != State::high) return;
    const Body &a = side(j, 0), &b = side(j, 1);
    sum += 0.5 * row.wanted * row.now.speed(without_kick(a), without_kick(b));
  });
  return sum;
}

// Adds the impulses `wanted` along the rows of now.
void Articulations::Solve::push_wanted() {
  gained_ += half_work();
  push(false, [](const Row& row, const Joint&) { return row.wanted; });
  gained_ += half_work();
}

// Joints give no energy, though in steps they seem to, now more, now less. Once they gave more than they took since the
// first step, what they gave goes out of the motion of the bodies against each other, or against what holds them.
void Articulations::Solve::settle() {
  double gain = 0;
  for_joints([&](const Joint& j) { gain += static_cast<double>(*j.gain); });
  float& account = *all_.joints_[island_.joints.begin].gain;
  change(account, gained_);
  gain += gained_;
  double noise = 0;  // J: as far as places are exact
  for_rows([&](const Row& row, const Joint&) { noise += std::fabs(row.impulse) * kExact / h_; });
  const double credit = lesser(kCredit * island_.apart, kMostCredit * energy_within(moving_with()));
  const double least = -credit - noise;
  if (gain < least) {  // what an impact took
    change(account, least - gain);
    gain = least;
  }
  if (!(gain > noise) && !all_.calm_) return;
  const JointedMotion common = common_motion();
  const double energy = energy_within(common);
  if (!(energy > 0)) return;
  double taken = gain > noise ? lesser(gain, kMostTaken * energy) : 0;
  change(account, -taken);
  if (all_.calm_) {
    double mass = 0;
    for_bodies([&](const Body& b) { mass += b.inverse_mass > 0 ? 1 / b.inverse_mass : 0; });
    const double calm = 0.5 * mass * kCalm * kCalm;
    if (energy < calm) taken += (energy - taken) * h_ * kCalming * (1 - energy / calm);
  }
  if (taken == 0) return;
  const double less = 1 - std::sqrt(1 - taken / energy);
  for_bodies([&](Body& b) {
    if (b.inverse_mass == 0) return;
    const JointedMotion own = against(b, common);
    b.now.velocity = b.now.velocity - less * own.velocity;
    if (b.inverse_inertia > 0) b.now.omega -= less * own.omega;
  });
}

// The same without turning.
JointedMotion Articulations::Solve::moving_with() {
  JointedMotion common = common_motion();
  common.omega = 0;
  return common;
}

// The kinetic energy of the bodies against a common motion. `without_kick`: less what the account leaves out.
double Articulations::Solve::energy_within(const JointedMotion& common, bool without_kick) {
  double energy = 0;
  for_bodies([&](const Body& b) {
    if (b.inverse_mass == 0) return;
    JointedMotion own = against(b, common);
    if (without_kick) {
      own.velocity = own.velocity - b.idle;
      own.omega -= b.idle_omega;
    }
    energy += 0.5 * dot(own.velocity, own.velocity) / b.inverse_mass;
    if (b.inverse_inertia > 0) energy += 0.5 * own.omega * own.omega / b.inverse_inertia;
  });
  return energy;
}

JointedMotion Articulations::Solve::against(const Body& b, const JointedMotion& common) {
  const Vec2 arm = b.place + b.now.at - common.at;
  return {.velocity = b.now.velocity - common.velocity - common.omega * Vec2{-arm.y, arm.x},
          .omega = b.now.omega - common.omega};
}

// How the bodies move as one: as what holds them, or as momentum and angular momentum tell. `at`: the centre of mass.
JointedMotion Articulations::Solve::common_motion() {
  if (island_.held != kNone) return {.velocity = all_.bodies_[island_.held].now.velocity};
  double mass = 0;
  JointedMotion all;
  for_bodies([&](const Body& b) {
    const double m = 1 / b.inverse_mass;
    mass += m;
    all.at = all.at + m * (b.place + b.now.at);
    all.velocity = all.velocity + m * b.now.velocity;
  });
  all.at = (1 / mass) * all.at;
  all.velocity = (1 / mass) * all.velocity;
  double spin = 0, inertia = 0;
  for_bodies([&](const Body& b) {
    const double m = 1 / b.inverse_mass, own = b.inverse_inertia > 0 ? 1 / b.inverse_inertia : 0;
    const Vec2 arm = b.place + b.now.at - all.at;
    spin += m * cross(arm, b.now.velocity - all.velocity) + own * b.now.omega;
    inertia += m * dot(arm, arm) + own;
  });
  all.omega = inertia > 0 ? spin / inertia : 0;
  return all;
}

}  // namespace psim
