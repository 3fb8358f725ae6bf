// What the parts of a step cost, in predicted ns: piece_* is one piece of a part, whole_* all of it where only counts
// are known (step/step_table.h has one pair of them in each row).
#pragma once

#include <cstddef>

#include "step/step_context.h"

namespace psim::part_costs {

using Piece = double(const StepContext&, const WorkCounts&, std::size_t piece);
Piece piece_check, piece_renew, piece_measure, piece_count, piece_move, piece_search, piece_near, piece_select,
    piece_pack, piece_group, piece_loads, piece_gather, piece_sort_out, piece_keep, piece_colour, piece_lay_out,
    piece_look, piece_stand;

using Whole = double(const UnitCosts&, const WorkCounts&);
Whole whole_check, whole_measure, whole_count, whole_move, whole_search, whole_near, whole_select, whole_pack,
    whole_loads, whole_gather, whole_sort_out, whole_keep, whole_colour, whole_lay_out, whole_stand;

inline double nothing(const UnitCosts&, const WorkCounts&) { return 0; }

}  // namespace psim::part_costs
