// Places and velocities after the drift.
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/elementary.h"
#include "joints/articulation_solve.h"

namespace psim {
namespace {

constexpr int kMostRounds = 4;   // the same after the drift
constexpr int kMostPasses = 4;   // over the places after the drift
constexpr double kSmall = 1e-7;  // m or rad: errors that stay
constexpr double kPush = 10;     // m/s: errors go out of the places no faster

}  // namespace

// Places after the drift: what joints miss is taken out of them, along the rows, but no faster than kPush.
bool Articulations::Solve::take_errors_out(double* angle) {
  double worst = 0;
  for_rows([&](Row& row, const Joint& j) {
    const double error = row.now.error;
    row.wanted = 0;
    if (row.use == Use::keep) row.wanted = -error;
    if (row.use == Use::pull) row.wanted = -greater(error, 0);
    if (row.state == State::low) row.wanted = greater(j.lower - error, 0);
    if (row.state == State::high) row.wanted = lesser(j.upper - error, 0);
    worst = greater(std::fabs(row.wanted), worst);
  });
  if (worst <= kSmall) return false;
  factorise(false, kSturdy);
  substitute();
  for_bodies([](Body& b) { b.start = b.now; });
  for_bodies([](Body& b) { b.now.velocity = {}, b.now.omega = 0; });
  push(false, [](const Row& row, const Joint&) { return row.wanted; });
  double most = 0;
  for_bodies([&](const Body& b) {
    most = greater(greater(length_of(b.now.velocity), std::fabs(b.now.omega) * b.radius), most);
  });
  const double share = most > kPush * h_ ? kPush * h_ / most : 1;
  for_bodies([&](Body& b) {
    const Vec2 way = share * b.now.velocity;
    const double turn = share * b.now.omega;
    b.now = b.start;
    if (b.inverse_mass == 0) return;
    gained_ -= dot(b.kick, way) / (h_ * b.inverse_mass);
    b.now.at = b.now.at + way;
    change(view_.disp, b.number, way);
    if (turn == 0) return;
    float& turned = view_.angle_change[b.number];
    change(turned, turn);
    const SineCosine q = sine_cosine(static_cast<double>(turned));
    view_.arm_change[2 * std::size_t{b.number}] = static_cast<float>(b.radius * (q.cosine - 1));
    view_.arm_change[2 * std::size_t{b.number} + 1] = static_cast<float>(b.radius * q.sine);
    angle[b.slot] += turn;
    b.now.angle += turn;
    b.now.turn = sine_cosine(b.now.angle);
  });
  return share == 1;
}

// Solves the equations of the matrix for what takes the speeds of errors away.
void Articulations::Solve::find_stopping() {
  for_rows([&](Row& row, const Joint& j) {
    const bool motor = row.use == Use::drive && row.state == State::bound;
    row.wanted = (motor ? j.motor_speed : 0) - speed(row.now, j);
    if (row.use == Use::spring) row.wanted -= row.softness * spring_rest(row, j);
  });
  substitute();
}

// Finds impulses along the rows of now that take the speeds of errors out of the velocities, with springs and with a share
// of what motors can. Ropes, limits and motors
// that would have to push the wrong way, or too much, give way in another round.
void Articulations::Solve::stop_errors(double share) {
  for (int round = 0;; ++round) {
    factorise(false, kAlike);
    find_stopping();
    if (round == kMostRounds) return;
    bool sound = true;
    for_rows([&](Row& row, const Joint& j) {
      const double l = row.wanted;
      const State before = row.state;
      if (row.use == Use::pull && row.on() && l > 0) row.state = State::free;
      if ((row.state == State::low && l < 0) || (row.state == State::high && l > 0)) row.state = State::free;
      const bool motor = row.use == Use::drive && row.state == State::bound;
      if (motor && std::fabs(row.impulse + l) > share * j.motor_most) {
        row.state = State::full;
        const double all = std::copysign(share * j.motor_most, row.impulse + l);
        push_row(row.now, j, all - row.impulse);
        row.impulse = all;
      }
      sound = sound && row.state == before;
    });
    if (sound) return;
  }
}

// The second halves of springs. They are done with then.
void Articulations::Solve::push_springs() {
  for_rows([&](Row& row, const Joint& j) {
    const bool works = row.use == Use::spring && row.on();
    row.wanted = works ? row.impulse : 0;
    const double from = row.start.error, to = row.now.error;
    if (works) gained_ += 0.5 * j.stiffness * (to + from) * (to - from) / all_.reach_;
    if (works) std::swap(row.start, row.now);
  });
  push_wanted();
  for_rows([](Row& row, const Joint&) {
    if (row.use != Use::spring || !row.on()) return;
    std::swap(row.start, row.now);
    row.state = State::free;
    row.impulse *= 2;
  });
}

// Ropes that are taut and drives that are at a limit may be stopped.
void Articulations::Solve::see_limits() {
  for_rows([&](Row& row, const Joint& j) {
    if (row.use == Use::pull && row.now.error > 0) row.state = State::bound;
    if (row.state == State::full) row.state = State::bound;
    if (row.use == Use::drive && row.now.error < j.lower) row.state = State::low;
    if (row.use == Use::drive && row.now.error > j.upper) row.state = State::high;
  });
}

void Articulations::Solve::finish(double* angle) {
  gained_ = island_.gained;
  for_bodies([&](Body& b) {
    load_motion(b);
    b.start = b.mark = b.now;
    if (!island_.refined || b.inverse_mass == 0) return;
    b.now.velocity = b.now.velocity + b.after;
    b.now.omega += b.after_omega;
  });
  find_rows_now();
  for_bodies([](Body& b) { b.idle = {}, b.idle_omega = 0; });
  push_springs();
  see_limits();
  for (int pass = 0; pass < kMostPasses && take_errors_out(angle); ++pass) find_rows_now();
  stop_errors(1);
  push_wanted();
  for_rows([](Row& row, const Joint&) { row.impulse += row.wanted; });
  if (!island_.refined) end_springs();
  settle();
  store_velocities();
  for_joints([&](Joint& j) {
    for (std::uint32_t k = 0; k < j.geometry.rows(); ++k) {
      const Row& row = all_.rows_[j.first_row + k];
      const bool motor = row.use == Use::drive && row.state != State::low && row.state != State::high;
      j.impulse[k] = motor ? 0.0f : static_cast<float>(row.impulse);
      if (row.use == Use::drive) j.impulse[3] = motor ? static_cast<float>(row.impulse) : 0.0f;
    }
  });
}

}  // namespace psim
