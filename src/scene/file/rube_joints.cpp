// Joints of a R.U.B.E. scene.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/rotor.h"
#include "file/parse_limits.h"
#include "file/rube.h"
#include "place/links.h"

namespace psim::scene {
namespace {

constexpr double kTwoPi = 6.283185307179586;

enum class Kind : std::uint8_t {
  revolute,
  distance,
  prismatic,
  weld,
  rope,
  wheel,
  friction,
  motor,
  gear,
  pulley,
  mouse
};
constexpr std::array<std::string_view, 11> kKinds = {"revolute", "distance", "prismatic", "weld",   "rope", "wheel",
                                                     "friction", "motor",    "gear",      "pulley", "mouse"};

const RubeBody& body_of(const Node& joint, std::string_view key, const std::vector<RubeBody>& bodies) {
  const Node node = joint.require(key);
  const std::uint64_t number = node.integer(0, kLargestBodyId);
  if (number >= bodies.size()) {
    node.fail("no body " + std::to_string(number) + ": an index of \"body\", which has " +
              std::to_string(bodies.size()));
  }
  return bodies[number];
}

// Parallel: 1/m = 1/a + 1/b, where 0 stands for what does not move.
double reduced(double a, double b) {
  const double inverse = (a > 0 ? 1 / a : 0) + (b > 0 ? 1 / b : 0);
  return inverse > 0 ? 1 / inverse : 0;
}

// stiffness = m (2 pi f)^2, damping = 2 m zeta 2 pi f.
void soften(const Node& node, double mass, JointDesc& joint, std::string_view frequency = "frequency",
            std::string_view damping = "dampingRatio") {
  const double rate = kTwoPi * rube_number_or(node, frequency, 0, {0, 1e6});
  const double ratio = rube_number_or(node, damping, 0, {0, 1e6});
  joint.stiffness = mass * rate * rate;
  joint.damping = 2 * mass * ratio * rate;
}

void read_limits_and_motor(const Node& node, Range range, std::string_view limit, JointDesc& joint) {
  if (node.boolean_or("enableLimit", false)) {
    joint.lower = rube_number_or(node, "lowerLimit", 0, range);
    joint.upper = rube_number_or(node, "upperLimit", 0, range);
    if (*joint.lower > *joint.upper) node.fail("lowerLimit is above upperLimit: no more than it");
  }
  if (node.boolean_or("enableMotor", false)) {
    joint.motor_speed = rube_number_or(node, "motorSpeed", 0, limits::kMotorSpeed);
    joint.motor_limit = rube_number_or(node, limit, 0, limits::kMotorLimit);
  }
}

void read_rube_axis(const Node& node, JointDesc& joint) {
  joint.axis = rube_vec2_or(node, "localAxisA", joint.axis, limits::kCoordinate);
  if (!(length_of(joint.axis) > 1e-9)) {
    node.fail_at_key("localAxisA", "is no direction: x and y, not both zero");
  }
}

void read_kind(const Node& node, Kind kind, const RubeBody& a, const RubeBody& b, JointDesc& joint) {
  switch (kind) {
    case Kind::revolute:
      joint.type = JointType::revolute;
      joint.reference = rube_number_or(node, "refAngle", 0, limits::kAngle);
      read_limits_and_motor(node, limits::kAngle, "maxMotorTorque", joint);
      break;
    case Kind::wheel:
      joint.type = JointType::wheel;
      read_rube_axis(node, joint);
      read_limits_and_motor(node, limits::kCoordinate, "maxMotorTorque", joint);
      soften(node, reduced(a.mass, b.mass), joint, "springFrequency", "springDampingRatio");
      break;
    case Kind::friction:  // drives to rest with what it has
      joint.type = JointType::motor;
      joint.force_limit = rube_number_or(node, "maxForce", 0, limits::kMotorLimit);
      joint.torque_limit = rube_number_or(node, "maxTorque", 0, limits::kMotorLimit);
      break;
    case Kind::prismatic:
      joint.type = JointType::prismatic;
      joint.reference = rube_number_or(node, "refAngle", 0, limits::kAngle);
      read_rube_axis(node, joint);
      read_limits_and_motor(node, limits::kCoordinate, "maxMotorForce", joint);
      break;
    case Kind::weld:
      joint.type = JointType::weld;
      joint.reference = rube_number_or(node, "refAngle", 0, limits::kAngle);
      soften(node, reduced(a.inertia, b.inertia), joint);
      break;
    case Kind::rope:
      joint.type = JointType::rope;
      joint.length = rube_number(node.require("maxLength"), limits::kRodLength);
      break;
    default:
      joint.type = JointType::distance;
      joint.length = rube_number(node.require("length"), limits::kRodLength);
      soften(node, reduced(a.mass, b.mass), joint);
      if (joint.stiffness > 0) joint.type = JointType::spring;
      break;
  }
}

}  // namespace

void read_rube_joints(const Node& root, const std::vector<RubeBody>& bodies, Scene& scene) {
  const auto joints = root.find("joint");
  if (!joints) return;
  joints->expect_array(0, kMostBodiesInGroup);
  for (std::size_t k = 0; k < joints->size(); ++k) {
    const Node node = joints->element(k);
    const std::string path = path_text(node.path());
    node.expect_object();
    const Node type = node.require("type");
    const auto kind = static_cast<Kind>(type.one_of(kKinds));
    if (kind > Kind::friction) {
      scene.notes.push_back(path + ": a " + type.string() + " joint is left out");
      continue;
    }
    const RubeBody &a = body_of(node, "bodyA", bodies), &b = body_of(node, "bodyB", bodies);
    if (&a == &b) node.fail_at_key("bodyB", "is bodyA: two different bodies");
    if (a.type != BodyType::dynamic_body && b.type != BodyType::dynamic_body) {
      scene.notes.push_back(path + ": joins two bodies, neither of them dynamic, and is left out");
      continue;
    }
    SceneJoint out;
    out.a = a.id;
    out.b = b.id;
    out.joint.anchor_a = rube_vec2_or(node, "anchorA", {}, limits::kCoordinate);
    out.joint.anchor_b = rube_vec2_or(node, "anchorB", {}, limits::kCoordinate);
    out.joint.collide = node.boolean_or("collideConnected", false);
    read_kind(node, kind, a, b, out.joint);
    scene.joints.push_back(out);
  }
}

}  // namespace psim::scene
