// The passes over linkages. One linkage is solved exactly but for its drives, which follow each other.
#include "joints/linkages.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/elementary.h"
#include "base/room.h"
#include "least.h"

namespace psim {
namespace {

constexpr std::uint32_t kLinkageColours = 24;
constexpr std::uint32_t kJob = 32;      // linkages: a job takes some microseconds
constexpr double kFastest = 10;         // m/s or rad/s: errors go out of the places no faster
constexpr double kResolvedTurn = 0.05;  // rad in a substep: how much of a turn still counts in full
constexpr double kBeyond = 1e29;        // m or rad: ends that are further away are none

// How the bodies of a linkage move, from the columns of the solver and back.
struct Motions {
  std::array<Vec2, Linkage::kMostEnds> velocity;
  std::array<double, Linkage::kMostEnds> omega{};

  Motions(const Linkage& l, const float* vel, const float* rim_speed) {
    for (std::uint32_t e = 0; e < l.ends; ++e) {
      const std::size_t n = l.end[e].number;
      velocity[e] = {static_cast<double>(vel[2 * n]), static_cast<double>(vel[2 * n + 1])};
      omega[e] = static_cast<double>(rim_speed[n]) / l.end[e].radius;
    }
  }
  void store(const Linkage& l, const kernels::BodyView& view) const {
    for (std::uint32_t e = 0; e < l.ends; ++e) {
      const LinkageEnd& end = l.end[e];
      if (!end.moves()) continue;
      view.vel[2 * std::size_t{end.number}] = kernels::snapped(velocity[e].x);
      view.vel[2 * std::size_t{end.number} + 1] = kernels::snapped(velocity[e].y);
      view.rim_speed[end.number] = kernels::snapped(omega[e] * end.radius);
    }
  }
  double speed(const Linkage& l, const LinkageRow& row) const {
    double sum = 0;
    for (std::uint32_t e = 0; e < l.ends; ++e) sum += dot(row.lever[e].n, velocity[e]) + row.lever[e].arm * omega[e];
    return sum;
  }
  void push(const Linkage& l, const Lever& lever, std::uint32_t e, double impulse) {
    velocity[e] = velocity[e] + (l.end[e].inverse_mass * impulse) * lever.n;
    omega[e] += l.end[e].turning * impulse * lever.arm;
  }
  void push(const Linkage& l, const LinkageRow& row, double impulse) {
    for (std::uint32_t e = 0; e < l.ends; ++e) push(l, row.lever[e], e, impulse);
  }
  // An impulse in a row that is not rigid, with what it takes along in those that are.
  void push_held(Linkage& l, const LinkageRow& row, double impulse) {
    push(l, row, impulse);
    for (std::uint32_t k = 0; k < l.rigid; ++k) {
      l.row[k].impulse += row.held[k] * impulse;
      push(l, l.row[k], row.held[k] * impulse);
    }
  }
};

// Where the bodies are now.
void load_places(const Linkage& l, const kernels::BodyView& view, JointedMotion* at) {
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    const std::size_t n = l.end[e].number;
    at[e].at = {static_cast<double>(view.disp[2 * n]), static_cast<double>(view.disp[2 * n + 1])};
    at[e].angle = l.end[e].angle + static_cast<double>(view.angle_change[n]);
    at[e].turn = sine_cosine(at[e].angle);
  }
}

void find_now(Linkage& l, const kernels::BodyView& view, double h) {
  JointedMotion at[Linkage::kMostEnds];
  load_places(l, view, at);
  find_rows(l, at);
  find_masses(l, h);
}

// h x the acceleration of the values while the velocities stay as they are: how fast the rows change their speeds on the
// way of a substep, as far as it resolves the turns.
void find_curves(Linkage& l, const kernels::BodyView& view, const Motions& m, double h) {
  JointedMotion at[Linkage::kMostEnds];
  load_places(l, view, at);
  double fastest = 0;
  for (std::uint32_t e = 0; e < l.ends; ++e) fastest = greater(fastest, std::fabs(m.omega[e]));
  const double time = fastest * h > kResolvedTurn ? kResolvedTurn / fastest : h;
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    at[e].at = at[e].at + time * m.velocity[e];
    at[e].angle += time * m.omega[e];
    at[e].turn = sine_cosine(at[e].angle);
  }
  Linkage ahead = l;
  find_rows(ahead, at);
  for (std::uint32_t r = 0; r < l.rows; ++r) l.row[r].curve = m.speed(l, ahead.row[r]) - m.speed(l, l.row[r]);
}

// ---- drives

// By how much the rigid rows miss their aims.
struct Misses {
  double of[2] = {};
};
// How much faster a row gets where these come to hold.
double held_speed(const LinkageRow& row, const Misses& miss) {
  return row.held[0] * miss.of[0] + row.held[1] * miss.of[1];
}
template <class Miss>
Misses misses(const Linkage& l, const Miss& miss) {
  Misses all;
  for (std::uint32_t k = 0; k < l.rigid; ++k) all.of[k] = miss(l.row[k]);
  return all;
}

// The impulses of a drive that together are right for the end of the substep: with mass m and speed v' then,
//   m v' = m v + spring + motor + end,   spring = c - drag v'.
// `v`: the speed without its present impulses. `before`: that before the kick.
void find_drive(LinkageDrive& d, const LinkageRow& row, double v, double before, double h) {
  const double m = row.mass, both = m + d.spring.drag;
  if (!(m > 0) || !(both > 0)) {
    d.spring_l = d.limit_l = d.motor_l = 0;
    return;
  }
  const double c = -d.spring.push * (row.value - d.rest + h * row.curve / 4) - (d.spring.drag + d.spring.lag) * before;
  const double pulled = m * v + c;
  d.motor_l = 0;
  if (d.most > 0) d.motor_l = lesser(greater(both * (d.speed - row.curve) - pulled, -d.most), d.most);
  double after = (pulled + d.motor_l) / both;
  // An end is reached at the end of the drift at most, which goes with the mean of the speeds before and after; one that
  // is passed does not go further.
  const double swing = h * row.curve / 2, over = row.value - d.lower + swing, under = d.upper - row.value - swing;
  double least = -HUGE_VAL, most = HUGE_VAL;
  if (d.lower > -kBeyond) least = over > 0 ? -2 * over / h - before : greater(-row.curve, -before);
  if (d.upper < kBeyond) most = under > 0 ? 2 * under / h - before : lesser(-row.curve, -before);
  if (d.lower == d.upper) least = most = -row.curve;
  d.limit_l = 0;
  const double to = greater(least, lesser(after, most));
  if (to != after) d.limit_l = both * to - pulled - d.motor_l;
  after = to;
  d.spring_l = c - d.spring.drag * after;
}

void solve_drive(Linkage& l, LinkageDrive& d, Motions& m, const Motions& before, double h) {
  LinkageRow& row = l.row[d.row];
  const Misses miss = misses(l, [&](const LinkageRow& r) { return m.speed(l, r) + r.curve; });
  const double sum = d.sum();
  const double v = m.speed(l, row) + held_speed(row, miss);
  find_drive(d, row, row.mass > 0 ? v - sum / row.mass : v, before.speed(l, row), h);
  row.impulse = d.sum();
  m.push_held(l, row, d.sum() - sum);
}

// After the drift: springs did their part, motors go on, and an end that pushes stops.
void relax_drive(Linkage& l, LinkageDrive& d, Motions& m) {
  LinkageRow& row = l.row[d.row];
  const auto speed = [&] {
    const Misses miss = misses(l, [&](const LinkageRow& r) { return m.speed(l, r); });
    return m.speed(l, row) + held_speed(row, miss);
  };
  const auto change = [&](double& part, double to) {
    m.push_held(l, row, to - part);
    part = to;
  };
  if (d.most > 0) change(d.motor_l, lesser(greater(d.motor_l - row.mass * (speed() - d.speed), -d.most), d.most));
  if (d.limit_l != 0) {
    const double next = d.limit_l - row.mass * speed();
    const bool locked = d.lower == d.upper;
    change(d.limit_l, locked ? next : d.limit_l > 0 ? greater(next, 0) : lesser(next, 0));
  }
  row.impulse = d.sum();
}

// ---- two rows at once

Vec2 times_inverse(const Linkage& l, Vec2 v) {
  return {l.inverse[0] * v.x + l.inverse[1] * v.y, l.inverse[1] * v.x + l.inverse[2] * v.y};
}

// Changes the impulse of the pair to one as long as it may be.
void set_pair(Linkage& l, Motions& m, Vec2 to) {
  LinkageDrive &x = l.drive[0], &y = l.drive[1];
  const double size = length_of(to);
  if (size > x.most) to = (x.most / size) * to;
  double& px = l.type == JointType::motor ? x.motor_l : x.spring_l;
  double& py = l.type == JointType::motor ? y.motor_l : y.spring_l;
  m.push(l, l.row[0], to.x - px);
  m.push(l, l.row[1], to.y - py);
  l.row[0].impulse = px = to.x;
  l.row[1].impulse = py = to.y;
}

Vec2 pair_impulse(const Linkage& l) { return {l.row[0].impulse, l.row[1].impulse}; }
Vec2 pair_speed(const Linkage& l, const Motions& m) { return {m.speed(l, l.row[0]), m.speed(l, l.row[1])}; }

void run_pair(Linkage& l, Motions& m) {
  const Vec2 miss = pair_speed(l, m) - Vec2{l.drive[0].speed, l.drive[1].speed};
  set_pair(l, m, pair_impulse(l) - times_inverse(l, miss));
}

// (K^-1 + drag) v' = K^-1 v + c for a vector: p = c - drag v'.
void pull_pair(Linkage& l, Motions& m, const Motions& before, double h) {
  const SpringRow& s = l.drive[0].spring;
  const Vec2 stretch{l.row[0].value + h * l.row[0].curve / 4, l.row[1].value + h * l.row[1].curve / 4};
  const Vec2 c = -s.push * stretch - (s.drag + s.lag) * pair_speed(l, before);
  const Vec2 pulled = times_inverse(l, pair_speed(l, m)) - pair_impulse(l) + c;
  const double xx = l.inverse[0] + s.drag, xy = l.inverse[1], yy = l.inverse[2] + s.drag, size = xx * yy - xy * xy;
  if (!(size > 0)) return;
  const Vec2 after{(yy * pulled.x - xy * pulled.y) / size, (xx * pulled.y - xy * pulled.x) / size};
  set_pair(l, m, c - s.drag * after);
}

// Impulses that take the speeds `miss` of the rigid rows away.
void stop_rigid(Linkage& l, Motions& m, const Misses& miss, bool keep) {
  const Vec2 by = times_inverse(l, {miss.of[0], miss.of[1]});
  for (std::uint32_t k = 0; k < l.rigid; ++k) {
    const double impulse = -(k == 0 ? by.x : by.y);
    if (keep) l.row[k].impulse += impulse;
    m.push(l, l.row[k], impulse);
  }
}

// ---- passes over one linkage

void warm_one(Linkage& l, const kernels::BodyView& view, double factor, double h) {
  l.each_impulse([factor](double& impulse) { impulse *= factor; });
  find_now(l, view, h);
  Motions m(l, view.vel, view.rim_speed);
  for (std::uint32_t r = 0; r < l.rows; ++r) m.push(l, l.row[r], l.row[r].impulse);
  m.store(l, view);
  for (LinkageEnd& end : l.end) end.half = {};
}

void solve_one(Linkage& l, const kernels::BodyView& view, double h, bool again) {
  Motions m(l, view.vel, view.rim_speed);
  const Motions before(l, view.vel0, view.rim_speed0);
  if (!again) {
    for (std::uint32_t e = 0; e < l.ends; ++e) m.push(l, l.end[e].half, e, 1);
    find_curves(l, view, m, h);
  }
  if (l.type == JointType::motor) run_pair(l, m);
  if (l.type == JointType::target || l.type == JointType::weld) pull_pair(l, m, before, h);
  for (std::uint32_t d = l.paired ? 2 : 0; d < l.drives; ++d) solve_drive(l, l.drive[d], m, before, h);
  stop_rigid(l, m, misses(l, [&](const LinkageRow& r) { return m.speed(l, r) + r.curve; }), true);
  m.store(l, view);
}

void push_one(Linkage& l, const kernels::BodyView& view, double rate) {
  Motions m(l, view.vel, view.rim_speed);
  const auto back = [rate](double error) { return lesser(greater(rate * error, -kFastest), kFastest); };
  const auto miss = [&](const LinkageRow& r) { return m.speed(l, r) + back(r.value); };
  Linkage& rows = l;
  for (std::uint32_t n = l.paired ? 2 : 0; n < l.drives; ++n) {
    const LinkageDrive& d = l.drive[n];
    const LinkageRow& row = l.row[d.row];
    const double beyond = lesser(row.value - d.lower, 0) + greater(row.value - d.upper, 0);
    if (beyond == 0) continue;
    const double speed = m.speed(l, row) + held_speed(row, misses(l, miss));
    const double impulse = -row.mass * (speed + back(beyond));
    m.push(l, row, impulse);
    for (std::uint32_t k = 0; k < l.rigid; ++k) m.push(rows, l.row[k], row.held[k] * impulse);
  }
  stop_rigid(l, m, misses(l, miss), false);
  m.store(l, view);
}

// Half of what the impulses gain where the rows turned in the drift.
void turn_half(Linkage& l, const kernels::BodyView& view, Motions& m, double h) {
  const auto old = l.row;
  find_now(l, view, h);
  double lightness = 0;
  for (std::uint32_t e = 0; e < l.ends; ++e) lightness += l.end[e].inverse_mass;
  for (std::uint32_t e = 0; e < l.ends; ++e) {
    Lever half;
    for (std::uint32_t r = 0; r < l.rows; ++r) {
      const double stiffness = std::fabs(l.row[r].impulse) * h * l.row[r].bend * lightness;
      const double part = 0.5 * l.row[r].impulse / greater(stiffness, 1);
      half.n = half.n + part * (l.row[r].lever[e].n - old[r].lever[e].n);
      half.arm += part * (l.row[r].lever[e].arm - old[r].lever[e].arm);
    }
    l.end[e].half = half;
    m.push(l, half, e, 1);
  }
}

void relax_one(Linkage& l, const kernels::BodyView& view, double h, bool again) {
  Motions m(l, view.vel, view.rim_speed);
  if (!again) turn_half(l, view, m, h);
  if (l.type == JointType::motor) run_pair(l, m);
  for (std::uint32_t d = l.paired ? 2 : 0; d < l.drives; ++d) relax_drive(l, l.drive[d], m);
  stop_rigid(l, m, misses(l, [&](const LinkageRow& r) { return m.speed(l, r); }), true);
  m.store(l, view);
}

}  // namespace

std::uint32_t Linkages::add() {
  if (free_.empty()) {
    all_.reserve(roomier(all_));
    free_.reserve(std::max(free_.capacity(), all_.capacity()));  // to take them out needs no memory
    free_.push_back(static_cast<std::uint32_t>(all_.size()));
    all_.emplace_back();
  }
  const std::uint32_t number = free_.back();
  free_.pop_back();
  all_[number] = {};
  return number;
}

void Linkages::lay_out(std::span<const std::uint32_t> some, std::size_t members) {
  stop();
  std::vector<std::vector<std::uint32_t>> of_colour(kLinkageColours + 1);
  std::vector<std::uint32_t> used(members, 0);
  for (const std::uint32_t number : some) {
    const Linkage& l = all_[number];
    std::uint32_t taken = 0;
    for (std::uint32_t e = 0; e < l.ends; ++e) taken |= l.end[e].moves() ? used[l.end[e].member] : 0;
    const std::uint32_t free = std::min(static_cast<std::uint32_t>(std::countr_one(taken)), kLinkageColours);
    for (std::uint32_t e = 0; e < l.ends && free < kLinkageColours; ++e) used[l.end[e].member] |= 1u << free;
    of_colour[free].push_back(number);
  }
  rest_ = !of_colour[kLinkageColours].empty();
  for (const std::vector<std::uint32_t>& colour : of_colour) {
    if (colour.empty()) continue;
    const auto begin = static_cast<std::uint32_t>(order_.size());
    order_.insert(order_.end(), colour.begin(), colour.end());
    colours_.push_back({begin, static_cast<std::uint32_t>(order_.size())});
  }
}

template <class Each>
void Linkages::run(bool backwards, WorkerPool& pool, const Each& each) {
  for (std::size_t n = 0; n < colours_.size(); ++n) {
    const std::size_t c = backwards ? colours_.size() - 1 - n : n;
    const BlockRange& colour = colours_[c];
    const std::uint32_t job = rest_ && c + 1 == colours_.size() ? colour.end - colour.begin : kJob;
    pool.run((colour.end - colour.begin + job - 1) / job, [&](std::size_t k) {
      const auto begin = colour.begin + static_cast<std::uint32_t>(k) * job;
      for (std::uint32_t i = begin; i < std::min(begin + job, colour.end); ++i) each(all_[order_[i]]);
    });
  }
}

void Linkages::warm(const kernels::BodyView& view, const kernels::JointParams& p, WorkerPool& pool) {
  run(false, pool, [&](Linkage& l) { warm_one(l, view, static_cast<double>(p.warm), static_cast<double>(p.h)); });
}
void Linkages::solve(const kernels::BodyView& view, const kernels::JointParams& p, bool backwards, WorkerPool& pool) {
  run(backwards, pool, [&](Linkage& l) { solve_one(l, view, static_cast<double>(p.h), p.again); });
}
void Linkages::push(const kernels::BodyView& view, const kernels::JointParams& p, bool backwards, WorkerPool& pool) {
  run(backwards, pool, [&](Linkage& l) { push_one(l, view, static_cast<double>(p.rate)); });
}
void Linkages::relax(const kernels::BodyView& view, const kernels::JointParams& p, bool backwards, WorkerPool& pool) {
  run(backwards, pool, [&](Linkage& l) { relax_one(l, view, static_cast<double>(p.h), p.again); });
}

}  // namespace psim
