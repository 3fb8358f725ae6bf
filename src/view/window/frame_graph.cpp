#include "window/frame_graph.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <string>

#include "report/phases.h"

namespace psim::view {
namespace {

constexpr std::array<ImU32, cli::kPhaseCount> kColours = {IM_COL32(86, 180, 233, 255), IM_COL32(0, 158, 115, 255),
                                                          IM_COL32(230, 159, 0, 255), IM_COL32(204, 121, 167, 255),
                                                          IM_COL32(150, 150, 150, 255)};
constexpr std::array<const char*, cli::kPhaseCount> kWords = {"broad", "narrow", "constraints", "integration",
                                                              "publish"};
constexpr ImU32 kBudget = IM_COL32(255, 90, 90, 255), kGround = IM_COL32(0, 0, 0, 90),
                kShown = IM_COL32(255, 255, 255, 255);

}  // namespace

void draw_frame_graph(const FrameLog& log, std::uint64_t shown, double budget_ms) {
  constexpr float kHeight = 80;
  constexpr double kAboveBudget = 1.25, kLeastShare = 0.25;
  double most = kLeastShare * budget_ms;
  const auto& frames = log.frames();
  const std::size_t first = first_graph_frame(log);
  for (std::size_t k = first; k < frames.size(); ++k) {
    if (frames[k].step) most = std::max(most, frames[k].step->total_ms);
  }
  // The budget's line is in the graph once a step comes near it.
  const double top = most > 0.6 * budget_ms ? std::max(most, kAboveBudget * budget_ms) : 1.2 * most;

  ImDrawList* const draw = ImGui::GetWindowDrawList();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const auto height_of = [&](double ms) { return static_cast<float>(ms / top) * kHeight; };
  draw->AddRectFilled(at, {at.x + width, at.y + kHeight}, kGround);
  const float bar = width / 240;
  float x = at.x + width - bar * static_cast<float>(frames.size() - first);
  std::array<double, cli::kPhaseCount> last{};
  for (std::size_t k = first; k < frames.size(); ++k) {
    const FrameValues& values = frames[k];
    last = values.step ? cli::phase_ms(*values.step) : std::array<double, cli::kPhaseCount>{};
    if (values.frame == shown && k + 1 != frames.size()) {
      draw->AddLine({x, at.y}, {x, at.y + kHeight}, kShown, 1);
    }
    float y = at.y + kHeight;
    for (std::size_t k = 0; k < last.size(); ++k) {
      const float up = std::max(y - height_of(last[k]), at.y);
      draw->AddRectFilled({x, up}, {x + std::max(bar, 1.0f), y}, kColours[k]);
      y = up;
    }
    x += bar;
  }
  const bool fits = budget_ms < top;
  const float line = at.y + kHeight - (fits ? height_of(budget_ms) : kHeight);
  draw->AddLine({at.x, line}, {at.x + width, line}, kBudget, fits ? 1.5f : 1.0f);
  const std::string budget = fmt::format("{}budget {:.1f} ms", fits ? "" : "above: ", budget_ms);
  const float below = line + 1 + ImGui::GetTextLineHeight();  // or above the line, where it lies low
  draw->AddText({at.x + 4, below <= at.y + kHeight ? line + 1 : line - 1 - ImGui::GetTextLineHeight()}, kBudget,
                budget.c_str());
  ImGui::Dummy({width, kHeight});
  for (std::size_t k = 0; k < last.size(); ++k) {
    if (k % 3 != 0) ImGui::SameLine((k == 1 ? 0.31f : 0.62f) * width);
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(kColours[k]), "%s %.2f", kWords[k], last[k]);
  }
}

}  // namespace psim::view
