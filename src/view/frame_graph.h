// The graph of step times: phases stacked, the newest to the right, with the budget as a line.
#pragma once

#include <deque>

#include "psim/report.h"

namespace psim::view {

/// Draws at Dear ImGui's cursor.
void draw_frame_graph(const std::deque<StepReport>& steps, double budget_ms);

}  // namespace psim::view
