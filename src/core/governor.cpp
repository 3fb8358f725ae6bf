#include "governor.h"

#include <algorithm>
#include <cmath>

namespace psim {
namespace {

// Longer lists of a step that takes longer than they last must save so much a frame.
constexpr double kWorthIt = 0.95;
// Of the work ahead, that go through strips.
constexpr double kParts = 5;
// Contacts under heavy loads are few a strip.
constexpr double kSparse = 1.7;
// Of c.narrow, a lane, once a step: with restitution, which contacts impacts are looked for at; where bodies of several
// sizes fly about, what lies far apart in memory; both.
constexpr double kMarking = 1.9, kMixed = 1.5, kMixedMarking = 2.4;
// Of c.touch: contacts that press turn where sizes are mixed, and bounce with restitution; of c.lay_out and of
// c.select, where both.
constexpr double kMixedTouch = 1.4, kBouncing = 4, kMixedBouncing = 5, kMixedPressing = 1, kMixedSelect = 2;
// Of c.lay_out, where some of the contacts may be under heavy loads.
constexpr double kLoads = 1.4;
// Of c.sweep, a lane: the first sweep over impacts, each of the others, which passes over most, and those where bodies
// of several sizes fly about; what is alike for all, and what goes for those between bodies on which nothing rests.
struct SweepCost {
  double any, free;
};
constexpr SweepCost kFirstSweep = {0.15, 1.6}, kNextSweep = {0.1, 0.25}, kNextMixedSweep = {0, 2};
constexpr double kSweepStrips = 0.7;  // of c.strip

// Of c.sort, a body: how fast bodies move is asked of a few in a strip, of all where masses differ.
constexpr double kSpeeds = 0.1, kUnevenSpeeds = 0.36;

// Of c.column: of a manifold that stays in its lane.
constexpr double kSoftening = 0.1;

double n(std::uint64_t count) { return static_cast<double>(count); }

// Bodies in a crowd have as many contacts as they have neighbours; large ones among small ones have many.
constexpr double kNeighbours = 3;  // pairs a body

WorkCounts grown(const WorkCounts& w, const Governor::Growth& by) {
  WorkCounts then = w;
  const double now = std::max(n(w.contacts), 1.0);
  const double crowd = w.mixed && w.sweeps > 0 ? n(w.candidates) * by.candidates : kNeighbours * n(w.bodies);
  const double most = std::min(n(w.candidates) * by.candidates, crowd) / now;
  const double contacts = w.candidates == 0 ? 1 : std::max(std::min(by.time, most), 1.0);
  for (std::uint64_t* const count : {&then.candidates, &then.manifolds, &then.looks, &then.writes}) {
    *count = static_cast<std::uint64_t>(n(*count) * by.candidates);
  }
  for (std::uint64_t* const count : {&then.contacts, &then.lanes, &then.solved}) {
    *count = static_cast<std::uint64_t>(n(*count) * contacts);
  }
  then.solved = std::min(then.solved, std::max(w.bodies, w.solved));
  then.tests *= by.candidates;
  return then;
}

}  // namespace

double Governor::ahead_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  const bool loose = w.candidates != 0;
  const double found = n(loose ? w.candidates : w.contacts + w.manifolds);
  return (c.check + c.sort + c.search + (w.fixed ? c.near_fixed : c.near)) * n(w.bodies) +
         c.pair * found + c.test * w.tests + (w.fixed ? c.near_shape * n(w.near) : 0) +
         (loose ? speeds_ns(w) + select(w) * n(w.candidates) + c.pack * (n(w.contacts) + n(w.bodies)) : 0) +
         ((w.loads ? c.load * w.visits : 0) + c.colour + lay_out(w)) * n(w.contacts) +
         (c.group + c.stand) * n(w.manifolds) + look_ns(w) + c.cell * n(w.cells) +
         kParts * c.strip * n(w.strips);
}

double Governor::crowded(const WorkCounts& w) {
  return w.mixed && w.sweeps > 0 ? std::min(n(w.touching) / std::max(n(w.contacts), 1.0), 1.0) : 0;
}

double Governor::select(const WorkCounts& w) const { return desc_.costs.select * (1 + kMixedSelect * crowded(w)); }

double Governor::lay_out(const WorkCounts& w) const {
  return (w.rough || w.sweeps > 0 ? desc_.costs.lay_out_rough : desc_.costs.lay_out) * (1 + kMixedPressing * crowded(w)) *
         (w.loads ? kLoads : 1);
}

double Governor::speeds_ns(const WorkCounts& w) const {
  return (w.uneven ? kUnevenSpeeds : kSpeeds) * desc_.costs.sort * n(w.bodies);
}

double Governor::look_ns(const WorkCounts& w) const {
  const std::uint64_t anew = std::min(w.looks, w.manifolds);
  return desc_.costs.look * n(anew) + desc_.costs.keep * n(w.manifolds - anew);
}

double Governor::rest_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  const bool bounces = w.sweeps > 0;
  const double a_lane = bounces ? (w.mixed ? kMixedMarking : kMarking) : w.mixed ? kMixed : 0;
  return c.narrow * (n(w.contacts) + a_lane * n(w.lanes)) + (w.copies ? c.load_body * n(w.solved) : 0) +
         c.column * (n(w.writes) + kSoftening * n(w.manifolds)) + (w.sorted ? c.joint_sorted : c.joint) * n(w.joints) +
         (c.move + (w.stops ? c.stop : 0)) * n(w.bodies) + c.sleep * n(w.sleep_looks) +
         (w.stops ? c.flight * n(w.flights) : 0);
}

double Governor::substep_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  const double free = std::max(0.0, 1 - 2 * n(w.touching) / std::max(n(w.lanes), 1.0));
  const auto cost = [&](const SweepCost& of) { return of.any + of.free * free; };
  const double pressing = w.sweeps > 0 ? (w.mixed ? kMixedBouncing : kBouncing) : w.mixed ? kMixedTouch : 1;
  const double sweeps =
      w.sweeps > 0 ? cost(kFirstSweep) + cost(w.mixed ? kNextMixedSweep : kNextSweep) * (w.sweeps - 1) : 0;
  return c.body_pass * n(w.solved) + (c.pass + c.sweep * sweeps) * n(w.lanes) +
         kSweepStrips * c.strip * n(w.strips) * w.sweeps +
         c.touch * pressing * n(w.touching) + kSparse * (c.pass + c.touch) * n(w.loaded_lanes) +
         c.strip * n(w.strips) + c.shape_pass * n(w.shape_lanes) + c.joint_pass * n(w.joints);
}

// Substeps that fit beside the rest.
int Governor::fitting(const WorkCounts& w, double ns, int most) const {
  const double each = substep_ns(w), room = ns - rest_ns(w);
  if (room < 0) return 0;
  if (!(each > 0) || room >= most * each) return most;
  return static_cast<int>(std::floor(room / each));
}

Governor::Lists Governor::lists_for(const WorkCounts& w, int most, const std::function<Growth(int)>& growth) const {
  const double room = room_ns() - desc_.costs.step;
  const auto all = [&](const WorkCounts& then, int frames) {
    return ahead_ns(then) + rest_ns(then) + frames * substep_ns(then);
  };
  Lists best{1, all(w, 1)};
  if (best.a_frame <= room) return best;
  for (int frames = 2; frames <= kMostFrames; ++frames) {
    const WorkCounts then = growth ? grown(w, growth(frames)) : w;
    if (fitting(then, room, most) < frames) break;  // no substep is longer than a frame
    const double a_frame = all(then, frames) / frames;
    if (a_frame < kWorthIt * best.a_frame) best = {frames, a_frame};
    if (a_frame > room) continue;
    const WorkCounts later = growth ? grown(w, growth(frames + 1)) : w;
    const bool spare = frames < kMostFrames && fitting(later, room, most) > frames;
    return {frames + (spare ? 1 : 0), a_frame};  // one to spare: counts change
  }
  return best;
}

int Governor::horizon(const WorkCounts& w, int most, const std::function<Growth(int)>& growth) const {
  const Lists whole = lists_for(w, most, growth);
  if (w.sweeps <= kFewSweeps || whole.a_frame <= room_ns() - desc_.costs.step) return whole.frames;
  const Lists cut = lists_for(with_sweeps(w, kFewSweeps), most, growth);
  return cut.a_frame < kWorthIt * whole.a_frame ? cut.frames : whole.frames;
}

Governor::Offer Governor::offer(const WorkCounts& w, double left, int elapsed, int horizon, int most) const {
  const double room = room_ns() - desc_.costs.step;
  const int fits = fitting(w, left, most), next = fitting(w, room, most);
  const int here = left >= room ? std::max(fits, 1) : fits;
  Offer of;
  of.choice.substeps = here;
  of.choice.frames = std::max(std::min({here, elapsed, horizon}), 1);
  const int later = std::min({std::max(next, 1), elapsed + 1, horizon});
  of.choice.solves = here >= 1 && of.choice.frames * (elapsed + 1) >= later * elapsed;
  if (of.choice.solves) {
    of.pace = fits == 0 ? 0.0 : 1.0 * of.choice.frames / elapsed;
  } else {
    of.pace = next == 0 ? 0.0 : 1.0 * later / (elapsed + 1);
  }
  return of;
}

Governor::Choice Governor::choose(const WorkCounts& w, double left, int elapsed, int horizon, int most) const {
  const Offer whole = offer(w, left, elapsed, horizon, most);
  if (w.sweeps <= kFewSweeps) return whole.choice;
  Offer cut = offer(with_sweeps(w, kFewSweeps), left, elapsed, horizon, most);
  if (whole.pace > 0 && cut.pace <= whole.pace) return whole.choice;
  cut.choice.sweeps = kFewSweeps;
  return cut.choice;
}

}  // namespace psim
