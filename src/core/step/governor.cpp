#include "step/governor.h"

#include <algorithm>
#include <cmath>

namespace psim {
namespace {

// Lists for more frames are worth it if a frame then takes no more than this share of what it takes now.
constexpr double kWorthIt = 0.95;

// Bodies in a crowd have as many contacts as they have neighbours: so many pairs a body. Large ones among small ones
// have more.
constexpr double kNeighbours = 3;

WorkCounts grown(const WorkCounts& w, const Governor::Growth& by) {
  WorkCounts then = w;
  const double now = std::max(n(w.contacts), 1.0);
  const double crowd = w.has.mixed && w.sweeps > 0 ? n(w.lists.candidates) * by.candidates : kNeighbours * n(w.bodies);
  const double most = std::min(n(w.lists.candidates) * by.candidates, crowd) / now;
  const double contacts = w.lists.candidates == 0 ? 1 : std::max(std::min(by.time, most), 1.0);
  for (std::uint64_t* const count :
       {&then.lists.candidates, &then.manifolds.pairs, &then.manifolds.looks, &then.manifolds.writes}) {
    *count = static_cast<std::uint64_t>(n(*count) * by.candidates);
  }
  for (std::uint64_t* const count : {&then.contacts, &then.lanes, &then.solved}) {
    *count = static_cast<std::uint64_t>(n(*count) * contacts);
  }
  then.solved = std::min(then.solved, std::max(w.bodies, w.solved));
  then.lists.tests *= by.candidates;
  return then;
}

}  // namespace

CostModel::CostModel() : CostModel(cost_model(UnitCosts{})) {}

bool Governor::sound(const GovernorDesc& desc) {
  const CostModel::Numbers numbers = desc.costs.numbers();
  return desc.budget_ms > 0 &&
         std::all_of(numbers.begin(), numbers.end(), [](double ns) { return ns >= 0 && std::isfinite(ns); });
}

void Governor::set(const GovernorDesc& desc) {
  desc_ = desc;
  costs_ = unit_costs(desc.costs);
}

// Substeps that fit beside the rest.
int Governor::fitting(const WorkCounts& w, double ns, int most) const {
  const double each = substep_ns(costs_, w), room = ns - rest_ns(costs_, w);
  if (room < 0) return 0;
  if (!(each > 0) || room >= most * each) return most;
  return static_cast<int>(std::floor(room / each));
}

Governor::Lists Governor::lists_for(const WorkCounts& w, int most, const std::function<Growth(int)>& growth) const {
  const double room = room_ns() - costs_.step;
  const auto all = [&](const WorkCounts& then, int frames) {
    return ahead_ns(costs_, then) + rest_ns(costs_, then) + frames * substep_ns(costs_, then);
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
  if (w.sweeps <= kFewSweeps || whole.a_frame <= room_ns() - costs_.step) return whole.frames;
  const Lists cut = lists_for(with_sweeps(w, kFewSweeps), most, growth);
  return cut.a_frame < kWorthIt * whole.a_frame ? cut.frames : whole.frames;
}

Governor::Offer Governor::offer(const WorkCounts& w, double left, int elapsed, int horizon, int most) const {
  const double room = room_ns() - costs_.step;
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
