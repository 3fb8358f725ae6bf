// Scenes of the R.U.B.E. editor: what its bodies, fixtures and joints become, and what is said of bad
// ones.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <variant>

#include "psim/scene.h"
#include "scene_text.h"

namespace psim::test {
namespace {

// As the editor writes it: zero vectors are 0, keys at their default are left out, floats may be hex.
constexpr std::string_view kCar = R"({
  "allowSleep": true, "autoClearForces": true, "continuousPhysics": true, "subStepping": false,
  "gravity": {"x": 0, "y": -9.5}, "stepsPerSecond": 50.0,
  "positionIterations": 3, "velocityIterations": 8, "warmStarting": true,
  "image": [], "collisionbitplanes": {"names": ["a"]},
  "body": [
    {"name": "ground", "type": 0, "position": 0, "angle": 0, "linearVelocity": 0,
     "fixture": [
       {"name": "f", "friction": 0.5, "chain": {"vertices": {"x": [-10, 0, 10], "y": [1, 0, 1]}}},
       {"friction": 0.25, "filter-categoryBits": 4, "filter-maskBits": 3, "filter-groupIndex": -2,
        "polygon": {"vertices": {"x": [20, 22, 21], "y": [0, 0, 2]}}}]},
    {"name": "car", "type": 2, "position": {"x": 1, "y": 5}, "angle": 0.5, "bullet": true,
     "linearVelocity": {"x": 3, "y": 4}, "angularVelocity": 2, "linearDamping": 0.5, "awake": true,
     "massData-mass": 6, "massData-I": 7,
     "fixture": [
       {"density": 2, "restitution": 0.125,
        "polygon": {"vertices": {"x": [-1, 1, 1, -1], "y": [-0.5, -0.5, 0.5, 0.5]}}},
       {"density": 2, "polygon": {"vertices": {"x": [1, 3, 3, 1], "y": [-0.5, -0.5, 0.5, 0.5]}}}]},
    {"name": "wheel", "type": 2, "position": {"x": "3F800000", "y": 4},
     "fixture": [{"density": 1, "circle": {"center": 0, "radius": 0.5}}]},
    {"name": "wheel", "type": 2, "position": {"x": 2, "y": 4}, "fixedRotation": true,
     "fixture": [{"density": 1, "circle": {"center": {"x": 1, "y": 0}, "radius": 0.5}}]},
    {"type": 1, "position": {"x": -5, "y": 9}, "angularVelocity": 1,
     "fixture": [{"sensor": true, "circle": {"center": {"x": 1, "y": 0}, "radius": 0.5}}]}
  ],
  "joint": [
    {"type": "revolute", "name": "axle", "bodyA": 1, "bodyB": 2, "anchorA": {"x": 0, "y": -1},
     "anchorB": 0, "collideConnected": true, "enableLimit": true, "lowerLimit": -1, "upperLimit": 1,
     "enableMotor": true, "motorSpeed": 3, "maxMotorTorque": 10, "refAngle": 0.5, "jointSpeed": 0},
    {"type": "wheel", "bodyA": 1, "bodyB": 3, "anchorA": {"x": 2, "y": -1}, "anchorB": {"x": 1, "y": 0},
     "localAxisA": {"x": 0, "y": 1}, "springFrequency": 4}
  ]})";

TEST(Rube, ReadsWorldAndBodies) {
  const Scene scene = parsed_scene(std::string(kCar));
  EXPECT_EQ(scene.world.boundary, Boundary::open);
  EXPECT_EQ(scene.world.gravity.y, -9.5);
  EXPECT_EQ(scene.world.dt, 0.02);
  ASSERT_EQ(scene.bodies.size(), 5u);

  EXPECT_EQ(scene.body_names[0], "ground");
  EXPECT_EQ(scene.bodies[0].type, BodyType::static_body);
  const auto& ground = std::get<CompoundShape>(scene.bodies[0].shape).parts;
  ASSERT_EQ(ground.size(), 2u);
  EXPECT_EQ(std::get<ChainShape>(ground[0].shape).vertices.size(), 3u);
  EXPECT_FALSE(std::get<ChainShape>(ground[0].shape).loop);
  EXPECT_EQ(ground[0].friction, 0.5);
  EXPECT_EQ(ground[0].filter, Filter{});
  EXPECT_EQ(std::get<PolygonShape>(ground[1].shape).vertices[2].y, 2);
  EXPECT_EQ(ground[1].friction, 0.25);
  EXPECT_EQ(ground[1].filter, (Filter{4, 3, -2}));

  EXPECT_EQ(scene.body_names[2], "wheel");
  EXPECT_EQ(scene.body_names[3], "") << "names are unique here";
  EXPECT_EQ(std::get<DiscShape>(scene.bodies[2].shape).radius, 0.5);
  EXPECT_EQ(scene.bodies[2].position.x, 1) << "hex digits";
  EXPECT_TRUE(scene.bodies[3].fixed_rotation);
}

TEST(Rube, FixturesAreThePartsOfABody) {
  const Scene scene = parsed_scene(std::string(kCar));
  const BodyDesc& car = scene.bodies.at(1);
  EXPECT_EQ(scene.body_names[1], "car");
  EXPECT_EQ(car.angle, 0.5);
  EXPECT_TRUE(car.bullet);
  EXPECT_EQ(car.linear_damping, 0.5);
  EXPECT_EQ(car.velocity.x, 3);
  EXPECT_EQ(car.velocity.y, 4);
  EXPECT_EQ(car.angular_velocity, 2);
  const auto& parts = std::get<CompoundShape>(car.shape).parts;
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].restitution, 0.125);
  EXPECT_EQ(parts[0].friction, 0);
  EXPECT_EQ(parts[0].density, 2);
  EXPECT_EQ(parts[0].sensor, false);
}

TEST(Rube, CirclesOffTheOriginKeepTheirPlace) {
  const Scene scene = parsed_scene(std::string(kCar));
  for (const std::size_t body : {std::size_t{3}, std::size_t{4}}) {
    const auto& parts = std::get<CompoundShape>(scene.bodies.at(body).shape).parts;
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(std::get<DiscShape>(parts[0].shape).radius, 0.5);
    EXPECT_EQ(parts[0].position.x, 1);
    EXPECT_EQ(parts[0].sensor, body == 4);
  }
  EXPECT_EQ(scene.bodies[3].position.x, 2);
}

TEST(Rube, ReadsJoints) {
  const Scene scene = parsed_scene(std::string(kCar));
  ASSERT_EQ(scene.joints.size(), 2u);
  const SceneJoint& axle = scene.joints[0];
  EXPECT_EQ(axle.a, 1u);
  EXPECT_EQ(axle.b, 2u);
  EXPECT_EQ(axle.joint.type, JointType::revolute);
  EXPECT_EQ(axle.joint.anchor_a.y, -1);
  EXPECT_TRUE(axle.joint.collide);
  EXPECT_EQ(axle.joint.lower, -1);
  EXPECT_EQ(axle.joint.upper, 1);
  EXPECT_EQ(axle.joint.motor_speed, 3);
  EXPECT_EQ(axle.joint.motor_limit, 10);
  EXPECT_EQ(axle.joint.reference, 0.5);
  const SceneJoint& wheel = scene.joints[1];
  EXPECT_EQ(wheel.joint.type, JointType::wheel);
  EXPECT_EQ(wheel.joint.anchor_b.x, 1);
  EXPECT_EQ(wheel.joint.motor_limit, 0);
  EXPECT_EQ(wheel.joint.axis.y, 1);
  EXPECT_GT(wheel.joint.stiffness, 0);
  EXPECT_EQ(wheel.joint.damping, 0);
  EXPECT_TRUE(scene.notes.empty());
}

TEST(Rube, BoundsLeaveRoomAroundEverything) {
  const Scene scene = parsed_scene(std::string(kCar));
  const Bounds& b = scene.world.bounds;
  EXPECT_LT(b.xmin, -10 - 32);
  EXPECT_GT(b.xmax, 22 + 32);
  EXPECT_LT(b.ymin, -100);
  EXPECT_GT(b.ymax, 100);
}

// What is read can be written and read again, however far bodies are.
TEST(Rube, BoundsAreThoseOfAWorld) {
  const auto discs = [](std::string_view place, std::string_view other) {
    const auto body = [](std::string_view x) {
      return R"({"type": 2, "position": {"x": )" + std::string(x) +
             R"(, "y": 0}, "fixture": [{"density": 1, "circle": {"center": 0, "radius": 1}}]})";
    };
    return R"({"body": [)" + body(place) + ", " + body(other) + "]}";
  };
  for (const auto& [place, other] : {std::pair("-410000000", "410000000"), {"-1e9", "-1e9"}, {"999999990", "1e9"}}) {
    const Scene scene = parsed_scene(discs(place, other));
    const Bounds& b = scene.world.bounds;
    EXPECT_LE(b.xmax - b.xmin, 1e9);
    EXPECT_GE(b.xmin, -1e9);
    EXPECT_LE(b.xmax, 1e9);
    parsed_scene(scene_to_json(scene));
  }
  expect_refused(discs("-6e8", "6e8"), "body", "reach over 1200000002 m");
}

TEST(Rube, ReadsBackAsAnOwnScene) {
  const Scene scene = parsed_scene(std::string(kCar));
  const std::string text = scene_to_json(scene);
  EXPECT_EQ(scene_to_json(parsed_scene(text)), text);
}

// A scene of two dynamic discs of 1 kg and 4 kg and this joint.
std::string jointed(std::string_view joint) {
  const double area = std::numbers::pi * 0.25;
  return R"({"gravity": 0, "body": [
    {"type": 2, "position": 0, "fixture": [{"density": )" +
         std::to_string(1 / area) +
         R"(, "circle": {"radius": 0.5}}]},
    {"type": 2, "position": {"x": 3, "y": 0}, "fixture": [{"density": )" +
         std::to_string(4 / area) +
         R"(, "circle": {"center": 0, "radius": 0.5}}]}],
  "joint": [)" +
         std::string(joint) + "]}";
}

TEST(Rube, JointsWithAFrequencyAreSprings) {
  const double rate = 2 * std::numbers::pi * 3;
  const auto only = [](const Scene& scene) { return scene.joints.empty() ? JointDesc{} : scene.joints[0].joint; };
  const JointDesc spring = only(parsed_scene(
      jointed(R"({"type": "distance", "bodyA": 0, "bodyB": 1, "length": 3, "frequency": 3, "dampingRatio": 0.5})")));
  EXPECT_EQ(spring.type, JointType::spring);
  EXPECT_EQ(spring.length, 3);
  EXPECT_NEAR(spring.stiffness, 0.8 * rate * rate, 1e-3);
  EXPECT_NEAR(spring.damping, 0.8 * rate, 1e-3);
  EXPECT_EQ(only(parsed_scene(jointed(R"({"type": "distance", "bodyA": 0, "bodyB": 1, "length": 3})"))).type,
            JointType::distance);
  // 1/8 and 1/2 kg m^2.
  const JointDesc weld = only(parsed_scene(
      jointed(R"({"type": "weld", "bodyA": 0, "bodyB": 1, "frequency": 3, "anchorA": {"x": 3, "y": 0}})")));
  EXPECT_EQ(weld.type, JointType::weld);
  EXPECT_NEAR(weld.stiffness, 0.1 * rate * rate, 1e-3);
  EXPECT_EQ(only(parsed_scene(jointed(R"({"type": "rope", "bodyA": 0, "bodyB": 1, "maxLength": 4})"))).length, 4);
  const JointDesc slide = only(parsed_scene(jointed(
      R"({"type": "prismatic", "bodyA": 0, "bodyB": 1, "localAxisA": {"x": 0, "y": 1}, "enableLimit": true,
          "lowerLimit": 0, "upperLimit": 2, "enableMotor": true, "maxMotorForce": 5})")));
  EXPECT_EQ(slide.type, JointType::prismatic);
  EXPECT_EQ(slide.axis.y, 1);
  EXPECT_EQ(slide.upper, 2);
  EXPECT_EQ(slide.motor_limit, 5);
}

TEST(Rube, FrictionJointsDriveToRest) {
  const JointDesc joint = parsed_scene(jointed(R"({"type": "friction", "bodyA": 0, "bodyB": 1, "maxForce": 5,
                                                    "maxTorque": 2})"))
                              .joints.at(0)
                              .joint;
  EXPECT_EQ(joint.type, JointType::motor);
  EXPECT_EQ(joint.force_limit, 5);
  EXPECT_EQ(joint.torque_limit, 2);
  EXPECT_EQ(joint.linear_velocity.x, 0);
}

TEST(Rube, WhatCannotBeMadeIsLeftOutAndSaid) {
  for (const std::string_view type : {"motor", "mouse", "gear"}) {
    const Scene scene = parsed_scene(jointed("{\"type\": \"" + std::string(type) + "\", \"bodyA\": 0, \"bodyB\": 1}"));
    EXPECT_TRUE(scene.joints.empty());
    ASSERT_EQ(scene.notes.size(), 1u);
    EXPECT_EQ(scene.notes[0], "joint[0]: a " + std::string(type) + " joint is left out");
  }
  const Scene scene = parsed_scene(R"({"body": [{"type": 0}, {"type": 2}, {"type": 0}],
    "joint": [{"type": "rope", "bodyA": 0, "bodyB": 1, "maxLength": 1}]})");
  EXPECT_EQ(scene.bodies.size(), 2u) << "bodies without fixtures stay if a joint holds them";
  EXPECT_TRUE(scene.bodies[0].sensor);
  EXPECT_EQ(scene.bodies[1].filter.mask, 0u);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_EQ(scene.notes[0], "body[2]: no fixture and no joint: left out");
}

TEST(Rube, JointsOfNothingDynamicAreLeftOut) {
  for (const std::string_view types : {"00", "01", "10", "11"}) {
    const auto body = [&](std::size_t k) {
      return std::string("{\"type\": ") + types[k] + R"(, "fixture": [{"circle": {"center": 0, "radius": 1}}]})";
    };
    const Scene scene = parsed_scene("{\"body\": [" + body(0) + ", " + body(1) +
                                     R"(], "joint": [{"type": "revolute", "bodyA": 0, "bodyB": 1}]})");
    EXPECT_TRUE(scene.joints.empty()) << types;
    ASSERT_EQ(scene.notes.size(), 1u) << types;
    EXPECT_EQ(scene.notes[0], "joint[0]: joins two bodies, neither of them dynamic, and is left out");
  }
}

TEST(Rube, ClosedChainsAreLoops) {
  const Scene scene = parsed_scene(R"({"body": [{"fixture": [
    {"chain": {"vertices": {"x": [0, 1, 1, 1, 0], "y": [0, 0, 1, 1, 0]}}},
    {"edge": {"vertex1": 0, "vertex2": {"x": 1, "y": 0}}}]}]})");
  const auto& parts = std::get<CompoundShape>(scene.bodies.at(0).shape).parts;
  const auto& chain = std::get<ChainShape>(parts.at(0).shape);
  EXPECT_TRUE(chain.loop);
  EXPECT_EQ(chain.vertices.size(), 3u);
  EXPECT_TRUE(std::holds_alternative<SegmentShape>(parts.at(1).shape));
}

TEST(Rube, BadOnesAreRefusedAtTheirPlace) {
  const auto body = [](std::string_view keys) { return "{\"body\": [{" + std::string(keys) + "}]}"; };
  const auto fixture = [&](std::string_view keys) {
    return body("\"type\": 2, \"fixture\": [{" + std::string(keys) + "}]");
  };
  expect_refused(R"({"body": [3]})", "body[0]", "must be an object");
  expect_refused(body(R"("type": 3)"), "body[0].type", "0 to 2");
  expect_refused(body(R"("position": 1)"), "body[0].position", "must be 0 or");
  expect_refused(body(R"("position": {"x": 1})"), "body[0].position", "\"y\" is missing");
  expect_refused(body(R"("angle": "zz")"), "body[0].angle", "eight hex digits");
  expect_refused(body(R"("angle": "7FC00000")"), "body[0].angle", "out of range");
  expect_refused(fixture(""), "body[0].fixture[0]", "has no shape");
  expect_refused(fixture(R"("circle": {"center": 0})"), "body[0].fixture[0].circle", "\"radius\" is missing");
  expect_refused(fixture(R"("polygon": {"vertices": {"x": [0, 1], "y": [0, 1]}})"),
                 "body[0].fixture[0].polygon.vertices.x", "has 2 elements");
  expect_refused(fixture(R"("polygon": {"vertices": {"x": [0, 1, 2], "y": [0, 1]}})"),
                 "body[0].fixture[0].polygon.vertices.y", "has 2 elements");
  expect_refused(fixture(R"("polygon": {"vertices": {"x": [0, 2, 2, 1, 0], "y": [0, 0, 2, 0.5, 2]}})"),
                 "body[0].fixture[0]", "convex");
  expect_refused(fixture(R"("chain": {"vertices": {"x": [0, 1], "y": [0, 1]}})"), "body[0].fixture[0]",
                 "types 0 and 1 only");
  expect_refused(fixture(R"("circle": {"radius": 1}, "edge": {})"), "body[0].fixture[0]", "two shapes");
  expect_refused(jointed(R"({"type": "hinge", "bodyA": 0, "bodyB": 1})"), "joint[0].type", "\"revolute\"");
  expect_refused(jointed(R"({"type": "weld", "bodyA": 0})"), "joint[0]", "\"bodyB\" is missing");
  expect_refused(jointed(R"({"type": "weld", "bodyA": 0, "bodyB": 2})"), "joint[0].bodyB", "no body 2");
  expect_refused(jointed(R"({"type": "weld", "bodyA": 1, "bodyB": 1})"), "joint[0].bodyB", "two different");
  expect_refused(jointed(R"({"type": "distance", "bodyA": 0, "bodyB": 1, "length": 0})"), "joint[0].length", "above 0");
  expect_refused(jointed(R"({"type": "revolute", "bodyA": 0, "bodyB": 1, "enableLimit": true,
                             "lowerLimit": 1, "upperLimit": 0})"),
                 "joint[0]", "lowerLimit is above");
  expect_refused(R"({"body": 3})", "scene", "\"psim\" is missing");
}

}  // namespace
}  // namespace psim::test
