// joints[] of a scene file. This version simulates none: they are checked and refused.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "parse_limits.h"
#include "parse_parts.h"

namespace psim::scene {
namespace {

constexpr std::array<std::string_view, 6> kTypes = {"distance", "spring", "rope",
                                                    "revolute", "weld",   "prismatic"};
constexpr std::array<std::string_view, 8> kKeys = {"type",     "a",      "b",         "anchor_a",
                                                   "anchor_b", "length", "stiffness", "damping"};

// A body by its name or its id.
void expect_body(const Node& node, const Context& context) {
  if (node.is_number()) {
    const std::uint64_t id = node.integer(0, kLargestBodyId);
    if (id < context.body_count) return;
    node.fail("no body " + std::to_string(id) + ": the name or the id of a body, ids count from 0");
  }
  if (!node.is_string()) node.fail("must be a body's name or id");
  if (context.body_names.contains(node.string())) return;
  node.fail("no body \"" + printable(node.string()) +
            "\": the name or the id of a body, ids count from 0");
}

void read_joint(const Node& joint, const Context& context) {
  joint.expect_object(kKeys);
  const Node type = joint.require("type"), a = joint.require("a"), b = joint.require("b");
  type.one_of(kTypes);
  expect_body(a, context);
  expect_body(b, context);
  if (a.json() == b.json()) b.fail("is the body of \"a\": two different bodies");
  joint.vec2_or("anchor_a", {}, kCoordinate);
  joint.vec2_or("anchor_b", {}, kCoordinate);
  joint.number_or("length", 0, kLength);
  joint.number_or("stiffness", 0, kJointStiffness);
  joint.number_or("damping", 0, kJointDamping);
}

}  // namespace

void read_joints(const Node& scene, Context& context) {
  const std::optional<Node> joints = scene.find("joints");
  if (!joints) return;
  joints->expect_array(0, kMostBodiesInGroup);
  for (std::size_t k = 0; k < joints->size(); ++k) {
    const Node joint = joints->element(k);
    read_joint(joint, context);
    context.availability.uses(Feature::joints, joint);
  }
}

}  // namespace psim::scene
