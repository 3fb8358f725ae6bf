// Joints: what the host asked for, and the blocks with what they did in the last substep. Which joint lies in which
// lane, and who is joined to whom, follows from that.
#include "joints/joint_store.h"
#include "state/describe.h"

namespace psim {

template <class A>
void JointStore::describe(A& a, const BodyStore& bodies) {
  if constexpr (!A::kLoading) save_impulses();
  a.list(joints_, [&](Joint& j) {
    visit(a, j.desc);
    numbers(a, j.generation, j.alive, j.dormant, j.kind);
    for (float& l : j.impulse) a.value(l);
  });
  describe_free(a, free_, 0, joints_.size(), [&](std::size_t k) { return !joints_[k].alive; });
  bool laid = !stale_;
  numbers(a, laid, h_);
  if constexpr (A::kLoading) {
    for (const Joint& j : joints_) check_joint(a, j, bodies);
    if (!a.ok()) joints_.clear(), free_.clear();
    tie_all(bodies);
    stale_ = bodies_stale_ = true;
    if (laid && a.ok()) {
      bodies_stale_ = true;
      lay_out(bodies);
      stale_ = false;
    }
  }
  for (std::uint32_t k = 0; k < kLists && laid; ++k) {
    JointLists::visit(lists_, k, [&](auto& blocks) {
      const std::size_t n = blocks.size();
      a.plain(blocks);
      if constexpr (A::kLoading) {
        a.require(blocks.size() == n);
        blocks.resize(n);
      }
    });
  }
}

template <class A>
void JointStore::check_joint(A& a, const Joint& j, const BodyStore& b) const {
  if (!j.alive) return;
  const BodyId ends[2] = {j.desc.a, j.desc.b};
  a.require(ends[0].index != ends[1].index && j.desc.length && j.desc.reference);
  bool dynamic = false;
  for (const BodyId& end : ends) {
    a.require(end.index < b.id_count && b.info[end.index].generation == end.generation);
    if (!a.ok()) return;
    const Place place = b.info[end.index].place;
    a.require(place == Place::moving || place == Place::asleep || place == Place::fixed);
    dynamic = dynamic || b.properties(end.index).inv_mass > 0;
  }
  a.require(dynamic);
}

// What follows from the joints.
void JointStore::tie_all(const BodyStore& b) {
  count_ = 0;
  first_.clear();
  exclusions_.clear();
  exclusive_.clear();
  for (auto& lanes : lanes_) lanes.clear();
  for (std::uint32_t k = 0; k < joints_.size(); ++k) {
    Joint& j = joints_[k];
    j.lane = kNoSlot;
    if (!j.alive) continue;
    ++count_;
    j.swapped = !(b.properties(j.desc.b.index).inv_mass > 0);
    j.list = JointLists::list_of(j.kind, j.swapped || !(b.properties(j.desc.a.index).inv_mass > 0));
    tie(k);
    exclude(j.desc, +1);
  }
}

PSIM_DESCRIBED(JointStore, const BodyStore&);

}  // namespace psim
