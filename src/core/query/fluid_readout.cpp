// Tells a host of particles: where each is, how full the cells around it are, and the pressure there.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/sort_keys.h"
#include "fluid/fluids.h"

namespace psim {

using kernels::kTile;
using kernels::tile_node;
using S = FluidSolver;

namespace {

// How far off the density of a tile is, and the pressure, around the middles of its full cells.
class TileFields {
 public:
  struct Values {
    double error = 0, pressure = 0;
  };

  void read(const FluidGrid& grid, std::size_t tile) {
    const FluidTile& of = grid.tiles[tile];
    wide_ = of.dry ? 0 : of.wide;
    high_ = of.dry ? 0 : of.high;
    const float* diagonal = grid.field(S::kDiagonal, tile);
    for (std::int32_t j = 0; j < high_; ++j) {
      for (std::int32_t i = 0; i < wide_; ++i) {
        const std::size_t n = tile_node(i, j);
        Cell& cell = cells_[place(i, j)];
        cell.full = diagonal[n] > 0;
        if (!cell.full) continue;
        cell.error = plane_at(grid.field(S::kError, tile), diagonal, n);
        cell.pressure = plane_at(grid.field(S::kPressure, tile), diagonal, n);
      }
    }
  }

  // At a place in the tile, cells, by the kernel: of each full cell what its value and its slope say.
  Values at(double x, double y) const {
    constexpr double kFar = 2 * kTile;  // cells from the corner of the tile
    if (!(std::fabs(x) <= kFar && std::fabs(y) <= kFar)) return {};
    const auto weight = [](double t) {
      t = std::fabs(t);
      return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0.0;
    };
    const auto ci = static_cast<std::int32_t>(std::floor(x)), cj = static_cast<std::int32_t>(std::floor(y));
    Values sum;
    double weights = 0;
    for (std::int32_t j = std::max(cj - 1, 0); j <= std::min(cj + 1, high_ - 1); ++j) {
      const double dy = y - j - 0.5, weight_y = weight(dy);
      for (std::int32_t i = std::max(ci - 1, 0); i <= std::min(ci + 1, wide_ - 1); ++i) {
        const Cell& cell = cells_[place(i, j)];
        if (!cell.full) continue;
        const double dx = x - i - 0.5, w = weight(dx) * weight_y;
        sum.error += w * cell.error.at(dx, dy);
        sum.pressure += w * cell.pressure.at(dx, dy);
        weights += w;
      }
    }
    return weights > 0 ? Values{sum.error / weights, sum.pressure / weights} : Values{};
  }

 private:
  struct Plane {
    double value = 0, slope_x = 0, slope_y = 0;
    double at(double dx, double dy) const { return value + dx * slope_x + dy * slope_y; }
  };
  struct Cell {
    Plane error, pressure;
    bool full = false;
  };

  static std::size_t place(std::int32_t i, std::int32_t j) {
    const std::int32_t n = j * kTile + i;
    return static_cast<std::size_t>(n);
  }

  // A field around a node: slopes are those to the neighbours that are full.
  static Plane plane_at(const float* value, const float* diagonal, std::size_t n) {
    const auto slope = [&](std::size_t step) {
      const bool after = diagonal[n + step] > 0, before = diagonal[n - step] > 0;
      const double next = after ? double{value[n + step]} - value[n] : 0;
      const double last = before ? double{value[n]} - value[n - step] : 0;
      return after && before ? (next + last) / 2 : next + last;
    };
    return {double{value[n]}, slope(1), slope(static_cast<std::size_t>(kernels::kTilePitch))};
  }

  std::int32_t wide_ = 0, high_ = 0;  // cells; 0: none is full
  std::array<Cell, std::size_t{kTile} * kTile> cells_;
};

}  // namespace

void Fluids::look(std::vector<FluidParticleState>& out) const {
  const FluidGrid& grid = solver_.grid();
  std::vector<std::uint64_t> order;  // of ids, with places in the list
  order.reserve(particles_.size());
  particles_.each(grid, [&](const kernels::FluidParticle& p, const FluidTile&, std::uint32_t) {
    order.push_back(std::uint64_t{p.id} << 32 | order.size());
  });
  sort_by_upper_half(order);
  std::vector<std::uint32_t> place(order.size());  // in `out`, by place in the list
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k] & 0xFFFFFFFFu] = static_cast<std::uint32_t>(k);
  out.resize(order.size());
  TileFields fields;
  std::uint32_t read = FluidTile::kNone;
  std::size_t at = 0;
  particles_.each(grid, [&](const kernels::FluidParticle& p, const FluidTile& tile, std::uint32_t t) {
    const bool stepped = t != FluidTile::kNone;
    if (stepped && t != read) fields.read(grid, read = t);
    const TileFields::Values here = stepped ? fields.at(double{p.x}, double{p.y}) : TileFields::Values{};
    out[place[at++]] = {p.id,
                        p.fluid,
                        FluidParticles::place_of(p, tile, space_),
                        {double{p.u}, double{p.v}},
                        kinds_[p.fluid].density * (1 + here.error),
                        pressure_unit() * here.pressure};
  });
}

}  // namespace psim
