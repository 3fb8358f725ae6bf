#include "governor.h"

#include <algorithm>
#include <cmath>

namespace psim {
namespace {

// Of the work ahead, that go through strips.
constexpr double kParts = 5;
// Contacts under heavy loads are few a strip.
constexpr double kSparse = 1.7;

double n(std::uint64_t count) { return static_cast<double>(count); }

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
  return c.narrow * n(w.contacts) + (w.copies ? c.load_body * n(w.solved) : 0) +
         c.column * n(w.manifolds) + (w.sorted ? c.joint_sorted : c.joint) * n(w.joints) +
         (c.move + (w.stops ? c.stop : 0)) * n(w.bodies) + c.sleep * n(w.sleep_looks) +
         (w.stops ? c.flight * n(w.flights) : 0);
}

double Governor::substep_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  return c.body_pass * n(w.solved) + (c.pass + c.sweep * w.sweeps) * n(w.lanes) +
         c.touch * n(w.touching) + kSparse * (c.pass + c.touch) * n(w.loaded_lanes) +
         c.strip * n(w.strips) + c.shape_pass * n(w.shape_lanes) + c.joint_pass * n(w.joints);
}

// Substeps that fit beside the rest.
int Governor::fitting(const WorkCounts& w, double ns, int most) const {
  const double each = substep_ns(w), room = ns - rest_ns(w);
  if (room < 0) return 0;
  if (!(each > 0) || room >= most * each) return most;
  return static_cast<int>(std::floor(room / each));
}

int Governor::horizon(const WorkCounts& w, int most) const {
  const double room = room_ns() - desc_.costs.step;
  const double all = ahead_ns(w) + rest_ns(w), each = substep_ns(w);
  if (all + each <= room) return 1;
  const int most_frames = std::min(std::max(fitting(w, room, most), 1), kMostFrames);
  int frames = 2;
  while (frames < most_frames && all + frames * each > frames * room) ++frames;
  return std::min(frames + 1, most_frames);  // one to spare: counts change
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
