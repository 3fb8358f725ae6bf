// The tiles of a fluid's grid: which there are, who lies beside whom, and their fields.
//
// A tile is there if a particle is in it or near it. Tiles come in the order of their rows; their numbers change from
// step to step. A coarser level has a tile for two by two of the level below.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/column.h"
#include "fluid_views.h"
#include "psim/desc.h"

namespace psim {

/// How a fluid's grid lies in the world. Cells are counted from its lower left corner.
struct FluidSpace {
  double left = 0, bottom = 0;            ///< m: corner of cell (0, 0)
  double cell_x = 1, cell_y = 1;          ///< m
  std::int32_t cells_x = 0, cells_y = 0;  ///< in the world; 0 where it has no end
  float wide = 0, high = 0;               ///< cells between walls, the first of which has number 1; 0 without walls
  Boundary boundary = Boundary::open;
};

/// The grid for cells of about `cell` m: it begins at the corner of the world, or, in an open one, at `corner`.
FluidSpace fluid_space(const Bounds& bounds, Boundary boundary, double cell, Vec2 corner);

struct FluidTile {
  static constexpr std::uint32_t kNone = ~0u;
  std::int32_t x = 0, y = 0;           ///< in tiles
  std::int32_t wide = 0, high = 0;     ///< its cells, at most 16
  std::uint32_t near[9] = {};          ///< those around it from the lower left one on, itself among them, or kNone
  std::uint32_t coarse = 0;            ///< of the coarser level
  std::uint32_t first = 0, count = 0;  ///< particles in it
  bool active = false;                 ///< whether cells of it have equations: FluidGrid::active
  bool dry = false;  ///< neither it nor a tile beside it has full cells: of its fields only sums count
};

/// A number by which tiles are in order.
constexpr std::uint64_t tile_key(std::int32_t x, std::int32_t y) {
  return (std::uint64_t{static_cast<std::uint32_t>(y) ^ 0x80000000u} << 32) |
         (static_cast<std::uint32_t>(x) ^ 0x80000000u);
}

/// The numbers of the tile that has a key.
constexpr std::int32_t column_of(std::uint64_t key) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(key) ^ 0x80000000u);
}
constexpr std::int32_t row_of(std::uint64_t key) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(key >> 32) ^ 0x80000000u);
}

/// One level of the grid, and the floats of its tiles: `fields` squares each.
class FluidGrid {
 public:
  FluidGrid(MemoryMeter& meter, std::size_t fields) : meter_(meter), fields_(fields) {}

  /// Makes tiles of these keys, which are in order.
  void lay(const std::vector<std::uint64_t>& keys, const FluidSpace& space, std::int32_t level);
  std::uint32_t find(std::uint64_t key) const;

  std::size_t size() const { return tiles.size(); }
  std::size_t bytes() const;
  float* field(std::size_t f, std::size_t tile) {
    return chunks_[tile / kChunk].data() + (tile % kChunk * fields_ + f) * kernels::kTileFloats;
  }
  const float* field(std::size_t f, std::size_t tile) const {
    return chunks_[tile / kChunk].data() + (tile % kChunk * fields_ + f) * kernels::kTileFloats;
  }
  /// Fills the halo of a tile from its neighbours: what a sum over four neighbours needs, or all of it.
  void pull_cross(std::size_t f, std::size_t tile);
  void pull_ring(std::size_t f, std::size_t tile) { pull_ring(f, tile, f, f); }
  /// The same from the field `of_near` of neighbours that are not dry, and `of_dry` of those that are, or zeros for
  /// kNothing.
  static constexpr std::size_t kNothing = ~std::size_t{0};
  void pull_ring(std::size_t f, std::size_t tile, std::size_t of_near, std::size_t of_dry);
  /// As pull_cross(), but neighbours that are not active, or those that are dry, count as zeros.
  void pull_active(std::size_t f, std::size_t tile);
  void pull_near(std::size_t f, std::size_t tile);
  /// Sets to zero what of the halo lies among the 16 x 16 nodes that kernels run over: in tiles of fewer cells.
  void clear_halo(std::size_t f, std::size_t tile);
  /// Makes these tiles active, and no other. They are in order.
  void activate(const std::vector<std::uint32_t>& these);

  std::vector<FluidTile> tiles;
  std::vector<std::uint64_t> keys;
  std::vector<std::uint32_t> active;  ///< the tiles on which equations are solved, in order

 private:
  template <class There>
  void pull_four(std::size_t f, std::size_t tile, const There& there);

  static constexpr std::size_t kChunk = 32;  // tiles: about a large page of memory for the finest level
  MemoryMeter& meter_;
  std::vector<Column<float>> chunks_;  // so that spray, which needs more and more tiles, moves nothing
  std::size_t fields_;
};

/// The neighbour of a tile's number.
std::uint64_t neighbour_key(const FluidSpace& space, std::int32_t level, std::int32_t x, std::int32_t y, bool& there);

}  // namespace psim
