// Springs in the steps of articulations (docs/joints.md, Springs).
#include <cmath>
#include <utility>

#include "base/elementary.h"
#include "joints/articulation_solve.h"

namespace psim {

// The rows of springs in the middle of the way that the step has come so far.
void Articulations::Solve::find_middle_rows() {
  for_rows([&](Row& row, const Joint& j) {
    if (row.use != Use::spring) return;
    const Body &a = side(j, 0), &b = side(j, 1);
    find_middle(j.geometry, a.start, b.start, a.now, b.now, row.start);
  });
}

// The speed of a row before the kick of the step.
double Articulations::Solve::speed_before(const JointRow& row, const Joint& j) const {
  const double share = 0.5 * h_ / all_.h_;
  JointedMotion a = side(j, 0).start, b = side(j, 1).start;
  a.velocity = a.velocity - share * side(j, 0).pull;
  b.velocity = b.velocity - share * side(j, 1).pull;
  return row.speed(a, b);
}

// Half of the impulse that a spring takes from a step that does not move it, N s, turned round; and what its lighter mass
// asks for because the row turns, so that the work is lighter (u'^2 - u^2) / 2.
double Articulations::Solve::spring_rest(const Row& row, const Joint& j) const {
  const double before = speed_before(row.start, j), mean = speed(row.start, j);
  const double after = 2 * speed(row.now, j) - speed_before(row.now, j), sum = 0.5 * (row.before + after);
  const double share = mean * sum > 0 ? lesser(sum / mean, 1.5) : 0;
  const double turned = share * (after - row.before) - 2 * (mean - before);
  return 0.5 * (j.spring.push * row.start.error + j.spring.lag * before - j.spring.lighter * turned);
}

// Steps are taken with the velocities u of lighter springs: M v = (M - N light N^T) u, with N the rows of springs. From v
// to u, where the other rows hold: q = light N^T u is the impulse.
void Articulations::Solve::begin_springs() {
  constexpr double kLeast = 1e-30;
  const auto each_spring = [&](const auto& each) {
    for_rows([&](Row& row, const Joint& j) {
      if (row.use == Use::spring && row.on()) each(row, j);
    });
  };
  bool any = false;
  each_spring([&](Row&, const Joint& j) { any = any || j.spring.light > 0; });
  if (!any) return;
  const double reach = std::exchange(reach_, 1);
  each_spring([](Row& row, const Joint& j) { row.softness = -1 / greater(j.spring.light, kLeast); });
  factorise(false, kAlike);
  for_rows([&](Row& row, const Joint& j) { row.wanted = row.use == Use::spring ? -speed_before(row.now, j) : 0; });
  substitute();
  push_wanted();
  reach_ = reach;
  for_bodies([](Body& b) { b.start.velocity = b.now.velocity, b.start.omega = b.now.omega; });
  each_spring([&](Row& row, const Joint& j) {
    row.softness = 1 / j.spring.drag;
    row.before = speed_before(row.now, j);
  });
}

// From u to v: with the matrix with which stop_errors() ended.
void Articulations::Solve::end_springs() {
  bool any = false;
  for_rows([&](Row& row, const Joint& j) {
    const double light = row.use == Use::spring ? j.spring.light : 0;
    row.wanted = light > 0 ? -light * speed(row.now, j) : 0;
    any = any || light > 0;
  });
  if (!any) return;
  push_wanted();
  find_stopping();
  push_wanted();
  for_rows([](Row& row, const Joint&) {
    if (row.use != Use::spring) row.impulse += row.wanted;
  });
}

}  // namespace psim
