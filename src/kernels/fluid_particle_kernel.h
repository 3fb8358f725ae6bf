// Between particles and the grid of a fluid. Weights are quadratic B-splines (Steffen, Kirby & Berzins 2008); a particle
// gives its velocity and the velocity's gradient (affine particle-in-cell, Jiang et al. 2015) and takes back what the
// grid gained (fluid-implicit particle, Brackbill & Ruppel 1986).
//
// A particle's place is measured in cells. Nodes of a kind lie on whole numbers or half-way between them.
#pragma once

#include "fluid_views.h"
#include "lane_vec.h"

namespace psim::kernels {
namespace {

template <class L>
using Four = typename L::Four;

/// Along an axis, the three nodes next to a particle and a fourth one, whose weights are 0.
template <class L>
struct Spline {
  std::int32_t first;  // number of the first node
  Four<L> w;           // weights of the nodes
  Four<L> ways;        // from the particle to them, cells
};
/// The same for the axis whose nodes are rows: three weights, and three ways.
struct Rows {
  std::int32_t first;
  float w[3], way[3];
};

/// Four axes at once: nodes on whole numbers or half-way between them, in x and in y, and whatever else is asked.
template <class L>
struct Splines {
  Four<L> w0, w1, w2;  // weights of the first, second and third node, by axis
  Four<L> off;         // from the second node to the particle
  float middle[4];     // number of the second node
  float w[3][4], way[4];

  /// `at`: where the particle is; half: 1/2 for nodes half-way between whole numbers, else 0.
  PSIM_INLINE Splines(Four<L> at, Four<L> half) {
    const Four<L> m = floor((at - half) + Four<L>(0.5f));
    off = (at - half) - m;
    const Four<L> below = Four<L>(0.5f) - off, above = Four<L>(0.5f) + off;
    w0 = Four<L>(0.5f) * (below * below);
    w1 = Four<L>(0.75f) - off * off;
    w2 = Four<L>(0.5f) * (above * above);
    store(middle, m);
    store(w[0], w0);
    store(w[1], w1);
    store(w[2], w2);
    store(way, off);
  }
  PSIM_INLINE std::int32_t first(std::size_t axis) const { return static_cast<std::int32_t>(middle[axis]) - 1; }
  /// Two of the axes as columns.
  PSIM_INLINE void columns(std::size_t a, Spline<L>& of_a, std::size_t b, Spline<L>& of_b) const {
    Four<L> column[4] = {w0, w1, w2, Four<L>(0.0f)};
    transpose(column[0], column[1], column[2], column[3]);
    const Four<L> nodes = {-1, 0, 1, 0};
    of_a = {first(a), column[a], nodes - Four<L>(way[a])};
    of_b = {first(b), column[b], nodes - Four<L>(way[b])};
  }
  PSIM_INLINE Rows rows(std::size_t axis) const {
    return {first(axis), {w[0][axis], w[1][axis], w[2][axis]}, {-1.0f - way[axis], -way[axis], 1.0f - way[axis]}};
  }
};

/// The derivatives of the weights by the particle's place.
template <class L>
PSIM_INLINE inline Four<L> slopes_of(const Spline<L>& s) {
  return s.ways * Four<L>(-1, 2, -1, 0) + Four<L>(-1.5f, 0, 1.5f, 0);
}
PSIM_INLINE inline float slope_of(const Rows& r, std::size_t row) {
  return row == 1 ? 2 * r.way[1] : row == 0 ? -1.5f - r.way[0] : 1.5f - r.way[2];
}

/// Adds mass and momentum of one component of the velocity to nine nodes.
template <class L>
PSIM_INLINE inline void give(const Spline<L>& sx, const Rows& sy, float mass, float value, float by_x, float by_y,
                             float* masses, float* momenta) {
  const std::size_t first = tile_node(sx.first, sy.first);
  const Four<L> row = Four<L>(value) + Four<L>(by_x) * sx.ways;
  for (std::size_t b = 0; b < 3; ++b) {
    float *m = masses + first + b * kTilePitch, *p = momenta + first + b * kTilePitch;
    const Four<L> w = Four<L>(mass * sy.w[b]) * sx.w;
    store(m, Four<L>::load(m) + w);
    store(p, Four<L>::load(p) + w * (row + Four<L>(by_y * sy.way[b])));
  }
}

/// Adds an amount to nine nodes.
template <class L, std::int32_t kPitch>
PSIM_INLINE inline void give(const Spline<L>& sx, const Rows& sy, float amount, float* node) {
  for (std::size_t b = 0; b < 3; ++b, node += kPitch) {
    store(node, Four<L>::load(node) + Four<L>(amount * sy.w[b]) * sx.w);
  }
}

/// Where a particle is among the nodes of a tile: on whole numbers (x0, y0), half-way (xh, yh), on the fine grid (xf, yf).
template <class L>
struct Place {
  Spline<L> x0, xh, xf;
  Rows y0, yh, yf;

  PSIM_INLINE explicit Place(const FluidParticle& p) {
    const Splines<L> cells({p.x, p.x, p.y, p.y}, {0, 0.5f, 0, 0.5f});
    cells.columns(0, x0, 1, xh);
    y0 = cells.rows(2);
    yh = cells.rows(3);
    const Splines<L> fine({2 * p.x, 2 * p.x, 2 * p.y, 2 * p.y}, 0.5f);
    fine.columns(0, xf, 0, xf);
    yf = fine.rows(2);
  }
};

/// Adds particles to the sums of their tile.
template <class L>
void scatter_fluid(const FluidParticle* particles, std::size_t count, const FluidMotion& motion, const FluidSums& to) {
  const float push = motion.dt * motion.history;
  const float fall_x = motion.dt * motion.gravity_x, fall_y = motion.dt * motion.gravity_y;
  for (std::size_t k = 0; k < count; ++k) {
    const FluidParticle& p = particles[k];
    const Place<L> at(p);
    const float mass = motion.mass[p.fluid], volume = motion.volume[p.fluid];
    const float u = p.u + (fall_x + push * p.push_x), v = p.v + (fall_y + push * p.push_y);
    give<L>(at.x0, at.yh, mass, u, p.ux * motion.cell_x, p.uy * motion.cell_y, to.mass_u, to.momentum_u);
    give<L>(at.xh, at.y0, mass, v, p.vx * motion.cell_x, p.vy * motion.cell_y, to.mass_v, to.momentum_v);
    give<L, kTilePitch>(at.xh, at.yh, volume, to.volume + tile_node(at.xh.first, at.yh.first));
    give<L, kFinePitch>(at.xf, at.yf, 4 * volume, to.fine + fine_node(at.xf.first, at.yf.first));
  }
}

/// Three rows of a field, by weights.
template <class L, std::int32_t kPitch>
PSIM_INLINE inline Four<L> rows(const float* node, float a, float b, float c) {
  return (Four<L>(a) * Four<L>::load(node) + Four<L>(b) * Four<L>::load(node + kPitch)) +
         Four<L>(c) * Four<L>::load(node + 2 * kPitch);
}
/// The rows by their weights.
template <class L>
PSIM_INLINE inline Four<L> rows_at(const float* field, const Spline<L>& sx, const Rows& sy) {
  return rows<L, kTilePitch>(field + tile_node(sx.first, sy.first), sy.w[0], sy.w[1], sy.w[2]);
}
/// The rows by the derivatives of their weights.
template <class L, std::int32_t kPitch>
PSIM_INLINE inline Four<L> rows_across(const float* node, const Rows& sy) {
  return rows<L, kPitch>(node, slope_of(sy, 0), slope_of(sy, 1), slope_of(sy, 2));
}

/// What a component of the velocity is at a particle, by a cell its gradient, and what it gained.
struct Speed {
  float value, by_x, by_y, gain;
};
/// The gradient is 4 (sum of w f d), d from the particle to the node: that of an affine field.
template <class L>
PSIM_INLINE inline Speed speed_at(const float* speed, const float* gain, const Spline<L>& sx, const Rows& sy) {
  const Four<L> along = sx.w * rows_at<L>(speed, sx, sy);
  const Four<L> across = rows<L, kTilePitch>(speed + tile_node(sx.first, sy.first), sy.w[0] * sy.way[0],
                                             sy.w[1] * sy.way[1], sy.w[2] * sy.way[2]);
  float s[4];
  store(s, sums(along, sx.ways * along, sx.w * across, sx.w * rows_at<L>(gain, sx, sy)));
  return {s[0], 4 * s[1], 4 * s[2], s[3]};
}

/// How steep the share of fluid is at a surface, by a cell.
inline constexpr float kSurface = 0.1f;
/// The longest way out of a dense place in a step, spacings.
inline constexpr float kLongestSpread = 0.2f;

/// Takes from the gradient (by_x, by_y) what points out of the surface.
template <class L>
PSIM_INLINE inline void keep_along_surface(const float* fill, const Place<L>& at, float& by_x, float& by_y) {
  const Four<L> none = 0.0f, along = rows_at<L>(fill, at.xh, at.yh);
  const Four<L> across = rows_across<L, kTilePitch>(fill + tile_node(at.xh.first, at.yh.first), at.yh);
  float n[4];
  store(n, sums(slopes_of<L>(at.xh) * along, at.xh.w * across, none, none));
  const float steep = n[0] * n[0] + n[1] * n[1];
  if (!(steep > kSurface * kSurface)) return;
  const float normal = (by_x * n[0] + by_y * n[1]) / steep;
  by_x -= normal * n[0];
  by_y -= normal * n[1];
}

/// Gives particles their new velocities, and moves them where the density is even.
template <class L>
void gather_fluid(FluidParticle* particles, std::size_t count, const FluidMotion& motion, const FluidFields& from) {
  const float dt = motion.dt, per_dt = 1 / dt;
  const float fall_x = dt * motion.gravity_x, fall_y = dt * motion.gravity_y;
  for (std::size_t k = 0; k < count; ++k) {
    FluidParticle& p = particles[k];
    const Place<L> at(p);
    const Speed u = speed_at<L>(from.u, from.gain_u, at.x0, at.yh), v = speed_at<L>(from.v, from.gain_v, at.xh, at.y0);
    const float* fine = from.fine + fine_node(at.xf.first, at.yf.first);
    const Four<L> fine_along = rows<L, kFinePitch>(fine, at.yf.w[0], at.yf.w[1], at.yf.w[2]);
    const Four<L> fine_across = rows_across<L, kFinePitch>(fine, at.yf);
    float s[4];  // shift, and the gradient of the number of particles by a spacing
    store(s, sums(at.x0.w * rows_at<L>(from.shift_u, at.x0, at.yh), at.xh.w * rows_at<L>(from.shift_v, at.xh, at.y0),
                  slopes_of<L>(at.xf) * fine_along, at.xf.w * fine_across));
    float gain_u = u.gain, gain_v = v.gain;
    if (from.drag_u != nullptr) {
      float drag[4];
      const Four<L> none = 0.0f;
      store(drag, sums(at.x0.w * rows_at<L>(from.drag_u, at.x0, at.yh), at.xh.w * rows_at<L>(from.drag_v, at.xh, at.y0),
                       none, none));
      gain_u += drag[0];
      gain_v += drag[1];
    }
    const float felt_x = motion.history * p.push_x, felt_y = motion.history * p.push_y;
    const float old_u = p.u + (fall_x + dt * felt_x), old_v = p.v + (fall_y + dt * felt_y);
    p.ux = u.by_x * motion.per_cell_x;
    p.uy = u.by_y * motion.per_cell_y;
    p.vx = v.by_x * motion.per_cell_x;
    p.vy = v.by_y * motion.per_cell_y;
    p.push_x = felt_x + u.gain * per_dt;
    p.push_y = felt_y + v.gain * per_dt;
    float by_x = s[2], by_y = s[3];
    if (from.edge[tile_node(at.xh.first + 1, at.yh.first + 1)] != 0) keep_along_surface<L>(from.volume, at, by_x, by_y);
    const float shear = p.uy + p.vx;
    const float strain = dt * sqrtf(p.ux * p.ux + p.vy * p.vy + 0.5f * (shear * shear)) * motion.strain;
    const float spreading = strain < 1 ? motion.spreading * strain : motion.spreading;
    const float way = spreading * sqrtf(by_x * by_x + by_y * by_y);
    const float spread = way > kLongestSpread ? spreading * (kLongestSpread / way) : spreading;
    const float shift_x = s[0] - 0.5f * spread * by_x * motion.cell_x;
    const float shift_y = s[1] - 0.5f * spread * by_y * motion.cell_y;
    p.u = old_u + gain_u - motion.calming * (old_u - (u.value - gain_u)) + (p.ux * shift_x + p.uy * shift_y);
    p.v = old_v + gain_v - motion.calming * (old_v - (v.value - gain_v)) + (p.vx * shift_x + p.vy * shift_y);
    p.x += shift_x * motion.per_cell_x;
    p.y += shift_y * motion.per_cell_y;
  }
}

/// Moves particles on by a step, as they move and are pushed.
template <class L>
void move_fluid(FluidParticle* particles, std::size_t count, const FluidMotion& motion) {
  const float dt = motion.dt, half = 0.5f * dt * dt;
  for (std::size_t k = 0; k < count; ++k) {
    FluidParticle& p = particles[k];
    p.x += (dt * p.u + half * (motion.gravity_x + p.push_x)) * motion.per_cell_x;
    p.y += (dt * p.v + half * (motion.gravity_y + p.push_y)) * motion.per_cell_y;
  }
}

}  // namespace
}  // namespace psim::kernels
