// The phases of the report: stages of a step, put together under the words that users know.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "psim/report.h"

namespace psim::cli {

struct Phase {
  std::string_view key;    ///< in JSON and CSV
  std::string_view title;  ///< in the text report
};

inline constexpr std::size_t kPhaseCount = 5;
inline constexpr std::array<Phase, kPhaseCount> kPhases = {{
    {"broad_phase", "Broad-phase"},
    {"narrow_phase", "Narrow-phase"},
    {"constraints", "Constraint resolution"},
    {"integration", "Integration"},
    {"publish", "Rendering sync"},
}};

/// Milliseconds a phase, in the order of kPhases.
inline std::array<double, kPhaseCount> phase_ms(const StepReport& report) {
  const auto stage = [&report](Stage s) { return report.stage_ms[static_cast<std::size_t>(s)]; };
  return {stage(Stage::broad_phase), stage(Stage::narrow_phase),
          stage(Stage::colouring) + stage(Stage::solver) + stage(Stage::fluid),
          stage(Stage::forces) + stage(Stage::integrate) + stage(Stage::sleep), stage(Stage::publish)};
}

}  // namespace psim::cli
