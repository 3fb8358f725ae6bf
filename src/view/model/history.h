// The last frames, to look back at: copies of snapshots, as many as fit into kMostBytes.
#pragma once

#include <cstddef>
#include <vector>

#include "psim/world.h"

namespace psim::view {

class History {
 public:
  /// Copies a frame; the oldest goes.
  void record(const Snapshot& snapshot);
  void clear();
  std::size_t size() const { return size_; }
  /// 0: the newest.
  const Snapshot& at(std::size_t back) const { return frames_[(next_ + frames_.size() - 1 - back) % frames_.size()]; }

 private:
  static constexpr std::size_t kMostBytes = 256u << 20, kMostFrames = 600, kLeastFrames = 8;
  static constexpr std::size_t kRowBytes = 9 * 4 + 1;

  std::vector<Snapshot> frames_;  // a ring
  std::size_t next_ = 0, size_ = 0;
};

}  // namespace psim::view
