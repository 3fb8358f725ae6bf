// What the steps of a run did, by frame, so that a panel can tell of the frame that is shown.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "model/simulation.h"

namespace psim::view {

struct FrameValues {
  std::uint64_t frame = 0;
  std::optional<StepReport> step;  ///< the one that led to the frame; none: it began here
  std::optional<std::uint64_t> hash;
};

class FrameLog {
 public:
  /// Begins anew with a new run.
  void note(const Status& status);
  /// The newest last, without gaps.
  const std::deque<FrameValues>& frames() const { return frames_; }
  /// nullptr if nothing is known of it.
  const FrameValues* find(std::uint64_t frame) const;
  /// The newest up to `frame` that was hashed; nullptr: none.
  const FrameValues* hashed(std::uint64_t frame) const;

 private:
  static constexpr std::size_t kKept = 2400;  // a history of 600 pictures at four times the speed

  std::deque<FrameValues> frames_;
  std::uint64_t run_ = 0;
};

}  // namespace psim::view
