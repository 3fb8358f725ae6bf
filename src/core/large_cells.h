// Cells of large bodies: those that are too big for the cells of the broad phase find one another here.
//
// Each octave of reaches is a level with cells of its own, as wide as two of its largest reaches, so that bodies of a
// size meet in three by three of them. A level's cells share as many buckets as it has bodies, neighbours along x side by
// side: what else lies in a bucket is sorted out by distance, as the pair search does with all candidates. Cells wrap
// with the lattice, so a periodic world does by itself. O(bodies) to build; 24 bytes a large body.
#pragma once

#include <cstdint>
#include <vector>

#include "column.h"
#include "kernel_table.h"
#include "lattice.h"

namespace psim {

class LargeCells {
 public:
  /// Fewer are faster compared each with each.
  static constexpr std::uint32_t kLeast = 768;

  explicit LargeCells(MemoryMeter& meter) : at_(meter), reach_(meter), slot_(meter), place_(meter), start_(meter) {}

  /// Slots [begin, end) of bodies at `at`, {x, y} in lattice steps, that reach so far, m.
  void build(const std::int32_t* at, const float* reach, std::uint32_t begin, std::uint32_t end,
             const Lattice& lattice);
  void release();
  bool any() const { return !levels_.empty(); }
  /// How many bodies each is compared with, at a guess; what it costs to find them counted as such.
  double tests() const;

  /// Appends the bodies behind slot i that are within reach of it, in order of slots. False if the list is full; all of
  /// it from its present count on is then of no use, but for the owners.
  bool find(std::uint32_t i, const kernels::KernelTable& k, kernels::PairList& list) const;
  /// Appends those that lie where they were, within reach of a body that may lie anywhere: as `other`, in order of slots.
  /// False if the list is full.
  bool around(const std::int32_t* at, float reach, kernels::PairList& list) const;

 private:
  struct Axis {
    std::uint64_t per = 1;  // cells in 2^32 lattice steps
    double pitch = 1;       // m
  };
  struct Level {
    float most = 0;                      // m: largest reach
    std::uint32_t begin = 0, end = 0;    // bodies, by place
    std::uint32_t bucket = 0, mask = 0;  // its first in start_; how many less one
    Axis axis[2];
  };
  struct Span {
    std::uint64_t first = 0, cells = 0;
  };

  static std::uint64_t cell_at(const Axis& a, std::int32_t at) {
    return (std::uint64_t{static_cast<std::uint32_t>(at)} * a.per) >> 32;
  }
  static Span span(const Axis& a, std::int32_t at, double reach);
  /// among(first place, end) of bodies that may be within reach of one at `at`; a place may come twice.
  template <class Among>
  void each_run(const std::int32_t* at, float reach, const Among& among) const;
  static std::uint32_t bucket_of(const Level& level, std::uint64_t column, std::uint64_t row) {
    return (static_cast<std::uint32_t>(column) + static_cast<std::uint32_t>(row) * 0x9E3779B1u) & level.mask;
  }

  // By place: bodies in order of their buckets, within one in order of slots.
  Column<std::int32_t> at_;
  Column<float> reach_;
  Column<std::uint32_t> slot_;
  Column<std::uint32_t> place_;  // of slot begin_ + k
  Column<std::uint32_t> start_;  // first place of each bucket, of all levels one after the other
  std::vector<Level> levels_;
  std::uint32_t begin_ = 0;
  float pitch_[2] = {1, 1};
};

}  // namespace psim
