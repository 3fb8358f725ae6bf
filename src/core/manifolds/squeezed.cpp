#include "manifolds/squeezed.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/rotor.h"
#include "least.h"

namespace psim {
namespace {

using kernels::BodyView;
using kernels::ContactParams;
using kernels::ManifoldBlock;

constexpr int kSweeps = 64;  // most sweeps of a solve
// A solve ends with a sweep whose changes are smaller than this share of the largest change, or of what gravity adds in a
// substep.
constexpr double kSettled = 1e-5, kStill = 1e-7;
constexpr double kHeld = 1e-9;  // share of the diagonal that holds changes back, since rows may say the same
// Errors of speeds may add so much energy: these shares of the speeds of rows and of bodies, times the impulse.
constexpr double kSlack = 1e-3, kOfBodies = 1e-6;
constexpr double kFlat = 1e-12;  // share of the diagonal: what is smaller is nothing

// Normals and arms of rows as pairs of numbers.
Vec2 pair_at(const float* records, std::size_t k) { return {records[2 * k], records[2 * k + 1]}; }

// A linear complementarity problem: w = M l + q with l >= 0, w >= 0 and l w = 0. It is solved by principal pivots, always
// at the first row whose basic variable is negative (Murty 1974), which ends where M is positive definite.
template <std::size_t N>
struct Complementarity {
  std::size_t n = 0;
  double m[N][N] = {}, q[N] = {};
  bool presses[N] = {};  // the basic variable of the row is l, not w

  void pivot(std::size_t i) {
    const double inverse = 1 / m[i][i];
    for (std::size_t k = 0; k < n; ++k) {
      if (k == i) continue;
      const double f = m[k][i] * inverse;
      q[k] -= f * q[i];
      for (std::size_t j = 0; j < n; ++j) m[k][j] = j == i ? f : m[k][j] - f * m[i][j];
    }
    for (std::size_t j = 0; j < n; ++j) m[i][j] = j == i ? inverse : -inverse * m[i][j];
    q[i] *= -inverse;
    presses[i] = !presses[i];
  }
  void solve() {
    double slack = 0;
    for (std::size_t i = 0; i < n; ++i) slack = std::max(slack, kFlat * std::fabs(q[i]));
    for (int left = 2 << n; left > 0; --left) {
      std::size_t i = 0;
      while (i < n && !(q[i] < -slack && m[i][i] > kFlat)) ++i;
      if (i == n) return;
      pivot(i);
    }
  }
  double impulse(std::size_t i) const { return presses[i] ? std::max(q[i], 0.0) : 0; }
};

// Adds to the impulse of a row.
void press(const BodyView& v, SqueezedRow& row, double impulse) {
  const auto push = [&](std::size_t slot, double w, double g, double arm) {
    const auto add = [](float& to, double what) { to = kernels::snapped(double{to} + what); };
    add(v.vel[2 * slot], w * row.along.x);
    add(v.vel[2 * slot + 1], w * row.along.y);
    if (row.block != nullptr) add(v.rim_speed[slot], g * arm);
  };
  row.impulse += impulse;
  push(row.light, impulse * row.wl, impulse * row.gl, row.arm);
  if (row.wo > 0) push(row.other, -impulse * row.wo, -impulse * row.go, row.arm_other);
}

}  // namespace

// Reads a contact of discs as it is now. The contact of discs that pass each other is left alone (contact_row.h).
void Squeezed::read_disc(const BodyView& v, const ContactParams& p, bool soft, SqueezedRow& row) {
  const bool fixed = row.other == kNoSlot;
  const ContactLanes& c = lanes_of(row);
  const std::size_t at = row.lane;
  const auto between = [&](const float* of) {
    return pair_at(of, row.light) - (fixed ? Vec2{} : pair_at(of, row.other));
  };
  const double s = double{c.gap[at]} + dot(row.along, between(v.disp)), radius = c.rsum[at];
  const Vec2 u = between(v.vel);
  const double vn = dot(row.along, u), vt = cross(row.along, u);
  const bool round = !fixed || discs_.fixed.refresh[at] < std::numeric_limits<float>::infinity();
  const bool passes = soft && round && s > 0 && vt * vt * s * (s + 2 * radius) > radius * radius * vn * vn;
  const bool settled = !c.e.empty() && std::signbit(c.impact[at]), meets = row.along.x != 0 || row.along.y != 0;
  row.active = meets && !passes && !settled;
  aim(p, soft, s, dot(row.along, between(v.vel0)), c.e.empty() ? 0.0 : double{c.e[at]}, row);
}

// Reads a point of a manifold as it is now.
void Squeezed::read_point(const BodyView& v, const ContactParams& p, bool soft, SqueezedRow& row) {
  const ManifoldBlock& c = *row.block;
  const std::uint32_t l = row.lane;
  const ManifoldBlock::Point& point = c.point[row.point];
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const Vec2 n{c.nx[l], c.ny[l]};
  const double at = point.at[l], bt = point.bt[l];
  Vec2 turn_a = pair_at(v.arm_change, a), turn_b = pair_at(v.arm_change, b);
  turn_a.x += double{c.lead_a[l]} * turn_a.y;
  turn_b.x += double{c.lead_b[l]} * turn_b.y;
  const double s = double{point.gap[l]} - double{row.offset} + dot(n, pair_at(v.disp, b) - pair_at(v.disp, a)) +
                   (turn_b.x * (double{point.bn[l]} + double{c.round_b[l]}) + turn_b.y * bt) -
                   (turn_a.x * (double{point.an[l]} - double{c.round_a[l]}) + turn_a.y * at);
  const double vn0 =
      dot(n, pair_at(v.vel0, b) - pair_at(v.vel0, a)) + double{v.rim_speed0[b]} * bt - double{v.rim_speed0[a]} * at;
  row.active = !(c.e[l] < 0);
  aim(p, soft, s, vn0, c.e[l], row);
}

// Sets the velocity and the softness with which the points of a row should part, as the kernels do: s is their gap, vn0
// their velocity before the kick, e their restitution. An impact asks for no more than the velocities of before the kick,
// turned round, would give. So rows on opposite sides never contradict each other, which would ask for impulses without
// bounds: overlaps are pushed out by soft rows alone.
void Squeezed::aim(const ContactParams& p, bool soft, double s, double vn0, double e, SqueezedRow& row) {
  const float was = impulse_of(row);
  row.impulse = double{std::max(was, 0.0f)} * row.unit;
  row.active &= soft || !std::signbit(was);
  row.apart = s > 0;
  row.bias = row.softness = row.way = row.push = 0;
  if (soft && row.apart) row.bias = s * double{p.inv_h};
  if (soft && !row.apart) {
    row.bias = std::max(s * double{p.soft_rate}, -double{p.push}) / double{p.soft_mass};
    row.softness = row.compliance;
    row.push = -row.bias;
  }
  if (!discs_.model().bounce) return;
  const bool meets = e > 0 && vn0 < -double{p.impact_floor} && (soft ? s + vn0 * double{p.h} < 0 : was > 0);
  const bool parts = vn0 > 0 && (soft || was > 0);
  if (!parts && !(meets && e * vn0 < row.bias)) return;
  row.bias = parts ? std::max(vn0, row.bias) : e * vn0;
  row.softness = row.push = 0;
}

// Finds along which directions the rows of a block push, what an impulse of each adds at each other one, and how they
// give way: as they would to the heavy body if the other bodies that squeeze the light one held it fast.
void Squeezed::couple(const ContactParams& p, Block& block) {
  const std::span<SqueezedRow> rows = rows_of(block);
  for (SqueezedRow& row : rows) {
    row.along = along(row);
    if (row.block == nullptr) continue;
    const ManifoldBlock& c = *row.block;
    const std::uint32_t l = row.lane;
    const double at = c.point[row.point].at[l], bt = c.point[row.point].bt[l];
    row.arm = row.light_b ? bt : -at, row.arm_other = row.light_b ? at : -bt;
    row.gl = row.light_b ? c.gb[l] : c.ga[l], row.go = row.light_b ? c.ga[l] : c.gb[l];
  }
  Complementarity<kMost> whole;
  whole.n = rows.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      const SqueezedRow &x = rows[i], &y = rows[j];
      const double cosine = dot(x.along, y.along);
      double& a = whole.m[i][j] = x.wl * cosine + x.gl * x.arm * y.arm;
      if (x.other == y.other) a += x.wo * cosine + x.go * x.arm_other * y.arm_other;
      block.a[i][j] = a;
    }
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Complementarity<kMost> rest = whole;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      if (rows[k].other != rows[i].other && rest.m[k][k] > kHeld * whole.m[k][k]) rest.pivot(k);
    }
    rows[i].compliance = double{p.soft_impulse} / double{p.soft_mass} * std::max(rest.m[i][i], 0.0);
  }
}

// Solves a block. Returns by how much, m/s, that changes the velocity of a heavy body at one of its rows at most.
double Squeezed::settle(const BodyView& v, const Block& block) {
  const std::span<SqueezedRow> rows = rows_of(block);
  Complementarity<kMost> problem;
  std::size_t row_of[kMost];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].active) row_of[problem.n++] = i;
  }
  for (std::size_t i = 0; i < problem.n; ++i) {
    const SqueezedRow& x = rows[row_of[i]];
    double& q = problem.q[i] = x.bias + parting(v, x);
    const double own = block.a[row_of[i]][row_of[i]];
    for (std::size_t j = 0; j < problem.n; ++j) {
      const double a = block.a[row_of[i]][row_of[j]] + (i == j ? kHeld * own : 0);
      q -= a * rows[row_of[j]].impulse;
      problem.m[i][j] = (a + (i == j ? x.softness : 0)) / own;
    }
    q /= own;
  }
  problem.solve();
  double most = 0;
  for (std::size_t i = 0; i < problem.n; ++i) {
    SqueezedRow& x = rows[row_of[i]];
    const double change = problem.impulse(i) - x.impulse;
    if (change == 0) continue;
    press(v, x, change);
    most = std::max(most, std::fabs(change) * x.w_heavy);
  }
  return most;
}

// m/s: the velocity with which the points of a row part.
double Squeezed::parting(const BodyView& v, const SqueezedRow& x) {
  double speed = dot(x.along, pair_at(v.vel, x.light));
  if (x.other != kNoSlot) speed -= dot(x.along, pair_at(v.vel, x.other));
  if (x.block == nullptr) return speed;
  speed += double{v.rim_speed[x.light]} * x.arm;
  return x.other == kNoSlot ? speed : speed - double{v.rim_speed[x.other]} * x.arm_other;
}

// Whether the impulses of all rows did more work than to part the bodies as fast as their rows ask for.
bool Squeezed::gains_energy(const BodyView& v) const {
  double gained = 0, allowed = 0;
  for (const SqueezedRow& row : rows_) {
    if (!row.active) continue;
    const double now = parting(v, row), rounding = kOfBodies * length_of(pair_at(v.vel, row.light));
    gained += 0.5 * row.impulse * (row.speed + now);
    allowed += row.impulse * (row.push + kSlack * (std::fabs(row.speed) + std::fabs(now)) + rounding);
  }
  return !(gained <= allowed);
}

// Sweeps over blocks, each followed by a step of conjugate gradients (Silcowitz, Niebe, Erleben 2010), which makes up for
// how slowly heavy bodies come to an agreement with several light ones.
void Squeezed::solve(const BodyView& v, const ContactParams& p, bool soft) {
  for (Block& block : blocks_) {
    couple(p, block);  // normals and arms follow the bodies
    for (SqueezedRow& row : rows_of(block)) {
      row.block != nullptr ? read_point(v, p, soft, row) : read_disc(v, p, soft, row);
    }
  }
  const auto press_active = [&](double sign) {
    for (SqueezedRow& row : rows_) {
      if (row.active) press(v, row, sign * row.first);
    }
  };
  for (SqueezedRow& row : rows_) row.first = row.impulse;
  press_active(-1);
  for (SqueezedRow& row : rows_) row.speed = parting(v, row);
  press_active(1);
  const double still = kStill * double{p.h} * length_of(Vec2{p.gravity_x, p.gravity_y});
  double most = 0, before = 0;
  for (int sweep = 1; sweep <= kSweeps; ++sweep) {
    for (SqueezedRow& row : rows_) row.start = row.impulse;
    double change = 0, square = 0;
    for (const Block& block : blocks_) change = std::max(change, settle(v, block));
    most = std::max(most, change);
    if (change <= std::max(kSettled * most, still) || sweep == kSweeps) break;
    for (const SqueezedRow& row : rows_) square += (row.impulse - row.start) * (row.impulse - row.start);
    const double share = square < before ? square / before : 0;
    before = square;
    for (SqueezedRow& row : rows_) {
      const double on = share * row.way;
      row.way = on + row.impulse - row.start;
      if (on != 0) press(v, row, on);
    }
  }
  if (gains_energy(v)) {  // the steps of conjugate gradients did not come to an end: it is as if there were no blocks
    for (SqueezedRow& row : rows_) press(v, row, row.first - row.impulse);
    return;
  }
  for (const SqueezedRow& row : rows_) {
    if (!row.active) continue;
    float& impulse = impulse_of(row);
    impulse = kernels::snapped(row.impulse / row.unit);
    if (soft && row.apart && !(impulse > 0)) impulse = -0.0f;  // it is open
  }
}

float& Squeezed::impulse_of(const SqueezedRow& row) {
  if (row.block != nullptr) return row.block->point[row.point].impulse[row.lane];
  return lanes_of(row).impulse[row.lane];
}

}  // namespace psim
