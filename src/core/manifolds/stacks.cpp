#include "manifolds/stacks.h"

#include <algorithm>
#include <cmath>

#include "base/tasks.h"

namespace psim {
namespace {

using kernels::ManifoldBlock;

constexpr double kSticking = 0.999;  // friction holds below this share of mu l
constexpr double kPivot = 1e-6;      // a pivot below this share of the diagonal vanishes
constexpr float kNoPoint = 1e5f;     // m: the gap of a point that a contact does not have
constexpr double kGoodStep = 0.9;    // share of a full step: a shorter one means an impact

// fmax and fmin without a call. Of two equal numbers the second is returned.
double most(double a, double b) { return a > b ? a : b; }
double least(double a, double b) { return a < b ? a : b; }

double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

ManifoldBlock& block_of(Manifolds& manifolds, const StackLink& link) {
  return manifolds.strip(link.strip).blocks[link.lane / kernels::kBlock];
}

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
void read_step(Manifolds& manifolds, StackLink& link) {
  const ManifoldBlock& c = block_of(manifolds, link);
  const std::uint32_t l = link.lane % kernels::kBlock;
  const auto d = [](float value) { return static_cast<double>(value); };
  const double nx = d(c.nx[l]), ny = d(c.ny[l]), sign = link.b_above ? 1 : -1;
  const double wa = d(c.wa[l]), wb = d(c.wb[l]), ga = d(c.ga[l]), gb = d(c.gb[l]);
  double points = 0;
  link.an = link.bn = 0;
  for (int k = 0; k < 2; ++k) {
    const ManifoldBlock::Point& point = c.point[k];
    const double at = d(point.at[l]), bt = d(point.bt[l]);
    link.dx[k] = nx * sign;
    link.dy[k] = ny * sign;
    link.up[k] = link.b_above ? bt : -at;
    link.low[k] = link.b_above ? -at : bt;
    link.soft[k] = d(c.soft[l]) * (wa + wb + ga * at * at + gb * bt * bt);
    if (!(point.gap[l] < kNoPoint)) continue;
    link.an += d(point.an[l]);
    link.bn += d(point.bn[l]);
    points += 1;
  }
  link.an /= points;
  link.bn /= points;
  link.dx[2] = -ny * sign;
  link.dy[2] = nx * sign;
  link.up[2] = link.b_above ? link.bn : -link.an;
  link.low[2] = link.b_above ? -link.an : link.bn;
  const double wu = link.b_above ? wb : wa, wl = link.b_above ? wa : wb;
  const double gu = link.b_above ? gb : ga, gl = link.b_above ? ga : gb;
  link.wu = wu, link.wl = wl, link.gu = gu, link.gl = gl;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double along = link.dx[i] * link.dx[j] + link.dy[i] * link.dy[j];
      link.a[i][j] = (wu + wl) * along + gu * link.up[i] * link.up[j] + gl * link.low[i] * link.low[j];
    }
  }
  for (ReducedLink& reduced : link.reduced) reduced.rows = ReducedLink().rows;
}

// The coupling with the link below, through the body that is the upper one there and the lower one here.
void couple(StackLink& link, const StackLink& under) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      link.full[i][j] =
          -link.wl * (link.dx[i] * under.dx[j] + link.dy[i] * under.dy[j]) + link.gl * link.low[i] * under.up[j];
    }
  }
}

// Finds which rows are active, and the residuals.
inline void read_rows(const kernels::BodyView& v, Manifolds& manifolds, const kernels::ContactParams& p, double gravity,
                      bool soft, StackLink& link) {
  const ManifoldBlock& c = block_of(manifolds, link);
  const std::uint32_t l = link.lane % kernels::kBlock;
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const auto d = [](float value) { return static_cast<double>(value); };
  const double nx = d(c.nx[l]), ny = d(c.ny[l]);
  const double vx = d(v.vel[2 * b]) - d(v.vel[2 * a]), vy = d(v.vel[2 * b + 1]) - d(v.vel[2 * a + 1]);
  const double ua = d(v.rim_speed[a]), ub = d(v.rim_speed[b]);
  const double mx = d(v.disp[2 * b]) - d(v.disp[2 * a]), my = d(v.disp[2 * b + 1]) - d(v.disp[2 * a + 1]);
  const double inv_h = d(p.inv_h);
  double pressed = 0, rubbed = 0;
  link.rows = 0;
  for (int k = 0; k < 2; ++k) {
    const ManifoldBlock::Point& point = c.point[k];
    const double at = d(point.at[l]), bt = d(point.bt[l]), lambda = most(d(point.impulse[l]), 0);
    const double s = d(point.gap[l]) + nx * mx + ny * my +
                     (d(v.arm_change[2 * b]) * (d(point.bn[l]) + d(c.round_b[l])) + d(v.arm_change[2 * b + 1]) * bt) -
                     (d(v.arm_change[2 * a]) * (d(point.an[l]) - d(c.round_a[l])) + d(v.arm_change[2 * a + 1]) * at);
    link.r[k] = nx * vx + ny * vy + ub * bt - ua * at;
    const bool gives = soft && !(s > 0);
    if (gives) {
      link.r[k] += most(s * d(c.rate[l]), -d(p.push)) + link.soft[k] * lambda;
    } else if (soft) {
      link.r[k] += s * inv_h;
    }
    if (!(point.gap[l] < kNoPoint)) continue;
    if (lambda > 0 || (s <= link.closed && link.r[k] <= gravity / inv_h / 2)) {
      link.rows |= (gives ? 9u : 1u) << k;
    }
    pressed += lambda;
    rubbed += d(point.friction[l]);
  }
  link.r[2] = nx * vy - ny * vx + ub * link.bn - ua * link.an;
  if (pressed > 0 && std::fabs(rubbed) <= kSticking * d(c.mu[l]) * pressed) link.rows |= 4u;
}

// Eliminates links from the free top down, starting with the first one whose active rows changed since the last time.
void reduce(StackLink* links, std::uint32_t n, bool soft) {
  std::uint32_t fresh = n;  // the links below this one must be done
  while (fresh > 0 && links[fresh - 1].reduced[soft].rows == links[fresh - 1].rows) --fresh;
  if (fresh == 0) return;
  for (std::uint32_t k = std::min(fresh + 1, n); k-- > 0;) {
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

void substitute(StackLink* links, std::uint32_t n, bool soft) {
  // The right side is reduced from the top down; then the unknowns follow from the bottom up.
  for (std::uint32_t k = n; k-- > 1;) {
    const StackLink& link = links[k];
    double* const right = links[k - 1].right;
    const auto& m = link.reduced[soft].m;
    for (int j = 0; j < 3; ++j) {
      right[j] -= m[0][j] * link.right[0] + m[1][j] * link.right[1] + m[2][j] * link.right[2];
    }
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    StackLink& link = links[k];
    double x[3][1] = {{link.right[0]}, {link.right[1]}, {link.right[2]}};
    const StackFactor factor = link.reduced[soft].factor;
    solve_block(factor, x);
    for (int i = 0; i < 3; ++i) link.d[i] = x[i][0];
  }
  for (std::uint32_t k = 1; k < n; ++k) {
    const auto& m = links[k].reduced[soft].m;
    for (int i = 0; i < 3; ++i) links[k].d[i] -= dot(m[i], links[k - 1].d);
  }
}

// d is minus the step. The step stays within the bounds and goes no further than the quadratic form falls along it:
// `fall` and `bend` are the slope and the curvature of that form.
void bound_step(Manifolds& manifolds, StackLink* links, std::uint32_t n, double& fall, double& bend) {
  for (std::uint32_t k = 0; k < n; ++k) {
    StackLink& link = links[k];
    const ManifoldBlock& c = block_of(manifolds, link);
    const std::uint32_t l = link.lane % kernels::kBlock;
    double pressed = 0, rubbed = 0;
    for (int i = 0; i < 2; ++i) {
      const double before = most(static_cast<double>(c.point[i].impulse[l]), 0);
      const double after = most(before - link.d[i], 0);
      link.d[i] = link.active(i) ? after - before : 0;
      pressed += before + link.d[i];
      rubbed += static_cast<double>(c.point[i].friction[l]);
    }
    const double cap = static_cast<double>(c.mu[l]) * pressed;
    const double rub = least(most(rubbed - link.d[2], -cap), cap);
    link.d[2] = link.active(2) ? rub - rubbed : 0;
    fall -= dot(link.r, link.d);
    for (int i = 0; i < 3; ++i) {
      bend += link.d[i] * (dot(link.a[i], link.d) + link.compliance(i) * link.d[i]);
      if (k > 0) bend += 2 * link.d[i] * dot(links[k - 1].d, link.full[i]);
    }
  }
}

void apply(const kernels::BodyView& v, Manifolds& manifolds, const StackLink& link, double step) {
  ManifoldBlock& c = block_of(manifolds, link);
  const std::uint32_t l = link.lane % kernels::kBlock;
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const std::size_t upper = link.b_above ? b : a, lower = link.b_above ? a : b;
  double px = 0, py = 0, up = 0, low = 0;
  for (int i = 0; i < 3; ++i) {
    const double d = step * link.d[i];
    px += d * link.dx[i];
    py += d * link.dy[i];
    up += d * link.up[i];
    low += d * link.low[i];
  }
  const auto add = [](float& to, double what) { to = static_cast<float>(static_cast<double>(to) + what); };
  add(v.vel[2 * upper], link.wu * px);
  add(v.vel[2 * upper + 1], link.wu * py);
  add(v.rim_speed[upper], link.gu * up);
  if (link.wl > 0 || link.gl > 0) {
    add(v.vel[2 * lower], -link.wl * px);
    add(v.vel[2 * lower + 1], -link.wl * py);
    add(v.rim_speed[lower], link.gl * low);
  }
  int points = 0;
  for (int i = 0; i < 2; ++i) {
    float& impulse = c.point[i].impulse[l];
    const double after = most(static_cast<double>(impulse), 0) + step * link.d[i];
    if (link.active(i) && (after > 0 || !std::signbit(impulse))) impulse = static_cast<float>(most(after, 0));
    points += impulse > 0 ? 1 : 0;
  }
  if (points == 0) return;
  for (int i = 0; i < 2; ++i) {
    if (c.point[i].impulse[l] > 0) add(c.point[i].friction[l], step * link.d[2] / points);
  }
}

}  // namespace

void Stacks::solve_one(const kernels::BodyView& v, Manifolds& manifolds, const kernels::ContactParams& p,
                       double gravity, bool soft, Stack& stack) {
  StackLink* const links = links_.data() + stack.first;
  const std::uint32_t n = stack.count;
  if (!stack.read) {
    for (std::uint32_t k = 0; k < n; ++k) {
      read_step(manifolds, links[k]);
      if (k > 0) couple(links[k], links[k - 1]);
    }
    stack.read = true;
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    read_rows(v, manifolds, p, gravity, soft, links[k]);
    for (int i = 0; i < 3; ++i) links[k].right[i] = links[k].active(i) ? links[k].r[i] : 0;
  }
  reduce(links, n, soft);
  substitute(links, n, soft);
  double fall = 0, bend = 0;
  bound_step(manifolds, links, n, fall, bend);
  const double step = bend > 0 ? least(most(fall / bend, 0), 1) : 0;
  for (std::uint32_t k = 0; k < n; ++k) {
    StackLink& link = links[k];
    if (step < kGoodStep && bend > 0) manifolds.pair(link.pair).rest_frames = kRestFrames;
    apply(v, manifolds, link, step);
  }
}

void Stacks::solve(const kernels::BodyView& bodies, Manifolds& manifolds, const kernels::ContactParams& p,
                   double gravity, bool soft, WorkerPool& pool) {
  pool.run(stacks_.size(), [&](std::size_t k) { solve_one(bodies, manifolds, p, gravity, soft, stacks_[k]); });
}

}  // namespace psim
