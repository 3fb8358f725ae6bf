// The passes over articulations (docs/joints.md): RATTLE (Andersen 1983) with Newton steps, all in double precision.
#include <algorithm>
#include <cmath>

#include "joints/articulations.h"

namespace psim {
namespace {

constexpr int kMostSteps = 6;        // Newton steps in a substep
constexpr int kMostChoices = 5;      // in how many of them limits may begin and cease to hold
constexpr int kMostRounds = 4;       // the same after the drift
constexpr double kExact = 3e-8;      // m or rad: an error below this is none
constexpr double kMostError = 1e6;   // m or rad: beyond it steps lead nowhere
constexpr double kConverged = 1e-6;  // m or rad: where Newton's steps miss by more, speeds alone are stopped
constexpr int kMostPasses = 4;       // over the places after the drift
constexpr double kSmall = 1e-7;      // m or rad: errors that stay
constexpr double kPush = 10;         // m/s: errors go out of the places no faster
constexpr double kAlike = 1e-9;      // softness, of a row's own: rows that ask for the same share their impulse
constexpr double kSturdy = 1e-3;     // the same where steps must not lead far: in rows that hardly move anybody
constexpr double kMostGain = 0.3;  // of the energy: what rows of the start may add that those after the drift take back
constexpr double kCalm = 0.02;     // m/s: mean speed below which a motion is damped where bodies may sleep
constexpr double kCalming = 2;     // 1/s: by how much of its energy, at rest
constexpr double kCredit = 2;      // how much less than nothing an account may hold, of the energy of turning rows
constexpr double kMostTaken = 0.5;  // of the energy: what an account takes back in a substep

Vec2 load(const float* records, std::size_t n) {
  return {static_cast<double>(records[2 * n]), static_cast<double>(records[2 * n + 1])};
}
void change(float& to, double v) { to = static_cast<float>(static_cast<double>(to) + v); }
void change(float* records, std::size_t n, Vec2 v) {
  change(records[2 * n], v.x);
  change(records[2 * n + 1], v.y);
}

}  // namespace

// What is done to one articulation in a substep.
class Articulations::Solve {
 public:
  Solve(Articulations& all, Island& island, const kernels::BodyView& view)
      : all_(all), island_(island), view_(view), h_(all.h_) {}

  void solve(double drift, double smooth_limit2);
  void finish(double* angle);

 private:
  template <class Each>
  void for_rows(const Each& each) {
    for (std::uint32_t r = island_.rows.begin; r < island_.rows.end; ++r) {
      Row& row = all_.rows_[r];
      each(row, all_.joints_[row.joint]);
    }
  }
  template <class Each>
  void for_bodies(const Each& each) {
    for (std::uint32_t b = island_.bodies.begin; b < island_.bodies.end; ++b) each(all_.bodies_[b]);
  }
  template <class Each>
  void for_joints(const Each& each) {
    for (std::uint32_t n = island_.joints.begin; n < island_.joints.end; ++n) each(all_.joints_[n]);
  }
  const Body& side(const Joint& j, int side) const { return all_.bodies_[j.body[side]]; }
  double speed(const JointRow& row, const Joint& j) const { return row.speed(side(j, 0).now, side(j, 1).now); }

  void load_motion(Body& b) const;
  void load_rows();
  void find_rows_now();
  bool choose(Row& row, const Joint& j) const;
  double residual(const Row& row, const Joint& j) const;
  double couple(const JointRow& a, const JointRow& b, const Joint& j, std::uint8_t shared) const;
  void assemble(bool across, double softness);
  void eliminate();
  void substitute();
  void push_row(const JointRow& along, const Joint& j, double l);
  template <class Impulse>
  void push(bool at_start, const Impulse& impulse);
  void move_on(double drift);
  struct Change {
    double square = 0, slope = 0;  // J
  };
  double begin_impulses(const JointedMotion& common);
  Change from_tangent(const JointedMotion& common);
  void stay_within(const JointedMotion& common);
  bool find_impulses(double drift, bool exact);
  void store_velocities();
  bool take_errors_out(double* angle);
  void stop_errors(double share);
  void settle();
  double softened();
  JointedMotion common_motion();
  JointedMotion moving_with();
  double energy_within(const JointedMotion& common, bool without_kick = false);
  static JointedMotion against(const Body& b, const JointedMotion& common);
  double half_work();
  void push_wanted();
  static JointedMotion without_kick(const Body& b) {
    return {.velocity = b.now.velocity - b.idle, .omega = b.now.omega - b.idle_omega};
  }

  Articulations& all_;
  Island& island_;
  const kernels::BodyView& view_;
  const double h_;
  double reach_ = 1;   // how far a change of velocity leads in the drift, of h
  double gained_ = 0;  // J: since the substep began
};

void Articulations::Solve::load_motion(Body& b) const {
  const std::size_t n = b.number;
  b.now.at = load(view_.disp, n);
  b.now.angle = b.angle + static_cast<double>(view_.angle_change[n]);
  b.now.turn = sine_cosine(b.now.angle);
  b.now.velocity = load(view_.vel, n);
  b.now.omega = static_cast<double>(view_.rim_speed[n]) / b.radius;
}

// Rows at the start. Ropes that pulled and drives that stood at a limit are taken to do so again.
void Articulations::Solve::load_rows() {
  find_rows_now();
  for_rows([&](Row& row, const Joint& j) {
    row.start = row.now;
    row.softness = row.use == Use::spring && j.drag > 0 ? 1 / j.drag : 0;
    const float before = j.impulse[&row - &all_.rows_[j.first_row]];
    row.state = State::bound;
    if (row.use == Use::pull && !(before < 0)) row.state = State::free;
    if (row.use == Use::spring && !(j.drag > 0)) row.state = State::free;
    if (row.use == Use::drive) {
      row.state = before > 0 ? State::low : before < 0 ? State::high : j.motor_most > 0 ? State::bound : State::free;
    }
  });
}

void Articulations::Solve::find_rows_now() {
  for_joints([&](Joint& j) {
    JointRow found[3];
    find_rows(j.geometry, side(j, 0).now, side(j, 1).now, found);
    for (std::uint32_t k = 0; k < j.geometry.rows(); ++k) all_.rows_[j.first_row + k].now = found[k];
  });
}

// Ropes pull or hang loose; a drive stands at a limit, or its motor runs. True if that changes. Nobody is brought back
// who was beyond a limit already.
bool Articulations::Solve::choose(Row& row, const Joint& j) const {
  const State before = row.state;
  const double error = row.now.error;
  if (row.use == Use::pull) {
    if (row.on() && row.impulse > 0) row.state = State::free;
    if (!row.on() && error > std::fmax(row.start.error, 0) + kExact) row.state = State::bound;
  } else if (row.use == Use::drive) {
    const State motor = j.motor_most > 0 ? State::bound : State::free;
    const double ahead = error - row.start.error - h_ * j.motor_speed;
    if (error < std::fmin(j.lower, row.start.error) - kExact) {
      row.state = State::low;
      row.impulse = std::fmax(row.impulse, 0);
    } else if (error > std::fmax(j.upper, row.start.error) + kExact) {
      row.state = State::high;
      row.impulse = std::fmin(row.impulse, 0);
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
  if (row.use == Use::pull) return to - std::fmax(from, 0);
  if (row.use == Use::spring) return (to - from) + h_ * row.softness * (0.5 * j.push * from + row.impulse);
  if (row.use == Use::drive) {
    if (row.state == State::low) return to - std::fmin(j.lower, from);
    if (row.state == State::high) return to - std::fmax(j.upper, from);
    return to - from - h_ * j.motor_speed;
  }
  return to - from;
}

// What an impulse along b changes in the speed of a. `shared`: bit 2 i + k if body i of a's joint, which is j, is body k
// of b's.
double Articulations::Solve::couple(const JointRow& a, const JointRow& b, const Joint& j, std::uint8_t shared) const {
  double sum = 0;
  for (const int i : {0, 1}) {
    const Body& body = side(j, i);
    const double arm = i == 0 ? a.arm_a : a.arm_b;
    for (const int k : {0, 1}) {
      if ((shared >> (2 * i + k) & 1) == 0) continue;
      const double both =
          reach_ * body.inverse_mass * dot(a.n, b.n) + body.inverse_inertia * arm * (k == 0 ? b.arm_a : b.arm_b);
      sum += i == k ? both : -both;
    }
  }
  return sum;
}

// The matrix of the rows that are on: what impulses along the rows of the start, or of now, change in the rows of now.
void Articulations::Solve::assemble(bool across, double softness) {
  constexpr std::uint8_t kOwn = 0b1001;
  const auto right = [across](const Row& row) -> const JointRow& { return across ? row.start : row.now; };
  for_rows([&](Row& row, const Joint& j) {
    const double own = couple(row.now, right(row), j, kOwn);
    row.inverse = couple(right(row), right(row), j, kOwn) * (1 + softness) + row.softness;
    row.diagonal = row.on() ? own + softness * row.inverse + row.softness : 1;
    for (std::uint32_t e = row.entries.begin; e < row.entries.end; ++e) {
      const Row& other = all_.rows_[all_.columns_[e]];
      const std::uint8_t shared = all_.couplings_[e];
      const bool any = row.on() && other.on() && shared != 0;
      all_.upper_[e] = any ? couple(row.now, right(other), j, shared) : 0;
      all_.lower_[e] = any ? couple(right(row), other.now, j, shared) : 0;
    }
  });
}

// Gauss without pivoting: the matrix is symmetric and positive, or near to such a one. Of a pivot that is not, the
// row's own mass is left.
void Articulations::Solve::eliminate() {
  double* const upper = all_.upper_.data();
  double* const lower = all_.lower_.data();
  const std::uint32_t* const columns = all_.columns_.data();
  for_rows([&](Row& row, const Joint&) {
    constexpr double kSound = 0.25 * kAlike;
    const bool sound = std::fabs(row.diagonal) > kSound * row.inverse;
    row.inverse = row.on() ? 1 / (sound ? row.diagonal : row.inverse) : 1;
    const std::uint32_t* target = all_.targets_.data() + row.first_target;
    const std::uint32_t end = row.entries.end;
    for (std::uint32_t e = row.entries.begin; e < end; ++e) lower[e] *= row.inverse;
    for (std::uint32_t e = row.entries.begin; e < end; ++e) {
      all_.rows_[columns[e]].diagonal -= lower[e] * upper[e];
      for (std::uint32_t f = e + 1; f < end; ++f, ++target) {
        upper[*target] -= lower[e] * upper[f];
        lower[*target] -= lower[f] * upper[e];
      }
    }
  });
}

// Solves for `wanted`.
void Articulations::Solve::substitute() {
  std::vector<Row>& rows = all_.rows_;
  for_rows([&](Row& row, const Joint&) {
    if (!row.on()) row.wanted = 0;
    for (std::uint32_t e = row.entries.begin; e < row.entries.end; ++e) {
      rows[all_.columns_[e]].wanted -= all_.lower_[e] * row.wanted;
    }
  });
  for (std::uint32_t r = island_.rows.end; r-- > island_.rows.begin;) {
    Row& row = rows[r];
    double sum = row.wanted;
    for (std::uint32_t e = row.entries.begin; e < row.entries.end; ++e)
      sum -= all_.upper_[e] * rows[all_.columns_[e]].wanted;
    row.wanted = row.on() ? sum * row.inverse : 0;
  }
}

// Adds the impulse l to the velocities of now.
void Articulations::Solve::push_row(const JointRow& along, const Joint& j, double l) {
  Body& a = all_.bodies_[j.body[0]];
  Body& b = all_.bodies_[j.body[1]];
  a.now.velocity = a.now.velocity - a.inverse_mass * l * along.n;
  a.now.omega -= a.inverse_inertia * l * along.arm_a;
  b.now.velocity = b.now.velocity + b.inverse_mass * l * along.n;
  b.now.omega += b.inverse_inertia * l * along.arm_b;
}

// Adds the impulses impulse(row, joint).
template <class Impulse>
void Articulations::Solve::push(bool at_start, const Impulse& impulse) {
  for_rows([&](Row& row, const Joint& j) {
    const double l = impulse(row, j);
    if (l != 0) push_row(at_start ? row.start : row.now, j, l);
  });
}

// From the start with the velocities of now.
void Articulations::Solve::move_on(double drift) {
  for_bodies([&](Body& b) {
    b.now.at = b.start.at + drift * b.now.velocity;
    b.now.angle = b.start.angle + h_ * b.now.omega;
    b.now.turn = sine_cosine(b.now.angle);
  });
}

// What joints did changes the velocity before the kick as well: the drift goes with all of it, and the next kick does
// not repeat it.
void Articulations::Solve::store_velocities() {
  for_bodies([&](Body& b) {
    if (b.inverse_mass == 0) return;
    const Vec2 gain = b.now.velocity - b.start.velocity;
    const double turn = (b.now.omega - b.start.omega) * b.radius;
    change(view_.vel, b.number, gain);
    change(view_.vel0, b.number, gain);
    change(view_.rim_speed[b.number], turn);
    change(view_.rim_speed0[b.number], turn);
  });
}

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
    if (!changed) least = std::fmin(least, worst);
    assemble(exact, exact ? kAlike : kSturdy);
    eliminate();
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

void Articulations::Solve::solve(double drift, double smooth_limit2) {
  reach_ = drift / h_;
  for_bodies([&](Body& b) {
    load_motion(b);
    const Vec2 acceleration = view_.acc != nullptr ? load(view_.acc, b.number) : Vec2{};
    b.kick = b.now.velocity - load(view_.vel0, b.number);
    b.idle_omega = 0.5 * (b.now.omega - static_cast<double>(view_.rim_speed0[b.number]) / b.radius);
    const bool smooth = dot(b.kick, b.kick) <= smooth_limit2 + 4 * drift * drift * dot(acceleration, acceleration);
    b.idle = 0.5 * b.kick;
    if (smooth) b.now.velocity = b.now.velocity - b.idle;
    b.start = b.now;
  });
  load_rows();
  const JointedMotion common = moving_with();
  const double before = energy_within(common, true), allowed = begin_impulses(common);
  gained_ = 0;
  bool found = find_impulses(drift, true);
  // The equations have other roots, far away.
  island_.apart = from_tangent(common).square;
  found = found && island_.apart <= kMostGain * allowed;
  if (found) {
    for_bodies([](Body& b) { b.now = b.start; });
    for_rows([](Row& row, const Joint&) { row.wanted = row.impulse, row.now = row.start; });
    push_wanted();
  } else {
    find_impulses(drift, false);
    stay_within(common);
    island_.apart = 0;
    gained_ = energy_within(common, true) - before;
  }
  store_velocities();
  island_.gained = gained_;
}

// Places after the drift: what joints miss is taken out of them, along the rows, but no faster than kPush.
bool Articulations::Solve::take_errors_out(double* angle) {
  double worst = 0;
  for_rows([&](Row& row, const Joint& j) {
    const double error = row.now.error;
    row.wanted = 0;
    if (row.use == Use::keep) row.wanted = -error;
    if (row.use == Use::pull) row.wanted = -std::fmax(error, 0);
    if (row.state == State::low) row.wanted = std::fmax(j.lower - error, 0);
    if (row.state == State::high) row.wanted = std::fmin(j.upper - error, 0);
    worst = std::fmax(worst, std::fabs(row.wanted));
  });
  if (worst <= kSmall) return false;
  assemble(false, kSturdy);
  eliminate();
  substitute();
  for_bodies([](Body& b) { b.start = b.now; });
  for_bodies([](Body& b) { b.now.velocity = {}, b.now.omega = 0; });
  push(false, [](const Row& row, const Joint&) { return row.wanted; });
  double most = 0;
  for_bodies([&](const Body& b) {
    most = std::fmax(most, std::fmax(length_of(b.now.velocity), std::fabs(b.now.omega) * b.radius));
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

// Finds impulses along the rows of now that take the speeds of errors out of the velocities, with springs and with a share
// of what motors can. Ropes, limits and motors
// that would have to push the wrong way, or too much, give way in another round.
void Articulations::Solve::stop_errors(double share) {
  for (int round = 0;; ++round) {
    assemble(false, kAlike);
    eliminate();
    for_rows([&](Row& row, const Joint& j) {
      const bool motor = row.use == Use::drive && row.state == State::bound;
      row.wanted = (motor ? j.motor_speed : 0) - speed(row.now, j);
      if (row.use == Use::spring) row.wanted -= 0.5 * row.softness * j.push * row.now.error;
    });
    substitute();
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

void Articulations::Solve::finish(double* angle) {
  gained_ = island_.gained;
  for_bodies([&](Body& b) {
    load_motion(b);
    b.start = b.now;
  });
  find_rows_now();
  for_bodies([](Body& b) { b.idle = {}, b.idle_omega = 0; });
  const auto works = [](const Row& row) { return row.use == Use::spring && row.on(); };
  for_rows([&](Row& row, const Joint& j) {
    row.wanted = works(row) ? row.impulse : 0;
    const double from = row.start.error, to = row.now.error;
    if (works(row)) gained_ += 0.5 * j.stiffness * (to + from) * (to - from);
  });
  push_wanted();
  store_velocities();
  for_rows([&](Row& row, const Joint&) {
    if (!works(row)) return;
    row.state = State::free;
    row.impulse *= 2;
  });
  for_bodies([](Body& b) { b.start.velocity = b.now.velocity, b.start.omega = b.now.omega; });
  for_rows([&](Row& row, const Joint& j) {
    if (row.use == Use::pull && row.now.error > 0) row.state = State::bound;
    if (row.state == State::full) row.state = State::bound;
    if (row.use == Use::drive && row.now.error < j.lower) row.state = State::low;
    if (row.use == Use::drive && row.now.error > j.upper) row.state = State::high;
  });
  for (int pass = 0; pass < kMostPasses && take_errors_out(angle); ++pass) find_rows_now();
  stop_errors(1);
  push_wanted();
  for_rows([](Row& row, const Joint&) { row.impulse += row.wanted; });
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

// Joints give no energy, though in steps they seem to, now more, now less. Once they gave more than they took since the
// first step, what they gave goes out of the motion of the bodies against each other, or against what holds them.
void Articulations::Solve::settle() {
  double gain = 0;
  for_joints([&](const Joint& j) { gain += static_cast<double>(*j.gain); });
  float& account = *all_.joints_[island_.joints.begin].gain;
  change(account, gained_);
  gain += gained_;
  const double least = -kCredit * island_.apart - softened();
  if (gain < least) {  // what an impact took
    change(account, least - gain);
    gain = least;
  }
  if (!(gain > 0) && !all_.calm_) return;
  const JointedMotion common = common_motion();
  const double energy = energy_within(common);
  if (!(energy > 0)) return;
  double taken = std::fmax(std::fmin(gain, kMostTaken * energy), 0);
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

// How far the energy of springs swings within a period, for steps have their frequency with another stiffness.
double Articulations::Solve::softened() {
  double sum = 0;
  for_rows([&](const Row& row, const Joint& j) {
    if (row.use == Use::spring) sum += std::fabs(j.push / h_ - j.stiffness) * row.now.error * row.now.error;
  });
  return sum;
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
      if (j.geometry.kind == JointKind::weld && k == 2 && j.drag > 0) use = Use::spring;
      const bool driven = j.geometry.kind == JointKind::driven || j.geometry.kind == JointKind::slide;
      if (driven && k == 2 && j.lower != j.upper) use = Use::drive;
    }
  }
}

void Articulations::solve(const kernels::BodyView& view, double drift, double smooth_limit2, WorkerPool& pool) {
  pool.run(islands_.size(), [&](std::size_t n) { Solve(*this, islands_[n], view).solve(drift, smooth_limit2); });
}

void Articulations::finish(const kernels::BodyView& view, double* angle, WorkerPool& pool) {
  pool.run(islands_.size(), [&](std::size_t n) { Solve(*this, islands_[n], view).finish(angle); });
}

}  // namespace psim
