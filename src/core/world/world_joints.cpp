// Joints of the public API: what is refused, and what they tell.
#include <cmath>

#include "base/range_text.h"
#include "base/rotor.h"
#include "bodies/body_desc.h"
#include "psim/limits.h"
#include "world/world_impl.h"

namespace psim {
namespace {

Vec2 world_point(const BodyState& s, Vec2 p) {
  const SineCosine turn = sine_cosine(s.angle);
  return {s.x + turn.cosine * p.x - turn.sine * p.y, s.y + turn.sine * p.x + turn.cosine * p.y};
}

// From one anchor to the other: by lattice differences, which are exact and go the short way round in a periodic world.
Vec2 way_between(const Observed& seen, const JointDesc& d) {
  LatticePoint at[2];
  Vec2 arm[2];
  for (const int side : {0, 1}) {
    const std::uint32_t id = (side == 0 ? d.a : d.b).index;
    const BodyState s = seen.state_of(id);
    const Place place = seen.bodies.info[id].place;
    const bool fixed = place != Place::moving && place != Place::asleep;
    const BodyKind& kind = seen.bodies.kind(id);
    const Vec2 centre = fixed ? Vec2{} : Vec2{kind.centre_x, kind.centre_y};
    at[side] = fixed ? seen.lattice.to_lattice({s.x, s.y}) : seen.stand(id).first;
    arm[side] = turned(sine_cosine(s.angle), (side == 0 ? d.anchor_a : d.anchor_b) - centre);
  }
  return seen.lattice.way(at[0], at[1]) + (arm[1] - arm[0]);
}

// One line of what is wrong with the numbers, or empty.
std::string check_numbers(const JointDesc& d) {
  const Range range = d.type == JointType::prismatic ? limits::kCoordinate : limits::kAngle;
  RangeCheck check;
  check("anchor a", d.anchor_a, limits::kCoordinate)("anchor b", d.anchor_b, limits::kCoordinate);
  check("stiffness", d.stiffness, limits::kStiffness)("damping", d.damping, limits::kJointDamping);
  check("axis", d.axis, limits::kCoordinate)("reference", d.reference, limits::kAngle);
  check("lower", d.lower, range)("upper", d.upper, range)("motor speed", d.motor_speed, limits::kMotorSpeed);
  check("motor limit", d.motor_limit, limits::kMotorLimit);
  if (d.type == JointType::prismatic) check("the length of the axis", length_of(d.axis), limits::kAxis);
  if (check.error.empty() && d.lower && d.upper && *d.lower > *d.upper) return "lower must not be above upper";
  return check.error;
}

// The same of the length that is given or, else, that there is between the anchors: a rope may begin without any.
std::string check_length(JointType type, bool given, double length) {
  const bool rod = type == JointType::distance || (type == JointType::rope && given);
  return RangeCheck()("length", length, rod ? limits::kRodLength : limits::kLength).error;
}

void count_joints(Owners& w) {
  w.population.traits.joints = w.joints.count();
  w.population.traits.exclusions = w.joints.any_exclusions();
  spoil_work(w);
  w.plan_stale = true;
}

void disturb_both(Owners& w, const JointDesc& joint) {
  for (const BodyId body : {joint.a, joint.b}) disturb(w, body.index);
}

}  // namespace

void disturb_joined(Owners& w, std::uint32_t body) {
  if (!w.joints.empty()) w.joints.each_joined(body, [&](std::uint32_t other) { disturb(w, other); });
}

void remove_joints_of(Owners& w, std::uint32_t body) {
  if (w.joints.empty()) return;
  w.joints.remove_of_body(body);
  count_joints(w);
}

JointId World::add_joint(const JointDesc& desc, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  error.clear();
  const auto refuse = [&](std::string what) {
    error = std::move(what);
    return kNoJoint;
  };
  for (const BodyId id : {desc.a, desc.b}) {
    if (!is_valid(id)) return refuse(id == desc.a ? "a is not a body" : "b is not a body");
    const bool frozen = w.bodies.info[id.index].place == Place::frozen;
    if (frozen) return refuse("a body whose numbers are broken cannot be joined");
  }
  if (desc.a == desc.b) return refuse("a and b must differ");
  const auto dynamic = [&](BodyId id) { return w.bodies.inv_mass_in_joints(id.index) > 0; };
  if (!dynamic(desc.a) && !dynamic(desc.b))
    return refuse("one of the bodies must be dynamic, and not locked altogether");
  if (error = check_numbers(desc); !error.empty()) return kNoJoint;

  JointDesc d = desc;
  const Observed seen = w.observed();
  const BodyState a = seen.state_of(d.a.index), b = seen.state_of(d.b.index);
  if (!d.length) d.length = length_of(way_between(seen, d));
  if (d.type == JointType::distance || d.type == JointType::spring || d.type == JointType::rope) {
    if (error = check_length(d.type, desc.length.has_value(), *d.length); !error.empty()) return kNoJoint;
  }
  if (!d.reference) d.reference = b.angle - a.angle;
  disturb_both(w, d);
  const JointId id = w.joints.add(d);
  count_joints(w);
  return id;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "a joint", error);
  return impl_->ran_out(kNoJoint);
}

bool World::remove_joint(JointId id) try {
  if (!is_valid_joint(id)) return false;
  Owners& w = impl_->settled();
  disturb_both(w, w.joints.desc(id));
  w.joints.remove(id);
  count_joints(w);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::is_valid_joint(JointId id) const { return impl_->joints.is_valid(id); }

std::size_t World::joint_count() const { return impl_->joints.count(); }

bool World::set_motor(JointId id, double speed, double limit) try {
  const FloatSettings settings;
  if (!limits::kMotorSpeed.contains(speed) || !limits::kMotorLimit.contains(limit) || !is_valid_joint(id)) return false;
  Owners& w = impl_->settled();
  const JointDesc& d = w.joints.desc(id);
  if (d.type != JointType::revolute && d.type != JointType::prismatic) return false;
  disturb_both(w, d);
  w.joints.set_motor(id, speed, limit);
  return true;
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

std::optional<JointState> World::joint(JointId id) const {
  const FloatSettings settings;
  if (!is_valid_joint(id)) return std::nullopt;
  const JointDesc& d = impl_->joints.desc(id);
  const Observed seen = impl_->observed();
  const BodyState a = seen.state_of(d.a.index), b = seen.state_of(d.b.index);
  JointState s;
  s.a = d.a;
  s.b = d.b;
  s.type = d.type;
  s.anchor_a = world_point(a, d.anchor_a);
  s.anchor_b = world_point(b, d.anchor_b);
  const Vec2 way = way_between(seen, d);
  switch (d.type) {
    case JointType::revolute:
    case JointType::weld:
      s.value = b.angle - a.angle - *d.reference;
      break;
    case JointType::prismatic:
      s.value = dot(way, turned(sine_cosine(a.angle), d.axis)) / length_of(d.axis);
      break;
    default:
      s.value = length_of(way);
  }
  impl_->joints.load_of(id, way, turned(sine_cosine(a.angle), d.axis), s.force, s.torque);
  return s;
}

}  // namespace psim
