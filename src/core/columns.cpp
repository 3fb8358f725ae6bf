#include "columns.h"

#include <algorithm>
#include <cmath>

namespace psim {
namespace {

using kernels::ManifoldBlock;

constexpr std::uint32_t kLongColumn = 4;  // links
constexpr float kMassRatio = 8;           // or one link with this ratio
constexpr float kSideShare = 0.05f;       // of the support: what side contacts may carry
constexpr double kSupport = 0.5;          // |cosine| between normal and up
constexpr float kTouching = 0.002f;       // of the inner radius: gap that counts as touching
constexpr float kClosed = 0.0002f;        // gap that a solve may close
constexpr double kSticking = 0.999;       // of mu l, below which friction holds
constexpr double kPivot = 1e-6;           // of the diagonal
constexpr float kNoPoint = 1e5f;          // m: gap of a point that a contact does not have
constexpr double kGoodStep = 0.9;         // of a full step; shorter ones tell of an impact
constexpr std::uint8_t kRestFrames = 8;   // as an ordinary contact after that or a short step
// Of what gravity does in a step: speed up to which a link becomes part of a long column, and stays one.
constexpr double kCalm = 0.06, kShaken = 1.2;
constexpr std::size_t kRoom = 64;         // links that there is always room for, and one for eight bodies

// As fmax and fmin, without a call; of two that are equal, the second.
double most(double a, double b) { return a > b ? a : b; }
double least(double a, double b) { return a < b ? a : b; }

double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

inline Columns::Factor Columns::factor_of(const double s[3][3]) {
  Factor f;
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

// Solves S x = b for N right sides side by side, in place; rows whose pivot vanishes give 0.
template <int N>
inline void Columns::solve(const Factor& f, double (&x)[3][N]) {
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

void Columns::find(const BodyStore& b, Manifolds& manifolds, const ManifoldParams& params,
                   const PairTable& table, WorkerPool& pool) {
  links_.clear();
  columns_.clear();
  const std::size_t bodies = manifolds.shaped().size(), usual = std::min(bodies, kRoom + bodies / 8);
  run_.reserve(usual);
  links_.reserve(usual);
  columns_.reserve(usual);
  const double g = std::sqrt(params.gravity.x * params.gravity.x + params.gravity.y * params.gravity.y);
  const auto upright = [&](const ManifoldPair& pair) {
    return -(params.gravity.x * static_cast<double>(pair.manifold.nx) +
             params.gravity.y * static_cast<double>(pair.manifold.ny)) / g;
  };
  const auto inner = [&](std::uint32_t id) { return b.make(id).inner; };
  const auto touches = [&](const ManifoldPair& pair) {
    if (!pair.active || pair.manifold.count == 0) return false;
    if (pair.impulse[0] > 0 || (pair.manifold.count == 2 && pair.impulse[1] > 0)) return true;
    const float least = pair.manifold.count == 2 ? std::fmin(pair.gap[0], pair.gap[1]) : pair.gap[0];
    return least <= kTouching * inner(pair.id_b);
  };
  standing_.resize(std::max<std::size_t>(standing_.size(), b.count));
  const auto each_strip = [&](const auto& visit) {  // no two jobs of a phase share a body
    const std::size_t grid = table.strips.size() - 1;
    for (std::size_t parity = 0; parity < 2; ++parity) {
      pool.run((grid + 1 - parity) / 2, [&](std::size_t k) { visit(2 * k + parity); });
    }
    visit(grid);
  };
  each_strip([&](std::size_t strip) {
    for (const std::uint32_t k : manifolds.active_of(strip)) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      standing_[pair.b] = {};
      if (pair.a != kNone) standing_[pair.a] = {};
    }
  });
  for (const std::uint32_t slot : manifolds.shaped()) standing_[slot] = {};
  each_strip([&](std::size_t strip) {
    for (const std::uint32_t k : manifolds.active_of(strip)) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      if (!(g > 0) || !touches(pair)) continue;
      const double up = upright(pair);
      const float load = pair.impulse[0] + (pair.manifold.count == 2 ? pair.impulse[1] : 0);
      const auto stand = [&](std::uint32_t upper, std::uint32_t lower) {
        if (upper != kNone) {
          ++standing_[upper].below;
          standing_[upper].on = k;
          standing_[upper].support = load;
        }
        if (lower != kNone) ++standing_[lower].above;
      };
      if (up >= kSupport) {
        stand(pair.b, pair.a);
      } else if (up <= -kSupport) {
        stand(pair.a, pair.b);
      } else {
        standing_[pair.b].side += load;
        if (pair.a != kNone) standing_[pair.a].side += load;
      }
    }
  });
  // Who is the upper body of a link, and who carries one.
  const auto links_down = [&](std::uint32_t slot) {
    const Standing& mine = standing_[slot];
    if (mine.below != 1 || mine.above > 1 || mine.side > kSideShare * mine.support) return false;
    const ManifoldPair& pair = manifolds.pairs()[mine.on];
    const bool b_above = pair.b == slot;
    if (pair.rest_frames != 0 || (!b_above && pair.fixed_a) || b.surface(b.id[slot]).inv_mass == 0) {
      return false;
    }
    if (pair.fixed_a) return true;
    const std::uint32_t lower = b_above ? pair.a : pair.b;
    return manifolds.has_corners(lower) && standing_[lower].above == 1;
  };
  for (const std::uint32_t slot : manifolds.shaped()) {
    if (!links_down(slot)) continue;
    standing_[slot].link = true;
    const ManifoldPair& pair = manifolds.pairs()[standing_[slot].on];
    if (!pair.fixed_a) standing_[pair.b == slot ? pair.a : pair.b].carries = true;
  }
  // Against each other. A direct solve throws bodies about that rock on each other.
  const auto moves = [&](const ManifoldPair& pair) {
    const auto motion = [&](std::uint32_t slot) {
      if (slot == kNone) return Vec2{};
      return Vec2{static_cast<double>(b.vel[2 * std::size_t{slot}]), static_cast<double>(b.vel[2 * std::size_t{slot} + 1])};
    };
    const auto turning = [&](std::uint32_t slot) {
      return slot == kNone ? 0 : std::fabs(static_cast<double>(b.spin[slot]));
    };
    const Vec2 va = motion(pair.a), vb = motion(pair.b);
    if (pair.manifold.count != 2) return false;
    return std::hypot(vb.x - va.x, vb.y - va.y) + turning(pair.a) + turning(pair.b) >
           (pair.was_column == ManifoldPair::kLoose ? kCalm : kShaken) * g * params.dt;
  };
  for (const std::uint32_t top : manifolds.shaped()) {
    if (!standing_[top].link || standing_[top].carries) continue;
    run_.clear();
    bool steep = false;
    for (std::uint32_t slot = top; slot != kNone && standing_[slot].link;) {
      Link link;
      link.pair = standing_[slot].on;
      const ManifoldPair& pair = manifolds.pairs()[link.pair];
      link.b_above = pair.b == slot;
      const std::uint32_t lower = pair.fixed_a ? kNone : (link.b_above ? pair.a : pair.b);
      if (lower != kNone) {
        const float here = b.surface(b.id[slot]).mass, there = b.surface(b.id[lower]).mass;
        steep |= here > kMassRatio * there || there > kMassRatio * here;
      }
      run_.push_back(link);
      slot = lower;
    }
    if (run_.size() < kLongColumn && !steep) continue;
    std::reverse(run_.begin(), run_.end());
    // A long one has none but links at rest; what is left between others is too short or a column of its own.
    std::size_t begin = 0;
    for (std::size_t k = 0; k <= run_.size(); ++k) {
      if (k != run_.size()) {
        if (steep || !moves(manifolds.pairs()[run_[k].pair])) continue;
        manifolds.pair(run_[k].pair).rest_frames = kRestFrames;
      }
      if (steep || k - begin >= kLongColumn) add_column(b, manifolds, begin, k);
      begin = k + 1;
    }
  }
}

// Links [begin, end) of the run, from the bottom.
void Columns::add_column(const BodyStore& b, Manifolds& manifolds, std::size_t begin, std::size_t end) {
  columns_.push_back({static_cast<std::uint32_t>(links_.size()), static_cast<std::uint32_t>(end - begin), false});
  const bool grounded = manifolds.pairs()[run_[begin].pair].fixed_a;
  for (std::size_t k = begin; k < end; ++k) {
    manifolds.set_column(run_[k].pair, grounded ? ManifoldPair::kOnFixed : ManifoldPair::kOnMoving);
    run_[k].closed = static_cast<double>(kClosed * b.make(manifolds.pairs()[run_[k].pair].id_b).inner);
    links_.push_back(run_[k]);
  }
}

void Columns::place(const Manifolds& manifolds) {
  for (Link& link : links_) {
    link.lane = manifolds.pairs()[link.pair].lane;
    link.strip = static_cast<std::uint32_t>(manifolds.strip_of(link.pair));
  }
}

// What of a link stays as it is for a step: rows and blocks.
void Columns::read_step(Manifolds& manifolds, Link& link) {
  const ManifoldBlock& c = manifolds.strip(link.strip).blocks[link.lane / kernels::kBlock];
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
  for (Reduced& reduced : link.reduced) reduced.rows = Reduced().rows;
}

// With the link below, through the body that is upper there and lower here.
void Columns::couple(Link& link, const Link& under) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      link.full[i][j] = -link.wl * (link.dx[i] * under.dx[j] + link.dy[i] * under.dy[j]) +
                        link.gl * link.low[i] * under.up[j];
    }
  }
}

// Which rows are active, and residuals, as things are now.
inline void Columns::read(const kernels::BodyView& v, Manifolds& manifolds,
                          const kernels::ContactParams& p, double gravity, bool soft, Link& link) {
  const ManifoldBlock& c = manifolds.strip(link.strip).blocks[link.lane / kernels::kBlock];
  const std::uint32_t l = link.lane % kernels::kBlock;
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const auto d = [](float value) { return static_cast<double>(value); };
  const double nx = d(c.nx[l]), ny = d(c.ny[l]);
  const double vx = d(v.vel[2 * b]) - d(v.vel[2 * a]), vy = d(v.vel[2 * b + 1]) - d(v.vel[2 * a + 1]);
  const double ua = d(v.spin[a]), ub = d(v.spin[b]);
  const double mx = d(v.disp[2 * b]) - d(v.disp[2 * a]), my = d(v.disp[2 * b + 1]) - d(v.disp[2 * a + 1]);
  const double inv_h = d(p.inv_h);
  double pressed = 0, rubbed = 0;
  link.rows = 0;
  for (int k = 0; k < 2; ++k) {
    const ManifoldBlock::Point& point = c.point[k];
    const double at = d(point.at[l]), bt = d(point.bt[l]), lambda = most(d(point.impulse[l]), 0);
    const double s = d(point.gap[l]) + nx * mx + ny * my +
                     (d(v.turn[2 * b]) * (d(point.bn[l]) + d(c.round_b[l])) + d(v.turn[2 * b + 1]) * bt) -
                     (d(v.turn[2 * a]) * (d(point.an[l]) - d(c.round_a[l])) + d(v.turn[2 * a + 1]) * at);
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

// Eliminates links from the free top down, from the first one whose rows are others than the last time.
void Columns::reduce(Link* links, std::uint32_t n, bool soft) {
  std::uint32_t fresh = n;  // links below this one are to be done
  while (fresh > 0 && links[fresh - 1].reduced[soft].rows == links[fresh - 1].rows) --fresh;
  if (fresh == 0) return;
  for (std::uint32_t k = std::min(fresh + 1, n); k-- > 0;) {
    Link& link = links[k];
    Reduced& reduced = link.reduced[soft];
    if (k < fresh) {
      double s[3][3];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) s[i][j] = link.active(i) && link.active(j) ? link.a[i][j] : 0;
        if (link.active(i)) s[i][i] += link.compliance(i);
      }
      if (k + 1 < n) {
        const Link& over = links[k + 1];
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
    const Factor factor = reduced.factor;
    solve(factor, reduced.m);
  }
}

void Columns::solve_one(const kernels::BodyView& v, Manifolds& manifolds,
                        const kernels::ContactParams& p, double gravity, bool soft, Column& column) {
  Link* const links = links_.data() + column.first;
  const std::uint32_t n = column.count;
  if (!column.read) {
    for (std::uint32_t k = 0; k < n; ++k) {
      read_step(manifolds, links[k]);
      if (k > 0) couple(links[k], links[k - 1]);
    }
    column.read = true;
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    read(v, manifolds, p, gravity, soft, links[k]);
    for (int i = 0; i < 3; ++i) links[k].right[i] = links[k].active(i) ? links[k].r[i] : 0;
  }
  reduce(links, n, soft);
  // The right side from the top down; then the unknowns from the bottom up.
  for (std::uint32_t k = n; k-- > 1;) {
    const Link& link = links[k];
    double* const right = links[k - 1].right;
    const auto& m = link.reduced[soft].m;
    for (int j = 0; j < 3; ++j) {
      right[j] -= m[0][j] * link.right[0] + m[1][j] * link.right[1] + m[2][j] * link.right[2];
    }
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    Link& link = links[k];
    double x[3][1] = {{link.right[0]}, {link.right[1]}, {link.right[2]}};
    const Factor factor = link.reduced[soft].factor;
    solve(factor, x);
    for (int i = 0; i < 3; ++i) link.d[i] = x[i][0];
  }
  for (std::uint32_t k = 1; k < n; ++k) {
    const auto& m = links[k].reduced[soft].m;
    for (int i = 0; i < 3; ++i) links[k].d[i] -= dot(m[i], links[k - 1].d);
  }
  // d is minus the step. Within the bounds, and no further than the quadratic form falls along it.
  double fall = 0, bend = 0;
  for (std::uint32_t k = 0; k < n; ++k) {
    Link& link = links[k];
    const ManifoldBlock& c = manifolds.strip(link.strip).blocks[link.lane / kernels::kBlock];
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
  const double step = bend > 0 ? least(most(fall / bend, 0), 1) : 0;
  for (std::uint32_t k = 0; k < n; ++k) {
    Link& link = links[k];
    if (step < kGoodStep && bend > 0) manifolds.pair(link.pair).rest_frames = kRestFrames;
    apply(v, manifolds, link, step);
  }
}

void Columns::apply(const kernels::BodyView& v, Manifolds& manifolds, const Link& link, double step) {
  ManifoldBlock& c = manifolds.strip(link.strip).blocks[link.lane / kernels::kBlock];
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
  add(v.spin[upper], link.gu * up);
  if (link.wl > 0 || link.gl > 0) {
    add(v.vel[2 * lower], -link.wl * px);
    add(v.vel[2 * lower + 1], -link.wl * py);
    add(v.spin[lower], link.gl * low);
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

void Columns::solve(const kernels::BodyView& bodies, Manifolds& manifolds,
                    const kernels::ContactParams& p, double gravity, bool soft, WorkerPool& pool) {
  pool.run(columns_.size(), [&](std::size_t k) {
    solve_one(bodies, manifolds, p, gravity, soft, columns_[k]);
  });
}

}  // namespace psim
