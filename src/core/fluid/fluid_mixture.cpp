// Adds fluids to a world, and finds how light what lies at each face is.
#include "fluid/fluid_mixture.h"

#include <algorithm>
#include <cmath>

#include "base/range_text.h"
#include "fluid/fluid_transfer.h"
#include "fluid/fluids.h"
#include "psim/limits.h"

namespace psim {

using kernels::kTileFloats;
using kernels::tile_node;
using S = FluidSolver;

namespace {

constexpr float kLeastVolume = 1e-6f;  // of a face that has a density, cells
// A fluid moves as if it were at most so many times as dense as the first one, and at least 1 / so many: beyond, the
// equations take a hundred iterations, and floats do not hold both.
constexpr double kMostTimesDenser = 1000;

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

std::string check_fluid(const FluidKind& kind, const FluidKind& first, const Bounds& bounds, Boundary boundary) {
  RangeCheck check;
  check("a fluid's spacing", kind.spacing, limits::kSpacing)("a fluid's density", kind.density, limits::kDensity);
  check("a fluid's viscosity", kind.viscosity, limits::kViscosity);
  check("a fluid's surface tension", kind.tension, limits::kSurfaceTension);
  if (!check.error.empty()) return check.error;
  if (kind.spacing > first.spacing) {
    return "a fluid's spacing must be at most that of the first fluid, " + exact_text(first.spacing) + " m, not " +
           exact_text(kind.spacing);
  }
  const double width = bounds.xmax - bounds.xmin, height = bounds.ymax - bounds.ymin;
  const bool open = boundary == Boundary::open;
  // Cells are counted in 32 bits, and within walls also in floats.
  const double most = open ? 0x1p29 : 0x1p23, least = open ? 0 : boundary == Boundary::walls ? 1 : 8;
  const double largest = std::max(width, height) / first.spacing, smallest = std::min(width, height) / first.spacing;
  if (largest <= most && smallest >= least) return {};
  return "a fluid's spacing must be " + exact_text(std::max(width, height) / most) +
         (least > 0 ? " to " + exact_text(std::min(width, height) / least) : " or more") +
         " m in a world of these bounds, not " + exact_text(first.spacing);
}

std::uint32_t Fluids::add_kind(const FluidKind& kind) {
  kinds_.reserve(kinds_.size() + 1);
  volume_.reserve(kinds_.size() + 1);
  mass_.reserve(kinds_.size() + 1);
  tensions_.reserve(kinds_.size() + 1);
  kinds_.push_back(kind);
  viscosity_ = std::max(viscosity_, kind.viscosity);
  densities_ = densities_ || kind.density != kinds_[0].density;
  const double share = kind.spacing * kind.spacing / (space_.cell_x * space_.cell_y);
  volume_.push_back(static_cast<float>(share));
  const double denser = std::clamp(kind.density / kinds_[0].density, 1 / kMostTimesDenser, kMostTimesDenser);
  mass_.push_back(static_cast<float>(share * denser));
  least_density_ = kinds_.size() == 1 ? kind.density : std::min(least_density_, kind.density);
  tension_ = std::max(tension_, kind.tension);
  tensions_.assign(kinds_.size(), 0);
  for (std::size_t k = 0; k < kinds_.size() && tension_ > 0; ++k) {
    tensions_[k] = volume_[k] * static_cast<float>(kinds_[k].tension / tension_);
  }
  return static_cast<std::uint32_t>(kinds_.size() - 1);
}

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
