// The last frames, to look back at: copies of snapshots and particles, as many as fit into kMostBytes, and the wells of
// each.
#pragma once

#include <cstddef>
#include <vector>

#include "model/simulation.h"

namespace psim::view {

class History {
 public:
  /// Copies a frame; the oldest goes.
  void record(const Snapshot& snapshot, const WellPlaces& wells, const FluidPlaces& fluids = {});
  void clear();
  std::size_t size() const { return size_; }
  /// 0: the newest.
  const Snapshot& at(std::size_t back) const { return frames_[place(back)].snapshot; }
  const WellPlaces& wells(std::size_t back) const { return frames_[place(back)].wells; }
  const FluidPlaces& fluids(std::size_t back) const { return frames_[place(back)].fluids; }

 private:
  static constexpr std::size_t kMostBytes = 256u << 20, kMostFrames = 600, kLeastFrames = 8;
  static constexpr std::size_t kRowBytes = 9 * 4 + 1;

  struct Frame {
    Snapshot snapshot;
    WellPlaces wells;
    FluidPlaces fluids;
  };

  std::size_t place(std::size_t back) const { return (next_ + frames_.size() - 1 - back) % frames_.size(); }

  std::vector<Frame> frames_;  // a ring
  std::size_t next_ = 0, size_ = 0;
};

}  // namespace psim::view
