// The report for people. Its columns and words are relied on by scripts too.
#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "output/text.h"
#include "psim/version.h"
#include "report/run_report.h"

namespace psim::cli {
namespace {

double percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

std::string grouped_mean(double mean) { return grouped(static_cast<std::uint64_t>(std::llround(mean))); }

std::string skipped_text(const RunReport& report) {
  std::string text;
  for (const auto& [stage, frames] : report.skipped) {
    if (frames == 0) continue;
    text += fmt::format("{}{} in {}", text.empty() ? "" : ", ", stage, frames);
  }
  if (text.empty()) return "nothing";
  return text + fmt::format(" of {} frames", report.frame_ms.count());
}

// Frames in which lists were kept for most bodies.
std::string renewed_text(const RunReport& report) {
  if (report.frames_renewed == 0) return "";
  const double mean = static_cast<double>(report.renewed_sum) / static_cast<double>(report.frames_renewed);
  return fmt::format(" ({} of them but for {} bodies)", report.frames_renewed, grouped_mean(mean));
}

std::string fluid_text(const FluidReport& fluid) {
  std::string text = fmt::format(
      "Fluid: {} particles  kinetic {:.6g} J  density error mean {:.3g} % max {:.3g} %  {} iterations in "
      "the last step\n",
      grouped(fluid.particles), fluid.kinetic, 100 * fluid.density_error_mean, 100 * fluid.density_error_max,
      fluid.iterations);
  if (fluid.emitted + fluid.drained + fluid.withheld != 0) {
    text += fmt::format("Taps: {} particles emitted  {} drained  {} withheld\n", grouped(fluid.emitted),
                        grouped(fluid.drained), grouped(fluid.withheld));
  }
  return text;
}

}  // namespace

std::string report_text(const RunReport& report) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "psim {}  scene {}  {} bodies  {} ({} lanes)  {} threads  ", PSIM_VERSION_STRING,
                 one_line(report.scene), grouped(report.bodies_total), isa_name(report.isa), isa_lanes(report.isa),
                 report.threads);
  fmt::format_to(out, "dt {:.4g} ms x {} substeps\n", report.dt_s * 1000, report.substeps);

  fmt::format_to(out, "{:<22}{:>10}{:>10}{:>9}\n", "Phase", "mean ms", "p99 ms", "budget");
  const auto row = [&](std::string_view title, const Samples& ms) {
    fmt::format_to(out, "{:<22}{:>10.4f}{:>10.4f}{:>7.1f} %\n", title, ms.mean(), ms.percentile(99),
                   percent(ms.mean(), report.budget_ms));
  };
  for (std::size_t i = 0; i < kPhaseCount; ++i) row(kPhases[i].title, report.phase_ms[i]);
  row("Total physics", report.frame_ms);

  const Samples& frame = report.frame_ms;
  fmt::format_to(out,
                 "Frames {}, over budget {}, p50 {:.4f} p95 {:.4f} p99 {:.4f} max {:.4f} ms, "
                 "{:.0f} fps\n",
                 frame.count(), report.frames_over_budget, frame.percentile(50), frame.percentile(95),
                 frame.percentile(99), frame.max(), frame.mean() > 0 ? 1000 / frame.mean() : 0);
  fmt::format_to(out,
                 "Pairs {}  contacts {}  hit ratio {:.1f} %  colours {:.1f}  "
                 "neighbour lists rebuilt {} of {} frames\n",
                 grouped_mean(report.per_frame(report.pairs_sum)), grouped_mean(report.per_frame(report.contacts_sum)),
                 percent(report.touching_sum, report.pairs_sum), report.per_frame(report.colours_sum),
                 report.neighbour_rebuilds, frame.count());
  const auto vector = static_cast<double>(report.lanes.vector);
  const auto scalar = static_cast<double>(report.lanes.scalar);
  fmt::format_to(out, "SIMD: {} lane operations, {} scalar fallbacks ({:.2f} %)\n", grouped(report.lanes.vector),
                 grouped(report.lanes.scalar), percent(scalar, vector + scalar));
  fmt::format_to(out, "Energy {:.6g} -> {:.6g} J  momentum ({:.4g}, {:.4g})  max penetration {:.3g} m\n",
                 report.start.kinetic + report.start.potential, report.end.kinetic + report.end.potential,
                 report.end.momentum_x, report.end.momentum_y, report.end.max_penetration);
  if (report.fluid) text += fluid_text(*report.fluid);
  if (report.target) text += target_text(*report.target);
  if (report.profile) text += profile_text(*report.profile);
  fmt::format_to(out, "Skipped: {}\n", skipped_text(report));
  fmt::format_to(out,
                 "Ledger: asleep {} of {} bodies (mean), lists kept in {} of {} frames{}, pairs reused {:.1f} %, "
                 "nobody fast in {}, {} substeps saved\n",
                 grouped_mean(report.per_frame(report.asleep_sum)), grouped(report.bodies_dynamic), report.lists_kept,
                 frame.count(), renewed_text(report), percent(report.reused_sum, report.pairs_sum),
                 frame.count() - report.fast_frames, grouped(report.substeps_saved));
  if (report.governed) {
    fmt::format_to(
        out,
        "Governor: {} frames with fewer substeps, {} in which time stood still, {} substeps saved, "
        "{} frames with few sweeps over impacts, {} with few parts of fluids' steps, time of {} frames lost\n",
        report.frames_cut, report.frames_waited, grouped(report.substeps_saved), report.frames_few_sweeps,
        report.frames_few_parts, report.frames_lost);
  }
  fmt::format_to(out, "State {}\n", hash_text(report.state_hash));
  return text;
}

}  // namespace psim::cli
