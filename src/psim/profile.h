// Where the time of a run went: by stage and by thread, from the steps' reports and the spans that the world
// records. Costs 10 ns a frame on one thread; with more, the spans (docs/performance.md).
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
  static constexpr std::size_t kRecent = 240;         ///< frames of the rolling figures
  static constexpr std::size_t kMostKept = 1 << 14;   ///< frames that percentiles are from, at most: see Samples

  explicit Profile(int threads) : recent_(kRecent), busy_ns_(static_cast<std::size_t>(threads)) {}

  /// One frame: its report and, with more than one thread, the spans that they recorded.
  void add(const StepReport& report, const std::vector<TraceEvent>& spans);

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
  std::vector<Stages> busy_ns_;  // by thread; of one alone the stages' own time
  double total_ms_ = 0;
};

/// As lines of the report.
std::string profile_text(const Profile& profile);

}  // namespace psim::cli
