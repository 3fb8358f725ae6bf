#include "manifolds/stacks.h"

#include <algorithm>
#include <cmath>

#include "least.h"

namespace psim {
namespace {

using kernels::ManifoldBlock;

constexpr double kSticking = 0.999;  // friction holds below this share of mu l
constexpr double kPivot = 1e-6;      // a pivot below this share of the diagonal vanishes
constexpr float kNoPoint = 1e5f;     // m: the gap of a point that a contact does not have
constexpr double kGoodStep = 0.9;    // share of a full step: a shorter one means an impact

double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec2 record(const float* records, std::size_t k) { return {records[2 * k], records[2 * k + 1]}; }

inline StackFactor factor_of(const double s[3][3]) {
  StackFactor f;
  for (int k = 0; k < 3; ++k) f.scale[k] = s[k][k] > 0 ? 1 / std::sqrt(s[k][k]) : 0;
  const auto at = [&](int i, int j) { return s[i][j] * f.scale[i] * f.scale[j]; };
  const auto pivot = [](double value) { return value > kPivot ? 1 / value : 0; };
  f.d[0] = pivot(at(0, 0));
  f.l10 = at(1, 0) * f.d[0];
  f.l20 = at(2, 0) * f.d[0];
  f.d[1] = pivot(at(1, 1) - f.l10 * at(1, 0));
  const double m21 = at(2, 1) - f.l20 * at(1, 0);
  f.l21 = m21 * f.d[1];
  f.d[2] = pivot(at(2, 2) - f.l20 * at(2, 0) - f.l21 * m21);
  return f;
}

// Solves S x = b in place, for N right sides at once. A row whose pivot vanishes gives 0.
template <int N>
inline void solve_block(const StackFactor& f, double (&x)[3][N]) {
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < N; ++j) x[k][j] *= f.scale[k];
  }
  for (int j = 0; j < N; ++j) {
    x[1][j] -= f.l10 * x[0][j];
    x[2][j] -= f.l20 * x[0][j] + f.l21 * x[1][j];
    for (int k = 0; k < 3; ++k) x[k][j] *= f.d[k];
    x[1][j] -= f.l21 * x[2][j];
    x[0][j] -= f.l10 * x[1][j] + f.l20 * x[2][j];
  }
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < N; ++j) x[k][j] *= f.scale[k];
  }
}

// Reads the parts of a link that stay the same within a step: rows and blocks.
void read_step(StackLink& link) {
  const ManifoldBlock& c = *link.block;
  const std::uint32_t l = link.lane;
  const double sign = link.b_above ? 1 : -1;
  const Vec2 n = sign * Vec2{c.nx[l], c.ny[l]};
  const double wa = c.wa[l], wb = c.wb[l], ga = c.ga[l], gb = c.gb[l];
  double points = 0;
  link.an = link.bn = 0;
  for (int k = 0; k < 2; ++k) {
    const ManifoldBlock::Point& point = c.point[k];
    const double at = point.at[l], bt = point.bt[l];
    link.along[k] = n;
    link.up[k] = link.b_above ? bt : -at;
    link.low[k] = link.b_above ? -at : bt;
    link.soft[k] = c.soft[l] * (wa + wb + ga * at * at + gb * bt * bt);
    if (!(point.gap[l] < kNoPoint)) continue;
    link.an += point.an[l];
    link.bn += point.bn[l];
    points += 1;
  }
  link.an /= points;
  link.bn /= points;
  link.along[2] = {-n.y, n.x};
  link.up[2] = link.b_above ? link.bn : -link.an;
  link.low[2] = link.b_above ? -link.an : link.bn;
  link.wu = link.b_above ? wb : wa, link.wl = link.b_above ? wa : wb;
  link.gu = link.b_above ? gb : ga, link.gl = link.b_above ? ga : gb;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      link.a[i][j] = (link.wu + link.wl) * dot(link.along[i], link.along[j]) + link.gu * link.up[i] * link.up[j] +
                     link.gl * link.low[i] * link.low[j];
    }
  }
  for (ReducedLink& reduced : link.reduced) reduced.rows = ReducedLink().rows;
}

// The coupling with the link below, through the body that is the upper one there and the lower one here.
void couple(StackLink& link, const StackLink& under) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      link.full[i][j] = -link.wl * dot(link.along[i], under.along[j]) + link.gl * link.low[i] * under.up[j];
    }
  }
}

// Finds which rows are active, and the residuals.
inline void read_rows(const kernels::BodyView& v, const kernels::ContactParams& p, double gravity, bool soft,
                      StackLink& link) {
  const ManifoldBlock& c = *link.block;
  const std::uint32_t l = link.lane;
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const Vec2 n{c.nx[l], c.ny[l]};
  const Vec2 vel = record(v.vel, b) - record(v.vel, a), move = record(v.disp, b) - record(v.disp, a);
  Vec2 turn_a = record(v.arm_change, a), turn_b = record(v.arm_change, b);
  turn_a.x += double{c.lead_a[l]} * turn_a.y;
  turn_b.x += double{c.lead_b[l]} * turn_b.y;
  const double ua = v.rim_speed[a], ub = v.rim_speed[b], inv_h = p.inv_h;
  double pressed = 0, rubbed = 0;
  link.rows = 0;
  for (int k = 0; k < 2; ++k) {
    const ManifoldBlock::Point& point = c.point[k];
    const double at = point.at[l], bt = point.bt[l], lambda = std::max<double>(0, point.impulse[l]);
    const double s = point.gap[l] + n.x * move.x + n.y * move.y +
                     (turn_b.x * (double{point.bn[l]} + double{c.round_b[l]}) + turn_b.y * bt) -
                     (turn_a.x * (double{point.an[l]} - double{c.round_a[l]}) + turn_a.y * at);
    link.r[k] = dot(n, vel) + ub * bt - ua * at;
    const bool gives = soft && !(s > 0);
    if (gives) {
      link.r[k] += std::max<double>(-p.push, s * c.rate[l]) + link.soft[k] * lambda;
    } else if (soft) {
      link.r[k] += s * inv_h;
    }
    if (!(point.gap[l] < kNoPoint)) continue;
    if (lambda > 0 || (s <= link.closed && link.r[k] <= gravity / inv_h / 2)) {
      link.rows |= (gives ? 9u : 1u) << k;
    }
    pressed += lambda;
    rubbed += point.friction[l];
  }
  link.r[2] = cross(n, vel) + ub * link.bn - ua * link.an;
  if (pressed > 0 && std::fabs(rubbed) <= kSticking * c.mu[l] * pressed) link.rows |= 4u;
}

// Eliminates links from the free top down, starting with the first one whose active rows changed since the last time.
void reduce(std::span<StackLink> links, bool soft) {
  const std::size_t n = links.size();
  std::size_t fresh = n;  // the links below this one must be done
  while (fresh > 0 && links[fresh - 1].reduced[soft].rows == links[fresh - 1].rows) --fresh;
  if (fresh == 0) return;
  for (std::size_t k = std::min(fresh + 1, n); k-- > 0;) {
    StackLink& link = links[k];
    ReducedLink& reduced = link.reduced[soft];
    if (k < fresh) {
      double s[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) s[i][j] = link.active(i) && link.active(j) ? link.a[i][j] : 0;
        if (link.active(i)) s[i][i] += link.compliance(i);
      }
      if (k + 1 < n) {
        const StackLink& over = links[k + 1];
        for (int m = 0; m < 3; ++m) {
          for (int i = 0; i < 3; ++i) {
            const double o = over.coupling(m, i, link);
            for (int j = 0; j < 3; ++j) s[i][j] -= o * over.reduced[soft].m[m][j];
          }
        }
      }
      reduced.factor = factor_of(s);
      reduced.rows = link.rows;
    }
    if (k == 0) break;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) reduced.m[i][j] = link.coupling(i, j, links[k - 1]);
    }
    const StackFactor factor = reduced.factor;
    solve_block(factor, reduced.m);
  }
}

void substitute(std::span<StackLink> links, bool soft) {
  // The right side is reduced from the top down; then the unknowns follow from the bottom up.
  for (std::size_t k = links.size(); k-- > 1;) {
    const StackLink& link = links[k];
    double* const right = links[k - 1].right;
    const auto& m = link.reduced[soft].m;
    for (int j = 0; j < 3; ++j) {
      right[j] -= m[0][j] * link.right[0] + m[1][j] * link.right[1] + m[2][j] * link.right[2];
    }
  }
  for (StackLink& link : links) {
    double x[3][1] = {{link.right[0]}, {link.right[1]}, {link.right[2]}};
    const StackFactor factor = link.reduced[soft].factor;
    solve_block(factor, x);
    for (int i = 0; i < 3; ++i) link.d[i] = x[i][0];
  }
  for (std::size_t k = 1; k < links.size(); ++k) {
    const auto& m = links[k].reduced[soft].m;
    for (int i = 0; i < 3; ++i) links[k].d[i] -= dot(m[i], links[k - 1].d);
  }
}

// d is minus the step. The step stays within the bounds and goes no further than the quadratic form falls along it:
// `fall` and `bend` are the slope and the curvature of that form.
void bound_step(std::span<StackLink> links, double& fall, double& bend) {
  const StackLink* under = nullptr;
  for (StackLink& link : links) {
    const ManifoldBlock& c = *link.block;
    const std::uint32_t l = link.lane;
    double pressed = 0, rubbed = 0;
    for (int i = 0; i < 2; ++i) {
      const double before = std::max<double>(0, c.point[i].impulse[l]);
      const double after = std::max(0.0, before - link.d[i]);
      link.d[i] = link.active(i) ? after - before : 0;
      pressed += before + link.d[i];
      rubbed += c.point[i].friction[l];
    }
    const double cap = c.mu[l] * pressed;
    const double rub = std::min(cap, std::max(-cap, rubbed - link.d[2]));
    link.d[2] = link.active(2) ? rub - rubbed : 0;
    fall -= dot(link.r, link.d);
    for (int i = 0; i < 3; ++i) {
      bend += link.d[i] * (dot(link.a[i], link.d) + link.compliance(i) * link.d[i]);
      if (under != nullptr) bend += 2 * link.d[i] * dot(under->d, link.full[i]);
    }
    under = &link;
  }
}

void apply(const kernels::BodyView& v, const StackLink& link, double step) {
  ManifoldBlock& c = *link.block;
  const std::uint32_t l = link.lane;
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const std::size_t upper = link.b_above ? b : a, lower = link.b_above ? a : b;
  Vec2 push;
  double up = 0, low = 0;
  for (int i = 0; i < 3; ++i) {
    const double d = step * link.d[i];
    push = push + d * link.along[i];
    up += d * link.up[i];
    low += d * link.low[i];
  }
  const auto add = [](float& to, double what) { to = kernels::snapped(to + what); };
  add(v.vel[2 * upper], link.wu * push.x);
  add(v.vel[2 * upper + 1], link.wu * push.y);
  add(v.rim_speed[upper], link.gu * up);
  if (link.wl > 0 || link.gl > 0) {
    add(v.vel[2 * lower], -link.wl * push.x);
    add(v.vel[2 * lower + 1], -link.wl * push.y);
    add(v.rim_speed[lower], link.gl * low);
  }
  int points = 0;
  for (int i = 0; i < 2; ++i) {
    float& impulse = c.point[i].impulse[l];
    const double after = std::max<double>(0, impulse) + step * link.d[i];
    if (link.active(i) && (after > 0 || !std::signbit(impulse))) impulse = static_cast<float>(std::max(0.0, after));
    points += impulse > 0 ? 1 : 0;
  }
  if (points == 0) return;
  for (int i = 0; i < 2; ++i) {
    if (c.point[i].impulse[l] > 0) add(c.point[i].friction[l], step * link.d[2] / points);
  }
}

}  // namespace

void Stacks::place() {
  pool_.run(stacks_.size(), [&](std::size_t index) {
    const StackLink* under = nullptr;
    for (StackLink& link : links_of(stacks_[index])) {
      const std::uint32_t lane = manifolds_.pairs()[link.pair].lane;
      link.block = &manifolds_.strip(manifolds_.strip_of(link.pair)).blocks[lane / kernels::kBlock];
      link.lane = lane % kernels::kBlock;
      read_step(link);
      if (under != nullptr) couple(link, *under);
      under = &link;
    }
  });
}

void Stacks::solve(const kernels::BodyView& v, const kernels::ContactParams& p, double gravity, bool soft) {
  pool_.run(stacks_.size(), [&](std::size_t index) {
    const std::span<StackLink> links = links_of(stacks_[index]);
    for (StackLink& link : links) {
      read_rows(v, p, gravity, soft, link);
      for (int i = 0; i < 3; ++i) link.right[i] = link.active(i) ? link.r[i] : 0;
    }
    reduce(links, soft);
    substitute(links, soft);
    double fall = 0, bend = 0;
    bound_step(links, fall, bend);
    const double step = bend > 0 ? std::min(1.0, std::max(0.0, fall / bend)) : 0;
    for (const StackLink& link : links) {
      if (step < kGoodStep && bend > 0) manifolds_.pair(link.pair).rest_frames = kRestFrames;
      apply(v, link, step);
    }
  });
}

}  // namespace psim
