// Impacts of shapes: manifolds with restitution whose bodies rest on nothing collide at their time within a substep
// (shape_impact.h). As with discs (impact_sweeps.cpp) sweeps go on until one finds no impact.
#include <algorithm>
#include <cmath>

#include "solver/shape_impact.h"

namespace psim {

using shape_impact::Around;
using shape_impact::ShapeImpact;

namespace {

constexpr double kTurning = 0.02;  // rad in a step: a body that turns less meets others with the arms of its start

// How fast the nearest points of a pair approach each other, m/s.
double approach_of(const kernels::BodyView& view, const kernels::ManifoldBlock& c, std::uint32_t l) {
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const float vn =
      c.nx[l] * (view.vel[2 * b] - view.vel[2 * a]) + c.ny[l] * (view.vel[2 * b + 1] - view.vel[2 * a + 1]);
  const auto at = [&](const kernels::ManifoldBlock::Point& p) {
    return vn + (view.rim_speed[b] * p.bt[l] - view.rim_speed[a] * p.at[l]);
  };
  return -double{std::min(at(c.point[0]), at(c.point[1]))};
}

// Whether bodies that touch in one point turn so that they may touch in another one within dt, s.
bool rocks(const BodyStore& b, const ManifoldPair& pair, float dt, float slowest) {
  const Manifold& m = pair.manifold;
  const std::size_t i = pair.of_piece() ? pair.b : pair.a, j = pair.b;
  const float spin_b = b.rim_speed[j] / b.radius[j], spin_a = pair.of_piece() ? 0.0f : b.rim_speed[i] / b.radius[i];
  if (!(std::fabs(spin_b - spin_a) * dt > kRocking)) return false;
  const int open = pair.gap[1] > pair.gap[0] ? 1 : 0;
  if (pair.gap[1 - open] > kTouching * b.kind(pair.id_b).inner) return false;
  const ManifoldPoint& p = m.point[open];
  float x = b.vel[2 * j] - spin_b * p.by, y = b.vel[2 * j + 1] + spin_b * p.bx;
  if (!pair.of_piece()) {
    x -= b.vel[2 * i] - spin_a * p.ay;
    y -= b.vel[2 * i + 1] + spin_a * p.ax;
  }
  const float vn = m.nx * x + m.ny * y;
  return vn < -slowest && pair.gap[open] + 1.25f * dt * vn < 0;
}

// Whether the gap of a point that does not press closes in about h, s, faster than `slowest`, m/s.
bool closes(const kernels::BodyView& view, const kernels::ManifoldBlock& c, std::uint32_t l, double h, double slowest) {
  const std::size_t a = c.body[2 * l], b = c.body[2 * l + 1];
  const auto along = [&](const float* v) {
    return c.nx[l] * (v[2 * b] - v[2 * a]) + c.ny[l] * (v[2 * b + 1] - v[2 * a + 1]);
  };
  const float *const ta = view.arm_change + 2 * a, *const tb = view.arm_change + 2 * b;
  return std::ranges::any_of(c.point, [&](const kernels::ManifoldBlock::Point& p) {
    if (p.impulse[l] > 0) return false;
    const float turned = (tb[0] + c.lead_b[l] * tb[1]) * (p.bn[l] + c.round_b[l]) + tb[1] * p.bt[l] -
                         ((ta[0] + c.lead_a[l] * ta[1]) * (p.an[l] - c.round_a[l]) + ta[1] * p.at[l]);
    const double gap = p.gap[l] + along(view.disp) + turned;
    const double speed = along(view.vel) + view.rim_speed[b] * p.bt[l] - view.rim_speed[a] * p.at[l];
    return speed < -slowest && gap > h * speed && gap + 1.5 * h * speed < 0;
  });
}

// How two bodies move against each other, and how far they have moved since the frame's start.
struct PairMotion {
  Vec2 v, d;                   // m/s, m
  double spin = 0, swing = 0;  // m/s, m: what turning adds at most
};

PairMotion motion_of(const Around& in, const ManifoldPair& pair) {
  const kernels::BodyView& view = in.view;
  const std::size_t b = pair.b;
  PairMotion m{{view.vel[2 * b], view.vel[2 * b + 1]}, {view.disp[2 * b], view.disp[2 * b + 1]}};
  m.spin = std::fabs(double{view.rim_speed[b]});
  m.swing = double{in.s.bodies.radius[b]} * std::fabs(double{view.angle_change[b]});
  if (!pair.of_piece()) {
    const std::size_t a = pair.a;
    m.v = m.v - Vec2{view.vel[2 * a], view.vel[2 * a + 1]};
    m.d = m.d - Vec2{view.disp[2 * a], view.disp[2 * a + 1]};
    m.spin += std::fabs(double{view.rim_speed[a]});
    m.swing += double{in.s.bodies.radius[a]} * std::fabs(double{view.angle_change[a]});
  }
  return m;
}

// Whether bodies that were apart at the start of the step may meet in this substep, and turn so fast that it matters when.
bool turns_ahead(const Around& in, const ManifoldPair& pair, double dt, double h) {
  const PairMotion m = motion_of(in, pair);
  const Vec2 n{pair.manifold.nx, pair.manifold.ny};
  const double closing = m.spin - dot(n, m.v);
  return m.spin * dt > kTurning * double{in.s.bodies.radius[pair.b]} && closing > 2 * length_of(in.gravity) * dt &&
         double{pair.least_gap()} + dot(n, m.d) - m.swing < 1.5 * h * closing;
}

}  // namespace

// Lists the pairs of shapes that may collide in sweeps: those with restitution, and if they are not fully elastic, those
// whose bodies carry nothing.
void Solver::list_bouncing(const SolverInput& in) {
  Manifolds& manifolds = in.contacts.manifolds;
  bouncing_.resize(std::max(bouncing_.size(), manifolds.strip_count()));
  in.contacts.surroundings.pool.run(manifolds.strip_count(), [&](std::size_t index) {
    Manifolds::StripBlocks& strip = manifolds.strip(index);
    bouncing_[index].clear();
    for (const std::uint32_t k : strip.active) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      float& e = strip.blocks[pair.lane / kernels::kBlock].e[pair.lane % kernels::kBlock];
      if (e == 0) continue;
      manifolds.catch_up(strip, k);
      e = std::fabs(e);
      const bool rests = touched_[pair.b] != 0 || (!pair.fixed_a && touched_[pair.a] != 0);
      if (e == 1 || !rests)
        bouncing_[index].push_back({k, pair.lane, pair.of_piece() ? pair.b : pair.a, pair.b, e == 1, pair.ahead});
    }
  });
}

// Lists the pairs that may meet in a second point within the step.
void Solver::list_rocking(const SolverInput& in, double dt, double slowest) {
  const Manifolds& manifolds = in.contacts.manifolds;
  rocking_.resize(std::max(rocking_.size(), manifolds.strip_count()));
  in.contacts.surroundings.pool.run(manifolds.strip_count(), [&](std::size_t index) {
    rocking_[index].clear();
    for (const std::uint32_t k : manifolds.strip(index).open) {
      const ManifoldPair& pair = manifolds.pairs()[k];
      const bool stands = pair.impulse[0] > 0 && pair.impulse[1] > 0;
      if (!stands && rocks(in.contacts.surroundings.bodies, pair, static_cast<float>(dt), kernels::snapped(slowest))) {
        rocking_[index].push_back(k);
      }
    }
  });
}

// Impacts without restitution: what comes after them is left to the solver, which goes by the arms and the normal of their
// time.
void Solver::Run::meet_shapes() {
  Manifolds& manifolds = contacts.manifolds;
  run_phases(manifolds.strip_count(), s_.pool, [&](std::size_t index) {
    Manifolds::StripBlocks& strip = manifolds.strip(index);
    const Around around{s_, view_, manifolds, params_.surfaces, params_.gravity, solver_.sums_[index].shapes};
    const auto each = [&](const std::vector<std::uint32_t>& list, const auto& visit) {
      for (const std::uint32_t k : list) {
        ManifoldPair& pair = manifolds.pair(k);
        visit(pair, strip.blocks[pair.lane / kernels::kBlock], pair.lane % kernels::kBlock);
      }
    };
    each(solver_.rocking_[index], [&](ManifoldPair& pair, ManifoldBlock& block, std::uint32_t l) {
      const float e = block.e[l];
      const bool loaded = pair.impulse[0] > 0 || pair.impulse[1] > 0;  // else what bounces does so in the sweeps
      if (e != 0 && !(loaded && e > 0 && e < 1)) return;
      const double slowest = gravity_ * h_;
      if (closes(view_, block, l, h_, slowest)) ShapeImpact(around, pair, block, l).rock(manifolds, pair, h_, slowest);
    });
    each(strip.landing, [&](ManifoldPair& pair, ManifoldBlock& block, std::uint32_t l) {
      const bool opened = block.point[0].gap[l] >= kNoGap;  // in the last substep
      if (block.e[l] != 0 || !(opened || turns_ahead(around, pair, params_.dt, h_))) return;
      ShapeImpact(around, pair, block, l).land(manifolds, pair, h_);
    });
  });
}

bool Solver::Run::impact_shapes(std::size_t index, bool first, bool all) {
  Manifolds& manifolds = contacts.manifolds;
  Manifolds::StripBlocks& strip = manifolds.strip(index);
  const Around around{s_, view_, manifolds, params_.surfaces, params_.gravity, solver_.sums_[index].shapes};
  const double floor = discs_.pair.bounce_floor;
  bool any = false;
  for (const auto& [k, lane, a, b, elastic, ahead] : solver_.bouncing_[index]) {
    // Only impacts of elastic bodies go by slices: the energy of others falls anyway. Later sweeps look at bodies that had
    // an impact in this substep.
    if (!(elastic ? all : first) && view_.event_time[b] == 0 && view_.event_time[a] == 0) continue;
    ManifoldBlock& block = strip.blocks[lane / kernels::kBlock];
    const std::uint32_t l = lane % kernels::kBlock;
    float& e = block.e[l];
    e = std::fabs(e);
    if (e < 1 && !ahead && static_cast<double>(e) * (approach_of(view_, block, l) + gravity_ * h_) < floor) continue;
    const ManifoldPair& pair = manifolds.pairs()[k];
    const PairMotion m = motion_of(around, pair);
    const Vec2 n{pair.manifold.nx, pair.manifold.ny};
    const double added = m.spin + gravity_ * h_, closing = length_of(m.v) + added;
    if (e < 1 && static_cast<double>(e) * closing < floor) continue;  // too slow to bounce
    if (!ahead && double{pair.least_gap()} + dot(n, m.d) - m.swing > h_ * (added - dot(n, m.v))) {
      e = -e;  // too far apart to meet
      continue;
    }
    any |= ShapeImpact(around, pair, block, l)
               .collide_in(h_, floor, discs_.pair.least_e, elastic ? discs_.pair.due : 1e30f);
  }
  return any;
}

}  // namespace psim
