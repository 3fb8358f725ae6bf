#include "profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace psim::cli {

void Profile::add(const StepReport& report, const std::vector<TraceEvent>& spans) {
  for (std::size_t i = 0; i < kStageCount; ++i) stage_ms_[i].add(report.stage_ms[i]);
  total_ms_ += report.total_ms;
  for (const TraceEvent& span : spans) {
    const auto thread = static_cast<std::size_t>(span.thread);
    const auto at = std::find(kStageNames.begin(), kStageNames.end(), std::string_view(span.name));
    if (thread >= busy_ns_.size() || at == kStageNames.end()) continue;
    busy_ns_[thread][static_cast<std::size_t>(at - kStageNames.begin())] +=
        static_cast<double>(span.end_ns - span.begin_ns);
  }
}

std::vector<Profile::Row> Profile::rows() const {
  double all = 0;
  for (const Samples& ms : stage_ms_) all += ms.mean();
  std::vector<Row> rows;
  for (std::size_t i = 0; i < kStageCount; ++i) {
    const double mean = stage_ms_[i].mean();
    if (!(mean > 0)) continue;
    double busy = 0;
    for (const auto& thread : busy_ns_) busy += thread[i];
    const double wall = mean * 1e6 * static_cast<double>(stage_ms_[i].count() * busy_ns_.size());
    rows.push_back({kStageNames[i], mean, stage_ms_[i].percentile(99), mean / all,
                    std::min(busy / wall, 1.0)});
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return a.mean_ms > b.mean_ms; });
  return rows;
}

double Profile::busy() const {
  double sum = 0;
  for (const auto& thread : busy_ns_) {
    for (const double ns : thread) sum += ns;
  }
  const double wall = total_ms_ * 1e6 * static_cast<double>(busy_ns_.size());
  return wall > 0 ? std::min(sum / wall, 1.0) : 0;
}

double Profile::imbalance() const {
  double most = 0, sum = 0;
  for (const auto& thread : busy_ns_) {
    double mine = 0;
    for (const double ns : thread) mine += ns;
    most = std::max(most, mine);
    sum += mine;
  }
  return sum > 0 ? most * static_cast<double>(busy_ns_.size()) / sum : 1;
}

std::string profile_text(const Profile& profile) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{:<22}{:>10}{:>10}{:>9}{:>14}\n", "Stage", "mean ms", "p99 ms", "share", "threads busy");
  const std::vector<Profile::Row> rows = profile.rows();
  for (const Profile::Row& row : rows) {
    fmt::format_to(out, "{:<22}{:>10.4f}{:>10.4f}{:>7.1f} %{:>12.1f} %\n", row.stage, row.mean_ms, row.p99_ms,
                   100 * row.share, 100 * row.busy);
  }
  if (!rows.empty()) {
    fmt::format_to(out, "Bottleneck: {}, {:.1f} % of the time; threads busy {:.1f} %, the busiest {:.2f} x the mean\n",
                   rows[0].stage, 100 * rows[0].share, 100 * profile.busy(), profile.imbalance());
  }
  return text;
}

}  // namespace psim::cli
