// Joints by id: the host adds, removes and reads them.
#include "joints/joint_store.h"
#include "base/sort_keys.h"

#include <algorithm>
#include <type_traits>

namespace psim {

using kernels::JointKind;
using kernels::kBlock;

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

double wide(float v) { return static_cast<double>(v); }

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
  std::uint32_t index;
  if (free_.empty()) {
    index = static_cast<std::uint32_t>(joints_.size());
    joints_.emplace_back();
  } else {
    index = free_.back();
    free_.pop_back();
  }
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
  for (Column<float>* c : {&share_vel_, &share_spin_, &push_vel_, &push_spin_}) c->release();
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
// joint's side. Its order does not depend on when the joints came, so it need not be saved.
void JointStore::tie(std::uint32_t index) {
  Joint& j = joints_[index];
  const std::uint32_t ends[2] = {j.desc.a.index, j.desc.b.index};
  const std::size_t most = std::max(ends[0], ends[1]);
  if (first_.size() <= most) first_.resize(most + 1, kNoSlot);
  for (int side = 0; side < 2; ++side) {
    std::uint32_t* link = &first_[ends[side]];
    while (*link != kNoSlot && *link > index) {
      Joint& other = joints_[*link];
      link = &other.next[other.desc.a.index == ends[side] ? 0 : 1];
    }
    j.next[side] = *link;
    *link = index;
  }
}

void JointStore::untie(std::uint32_t index) {
  const Joint& j = joints_[index];
  const std::uint32_t ends[2] = {j.desc.a.index, j.desc.b.index};
  for (int side = 0; side < 2; ++side) {
    std::uint32_t* link = &first_[ends[side]];
    while (*link != index) {
      Joint& other = joints_[*link];
      link = &other.next[other.desc.a.index == ends[side] ? 0 : 1];
    }
    *link = j.next[side];
  }
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
  const std::uint32_t k = j.lane % kBlock;
  const kernels::JointBodies& block = lists_.block(j.list, j.lane / kBlock);
  switch (j.kind) {
    case JointKind::rod:
    case JointKind::spring: {
      const auto& b = static_cast<const kernels::LineBlock&>(block);
      force = {wide(b.l[k]) * wide(b.nx[k]), wide(b.l[k]) * wide(b.ny[k])};
      break;
    }
    case JointKind::pin:
    case JointKind::driven:
    case JointKind::weld: {
      const auto& b = static_cast<const kernels::PinBlock&>(block);
      force = {wide(b.px[k]), wide(b.py[k])};
      if (j.kind == JointKind::weld) torque = wide(static_cast<const kernels::WeldBlock&>(b).l[k]);
      if (j.kind != JointKind::driven) break;
      const kernels::Drive& drive = static_cast<const kernels::DrivenBlock&>(b).drive;
      torque = wide(drive.limit_l[k]) + wide(drive.motor_l[k]);
      break;
    }
    case JointKind::slide: {
      const auto& b = static_cast<const kernels::SlideBlock&>(block);
      const double l = wide(b.l[k]), t = wide(b.drive.limit_l[k]) + wide(b.drive.motor_l[k]);
      const double ux = wide(b.ux[k]), uy = wide(b.uy[k]);
      force = {t * ux - l * uy, t * uy + l * ux};
      torque = wide(b.turn_l[k]);
    }
  }
  const double per_h = (j.swapped ? -1 : 1) / h_;
  force = {force.x * per_h, force.y * per_h};
  torque *= per_h;
}

}  // namespace psim
