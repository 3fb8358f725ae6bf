// joints[] of a scene file, and the links of its groups.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/rotor.h"
#include "file/parse_limits.h"
#include "file/parse_parts.h"
#include "place/links.h"

namespace psim::scene {
namespace {

// In the order of JointType.
constexpr std::array<std::string_view, 12> kJointTypes = {"distance",  "spring", "rope",   "revolute",
                                                          "prismatic", "weld",   "wheel",  "motor",
                                                          "target",    "gear",   "pulley", "filter"};
constexpr std::array<std::string_view, 3> kLinkTypes = {"distance", "spring", "rope"};
constexpr std::array<std::string_view, 5> kPins = {"none", "top", "corners", "left", "ends"};

template <class... Types>
constexpr unsigned bits(Types... types) {
  return ((1u << static_cast<unsigned>(types)) | ...);
}
using enum JointType;
constexpr unsigned kAnyType = 0xFFFu;
constexpr unsigned kNotGear = kAnyType & ~bits(gear);
constexpr unsigned kA = kAnyType & ~bits(gear, target);
constexpr unsigned kAnchorB = kAnyType & ~bits(gear, filter), kAnchorA = kAnchorB & ~bits(target);
constexpr unsigned kLengths = bits(distance, spring, rope, pulley);
constexpr unsigned kLines = bits(distance, spring, rope);
constexpr unsigned kSoft = bits(distance, spring, weld, revolute, prismatic, wheel, target);
constexpr unsigned kMotors = bits(distance, revolute, prismatic, wheel);
constexpr unsigned kRests = bits(revolute, prismatic);
constexpr unsigned kAngled = bits(revolute, prismatic, weld, motor);
constexpr unsigned kBreaks = kAnyType & ~bits(filter);

// A key and the types of joint that have it.
struct Key {
  std::string_view name;
  unsigned types;
};
constexpr std::array kJointKeys = {Key{"type", kAnyType},
                                   Key{"a", kA},
                                   Key{"b", kNotGear},
                                   Key{"anchor_a", kAnchorA},
                                   Key{"anchor_b", kAnchorB},
                                   Key{"collide", kAnyType & ~bits(filter)},
                                   Key{"length", kLengths},
                                   Key{"stiffness", kSoft},
                                   Key{"damping", kSoft},
                                   Key{"frequency", kSoft},
                                   Key{"damping_ratio", kSoft},
                                   Key{"axis", bits(prismatic, wheel)},
                                   Key{"reference", kAngled},
                                   Key{"lower", kMotors},
                                   Key{"upper", kMotors},
                                   Key{"motor_speed", kMotors},
                                   Key{"motor_limit", kMotors},
                                   Key{"target", kRests | bits(target)},
                                   Key{"linear_velocity", bits(motor)},
                                   Key{"angular_velocity", bits(motor)},
                                   Key{"force_limit", bits(motor, target)},
                                   Key{"torque_limit", bits(motor)},
                                   Key{"linear_stiffness", bits(weld)},
                                   Key{"linear_damping", bits(weld)},
                                   Key{"correction", bits(motor)},
                                   Key{"offset", bits(motor)},
                                   Key{"ground_a", bits(pulley)},
                                   Key{"ground_b", bits(pulley)},
                                   Key{"ratio", bits(gear, pulley)},
                                   Key{"joint_a", bits(gear)},
                                   Key{"joint_b", bits(gear)},
                                   Key{"break_force", kBreaks},
                                   Key{"break_torque", kBreaks},
                                   Key{"pressure", kLines | bits(weld)},
                                   Key{"drag", kLines | bits(weld)},
                                   Key{"lift", kLines | bits(weld)},
                                   Key{"area", kLines | bits(weld)}};
constexpr std::array kLinkKeys = {Key{"type", kAnyType},
                                  Key{"stiffness", bits(spring)},
                                  Key{"damping", bits(spring)},
                                  Key{"diagonals", kAnyType},
                                  Key{"pin", kAnyType},
                                  Key{"collide", kAnyType},
                                  Key{"break_force", kAnyType},
                                  Key{"pressure", kAnyType},
                                  Key{"drag", kAnyType},
                                  Key{"lift", kAnyType},
                                  Key{"area", kAnyType},
                                  Key{"bending", bits(distance)},
                                  Key{"bending_damping", bits(distance)}};

std::vector<std::string_view> names_of(unsigned types) {
  std::vector<std::string_view> names;
  for (std::size_t k = 0; k < kJointTypes.size(); ++k) {
    if (types >> k & 1u) names.push_back(kJointTypes[k]);
  }
  return names;
}

// An object with no other keys than those of its type.
void expect_keys(const Node& node, std::span<const Key> keys, JointType type) {
  std::vector<std::string_view> all;
  for (const Key& key : keys) all.push_back(key.name);
  node.expect_object(all);
  for (const Key& key : keys) {
    if (key.types & bits(type) || !node.find(key.name)) continue;
    node.fail_at_key(key.name, "is no key of a " + std::string(kJointTypes[static_cast<std::size_t>(type)]) +
                                   " joint: of " + word_list(names_of(key.types)) + " only");
  }
}

// A body by its name or its id.
std::uint64_t read_body_id(const Node& node, const Context& context) {
  if (node.is_number()) {
    const std::uint64_t id = node.integer(0, kLargestBodyId);
    if (id < context.body_count) return id;
    node.fail("no body " + std::to_string(id) + ": the name or the id of a body, ids count from 0");
  }
  if (!node.is_string()) node.fail("must be a body's name or id");
  const auto named = context.body_ids.find(node.string());
  if (named != context.body_ids.end()) return named->second;
  node.fail("no body \"" + printable(node.string()) + "\": the name or the id of a body, ids count from 0");
}

// A body as read_body_id() has it, or "world" where it may be.
std::uint64_t read_side(const Node& node, const Context& context, bool world) {
  if (!node.is_string() || node.string() != "world" || context.body_ids.contains("world")) {
    return read_body_id(node, context);
  }
  if (!world) node.fail("is the world: a body");
  return kWorldSide;
}

void read_length(const Node& node, JointDesc& joint) {
  const std::optional<Node> length = node.find("length");
  if (!length) return;
  joint.length = length->number(joint.type == JointType::spring ? limits::kLength : limits::kRodLength);
}

// A spring has a stiffness or a frequency; others may.
void read_softness(const Node& node, JointType type, JointDesc& joint) {
  const bool needed = (bits(type) & bits(spring, target)) != 0;
  if (const std::optional<Node> frequency = node.find("frequency")) {
    for (const std::string_view other : {"stiffness", "damping"}) {
      if (node.find(other)) node.fail_at_key(other, "follows from \"frequency\" and \"damping_ratio\": these or those");
    }
    joint.frequency = frequency->number(limits::kFrequency);
    joint.damping_ratio = node.number_or("damping_ratio", joint.damping_ratio, limits::kDampingRatio);
    return;
  }
  if (node.number_or("damping_ratio", 0, limits::kDampingRatio) != 0) {
    node.fail_at_key("damping_ratio", "is for a spring with \"frequency\"");
  }
  if (needed) {
    const Node required = node.require("stiffness");
    joint.stiffness = required.number(limits::kStiffness);
  } else {
    joint.stiffness = node.number_or("stiffness", joint.stiffness, limits::kStiffness);
  }
  joint.damping = node.number_or("damping", joint.damping, limits::kJointDamping);
  if (needed && joint.stiffness == 0 && joint.damping == 0) {
    node.fail_at_key("stiffness", "is 0, and there is no \"damping\": one of them above 0");
  }
}

void read_limits_and_motor(const Node& node, JointDesc& joint) {
  const Range range = joint.type == JointType::revolute   ? limits::kAngle
                      : joint.type == JointType::distance ? limits::kLength
                                                          : limits::kCoordinate;
  const std::optional<Node> lower = node.find("lower"), upper = node.find("upper");
  if (lower) joint.lower = lower->number(range);
  if (upper) joint.upper = upper->number(range);
  if (lower && upper && *joint.lower > *joint.upper) {
    upper->fail(exact_text(*joint.upper) + " is less than \"lower\", " + exact_text(*joint.lower) +
                ": no less than it");
  }
  joint.motor_speed = node.number_or("motor_speed", joint.motor_speed, limits::kMotorSpeed);
  joint.motor_limit = node.number_or("motor_limit", joint.motor_limit, limits::kMotorLimit);
}

void read_axis(const Node& node, JointDesc& joint) {
  const std::optional<Node> axis = node.find("axis");
  if (!axis) return;
  joint.axis = axis->vec2(limits::kCoordinate);
  if (!limits::kAxis.contains(length_of(joint.axis))) {
    axis->fail("is no direction: [x, y], not both zero");
  }
}

// What a motor or a target asks for.
void read_drive(const Node& node, JointDesc& joint) {
  if (joint.type == JointType::target) {
    const Node at = node.require("target");
    joint.target = at.vec2(limits::kCoordinate);
  } else if ((bits(joint.type) & kRests) != 0) {
    joint.rest = node.number_or("target", joint.rest, limits::kCoordinate);
  }
  joint.linear_velocity = node.vec2_or("linear_velocity", joint.linear_velocity, limits::kMotorSpeed);
  joint.angular_velocity = node.number_or("angular_velocity", joint.angular_velocity, limits::kMotorSpeed);
  joint.force_limit = node.number_or("force_limit", joint.force_limit, limits::kMotorLimit);
  joint.torque_limit = node.number_or("torque_limit", joint.torque_limit, limits::kMotorLimit);
  joint.correction = node.number_or("correction", joint.correction, limits::kCorrection);
  joint.offset = node.vec2_or("offset", joint.offset, limits::kCoordinate);
  joint.linear_stiffness = node.number_or("linear_stiffness", joint.linear_stiffness, limits::kStiffness);
  joint.linear_damping = node.number_or("linear_damping", joint.linear_damping, limits::kJointDamping);
}

// Past which load a joint breaks; above 0 where it is given.
constexpr Range kBreakingLoad{0, limits::kMotorLimit.max, true};

void read_break(const Node& node, JointDesc& joint) {
  if (const std::optional<Node> force = node.find("break_force")) joint.break_force = force->number(kBreakingLoad);
  if (const std::optional<Node> torque = node.find("break_torque")) joint.break_torque = torque->number(kBreakingLoad);
}

void read_membrane(const Node& node, JointDesc& joint) {
  joint.pressure = node.number_or("pressure", joint.pressure, limits::kPressure);
  joint.wind_drag = node.number_or("drag", joint.wind_drag, limits::kWindFactor);
  joint.wind_lift = node.number_or("lift", joint.wind_lift, limits::kWindFactor);
  joint.area = node.number_or("area", joint.area, limits::kArea);
}

void read_pulley(const Node& node, JointDesc& joint) {
  const Node a = node.require("ground_a"), b = node.require("ground_b");
  joint.ground_a = a.vec2(limits::kCoordinate);
  joint.ground_b = b.vec2(limits::kCoordinate);
  joint.ratio = node.number_or("ratio", joint.ratio, limits::kPulleyRatio);
}

// A joint of the list, of those before this one.
std::uint64_t read_part(const Node& node, const Scene& scene) {
  const std::uint64_t k = node.integer(0, kLargestBodyId);
  if (k >= scene.joints.size()) {
    node.fail("no joint " + std::to_string(k) + " before this one: the place in \"joints\" of an earlier one");
  }
  const JointType type = scene.joints[k].joint.type;
  if (type != JointType::revolute && type != JointType::prismatic) {
    node.fail("is a " + std::string(kJointTypes[static_cast<std::size_t>(type)]) + " joint: revolute or prismatic");
  }
  return k;
}

void read_gear(const Node& node, const Scene& scene, SceneJoint& out) {
  const Node a = node.require("joint_a"), b = node.require("joint_b");
  out.joint_a = read_part(a, scene);
  out.joint_b = read_part(b, scene);
  if (out.joint_a == out.joint_b) b.fail("is the joint of \"joint_a\": two different joints");
  out.joint.ratio = node.number_or("ratio", out.joint.ratio, limits::kRatio);
  if (std::fabs(out.joint.ratio) < limits::kPulleyRatio.min)
    node.fail_at_key("ratio", "is too near to 0: 1e-6 at least");
}

void read_sides(const Node& node, const Context& context, const SceneBodies& bodies, SceneJoint& out) {
  const JointType type = out.joint.type;
  const bool world = type != JointType::pulley && type != JointType::filter;
  const Node b = node.require("b");
  out.b = read_side(b, context, world && type != JointType::target);
  out.a = kWorldSide;
  if (type != JointType::target) {
    const Node a = node.require("a");
    out.a = read_side(a, context, world);
  }
  if (out.a == out.b) b.fail("is the body of \"a\": two different bodies");
  const auto moves = [&](std::uint64_t id) { return id != kWorldSide && bodies.type_of(id) == BodyType::dynamic_body; };
  if (!moves(out.a) && !moves(out.b)) {
    b.fail(type == JointType::target ? "is not dynamic: a body that is"
                                     : "is not dynamic, nor is \"a\": at least one that is");
  }
}

SceneJoint read_joint(const Node& node, const Context& context, const SceneBodies& bodies, const Scene& scene) {
  node.expect_object();
  SceneJoint out;
  JointDesc& joint = out.joint;
  const Node type = node.require("type");
  joint.type = static_cast<JointType>(type.one_of(kJointTypes));
  expect_keys(node, kJointKeys, joint.type);
  joint.collide = node.boolean_or("collide", joint.collide);
  read_break(node, joint);
  read_membrane(node, joint);
  if (joint.type == JointType::gear) {
    read_gear(node, scene, out);
    return out;
  }
  read_sides(node, context, bodies, out);
  joint.anchor_a = node.vec2_or("anchor_a", joint.anchor_a, limits::kCoordinate);
  joint.anchor_b = node.vec2_or("anchor_b", joint.anchor_b, limits::kCoordinate);
  const unsigned of_type = bits(joint.type);
  if (of_type & kLengths) read_length(node, joint);
  if (of_type & kSoft) read_softness(node, joint.type, joint);
  if (of_type & kMotors) read_limits_and_motor(node, joint);
  if (of_type & bits(pulley)) read_pulley(node, joint);
  read_drive(node, joint);
  if (const std::optional<Node> reference = node.find("reference")) {
    joint.reference = reference->number(limits::kAngle);
  }
  read_axis(node, joint);
  if (joint.type == JointType::distance && !joint.length) {
    const std::optional<double> apart = bodies.anchor_distance(out);
    if (apart && *apart < kShortestJoint) {
      node.fail(
          "has no length, and its anchors lie on each other: \"length\" above 0, anchors "
          "apart, or type \"revolute\"");
    }
  }
  return out;
}

}  // namespace

void read_joints(const Node& scene, const Context& context, Scene& out) {
  const std::optional<Node> joints = scene.find("joints");
  if (!joints) return;
  joints->expect_array(0, kMostBodiesInGroup);
  const SceneBodies bodies(out);
  out.joints.reserve(joints->size());
  for (std::size_t k = 0; k < joints->size(); ++k) {
    out.joints.push_back(read_joint(joints->element(k), context, bodies, out));
  }
}

std::optional<LinkDesc> read_links(const Node& group_node, const GroupDesc& group) {
  const std::optional<Node> node = group_node.find("links");
  if (!node) return std::nullopt;
  if (group.layout == Layout::random) {
    group_node.fail_at_key("links", "ties neighbours: layout \"lattice\", \"hex\" or \"ring\"");
  }
  if (group.body.type != BodyType::dynamic_body) {
    group_node.fail_at_key("links", "ties dynamic bodies: type \"dynamic\" (\"pin\" holds some)");
  }
  LinkDesc links;
  node->expect_object();
  if (const std::optional<Node> type = node->find("type")) {
    links.type = static_cast<JointType>(type->one_of(kLinkTypes));
  }
  expect_keys(*node, kLinkKeys, links.type);
  if (links.type == JointType::spring) {
    JointDesc spring_of_links;
    read_softness(*node, links.type, spring_of_links);
    links.stiffness = spring_of_links.stiffness;
    links.damping = spring_of_links.damping;
  }
  links.diagonals = node->boolean_or("diagonals", links.diagonals);
  if (links.diagonals && group.layout != Layout::lattice) {
    node->fail_at_key("diagonals", "is for layout \"lattice\": all neighbours of the others are joined");
  }
  if (const std::optional<Node> pin = node->find("pin")) {
    links.pin = static_cast<Pin>(pin->one_of(kPins));
    if (links.pin != Pin::none && group.layout == Layout::ring) {
      pin->fail("is for layout \"lattice\" or \"hex\": a ring has no rows");
    }
  }
  links.collide = node->boolean_or("collide", links.collide);
  if (const std::optional<Node> force = node->find("break_force")) links.break_force = force->number(kBreakingLoad);
  links.pressure = node->number_or("pressure", links.pressure, limits::kPressure);
  links.drag = node->number_or("drag", links.drag, limits::kWindFactor);
  links.lift = node->number_or("lift", links.lift, limits::kWindFactor);
  links.area = node->boolean_or("area", links.area);
  links.bending = node->number_or("bending", links.bending, limits::kStiffness);
  if (links.bending > 0 && !may_bend(group)) node->fail_at_key("bending", kMayBend);
  if (const std::optional<Node> damping = node->find("bending_damping")) {
    links.bending_damping = damping->number(limits::kJointDamping);
    if (!(links.bending > 0)) damping->fail("needs a `bending` above 0");
  }
  const std::string_view encloses = links.area ? "area" : links.pressure != 0 ? "pressure" : "";
  if (!encloses.empty() && group.layout != Layout::ring) {
    node->fail_at_key(encloses, "is for layout \"ring\": nothing else has an inside");
  }
  return links;
}

}  // namespace psim::scene
