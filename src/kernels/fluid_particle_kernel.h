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

/// The three nodes next to a particle along an axis.
struct Spline {
  std::int32_t first;  // number of the first of them
  float off;           // from the middle one to the particle, cells: -1/2 to 1/2
  float w[3];          // their weights
};

PSIM_INLINE inline Spline spline_at(std::int32_t middle, float off) {
  const float below = 0.5f - off, above = 0.5f + off;
  return {middle - 1, off, {0.5f * (below * below), 0.75f - off * off, 0.5f * (above * above)}};
}
PSIM_INLINE inline std::int32_t floor_int(float a) {
  const auto i = static_cast<std::int32_t>(a);
  return i - (static_cast<float>(i) > a ? 1 : 0);
}
/// Of nodes on whole numbers.
PSIM_INLINE inline Spline spline_whole(float x) {
  const std::int32_t middle = floor_int(x + 0.5f);
  return spline_at(middle, x - static_cast<float>(middle));
}
/// Of nodes half-way between them: node i lies at i + 1/2.
PSIM_INLINE inline Spline spline_half(float x) {
  const std::int32_t middle = floor_int(x);
  return spline_at(middle, (x - 0.5f) - static_cast<float>(middle));
}

/// Adds mass and momentum of one component of the velocity to nine nodes.
PSIM_INLINE inline void give(const Spline& sx, const Spline& sy, float mass, float value, float by_x, float by_y,
                             float* masses, float* momenta) {
  const std::size_t first = tile_node(sx.first, sy.first);
  const float corner = value - by_x * (1.0f + sx.off) - by_y * (1.0f + sy.off);
  for (std::size_t b = 0; b < 3; ++b) {
    const float row = mass * sy.w[b], start = corner + by_y * static_cast<float>(b);
    float *m = masses + first + b * kTilePitch, *p = momenta + first + b * kTilePitch;
    for (std::size_t a = 0; a < 3; ++a) {
      const float w = row * sx.w[a];
      m[a] += w;
      p[a] += w * (start + by_x * static_cast<float>(a));
    }
  }
}

/// Adds particles to the sums of their tile.
template <class L>
void scatter_fluid(const FluidParticle* particles, std::size_t count, const FluidMotion& motion, const FluidSums& to) {
  const float push = motion.dt * motion.history;
  const float fall_x = motion.dt * motion.gravity_x, fall_y = motion.dt * motion.gravity_y;
  for (std::size_t k = 0; k < count; ++k) {
    const FluidParticle& p = particles[k];
    const Spline wx = spline_whole(p.x), hx = spline_half(p.x), wy = spline_whole(p.y), hy = spline_half(p.y);
    const float mass = motion.mass[p.fluid], volume = motion.volume[p.fluid];
    const float u = p.u + (fall_x + push * p.push_x), v = p.v + (fall_y + push * p.push_y);
    give(wx, hy, mass, u, p.ux * motion.cell_x, p.uy * motion.cell_y, to.mass_u, to.momentum_u);
    give(hx, wy, mass, v, p.vx * motion.cell_x, p.vy * motion.cell_y, to.mass_v, to.momentum_v);
    float* cell = to.volume + tile_node(hx.first, hy.first);
    for (std::size_t b = 0; b < 3; ++b, cell += kTilePitch) {
      const float row = volume * hy.w[b];
      for (std::size_t a = 0; a < 3; ++a) cell[a] += row * hx.w[a];
    }
    const Spline fx = spline_half(2 * p.x), fy = spline_half(2 * p.y);
    float* node = to.fine + fine_node(fx.first, fy.first);
    for (std::size_t b = 0; b < 3; ++b, node += kFinePitch) {
      const float row = 4 * volume * fy.w[b];
      for (std::size_t a = 0; a < 3; ++a) node[a] += row * fx.w[a];
    }
  }
}

/// The value of a field at a particle.
PSIM_INLINE inline float value_at(const float* field, const Spline& sx, const Spline& sy) {
  const float* node = field + tile_node(sx.first, sy.first);
  float sum = 0;
  for (std::size_t b = 0; b < 3; ++b, node += kTilePitch) {
    sum += sy.w[b] * (sx.w[0] * node[0] + sx.w[1] * node[1] + sx.w[2] * node[2]);
  }
  return sum;
}

struct ValueAndSlope {
  float value, by_x, by_y;  // by a cell
};
/// The same, and its gradient: 4 (sum of w f d), d from the particle to the node, is that of an affine field.
PSIM_INLINE inline ValueAndSlope slope_at(const float* field, const Spline& sx, const Spline& sy) {
  const float* node = field + tile_node(sx.first, sy.first);
  ValueAndSlope s = {0, 0, 0};
  const float dx[3] = {-1.0f - sx.off, -sx.off, 1.0f - sx.off};
  const float dy[3] = {-1.0f - sy.off, -sy.off, 1.0f - sy.off};
  const float wx[3] = {sx.w[0] * dx[0], sx.w[1] * dx[1], sx.w[2] * dx[2]};
  for (std::size_t b = 0; b < 3; ++b, node += kTilePitch) {
    const float row = sx.w[0] * node[0] + sx.w[1] * node[1] + sx.w[2] * node[2];
    s.value += sy.w[b] * row;
    s.by_x += sy.w[b] * (wx[0] * node[0] + wx[1] * node[1] + wx[2] * node[2]);
    s.by_y += sy.w[b] * dy[b] * row;
  }
  s.by_x *= 4;
  s.by_y *= 4;
  return s;
}

/// The gradient of a field by the derivatives of the weights, by a node.
template <std::int32_t kPitch>
PSIM_INLINE inline void gradient_at(const float* node, const Spline& sx, const Spline& sy, float& by_x, float& by_y) {
  const float dx[3] = {sx.off - 0.5f, -2 * sx.off, sx.off + 0.5f};
  const float dy[3] = {sy.off - 0.5f, -2 * sy.off, sy.off + 0.5f};
  by_x = by_y = 0;
  for (std::size_t b = 0; b < 3; ++b, node += kPitch) {
    by_x += sy.w[b] * (dx[0] * node[0] + dx[1] * node[1] + dx[2] * node[2]);
    by_y += dy[b] * (sx.w[0] * node[0] + sx.w[1] * node[1] + sx.w[2] * node[2]);
  }
}

/// How steep the share of fluid is at a surface, by a cell.
inline constexpr float kSurface = 0.1f;
/// The longest way out of a dense place in a step, spacings.
inline constexpr float kLongestSpread = 0.2f;

/// Gives particles their new velocities, and moves them where the density is even.
template <class L>
void gather_fluid(FluidParticle* particles, std::size_t count, const FluidMotion& motion, const FluidFields& from) {
  const float dt = motion.dt, per_dt = 1 / dt;
  const float fall_x = dt * motion.gravity_x, fall_y = dt * motion.gravity_y;
  for (std::size_t k = 0; k < count; ++k) {
    FluidParticle& p = particles[k];
    const Spline wx = spline_whole(p.x), hx = spline_half(p.x), wy = spline_whole(p.y), hy = spline_half(p.y);
    const float felt_x = motion.history * p.push_x, felt_y = motion.history * p.push_y;
    const float u = p.u + (fall_x + dt * felt_x), v = p.v + (fall_y + dt * felt_y);
    const ValueAndSlope nu = slope_at(from.u, wx, hy), nv = slope_at(from.v, hx, wy);
    const float push_u = value_at(from.gain_u, wx, hy), push_v = value_at(from.gain_v, hx, wy);
    const float gain_u = from.drag_u == nullptr ? push_u : push_u + value_at(from.drag_u, wx, hy);
    const float gain_v = from.drag_v == nullptr ? push_v : push_v + value_at(from.drag_v, hx, wy);
    float shift_x = value_at(from.shift_u, wx, hy), shift_y = value_at(from.shift_v, hx, wy);
    p.ux = nu.by_x * motion.per_cell_x;
    p.uy = nu.by_y * motion.per_cell_y;
    p.vx = nv.by_x * motion.per_cell_x;
    p.vy = nv.by_y * motion.per_cell_y;
    p.push_x = felt_x + push_u * per_dt;
    p.push_y = felt_y + push_v * per_dt;
    const float to_u = u + gain_u - motion.calming * (u - (nu.value - gain_u));
    const float to_v = v + gain_v - motion.calming * (v - (nv.value - gain_v));
    const Spline fx = spline_half(2 * p.x), fy = spline_half(2 * p.y);
    float by_x, by_y, nx, ny;
    gradient_at<kFinePitch>(from.fine + fine_node(fx.first, fy.first), fx, fy, by_x, by_y);
    gradient_at<kTilePitch>(from.volume + tile_node(hx.first, hy.first), hx, hy, nx, ny);
    const float steep = nx * nx + ny * ny;
    if (from.edge[tile_node(hx.first + 1, hy.first + 1)] != 0 &&
        steep > kSurface * kSurface) {  // along the surface only
      const float normal = (by_x * nx + by_y * ny) / steep;
      by_x -= normal * nx;
      by_y -= normal * ny;
    }
    const float way = motion.spreading * sqrtf(by_x * by_x + by_y * by_y);
    const float spread = way > kLongestSpread ? motion.spreading * (kLongestSpread / way) : motion.spreading;
    shift_x -= 0.5f * spread * by_x * motion.cell_x;
    shift_y -= 0.5f * spread * by_y * motion.cell_y;
    p.u = to_u + (p.ux * shift_x + p.uy * shift_y);
    p.v = to_v + (p.vx * shift_x + p.vy * shift_y);
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
