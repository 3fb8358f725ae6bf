// The particles of all fluids, sorted by the tiles of the grid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/column.h"
#include "base/worker_pool.h"
#include "fluid/fluid_bodies.h"
#include "fluid/fluid_tiles.h"
#include "fluid_views.h"
#include "kernel_table.h"

namespace psim {

class Archive;

class FluidParticles {
 public:
  explicit FluidParticles(MemoryMeter& meter) : list_(meter), sorted_(meter), tile_of_(meter) {}

  /// So many ids a world has: the last number is nobody's.
  static constexpr std::uint32_t kMostIds = 0xFFFFFFFFu;

  std::size_t size() const { return count_; }
  kernels::FluidParticle* data() { return list_.data(); }
  const kernels::FluidParticle* data() const { return list_.data(); }

  /// One more than the largest id.
  std::uint32_t next_id() const { return next_id_; }
  std::size_t bytes() const { return list_.bytes() + sorted_.bytes() + tile_of_.bytes(); }

  /// Makes room for n more.
  void make_room(std::size_t n);
  void clear();
  /// Calls see(particle, its tile, the number of the tile in the grid) for all. The tile of one that was added since the
  /// last step may not be in the grid: its number is FluidTile::kNone.
  template <class See>
  void each(const FluidGrid& grid, const See& see) const {
    for (std::uint32_t t = 0; t < grid.size(); ++t) {
      const FluidTile& tile = grid.tiles[t];
      for (std::uint32_t k = 0; k < tile.count; ++k) see(list_[tile.first + k], tile, t);
    }
    for (std::size_t k = 0; k < added_.size(); ++k) {
      FluidTile tile;
      tile.x = column_of(added_[k]);
      tile.y = row_of(added_[k]);
      see(list_[count_ - added_.size() + k], tile, FluidTile::kNone);
    }
  }
  /// Calls see(particle, its tile) for all whose tile touches a box, and for those that were added since the last step.
  template <class See>
  void each_near(const FluidGrid& grid, const Bounds& box, const FluidSpace& space, const See& see) const {
    for (const FluidTile& tile : grid.tiles) {
      if (beside(tile, box, space)) continue;
      for (std::uint32_t k = 0; k < tile.count; ++k) see(list_[tile.first + k], tile);
    }
    for (std::size_t k = 0; k < added_.size(); ++k) {
      FluidTile tile;
      tile.x = column_of(added_[k]);
      tile.y = row_of(added_[k]);
      see(list_[count_ - added_.size() + k], tile);
    }
  }
  /// For saved states (state/describe_fluids.cpp): with the tiles of `grid` that the particles are sorted by.
  void describe(Archive& a, FluidGrid& grid, const FluidSpace& space, std::size_t kinds);
  /// Adds a particle at a place, in cells.
  void add(double x, double y, Vec2 velocity, std::uint32_t fluid, const FluidSpace& space);
  /// Moves particles on by a step, keeps them within the walls, sorts them, and makes the tiles of `grid` for them.
  /// `bodies`: particles do not pass their shapes, which have moved for `bodies_moved` seconds to where they are.
  void move(const FluidSpace& space, const kernels::FluidMotion& motion, const kernels::KernelTable& kernels,
            FluidGrid& grid, WorkerPool& pool, FluidBodies& bodies, float bodies_moved);
  /// Moves the particles of a tile out of its shapes, into which they went from these places, cells.
  void keep_out(const FluidTile& tile, std::span<const FluidSolid> solids, std::span<const Place2> from,
                const float* mass, const FluidSpace& space, const FluidBodies& bodies, std::vector<FluidHits>& hits);
  /// Removes the sorted particles that are within a box, or, if `within` is false, beside it, from the tiles of `grid`,
  /// too. Returns how many.
  std::size_t remove(const Bounds& box, bool within, FluidGrid& grid, const FluidSpace& space);
  /// The place of a particle, m.
  static Vec2 place_of(const kernels::FluidParticle& p, const FluidTile& tile, const FluidSpace& space) {
    return {space.left + (double{kernels::kTile} * tile.x + p.x) * space.cell_x,
            space.bottom + (double{kernels::kTile} * tile.y + p.y) * space.cell_y};
  }

 private:
  void move_chunk(std::size_t job, const FluidSpace& space, const kernels::FluidMotion& motion,
                  const kernels::KernelTable& kernels, FluidBodies& bodies, float bodies_moved);
  void note_places(std::size_t begin, std::size_t end, std::vector<Place2>& places) const;
  void look_around(const FluidSpace& space, const kernels::FluidMotion& motion, WorkerPool& pool, FluidBodies& bodies);
  void lay_tiles(const FluidSpace& space, FluidGrid& grid);
  void count_chunk(std::size_t job, const FluidGrid& grid);

  /// Whether a tile has no point of a box.
  static bool beside(const FluidTile& tile, const Bounds& box, const FluidSpace& space) {
    kernels::FluidParticle corner{}, other{};
    other.x = other.y = static_cast<float>(kernels::kTile);
    const Vec2 low = place_of(corner, tile, space), high = place_of(other, tile, space);
    return low.x > box.xmax || high.x < box.xmin || low.y > box.ymax || high.y < box.ymin;
  }

  static constexpr std::size_t kChunk = 4096;  // particles a job
  /// A job notes here where its particles are.
  struct Chunk {
    std::vector<std::uint64_t> keys;    // tiles that its particles are in or near
    std::vector<std::uint32_t> counts;  // particles by tile
    std::vector<Place2> from;           // where its particles were
    std::vector<FluidHits> hits;        // of its particles
  };

  std::size_t count_ = 0;
  std::uint32_t next_id_ = 0;
  Column<kernels::FluidParticle> list_, sorted_;
  Column<std::uint64_t> tile_of_;  // key of a particle's tile, then its number
  std::vector<FluidTile> old_tiles_;
  std::vector<std::uint32_t> old_tile_;  // of each chunk's first particle
  std::vector<std::uint64_t> added_;     // keys of the tiles of particles that were added since the last sort
  std::vector<Chunk> chunks_;
  std::vector<std::uint64_t> keys_, old_keys_;
};

}  // namespace psim
