// The order of bodies by the cells of a grid over their box: a stable counting sort in parallel, with the same
// result for any number of threads.
//
//   keys      cell of every body; each chunk of bodies notes the window of cells that it meets
//   count     each chunk counts its bodies by cell, in its own window
//   prefix    counts become places: by cell, then by chunk
//   order     each chunk tells which bodies its slots get
// Bodies are nearly sorted from the last time, so the windows are small. If they are not (a first sort of
// shuffled bodies), one chunk sorts all bodies alone. Measured in docs/performance.md.
#pragma once

#include <cstdint>
#include <vector>

#include "bodies/surroundings.h"
#include "lists/cell_list.h"

namespace psim {

/// The grid of one build.
struct Grid {
  kernels::GridView view;
  double cell[2] = {1, 1};  ///< m
  bool periodic = false;
  std::uint32_t keys = 0;  ///< cells with guards
};

class GridSort {
 public:
  explicit GridSort(const Surroundings& s) : s_(s), b_(s.bodies) {}

  /// Finds the cell of every body, and where each cell's bodies will lie. A body whose reach exceeds `large`, m, is in
  /// no cell.
  void count(const Grid& grid, float large);
  /// Mean number of bodies in a body's cell and the eight cells around it, from a sample of about 100 bodies.
  /// Call between count() and order().
  double neighbours(const Grid& grid) const;
  /// Number of bodies in a cell and in the cells to its west and its east. Guards stand above the last row.
  std::uint32_t in_three(std::uint32_t key) const { return (start() + key)[2] - (start() + key)[-1]; }
  /// Call once after count(). Bodies in cells come first, then large and dead ones: from[k] becomes the slot that comes
  /// k-th, keys[k] its cell.
  SortCount order(std::uint32_t* from, std::uint32_t* keys);

  /// Makes room for the cells of `bodies` bodies that spread out.
  void spare(std::size_t bodies) {
    start_.reserve(5 * bodies / 2 + 4096);
    counts_.reserve(4 * bodies + 4096);
  }

  /// First slot of a cell; index -1 and the guards above the last row are readable.
  const std::uint32_t* start() const { return start_.data() + 1; }

 private:
  struct Chunk {
    std::uint32_t begin = 0, end = 0;   // bodies
    std::uint32_t low = 0, high = 0;    // window of keys, past-the-end high
    std::size_t counts = 0;             // its window in counts_
    std::uint32_t large = 0, dead = 0;  // number of large and of dead bodies; after count() the place of the first
  };

  void find_keys(const Grid& grid, float large, Chunk& chunk);
  std::size_t find_windows(const Grid& grid, float large);
  void place_cells(std::uint32_t keys);

  const Surroundings s_;
  const BodyStore& b_;
  Column<std::uint32_t> key_{s_.memory}, start_{s_.memory}, counts_{s_.memory};
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> range_sum_;
};

}  // namespace psim
