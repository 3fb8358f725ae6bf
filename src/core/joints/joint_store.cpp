// Joints by id: the host adds, removes and reads them.
#include "joints/joint_store.h"
#include "base/sort_keys.h"

#include <algorithm>
#include <type_traits>

namespace psim {

using kernels::JointKind;

namespace {

JointKind kind_of(const JointDesc& d) {
  switch (d.type) {
    case JointType::distance:
    case JointType::rope:
      return JointKind::rod;
    case JointType::spring:
      return JointKind::spring;
    case JointType::revolute:
      return d.lower || d.upper || d.motor_limit > 0 ? JointKind::driven : JointKind::pin;
    case JointType::prismatic:
      return JointKind::slide;
    case JointType::weld:
      break;
  }
  return JointKind::weld;
}

}  // namespace

void JointStore::exclude(const JointDesc& d, int sign) {
  if (d.collide) return;
  const std::uint32_t most = std::max(d.a.index, d.b.index);
  if (exclusive_.size() <= most) exclusive_.resize(std::size_t{most} + 1);
  const std::uint64_t key = pair_key(d.a.index, d.b.index);
  if (sign > 0) {
    ++exclusions_[key];
    ++exclusive_[d.a.index];
    ++exclusive_[d.b.index];
    return;
  }
  const auto found = exclusions_.find(key);
  if (--found->second == 0) exclusions_.erase(found);
  --exclusive_[d.a.index];
  --exclusive_[d.b.index];
}

JointId JointStore::add(const JointDesc& d, const BodyStore& bodies) {
  if (free_.empty()) {
    free_.push_back(static_cast<std::uint32_t>(joints_.size()));
    joints_.emplace_back();
  }
  const std::uint32_t index = free_.back();
  free_.pop_back();
  Joint& j = joints_[index];
  const std::uint32_t generation = j.generation;
  j = Joint{};
  j.generation = generation;
  j.desc = d;
  j.alive = true;
  const auto dynamic = [&](BodyId id) { return bodies.properties(id.index).inv_mass > 0; };
  j.swapped = !dynamic(d.b);
  const bool held = j.swapped || !dynamic(d.a);
  j.kind = kind_of(d);
  j.list = JointLists::list_of(j.kind, held);
  j.lane = kNoSlot;
  tie(index);
  exclude(d, +1);
  ++count_;
  stale_ = bodies_stale_ = true;
  return {index, generation};
}

bool JointStore::remove(JointId id) {
  if (!is_valid(id)) return false;
  Joint& j = joints_[id.index];
  exclude(j.desc, -1);
  untie(id.index);
  if (j.lane != kNoSlot) lanes_[j.list][j.lane] = kNoSlot;
  j.alive = false;
  ++j.generation;
  free_.push_back(id.index);
  --count_;
  stale_ = bodies_stale_ = true;
  return true;
}

void JointStore::release_blocks() {
  const auto drop = [](auto&... lists) { (std::remove_reference_t<decltype(lists)>().swap(lists), ...); };
  drop(first_, exclusive_, bodies_, members_, ranges_, share_ranges_, jobs_, share_jobs_, phases_, marks_);
  for (auto& lanes : lanes_) drop(lanes);
  lists_ = JointLists();
  for (Column<float>* c : {&share_vel_, &share_rim_speed_, &push_vel_, &push_rim_speed_}) c->release();
  total_blocks_ = 0;
  stale_ = bodies_stale_ = true;
}

void JointStore::remove_of_body(std::uint32_t body) {
  while (body < first_.size() && first_[body] != kNoSlot) {
    const std::uint32_t index = first_[body];
    remove({index, joints_[index].generation});
  }
}

// The joints of a body form a linked list, the latest number first: it begins in first_ and goes on in `next` of the
// joint's side. Its order does not depend on when the joints came, so it need not be saved. This finds the link where
// joint `index` is, or belongs.
std::uint32_t* JointStore::link_to(std::uint32_t index, std::uint32_t body) {
  std::uint32_t* link = &first_[body];
  while (*link != kNoSlot && *link > index) {
    Joint& other = joints_[*link];
    link = &other.next[other.desc.a.index == body ? 0 : 1];
  }
  return link;
}

void JointStore::tie(std::uint32_t index) {
  Joint& j = joints_[index];
  const std::uint32_t ends[2] = {j.desc.a.index, j.desc.b.index};
  const std::size_t most = std::max(ends[0], ends[1]);
  if (first_.size() <= most) first_.resize(most + 1, kNoSlot);
  for (int side = 0; side < 2; ++side) {
    std::uint32_t* const link = link_to(index, ends[side]);
    j.next[side] = *link;
    *link = index;
  }
}

void JointStore::untie(std::uint32_t index) {
  const Joint& j = joints_[index];
  *link_to(index, j.desc.a.index) = j.next[0];
  *link_to(index, j.desc.b.index) = j.next[1];
}

bool JointStore::set_motor(JointId id, double speed, double limit) {
  if (!is_valid(id)) return false;
  Joint& j = joints_[id.index];
  if (j.desc.type != JointType::revolute && j.desc.type != JointType::prismatic) return false;
  j.desc.motor_speed = speed;
  j.desc.motor_limit = limit;
  if (j.kind == JointKind::pin && limit > 0) {  // it moves to the blocks with a motor
    save_impulses();
    if (j.lane != kNoSlot) lanes_[j.list][j.lane] = kNoSlot;
    j.lane = kNoSlot;
    j.kind = JointKind::driven;
    j.list = JointLists::list_of(j.kind, (j.list & 1u) != 0);
    stale_ = true;
  }
  return true;
}

void JointStore::follow_sleep(const BodyStore& b) {
  for (Joint& j : joints_) {
    if (!j.alive) continue;
    const bool dormant = b.info[j.desc.a.index].place == Place::asleep || b.info[j.desc.b.index].place == Place::asleep;
    stale_ = stale_ || dormant != j.dormant;
    j.dormant = dormant;
  }
  bodies_stale_ = bodies_stale_ || stale_;
}

const std::vector<std::uint32_t>& JointStore::bodies() {
  if (!bodies_stale_) return bodies_;
  bodies_stale_ = false;
  bodies_.clear();
  for (const Joint& j : joints_) {
    if (!j.alive || j.dormant) continue;
    bodies_.push_back(j.desc.a.index);
    bodies_.push_back(j.desc.b.index);
  }
  sort_keys(bodies_.begin(), bodies_.end());
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
  return bodies_;
}

void JointStore::load_of(JointId id, Vec2& force, double& torque) const {
  const Joint& j = joints_[id.index];
  force = {};
  torque = 0;
  if (j.lane == kNoSlot || !(h_ > 0)) return;
  JointLists::visit_lane(lists_, j.list, j.lane, [&](const auto& b, std::uint32_t k) {
    double l[JointLists::kImpulses] = {};
    JointLists::each_impulse(b, k, [&](int i, float impulse) { l[i] = static_cast<double>(impulse); });
    const auto along = [&](float x, float y, double f) {
      return f * Vec2{static_cast<double>(x), static_cast<double>(y)};
    };
    if constexpr (requires { b.nx; }) {
      force = along(b.nx[k], b.ny[k], l[0]);
    } else if constexpr (requires { b.ux; }) {
      force = along(b.ux[k], b.uy[k], l[2] + l[3]) + along(-b.uy[k], b.ux[k], l[0]);
      torque = l[1];
    } else {
      force = {l[0], l[1]};
      torque = l[2] + l[3];
    }
  });
  const double per_h = (j.swapped ? -1 : 1) / h_;
  force = per_h * force;
  torque *= per_h;
}

}  // namespace psim
