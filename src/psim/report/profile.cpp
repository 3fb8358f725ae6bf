#include "report/profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace psim::cli {
namespace {

// The smallest value that at least 99 % do not exceed (nearest rank).
double p99_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const double rank = std::ceil(0.99 * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

template <class Rows>
std::vector<double> column(const Rows& rows, std::size_t count, std::size_t stage) {
  std::vector<double> values(count);
  for (std::size_t k = 0; k < count; ++k) values[k] = rows[k][stage];
  return values;
}

}  // namespace

Profile::Profile(int threads, std::uint64_t frames)
    : recent_(kRecent),
      every_(static_cast<std::uint32_t>(std::clamp<std::uint64_t>(frames / kFewestLooks, 1, kEvery))),
      busy_ns_(static_cast<std::size_t>(threads)) {}

// At no fixed distance: what steps do at one, such as making lists, would be seen always or never.
bool Profile::looks_at(std::uint64_t frame) const {
  const auto mixed = static_cast<std::uint32_t>(frame * 0x9E3779B97F4A7C15u >> 32);
  return busy_ns_.size() > 1 && mixed % every_ == 0;
}

void Profile::add(const StepReport& report, const std::vector<TraceEvent>* spans) {
  for (std::size_t i = 0; i < kStageCount; ++i) sum_ms_[i] += report.stage_ms[i];
  recent_[next_recent_] = report.stage_ms;
  next_recent_ = next_recent_ + 1 == kRecent ? 0 : next_recent_ + 1;
  if ((frames_ & (stride_ - 1)) == 0) {
    if (kept_.size() == kMostKept) {
      for (std::size_t k = 0; k < kMostKept / 2; ++k) kept_[k] = kept_[2 * k];
      kept_.resize(kMostKept / 2);
      stride_ *= 2;
    }
    if ((frames_ & (stride_ - 1)) == 0) kept_.push_back(report.stage_ms);
  }
  ++frames_;
  if (spans == nullptr && busy_ns_.size() > 1) return;
  for (std::size_t i = 0; i < kStageCount; ++i) looked_ms_[i] += report.stage_ms[i];
  looked_total_ms_ += report.total_ms;
  if (spans == nullptr) return;

  double waited_ns = 0;        // of the first thread, in the stage whose span comes next
  const char* last = nullptr;  // spans of one stage follow each other: its name is looked up once
  auto at = kStageNames.end();
  for (const TraceEvent& span : *spans) {
    const auto length_ns = static_cast<double>(span.end_ns - span.begin_ns);
    const auto thread = static_cast<std::size_t>(span.thread);
    if (std::string_view(span.name) == "wait") {
      waited_ns += length_ns;
      continue;
    }
    if (span.name != last) at = std::find(kStageNames.begin(), kStageNames.end(), std::string_view(span.name));
    last = span.name;
    if (thread >= busy_ns_.size() || at == kStageNames.end()) continue;
    double& busy = busy_ns_[thread][static_cast<std::size_t>(at - kStageNames.begin())];
    busy += length_ns;
    if (thread != 0) continue;
    busy -= waited_ns;
    waited_ns = 0;
  }
}

std::vector<Profile::Row> Profile::rows() const {
  const double all = std::accumulate(sum_ms_.begin(), sum_ms_.end(), 0.0);
  const std::size_t recent = std::min<std::size_t>(static_cast<std::size_t>(frames_), kRecent);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < kStageCount; ++i) {
    if (!(sum_ms_[i] > 0)) continue;
    double busy = 0;
    for (const Stages& thread : busy_ns_) busy += thread[i];
    if (busy_ns_.size() == 1) busy = looked_ms_[i] * 1e6;
    const double looked_ns = looked_ms_[i] * 1e6 * static_cast<double>(busy_ns_.size());
    const std::vector<double> last = column(recent_, recent, i);
    Row row;
    row.stage = kStageNames[i];
    row.mean_ms = sum_ms_[i] / static_cast<double>(frames_);
    row.p99_ms = p99_of(column(kept_, kept_.size(), i));
    row.share = sum_ms_[i] / all;
    row.busy = looked_ns > 0 ? std::clamp(busy / looked_ns, 0.0, 1.0) : 0;
    row.recent_mean_ms = std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(recent);
    row.recent_p99_ms = p99_of(last);
    rows.push_back(row);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.mean_ms > b.mean_ms; });
  return rows;
}

double Profile::busy_ns(std::size_t thread) const {
  const Stages& stages = busy_ns_[thread];
  return busy_ns_.size() == 1 ? 1e6 * std::accumulate(looked_ms_.begin(), looked_ms_.end(), 0.0)
                              : std::accumulate(stages.begin(), stages.end(), 0.0);
}

double Profile::busy() const {
  double sum = 0;
  for (std::size_t thread = 0; thread < busy_ns_.size(); ++thread) sum += busy_ns(thread);
  const double wall = looked_total_ms_ * 1e6 * static_cast<double>(busy_ns_.size());
  return wall > 0 ? std::min(sum / wall, 1.0) : 0;
}

double Profile::imbalance() const {
  double most = 0, sum = 0;
  for (std::size_t thread = 0; thread < busy_ns_.size(); ++thread) {
    most = std::max(most, busy_ns(thread));
    sum += busy_ns(thread);
  }
  return sum > 0 ? most * static_cast<double>(busy_ns_.size()) / sum : 1;
}

std::string profile_text(const Profile& profile) {
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{:<22}{:>10}{:>10}{:>9}{:>14}{:>14}{:>10}\n", "Stage", "mean ms", "p99 ms", "share",
                 "threads busy", fmt::format("last {}: ms", Profile::kRecent), "p99 ms");
  const std::vector<Profile::Row> rows = profile.rows();
  for (const Profile::Row& row : rows) {
    fmt::format_to(out, "{:<22}{:>10.4f}{:>10.4f}{:>7.1f} %{:>12.1f} %{:>14.4f}{:>10.4f}\n", row.stage, row.mean_ms,
                   row.p99_ms, 100 * row.share, 100 * row.busy, row.recent_mean_ms, row.recent_p99_ms);
  }
  if (!rows.empty()) {
    fmt::format_to(out, "Bottleneck: {}, {:.1f} % of the time; threads busy {:.1f} %, the busiest {:.2f} x the mean\n",
                   rows[0].stage, 100 * rows[0].share, 100 * profile.busy(), profile.imbalance());
  }
  if (!profile.lanes.empty()) {
    text += "Lanes used:";
    for (const LaneUse& use : profile.lanes) {
      fmt::format_to(out, "{} {} {:.1f} %", &use == &profile.lanes[0] ? "" : ",", use.kernels,
                     100 * static_cast<double>(use.used) / static_cast<double>(use.lanes));
    }
    text += "\n";
  }
  return text;
}

}  // namespace psim::cli
