// Joints and links of scene files: what good ones become, what is said of bad ones and where.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "place/links.h"
#include "place/placement.h"
#include "psim/scene.h"
#include "scene_text.h"

namespace psim::test {
namespace {

// Bodies "a", "b" (id 1), a static "floor" (2), a static "wall" (3), and a group of two (4, 5).
std::string joints_text(std::string_view joints) {
  return scene_text(R"("bodies": [
    {"name": "a", "position": [0, 0], "shape": {"box": {"size": [1, 1]}}},
    {"name": "b", "position": [3, 4], "shape": {"disc": {"radius": 0.5}}},
    {"name": "floor", "position": [0, -9], "type": "static", "shape": {"box": {"size": [9, 1]}}},
    {"name": "wall", "position": [9, 0], "type": "static", "shape": {"box": {"size": [1, 9]}}}],
    "groups": [{"layout": "lattice", "count": 2, "region": [20, 20, 24, 22], "radius": 0.5}],
    "joints": [)" + std::string(joints) +
                    "]");
}

SceneJoint joint_of(std::string_view joint) {
  const Scene scene = parsed_scene(joints_text(joint));
  return scene.joints.empty() ? SceneJoint{} : scene.joints[0];
}

TEST(SceneJoints, AreRead) {
  const SceneJoint rod = joint_of(
      R"({"type": "distance", "a": "a", "b": 4, "anchor_a": [1, 2], "anchor_b": [3, 4], "length": 5,
          "collide": true})");
  EXPECT_EQ(rod.a, 0u);
  EXPECT_EQ(rod.b, 4u);
  EXPECT_EQ(rod.joint.type, JointType::distance);
  EXPECT_EQ(rod.joint.anchor_a.y, 2);
  EXPECT_EQ(rod.joint.anchor_b.x, 3);
  EXPECT_EQ(rod.joint.length, 5);
  EXPECT_TRUE(rod.joint.collide);

  const JointDesc spring =
      joint_of(R"({"type": "spring", "a": "floor", "b": "b", "stiffness": 7, "damping": 2})").joint;
  EXPECT_EQ(spring.type, JointType::spring);
  EXPECT_EQ(spring.stiffness, 7);
  EXPECT_EQ(spring.damping, 2);
  EXPECT_FALSE(spring.length);
  EXPECT_FALSE(spring.collide);

  const JointDesc pin = joint_of(R"({"type": "revolute", "a": 0, "b": 1, "lower": -1, "upper": 2,
      "motor_speed": 3, "motor_limit": 4, "reference": 0.5})")
                            .joint;
  EXPECT_EQ(pin.type, JointType::revolute);
  EXPECT_EQ(pin.lower, -1);
  EXPECT_EQ(pin.upper, 2);
  EXPECT_EQ(pin.motor_speed, 3);
  EXPECT_EQ(pin.motor_limit, 4);
  EXPECT_EQ(pin.reference, 0.5);

  const JointDesc slide = joint_of(R"({"type": "prismatic", "a": 0, "b": 1, "axis": [0, 2]})").joint;
  EXPECT_EQ(slide.type, JointType::prismatic);
  EXPECT_EQ(slide.axis.y, 2);
  EXPECT_FALSE(slide.lower || slide.upper || slide.reference);

  const JointDesc weld = joint_of(R"({"type": "weld", "a": 0, "b": 1, "stiffness": 9, "damping": 1})").joint;
  EXPECT_EQ(weld.type, JointType::weld);
  EXPECT_EQ(weld.stiffness, 9);
  EXPECT_EQ(joint_of(R"({"type": "rope", "a": 5, "b": 4, "length": 3})").joint.type, JointType::rope);
  // Names win over nothing: ids run over bodies, then groups.
  EXPECT_EQ(joint_of(R"({"type": "rope", "a": 5, "b": "b", "length": 3})").a, 5u);
}

TEST(SceneJoints, BadOnesAreRefusedAtTheirPlace) {
  struct Bad {
    std::string_view joint, path, words;
  };
  const Bad all[] = {
      {"3", "joints[0]", "must be an object"},
      {R"({"a": 0, "b": 1})", "joints[0]", "\"type\" is missing"},
      {R"({"type": "hinge", "a": 0, "b": 1})", "joints[0].type", "allowed: \"distance\""},
      {R"({"type": "weld", "a": 0})", "joints[0]", "\"b\" is missing"},
      {R"({"type": "weld", "a": 0, "b": 6})", "joints[0].b", "no body 6"},
      {R"({"type": "weld", "a": "c", "b": 1})", "joints[0].a", "no body \"c\""},
      {R"({"type": "weld", "a": [0], "b": 1})", "joints[0].a", "name or id"},
      {R"({"type": "weld", "a": -1, "b": 1})", "joints[0].a", "out of range"},
      {R"({"type": "weld", "a": 1, "b": 1})", "joints[0].b", "two different bodies"},
      {R"({"type": "weld", "a": "b", "b": 1})", "joints[0].b", "two different bodies"},
      {R"({"type": "weld", "a": 2, "b": "wall"})", "joints[0].b", "at least one that is"},
      {R"({"type": "weld", "a": 0, "b": 1, "anchor_a": 1})", "joints[0].anchor_a", "array of 2"},
      {R"({"type": "weld", "a": 0, "b": 1, "collide": 1})", "joints[0].collide", "true or false"},
      {R"({"type": "weld", "a": 0, "b": 1, "lenght": 1})", "joints[0].lenght", "did you mean \"length\""},
      {R"({"type": "weld", "a": 0, "b": 1, "length": 1})", "joints[0].length",
       "is no key of a weld joint: of \"distance\", \"spring\", \"rope\" or \"pulley\" only"},
      {R"({"type": "rope", "a": 0, "b": 1, "axis": [1, 0]})", "joints[0].axis",
       "is no key of a rope joint: of \"prismatic\" or \"wheel\" only"},
      {R"({"type": "rope", "a": 0, "b": 1, "stiffness": 1})", "joints[0].stiffness", "\"wheel\" or \"target\" only"},
      {R"({"type": "weld", "a": 0, "b": 1, "motor_speed": 1})", "joints[0].motor_speed",
       "of \"distance\", \"revolute\", \"prismatic\" or \"wheel\" only"},
      {R"({"type": "spring", "a": 0, "b": 1, "stiffness": 0})", "joints[0].stiffness", "no \"damping\""},
      {R"({"type": "spring", "a": 0, "b": 1, "stiffness": 1, "frequency": 1})", "joints[0].stiffness",
       "follows from \"frequency\""},
      {R"({"type": "wheel", "a": 0, "b": 1, "damping_ratio": 1})", "joints[0].damping_ratio", "with \"frequency\""},
      {R"({"type": "wheel", "a": 0, "b": 1, "frequency": 0})", "joints[0].frequency", "above 0"},
      {R"({"type": "distance", "a": 0, "b": 1, "lower": -1})", "joints[0].lower", "out of range"},
      {R"({"type": "weld", "a": 0, "b": 1, "break_force": 0})", "joints[0].break_force", "above 0"},
      {R"({"type": "weld", "a": "world", "b": "world"})", "joints[0].b", "two different bodies"},
      {R"({"type": "weld", "a": "world", "b": 2})", "joints[0].b", "at least one that is"},
      {R"({"type": "filter", "a": "world", "b": 1})", "joints[0].a", "is the world: a body"},
      {R"({"type": "target", "b": 2, "target": [0, 0], "stiffness": 1})", "joints[0].b", "a body that is"},
      {R"({"type": "target", "b": "world", "target": [0, 0], "stiffness": 1})", "joints[0].b", "is the world"},
      {R"({"type": "target", "b": 1, "stiffness": 1})", "joints[0]", "\"target\" is missing"},
      {R"({"type": "target", "b": 1, "a": 0, "target": [0, 0], "stiffness": 1})", "joints[0].a",
       "is no key of a target"},
      {R"({"type": "motor", "a": 0, "b": 1, "linear_velocity": [1]})", "joints[0].linear_velocity", "has 1 element"},
      {R"({"type": "motor", "a": 0, "b": 1, "torque_limit": -1})", "joints[0].torque_limit", "out of range"},
      {R"({"type": "pulley", "a": 0, "b": 1, "ground_a": [0, 1]})", "joints[0]", "\"ground_b\" is missing"},
      {R"({"type": "pulley", "a": 0, "b": 1, "ground_a": [0, 1], "ground_b": [1, 1], "ratio": 0})", "joints[0].ratio",
       "out of range"},
      {R"({"type": "gear", "joint_a": 0, "joint_b": 1})", "joints[0].joint_a", "no joint 0 before this one"},
      {R"({"type": "rope", "a": 0, "b": 1}, {"type": "gear", "joint_a": 0, "joint_b": 0})", "joints[1].joint_a",
       "is a rope joint: revolute or prismatic"},
      {R"({"type": "revolute", "a": 0, "b": 1}, {"type": "gear", "joint_a": 0, "joint_b": 0})", "joints[1].joint_b",
       "two different joints"},
      {R"({"type": "revolute", "a": 0, "b": 1}, {"type": "revolute", "a": 0, "b": 2},
          {"type": "gear", "joint_a": 0, "joint_b": 1, "ratio": 1e-9})",
       "joints[2].ratio", "1e-6 at least"},
      {R"({"type": "spring", "a": 0, "b": 1, "reference": 1, "stiffness": 1})", "joints[0].reference",
       "is no key of a spring"},
      {R"({"type": "spring", "a": 0, "b": 1})", "joints[0]", "\"stiffness\" is missing"},
      {R"({"type": "spring", "a": 0, "b": 1, "stiffness": -1})", "joints[0].stiffness", "out of range"},
      {R"({"type": "spring", "a": 0, "b": 1, "stiffness": 1, "damping": "x"})", "joints[0].damping",
       "must be a number"},
      {R"({"type": "distance", "a": 0, "b": 1, "length": 0})", "joints[0].length", "above 0"},
      {R"({"type": "rope", "a": 0, "b": 1, "length": 0})", "joints[0].length", "above 0"},
      {R"({"type": "distance", "a": 0, "b": 1, "anchor_a": [3, 4]})", "joints[0]", "anchors lie on each other"},
      {R"({"type": "revolute", "a": 0, "b": 1, "lower": 1, "upper": 0.5})", "joints[0].upper", "less than \"lower\""},
      {R"({"type": "revolute", "a": 0, "b": 1, "lower": 1e10})", "joints[0].lower", "out of range"},
      {R"({"type": "prismatic", "a": 0, "b": 1, "axis": [0, 0]})", "joints[0].axis", "is no direction"},
      {R"({"type": "prismatic", "a": 0, "b": 1, "axis": [1]})", "joints[0].axis", "has 1 element"},
      {R"({"type": "prismatic", "a": 0, "b": 1, "motor_limit": -1})", "joints[0].motor_limit", "out of range"}};
  for (const Bad& bad : all) expect_refused(joints_text(bad.joint), bad.path, bad.words);
}

TEST(SceneJoints, ReadBackFromTheirText) {
  const Scene scene = parsed_scene(joints_text(R"(
    {"type": "distance", "a": 0, "b": 1, "anchor_a": [0.1, 0], "length": 0.3, "collide": true},
    {"type": "spring", "a": 0, "b": 1, "length": 0, "stiffness": 0.7, "damping": 0.1},
    {"type": "rope", "a": 0, "b": 1, "anchor_b": [0, 0.1]},
    {"type": "revolute", "a": 0, "b": 1, "reference": 0, "lower": -0.1, "upper": 0,
     "motor_speed": -1, "motor_limit": 2},
    {"type": "prismatic", "a": 0, "b": 1, "axis": [0.1, 1], "upper": 1e-3},
    {"type": "weld", "a": 0, "b": 1, "stiffness": 3, "damping": 0.2},
    {"type": "wheel", "a": "world", "b": 1, "axis": [0, 1], "frequency": 3, "damping_ratio": 0.5, "lower": -1},
    {"type": "motor", "a": 0, "b": 1, "linear_velocity": [1, 2], "angular_velocity": 3, "force_limit": 4,
     "torque_limit": 5, "break_force": 6, "break_torque": 7},
    {"type": "target", "b": 1, "target": [1, 2], "stiffness": 3, "force_limit": 4},
    {"type": "pulley", "a": 0, "b": 1, "ground_a": [1, 2], "ground_b": [3, 4], "ratio": 2, "length": 9},
    {"type": "revolute", "a": 0, "b": 1, "stiffness": 2, "damping": 1, "target": 0.5},
    {"type": "gear", "joint_a": 3, "joint_b": 4, "ratio": -2},
    {"type": "filter", "a": 0, "b": 1},
    {"type": "distance", "a": 0, "b": "world", "anchor_b": [0, 3], "lower": 1, "upper": 2, "motor_speed": 3, "motor_limit": 4})"));
  const std::string text = scene_to_json(scene);
  const Scene again = parsed_scene(text);
  EXPECT_EQ(scene_to_json(again), text);
  ASSERT_EQ(again.joints.size(), 14u);
  EXPECT_EQ(again.joints[6].a, kWorldSide);
  EXPECT_EQ(again.joints[13].b, kWorldSide);
  for (std::size_t k = 0; k < 14; ++k) {
    const JointDesc &p = scene.joints[k].joint, &q = again.joints[k].joint;
    EXPECT_EQ(again.joints[k].a, scene.joints[k].a);
    EXPECT_EQ(again.joints[k].b, scene.joints[k].b);
    EXPECT_EQ(again.joints[k].joint_a, scene.joints[k].joint_a);
    EXPECT_EQ(again.joints[k].joint_b, scene.joints[k].joint_b);
    EXPECT_EQ(p.frequency, q.frequency);
    EXPECT_EQ(p.damping_ratio, q.damping_ratio);
    EXPECT_EQ(p.target.y, q.target.y);
    EXPECT_EQ(p.rest, q.rest);
    EXPECT_EQ(p.linear_velocity.y, q.linear_velocity.y);
    EXPECT_EQ(p.angular_velocity, q.angular_velocity);
    EXPECT_EQ(p.force_limit, q.force_limit);
    EXPECT_EQ(p.torque_limit, q.torque_limit);
    EXPECT_EQ(p.ground_a.x, q.ground_a.x);
    EXPECT_EQ(p.ground_b.y, q.ground_b.y);
    EXPECT_EQ(p.ratio, q.ratio);
    EXPECT_EQ(p.break_force, q.break_force);
    EXPECT_EQ(p.break_torque, q.break_torque);
    EXPECT_EQ(p.type, q.type);
    EXPECT_EQ(p.anchor_a.x, q.anchor_a.x);
    EXPECT_EQ(p.anchor_b.y, q.anchor_b.y);
    EXPECT_EQ(p.length, q.length);
    EXPECT_EQ(p.stiffness, q.stiffness);
    EXPECT_EQ(p.damping, q.damping);
    EXPECT_EQ(p.axis.x, q.axis.x);
    EXPECT_EQ(p.reference, q.reference);
    EXPECT_EQ(p.lower, q.lower);
    EXPECT_EQ(p.upper, q.upper);
    EXPECT_EQ(p.motor_speed, q.motor_speed);
    EXPECT_EQ(p.motor_limit, q.motor_limit);
    EXPECT_EQ(p.collide, q.collide);
  }
}

// ---- links ----------------------------------------------------------------------------------------

std::string linked_text(std::string_view layout, int count, std::string_view region, std::string_view links) {
  return scene_text("\"groups\": [{\"layout\": \"" + std::string(layout) +
                    "\", \"radius\": 0.25, \"count\": " + std::to_string(count) +
                    ", \"region\": " + std::string(region) + ", \"links\": " + std::string(links) + "}]");
}

std::set<std::pair<std::uint64_t, std::uint64_t>> pairs_of(const Scene& scene) {
  std::set<std::pair<std::uint64_t, std::uint64_t>> pairs;
  for (const SceneJoint& joint : all_joints(scene)) {
    EXPECT_TRUE(pairs.emplace(joint.a, joint.b).second) << joint.a << ' ' << joint.b;
  }
  return pairs;
}

TEST(SceneLinks, AreRead) {
  const Scene scene = parsed_scene(linked_text("lattice", 6, "[0, 0, 3, 2]",
                                               R"({"type": "spring", "stiffness": 5, "damping": 1,
                                                   "diagonals": true, "pin": "corners",
                                                   "break_force": 7})"));
  ASSERT_TRUE(scene.groups.at(0).links);
  const LinkDesc& links = *scene.groups[0].links;
  EXPECT_EQ(links.type, JointType::spring);
  EXPECT_EQ(links.stiffness, 5);
  EXPECT_EQ(links.damping, 1);
  EXPECT_TRUE(links.diagonals);
  EXPECT_EQ(links.pin, Pin::corners);
  EXPECT_FALSE(links.collide);
  EXPECT_EQ(links.break_force, 7);
  for (const SceneJoint& joint : all_joints(scene)) EXPECT_EQ(joint.joint.break_force, 7);
  const Scene again = parsed_scene(scene_to_json(scene));
  EXPECT_EQ(scene_to_json(again), scene_to_json(scene));
  EXPECT_EQ(again.groups.at(0).links->stiffness, 5);
  EXPECT_EQ(again.groups.at(0).links->pin, Pin::corners);
  EXPECT_EQ(again.groups.at(0).links->break_force, 7);
  EXPECT_EQ(parsed_scene(linked_text("hex", 4, "[0, 0, 9, 9]", "{}")).groups[0].links->type, JointType::distance);
}

TEST(SceneLinks, OfARowOrRingMayBend) {
  const Scene scene = parsed_scene(linked_text("lattice", 4, "[0, 0, 8, 1]", R"({"bending": 5})"));
  ASSERT_EQ(all_joints(scene).size(), 3u);
  for (const SceneJoint& joint : all_joints(scene)) {
    EXPECT_EQ(joint.joint.type, JointType::weld);
    EXPECT_EQ(joint.joint.stiffness, 5);
    EXPECT_EQ(joint.joint.damping, 5e-3);
  }
  const Scene damped = parsed_scene(linked_text("ring", 6, "[0, 0, 9, 9]", R"({"bending": 5, "bending_damping": 0})"));
  const Scene again = parsed_scene(scene_to_json(damped));
  EXPECT_EQ(again.groups.at(0).links->bending, 5);
  EXPECT_EQ(again.groups.at(0).links->bending_damping, 0.0);
  EXPECT_EQ(all_joints(again).at(5).joint.damping, 0);
  EXPECT_EQ(scene_to_json(again), scene_to_json(damped));
}

// Each link of a ring has its share of the area, also if the ring is an ellipse.
TEST(SceneLinks, OfARingMayBeMembranes) {
  const Scene scene =
      parsed_scene(linked_text("ring", 6, "[0, 0, 9, 5]", R"({"pressure": 3, "drag": 0.5, "lift": 2, "area": true})"));
  double area = 0;
  for (const SceneJoint& joint : all_joints(scene)) {
    EXPECT_EQ(joint.joint.pressure, 3);
    EXPECT_EQ(joint.joint.wind_drag, 0.5);
    EXPECT_EQ(joint.joint.wind_lift, 2);
    area += joint.joint.area;
  }
  EXPECT_NEAR(area, 1.5 * std::sqrt(3.0) * 4.5 * 2.5, 1e-12);
  const Scene again = parsed_scene(scene_to_json(scene));
  EXPECT_EQ(scene_to_json(again), scene_to_json(scene));
  const LinkDesc& links = *again.groups.at(0).links;
  EXPECT_EQ(links.pressure, 3);
  EXPECT_EQ(links.drag, 0.5);
  EXPECT_EQ(links.lift, 2);
  EXPECT_TRUE(links.area);
}

TEST(SceneLinks, JoinNeighboursOfALattice) {
  // 3 columns, 2 rows:  3 4 5
  //                     0 1 2
  using Pairs = std::set<std::pair<std::uint64_t, std::uint64_t>>;
  const Pairs sides{{0, 1}, {1, 2}, {3, 4}, {4, 5}, {0, 3}, {1, 4}, {2, 5}};
  EXPECT_EQ(pairs_of(parsed_scene(linked_text("lattice", 6, "[0, 0, 3, 2]", "{}"))), sides);
  Pairs all = sides;
  all.insert({{0, 4}, {1, 3}, {1, 5}, {2, 4}});
  EXPECT_EQ(pairs_of(parsed_scene(linked_text("lattice", 6, "[0, 0, 3, 2]", R"({"diagonals": true})"))), all);
  // A row that is not full.
  const Pairs five{{0, 1}, {1, 2}, {3, 4}, {0, 3}, {1, 4}};
  EXPECT_EQ(pairs_of(parsed_scene(linked_text("lattice", 5, "[0, 0, 3, 2]", "{}"))), five);
}

// Each with its neighbours in the row and the two nearest of the rows above and below.
TEST(SceneLinks, JoinTheSixNearestOfAHexLattice) {
  const Scene scene = parsed_scene(linked_text("hex", 60, "[0, 0, 8.5, 6]", "{}"));
  std::string error;
  const auto placed = place_group(scene.groups[0], error);
  ASSERT_TRUE(placed) << error;
  const LatticePlan plan = plan_lattice(60, scene.groups[0].region, true);
  std::set<std::pair<std::uint64_t, std::uint64_t>> expected;
  for (std::uint64_t i = 0; i < 60; ++i) {
    for (std::uint64_t j = i + 1; j < 60; ++j) {
      const double dx = std::fabs(placed->x[i] - placed->x[j]) / plan.cell_x;
      const double dy = std::fabs(placed->y[i] - placed->y[j]) / plan.cell_y;
      if ((dy < 0.1 && dx < 1.1) || (dy < 1.1 && dx < 0.6)) expected.emplace(i, j);
    }
  }
  EXPECT_EQ(pairs_of(scene), expected);
}

TEST(SceneLinks, OfARingCloseIt) {
  using Pairs = std::set<std::pair<std::uint64_t, std::uint64_t>>;
  const auto of = [](int count) { return pairs_of(parsed_scene(linked_text("ring", count, "[0, 0, 9, 9]", "{}"))); };
  EXPECT_EQ(of(4), (Pairs{{0, 1}, {1, 2}, {2, 3}, {3, 0}}));
  EXPECT_EQ(of(2), (Pairs{{0, 1}}));
  EXPECT_EQ(of(1), Pairs{});
  EXPECT_EQ(of(0), Pairs{});
  const Scene scene = parsed_scene(linked_text("ring", 5, "[0, 0, 9, 9]", "{}"));
  EXPECT_EQ(scene_to_json(parsed_scene(scene_to_json(scene))), scene_to_json(scene));
}

TEST(SceneLinks, PinsMakeStaticBodiesWithoutJointsBetweenThem) {
  const auto pinned = [](std::string_view pin) {
    const Scene scene =
        parsed_scene(linked_text("lattice", 6, "[0, 0, 3, 2]", "{\"pin\": \"" + std::string(pin) + "\"}"));
    const SceneBodies bodies(scene);
    std::string ids;
    for (std::uint64_t k = 0; k < 6; ++k) {
      if (bodies.type_of(k) == BodyType::static_body) ids += std::to_string(k);
    }
    for (const auto& [a, b] : pairs_of(scene)) {
      EXPECT_FALSE(bodies.type_of(a) == BodyType::static_body && bodies.type_of(b) == BodyType::static_body);
    }
    return ids;
  };
  EXPECT_EQ(pinned("none"), "");
  EXPECT_EQ(pinned("top"), "345");
  EXPECT_EQ(pinned("corners"), "35");
  EXPECT_EQ(pinned("left"), "03");
  EXPECT_EQ(pinned("ends"), "0235");
}

TEST(SceneLinks, BadOnesAreRefused) {
  const auto refused = [](std::string_view layout, std::string_view links, std::string_view path,
                          std::string_view words) {
    expect_refused(linked_text(layout, 4, "[0, 0, 9, 9]", links), path, words);
  };
  refused("lattice", "true", "groups[0].links", "must be an object");
  refused("lattice", R"({"type": "weld"})", "groups[0].links.type", "\"rope\"");
  refused("lattice", R"({"type": "spring"})", "groups[0].links", "\"stiffness\" is missing");
  refused("lattice", R"({"stiffness": 1})", "groups[0].links.stiffness", "of \"spring\" only");
  refused("lattice", R"({"pin": "bottom"})", "groups[0].links.pin", "\"corners\"");
  refused("lattice", R"({"length": 1})", "groups[0].links.length", "unknown key");
  refused("hex", R"({"diagonals": true})", "groups[0].links.diagonals", "layout \"lattice\"");
  refused("ring", R"({"diagonals": true})", "groups[0].links.diagonals", "layout \"lattice\"");
  refused("ring", R"({"pin": "top"})", "groups[0].links.pin", "layout \"lattice\" or \"hex\"");
  refused("lattice", R"({"break_force": 0})", "groups[0].links.break_force", "above 0");
  refused("lattice", R"({"pressure": 1})", "groups[0].links.pressure", "layout \"ring\"");
  refused("hex", R"({"area": true})", "groups[0].links.area", "layout \"ring\"");
  refused("ring", R"({"pressure": 1e13})", "groups[0].links.pressure", "1e12");
  refused("lattice", R"({"bending": 1})", "groups[0].links.bending", "a ring, or a single row or column");
  refused("ring", R"({"bending": -1})", "groups[0].links.bending", "0 to 1e12");
  refused("ring", R"({"type": "rope", "bending": 1})", "groups[0].links.bending", "of \"distance\" only");
  refused("ring", R"({"bending_damping": 1})", "groups[0].links.bending_damping", "`bending` above 0");
  refused("ring", R"({"area": 1})", "groups[0].links.area", "true or false");
  refused("ring", R"({"drag": -1})", "groups[0].links.drag", "0 to 1000");
  refused("ring", R"({"lift": 1001})", "groups[0].links.lift", "0 to 1000");
  refused("random", "{}", "groups[0].links", "layout \"lattice\", \"hex\" or \"ring\"");
  expect_refused(scene_text(R"("groups": [{"layout": "lattice", "count": 1, "region": [0, 0, 9, 9],
    "radius": 1, "type": "static", "links": {}}])"),
                 "groups[0].links", "dynamic bodies");
  expect_refused(scene_text(R"("groups": [{"layout": "explicit", "x": [1], "y": [1], "radius": 1,
    "links": {}}])"),
                 "groups[0].links", "unknown key");
}

TEST(SceneLinks, AJointMayNotTieTwoPinnedBodies) {
  expect_refused(scene_text(R"("groups": [{"layout": "lattice", "count": 4, "region": [0, 0, 4, 1],
    "radius": 0.25, "links": {"pin": "ends"}}], "joints": [{"type": "weld", "a": 0, "b": 3}])"),
                 "joints[0].b", "at least one that is");
}

// ---- --check --------------------------------------------------------------------------------------

TEST(SceneJointsCheck, SaysWhatWillGoWrong) {
  EXPECT_EQ(check_lines(joints_text(R"({"type": "distance", "a": 0, "b": 1, "length": 5})")), "");
  const auto says = [](std::string_view joint, std::string_view words) {
    const std::string lines = check_lines(joints_text(joint));
    EXPECT_NE(lines.find(words), std::string::npos) << lines;
  };
  says(R"({"type": "distance", "a": "a", "b": 1, "length": 4})",
       "joints[0] (distance of \"a\" and \"b\"): the anchors are 5 m apart");
  says(R"({"type": "rope", "a": 0, "b": 1, "length": 4})", "length is 4 m");
  says(R"({"type": "revolute", "a": 0, "b": 1})", "pulled together");
  says(R"({"type": "revolute", "a": 0, "b": 1, "anchor_a": [3, 4], "motor_speed": 1})",
       "motor_speed without motor_limit");
  says(R"({"type": "spring", "a": 0, "b": 1, "stiffness": 1e6})", "stiffness at most");
  EXPECT_EQ(check_lines(joints_text(R"({"type": "rope", "a": 0, "b": 1, "length": 6})")), "");
  EXPECT_EQ(check_lines(joints_text(R"({"type": "spring", "a": 0, "b": 1, "stiffness": 10})")), "");
}

TEST(SceneJointsCheck, TiedBodiesMayOverlap) {
  const auto text = [](std::string_view joint) {
    return scene_text(R"("bodies": [{"position": [0, 0], "shape": {"disc": {"radius": 1}}},
      {"position": [1, 0], "shape": {"disc": {"radius": 1}}}], "joints": [{"type": "revolute",
      "a": 0, "b": 1, "anchor_a": [1, 0])" +
                      std::string(joint) + "}]");
  };
  EXPECT_EQ(check_lines(text("")), "");
  EXPECT_NE(check_lines(text(R"(, "collide": true)")).find("overlap"), std::string::npos);
}

}  // namespace
}  // namespace psim::test
