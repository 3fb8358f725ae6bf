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

/// Along an axis, the three nodes next to a particle; a lane is a particle.
template <class L>
struct Axis {
  F<L> middle;         // number of the second node
  F<L> w[3], ways[3];  // weights of the nodes, and from the particle to them, cells

  /// `at`: where the particle is; half: 1/2 for nodes half-way between whole numbers, else 0.
  PSIM_INLINE Axis(F<L> at, F<L> half) {
    middle = floor((at - half) + F<L>(0.5f));
    const F<L> off = (at - half) - middle;  // from the second node to the particle
    const F<L> below = F<L>(0.5f) - off, above = F<L>(0.5f) + off;
    w[0] = F<L>(0.5f) * (below * below);
    w[1] = F<L>(0.75f) - off * off;
    w[2] = F<L>(0.5f) * (above * above);
    for (int k = 0; k < 3; ++k) ways[k] = F<L>(static_cast<float>(k - 1)) - off;
  }
  /// The derivative of a weight by the particle's place.
  PSIM_INLINE F<L> slope(int k) const { return k == 1 ? F<L>(2.0f) * ways[1] : F<L>(k == 0 ? -1.5f : 1.5f) - ways[k]; }
};

/// Where particles are among the nodes of a tile: on whole numbers (x0, y0), half-way (xh, yh), on the fine grid (xf, yf).
template <class L>
struct Places {
  Axis<L> x0, xh, xf, y0, yh, yf;

  PSIM_INLINE Places(F<L> x, F<L> y)
      : x0(x, 0.0f), xh(x, 0.5f), xf(F<L>(2.0f) * x, 0.5f), y0(y, 0.0f), yh(y, 0.5f), yf(F<L>(2.0f) * y, 0.5f) {}
};

/// The particles that have a lane each: the next ones, and a spare one where there are no more.
template <class L, class Particle, class Float>
PSIM_INLINE inline void point_at(Particle* particles, std::size_t count, Particle& spare, Float* (&at)[L::width]) {
  for (std::size_t k = 0; k < L::width; ++k) at[k] = reinterpret_cast<Float*>(k < count ? particles + k : &spare);
}
static_assert(sizeof(FluidParticle) == 12 * sizeof(float));
/// Where members of a particle begin, in floats.
enum FluidMember : std::size_t { kPlaceAndVelocity = 0, kPushAndGradientU = 4, kGradient = 6 };

/// Numbers that belong to a particle, in fours: written a lane each, read one by one.
template <class L, std::size_t kFours>
struct Fours {
  alignas(32) float of[L::width][kFours][4];

  PSIM_INLINE void put(std::size_t four, F<L> a, F<L> b, F<L> c, F<L> d = 0.0f) {
    float* at[L::width];
    for (std::size_t k = 0; k < L::width; ++k) at[k] = of[k][four];
    L::scatter4(at, 0, a, b, c, d);
  }
  PSIM_INLINE void put(std::size_t four, const F<L> (&three)[3]) { put(four, three[0], three[1], three[2]); }
  PSIM_INLINE void get(std::size_t four, F<L>& a, F<L>& b, F<L>& c, F<L>& d) const {
    const float* at[L::width];
    for (std::size_t k = 0; k < L::width; ++k) at[k] = of[k][four];
    L::gather4(at, 0, a, b, c, d);
  }
};

/// For each particle the number of the first of nine nodes.
template <class L>
struct FirstNodes {
  alignas(32) float of[L::width];

  PSIM_INLINE FirstNodes(const Axis<L>& x, const Axis<L>& y, std::int32_t pitch) {
    L::store(of, y.middle * F<L>(static_cast<float>(pitch)) + x.middle);
  }
  PSIM_INLINE std::size_t operator[](std::size_t lane) const {
    return static_cast<std::size_t>(static_cast<std::int32_t>(of[lane]));
  }
};

/// Adds mass and momentum of one component of the velocity to nine nodes. `weights`: of the columns; `ways`: to them.
/// `rows`: their masses, and the velocity; `across`: what it gains up to them, and by a column.
template <class L>
PSIM_INLINE inline void give(const float* weights, const float* ways, const float* rows, const float* across,
                             float* masses, float* momenta) {
  const Four<L> columns = Four<L>::load(weights);
  const Four<L> row = Four<L>(rows[3]) + Four<L>(across[3]) * Four<L>::load(ways);
  for (std::size_t b = 0; b < 3; ++b, masses += kTilePitch, momenta += kTilePitch) {
    const Four<L> w = Four<L>(rows[b]) * columns;
    store(masses, Four<L>::load(masses) + w);
    store(momenta, Four<L>::load(momenta) + w * (row + Four<L>(across[b])));
  }
}

/// Adds an amount to nine nodes. `rows`: what is each row's.
template <class L, std::int32_t kPitch>
PSIM_INLINE inline void give(const float* weights, const float* rows, float* node) {
  const Four<L> columns = Four<L>::load(weights);
  for (std::size_t b = 0; b < 3; ++b, node += kPitch) {
    store(node, Four<L>::load(node) + Four<L>(rows[b]) * columns);
  }
}

/// Adds particles to the sums of their tile.
template <class L>
void scatter_fluid(const FluidParticle* particles, std::size_t count, const FluidMotion& motion, const FluidSums& to) {
  enum { kX0, kX0Ways, kXh, kXhWays, kXf, kRowsU, kAcrossU, kRowsV, kAcrossV, kRowsVolume, kRowsFine, kFours };
  const F<L> push = motion.dt * motion.history;
  const F<L> fall_x = motion.dt * motion.gravity_x, fall_y = motion.dt * motion.gravity_y;
  const FluidParticle spare = {};
  Fours<L, kFours> fours;
  for (std::size_t k = 0; k < count; k += L::width) {
    const std::size_t lanes = count - k < L::width ? count - k : L::width;
    const float* of[L::width];
    point_at<L>(particles + k, lanes, spare, of);
    alignas(32) float masses[L::width] = {}, volumes[L::width] = {};
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      masses[lane] = motion.mass[particles[k + lane].fluid];
      volumes[lane] = motion.volume[particles[k + lane].fluid];
    }
    F<L> x, y, u, v, push_x, push_y, ux, uy, vx, vy;
    L::gather4(of, kPlaceAndVelocity, x, y, u, v);
    L::gather4(of, kPushAndGradientU, push_x, push_y, ux, uy);
    L::gather4(of, kGradient, ux, uy, vx, vy);
    u = u + (fall_x + push * push_x);
    v = v + (fall_y + push * push_y);
    const F<L> by_y_of_u = uy * F<L>(motion.cell_y), by_y_of_v = vy * F<L>(motion.cell_y);
    const F<L> mass = L::load(masses), volume = L::load(volumes), fine = F<L>(4.0f) * volume;

    const Places<L> at(x, y);
    const F<L>(&w0)[3] = at.y0.w, (&wh)[3] = at.yh.w, (&wf)[3] = at.yf.w;
    fours.put(kX0, at.x0.w);
    fours.put(kX0Ways, at.x0.ways);
    fours.put(kXh, at.xh.w);
    fours.put(kXhWays, at.xh.ways);
    fours.put(kXf, at.xf.w);
    fours.put(kRowsU, mass * wh[0], mass * wh[1], mass * wh[2], u);
    fours.put(kAcrossU, by_y_of_u * at.yh.ways[0], by_y_of_u * at.yh.ways[1], by_y_of_u * at.yh.ways[2],
              ux * F<L>(motion.cell_x));
    fours.put(kRowsV, mass * w0[0], mass * w0[1], mass * w0[2], v);
    fours.put(kAcrossV, by_y_of_v * at.y0.ways[0], by_y_of_v * at.y0.ways[1], by_y_of_v * at.y0.ways[2],
              vx * F<L>(motion.cell_x));
    fours.put(kRowsVolume, volume * wh[0], volume * wh[1], volume * wh[2]);
    fours.put(kRowsFine, fine * wf[0], fine * wf[1], fine * wf[2]);
    const FirstNodes<L> of_u(at.x0, at.yh, kTilePitch), of_v(at.xh, at.y0, kTilePitch),
        middle(at.xh, at.yh, kTilePitch);
    const FirstNodes<L> of_fine(at.xf, at.yf, kFinePitch);

    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const auto& f = fours.of[lane];
      const std::size_t nu = of_u[lane], nv = of_v[lane];
      give<L>(f[kX0], f[kX0Ways], f[kRowsU], f[kAcrossU], to.mass_u + nu, to.momentum_u + nu);
      give<L>(f[kXh], f[kXhWays], f[kRowsV], f[kAcrossV], to.mass_v + nv, to.momentum_v + nv);
      give<L, kTilePitch>(f[kXh], f[kRowsVolume], to.volume + middle[lane]);
      give<L, kFinePitch>(f[kXf], f[kRowsFine], to.fine + of_fine[lane]);
    }
  }
}

/// The sum of three rows of nodes, each by its weight.
template <class L, std::int32_t kPitch>
PSIM_INLINE inline Four<L> sum_rows(const float* node, const float* w) {
  return (Four<L>(w[0]) * Four<L>::load(node) + Four<L>(w[1]) * Four<L>::load(node + kPitch)) +
         Four<L>(w[2]) * Four<L>::load(node + 2 * kPitch);
}

/// How steep the share of fluid is at a surface, by a cell.
inline constexpr float kSurface = 0.1f;
/// The longest way out of a dense place in a step, spacings.
inline constexpr float kLongestSpread = 0.2f;

/// Takes from the gradient (by_x, by_y) what points out of the surface. (n_x, n_y): the gradient of the share of fluid.
PSIM_INLINE inline void keep_along_surface(float n_x, float n_y, float& by_x, float& by_y) {
  const float steep = n_x * n_x + n_y * n_y;
  if (!(steep > kSurface * kSurface)) return;
  const float normal = (by_x * n_x + by_y * n_y) / steep;
  by_x -= normal * n_x;
  by_y -= normal * n_y;
}

/// What gather_fluid needs to know of where a particle is, and what it finds there.
struct GatherFours {
  enum {
    kX0,
    kX0Ways,
    kXh,
    kXhWays,
    kXhSlopes,
    kXf,
    kXfSlopes,
    kY0,
    kAcross0,
    kYh,
    kAcrossH,
    kYhSlopes,
    kYf,
    kYfSlopes
  };
  enum { kSpeedU = kYfSlopes + 1, kSpeedV, kShift, kDrag, kFours };
};

/// Sums over the nodes of the particle in a lane: of each component the velocity, by_x / 4 and by_y / 4 of it, and what
/// it gained; the displacement, and the gradient of the number of particles by a spacing; what viscosity gave.
template <class L>
PSIM_INLINE inline void take(const FluidFields& from, std::size_t of_u, std::size_t of_v, std::size_t middle,
                             std::size_t of_fine, float (&f)[GatherFours::kFours][4]) {
  using G = GatherFours;
  const Four<L> x0 = Four<L>::load(f[G::kX0]), xh = Four<L>::load(f[G::kXh]), xf = Four<L>::load(f[G::kXf]);
  const auto rows = [](const float* node, const float* w)
                        PSIM_INLINE_LAMBDA { return sum_rows<L, kTilePitch>(node, w); };
  const Four<L> along_u = x0 * rows(from.u + of_u, f[G::kYh]), along_v = xh * rows(from.v + of_v, f[G::kY0]);
  store(f[G::kSpeedU], sums(along_u, Four<L>::load(f[G::kX0Ways]) * along_u, x0 * rows(from.u + of_u, f[G::kAcrossH]),
                            x0 * rows(from.gain_u + of_u, f[G::kYh])));
  store(f[G::kSpeedV], sums(along_v, Four<L>::load(f[G::kXhWays]) * along_v, xh * rows(from.v + of_v, f[G::kAcross0]),
                            xh * rows(from.gain_v + of_v, f[G::kY0])));
  store(f[G::kShift], sums(x0 * rows(from.shift_u + of_u, f[G::kYh]), xh * rows(from.shift_v + of_v, f[G::kY0]),
                           Four<L>::load(f[G::kXfSlopes]) * sum_rows<L, kFinePitch>(from.fine + of_fine, f[G::kYf]),
                           xf * sum_rows<L, kFinePitch>(from.fine + of_fine, f[G::kYfSlopes])));
  const Four<L> none = 0.0f;
  if (from.edge[middle + tile_node(0, 0)] != 0) {
    const float* fill = from.volume + middle;
    float n[4];
    store(n,
          sums(Four<L>::load(f[G::kXhSlopes]) * rows(fill, f[G::kYh]), xh * rows(fill, f[G::kYhSlopes]), none, none));
    keep_along_surface(n[0], n[1], f[G::kShift][2], f[G::kShift][3]);
  }
  if (from.drag_u != nullptr) {
    store(f[G::kDrag],
          sums(x0 * rows(from.drag_u + of_u, f[G::kYh]), xh * rows(from.drag_v + of_v, f[G::kY0]), none, none));
  }
}

/// Gives particles their new velocities, and moves them where the density is even.
template <class L>
void gather_fluid(FluidParticle* particles, std::size_t count, const FluidMotion& motion, const FluidFields& from) {
  using G = GatherFours;
  const F<L> dt = motion.dt, per_dt = 1 / motion.dt, history = motion.history, calming = motion.calming;
  const F<L> fall_x = motion.dt * motion.gravity_x, fall_y = motion.dt * motion.gravity_y;
  FluidParticle spare = {};
  Fours<L, G::kFours> fours = {};
  for (std::size_t k = 0; k < count; k += L::width) {
    const std::size_t lanes = count - k < L::width ? count - k : L::width;
    float* of[L::width];
    point_at<L>(particles + k, lanes, spare, of);
    F<L> x, y, u, v, push_x, push_y, ux, uy, vx, vy;
    L::gather4(of, kPlaceAndVelocity, x, y, u, v);
    L::gather4(of, kPushAndGradientU, push_x, push_y, ux, uy);

    const Places<L> at(x, y);
    fours.put(G::kX0, at.x0.w);
    fours.put(G::kX0Ways, at.x0.ways);
    fours.put(G::kXh, at.xh.w);
    fours.put(G::kXhWays, at.xh.ways);
    fours.put(G::kXhSlopes, at.xh.slope(0), at.xh.slope(1), at.xh.slope(2));
    fours.put(G::kXf, at.xf.w);
    fours.put(G::kXfSlopes, at.xf.slope(0), at.xf.slope(1), at.xf.slope(2));
    fours.put(G::kY0, at.y0.w);
    fours.put(G::kAcross0, at.y0.w[0] * at.y0.ways[0], at.y0.w[1] * at.y0.ways[1], at.y0.w[2] * at.y0.ways[2]);
    fours.put(G::kYh, at.yh.w);
    fours.put(G::kAcrossH, at.yh.w[0] * at.yh.ways[0], at.yh.w[1] * at.yh.ways[1], at.yh.w[2] * at.yh.ways[2]);
    fours.put(G::kYhSlopes, at.yh.slope(0), at.yh.slope(1), at.yh.slope(2));
    fours.put(G::kYf, at.yf.w);
    fours.put(G::kYfSlopes, at.yf.slope(0), at.yf.slope(1), at.yf.slope(2));
    const FirstNodes<L> of_u(at.x0, at.yh, kTilePitch), of_v(at.xh, at.y0, kTilePitch),
        middle(at.xh, at.yh, kTilePitch);
    const FirstNodes<L> of_fine(at.xf, at.yf, kFinePitch);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      take<L>(from, of_u[lane], of_v[lane], middle[lane], of_fine[lane], fours.of[lane]);
    }

    F<L> u_here, v_here, gain_u, gain_v, shift_x, shift_y, by_x, by_y;
    fours.get(G::kSpeedU, u_here, ux, uy, gain_u);
    fours.get(G::kSpeedV, v_here, vx, vy, gain_v);
    fours.get(G::kShift, shift_x, shift_y, by_x, by_y);
    const F<L> felt_x = history * push_x, felt_y = history * push_y;
    const F<L> old_u = u + (fall_x + dt * felt_x), old_v = v + (fall_y + dt * felt_y);
    push_x = felt_x + gain_u * per_dt;
    push_y = felt_y + gain_v * per_dt;
    if (from.drag_u != nullptr) {
      F<L> drag_u, drag_v, nothing, zero;
      fours.get(G::kDrag, drag_u, drag_v, nothing, zero);
      gain_u += drag_u;
      gain_v += drag_v;
    }
    // The gradient is 4 (sum of w f d), d from the particle to the node: that of an affine field.
    const F<L> four = 4.0f, per_cell_x = motion.per_cell_x, per_cell_y = motion.per_cell_y;
    ux = (four * ux) * per_cell_x;
    uy = (four * uy) * per_cell_y;
    vx = (four * vx) * per_cell_x;
    vy = (four * vy) * per_cell_y;
    const F<L> shear = uy + vx, half = 0.5f, most = motion.spreading, longest = kLongestSpread;
    const F<L> strain = dt * sqrt(ux * ux + vy * vy + half * (shear * shear)) * F<L>(motion.strain);
    const F<L> spreading = select(strain < F<L>(1.0f), most * strain, most);
    const F<L> way = spreading * sqrt(by_x * by_x + by_y * by_y);
    const F<L> spread = select(longest < way, spreading * (longest / way), spreading);
    shift_x -= half * spread * by_x * F<L>(motion.cell_x);
    shift_y -= half * spread * by_y * F<L>(motion.cell_y);
    u = old_u + gain_u - calming * (old_u - (u_here - gain_u)) + (ux * shift_x + uy * shift_y);
    v = old_v + gain_v - calming * (old_v - (v_here - gain_v)) + (vx * shift_x + vy * shift_y);
    L::scatter4(of, kPlaceAndVelocity, x + shift_x * per_cell_x, y + shift_y * per_cell_y, u, v);
    L::scatter4(of, kPushAndGradientU, push_x, push_y, ux, uy);
    L::scatter4(of, kGradient, ux, uy, vx, vy);
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
