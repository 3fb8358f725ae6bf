// Boxes that come and go, found by place: a hashed grid of several levels (Ericson 2005, 7.2.1). Every
// box lies in the one cell that holds its middle, at the level whose cells are at least as large as the box;
// a query therefore looks half a cell further. Places are lattice points, so that a periodic world wraps by
// itself. To insert or remove a box costs O(1), however many others there are and however far apart.
#pragma once

#include <cstdint>
#include <vector>

#include "base/column.h"

namespace psim {

class HashGrid {
 public:
  /// `shift`: the ratio of the pitches along x and y, as a power of two.
  HashGrid(MemoryMeter& meter, int shift) : first_(meter), next_(meter), cell_(meter), shift_(shift) {}

  /// `number` may be any; the box is (x +- half_x, y +- half_y), lattice steps.
  void insert(std::uint32_t number, std::int32_t x, std::int32_t y, std::uint32_t half_x, std::uint32_t half_y);
  void remove(std::uint32_t number);
  /// Makes room for `boxes` boxes with numbers below `numbers`: inserting them allocates nothing.
  void make_room(std::uint32_t numbers, std::size_t boxes);
  void clear();
  bool empty() const { return count_ == 0; }

  /// Appends the numbers of all boxes in the cells that a box may meet. Each comes once; the order is arbitrary.
  void near(std::int32_t x, std::int32_t y, std::uint32_t half_x, std::uint32_t half_y,
            std::vector<std::uint32_t>& out) const;

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  // A level is log2 of the width of its cells in lattice steps. The highest one has a single cell.
  static constexpr int kLeast = 3, kTop = 32;

  int level_y(int level) const;
  std::uint32_t& first_of(std::uint64_t cell);
  void grow(std::size_t places);

  Column<std::uint32_t> first_;  // a box by the hash of its cell; the others of that hash follow in next_
  Column<std::uint32_t> next_;   // by number
  Column<std::uint64_t> cell_;   // by number
  std::size_t size_ = 0, count_ = 0;
  std::uint32_t of_level_[kTop + 1] = {};  // number of boxes on each level
  int shift_;
};

}  // namespace psim
