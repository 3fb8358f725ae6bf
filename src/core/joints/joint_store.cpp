// Joints by id: the host adds, removes and reads them.
#include "joints/joint_store.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/room.h"
#include "base/sort_keys.h"

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

// Room for the links of the bodies of a joint.
void JointStore::link_room(const JointDesc& d) {
  const std::size_t most = std::max(d.a.index, d.b.index);
  if (first_.size() <= most) first_.resize(most + 1, kNoSlot);
}

// Which sides of a joint move, and whether any does.
void JointStore::find_sides(Joint& j) const {
  const auto dynamic = [&](BodyId id) { return s_.bodies.inv_mass_in_joints(id.index) > 0; };
  const auto rests = [&](BodyId id) {
    const Place place = s_.bodies.info[id.index].place;
    return place == Place::asleep || place == Place::disabled;
  };
  j.swapped = !dynamic(j.desc.b);
  j.held = j.swapped || !dynamic(j.desc.a);
  j.dormant = rests(j.desc.a) || rests(j.desc.b) || (j.swapped && !dynamic(j.desc.a));
}

// A joint begins to count. This finds out what follows from its description and its bodies.
void JointStore::enter(std::uint32_t index) {
  Joint& j = joints_[index];
  find_sides(j);
  j.lane = j.articulated = kNoSlot;
  link_room(j.desc);
  for (const BodyId body : {j.desc.a, j.desc.b}) link(index, body.index);
  if (!j.desc.collide) ++exclusions_;
  ++count_;
  stale_ = true;
}

JointId JointStore::add(const JointDesc& d) {
  link_room(d);
  if (free_.empty()) {
    joints_.reserve(roomier(joints_));
    free_.reserve(std::max(free_.capacity(), joints_.capacity()));  // to take joints out needs no memory
    free_.push_back(static_cast<std::uint32_t>(joints_.size()));
    joints_.emplace_back();
  }
  const std::uint32_t index = free_.back();
  free_.pop_back();
  const std::uint32_t generation = joints_[index].generation;
  joints_[index] = {.desc = d, .generation = generation, .alive = true, .kind = kind_of(d)};
  enter(index);
  return {index, generation};
}

void JointStore::leave_lane(Joint& j) {
  if (j.lane != kNoSlot) lanes_[j.list()][j.lane] = kNoSlot;
  j.lane = j.articulated = kNoSlot;
  stale_ = true;
}

bool JointStore::remove(JointId id) {
  if (!is_valid(id)) return false;
  Joint& j = joints_[id.index];
  for (const BodyId body : {j.desc.a, j.desc.b}) unlink(id.index, body.index);
  leave_lane(j);
  if (!j.desc.collide) --exclusions_;
  --count_;
  j.alive = false;
  if (++j.generation != kLastGeneration) free_.push_back(id.index);
  return true;
}

std::size_t JointStore::bytes() const {
  std::size_t sum = bytes_of(joints_, free_, first_, bodies_, members_, jobs_.ranges, jobs_.jobs, phases_,
                             shares_.ranges, shares_.jobs, marks_, swept_, tethers_, tether_ranges_) +
                    lists_.bytes() + articulations_.bytes();
  for (std::uint32_t list = 0; list < kLists; ++list) sum += bytes_of(lanes_[list], ends_[list]);
  return sum;
}

void JointStore::release_blocks() {
  give_back(first_, bodies_, members_, lists_, lanes_, ends_, jobs_, phases_, shares_, marks_, share_vel_,
            share_rim_speed_, push_vel_, push_rim_speed_, push0_vel_, push0_rim_speed_);
  give_back(swept_, tethers_, tether_ranges_);
  articulations_.release();
  stale_ = true;
}

void JointStore::remove_of_body(std::uint32_t body) {
  while (body < first_.size() && first_[body] != kNoSlot) {
    const std::uint32_t index = first_[body];
    remove({index, joints_[index].generation});
  }
}

// The joints of a body form a linked list, the latest number first: it begins in first_ and goes on in `next` of the
// joint's side. Its order does not depend on when the joints came, so it need not be saved. A new number comes first, in
// O(1); one that is used again goes past those above it.
void JointStore::link(std::uint32_t index, std::uint32_t body) {
  std::uint32_t before = kNoSlot, next = first_[body];
  while (next != kNoSlot && next > index) before = std::exchange(next, joints_[next].next_of(body));
  joints_[index].before_of(body) = before;
  joints_[index].next_of(body) = next;
  (before == kNoSlot ? first_[body] : joints_[before].next_of(body)) = index;
  if (next != kNoSlot) joints_[next].before_of(body) = index;
}

void JointStore::unlink(std::uint32_t index, std::uint32_t body) {
  const std::uint32_t before = joints_[index].before_of(body), next = joints_[index].next_of(body);
  (before == kNoSlot ? first_[body] : joints_[before].next_of(body)) = next;
  if (next != kNoSlot) joints_[next].before_of(body) = before;
}

void JointStore::set_motor(JointId id, double speed, double limit) {
  Joint& j = joints_[id.index];
  j.desc.motor_speed = speed;
  j.desc.motor_limit = limit;
  if (j.kind == JointKind::pin && limit > 0) {  // it moves to the blocks with a motor
    save_impulse(j);
    leave_lane(j);
    j.kind = JointKind::driven;
  }
}

void JointStore::follow(std::uint32_t body) {
  for (std::uint32_t i = first_of(body); i != kNoSlot; i = joints_[i].next_of(body)) {
    Joint& j = joints_[i];
    const auto sides = [&] { return std::tuple(j.dormant, j.swapped, j.held); };
    const auto [slept, swapped, held] = sides();
    const std::uint32_t list = j.list();
    find_sides(j);
    stale_ = stale_ || slept != j.dormant;
    if (swapped == j.swapped && held == j.held) continue;
    // It goes into another list, without its impulses, which are those of other sides.
    if (j.lane != kNoSlot) lanes_[list][j.lane] = kNoSlot;
    j.lane = j.articulated = kNoSlot;
    std::ranges::fill(j.impulse, 0.0f);
    stale_ = true;
  }
}

const std::vector<std::uint32_t>& JointStore::bodies() {
  if (!stale_) return bodies_;
  bodies_.clear();
  for (const Joint& j : joints_) {
    if (j.alive && !j.dormant) bodies_.insert(bodies_.end(), {j.desc.a.index, j.desc.b.index});
  }
  sort_keys(bodies_.begin(), bodies_.end());
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
  return bodies_;
}

void JointStore::load_of(JointId id, Vec2 line, Vec2 axis, Vec2& force, double& torque) const {
  const Joint& j = joints_[id.index];
  force = {};
  torque = 0;
  if (!(h_ > 0)) return;
  const double sign = j.swapped ? -1 : 1, per_h = sign / h_;
  if (j.articulated != kNoSlot) {
    double l[JointLists::kImpulses];
    std::copy(std::begin(j.impulse), std::end(j.impulse), l);
    if (j.kind == JointKind::rod || j.kind == JointKind::spring) {
      const double far = length_of(line);
      force = (far > 0 ? sign * l[0] / far : 0) * line;
    } else if (j.kind == JointKind::slide) {
      const Vec2 u = (sign / length_of(axis)) * axis;
      force = (l[2] + l[3]) * u + l[0] * Vec2{-u.y, u.x};
      torque = l[1];
    } else {
      force = {l[0], l[1]};
      torque = l[2] + l[3];
    }
  }
  const auto of_lane = [&](const auto& b, std::uint32_t k) {
    double l[JointLists::kImpulses] = {};
    JointLists::each_impulse(b, k, [&](int i, float impulse) { l[i] = impulse; });
    const auto along = [](float x, float y, double f) { return f * Vec2{x, y}; };
    if constexpr (requires { b.nx; }) {
      force = along(b.nx[k], b.ny[k], l[0]);
    } else if constexpr (requires { b.ux; }) {
      force = along(b.ux[k], b.uy[k], l[2] + l[3]) + along(-b.uy[k], b.ux[k], l[0]);
      torque = l[1];
    } else {
      force = {l[0], l[1]};
      torque = l[2] + l[3];
    }
  };
  if (j.lane != kNoSlot) {
    JointLists::visit_lane(lists_, j.list(), j.lane, of_lane);
    force = force + tethered_load(id.index);
  }
  force = per_h * force;
  torque *= per_h;
}

}  // namespace psim
