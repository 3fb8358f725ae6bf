// What the parts of a step do (step/step_table.h has one of these functions in each row). Each does some of its
// pieces, in order; what it knows of the world is its StepContext.
#pragma once

#include "step/step_table.h"

namespace psim::step_parts_run {

using Run = void(const StepContext&, const Span&, StepReport&, PieceRange);
Run check, renew, measure, count, move, search, near, select, pack, group, loads, gather, sort_out, keep, colour,
    lay_out, look, stand;

}  // namespace psim::step_parts_run
