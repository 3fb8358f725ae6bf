// Cells of large bodies: bodies that are too big for the cells of the broad phase find one another here.
//
// Each octave of reaches is a level with cells of its own, as wide as twice its largest reach, so that bodies of about
// the same size meet within three by three cells. The cells of a level are hashed into as many buckets as the level has
// bodies; cells that are neighbours along x have neighbouring buckets. Bodies of other cells that share a bucket are
// rejected by distance, as the pair search does with every candidate. Cells wrap with the lattice, so a periodic world
// needs nothing else. O(bodies) to build; 24 bytes a large body.
#pragma once

#include <cstdint>
#include <vector>

#include "base/cell_axis.h"
#include "base/column.h"
#include "kernel_table.h"

namespace psim {

class LargeCells {
 public:
  /// Fewer large bodies are compared each with each, which is faster.
  static constexpr std::uint32_t kLeast = 768;

  explicit LargeCells(MemoryMeter& meter) : at_(meter), reach_(meter), slot_(meter), place_(meter), start_(meter) {}

  /// Builds the levels for slots [begin, end): `at` holds {x, y} in lattice steps, `reach` metres.
  void build(const std::int32_t* at, const float* reach, std::uint32_t begin, std::uint32_t end,
             const Lattice& lattice);
  void release();
  bool any() const { return !levels_.empty(); }
  /// Expected number of comparisons a body; the cost of finding the candidates is counted in comparisons too.
  double tests() const;

  /// Appends the bodies with slots above i that are within reach of body i, in order of slots. False if the list is
  /// full; then the entries from its present count on are of no use, except the owners.
  bool find(std::uint32_t i, const kernels::KernelTable& k, kernels::PairList& list) const;
  /// Appends the bodies within reach of a place as `other`, in order of slots, at the positions that they had at the
  /// build. False if the list is full.
  bool around(const std::int32_t* at, float reach, kernels::PairList& list) const;

 private:
  struct Level {
    float most = 0;                      // m: largest reach
    std::uint32_t begin = 0, end = 0;    // bodies, by place
    std::uint32_t bucket = 0, mask = 0;  // first bucket in start_; number of buckets less one
    CellAxis axis[2];
  };

  void make_levels(const float* reach, std::uint32_t begin, std::uint32_t end);
  /// Calls among(first place, end) for runs of bodies that may be within reach of `at`; a place may come twice.
  template <class Among>
  void each_run(const std::int32_t* at, float reach, const Among& among) const;
  // The bucket of a cell, counted from the first one of its level.
  static std::uint32_t bucket_of(const Level& level, std::uint64_t column, std::uint64_t row) {
    return (static_cast<std::uint32_t>(column) + static_cast<std::uint32_t>(row) * 0x9E3779B1u) & level.mask;
  }

  // By place. Bodies lie in order of their buckets, and within a bucket in order of slots.
  Column<std::int32_t> at_;
  Column<float> reach_;
  Column<std::uint32_t> slot_;
  Column<std::uint32_t> place_;  // by k: the place of slot begin_ + k
  Column<std::uint32_t> start_;  // by bucket, level after level: its first place
  std::vector<Level> levels_;
  std::uint32_t begin_ = 0;
  double pitch_[2] = {1, 1};  // m
};

}  // namespace psim
