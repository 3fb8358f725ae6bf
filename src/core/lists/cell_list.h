// Cells of a sparse world: a sorted list of the cells that hold bodies.
// The empty space between bodies costs nothing, however far apart they are.
// docs/decisions/008-sparse-worlds.md
//
// A cell's name is row x stride + column, in 64 bits. The last column of a row
// is always empty, so name + 1 is the cell to the east, or an empty one. Bodies
// are sorted by the name of their cell. While the cells keep their places, the
// few bodies that went to another cell are merged with the rest; otherwise all
// are sorted by a radix sort. Each cell has four numbers, at the places where
// the pair search expects them with key = 4 cell and next_row = 1 (pair_kernel.h):
//
//   start[key]      first body of the three cells above
//   start[key + 1]  its own first body
//   start[key + 2]  past the last body of this cell and the one to the east
//   start[key + 3]  past the last body of the three cells above
//
// Rows run across the longer side of the bodies' box, so that bodies along a
// line lie in many rows. O(bodies), whatever their box; 33 bytes a body.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "base/cell_axis.h"
#include "bodies/surroundings.h"

namespace psim {

/// How many bodies of each kind a sort found.
struct SortCount {
  std::uint32_t small = 0, large = 0, dead = 0;
  std::uint32_t all() const { return small + large + dead; }
};

class CellList {
 public:
  /// For saved states. `used`: bodies lie in cells that are laid.
  void describe(class Archive& a, bool periodic, bool used);

  explicit CellList(const Surroundings& s) : s_(s), b_(s.bodies) {}

  /// Chooses cells at least `edge` lattice steps wide for the box {x low, y low,
  /// x high, y high} of `bodies` bodies, or for the whole of a periodic world.
  /// False if fewer than three by three cells fit.
  bool lay(const std::int32_t box[4], const double edge[2], bool periodic, std::uint32_t bodies);

  /// Sorts the slots by cell, and within a cell by slot. Bodies whose reach
  /// exceeds `large` come after those, dead bodies last. order[k] becomes the
  /// slot that comes k-th, keys[k] four times its cell. On entry `keys` holds
  /// the keys of the last sort: they tell which bodies stayed in their cells.
  SortCount sort(float large, std::uint32_t* order, std::uint32_t* keys);

  /// Forgets the cells and keys of the last sort.
  void forget() {
    sorted_ = 0;
    stays_ = false;
  }

  const std::uint32_t* start() const { return start_.data(); }
  std::uint32_t size() const { return cells_; }
  bool periodic() const { return periodic_; }
  double cell_steps(int axis) const { return axis_[axis].width; }

  /// First body of a cell; of cell size(): past the last body.
  std::uint32_t first(std::uint32_t cell) const { return start_[4 * std::size_t{cell} + 1]; }
  std::uint64_t row(std::uint32_t cell) const { return name_[cell] / stride_; }
  std::uint64_t column(std::uint32_t cell) const { return name_[cell] % stride_; }
  std::uint64_t last_column() const { return stride_ - 2; }
  std::uint64_t row_above(std::uint64_t row) const { return row + 1 == rows_ ? 0 : row + 1; }
  /// The first cell of a row at or after a column; if there is none, the first
  /// cell of a later row. O(log cells), fast if the result is near `guess`.
  std::uint32_t find(std::uint64_t row, std::uint64_t column, std::uint32_t guess = 0) const;

  /// Calls each(first body, past the last) for runs of bodies that may lie in
  /// the box that reaches `half` lattice steps each way from a place. Ends and
  /// returns false when a call returns false.
  template <class Each>
  bool in_box(const std::int32_t place[2], const double half[2], const Each& each) const {
    const auto along = [&](int k) { return axis_[k].around(place[k], half[k], periodic_); };
    const auto columns = along(1 - row_axis_);
    for (const CellRange& r : along(row_axis_)) {
      // Rows are much alike: the offsets of one row are good guesses for the next.
      std::uint32_t row_cells = 0, offset[2] = {0, 0};
      for (std::uint32_t c = find(r.first, 0); c < cells_;) {
        const std::uint64_t here = row(c);
        if (here >= r.end) break;
        for (std::size_t k = 0; k < 2; ++k) {
          if (columns[k].size() == 0) continue;
          const std::uint32_t begin = find(here, columns[k].first, c + offset[k]);
          offset[k] = begin - c;
          const std::uint32_t from = first(begin), to = first(find(here, columns[k].end, begin));
          if (from < to && !each(from, to)) return false;
        }
        const std::uint32_t next = find(here + 1, 0, c + row_cells);
        row_cells = next - c;
        c = next;
      }
    }
    return true;
  }

  /// Mean number of bodies in a body's cell and the eight cells around it, from
  /// a sample of about 2,000 bodies.
  double neighbours(const std::uint32_t* keys, std::uint32_t bodies) const;

 private:
  struct Chunk {
    std::uint32_t begin = 0, end = 0;  // bodies
    std::uint32_t large = 0, dead = 0, cells = 0;
    std::uint32_t stayed = 0, moved = 0;
  };

  bool serves(int axis, const std::int32_t box[4], double edge, bool periodic) const;
  void cut_chunks(std::uint32_t bodies);
  void name_bodies(float large, Chunk& chunk);
  bool merge_moved(float large, const std::uint32_t* keys);
  void find_moved(const std::uint32_t* keys, std::size_t chunk);
  void sort_by_digit(int shift, int bits);
  void list_cells(std::uint32_t bodies, std::uint32_t* order, std::uint32_t* keys);
  void find_neighbours(std::uint32_t begin, std::uint32_t end);

  const Surroundings s_;
  const BodyStore& b_;
  // During a sort: a name for each body, with its slot in the low bits. Afterwards: the names of the cells.
  Column<std::uint64_t> name_{s_.memory}, spare_name_{s_.memory};
  int slot_bits_ = 0;
  Column<std::uint64_t> moved_{s_.memory};   // names of the bodies that went to another cell
  std::uint32_t moved_room_ = 0;             // number of them that fit into the room of a chunk
  std::uint32_t sorted_ = 0;                 // number of bodies in the last sort; 0: its keys are gone
  bool stays_ = false;                       // the cells kept their places
  int patience_ = 0;                         // sorts to go before moved bodies are looked for again
  Column<std::uint32_t> counts_{s_.memory};  // by chunk and digit
  Column<std::uint32_t> start_{s_.memory};
  std::vector<Chunk> chunks_;
  CellAxis axis_[2];
  int row_axis_ = 1;
  std::uint64_t stride_ = 2, rows_ = 0;
  std::uint32_t cells_ = 0;
  bool periodic_ = false;
};

}  // namespace psim
