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
constexpr std::array<std::string_view, 6> kJointTypes = {"distance", "spring", "rope", "revolute", "prismatic", "weld"};
constexpr std::array<std::string_view, 3> kLinkTypes = {"distance", "spring", "rope"};
constexpr std::array<std::string_view, 5> kPins = {"none", "top", "corners", "left", "ends"};

constexpr unsigned bit(JointType type) { return 1u << static_cast<unsigned>(type); }
constexpr unsigned kAnyType = 0x3Fu;
constexpr unsigned kLengths = bit(JointType::distance) | bit(JointType::spring) | bit(JointType::rope);
constexpr unsigned kSoft = bit(JointType::spring) | bit(JointType::weld);
constexpr unsigned kDriven = bit(JointType::revolute) | bit(JointType::prismatic);
constexpr unsigned kAngled = kDriven | bit(JointType::weld);

// A key and the types of joint that have it.
struct Key {
  std::string_view name;
  unsigned types;
};
constexpr std::array kJointKeys = {Key{"type", kAnyType},      Key{"a", kAnyType},
                                   Key{"b", kAnyType},         Key{"anchor_a", kAnyType},
                                   Key{"anchor_b", kAnyType},  Key{"collide", kAnyType},
                                   Key{"length", kLengths},    Key{"stiffness", kSoft},
                                   Key{"damping", kSoft},      Key{"axis", bit(JointType::prismatic)},
                                   Key{"reference", kAngled},  Key{"lower", kDriven},
                                   Key{"upper", kDriven},      Key{"motor_speed", kDriven},
                                   Key{"motor_limit", kDriven}};
constexpr std::array kLinkKeys = {Key{"type", kAnyType},
                                  Key{"stiffness", bit(JointType::spring)},
                                  Key{"damping", bit(JointType::spring)},
                                  Key{"diagonals", kAnyType},
                                  Key{"pin", kAnyType},
                                  Key{"collide", kAnyType}};

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
    if (key.types & bit(type) || !node.find(key.name)) continue;
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

void read_length(const Node& node, JointDesc& joint) {
  const std::optional<Node> length = node.find("length");
  if (!length) return;
  joint.length = length->number(joint.type == JointType::spring ? limits::kLength : limits::kRodLength);
}

// A spring has a stiffness; a weld may.
void read_softness(const Node& node, JointType type, double& stiffness, double& damping) {
  if (type == JointType::spring) {
    const Node required = node.require("stiffness");
    stiffness = required.number(limits::kStiffness);
  } else {
    stiffness = node.number_or("stiffness", stiffness, limits::kStiffness);
  }
  damping = node.number_or("damping", damping, limits::kJointDamping);
}

void read_limits_and_motor(const Node& node, JointDesc& joint) {
  const Range range = joint.type == JointType::revolute ? limits::kAngle : limits::kCoordinate;
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

SceneJoint read_joint(const Node& node, const Context& context, const SceneBodies& bodies) {
  node.expect_object();
  SceneJoint out;
  JointDesc& joint = out.joint;
  const Node type = node.require("type");
  joint.type = static_cast<JointType>(type.one_of(kJointTypes));
  expect_keys(node, kJointKeys, joint.type);
  const Node a = node.require("a"), b = node.require("b");
  out.a = read_body_id(a, context);
  out.b = read_body_id(b, context);
  if (out.a == out.b) b.fail("is the body of \"a\": two different bodies");
  if (bodies.type_of(out.a) != BodyType::dynamic_body && bodies.type_of(out.b) != BodyType::dynamic_body) {
    b.fail("is not dynamic, nor is \"a\": at least one that is");
  }
  joint.anchor_a = node.vec2_or("anchor_a", joint.anchor_a, limits::kCoordinate);
  joint.anchor_b = node.vec2_or("anchor_b", joint.anchor_b, limits::kCoordinate);
  joint.collide = node.boolean_or("collide", joint.collide);
  const unsigned of_type = bit(joint.type);
  if (of_type & kLengths) read_length(node, joint);
  if (of_type & kSoft) read_softness(node, joint.type, joint.stiffness, joint.damping);
  if (of_type & kDriven) read_limits_and_motor(node, joint);
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
    out.joints.push_back(read_joint(joints->element(k), context, bodies));
  }
}

std::optional<LinkDesc> read_links(const Node& group_node, const GroupDesc& group) {
  const std::optional<Node> node = group_node.find("links");
  if (!node) return std::nullopt;
  if (group.layout == Layout::random) {
    group_node.fail_at_key("links", "ties the neighbours of a grid: layout \"lattice\" or \"hex\"");
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
    read_softness(*node, links.type, links.stiffness, links.damping);
  }
  links.diagonals = node->boolean_or("diagonals", links.diagonals);
  if (links.diagonals && group.layout == Layout::hex) {
    node->fail_at_key("diagonals", "is for layout \"lattice\": all neighbours of \"hex\" are joined");
  }
  if (const std::optional<Node> pin = node->find("pin")) {
    links.pin = static_cast<Pin>(pin->one_of(kPins));
  }
  links.collide = node->boolean_or("collide", links.collide);
  return links;
}

}  // namespace psim::scene
