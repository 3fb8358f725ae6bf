#include "fluid/fluid_transfer.h"

#include <algorithm>

namespace psim {

using kernels::kFinePitch;
using kernels::kTile;
using kernels::kTileFloats;
using kernels::kTilePitch;
using kernels::tile_node;
using S = FluidSolver;

namespace {

constexpr float kLeastMass = 1e-6f;  // of a face that has a velocity, by that of a full cell
constexpr S::Field kSums[] = {S::kMassU, S::kU, S::kMassV, S::kV, S::kVolume};

// A square of floats: a field, or the fine grid.
struct Square {
  S::Field field;
  std::int32_t pitch, nodes;  // floats a row; nodes a cell
  std::int32_t spill;         // nodes beyond the upper end of a tile that its particles reach; one beyond the lower end

  std::size_t node(std::int32_t i, std::int32_t j) const {
    const std::int32_t n = (j + 1) * pitch + i + 1;
    return static_cast<std::size_t>(n);
  }
};
constexpr Square square_of(S::Field f) {
  return f == S::kFine ? Square{f, kFinePitch, 2, 1} : Square{f, kTilePitch, 1, 2};
}

// Adds what the particles of the neighbour k gave to the nodes of a tile.
void add_spill(FluidGrid& grid, std::size_t tile, int k, const Square& s) {
  const FluidTile &to = grid.tiles[tile], &from = grid.tiles[to.near[k]];
  const int dx = k % 3 - 1, dy = k / 3 - 1;
  const std::int32_t wide = s.nodes * to.wide, high = s.nodes * to.high;
  const std::int32_t i0 = dx > 0 ? wide - 1 : 0, i1 = dx < 0 ? std::min(s.spill, wide) : wide;
  const std::int32_t j0 = dy > 0 ? high - 1 : 0, j1 = dy < 0 ? std::min(s.spill, high) : high;
  const std::int32_t right = dx < 0 ? s.nodes * from.wide : dx > 0 ? -wide : 0;
  const std::int32_t up = dy < 0 ? s.nodes * from.high : dy > 0 ? -high : 0;
  float* sums = grid.field(s.field, tile);
  const float* given = grid.field(s.field, to.near[k]);
  for (std::int32_t j = j0; j < j1; ++j) {
    for (std::int32_t i = i0; i < i1; ++i) sums[s.node(i, j)] += given[s.node(i + right, j + up)];
  }
}

// One node around a tile's part of the fine grid, from its neighbours.
void pull_fine(FluidGrid& grid, std::size_t tile) {
  const Square s = square_of(S::kFine);
  const FluidTile& to = grid.tiles[tile];
  float* fine = grid.field(S::kFine, tile);
  const std::int32_t wide = 2 * to.wide, high = 2 * to.high;
  for (int k = 0; k < 9; ++k) {
    if (k == 4) continue;
    const int dx = k % 3 - 1, dy = k / 3 - 1;
    const bool there = to.near[k] != FluidTile::kNone;
    const float* from = there ? grid.field(S::kFine, to.near[k]) : nullptr;
    const std::int32_t i = dx < 0 ? -1 : dx > 0 ? wide : 0, j = dy < 0 ? -1 : dy > 0 ? high : 0;
    const std::int32_t from_i = dx < 0 && there ? 2 * grid.tiles[to.near[k]].wide - 1 : 0;
    const std::int32_t from_j = dy < 0 && there ? 2 * grid.tiles[to.near[k]].high - 1 : 0;
    for (std::int32_t b = 0; b < (dy == 0 ? high : 1); ++b) {
      for (std::int32_t a = 0; a < (dx == 0 ? wide : 1); ++a) {
        fine[s.node(i + a, j + b)] = there ? from[s.node(from_i + a, from_j + b)] : 0;
      }
    }
  }
}

}  // namespace

void scatter_particles(FluidGrid& grid, std::size_t t, const FluidParticles& particles,
                       const kernels::KernelTable& kernels, const kernels::FluidMotion& motion) {
  for (const S::Field f : kSums) std::fill_n(grid.field(f, t), kTileFloats, 0.0f);
  std::fill_n(grid.field(S::kFine, t), kernels::kFineFloats, 0.0f);
  const FluidTile& tile = grid.tiles[t];
  if (tile.count == 0) return;
  const kernels::FluidSums to = {grid.field(S::kMassU, t), grid.field(S::kU, t),      grid.field(S::kMassV, t),
                                 grid.field(S::kV, t),     grid.field(S::kVolume, t), grid.field(S::kFine, t)};
  kernels.scatter_fluid(particles.data() + tile.first, tile.count, motion, to);
}

void sum_up(FluidGrid& grid, std::size_t t) {
  const FluidTile& tile = grid.tiles[t];
  for (int k = 0; k < 9; ++k) {
    const std::uint32_t n = tile.near[k];
    if (k == 4 || n == FluidTile::kNone || grid.tiles[n].count == 0) continue;
    for (const S::Field f : kSums) add_spill(grid, t, k, square_of(f));
    add_spill(grid, t, k, square_of(S::kFine));
  }
  for (const auto& [mass_field, momentum_field] : {std::pair{S::kMassU, S::kU}, std::pair{S::kMassV, S::kV}}) {
    const float* mass = grid.field(mass_field, t);
    float* momentum = grid.field(momentum_field, t);
    for (std::int32_t j = 0; j < tile.high; ++j) {
      for (std::int32_t i = 0; i < tile.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        momentum[n] = mass[n] > kLeastMass ? momentum[n] / mass[n] : 0;
      }
    }
  }
}

void add_spills(FluidGrid& grid, std::size_t t, FluidSolver::Field field) {
  const FluidTile& tile = grid.tiles[t];
  for (int k = 0; k < 9; ++k) {
    const std::uint32_t n = tile.near[k];
    if (k != 4 && n != FluidTile::kNone && grid.tiles[n].count != 0) add_spill(grid, t, k, square_of(field));
  }
}

void gather_particles(FluidGrid& grid, std::size_t t, FluidParticles& particles, const kernels::KernelTable& kernels,
                      const kernels::FluidMotion& motion, bool viscous) {
  const FluidTile& tile = grid.tiles[t];
  if (tile.count == 0) return;
  static constexpr float kNone[kTileFloats] = {};
  const auto field = [&](S::Field f) { return static_cast<const float*>(grid.field(f, t)); };
  const auto gained = [&](S::Field f) { return tile.dry ? kNone : field(f); };
  const auto dragged = [&](S::Field f) { return viscous && !tile.dry ? field(f) : nullptr; };
  const S::Field u = tile.dry ? S::kU : S::kNewU, v = tile.dry ? S::kV : S::kNewV;
  grid.pull_ring(u, t, S::kNewU, S::kU);
  grid.pull_ring(v, t, S::kNewV, S::kV);
  kernels::FluidMotion of_tile = motion;
  if (tile.dry) {
    of_tile.spreading = 0;
  } else {
    for (const S::Field f : {S::kGainU, S::kGainV, S::kShiftU, S::kShiftV, S::kDragU, S::kDragV}) {
      if (viscous || (f != S::kDragU && f != S::kDragV)) grid.pull_ring(f, t, f, FluidGrid::kNothing);
    }
    grid.pull_ring(S::kFill, t, S::kFill, S::kVolume);
    pull_fine(grid, t);
  }
  const kernels::FluidFields from = {field(u),           field(v),           gained(S::kGainU), gained(S::kGainV),
                                     gained(S::kShiftU), gained(S::kShiftV), gained(S::kFill),  gained(S::kEdge),
                                     field(S::kFine),    dragged(S::kDragU), dragged(S::kDragV)};
  kernels.gather_fluid(particles.data() + tile.first, tile.count, of_tile, from);
}

}  // namespace psim
