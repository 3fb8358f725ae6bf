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
// Of c.narrow, a lane, once a step: where there is restitution, which contacts impacts are looked for at; where bodies
// of several sizes fly about, what lies far apart in memory. There contacts that press turn, too.
constexpr double kMarking = 0.4, kMixed = 1.5, kMixedTouch = 1.4;

double n(std::uint64_t count) { return static_cast<double>(count); }

// Bodies in a crowd have as many contacts as they have neighbours.
constexpr double kNeighbours = 3;  // pairs a body

WorkCounts grown(const WorkCounts& w, const Governor::Growth& by) {
  WorkCounts then = w;
  const double now = std::max(n(w.contacts), 1.0);
  const double most = std::min(n(w.candidates) * by.candidates, kNeighbours * n(w.bodies)) / now;
  const double contacts = w.candidates == 0 ? 1 : std::max(std::min(by.time, most), 1.0);
  for (std::uint64_t* const count : {&then.candidates, &then.manifolds, &then.looks}) {
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
         (loose ? c.select * n(w.candidates) + c.pack * (n(w.contacts) + n(w.bodies)) : 0) +
         ((w.loads ? c.load * w.visits : 0) + c.colour + lay_out(w)) * n(w.contacts) +
         (c.group + c.stand) * n(w.manifolds) + look_ns(w) + c.cell * n(w.cells) +
         kParts * c.strip * n(w.strips);
}

double Governor::lay_out(const WorkCounts& w) const {
  return w.rough || w.sweeps > 0 ? desc_.costs.lay_out_rough : desc_.costs.lay_out;
}

double Governor::look_ns(const WorkCounts& w) const {
  const std::uint64_t anew = std::min(w.looks, w.manifolds);
  return desc_.costs.look * n(anew) + desc_.costs.keep * n(w.manifolds - anew);
}

double Governor::rest_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  const double a_lane = w.mixed ? kMixed : w.sweeps > 0 ? kMarking : 0;
  return c.narrow * (n(w.contacts) + a_lane * n(w.lanes)) + (w.copies ? c.load_body * n(w.solved) : 0) +
         c.column * n(w.manifolds) + (w.sorted ? c.joint_sorted : c.joint) * n(w.joints) +
         (c.move + (w.stops ? c.stop : 0)) * n(w.bodies) + c.sleep * n(w.sleep_looks) +
         (w.stops ? c.flight * n(w.flights) : 0);
}

double Governor::substep_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  return c.body_pass * n(w.solved) + (c.pass + c.sweep * w.sweeps) * n(w.lanes) +
         c.touch * (w.mixed ? kMixedTouch : 1) * n(w.touching) + kSparse * (c.pass + c.touch) * n(w.loaded_lanes) +
         c.strip * n(w.strips) + c.shape_pass * n(w.shape_lanes) + c.joint_pass * n(w.joints);
}

// Substeps that fit beside the rest.
int Governor::fitting(const WorkCounts& w, double ns, int most) const {
  const double each = substep_ns(w), room = ns - rest_ns(w);
  if (room < 0) return 0;
  if (!(each > 0) || room >= most * each) return most;
  return static_cast<int>(std::floor(room / each));
}

int Governor::horizon(const WorkCounts& w, int most, const std::function<Growth(int)>& growth) const {
  const double room = room_ns() - desc_.costs.step;
  const auto all = [&](const WorkCounts& then, int frames) {
    return ahead_ns(then) + rest_ns(then) + frames * substep_ns(then);
  };
  double least = all(w, 1);
  if (least <= room) return 1;
  int best = 1;
  for (int frames = 2; frames <= kMostFrames; ++frames) {
    const WorkCounts then = growth ? grown(w, growth(frames)) : w;
    if (fitting(then, room, most) < frames) break;  // no substep is longer than a frame
    const double a_frame = all(then, frames) / frames;
    if (a_frame < kWorthIt * least) best = frames, least = a_frame;
    if (a_frame > room) continue;
    const WorkCounts later = growth ? grown(w, growth(frames + 1)) : w;
    const bool spare = frames < kMostFrames && fitting(later, room, most) > frames;
    return frames + (spare ? 1 : 0);  // one to spare: counts change
  }
  return best;
}

Governor::Choice Governor::choose(const WorkCounts& w, double left, int elapsed, int horizon,
                                  int most) const {
  const double room = room_ns() - desc_.costs.step;
  int here = fitting(w, left, most);
  if (left >= room) here = std::max(here, 1);
  const int next = std::max(fitting(w, room, most), 1);
  Choice choice;
  choice.substeps = here;
  choice.frames = std::max(std::min({here, elapsed, horizon}), 1);
  const int later = std::min({next, elapsed + 1, horizon});
  choice.solves = here >= 1 && choice.frames * (elapsed + 1) >= later * elapsed;
  return choice;
}

}  // namespace psim
