// The graph of step times: phases stacked, the newest to the right, with the budget as a line.
#pragma once

#include <cstddef>
#include <cstdint>

#include "model/frame_log.h"

namespace psim::view {

/// Index of the first frame of the log that the graph shows; it shows all from there on.
inline std::size_t first_graph_frame(const FrameLog& log) {
  constexpr std::size_t kMost = 240;
  return log.frames().size() > kMost ? log.frames().size() - kMost : 0;
}

/// Draws at Dear ImGui's cursor. `shown` is marked if it is not the newest.
void draw_frame_graph(const FrameLog& log, std::uint64_t shown, double budget_ms);

}  // namespace psim::view
