// What a run came to: filled by run.cpp, printed by report_text.cpp and report_json.cpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "options/target.h"
#include "psim/fluid.h"
#include "psim/isa.h"
#include "psim/report.h"
#include "report/phases.h"
#include "report/profile.h"
#include "report/samples.h"

namespace psim::cli {

struct RunReport {
  std::string scene;
  Isa isa = Isa::scalar;
  int threads = 1;
  std::uint64_t frames_wanted = 0;  ///< frames done are frame_ms.count()
  double dt_s = 0;
  int substeps = 0;
  std::uint64_t seed = 0;

  std::size_t bodies_total = 0, bodies_dynamic = 0, bodies_static = 0;
  std::uint64_t bodies_awake = 0, bodies_asleep = 0;

  std::optional<Target> target;
  std::optional<Profile> profile;

  double budget_ms = 0;
  std::uint64_t frames_over_budget = 0;
  Samples frame_ms;  ///< wall time around every World::step, the first ones included
  std::array<Samples, kPhaseCount> phase_ms;

  double pairs_sum = 0, contacts_sum = 0, touching_sum = 0, colours_sum = 0;  ///< over all frames
  std::uint64_t neighbour_rebuilds = 0;
  // The ledger of what was left out.
  double asleep_sum = 0, reused_sum = 0;  ///< bodies, pairs; over all frames
  std::uint64_t lists_kept = 0;           ///< frames
  std::uint64_t frames_renewed = 0;       ///< in which lists of some bodies alone were made anew
  std::uint64_t renewed_sum = 0;          ///< bodies, summed over them
  std::uint64_t fast_frames = 0;          ///< in which a body's way was looked at
  double fast_sum = 0;                    ///< bodies, over all frames
  std::array<std::uint64_t, kSkipNames.size()> frames_skipped{};
  bool governed = false;
  std::uint64_t frames_cut = 0, frames_waited = 0;  ///< with fewer substeps; in which time stood still
  std::uint64_t substeps_saved = 0;                 ///< against all frames done in full
  std::uint64_t frames_few_parts = 0;               ///< with a limit on the parts in which fluids move
  std::uint64_t frames_few_sweeps = 0;              ///< with a limit on sweeps over impacts
  std::uint64_t frames_lost = 0;                    ///< that no step made up for: the world went slower
  std::uint64_t frames_waiting = 0;                 ///< that the present step may make up for
  LaneCounts lanes;

  Diagnostics start, end;
  std::optional<FluidReport> fluid;  ///< at the end; nothing: the scene has no fluids
  double virial = 0;                 ///< N s m, over all frames
  std::uint64_t escaped = 0;
  std::uint64_t quarantined = 0, first_quarantine_frame = 0;

  std::vector<std::pair<std::string, std::uint64_t>> skipped;
  std::size_t memory_bytes = 0;
  std::uint64_t state_hash = 0;

  double per_frame(double sum) const { return frame_ms.count() == 0 ? 0 : sum / static_cast<double>(frame_ms.count()); }
};

std::string report_text(const RunReport& report);
std::string report_json(const RunReport& report);

}  // namespace psim::cli
