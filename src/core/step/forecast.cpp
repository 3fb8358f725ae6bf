#include "step/forecast.h"

#include <algorithm>

#include "step/step_table.h"

namespace psim {
namespace {

// Factors on UnitCosts::touch, a contact that presses: where bodies of several sizes turn, where they bounce, both.
constexpr double kMixedTouch = 1.4, kBouncing = 4, kMixedBouncing = 5;
// On UnitCosts::lay_out and select, where bodies of several sizes bounce: for all contacts that press.
constexpr double kMixedPressing = 1, kMixedSelect = 2;
// On UnitCosts::lay_out, where some contacts may be under heavy loads; on a lane under one, of which a strip has few.
constexpr double kLoads = 1.4, kSparse = 1.7;
// On UnitCosts::narrow, a lane, once a step. With restitution: which contacts impacts are looked for at. Where bodies
// of several sizes fly about: what lies far apart in memory. Both.
constexpr double kMarking = 1.9, kMixed = 1.5, kMixedMarking = 2.4;
// On UnitCosts::sweep, a lane: the first sweep over impacts; each of the others, which passes over most lanes; and
// those where bodies of several sizes fly about. `any` counts for all lanes, `free` for those between bodies on which
// nothing rests.
struct SweepCost {
  double any, free;
};
constexpr SweepCost kFirstSweep = {0.15, 1.6}, kNextSweep = {0.1, 0.25}, kNextMixedSweep = {0, 2};
constexpr double kSweepStrips = 0.7;  // on UnitCosts::strip
// On UnitCosts::sort, a body: how fast bodies move is asked of a few in a strip, of all where masses differ.
constexpr double kSpeeds = 0.1, kUnevenSpeeds = 0.36;
// On UnitCosts::column: a manifold that stays in its lane. On keep: a manifold that is copied to be remembered.
constexpr double kInItsLane = 0.1, kRemembered = 0.6;
// On the looks at manifolds whose lists serve several frames: such manifolds last less often.
constexpr double kLongLooks = 1.4;

}  // namespace

double crowded(const WorkCounts& w) {
  return w.has.mixed && w.sweeps > 0 ? std::min(n(w.touching) / std::max(n(w.contacts), 1.0), 1.0) : 0;
}

double select_ns(const UnitCosts& c, const WorkCounts& w) { return c.select * (1 + kMixedSelect * crowded(w)); }

double lay_out_ns(const UnitCosts& c, const WorkCounts& w) {
  return (w.has.rough || w.sweeps > 0 ? c.lay_out_rough : c.lay_out) * (1 + kMixedPressing * crowded(w)) *
         (w.has.loads ? kLoads : 1);
}

double speeds_ns(const UnitCosts& c, const WorkCounts& w) {
  return (w.has.uneven ? kUnevenSpeeds : kSpeeds) * c.sort * n(w.bodies);
}

double look_ns(const UnitCosts& c, const WorkCounts& w) {
  const std::uint64_t anew = std::min(w.manifolds.looks, w.manifolds.pairs);
  return (w.has.long_lists ? kLongLooks : 1.0) * (c.look * n(anew) + c.keep * n(w.manifolds.pairs - anew));
}

double remember_ns(const UnitCosts& c, const WorkCounts& w) { return kRemembered * c.keep * n(w.manifolds.pairs); }

double ahead_ns(const UnitCosts& c, const WorkCounts& w) {
  double sum = 0;
  for (const StepPart& part : step_parts()) sum += part.whole_ns(c, w);
  return sum;
}

double in_place_ns(const UnitCosts& c, const WorkCounts& w) {
  double sum = 0;
  for (const StepPart& part : step_parts()) {
    if (part.in_place) sum += part.whole_ns(c, w);
  }
  return sum;
}

double rest_ns(const UnitCosts& c, const WorkCounts& w) {
  const bool bounces = w.sweeps > 0;
  const double a_lane = bounces ? (w.has.mixed ? kMixedMarking : kMarking) : w.has.mixed ? kMixed : 0;
  return c.narrow * (n(w.contacts) + a_lane * n(w.lanes)) + (w.has.copies ? c.load_body * n(w.solved) : 0) +
         c.column * (n(w.manifolds.writes) + kInItsLane * n(w.manifolds.pairs)) +
         (w.has.sorted ? c.joint_sorted : c.joint) * n(w.joints) + (c.move + (w.has.stops ? c.stop : 0)) * n(w.bodies) +
         c.sleep * n(w.sleep_looks) + (w.has.stops ? c.flight * n(w.flights) : 0);
}

double substep_ns(const UnitCosts& c, const WorkCounts& w) {
  const double free = std::max(0.0, 1 - 2 * n(w.touching) / std::max(n(w.lanes), 1.0));
  const auto cost = [&](const SweepCost& of) { return of.any + of.free * free; };
  const double pressing = w.sweeps > 0 ? (w.has.mixed ? kMixedBouncing : kBouncing) : w.has.mixed ? kMixedTouch : 1;
  const double sweeps =
      w.sweeps > 0 ? cost(kFirstSweep) + cost(w.has.mixed ? kNextMixedSweep : kNextSweep) * (w.sweeps - 1) : 0;
  return c.body_pass * n(w.solved) + (c.pass + c.sweep * sweeps) * n(w.lanes) +
         kSweepStrips * c.strip * n(w.lists.strips) * w.sweeps + c.touch * pressing * n(w.touching) +
         kSparse * (c.pass + c.touch) * n(w.loaded_lanes) + c.strip * n(w.lists.strips) +
         c.shape_pass * n(w.manifolds.lanes) + c.joint_pass * n(w.joints);
}

}  // namespace psim
