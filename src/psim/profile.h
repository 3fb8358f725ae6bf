// Where the time of a run went: by stage and by thread, from the spans that the world records.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "psim/report.h"
#include "psim/world.h"
#include "samples.h"

namespace psim::cli {

class Profile {
 public:
  explicit Profile(int threads) : busy_ns_(static_cast<std::size_t>(threads)) {}

  /// One frame: its report and the spans that its threads recorded.
  void add(const StepReport& report, const std::vector<TraceEvent>& spans);

  struct Row {
    std::string_view stage;
    double mean_ms = 0, p99_ms = 0, share = 0;  ///< share of all stages, 0..1
    double busy = 0;                            ///< of all threads while the stage ran, 0..1
  };
  /// Stages that took time, the longest first.
  std::vector<Row> rows() const;
  /// Of the frames' time, what all threads together were busy; 0..1.
  double busy() const;
  /// The busiest thread over the mean of all, at least 1.
  double imbalance() const;

 private:
  std::array<Samples, kStageCount> stage_ms_;
  std::vector<std::array<double, kStageCount>> busy_ns_;  // by thread
  double total_ms_ = 0;
};

/// As lines of the report.
std::string profile_text(const Profile& profile);

}  // namespace psim::cli
