// Where the time of a run went: by stage and by thread, from the steps' reports and, with more than one thread, the
// spans that the world records in some of the frames. What it costs: docs/performance.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "psim/report.h"
#include "psim/world.h"

namespace psim::cli {

class Profile {
 public:
  static constexpr std::size_t kRecent = 240;  ///< frames of the rolling figures
  static constexpr std::uint32_t kEvery = 8, kFewestLooks = 64;
  static constexpr std::size_t kMostKept = 1 << 14;  ///< frames that percentiles are from, at most: see Samples

  Profile(int threads, std::uint64_t frames);

  /// Whether threads are to record the spans of the frame: all frames of a short run, one in kEvery of a long one.
  bool looks_at(std::uint64_t frame) const;
  /// One frame: its report and, if they were recorded, its spans.
  void add(const StepReport& report, const std::vector<TraceEvent>* spans);

  struct Row {
    std::string_view stage;
    double mean_ms = 0, p99_ms = 0, share = 0;     ///< share of all stages, 0..1
    double busy = 0;                               ///< of all threads while the stage ran, 0..1
    double recent_mean_ms = 0, recent_p99_ms = 0;  ///< of the last kRecent frames
  };
  /// Stages that took time, the longest first.
  std::vector<Row> rows() const;
  /// Of the frames' time, what all threads together were busy; 0..1.
  double busy() const;
  /// The busiest thread over the mean of all, at least 1.
  double imbalance() const;

  std::vector<LaneUse> lanes;  ///< at the end of the run

 private:
  using Stages = std::array<double, kStageCount>;
  double busy_ns(std::size_t thread) const;

  Stages sum_ms_{};
  std::vector<Stages> kept_;  // every stride_-th frame
  std::vector<Stages> recent_;
  std::uint64_t frames_ = 0, stride_ = 1;
  std::size_t next_recent_ = 0;
  std::uint32_t every_;
  // Of the frames with spans: the stages' own time, and by thread what of it it was busy.
  Stages looked_ms_{};
  std::vector<Stages> busy_ns_;
  double looked_total_ms_ = 0;
};

/// As lines of the report.
std::string profile_text(const Profile& profile);

}  // namespace psim::cli
