// Boxes that come and go, found by place: a hashed grid of several levels (Ericson 2005, 7.2.1). Every
// box lies in the one cell that holds its middle, at the level whose cells are at least as large as it is;
// who asks looks half a cell further. Places are on the lattice, so that a periodic world wraps by itself.
// Costs O(1) to insert and remove, whatever else there is and however far apart.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "column.h"

namespace psim {

class HashGrid {
 public:
  explicit HashGrid(MemoryMeter& meter) : key_(meter), head_(meter), next_(meter), cell_(meter) {}

  /// How many lattice steps along y make up one along x, as a power of two: pitches may differ.
  void set_shape(int shift) { shift_ = shift; }

  /// `number` may be any; the box is (x +- half_x, y +- half_y), lattice steps.
  void insert(std::uint32_t number, std::int32_t x, std::int32_t y, std::uint32_t half_x,
              std::uint32_t half_y);
  void remove(std::uint32_t number);
  /// For numbers below `numbers`, and so many boxes: inserting them allocates nothing.
  void make_room(std::uint32_t numbers, std::size_t boxes);
  void clear();
  bool empty() const { return count_ == 0; }

  /// Appends the numbers in the cells that a box may meet, each once, in no order.
  void near(std::int32_t x, std::int32_t y, std::uint32_t half_x, std::uint32_t half_y,
            std::vector<std::uint32_t>& out) const;

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  static constexpr int kLeast = 3;  // level: log2 of a cell's width in steps

  std::uint32_t find(std::uint64_t key) const;
  static std::size_t size_for(std::size_t boxes);
  void rehash(std::size_t size);

  Column<std::uint64_t> key_;  // open addressing; 0: free
  Column<std::uint32_t> head_;
  Column<std::uint32_t> next_, cell_;  // by number
  std::vector<std::pair<std::uint64_t, std::uint32_t>> moved_;  // scratch of rehash
  std::size_t size_ = 0, used_ = 0, count_ = 0;
  std::uint32_t of_level_[32] = {};    // how many boxes
  int shift_ = 0;
};

}  // namespace psim
