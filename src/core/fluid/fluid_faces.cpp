#include "fluid/fluid_faces.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace psim {

using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

float correct_faces(FluidGrid& grid, std::size_t tile, const FluidSpace& space) {
  const FluidTile& of = grid.tiles[tile];
  for (const S::Field f : {S::kEven, S::kDiagonal}) grid.pull_active(f, tile);
  grid.pull_near(S::kPressure, tile);
  const float *pressure = grid.field(S::kPressure, tile), *even = grid.field(S::kEven, tile);
  const float* diagonal = grid.field(S::kDiagonal, tile);
  float fastest = 0;
  const auto run = [&](std::array<S::Field, 6> f, std::size_t back, float per_cell) {
    const float *valid = grid.field(f[0], tile), *slope = grid.field(f[1], tile), *old = grid.field(f[2], tile);
    float *to = grid.field(f[3], tile), *gain = grid.field(f[4], tile), *shift = grid.field(f[5], tile);
    for (float* a : {gain, shift}) std::fill_n(a, kTileFloats, 0.0f);
    for (std::int32_t j = 0; j < of.high; ++j) {
      for (std::int32_t i = 0; i < of.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        to[n] = old[n];
        if (valid[n] == 0) continue;
        const float by = slope[n] * per_cell;
        to[n] = slope[n] > 0 ? old[n] - by * (pressure[n] - pressure[n - back]) : 0;
        gain[n] = to[n] - old[n];
        shift[n] = -by * (even[n] - even[n - back]);
        if (diagonal[n] > 0 && diagonal[n - back] > 0) fastest = std::max(fastest, std::fabs(to[n]));
      }
    }
  };
  run({S::kValidU, S::kSlopeX, S::kU, S::kNewU, S::kGainU, S::kShiftU}, 1, static_cast<float>(1 / space.cell_x));
  run({S::kValidV, S::kSlopeY, S::kV, S::kNewV, S::kGainV, S::kShiftV}, kTilePitch,
      static_cast<float>(1 / space.cell_y));
  return fastest;
}

void pull_faces(FluidGrid& grid, std::size_t tile, bool viscous) {
  for (const S::Field f : {S::kValidU, S::kValidV, S::kGainU, S::kGainV, S::kShiftU, S::kShiftV})
    grid.pull_near(f, tile);
  if (!viscous) return;
  for (const S::Field f : {S::kDragU, S::kDragV}) grid.pull_near(f, tile);
}

void extend_faces(FluidGrid& grid, std::size_t tile, bool viscous) {
  const FluidTile& of = grid.tiles[tile];
  const auto run = [&](S::Field valid_field, S::Field new_field, S::Field gain_field, S::Field shift_field,
                       S::Field drag_field) {
    const float* valid = grid.field(valid_field, tile);
    float *to = grid.field(new_field, tile), *gain = grid.field(gain_field, tile),
          *shift = grid.field(shift_field, tile);
    float* drag = viscous ? grid.field(drag_field, tile) : nullptr;
    for (std::int32_t j = 0; j < of.high; ++j) {
      for (std::int32_t i = 0; i < of.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        if (valid[n] != 0) continue;
        const std::size_t a = n - 1, b = n + 1, c = n - kTilePitch, d = n + kTilePitch;
        const float found = (valid[a] + valid[b]) + (valid[c] + valid[d]);
        if (found == 0) continue;
        const auto mean = [&](const float* x) {
          return ((valid[a] * x[a] + valid[b] * x[b]) + (valid[c] * x[c] + valid[d] * x[d])) / found;
        };
        gain[n] = mean(gain);
        shift[n] = mean(shift);
        if (viscous) drag[n] = mean(drag);
        to[n] += gain[n] + (viscous ? drag[n] : 0);
      }
    }
  };
  run(S::kValidU, S::kNewU, S::kGainU, S::kShiftU, S::kDragU);
  run(S::kValidV, S::kNewV, S::kGainV, S::kShiftV, S::kDragV);
}

// The velocities are kept in kWay and kChange, which the solver has done with.
void find_slip(FluidGrid& grid, std::size_t tile) {
  for (const S::Field f : {S::kSeen, S::kSolidU, S::kSolidV}) grid.pull_ring(f, tile);
  grid.pull_ring(S::kNewU, tile, S::kNewU, S::kU);
  grid.pull_ring(S::kNewV, tile, S::kNewV, S::kV);
  const float *u = grid.field(S::kNewU, tile), *v = grid.field(S::kNewV, tile), *seen = grid.field(S::kSeen, tile);
  const float *body_u = grid.field(S::kSolidU, tile), *body_v = grid.field(S::kSolidV, tile);
  const FluidTile& of = grid.tiles[tile];
  // Along an axis: `one` leads to the next node, `other` to the next across.
  const auto run = [&](S::Field valid_field, S::Field open_field, const float* along, const float* across,
                       const float* body, const float* body_across, std::size_t one, std::size_t other, S::Field to) {
    const float *valid = grid.field(valid_field, tile), *open = grid.field(open_field, tile);
    float* found = grid.field(to, tile);
    for (std::int32_t j = 0; j < of.high; ++j) {
      for (std::int32_t i = 0; i < of.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        found[n] = along[n];
        if (valid[n] != 0 || open[n] > 0.5f) continue;
        const float gx = seen[n] - seen[n - one];
        const float gy = ((seen[n + other] + seen[n - one + other]) - (seen[n - other] + seen[n - one - other])) / 4;
        const float steep = gx * gx + gy * gy;
        if (!(steep > 1e-4f)) continue;
        const auto mean = [&](const float* a) {
          return ((a[n] + a[n - one]) + (a[n + other] + a[n - one + other])) / 4;
        };
        found[n] -= gx * (gx * (along[n] - body[n]) + gy * (mean(across) - mean(body_across))) / steep;
      }
    }
  };
  run(S::kValidU, S::kOpenU, u, v, body_u, body_v, 1, kTilePitch, S::kWay);
  run(S::kValidV, S::kOpenV, v, u, body_v, body_u, kTilePitch, 1, S::kChange);
}

void set_slip(FluidGrid& grid, std::size_t tile) {
  const FluidTile& of = grid.tiles[tile];
  for (const auto& [from, to] : {std::pair{S::kWay, S::kNewU}, std::pair{S::kChange, S::kNewV}}) {
    const float* found = grid.field(from, tile);
    float* speed = grid.field(to, tile);
    for (std::int32_t j = 0; j < of.high; ++j) std::copy_n(found + tile_node(0, j), of.wide, speed + tile_node(0, j));
  }
}

}  // namespace psim
