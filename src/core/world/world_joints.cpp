// Joints of the public API: what is refused, and what they tell.
#include <cmath>
#include <numbers>

#include "base/range_text.h"
#include "base/rotor.h"
#include "bodies/body_desc.h"
#include "psim/limits.h"
#include "world/world_impl.h"

namespace psim {
namespace {

// The world has no motion.
BodyState side_of(const Observed& seen, BodyId id) {
  return is_world(id.index) ? BodyState{} : seen.state_of(id.index);
}

Vec2 world_point(const BodyState& s, Vec2 p) { return Vec2{s.x, s.y} + turned(sine_cosine(s.angle), p); }

// A side of a joint as it is now, with what tells how it is moved. Of the world, the place is the anchor.
JointMember member_of(const Observed& seen, BodyId id, Vec2 anchor) {
  JointMember m;
  if (is_world(id.index)) {
    m.at = seen.lattice.to_lattice(anchor);
    m.centre = anchor;
    return m;
  }
  const BodyState s = seen.state_of(id.index);
  const Place place = seen.bodies.info[id.index].place;
  const bool fixed = place != Place::moving && place != Place::asleep;
  const BodyKind& kind = seen.bodies.kind(id.index);
  const BodyProperties& of = seen.bodies.properties(id.index);
  m.centre = fixed ? Vec2{} : Vec2{kind.centre_x, kind.centre_y};
  m.at = fixed ? seen.lattice.to_lattice({s.x, s.y}) : seen.stand(id.index).first;
  m.angle = s.angle;
  m.turn = sine_cosine(s.angle);
  m.inverse_mass = wide(seen.bodies.inv_mass_in_joints(id.index));
  m.rim_gain = wide(of.rim_gain);
  if (of.radius > 0) m.inverse_radius = 1 / wide(of.radius);
  return m;
}

// From one anchor to the other: by lattice differences, which are exact and go the short way round in a periodic world.
Vec2 way_between(const Observed& seen, BodyId a, Vec2 anchor_a, BodyId b, Vec2 anchor_b) {
  const JointMember ma = member_of(seen, a, anchor_a), mb = member_of(seen, b, anchor_b);
  return seen.lattice.way(ma.at, mb.at) +
         (turned(mb.turn, anchor_b - mb.centre) - turned(ma.turn, anchor_a - ma.centre));
}
Vec2 way_between(const Observed& seen, const JointDesc& d) {
  return way_between(seen, d.a, d.anchor_a, d.b, d.anchor_b);
}

// What a gear ties of a revolute or prismatic joint, what joint() tells of it, and what limits are of.
double way_of(const Observed& seen, const JointDesc& d) {
  const double angle = side_of(seen, d.a).angle;
  switch (d.type) {
    case JointType::revolute:
    case JointType::weld:
    case JointType::motor:
      return side_of(seen, d.b).angle - angle - d.reference.value_or(0);
    case JointType::prismatic:
    case JointType::wheel:
      return dot(way_between(seen, d), turned(sine_cosine(angle), d.axis)) / length_of(d.axis);
    case JointType::target:
      return length_of(way_between(seen, kWorldBody, d.target, d.b, d.anchor_b));
    case JointType::pulley:
      return length_of(way_between(seen, kWorldBody, d.ground_a, d.a, d.anchor_a)) +
             d.ratio * length_of(way_between(seen, kWorldBody, d.ground_b, d.b, d.anchor_b));
    case JointType::filter:
    case JointType::gear:
      return 0;
    default:
      return length_of(way_between(seen, d));
  }
}
double sum_of_gear(const Owners& w, const Observed& seen, const JointDesc& gear) {
  return way_of(seen, w.joints.desc(gear.joint_a)) + gear.ratio * way_of(seen, w.joints.desc(gear.joint_b));
}

// How a side moves at its anchor, which a body that does not take part in the steps does not.
struct AnchorMotion {
  Vec2 velocity;    // m/s
  double spin = 0;  // rad/s
};
AnchorMotion motion_of(const Observed& seen, BodyId id, Vec2 anchor) {
  if (is_world(id.index) || seen.bodies.info[id.index].place != Place::moving) return {};
  const BodyState s = seen.state_of(id.index);
  const bool about_place = s.type == BodyType::kinematic_body;
  const Vec2 centre = about_place ? Vec2{} : arm_of(seen.bodies.kind(id.index), s.angle);
  const Vec2 arm = turned(sine_cosine(s.angle), anchor) - centre;
  return {Vec2{s.vx, s.vy} + s.omega * upright(arm), s.omega};
}

// m/s: how fast a way grows.
double growth(Vec2 way, Vec2 velocity) {
  const double length = length_of(way);
  return length > 0 ? dot(way, velocity) / length : 0;
}

// How fast way_of() grows.
double speed_of(const Observed& seen, const JointDesc& d) {
  const AnchorMotion a = motion_of(seen, d.a, d.anchor_a), b = motion_of(seen, d.b, d.anchor_b);
  switch (d.type) {
    case JointType::revolute:
    case JointType::weld:
    case JointType::motor:
      return b.spin - a.spin;
    case JointType::prismatic:
    case JointType::wheel: {
      const Vec2 axis = turned(sine_cosine(side_of(seen, d.a).angle), d.axis);  // it turns with a
      const double along = dot(b.velocity - a.velocity, axis) + a.spin * dot(way_between(seen, d), upright(axis));
      return along / length_of(d.axis);
    }
    case JointType::target:
      return growth(way_between(seen, kWorldBody, d.target, d.b, d.anchor_b), b.velocity);
    case JointType::pulley:
      return growth(way_between(seen, kWorldBody, d.ground_a, d.a, d.anchor_a), a.velocity) +
             d.ratio * growth(way_between(seen, kWorldBody, d.ground_b, d.b, d.anchor_b), b.velocity);
    case JointType::filter:
    case JointType::gear:
      return 0;
    default:
      return growth(way_between(seen, d), b.velocity - a.velocity);
  }
}
double speed_of_gear(const Owners& w, const Observed& seen, const JointDesc& gear) {
  return speed_of(seen, w.joints.desc(gear.joint_a)) + gear.ratio * speed_of(seen, w.joints.desc(gear.joint_b));
}

bool is_line(JointType type) {
  return type == JointType::distance || type == JointType::spring || type == JointType::rope;
}
bool has_axis(JointType type) { return type == JointType::prismatic || type == JointType::wheel; }
bool has_spring(JointType type) {
  return type == JointType::distance || type == JointType::spring || type == JointType::revolute || has_axis(type) ||
         type == JointType::weld || type == JointType::target;
}
bool has_motor(JointType type) { return type == JointType::distance || type == JointType::revolute || has_axis(type); }

// One line of what is wrong with the numbers, or empty.
std::string check_numbers(const JointDesc& d) {
  const Range range = d.type == JointType::distance ? limits::kLength
                      : has_axis(d.type)            ? limits::kCoordinate
                                                    : limits::kAngle;
  RangeCheck check;
  check("type", d.type, JointType::filter);
  check("anchor a", d.anchor_a, limits::kCoordinate)("anchor b", d.anchor_b, limits::kCoordinate);
  check("stiffness", d.stiffness, limits::kStiffness)("damping", d.damping, limits::kJointDamping);
  check("axis", d.axis, limits::kCoordinate)("reference", d.reference, limits::kAngle);
  check("lower", d.lower, range)("upper", d.upper, range)("motor speed", d.motor_speed, limits::kMotorSpeed);
  check("motor limit", d.motor_limit, limits::kMotorLimit);
  check("target", d.target, limits::kCoordinate)("rest", d.rest, limits::kCoordinate);
  check("linear velocity", d.linear_velocity, limits::kMotorSpeed);
  check("angular velocity", d.angular_velocity, limits::kMotorSpeed);
  check("force limit", d.force_limit, limits::kMotorLimit)("torque limit", d.torque_limit, limits::kMotorLimit);
  check("ground a", d.ground_a, limits::kCoordinate)("ground b", d.ground_b, limits::kCoordinate);
  check("linear stiffness", d.linear_stiffness, limits::kStiffness);
  check("linear damping", d.linear_damping, limits::kJointDamping);
  check("correction", d.correction, limits::kCorrection)("offset", d.offset, limits::kCoordinate);
  check("ratio", d.ratio, d.type == JointType::pulley ? limits::kPulleyRatio : limits::kRatio);
  check("frequency", d.frequency, limits::kFrequency)("damping ratio", d.damping_ratio, limits::kDampingRatio);
  check("break force", d.break_force, limits::kMotorLimit)("break torque", d.break_torque, limits::kMotorLimit);
  check("pressure", d.pressure, limits::kPressure)("area", d.area, limits::kArea);
  check("wind drag", d.wind_drag, limits::kWindFactor)("wind lift", d.wind_lift, limits::kWindFactor);
  if (has_axis(d.type)) check("the length of the axis", length_of(d.axis), limits::kAxis);
  if (check.error.empty() && d.lower && d.upper && *d.lower > *d.upper) return "lower must not be above upper";
  if (check.error.empty() && d.type == JointType::gear && std::fabs(d.ratio) < limits::kPulleyRatio.min)
    return "the ratio of a gear must not be nearer to 0 than 1e-6";
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
  for (const BodyId body : {joint.a, joint.b}) {
    if (!is_world(body.index)) disturb(w, body.index);
  }
}

// The bodies of a gear are those that its joints move.
std::string find_sides_of_gear(const Owners& w, JointDesc& d) {
  const auto tied = [&](JointId id, BodyId& side) {
    if (!w.joints.is_valid(id)) return false;
    const JointDesc joint = w.joints.desc(id);
    if (joint.type != JointType::revolute && joint.type != JointType::prismatic) return false;
    const bool moves = !is_world(joint.b.index) && w.bodies.inv_mass_in_joints(joint.b.index) > 0;
    side = moves ? joint.b : joint.a;
    return true;
  };
  if (!tied(d.joint_a, d.a)) return "joint a is no revolute or prismatic joint";
  if (!tied(d.joint_b, d.b)) return "joint b is no revolute or prismatic joint";
  return d.a == d.b ? "the joints of a gear must move two bodies" : "";
}

// What is wrong with the bodies of a joint, or empty. Those that follow from the type are set.
std::string check_sides(const Owners& w, JointDesc& d) {
  if (d.type == JointType::target) d.a = kWorldBody;
  if (d.type == JointType::gear) {
    if (std::string wrong = find_sides_of_gear(w, d); !wrong.empty()) return wrong;
  }
  const bool alone = d.type == JointType::pulley || d.type == JointType::filter;
  for (const BodyId id : {d.a, d.b}) {
    if (id == kWorldBody && !alone) continue;
    if (!w.population.is_valid(id)) return id == d.a ? "a is not a body" : "b is not a body";
    const bool frozen = w.bodies.info[id.index].place == Place::frozen;
    if (frozen) return "a body whose numbers are broken cannot be joined";
  }
  if (d.a == d.b) return "a and b must differ";
  const auto dynamic = [&](BodyId id) { return id != kWorldBody && w.bodies.inv_mass_in_joints(id.index) > 0; };
  if (!dynamic(d.a) && !dynamic(d.b)) return "one of the bodies must be dynamic, and not locked altogether";
  return {};
}

// From frequency and damping ratio.
std::string find_stiffness(const Owners& w, const Observed& seen, JointDesc& d) {
  if (d.frequency) {
    if (!has_spring(d.type)) return "frequency is for a spring that moves something: of no such joint";
    JointDesc line = d;
    if (d.type == JointType::target) line.anchor_a = d.target;
    const JointMember a = member_of(seen, line.a, line.anchor_a), b = member_of(seen, line.b, line.anchor_b);
    const double mass = JointStore::sprung_mass(line, a, b, w.lattice);
    if (!(mass > 0)) return "frequency is for a spring that moves something: of no such joint";
    const double swing = 2 * std::numbers::pi * *d.frequency;
    d.stiffness = mass * swing * swing;
    d.damping = 2 * d.damping_ratio * mass * swing;
    d.frequency.reset();
    const std::string wrong = check_numbers(d);
    if (!wrong.empty()) return "frequency asks for more than that: " + wrong;
  }
  const bool sprung = d.type == JointType::spring || d.type == JointType::target;
  if (sprung && !(d.stiffness > 0 || d.damping > 0)) return "stiffness and damping are 0: a spring has one of them";
  return {};
}

// Checks a description and sets what it leaves open. One line of what is wrong, or empty.
std::string complete(Owners& w, JointDesc& d) {
  if (std::string wrong = check_sides(w, d); !wrong.empty()) return wrong;
  if (std::string wrong = check_numbers(d); !wrong.empty()) return wrong;
  const Observed seen = w.observed();
  const bool given = d.length.has_value();
  if (!given) {
    d.length = d.type == JointType::gear     ? sum_of_gear(w, seen, d)
               : d.type == JointType::pulley ? way_of(seen, d)
                                             : length_of(way_between(seen, d));
  }
  if (is_line(d.type)) {
    if (std::string wrong = check_length(d.type, given, *d.length); !wrong.empty()) return wrong;
  } else if (d.type == JointType::pulley) {
    if (std::string wrong = check_length(JointType::distance, true, *d.length); !wrong.empty()) return wrong;
  } else if (!std::isfinite(*d.length)) {
    return RangeCheck()("length", *d.length, limits::kCoordinate).error;
  }
  if (!d.reference) d.reference = side_of(seen, d.b).angle - side_of(seen, d.a).angle;
  return find_stiffness(w, seen, d);
}

}  // namespace

void disturb_joined(Owners& w, std::uint32_t body) {
  if (w.joints.empty()) return;
  w.joints.each_joined(body, [&](std::uint32_t other) {
    if (!is_world(other)) disturb(w, other);
  });
}

void remove_joints_of(Owners& w, std::uint32_t body) {
  if (w.joints.empty()) return;
  w.joints.remove_of_body(body);
  count_joints(w);
}

void break_joints(Owners& w) {
  for (const JointStore::Overload& load : w.joints.overloads()) {
    const JointId id = w.joints.id_of(load.joint);
    if (id == kNoJoint) continue;  // a gear that broke with a joint of it
    const JointDesc d = w.joints.desc(id);
    const Vec2 point = world_point(side_of(w.observed(), d.b), d.anchor_b);
    disturb_both(w, d);
    w.observers.events.breaks.push_back({id, d.a, d.b, point, load.force, load.torque, d.user_data});
    w.joints.remove(id);
    count_joints(w);
  }
}

JointId World::add_joint(const JointDesc& desc, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  JointDesc d = desc;
  if (error = complete(w, d); !error.empty()) return kNoJoint;
  disturb_both(w, d);
  const JointId id = w.joints.add(d);
  count_joints(w);
  return id;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "a joint", error);
  return impl_->ran_out(kNoJoint);
}

bool World::set_joint(JointId id, const JointDesc& desc, std::string& error) try {
  const FloatSettings settings;
  Owners& w = impl_->settled();
  error = "there is no such joint";
  if (!is_valid_joint(id)) return false;
  const JointDesc before = w.joints.desc(id);
  JointDesc d = desc;
  error = "the type of a joint stays what it is";
  if (d.type != before.type) return false;
  if (error = complete(w, d); !error.empty()) return false;
  error = "the bodies of a joint stay what they are";
  if (d.a != before.a || d.b != before.b || d.joint_a != before.joint_a || d.joint_b != before.joint_b) return false;
  error.clear();
  disturb_both(w, d);
  w.joints.change(id, d);
  count_joints(w);
  return true;
} catch (const std::bad_alloc&) {
  say_no_room(*impl_, "a joint", error);
  return impl_->ran_out(false);
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

std::vector<JointId> World::joints_of(BodyId id) const try {
  std::vector<JointId> found;
  if (!is_valid(id)) return found;
  impl_->joints.each_of(id.index, [&](std::uint32_t index) { found.push_back(impl_->joints.id_of(index)); });
  std::ranges::sort(found, {}, &JointId::index);  // Total order: no two have one index.
  return found;
} catch (const std::bad_alloc&) {
  return nothing_found<std::vector<JointId>>();
}

namespace {

// Changes one thing of a joint whose type has it, and wakes its bodies. False if there is no such joint.
template <class Has, class Change>
bool change_joint(Owners& w, JointId id, const Has& has, const Change& change) {
  if (!w.joints.is_valid(id)) return false;
  JointDesc d = w.joints.desc(id);
  if (!has(d.type)) return false;
  w.settled();
  disturb_both(w, d);
  change(d);
  w.joints.change(id, d);
  return true;
}

}  // namespace

bool World::set_motor(JointId id, double speed, double limit) try {
  const FloatSettings settings;
  if (!limits::kMotorSpeed.contains(speed) || !limits::kMotorLimit.contains(limit)) return false;
  return change_joint(*impl_, id, has_motor, [&](JointDesc& d) { d.motor_speed = speed, d.motor_limit = limit; });
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

bool World::set_target(JointId id, Vec2 point) try {
  const FloatSettings settings;
  if (!limits::kCoordinate.contains(point)) return false;
  const auto has_target = [](JointType type) { return type == JointType::target; };
  return change_joint(*impl_, id, has_target, [&](JointDesc& d) { d.target = point; });
} catch (const std::bad_alloc&) {
  return impl_->ran_out(false);
}

std::optional<JointDesc> World::joint_desc(JointId id) const {
  if (!is_valid_joint(id)) return std::nullopt;
  return impl_->joints.desc(id);
}

std::optional<JointState> World::joint(JointId id) const {
  const FloatSettings settings;
  if (!is_valid_joint(id)) return std::nullopt;
  const JointDesc d = impl_->joints.desc(id);
  const Observed seen = impl_->observed();
  const BodyState a = side_of(seen, d.a), b = side_of(seen, d.b);
  JointState s;
  s.a = d.a;
  s.b = d.b;
  s.type = d.type;
  s.anchor_a = d.type == JointType::target ? d.target : world_point(a, d.anchor_a);
  s.anchor_b = world_point(b, d.anchor_b);
  s.value = d.type == JointType::gear ? sum_of_gear(*impl_, seen, d) : way_of(seen, d);
  s.speed = d.type == JointType::gear ? speed_of_gear(*impl_, seen, d) : speed_of(seen, d);
  impl_->joints.load_of(id, way_between(seen, d), turned(sine_cosine(a.angle), d.axis), s.force, s.torque);
  return s;
}

}  // namespace psim
