// Written by tools/cost-table; do not edit the numbers by hand. What a unit of work costs, in ns, on one thread.
// Measured 2026-11-22 on an Intel Xeon with 2 vCPUs, g++ 12.2, AVX2 (docs/governor.md says how).
//
// World::measure_costs scales these to the machine that it runs on: CostModel holds the numbers in this order.
#pragma once

#include <bit>

#include "psim/governor.h"

namespace psim {

struct UnitCosts {
  double step = 3000;         ///< a frame, whatever is in it
  double check = 0.5;         ///< a body: do its lists serve
  double sort = 12.5;         ///< a body, when lists are made: to its cell
  double search = 3.5;        ///< a body: its candidates
  double test = 0.25;         ///< two bodies that are looked at for that
  double pair = 1.8;          ///< a candidate pair that is found
  double near = 2.5;          ///< a body: walls near it
  double near_fixed = 60;     ///< a body, where there are fixed shapes or sleepers
  double near_shape = 180;    ///< a fixed shape near a body
  double select = 2.2;        ///< a candidate pair, when a step selects from them
  double pack = 3.2;          ///< a pair that was selected, a body that the solver may leave out
  double group = 80;          ///< a manifold, when it is taken out of the lists of discs
  double load = 4;            ///< a contact of discs, where bodies carry much heavier ones
  double colour = 3.2;        ///< a contact of discs, when contacts are laid out: its colour
  double lay_out = 12;        ///< a contact of discs: its lane
  double lay_out_rough = 18;  ///< the same with friction or restitution
  double keep = 40;           ///< a manifold that is kept as it is: its gaps
  double look = 180;          ///< a manifold that is looked at anew
  double stand = 14;          ///< a manifold: who stands on whom
  double column = 30;         ///< a manifold, once a step: its lane
  double narrow = 2.7;        ///< a contact of discs, once a step: its normal, its sums
  double load_body = 5;       ///< a body that the solver copies
  double move = 1.5;          ///< a body: integrate
  double stop = 15;           ///< a body, where shapes fly fast
  double sleep = 4;           ///< a body or a contact, each time that sleep looks at it
  double joint = 35;          ///< a joint, once a step
  double joint_sorted = 200;  ///< a joint whose bodies have new slots
  double body_pass = 3.5;     ///< a body that the solver has, in a substep
  double pass = 1.4;          ///< a lane of contacts of discs, in a substep
  double touch = 3.9;         ///< a contact that presses, in a substep
  double sweep = 2.4;         ///< a lane, in a sweep over impacts, where there is restitution
  double shape_pass = 15;     ///< a manifold, in a substep
  double joint_pass = 44;     ///< a joint, in a substep
  double cell = 1;            ///< a cell of the grid, when lists are made
  double flight = 350;        ///< a fixed shape near the way of a fast shape
  double strip = 50;          ///< a strip, each time that its lists are gone through
  double particle = 60;       ///< a particle of a fluid, in a part of a step
};

/// How work of one kind differs: factors, the same on every machine. tools/cost-table leaves them as they are.
namespace cost {

// Factors on UnitCosts::touch, a contact that presses: where bodies of several sizes turn, where they bounce, both.
inline constexpr double kMixedTouch = 1.4, kBouncing = 4, kMixedBouncing = 5;
// On UnitCosts::lay_out and select, where bodies of several sizes bounce: for all contacts that press.
inline constexpr double kMixedPressing = 1, kMixedSelect = 2;
// On UnitCosts::lay_out, where some contacts may be under heavy loads; on a lane under one, of which a strip has few.
inline constexpr double kLoads = 1.4, kSparse = 1.7;
// On UnitCosts::narrow, a lane, once a step. With restitution: which contacts impacts are looked for at. Where bodies
// of several sizes fly about: what lies far apart in memory. Both.
inline constexpr double kMarking = 1.9, kMixed = 1.5, kMixedMarking = 2.4;
// On UnitCosts::sweep, a lane: the first sweep over impacts; each of the others, which passes over most lanes; and
// those where bodies of several sizes fly about. `any` counts for all lanes, `free` for those between bodies on which
// nothing rests.
struct SweepCost {
  double any, free;
};
inline constexpr SweepCost kFirstSweep = {0.15, 1.6}, kNextSweep = {0.1, 0.25}, kNextMixedSweep = {0, 2};
inline constexpr double kSweepStrips = 0.7;  // on UnitCosts::strip
// On UnitCosts::sort, a body: how fast bodies move is asked of a few in a strip. On UnitCosts::select, a candidate: where
// masses differ, it is asked of what is near each.
inline constexpr double kSpeeds = 0.1, kSegmentSpeeds = 1.5;
// On UnitCosts::column: a manifold that stays in its lane. On keep: a manifold that is copied to be remembered.
inline constexpr double kInItsLane = 0.1, kRemembered = 0.6;
// On the looks at manifolds whose lists serve several frames: such manifolds last less often.
inline constexpr double kLongLooks = 1.4;
// On UnitCosts::check, a body: margins are measured against what bodies have in common.
inline constexpr double kCommonCheck = 8;
// Shares of UnitCosts::sort that the parts of sorting bodies take; more where radii differ or cells are listed.
inline constexpr double kMeasure = 0.2, kCount = 0.3, kMove = 0.5;
inline constexpr double kMixedCount = 0.6, kListedCount = 2, kMixedMove = 1;
// Shares of UnitCosts::group that the parts of taking manifolds out of the lists take.
inline constexpr double kGather = 0.25, kSortOut = 0.35, kKeep = 0.4;
// Bodies of several sizes that press each other are searched for longer in cells that are listed.
inline constexpr double kListedCrowd = 3.2;
// On UnitCosts::particle: a tile in a part of a step, and in an iteration; on all of it, if there are bodies.
inline constexpr double kTile = 380, kTilePass = 70, kAmongBodies = 1.3;
// On UnitCosts::strip: how often strips are gone through to lay contacts out.
inline constexpr double kLayOutStrips = 2;

}  // namespace cost

/// The tank of water of World::measure_costs takes this share of what these costs predict for it there.
inline constexpr double kTank = 1;
/// The same of its heaps.
struct HeapShares {
  double lists, rest, pass;
};
inline constexpr HeapShares kDiscHeap = {0.79, 1.05, 0.74}, kBoxHeap = {1.1, 0.73, 0.91};

static_assert(sizeof(UnitCosts) == CostModel::kNumbers * sizeof(double));

inline UnitCosts unit_costs(const CostModel& model) { return std::bit_cast<UnitCosts>(model.numbers()); }
inline CostModel cost_model(const UnitCosts& costs) { return CostModel(std::bit_cast<CostModel::Numbers>(costs)); }

}  // namespace psim
