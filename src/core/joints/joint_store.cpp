// Joints by id: the host adds, removes and reads them.
#include "joints/joint_store.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "base/elementary.h"
#include "base/room.h"
#include "base/sort_keys.h"

namespace psim {

using kernels::JointKind;

// How a joint is solved.
JointKind JointStore::kind_of(const JointDesc& d) {
  const bool sprung = d.stiffness > 0 || d.damping > 0, limited = d.lower || d.upper || d.motor_limit > 0;
  switch (d.type) {
    case JointType::distance:
      return limited ? JointKind::linkage : sprung ? JointKind::spring : JointKind::rod;
    case JointType::rope:
      return JointKind::rod;
    case JointType::spring:
      return JointKind::spring;
    case JointType::revolute:
      return sprung ? JointKind::linkage : limited ? JointKind::driven : JointKind::pin;
    case JointType::prismatic:
      return sprung ? JointKind::linkage : JointKind::slide;
    case JointType::weld:
      return d.linear_stiffness > 0 || d.linear_damping > 0 ? JointKind::linkage : JointKind::weld;
    case JointType::filter:
      return JointKind::none;
    default:
      return JointKind::linkage;
  }
}

// Room for the links of the bodies of a joint.
void JointStore::link_room(const Basics& d) {
  for (const BodyId body : {d.a, d.b}) {
    if (!is_world(body.index) && first_.size() <= body.index) first_.resize(std::size_t{body.index} + 1, kNoSlot);
  }
}

// Which sides of a joint move, and whether any does.
void JointStore::find_sides(Joint& j) const {
  const auto dynamic = [&](BodyId id) { return !is_world(id.index) && s_.bodies.inv_mass_in_joints(id.index) > 0; };
  const auto rests = [&](BodyId id) {
    if (is_world(id.index)) return false;
    const Place place = s_.bodies.info[id.index].place;
    return place == Place::asleep || place == Place::disabled;
  };
  j.swapped = !dynamic(j.desc.b);
  j.held = j.swapped || !dynamic(j.desc.a);
  j.dormant = rests(j.desc.a) || rests(j.desc.b) || (j.swapped && !dynamic(j.desc.a)) || j.kind == JointKind::none;
  if (j.desc.type != JointType::gear) return;
  for (const int part : {0, 1}) j.dormant = j.dormant || joints_[part_of_gear(j, part).index].dormant;
}

// A joint begins to count. This finds out what follows from its description and its bodies. Needs no memory if link_room()
// made it, and there is room for a gear.
void JointStore::enter(std::uint32_t index) {
  Joint& j = joints_[index];
  find_sides(j);
  j.lane = j.articulated = kNoSlot;
  link_room(j.desc);
  for (const BodyId body : {j.desc.a, j.desc.b}) link(index, body.index);
  if (j.desc.type == JointType::gear) gears_.push_back(index);
  if (!j.desc.collide) ++exclusions_;
  ++count_;
  stale_ = true;
}

// Notes a description, with its rarer parts where there are any; there is room for these.
void JointStore::set_desc(Joint& j, const JointDesc& d) {
  j.desc = {d.type, d.a,         d.b,     d.anchor_a, d.anchor_b,    d.length,      d.stiffness, d.damping,
            d.axis, d.reference, d.lower, d.upper,    d.motor_speed, d.motor_limit, d.collide};
  if (j.extra != kNoSlot) extras_[j.extra].desc = d;
}

JointDesc JointStore::desc(JointId id) const {
  const Joint& j = joints_[id.index];
  if (j.extra != kNoSlot) return extras_[j.extra].desc;
  const Basics& b = j.desc;
  JointDesc d;
  d.type = b.type, d.a = b.a, d.b = b.b, d.anchor_a = b.anchor_a, d.anchor_b = b.anchor_b, d.length = b.length;
  d.stiffness = b.stiffness, d.damping = b.damping, d.axis = b.axis, d.reference = b.reference;
  d.lower = b.lower, d.upper = b.upper, d.motor_speed = b.motor_speed, d.motor_limit = b.motor_limit;
  d.collide = b.collide;
  return d;
}

// Gives a joint what it needs beyond the basics.
void JointStore::make_extra(Joint& j, const JointDesc& d) {
  const bool linkage = kind_of(d) == JointKind::linkage;
  const bool needed = linkage || tells_of_membrane(d) || d.break_force > 0 || d.break_torque > 0 || d.user_data != 0;
  if (needed && j.extra == kNoSlot) {
    if (free_extras_.empty()) {
      extras_.reserve(roomier(extras_));
      free_extras_.reserve(std::max(free_extras_.capacity(), extras_.capacity()));  // dropping needs no memory
      free_extras_.push_back(static_cast<std::uint32_t>(extras_.size()));
      extras_.emplace_back();
    }
    j.extra = free_extras_.back();
    free_extras_.pop_back();
  }
  if (!linkage || extras_[j.extra].linkage != kNoSlot) return;
  const std::uint32_t number = linkages_.add();
  linkages_[number].set_type(d.type);
  extras_[j.extra].linkage = number;
}

void JointStore::drop_extra(Joint& j) {
  if (j.extra == kNoSlot) return;
  if (extras_[j.extra].linkage != kNoSlot) linkages_.remove(extras_[j.extra].linkage);
  extras_[j.extra] = {};
  free_extras_.push_back(j.extra);
  j.extra = kNoSlot;
}

JointId JointStore::add(const JointDesc& d) {
  Joint made;
  made.alive = true;
  made.kind = kind_of(d);
  set_desc(made, d);
  link_room(made.desc);
  if (d.type == JointType::gear) gears_.reserve(roomier(gears_));
  if (free_.empty()) {
    joints_.reserve(roomier(joints_));
    free_.reserve(std::max(free_.capacity(), joints_.capacity()));  // to take joints out needs no memory
    free_.push_back(static_cast<std::uint32_t>(joints_.size()));
    joints_.emplace_back();
  }
  or_else([&] { drop_extra(made); }, [&] { make_extra(made, d); });
  set_desc(made, d);
  const std::uint32_t index = free_.back();
  free_.pop_back();
  made.generation = joints_[index].generation;
  joints_[index] = made;
  enter(index);
  return {index, made.generation};
}

void JointStore::change(JointId id, const JointDesc& d) {
  Joint& j = joints_[id.index];
  const bool plain = j.extra == kNoSlot;
  or_else(
      [&] {
        if (plain) drop_extra(j);
      },
      [&] { make_extra(j, d); });
  const bool excluded = !j.desc.collide;
  // What the layout knows of a joint, apart from its kind.
  const auto known = [&] {
    return std::tuple(j.desc.anchor_a, j.desc.anchor_b, j.desc.length, j.desc.lower || j.desc.upper, j.is_soft());
  };
  const auto before_it = known();
  set_desc(j, d);
  if (excluded != !d.collide) (excluded ? --exclusions_ : ++exclusions_);
  stale_ = stale_ || j.extra != kNoSlot || known() != before_it;  // with an extra it may break now
  const JointKind before = j.kind, now = kind_of(d);
  if (before == now || (before == JointKind::driven && now == JointKind::pin)) return;
  save_impulse(j);
  leave_lane(j);
  j.kind = now;
  if (now == JointKind::driven && before == JointKind::pin) return;  // the impulses of the anchors stay
  std::ranges::fill(j.impulse, 0.0f);
  if (now == JointKind::linkage) linkages_[extras_[j.extra].linkage].each_impulse([](double& l) { l = 0; });
}

void JointStore::leave_lane(Joint& j) {
  if (j.lane != kNoSlot) lanes_[j.list()][j.lane] = kNoSlot;
  j.lane = j.articulated = kNoSlot;
  stale_ = true;
}

bool JointStore::remove(JointId id) {
  if (!is_valid(id)) return false;
  for (std::size_t k = gears_.size(); k-- > 0;) {
    const std::uint32_t gear = gears_[k];
    if (part_of_gear(joints_[gear], 0) == id || part_of_gear(joints_[gear], 1) == id) {
      remove({gear, joints_[gear].generation});
    }
  }
  Joint& j = joints_[id.index];
  if (j.desc.type == JointType::gear) std::erase(gears_, id.index);
  drop_extra(j);
  for (const BodyId body : {j.desc.a, j.desc.b}) unlink(id.index, body.index);
  leave_lane(j);
  if (!j.desc.collide) --exclusions_;
  --count_;
  j.alive = false;
  if (++j.generation != kLastGeneration) free_.push_back(id.index);
  return true;
}

std::size_t JointStore::bytes() const {
  std::size_t sum =
      bytes_of(joints_, free_, first_, bodies_, members_, jobs_.ranges, jobs_.jobs, phases_, shares_.ranges,
               shares_.jobs, marks_, swept_, tethers_, tether_ranges_, extras_, free_extras_, gears_, fragile_) +
      lists_.bytes() + articulations_.bytes() + linkages_.bytes() + membranes_.bytes();
  for (std::uint32_t list = 0; list < kLists; ++list) sum += bytes_of(lanes_[list], ends_[list]);
  return sum;
}

void JointStore::release_blocks() {
  give_back(first_, bodies_, members_, lists_, lanes_, ends_, jobs_, phases_, shares_, marks_, share_vel_,
            share_rim_speed_, push_vel_, push_rim_speed_, push0_vel_, push0_rim_speed_);
  give_back(swept_, tethers_, tether_ranges_, extras_, free_extras_, gears_, fragile_, linkages_);
  articulations_.release();
  membranes_.release();
  cycles_.release();
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
  if (is_world(body)) return;
  std::uint32_t before = kNoSlot, next = first_[body];
  while (next != kNoSlot && next > index) before = std::exchange(next, joints_[next].next_of(body));
  joints_[index].before_of(body) = before;
  joints_[index].next_of(body) = next;
  (before == kNoSlot ? first_[body] : joints_[before].next_of(body)) = index;
  if (next != kNoSlot) joints_[next].before_of(body) = index;
}

void JointStore::unlink(std::uint32_t index, std::uint32_t body) {
  if (is_world(body)) return;
  const std::uint32_t before = joints_[index].before_of(body), next = joints_[index].next_of(body);
  (before == kNoSlot ? first_[body] : joints_[before].next_of(body)) = next;
  if (next != kNoSlot) joints_[next].before_of(body) = before;
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
  for (const std::uint32_t gear : gears_) {
    const bool slept = joints_[gear].dormant;
    find_sides(joints_[gear]);
    stale_ = stale_ || slept != joints_[gear].dormant;
  }
}

const std::vector<std::uint32_t>& JointStore::bodies() {
  if (!stale_) return bodies_;
  bodies_.clear();
  for (const Joint& j : joints_) {
    if (!j.alive || j.dormant) continue;
    bodies_.insert(bodies_.end(), {j.desc.a.index, j.desc.b.index});
    if (j.desc.type == JointType::pulley) bodies_.push_back(kWorldBody.index);
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
  if (j.kind == JointKind::linkage && !j.dormant) {
    const Linkage& l = linkages_[extras_[j.extra].linkage];
    const std::uint32_t b = l.part[l.ratio != 0 ? 1 : 0].end[1];
    for (std::uint32_t r = 0; r < l.rows; ++r) {
      const Lever& lever = l.row[r].lever[b];
      force = force + (l.row[r].impulse / h_) * lever.n;
      if (lever.n.x == 0 && lever.n.y == 0) torque += l.row[r].impulse * lever.arm / h_;
    }
    return;
  }
  const double sign = j.swapped ? -1 : 1, per_h = sign * (j.lane != kNoSlot ? cycles_.count : 1) / h_;
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

// Adds what joints that may break bear in a substep.
void JointStore::add_loads() {
  ++substeps_;
  for (const std::uint32_t i : fragile_) {
    Vec2 force;
    double torque = 0;
    const Joint& j = joints_[i];
    Vec2 line{1, 0}, axis{1, 0};
    if (j.articulated != kNoSlot) {
      const Articulations::Joint& in = articulations_.joints()[j.articulated];
      const JointedMotion &a = articulations_.bodies()[in.body[0]].now, &b = articulations_.bodies()[in.body[1]].now;
      const JointGeometry& g = in.geometry;
      const double sign = j.swapped ? -1 : 1;
      line = sign * (g.base + (b.at - a.at) + (turned(b.turn, g.anchor[1]) - turned(a.turn, g.anchor[0])));
      axis = sign * turned(a.turn, g.axis);
    }
    load_of({i, j.generation}, line, axis, force, torque);
    Extra& extra = extras_[joints_[i].extra];
    extra.force = extra.force + force;
    extra.torque += torque;
  }
}

// Whether no other overloaded joint of its moving bodies is loaded more; of equal ones the lowest index goes.
bool JointStore::breaks_first(const Overload& load, std::span<const Overload> all) const {
  bool first = true;
  const auto compare = [&](std::uint32_t index) {
    const auto at = std::ranges::lower_bound(all, index, {}, &Overload::joint);
    if (at == all.end() || at->joint != index || index == load.joint) return;
    if (at->share > load.share || (at->share == load.share && index < load.joint)) first = false;
  };
  const Basics& d = joints_[load.joint].desc;
  for (const BodyId body : {d.a, d.b}) {
    if (inverse_mass_of(body.index) > 0) each_of(body.index, compare);
  }
  return first;
}

std::vector<JointStore::Overload> JointStore::overloads() const {
  constexpr double kSteps = 100;  // loads that differ by rounding alone are equal
  std::vector<Overload> all;
  if (stale_) return all;  // nothing was solved since joints came, went or changed
  for (const std::uint32_t i : fragile_) {
    const Extra& extra = extras_[joints_[i].extra];
    Overload load{i, (1.0 / substeps_) * extra.force, extra.torque / substeps_};
    const JointDesc& d = extra.desc;
    if (d.break_force > 0) load.share = length_of(load.force) / d.break_force;
    if (d.break_torque > 0) load.share = greater(load.share, std::fabs(load.torque) / d.break_torque);
    if (!(load.share > 1)) continue;
    load.share = std::floor(kSteps * load.share);
    all.push_back(load);
  }
  std::vector<Overload> out;
  for (const Overload& load : all) {
    if (breaks_first(load, all)) out.push_back(load);
  }
  return out;
}

}  // namespace psim
