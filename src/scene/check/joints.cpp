// What would go wrong with the joints of a scene.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "check/rules.h"
#include "number_text.h"
#include "place/links.h"
#include "place/shape_size.h"

namespace psim {
namespace {

// Of the size of the smaller body: anchors of a pin that lie further apart are pulled together
// visibly.
constexpr double kApart = 0.05;
// A spring whose swing is shorter than so many substeps is softer than it says.
constexpr double kSubstepsASwing = 6;

constexpr const char* kNames[] = {"distance", "spring", "rope",   "revolute", "prismatic", "weld",
                                  "wheel",    "motor",  "target", "gear",     "pulley",    "filter"};

bool is_spring(const JointDesc& joint) {
  return joint.type == JointType::spring || (joint.type == JointType::distance && joint.stiffness > 0);
}

std::string joint_name(const Scene& scene, const SceneJoint& joint, std::size_t k) {
  const auto body = [&](std::uint64_t id) {
    if (id == kWorldSide) return std::string("the world");
    const bool named = id < scene.body_names.size() && !scene.body_names[id].empty();
    return named ? '"' + scene.body_names[id] + '"' : std::to_string(id);
  };
  return "joints[" + std::to_string(k) + "] (" + kNames[static_cast<std::size_t>(joint.joint.type)] + " of " +
         body(joint.a) + " and " + body(joint.b) + ")";
}

double size_of(const SceneBodies& bodies, std::uint64_t id) {
  return id == kWorldSide ? HUGE_VAL : bounding_radius(bodies.desc_of(id).shape);
}

// Anchors that a joint wants nearer than they are.
void check_anchors(const Scene& scene, const SceneBodies& bodies, std::size_t k, Lines& lines) {
  const SceneJoint& joint = scene.joints[k];
  const JointType type = joint.joint.type;
  const std::optional<double> apart = bodies.anchor_distance(joint);
  if (!apart) return;
  const double size = std::min(size_of(bodies, joint.a), size_of(bodies, joint.b));
  const std::string name = joint_name(scene, joint, k);
  if (type == JointType::revolute || type == JointType::weld) {
    if (*apart > kApart * size) {
      lines.push_back(name + ": the anchors are " + number_text(*apart) +
                      " m apart at the start, and will be pulled together; move anchor_a, anchor_b "
                      "or position");
    }
  } else if (joint.joint.length && (type == JointType::rope || is_rigid_rod(joint.joint))) {
    const double over = *apart - *joint.joint.length;
    const double wrong = type == JointType::rope ? over : std::fabs(over);
    if (wrong > kApart * size) {
      lines.push_back(name + ": the anchors are " + number_text(*apart) + " m apart at the start, and length is " +
                      number_text(*joint.joint.length) +
                      " m: they will be pulled there at once; move position or change length");
    }
  }
}

void check_motor(const Scene& scene, std::size_t k, Lines& lines) {
  const SceneJoint& joint = scene.joints[k];
  if (joint.joint.motor_speed == 0 || joint.joint.motor_limit > 0) return;
  lines.push_back(joint_name(scene, joint, k) +
                  ": motor_speed without motor_limit does nothing; give motor_limit, the most " +
                  (joint.joint.type == JointType::revolute || joint.joint.type == JointType::wheel ? "torque in N m"
                                                                                                   : "force in N"));
}

// Mass of every body that moves, by id, for look-up only; infinite for the others.
std::unordered_map<std::uint64_t, double> masses(const Survey& survey) {
  std::unordered_map<std::uint64_t, double> all;
  for (const PlacedBody& body : survey.bodies) {
    if (body.moves) all[body.id] = survey.owners[body.owner].mass_min;
  }
  return all;
}

void check_spring(const Scene& scene, const std::unordered_map<std::uint64_t, double>& mass, const SceneJoint& joint,
                  const std::string& name, Lines& lines) {
  const double stiffness = joint.joint.stiffness;
  double inverse = 0;
  for (const std::uint64_t id : {joint.a, joint.b}) {
    const auto found = mass.find(id);
    if (found != mass.end() && found->second > 0) inverse += 1 / found->second;
  }
  const double h = scene.world.dt / scene.world.substeps;
  const double swing = 2 * std::numbers::pi / std::sqrt(stiffness * inverse);
  if (!(swing < kSubstepsASwing * h)) return;
  const double fastest = 2 * std::numbers::pi / (kSubstepsASwing * h), soft = fastest * fastest / inverse;
  lines.push_back(name + ": stiffness " + number_text(stiffness) + " N/m on " + number_text(1 / inverse) +
                  " kg swings in " + number_text(swing) + " s, less than " + number_text(kSubstepsASwing) +
                  " substeps of " + number_text(h) + " s: it will be softer than that; make stiffness at most " +
                  round_down_text(soft) + " N/m, or step.substeps more");
}

}  // namespace

bool is_rigid_rod(const JointDesc& joint) {
  return joint.type == JointType::distance && !joint.frequency && joint.stiffness == 0 && joint.damping == 0 &&
         !joint.lower && !joint.upper && joint.motor_limit == 0;
}

void check_joints(const Scene& scene, const Survey& survey, Lines& lines) {
  if (!survey.misplaced.empty()) return;  // ids behind those are not known
  const SceneBodies bodies(scene);
  const bool springs =
      std::ranges::any_of(scene.joints, [](const SceneJoint& joint) { return is_spring(joint.joint); });
  const auto mass = springs ? masses(survey) : std::unordered_map<std::uint64_t, double>();
  for (std::size_t k = 0; k < scene.joints.size(); ++k) {
    const SceneJoint& joint = scene.joints[k];
    check_anchors(scene, bodies, k, lines);
    check_motor(scene, k, lines);
    if (is_spring(joint.joint)) {
      check_spring(scene, mass, joint, joint_name(scene, joint, k), lines);
    }
  }
  for (std::size_t k = 0; k < scene.groups.size(); ++k) {
    const auto& links = scene.groups[k].links;
    if (!links || links->type != JointType::spring || scene.groups[k].count < 2) continue;
    SceneJoint link;  // between two bodies of the lightest mass, by ids that stand for them
    link.a = 0;
    link.b = 1;
    link.joint.stiffness = links->stiffness;
    const double lightest = survey.owners[scene.bodies.size() + k].mass_min;
    check_spring(scene, {{0, lightest}, {1, lightest}}, link, "groups[" + std::to_string(k) + "].links", lines);
  }
}

MayOverlap jointed_pairs(const Scene& scene) {
  const auto key = [](std::uint64_t a, std::uint64_t b) { return std::min(a, b) << 32 | std::max(a, b); };
  auto pairs = std::make_shared<std::unordered_set<std::uint64_t>>();
  for (const SceneJoint& joint : all_joints(scene)) {
    if (!joint.joint.collide && joint.joint.type != JointType::gear) pairs->insert(key(joint.a, joint.b));
  }
  return [pairs, key](std::uint32_t a, std::uint32_t b) { return pairs->contains(key(a, b)); };
}

}  // namespace psim
