// Counts what steps did and what they left out. The world owns one; each step opens and closes its page:
// begin_step, skip for everything that had nothing to do, end_step. World::skipped, lane_counts and lane_use read it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/column.h"
#include "psim/report.h"

namespace psim {

/// What steps did, in counts.
class Ledger {
 public:
  /// Opens the page of a step. `memory` counts the growths of the world's arrays.
  void begin_step(const MemoryMeter& memory);
  /// A stage or a part of one had nothing to do in this step. To say so twice changes nothing.
  void skip(Skip what, bool nothing_to_do = true) {
    skipped_ |= unsigned{nothing_to_do} << static_cast<unsigned>(what);
  }
  /// Nobody moves: everything is left out but what the host asked for.
  void skip_all(bool but_publish, bool but_events);
  /// Adds the page to the sums and writes it into the report. Lists that were rebuilt do not count as left out.
  void end_step(const MemoryMeter& memory, StepReport& report);

  /// Names what was left out, and in how many steps.
  std::vector<std::pair<std::string, std::uint64_t>> skipped() const;

  std::uint64_t frames = 0;  ///< in which the world stepped
  std::uint64_t steps = 0;   ///< frames in which time did not stand still
  /// Elements that were worked on in lanes and one at a time, since the world was made.
  LaneCounts lanes;

  /// Asks for a look at how full the blocks are, in every 16th step.
  void survey_lanes() { surveying_ = true; }
  bool surveys() const { return surveying_ && steps % kSurveySteps == 0; }
  /// Adds lanes of blocks, and how many of them held something, to what some kernels had so far.
  void add_lanes(std::string_view user, std::uint64_t lanes, std::uint64_t used);
  std::vector<LaneUse> lane_use() const;

 private:
  static constexpr std::uint64_t kSurveySteps = 16;

  std::uint32_t skipped_ = 0;         // a bit for each Skip, in this step
  std::uint64_t growths_before_ = 0;  // MemoryMeter::growths when the step began
  std::array<std::uint64_t, kSkipNames.size()> skipped_steps_{};
  std::vector<LaneUse> use_;  // in the order in which survey_lanes names them
  bool surveying_ = false;
};

struct StepContext;

/// How full the blocks of the kernels are after a step (`rebuilt`: it made new lists), for World::lane_use.
void survey_lanes(StepContext& c, bool rebuilt);

}  // namespace psim
