// Bodies and rows of an articulation as they are, and the equations between impulses and the errors of rows.
#include <cmath>

#include "joints/articulation_solve.h"

namespace psim {

void Articulations::Solve::load_motion(Body& b) const {
  const std::size_t n = b.number;
  b.now.at = load_record(view_.disp, n);
  b.now.angle = b.angle + static_cast<double>(view_.angle_change[n]);
  b.now.turn = sine_cosine(b.now.angle);
  b.now.velocity = load_record(view_.vel, n);
  b.now.omega = static_cast<double>(view_.rim_speed[n]) / b.radius;
}

// Rows at the start. Ropes that pulled and drives that stood at a limit are taken to do so again.
void Articulations::Solve::load_rows() {
  find_rows_now();
  for_rows([&](Row& row, const Joint& j) {
    row.start = row.now;
    row.softness = row.use == Use::spring && j.spring.drag > 0 ? 1 / j.spring.drag : 0;
    const float before = j.impulse[&row - &all_.rows_[j.first_row]];
    row.state = State::bound;
    if (row.use == Use::pull && !(before < 0)) row.state = State::free;
    if (row.use == Use::spring && !(j.spring.drag > 0)) row.state = State::free;
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

// How fast the error of a row changes in the drift.
double Articulations::Solve::speed(const JointRow& row, const Joint& j) const {
  JointedMotion a = side(j, 0).now, b = side(j, 1).now;
  a.velocity = reach_ * a.velocity;
  b.velocity = reach_ * b.velocity;
  return row.speed(a, b);
}

// Returns by how much a unit of impulse along row b changes the speed of row a. `ends`: of the two bodies of a's joint.
// `shared`: bit 2 i + k is set if body i of a's joint is body k of b's.
double Articulations::Solve::couple(const JointRow& a, const JointRow& b, const Ends& ends, std::uint8_t shared) {
  const double along = dot(a.n, b.n);
  double sum = 0;
  if ((shared & 1) != 0) sum += ends.linear[0] * along + ends.turning[0] * a.arm_a * b.arm_a;
  if ((shared & 2) != 0) sum -= ends.linear[0] * along + ends.turning[0] * a.arm_a * b.arm_b;
  if ((shared & 4) != 0) sum -= ends.linear[1] * along + ends.turning[1] * a.arm_b * b.arm_a;
  if ((shared & 8) != 0) sum += ends.linear[1] * along + ends.turning[1] * a.arm_b * b.arm_b;
  return sum;
}

// The matrix of the rows that are on: what impulses along the rows of the start (`across`), or of now, change in the rows
// of now.
void Articulations::Solve::assemble(bool across, double softness) {
  constexpr std::uint8_t kOwn = 0b1001;
  const auto right = [across](const Row& row) -> const JointRow& { return across ? row.start : row.now; };
  for_rows([&](Row& row, const Joint& j) {
    Ends ends;
    for (const int i : {0, 1}) {
      ends.linear[i] = reach_ * side(j, i).inverse_mass;
      ends.turning[i] = side(j, i).inverse_inertia;
    }
    const double own = couple(row.now, right(row), ends, kOwn);
    row.inverse = (across ? couple(row.start, row.start, ends, kOwn) : own) * (1 + softness) + row.softness;
    row.diagonal = row.on() ? own + softness * row.inverse + row.softness : 1;
    for (std::uint32_t e = row.entries.begin; e < row.entries.end; ++e) {
      const Row& other = all_.rows_[all_.columns_[e]];
      const std::uint8_t shared = all_.couplings_[e];
      const bool any = row.on() && other.on() && shared != 0;
      all_.upper_[e] = any ? couple(row.now, right(other), ends, shared) : 0;
      all_.lower_[e] = any && across ? couple(row.start, other.now, ends, shared) : all_.upper_[e];
    }
  });
}

void Articulations::Solve::factorise(bool across, double softness) {
  assemble(across, softness);
  eliminate();
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
    const Vec2 gain = b.now.velocity - b.mark.velocity;
    const double turn = (b.now.omega - b.mark.omega) * b.radius;
    change(view_.vel, b.number, gain);
    change(view_.vel0, b.number, gain);
    change(view_.rim_speed[b.number], turn);
    change(view_.rim_speed0[b.number], turn);
  });
}

}  // namespace psim
