// Scene files and the library have one table of limits: at both ends of each range, and just beyond them, a scene file
// is accepted where the same description is accepted in C++ (and so in C, whose calls those are).
#include <gtest/gtest.h>
#include <psim/limits.h>
#include <psim/scene.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/range_text.h"
#include "support.h"

namespace psim::test {
namespace {

struct Everything {
  WorldDesc world;
  BodyDesc body;
  JointDesc joint;
  FluidDesc fluid{1};
};

struct Row {
  std::string key;  ///< as in a scene file
  Range range;
  std::string text;  ///< of a scene, with # for the number
  std::function<void(Everything&, double)> put;
};

constexpr const char* kBounds = R"("bounds": [-1e8, -1e8, 1e8, 1e8], "boundary": "open")";

Row world_row(const std::string& member, Range range, std::function<void(Everything&, double)> put) {
  return {member, range, R"({"psim": 1, "world": {)" + std::string(kBounds) + ", " + member + "}}", std::move(put)};
}

Row step_row(const std::string& member, Range range, std::function<void(Everything&, double)> put) {
  return {member, range, R"({"psim": 1, "world": {)" + std::string(kBounds) + R"(}, "step": {)" + member + "}}",
          std::move(put)};
}

Row field_row(const std::string& field, Range range, std::function<void(Everything&, double)> put) {
  return {field, range, R"({"psim": 1, "world": {)" + std::string(kBounds) + R"(}, "fields": [{)" + field + "}]}",
          std::move(put)};
}

Row fluid_row(const std::string& member, Range range, std::function<void(Everything&, double)> put) {
  return {member, range,
          R"({"psim": 1, "world": {)" + std::string(kBounds) +
              R"(}, "fluids": [{"layout": "explicit", "x": [], "y": [], "spacing": 1, )" + member + "}]}",
          std::move(put)};
}

Row body_row(const std::string& member, Range range, std::function<void(Everything&, double)> put,
             const std::string& shape = R"("disc": {"radius": 0.5})") {
  return {shape + ", " + member, range,
          R"({"psim": 1, "world": {)" + std::string(kBounds) + R"(}, "bodies": [{"position": [0, 0], "shape": {)" +
              shape + "}" + (member.empty() ? "" : ", ") + member + "}]}",
          std::move(put)};
}

Row joint_row(const std::string& joint, Range range, std::function<void(Everything&, double)> put) {
  return {joint, range,
          R"({"psim": 1, "world": {)" + std::string(kBounds) +
              R"(}, "bodies": [{"position": [0, 0], "shape": {"disc": {"radius": 0.5}}},
                               {"position": [3, 0], "shape": {"disc": {"radius": 0.5}}}],
                 "joints": [{"a": 0, "b": 1, )" +
              joint + "}]}",
          std::move(put)};
}

Row line_row(BodyType type, std::function<Shape(double)> shape, const std::string& member, const std::string& text) {
  return body_row(
      member, limits::kCoordinate,
      [=](Everything& e, double v) {
        e.body.type = type;
        e.body.shape = shape(v);
      },
      text);
}

WellField& well_of(Everything& e) {
  if (e.world.fields.empty()) e.world.fields.push_back(WellField{});
  return std::get<WellField>(e.world.fields[0]);
}

DragField& drag_of(Everything& e) {
  if (e.world.fields.empty()) e.world.fields.push_back(DragField{});
  return std::get<DragField>(e.world.fields[0]);
}

BuoyancyField& water_of(Everything& e) {
  if (e.world.fields.empty()) e.world.fields.push_back(BuoyancyField{{0, 0, 1, 1}});
  return std::get<BuoyancyField>(e.world.fields[0]);
}

WindField& wind_of(Everything& e) {
  if (e.world.fields.empty()) e.world.fields.push_back(WindField{});
  return std::get<WindField>(e.world.fields[0]);
}

std::vector<Row> rows() {
  using namespace limits;
  using E = Everything;
  const std::string well = R"("type": "well", )", still = R"("position": [0, 0], "strength": 1, )";
  const std::string water = R"("type": "buoyancy", "region": [0, 0, 1, 1], )",
                    wind = R"("type": "wind", "velocity": [0, 0], )";
  const std::string turning = R"("type": "revolute", )", sliding = R"("type": "prismatic", )";
  return {world_row(R"("gravity": [#, 0])", kGravity,
                    [](E& e, double v) {
                      e.world.gravity = {v, 0};
                    }),
          world_row(R"("gravity": [0, #])", kGravity,
                    [](E& e, double v) {
                      e.world.gravity = {0, v};
                    }),
          world_row(R"("linear_damping": #)", kDamping, [](E& e, double v) { e.world.linear_damping = v; }),
          fluid_row(R"("density": #)", kDensity, [](E& e, double v) { e.fluid.density = v; }),
          fluid_row(R"("viscosity": #)", kViscosity, [](E& e, double v) { e.fluid.viscosity = v; }),
          fluid_row(R"("surface_tension": #)", kSurfaceTension, [](E& e, double v) { e.fluid.surface_tension = v; }),
          step_row(R"("dt": #)", kTimeStep, [](E& e, double v) { e.world.dt = v; }),
          step_row(R"("restitution_threshold": #)", kSpeed, [](E& e, double v) { e.world.restitution_threshold = v; }),
          step_row(R"("skin": #)", kSkin, [](E& e, double v) { e.world.skin = v; }),
          field_row(well + R"("strength": 1, "position": [#, 0])", kCoordinate,
                    [](E& e, double v) {
                      well_of(e).position = {v, 0};
                    }),
          field_row(well + R"("position": [0, 0], "strength": #)", kWellStrength,
                    [](E& e, double v) { well_of(e).strength = v; }),
          field_row(well + still + R"("softening": #)", kWellLength, [](E& e, double v) { well_of(e).softening = v; }),
          field_row(well + still + R"("exponent": #)", kWellExponent, [](E& e, double v) { well_of(e).exponent = v; }),
          field_row(well + still + R"("range": #)", kWellLength, [](E& e, double v) { well_of(e).range = v; }),
          field_row(R"("type": "drag", "linear": #)", kDamping, [](E& e, double v) { drag_of(e).linear = v; }),
          field_row(R"("type": "drag", "quadratic": #)", kDamping, [](E& e, double v) { drag_of(e).quadratic = v; }),
          field_row(water + R"("density": #)", kDensity, [](E& e, double v) { water_of(e).density = v; }),
          field_row(water + R"("density": 1, "linear_damping": #)", kDamping,
                    [](E& e, double v) { water_of(e).linear_damping = v; }),
          field_row(water + R"("density": 1, "angular_damping": #)", kDamping,
                    [](E& e, double v) { water_of(e).angular_damping = v; }),
          field_row(water + R"("density": 1, "flow": [0, #])", kVelocity,
                    [](E& e, double v) {
                      water_of(e).flow = {0, v};
                    }),
          field_row(R"("type": "wind", "density": 1, "velocity": [#, 0])", kVelocity,
                    [](E& e, double v) {
                      wind_of(e).velocity = {v, 0};
                    }),
          field_row(wind + R"("density": #)", kDensity, [](E& e, double v) { wind_of(e).density = v; }),
          field_row(wind + R"("density": 1, "drag": #)", kWindFactor, [](E& e, double v) { wind_of(e).drag = v; }),
          field_row(wind + R"("density": 1, "lift": #)", kWindFactor, [](E& e, double v) { wind_of(e).lift = v; }),
          body_row(R"("angle": #)", kAngle, [](E& e, double v) { e.body.angle = v; }),
          body_row(R"("velocity": [#, 0])", kVelocity,
                   [](E& e, double v) {
                     e.body.velocity = {v, 0};
                   }),
          body_row(R"("velocity": [0, #])", kVelocity,
                   [](E& e, double v) {
                     e.body.velocity = {0, v};
                   }),
          body_row(R"("angular_velocity": #)", kAngularVelocity, [](E& e, double v) { e.body.angular_velocity = v; }),
          body_row(R"("density": #)", kDensity, [](E& e, double v) { e.body.material.density = v; }),
          body_row(R"("mass": #)", kMass, [](E& e, double v) { e.body.mass = v; }),
          body_row(R"("restitution": #)", kRestitution, [](E& e, double v) { e.body.material.restitution = v; }),
          body_row(R"("friction": #)", kFriction, [](E& e, double v) { e.body.material.friction = v; }),
          body_row(R"("gravity_scale": #)", kGravityScale, [](E& e, double v) { e.body.gravity_scale = v; }),
          body_row(
              "", kRadius, [](E& e, double v) { e.body.shape = DiscShape{v}; }, R"("disc": {"radius": #})"),
          body_row(
              "", kRadius,
              [](E& e, double v) {
                e.body.shape = CapsuleShape{{0, 0}, {1, 0}, v};
              },
              R"("capsule": {"p1": [0, 0], "p2": [1, 0], "radius": #})"),
          body_row(
              "", kRadius,
              [](E& e, double v) {
                e.body.shape = BoxShape{v, 1, 0};
              },
              R"("box": {"size": [#, 1]})"),
          body_row(
              "", kRadius,
              [](E& e, double v) {
                e.body.shape = BoxShape{1, v, 0};
              },
              R"("box": {"size": [1, #]})"),
          body_row(
              "", kRounding,
              [](E& e, double v) {
                e.body.shape = BoxShape{1, 1, v};
              },
              R"("box": {"size": [1, 1], "radius": #})"),
          line_row(
              BodyType::static_body,
              [](double v) {
                return SegmentShape{{v, 0}, {0, 1}};
              },
              R"("type": "static")", R"("segment": {"p1": [#, 0], "p2": [0, 1]})"),
          line_row(
              BodyType::static_body,
              [](double v) {
                return ChainShape{{{0, 1}, {v, 0}, {0, 2}}, false};
              },
              R"("type": "static")", R"("chain": {"vertices": [[0, 1], [#, 0], [0, 2]]})"),
          line_row(
              BodyType::kinematic_body,
              [](double v) {
                return ChainShape{{{0, 1}, {v, 0}, {0, 2}}, false};
              },
              R"("type": "kinematic")", R"("chain": {"vertices": [[0, 1], [#, 0], [0, 2]]})"),
          joint_row(R"("type": "distance", "length": #)", kRodLength, [](E& e, double v) { e.joint.length = v; }),
          joint_row(R"("type": "rope", "length": #)", kRodLength,
                    [](E& e, double v) {
                      e.joint.type = JointType::rope;
                      e.joint.length = v;
                    }),
          joint_row(R"("type": "spring", "stiffness": 1, "length": #)", kLength,
                    [](E& e, double v) {
                      e.joint.type = JointType::spring;
                      e.joint.stiffness = 1;
                      e.joint.length = v;
                    }),
          joint_row(R"("type": "spring", "damping": 1, "stiffness": #)", kStiffness,
                    [](E& e, double v) {
                      e.joint.type = JointType::spring;
                      e.joint.damping = 1;
                      e.joint.stiffness = v;
                    }),
          joint_row(R"("type": "weld", "damping": #)", kJointDamping,
                    [](E& e, double v) {
                      e.joint.type = JointType::weld;
                      e.joint.damping = v;
                    }),
          joint_row(turning + R"("anchor_a": [#, 0])", kCoordinate,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.anchor_a = {v, 0};
                    }),
          joint_row(turning + R"("anchor_b": [0, #])", kCoordinate,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.anchor_b = {0, v};
                    }),
          joint_row(turning + R"("reference": #)", kAngle,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.reference = v;
                    }),
          joint_row(turning + R"("lower": #)", kAngle,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.lower = v;
                    }),
          joint_row(sliding + R"("upper": #)", kCoordinate,
                    [](E& e, double v) {
                      e.joint.type = JointType::prismatic;
                      e.joint.upper = v;
                    }),
          joint_row(sliding + R"("axis": [#, 0])", Range{1e-9, 1e9},
                    [](E& e, double v) {
                      e.joint.type = JointType::prismatic;
                      e.joint.axis = {v, 0};
                    }),
          joint_row(turning + R"("motor_speed": #)", kMotorSpeed,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.motor_speed = v;
                    }),
          joint_row(turning + R"("motor_limit": #)", kMotorLimit,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.motor_limit = v;
                    }),
          joint_row(R"("type": "distance", "lower": #)", kLength, [](E& e, double v) { e.joint.lower = v; }),
          joint_row(turning + R"("stiffness": 1, "target": #)", kCoordinate,
                    [](E& e, double v) {
                      e.joint.type = JointType::revolute;
                      e.joint.stiffness = 1;
                      e.joint.rest = v;
                    }),
          joint_row(R"("type": "motor", "linear_velocity": [0, #])", kMotorSpeed,
                    [](E& e, double v) {
                      e.joint.type = JointType::motor;
                      e.joint.linear_velocity = {0, v};
                    }),
          joint_row(R"("type": "motor", "angular_velocity": #)", kMotorSpeed,
                    [](E& e, double v) {
                      e.joint.type = JointType::motor;
                      e.joint.angular_velocity = v;
                    }),
          joint_row(R"("type": "motor", "force_limit": #)", kMotorLimit,
                    [](E& e, double v) {
                      e.joint.type = JointType::motor;
                      e.joint.force_limit = v;
                    }),
          joint_row(R"("type": "motor", "correction": #)", kCorrection,
                    [](E& e, double v) {
                      e.joint.type = JointType::motor;
                      e.joint.correction = v;
                    }),
          joint_row(R"("type": "motor", "offset": [#, 0])", kCoordinate,
                    [](E& e, double v) {
                      e.joint.type = JointType::motor;
                      e.joint.offset = {v, 0};
                    }),
          joint_row(R"("type": "rope", "pressure": #)", kPressure,
                    [](E& e, double v) {
                      e.joint.type = JointType::rope;
                      e.joint.pressure = v;
                    }),
          joint_row(R"("type": "rope", "drag": #)", kWindFactor,
                    [](E& e, double v) {
                      e.joint.type = JointType::rope;
                      e.joint.wind_drag = v;
                    }),
          joint_row(R"("type": "rope", "lift": #)", kWindFactor,
                    [](E& e, double v) {
                      e.joint.type = JointType::rope;
                      e.joint.wind_lift = v;
                    }),
          joint_row(R"("type": "rope", "area": #)", kArea,
                    [](E& e, double v) {
                      e.joint.type = JointType::rope;
                      e.joint.area = v;
                    }),
          joint_row(R"("type": "weld", "linear_stiffness": #)", kStiffness,
                    [](E& e, double v) {
                      e.joint.type = JointType::weld;
                      e.joint.linear_stiffness = v;
                    }),
          joint_row(R"("type": "weld", "linear_damping": #)", kJointDamping,
                    [](E& e, double v) {
                      e.joint.type = JointType::weld;
                      e.joint.linear_damping = v;
                    }),
          joint_row(R"("type": "motor", "torque_limit": #)", kMotorLimit,
                    [](E& e, double v) {
                      e.joint.type = JointType::motor;
                      e.joint.torque_limit = v;
                    }),
          joint_row(R"("type": "pulley", "ground_a": [1, #], "ground_b": [3, 1], "length": 5)", kCoordinate,
                    [](E& e, double v) {
                      e.joint.type = JointType::pulley;
                      e.joint.ground_a = {1, v};
                      e.joint.ground_b = {3, 1};
                      e.joint.length = 5;
                    }),
          joint_row(R"("type": "pulley", "ground_a": [1, 1], "ground_b": [3, 1], "ratio": #)", kPulleyRatio,
                    [](E& e, double v) {
                      e.joint.type = JointType::pulley;
                      e.joint.ground_a = {1, 1};
                      e.joint.ground_b = {3, 1};
                      e.joint.ratio = v;
                    }),
          joint_row(R"("type": "wheel", "damping_ratio": #, "frequency": 1)", Range{0, 1e6}, [](E& e, double v) {
            e.joint.type = JointType::wheel;
            e.joint.frequency = 1;
            e.joint.damping_ratio = v;
          })};
}

// What the library says of the description, or nothing.
std::string refusal_of_library(const Row& row, double v) {
  Everything e;
  e.world.bounds = {-1e8, -1e8, 1e8, 1e8};
  e.world.boundary = Boundary::open;
  row.put(e, v);
  std::string error;
  const auto world = World::create(e.world, {}, error);
  if (!world) return error;
  e.joint.a = world->add_body(e.body, error);
  if (e.joint.a == kNoBody) return error;
  BodyDesc other = e.body;
  other.position = {3, 0};
  e.joint.b = world->add_body(other, error);
  if (row.text.find("joints") != row.text.npos) world->add_joint(e.joint, error);
  if (row.text.find("fluids") != row.text.npos) world->add_fluid(e.fluid, error);
  return error;
}

// What the reader of scenes says of it.
std::string refusal_of_scene(const Row& row, double v) {
  std::string text = row.text, error;
  text.replace(text.find('#'), 1, exact_text(v));
  parse_scene(text, "f", error);
  return error;
}

TEST(Limits, AreThoseOfScenesAndOfTheLibrary) {
  for (const Row& row : rows()) {
    const double least = row.range.above ? std::nextafter(row.range.min, row.range.max) : row.range.min;
    for (const double v : {least, row.range.max}) {
      EXPECT_EQ(refusal_of_library(row, v), "") << row.key << " " << v;
      EXPECT_EQ(refusal_of_scene(row, v), "") << row.key << " " << v;
    }
    const double below = row.range.above ? row.range.min : std::nextafter(row.range.min, -kInf);
    for (const double v : {below, std::nextafter(row.range.max, kInf), -1e300, 1e300}) {
      EXPECT_NE(refusal_of_library(row, v), "") << row.key << " " << v;
      EXPECT_NE(refusal_of_scene(row, v), "") << row.key << " " << v;
    }
    for (const double v : {kNan, kInf, -kInf}) EXPECT_NE(refusal_of_library(row, v), "") << row.key << " " << v;
  }
}

TEST(Limits, OfWholeNumbersAreTheSame) {
  for (const auto& [substeps, sound] : {std::pair{0, false}, {1, true}, {64, true}, {65, false}}) {
    WorldDesc desc;
    desc.substeps = substeps;
    std::string error;
    EXPECT_EQ(World::create(desc, {}, error) != nullptr, sound) << error;
    const std::string text = R"({"psim": 1, "world": {"bounds": [0, 0, 1, 1]}, "step": {"substeps": )";
    EXPECT_EQ(parse_scene(text + std::to_string(substeps) + "}}", "f", error).has_value(), sound) << error;
  }
}

TEST(Limits, OfTheWorldsSizeAreTheSame) {
  for (const auto& [width, sound] : {std::pair{1e-9, true}, {0.9e-9, false}, {1e9, true}, {1.0000001e9, false}}) {
    WorldDesc desc;
    desc.bounds = {0, 0, width, 1};
    std::string error;
    EXPECT_EQ(World::create(desc, {}, error) != nullptr, sound) << error;
    const std::string text = R"({"psim": 1, "world": {"bounds": [0, 0, )" + exact_text(width) + ", 1]}}";
    EXPECT_EQ(parse_scene(text, "f", error).has_value(), sound) << error;
  }
}

}  // namespace
}  // namespace psim::test
