#include "fluid/fluid_tension.h"

#include <algorithm>
#include <cmath>

namespace psim {

using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

namespace {

constexpr float kLeastSlope = 0.05f;     // of the share of fluid, by a cell: where it is less, there is no surface
constexpr float kLeastOpenShare = 0.3f;  // of a cell; with less, it takes the value of the cell beside it

// Calls each(n) for the own cells of a tile.
template <class Each>
void each_cell(const FluidTile& tile, const Each& each) {
  for (std::int32_t j = 0; j < tile.high; ++j) {
    for (std::int32_t i = 0; i < tile.wide; ++i) each(tile_node(i, j));
  }
}

// The mean around a cell with weights 1, 2, 1 both ways, of what is open.
float smoothed(const float* a, const float* open, std::size_t n) {
  const auto row = [&](std::size_t m, float& sum, float& weights, float by) {
    sum += by * ((open[m - 1] * a[m - 1] + open[m + 1] * a[m + 1]) + 2 * (open[m] * a[m]));
    weights += by * ((open[m - 1] + open[m + 1]) + 2 * open[m]);
  };
  float sum = 0, weights = 0;
  row(n - kTilePitch, sum, weights, 1);
  row(n, sum, weights, 2);
  row(n + kTilePitch, sum, weights, 1);
  return weights > 0 ? sum / weights : 0;
}

float sum_around(const float* a, std::size_t n) {
  const auto row = [&](std::size_t m) { return (a[m - 1] + a[m + 1]) + a[m]; };
  return (row(n - kTilePitch) + row(n + kTilePitch)) + row(n);
}

void pull(FluidGrid& grid, std::size_t tile, S::Field f) { grid.pull_ring(f, tile, f, FluidGrid::kNothing); }

}  // namespace

void smooth_share(FluidGrid& grid, std::size_t t, S::Field from, S::Field to) {
  pull(grid, t, from);
  pull(grid, t, S::kGainV);
  const float *share = grid.field(from, t), *open = grid.field(S::kGainV, t);
  float* smooth = grid.field(to, t);
  each_cell(grid.tiles[t], [&](std::size_t n) { smooth[n] = smoothed(share, open, n); });
}

void find_curvature(FluidGrid& grid, std::size_t t, const SurfaceTension& by) {
  pull(grid, t, S::kShiftV);
  const float *share = grid.field(S::kShiftV, t), *open = grid.field(S::kGainV, t);
  float *curvature = grid.field(S::kGainU, t), *weight = grid.field(S::kShiftU, t);
  const float per_x = 1 / by.cell_x, per_y = 1 / by.cell_y, sharpest = (per_x + per_y) / 2;
  each_cell(grid.tiles[t], [&](std::size_t n) {
    curvature[n] = weight[n] = 0;
    if (!(open[n] > kLeastOpenShare)) return;
    // A wall is like a mirror, so that surfaces meet it at a right angle.
    const auto f = [&](std::size_t m) { return share[open[m] > kLeastOpenShare ? m : n]; };
    const float left = f(n - 1), right = f(n + 1), below = f(n - kTilePitch), above = f(n + kTilePitch);
    const float x = (right - left) / 2 * per_x, y = (above - below) / 2 * per_y;
    const float slopes = x * x + y * y;
    if (!(slopes > (kLeastSlope * sharpest) * (kLeastSlope * sharpest))) return;
    const float xx = ((right + left) - 2 * share[n]) * per_x * per_x;
    const float yy = ((above + below) - 2 * share[n]) * per_y * per_y;
    const float xy =
        ((f(n + kTilePitch + 1) + f(n - kTilePitch - 1)) - (f(n + kTilePitch - 1) + f(n - kTilePitch + 1))) / 4 *
        per_x * per_y;
    const float bent = -((xx * y * y + yy * x * x) - 2 * (x * y) * xy) / (slopes * std::sqrt(slopes));
    // That of the line through the middle of this cell. The surface is where the share is one half.
    const float cell = 1 / sharpest, away = std::clamp((0.5f - share[n]) / std::sqrt(slopes), -cell, cell);
    const float at_surface = std::clamp(bent, -sharpest, sharpest);
    const float steep = slopes * cell * cell;
    weight[n] = steep * steep * steep;
    curvature[n] = std::clamp(at_surface / std::max(1 - at_surface * away, 0.5f), -sharpest, sharpest) * weight[n];
  });
}

void find_slopes(FluidGrid& grid, std::size_t t, const SurfaceTension& by) {
  pull(grid, t, S::kShiftV);
  if (by.by_fluid) grid.pull_ring(S::kWay, t);
  const float *share = grid.field(S::kShiftV, t), *shares = grid.field(S::kWay, t);
  const float* volume = grid.field(S::kVolume, t);
  float *slope_x = grid.field(S::kChange, t), *slope_y = grid.field(S::kOther, t);
  each_cell(grid.tiles[t], [&](std::size_t n) {
    const float x = (share[n + 1] - share[n - 1]) / 2, y = (share[n + kTilePitch] - share[n - kTilePitch]) / 2;
    float jump = x * x + y * y > kLeastSlope * kLeastSlope ? by.jump : 0;
    if (by.by_fluid && jump != 0) {
      const float around = sum_around(volume, n);
      jump *= around > 0 ? sum_around(shares, n) / around : 0;
    }
    slope_x[n] = jump * x / by.cell_x;
    slope_y[n] = jump * y / by.cell_y;
  });
}

void pull_bodies(const FluidGrid& grid, std::span<const std::uint32_t> tiles, FluidBodies& bodies) {
  for (const std::uint32_t t : tiles) {
    const float *slope_x = grid.field(S::kChange, t), *slope_y = grid.field(S::kOther, t);
    bodies.each_row(t, [&](std::uint32_t k, std::size_t n, float x, float y, float turn) {
      const float gx = slope_x[n], gy = slope_y[n], slope = std::sqrt(gx * gx + gy * gy);
      const float size = std::sqrt(x * x + y * y), across = x * gy - y * gx;
      if (!(slope > 0) || !(size > 0)) return;
      // Along the surface: (x, y) leads into the body, and this out of it.
      const float force = across / slope;
      const double arm = -static_cast<double>(std::fabs(across) / size);
      bodies.pull(k, static_cast<double>(-force * gy), static_cast<double>(force * gx),
                  arm * static_cast<double>(turn));
    });
  }
}

void find_surface_pressure(FluidGrid& grid, std::size_t t, const SurfaceTension& by) {
  pull(grid, t, S::kGainU);
  pull(grid, t, S::kShiftU);
  if (by.by_fluid) grid.pull_ring(S::kWay, t);
  const float *curvature = grid.field(S::kGainU, t), *weight = grid.field(S::kShiftU, t);
  const float *shares = grid.field(S::kWay, t), *volume = grid.field(S::kVolume, t);
  float* to = grid.field(S::kShiftV, t);
  each_cell(grid.tiles[t], [&](std::size_t n) {
    const float weights = sum_around(weight, n);
    to[n] = weights > 0 ? by.jump * (sum_around(curvature, n) / weights) : 0;
    if (!by.by_fluid || to[n] == 0) return;
    const float around = sum_around(volume, n);
    to[n] *= around > 0 ? sum_around(shares, n) / around : 0;
  });
}

}  // namespace psim
