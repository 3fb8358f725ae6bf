#include "fluid/fluid_mixture.h"

#include <algorithm>
#include <cmath>

#include "fluid/fluid_transfer.h"

namespace psim {

using kernels::kTileFloats;
using kernels::tile_node;
using S = FluidSolver;

namespace {

constexpr float kLeastVolume = 1e-6f;  // of a face that has a density, cells

// The three nodes next to a place along an axis, and their weights.
struct NextNodes {
  std::int32_t first;
  float weight[3];

  // `half`: 1/2 for nodes half-way between whole numbers, else 0.
  NextNodes(float at, float half) {
    const float middle = std::floor((at - half) + 0.5f), off = (at - half) - middle;
    first = static_cast<std::int32_t>(middle) - 1;
    weight[0] = 0.5f * ((0.5f - off) * (0.5f - off));
    weight[1] = 0.75f - off * off;
    weight[2] = 0.5f * ((0.5f + off) * (0.5f + off));
  }
};

}  // namespace

void scatter_amount(FluidGrid& grid, std::size_t t, const FluidParticles& particles, std::span<const float> amount,
                    Nodes at, FluidSolver::Field to) {
  float* sums = grid.field(to, t);
  std::fill_n(sums, kTileFloats, 0.0f);
  const FluidTile& tile = grid.tiles[t];
  for (std::uint32_t k = 0; k < tile.count; ++k) {
    const kernels::FluidParticle& p = particles.data()[tile.first + k];
    const NextNodes x(p.x, at == Nodes::left ? 0 : 0.5f), y(p.y, at == Nodes::lower ? 0 : 0.5f);
    for (std::int32_t j = 0; j < 3; ++j) {
      const float row = amount[p.fluid] * y.weight[j];
      for (std::int32_t i = 0; i < 3; ++i) sums[tile_node(x.first + i, y.first + j)] += row * x.weight[i];
    }
  }
}

void scatter_volumes(FluidGrid& grid, std::size_t tile, const FluidParticles& particles,
                     std::span<const float> volume) {
  scatter_amount(grid, tile, particles, volume, Nodes::left, S::kLightU);
  scatter_amount(grid, tile, particles, volume, Nodes::lower, S::kLightV);
}

void find_lightness(FluidGrid& grid, std::size_t t) {
  const FluidTile& tile = grid.tiles[t];
  for (const auto& [light_field, mass_field] : {std::pair{S::kLightU, S::kMassU}, std::pair{S::kLightV, S::kMassV}}) {
    add_spills(grid, t, light_field);
    const float* mass = grid.field(mass_field, t);
    float* light = grid.field(light_field, t);
    for (std::int32_t j = 0; j < tile.high; ++j) {
      for (std::int32_t i = 0; i < tile.wide; ++i) {
        const std::size_t n = tile_node(i, j);
        light[n] = light[n] > kLeastVolume ? light[n] / mass[n] : 1;
      }
    }
  }
}

}  // namespace psim
