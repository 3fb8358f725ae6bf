// Sorts bodies into the cells of a grid over their box: a stable counting sort in parallel, with the
// same result for any number of threads.
//
//   keys      cell of every body; each chunk of bodies notes the window of cells that it meets
//   count     each chunk counts its bodies by cell, in its own window
//   prefix    counts become places: by cell, then by chunk
//   scatter   each chunk moves its bodies' columns to their new slots
// Bodies are nearly sorted from the last time, so the windows are small. If they are not (a first sort of
// shuffled bodies), one chunk sorts all bodies alone. Measured in docs/performance.md.
// Where most of the box is empty, CellList finds the order of the bodies instead, and they are moved here.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bodies/surroundings.h"
#include "lists/cell_list.h"

namespace psim {

/// The grid of one build.
struct Grid {
  kernels::GridView view;
  double cell_x = 1, cell_y = 1;  ///< m
  bool periodic = false;
  std::uint32_t keys = 0;  ///< cells with guards
};

class GridSort {
 public:
  explicit GridSort(const Surroundings& s) : b_(s.bodies), k_(s.kernels), pool_(s.pool), meter_(s.memory), listed_(s) {}

  /// Finds the cell of every body, and where each cell's bodies will lie. A body whose reach exceeds `large`, m, is in
  /// no cell.
  void count(const Grid& grid, float large);
  /// Mean number of bodies in a body's cell and the eight cells around it, from a sample of about 100 bodies.
  /// Call after count().
  double neighbours(const Grid& grid) const;
  /// Moves the bodies to their cells and drops dead ones, in moves() pieces, in order. Large bodies go last. The
  /// columns change with the last piece, which returns the first large slot. Afterwards from()[slot] is the slot
  /// before.
  std::size_t moves() const { return chunks_.size(); }
  std::uint32_t move(bool mixed_radii, std::size_t begin, std::size_t end);

  /// Counts and moves at once, into the cells of listed(), whose extent was chosen by CellList::lay.
  std::uint32_t sort(float large, bool mixed_radii);
  CellList& listed() { return listed_; }
  const CellList& listed() const { return listed_; }

  /// Makes room for the cells of `bodies` bodies that spread out, and for moving `all` slots.
  void spare(std::size_t bodies, std::size_t all) {
    start_.reserve(5 * bodies / 2 + 4096);
    counts_.reserve(4 * bodies + 4096);
    pos_.reserve(2 * all);
    vel_.reserve(2 * all);
    disp_.reserve(2 * all);
  }
  /// Gives back the scratch columns of radii or rotation if they are not needed any more.
  void forget(bool radii, bool rotation) {
    if (radii) radius_.release();
    if (!rotation) return;
    rim_speed_.release();
    angle_.release();
  }
  std::size_t radii_bytes() const { return radius_.bytes(); }
  std::size_t rotation_bytes() const { return rim_speed_.bytes() + angle_.bytes(); }

  const std::uint32_t* from() const { return from_.data(); }
  const std::uint32_t* keys() const { return key_sorted_.data(); }
  /// First slot of a cell; index -1 and the guards above the last row are readable.
  const std::uint32_t* start() const { return start_.data() + 1; }

 private:
  struct Chunk {
    std::uint32_t begin = 0, end = 0;   // bodies
    std::uint32_t low = 0, high = 0;    // window of keys, past-the-end high
    std::size_t counts = 0;             // its window in counts_
    std::uint32_t large = 0, dead = 0;  // number of large and of dead bodies
  };

  void find_keys(const Grid& grid, float large, bool special, Chunk& chunk);
  std::size_t find_windows(const Grid& grid, float large);
  void count_chunk(const Chunk& chunk);
  void place_cells(std::uint32_t keys);
  void reserve(bool mixed_radii);
  template <bool kRadii, bool kTurns>
  void move_one(const BodyStore& b, std::size_t to, std::size_t from);
  template <bool kRadii, bool kTurns>
  void scatter_chunk(const BodyStore& b, const Chunk& chunk, std::uint32_t large_at, std::uint32_t dead_at);
  void finish(std::uint32_t count, bool mixed_radii);
  template <bool kRadii, bool kTurns>
  void scatter_listed(const BodyStore& b, std::size_t begin, std::size_t end);
  template <class Scatter>
  Scatter for_columns(bool mixed_radii, const std::array<Scatter, 4>& scatters) const;

  BodyStore& b_;
  const kernels::KernelTable& k_;
  WorkerPool& pool_;
  MemoryMeter& meter_;
  Column<std::uint32_t> key_{meter_}, start_{meter_}, counts_{meter_}, from_{meter_};
  Column<std::int32_t> pos_{meter_};
  Column<float> vel_{meter_}, disp_{meter_};
  Column<std::uint32_t> id_{meter_};
  Column<float> radius_{meter_}, reach_{meter_}, rim_speed_{meter_};
  Column<double> angle_{meter_};
  Column<std::uint32_t> key_sorted_{meter_};
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> range_sum_;
  CellList listed_;
};

}  // namespace psim
