#include "model/history.h"

#include <algorithm>

namespace psim::view {

void History::record(const Snapshot& snapshot, const WellPlaces& wells, const FluidPlaces& fluids) {
  const std::size_t of_fluids = fluids ? fluids->particles * FluidLook::kRowBytes : 0;
  const std::size_t bytes = std::max<std::size_t>(snapshot.id.size() * kRowBytes + of_fluids, 1);
  const std::size_t room = std::clamp(kMostBytes / bytes, kLeastFrames, kMostFrames);
  if (frames_.empty() || room < frames_.size()) {
    clear();
    frames_.resize(room);
  }
  frames_[next_].snapshot = snapshot;  // into memory that is there
  frames_[next_].wells = wells;
  frames_[next_].fluids = fluids;
  next_ = (next_ + 1) % frames_.size();
  size_ = std::min(size_ + 1, frames_.size());
}

void History::clear() {
  frames_.clear();
  next_ = size_ = 0;
}

}  // namespace psim::view
