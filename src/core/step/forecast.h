// Predicted times of what a step does, from counted work and the costs of units: linear, with a few factors for how
// work of one kind differs. docs/governor.md has where the numbers come from.
#pragma once

#include "step/cost_table.h"
#include "step/work_counts.h"

namespace psim {

/// The share of contacts that press, where bodies of several sizes bounce; else 0.
double crowded(const WorkCounts& work);

/// ns of one contact of discs that is laid out, of one candidate that is selected from.
double lay_out_ns(const UnitCosts& costs, const WorkCounts& work);
double select_ns(const UnitCosts& costs, const WorkCounts& work);
/// ns to find how fast bodies move in their strips, before a step selects.
double speeds_ns(const UnitCosts& costs, const WorkCounts& work);
/// ns to look at all manifolds; to keep them as they were beside that.
double look_ns(const UnitCosts& costs, const WorkCounts& work);
double remember_ns(const UnitCosts& costs, const WorkCounts& work);

/// ns of all parts of the step table, if lists are made; of those that change contacts in place.
double ahead_ns(const UnitCosts& costs, const WorkCounts& work);
double in_place_ns(const UnitCosts& costs, const WorkCounts& work);
/// ns of what comes after them but for the substeps, and of one substep.
double rest_ns(const UnitCosts& costs, const WorkCounts& work);
double substep_ns(const UnitCosts& costs, const WorkCounts& work);

}  // namespace psim
