// Records which stage ran when on which thread, if the host asked for a trace. If not, it costs one branch a stage.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <vector>

#include "psim/report.h"

namespace psim {

/// Name of the spans in which the first thread waits for the last jobs of the others. They lie within a stage's span.
inline constexpr const char* kWaitName = "wait";

class Tracer {
 public:
  using Clock = std::chrono::steady_clock;

  void start(int threads) {
    if (tracks_.empty()) origin_ = Clock::now();
    tracks_.resize(static_cast<std::size_t>(threads));
    on_.store(true, std::memory_order_relaxed);
  }
  /// Ends recording; the spans so far can still be taken.
  void stop() { on_.store(false, std::memory_order_relaxed); }
  bool on() const { return on_.load(std::memory_order_relaxed); }

  /// Reads the clock: the next stage begins now.
  Clock::time_point begin() { return stage_end_ = Clock::now(); }
  /// The time at which the last stage ended, or the step began.
  Clock::time_point stage_end() const { return stage_end_; }
  void set_stage(const char* name) { stage_ = name; }
  const char* stage() const { return stage_; }

  /// Adds a span; each thread writes its own track.
  void add(std::size_t thread, const char* name, Clock::time_point begin, Clock::time_point end) {
    tracks_[thread].spans.push_back({name, static_cast<int>(thread), ns(begin), ns(end)});
  }

  std::vector<TraceEvent> take() {
    std::size_t count = 0;
    for (const Track& t : tracks_) count += t.spans.size();
    std::vector<TraceEvent> all;
    all.reserve(count);
    for (Track& t : tracks_) {
      all.insert(all.end(), t.spans.begin(), t.spans.end());
      t.spans.clear();
    }
    return all;
  }

 private:
  // The spans of one thread, in a cache line of its own, because threads write at the same time.
  struct alignas(64) Track {
    std::vector<TraceEvent> spans;
  };

  std::int64_t ns(Clock::time_point t) const {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(t - origin_).count();
  }
  std::atomic<bool> on_ = false;  // atomic, because a late worker may read it between two steps
  const char* stage_ = "";
  Clock::time_point origin_, stage_end_;
  std::vector<Track> tracks_;
};

}  // namespace psim
