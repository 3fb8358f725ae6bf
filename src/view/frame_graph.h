// The graph of step times: phases stacked, the newest to the right, with the budget as a line.
#pragma once

#include <cstdint>
#include <ranges>

#include "frame_log.h"

namespace psim::view {

/// The frames that the graph shows: the newest.
inline auto graph_frames(const FrameLog& log) {
  constexpr std::size_t kMost = 240;
  const std::size_t n = log.frames().size();
  return log.frames() | std::views::drop(n > kMost ? n - kMost : 0);
}

/// Draws at Dear ImGui's cursor. `shown` is marked if it is not the newest.
void draw_frame_graph(const FrameLog& log, std::uint64_t shown, double budget_ms);

}  // namespace psim::view
