#include "model/frame_log.h"

#include <algorithm>

namespace psim::view {

void FrameLog::note(const Status& status) {
  const std::size_t n = status.steps.size();
  if (status.run_serial != run_) frames_.clear();
  run_ = status.run_serial;
  const std::uint64_t next = status.frame + 1 - n;
  if (!frames_.empty() && frames_.back().frame + 1 != next) frames_.clear();  // some went unread
  for (std::size_t k = 0; k < n; ++k) frames_.push_back({next + k, status.steps[k], std::nullopt});
  if (frames_.empty()) frames_.push_back({status.frame, std::nullopt, std::nullopt});
  while (frames_.size() > kKept) frames_.pop_front();
  const auto at = std::ranges::find(frames_, status.hash_frame, &FrameValues::frame);
  if (at != frames_.end()) at->hash = status.hash;
}

const FrameValues* FrameLog::find(std::uint64_t frame) const {
  if (frames_.empty() || frame < frames_.front().frame || frame > frames_.back().frame) return nullptr;
  return &frames_[frame - frames_.front().frame];
}

const FrameValues* FrameLog::hashed(std::uint64_t frame) const {
  for (auto values = frames_.rbegin(); values != frames_.rend(); ++values) {
    if (values->frame <= frame && values->hash) return &*values;
  }
  return nullptr;
}

}  // namespace psim::view
