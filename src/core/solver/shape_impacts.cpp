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

// How two bodies move against each other, and how far they have moved since the frame's start.
struct Motion {
  Vec2 v, d;                   // m/s, m
  double spin = 0, swing = 0;  // m/s, m: what turning adds at most
};

Motion motion_of(const Around& in, const ManifoldPair& pair) {
  const kernels::BodyView& view = in.view;
  const std::size_t b = pair.b;
  Motion m{{view.vel[2 * b], view.vel[2 * b + 1]}, {view.disp[2 * b], view.disp[2 * b + 1]}};
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
  const Motion m = motion_of(in, pair);
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
      e = std::fabs(e);
      const bool rests = touched_[pair.b] != 0 || (!pair.fixed_a && touched_[pair.a] != 0);
      if (e == 1 || !rests)
        bouncing_[index].push_back({k, pair.lane, pair.of_piece() ? pair.b : pair.a, pair.b, e == 1, pair.ahead});
    }
  });
}

// Impacts without restitution of bodies that were apart at the start of the step are left to the solver, which goes by the
// arms and the normal of the time of the impact.
void Solver::Run::foretell_landings() {
  Manifolds& manifolds = contacts.manifolds;
  s_.pool.run(manifolds.strip_count(), [&](std::size_t index) {
    Manifolds::StripBlocks& strip = manifolds.strip(index);
    const Around around{s_, view_, manifolds, params_.gravity, solver_.sums_[index].shapes};
    for (const std::uint32_t k : strip.landing) {
      ManifoldPair& pair = manifolds.pair(k);
      ManifoldBlock& block = strip.blocks[pair.lane / kernels::kBlock];
      const std::uint32_t l = pair.lane % kernels::kBlock;
      const bool opened = block.point[0].gap[l] >= kNoGap;  // in the last substep
      if (block.e[l] != 0 || !(opened || turns_ahead(around, pair, params_.dt, h_))) continue;
      ShapeImpact(around, pair, block, l).foretell(manifolds, pair, h_);
    }
  });
}

bool Solver::Run::impact_shapes(std::size_t index, bool first, bool all) {
  Manifolds& manifolds = contacts.manifolds;
  Manifolds::StripBlocks& strip = manifolds.strip(index);
  const Around around{s_, view_, manifolds, params_.gravity, solver_.sums_[index].shapes};
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
    const Motion m = motion_of(around, pair);
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
