#include "governor.h"

#include <algorithm>
#include <cmath>

namespace psim {
namespace {

double n(std::uint64_t count) { return static_cast<double>(count); }

}  // namespace

double Governor::lists_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  return c.step + c.check * n(w.bodies) + (w.builds ? c.build * n(w.bodies) : 0);
}

double Governor::contacts_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  return c.select * n(w.candidates) + (w.lays_out ? c.colour * n(w.contacts) : 0);
}

double Governor::geometry_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  return c.narrow * n(w.contacts) + c.look * n(w.manifolds);
}

double Governor::fixed_ns(const WorkCounts& w) const {
  return lists_ns(w) + contacts_ns(w) + geometry_ns(w);
}

double Governor::substep_ns(const WorkCounts& w) const {
  const CostModel& c = desc_.costs;
  return c.body_pass * n(w.solved) + (w.bounces ? c.bounce_pass : c.pass) * n(w.contacts) +
         c.shape_pass * n(w.manifolds) + c.joint_pass * n(w.joints);
}

// Of a step spread over k frames, k substeps at least.
Governor::Spread Governor::spread(const WorkCounts& w) const {
  using D = StepDetail;
  const double lists = lists_ns(w), contacts = contacts_ns(w), room = room_ns();
  const auto solve = [&](int substeps) { return geometry_ns(w) + substeps * substep_ns(w); };
  if (lists + contacts + solve(1) <= room) return {};
  const double early = std::max(lists, contacts + solve(2)), late = std::max(lists + contacts, solve(2));
  if (std::min(early, late) <= room) {
    if (early <= late) return {2, {D::kLists, D::kContacts | D::kSolve, 0}};
    return {2, {D::kLists | D::kContacts, D::kSolve, 0}};
  }
  return {3, {D::kLists, D::kContacts, D::kSolve}};
}

int Governor::substeps(const WorkCounts& w, int least, int most) const {
  const double each = substep_ns(w), room = room_ns() - fixed_ns(w);
  if (!(each > 0) || room >= most * each) return most;
  return std::clamp(static_cast<int>(std::floor(room / each)), least, most);
}

}  // namespace psim
