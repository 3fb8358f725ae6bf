// docs/scene.schema.json and the parser describe one format: every document below, the scenes of
// scenes/ and thousands of damaged ones are judged by both. The parser alone knows what a schema
// cannot say (places inside the world, references, lengths, convexity).
#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "json_schema.h"
#include "psim/scene.h"
#include "sanitized.h"

namespace psim {
namespace {

using Json = nlohmann::json;

const test::JsonSchema& schema() {
  static const test::JsonSchema kSchema = [] {
    std::ifstream file(PSIM_SOURCE_DIR "/docs/scene.schema.json");
    return test::JsonSchema(Json::parse(file));
  }();
  return kSchema;
}

// Nothing, or what the parser said.
std::string refusal(const std::string& text) {
  std::string error;
  parse_scene(text, "f", error);
  return error;
}

bool beyond_the_schema(std::string_view error) {
  for (const std::string_view reason : {"outside the world",
                                        "out of the world",
                                        "larger than the world",
                                        "is no area",
                                        "width and height from 1e-9",
                                        "no material",
                                        "no body ",
                                        "names are unique",
                                        "one for each body",
                                        "is p1",
                                        "is the vertex before it",
                                        "is the first vertex",
                                        "at least 3",
                                        "is less than the smallest",
                                        "stands beside \"vx\"",
                                        "is the body of",
                                        "needs \"bounds\"",
                                        "stands there twice",
                                        "is no direction",
                                        "a single row or column",
                                        "needs a `bending`",
                                        "one for each segment",
                                        "nor is \"a\"",
                                        "is not dynamic: a body that is",
                                        "is the world: a body",
                                        "\"stiffness\" is missing",
                                        "follows from \"frequency\"",
                                        "is for a spring with \"frequency\"",
                                        "there is no \"damping\"",
                                        "before this one",
                                        "joint: revolute or prismatic",
                                        "two different joints",
                                        "is too near to 0",
                                        "is the shape of a dynamic body",
                                        "must be convex",
                                        "must have an area",
                                        "must not cross or touch itself",
                                        "must be from 1e-9",
                                        "too far from the body's place",
                                        "is no direction",
                                        "is less than \"lower\"",
                                        "is less than \"start\"",
                                        "lie on each other",
                                        "ties the neighbours",
                                        "ties dynamic bodies",
                                        "is for layout",
                                        "one for each particle",
                                        "that of the first fluid",
                                        "has no room for a particle",
                                        "no emitter lets this fluid out",
                                        "lets out a fluid",
                                        "its two points are the same",
                                        "particles in all"}) {
    if (error.find(reason) != error.npos) return true;
  }
  return false;
}

// Uses every key of the format.
const std::vector<std::string>& good_documents() {
  static const std::vector<std::string> kDocuments = {
      R"({"psim": 1, "world": {"bounds": [0, 0, 1, 1]}})",
      R"({"psim": 1, "name": "n", "description": "d",
          "world": {"bounds": [-50, -50, 50, 50], "boundary": "periodic", "gravity": [0, -1],
                    "linear_damping": 0.1, "material": "m",
                    "mixing": {"restitution": "product", "friction": "min"}},
          "step": {"dt": 0.02, "substeps": 2, "sleeping": false, "integrator": "verlet",
                   "restitution_threshold": 0.1, "skin": 2},
          "materials": {"m": {"density": 2, "restitution": 0.5, "friction": 0.3}},
          "bodies": [{"name": "a", "type": "dynamic", "shape": {"disc": {"radius": 1}},
                      "position": [1, 2], "angle": 1, "velocity": [1, 2], "angular_velocity": 1,
                      "material": "m", "density": 3, "mass": 4, "restitution": 1, "friction": 1,
                      "gravity_scale": 2, "fixed_rotation": true, "bullet": true, "linear_damping": 1,
                      "angular_damping": 2, "lock": ["x", "y", "angle"]}],
          "fields": [{"type": "well", "position": [0, 0], "strength": 1, "softening": 0.1,
                      "exponent": 3, "range": 5},
                     {"type": "drag", "linear": 1, "quadratic": 2}],
          "joints": []})",
      R"({"psim": 1, "world": {"bounds": [-50, -50, 50, 50]},
          "bodies": [{"type": "static", "position": [0, 0],
                      "shape": {"segment": {"p1": [0, 0], "p2": [1, 1]}}},
                     {"type": "static", "position": [0, 0],
                      "shape": {"chain": {"vertices": [[0, 0], [1, 1], [2, 0]], "loop": true}}}]})",
      R"({"psim": 1, "world": {"bounds": [-50, -50, 50, 50]},
          "materials": {"m": {"tangent_speed": 2, "rolling_resistance": 0.5}},
          "bodies": [{"type": "static", "position": [0, 0], "tangent_speed": 1, "rolling_resistance": 0.1,
                      "one_way": [0, 1], "enabled": false,
                      "shape": {"chain": {"vertices": [[0, 0], [1, 1], [2, 0]],
                                          "materials": ["m", {"friction": 1, "tangent_speed": 1}]}}},
                     {"position": [0, 0], "shapes": [{"disc": {"radius": 1}, "tangent_speed": 1,
                                                      "rolling_resistance": 0.1, "one_way": [1, 0]}]}]})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]}, "step": {"integrator": "euler"}})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]}, "step": {"integrator": "rk4"}})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]}, "step": {"integrator": "symplectic4"}})",
      R"({"psim": 1, "world": {"bounds": [-50, -50, 50, 50], "boundary": "open"},
          "materials": {"m": {}},
          "groups": [{"layout": "lattice", "count": 4, "region": [0, 0, 9, 9], "radius": [1, 2],
                      "jitter": 0.5, "velocity": [1, 1], "velocity_spread": 1, "seed": 3,
                      "type": "kinematic", "angle": 1, "angular_velocity": 1, "material": "m",
                      "density": 1, "mass": 1, "restitution": 0, "friction": 0, "gravity_scale": 1,
                      "fixed_rotation": false, "bullet": false},
                     {"layout": "random", "count": 4, "region": [0, 0, 9, 9],
                      "shape": {"disc": {"radius": 1}}},
                     {"layout": "explicit", "x": [1, 2], "y": [1, 2], "radius": [1, 1],
                      "vx": [1, 2], "vy": [1, 2], "type": "static", "angle": 1,
                      "angular_velocity": 1, "material": "m", "density": 1, "mass": 1,
                      "restitution": 0, "friction": 0, "gravity_scale": 1,
                      "fixed_rotation": false, "bullet": false},
                     {"layout": "explicit", "x": [], "y": [], "radius": 1, "velocity": [1, 1]},
                     {"layout": "explicit", "x": [], "y": [], "shape": {"disc": {"radius": 1}}}]})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]},
          "bodies": [{"shape": {"box": {"size": [1, 2], "radius": 0.1}}, "position": [0, 0],
                      "category": 2, "mask": 4294967295, "group": -1, "sensor": false},
                     {"shape": {"polygon": {"vertices": [[0, 0], [1, 0], [0, 1]], "radius": 0.1}},
                      "position": [0, 0]},
                     {"shape": {"outline": {"vertices": [[0, 0], [2, 0], [0.5, 0.5], [0, 2]], "radius": 0.1}},
                      "position": [0, 0]},
                     {"shape": {"capsule": {"p1": [0, 0], "p2": [1, 0], "radius": 1}},
                      "position": [0, 0]},
                     {"type": "kinematic", "position": [0, 0], "sensor": true,
                      "shape": {"chain": {"vertices": [[0, 0], [1, 1]]}}},
                     {"shape": {"segment": {"p1": [0, 0], "p2": [1, 1]}}, "position": [0, 0]},
                     {"position": [0, 0], "shapes": [{"disc": {"radius": 1}, "position": [1, 0], "angle": 1,
                      "density": 2, "restitution": 1, "friction": 1, "category": 2, "mask": 3, "group": -1,
                      "sensor": true}]}]})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]},
          "groups": [{"layout": "hex", "count": 1, "region": [0, 0, 9, 9], "category": 1,
                      "mask": 0, "group": 1, "sensor": false, "shape": {"box": {"size": [1, 2]}},
                      "links": {"type": "rope", "pin": "ends", "collide": true, "break_force": 5,
                                "drag": 1, "lift": 2}},
                     {"layout": "ring", "count": 4, "region": [0, 0, 9, 9], "radius": 1, "links": {}},
                     {"layout": "ring", "count": 4, "region": [0, 0, 9, 9], "radius": 1,
                      "links": {"pressure": -5, "area": true, "bending": 3, "bending_damping": 1}},
                     {"layout": "lattice", "count": 4, "region": [0, 0, 9, 9], "radius": 1,
                      "links": {"type": "spring", "stiffness": 1, "damping": 1,
                                "diagonals": true, "pin": "top", "collide": false}},
                     {"layout": "explicit", "x": [1], "y": [1], "angle": 1, "category": 1,
                      "mask": 0, "group": 1, "sensor": true, "type": "static",
                      "shape": {"segment": {"p1": [0, 0], "p2": [1, 1]}}}]})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]},
          "bodies": [{"name": "a", "shape": {"disc": {"radius": 1}}, "position": [0, 0]},
                     {"shape": {"disc": {"radius": 1}}, "position": [3, 0]}],
          "joints": [{"type": "spring", "a": "a", "b": 1, "anchor_a": [0, 0], "anchor_b": [0, 0],
                      "length": 1, "stiffness": 10, "damping": 1, "collide": true},
                     {"type": "distance", "a": 0, "b": 1, "length": 1},
                     {"type": "rope", "a": 0, "b": 1, "length": 1},
                     {"type": "revolute", "a": 0, "b": 1, "reference": 1, "lower": -1, "upper": 1,
                      "motor_speed": 1, "motor_limit": 1},
                     {"type": "prismatic", "a": 0, "b": 1, "axis": [1, 2], "reference": 1,
                      "lower": -1, "upper": 1, "motor_speed": 1, "motor_limit": 1},
                     {"type": "weld", "a": 0, "b": 1, "reference": 1, "stiffness": 1,
                      "damping": 1}]})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]},
          "fluids": [{"region": [0, 0, 1, 2], "spacing": 0.5, "density": 900, "viscosity": 0.1, "velocity": [1, 0]},
                     {"disc": {"position": [-2, -2], "radius": 1}, "spacing": 0.5},
                     {"polygon": {"vertices": [[3, 3], [5, 3], [3, 5]]}, "spacing": 0.5},
                     {"layout": "explicit", "x": [4, 4.5], "y": [-1, -1], "vx": [0, 1], "vy": [1, 0],
                      "spacing": 0.25, "density": 900, "viscosity": 0.1},
                     {"layout": "explicit", "x": [], "y": [], "spacing": 0.5, "velocity": [1, 1]}]})",
      R"({"psim": 1, "world": {"bounds": [-9, -9, 9, 9]},
          "fluids": [{"spacing": 0.5, "density": 900, "viscosity": 0.1, "velocity": [1, 0]}],
          "emitters": [{"segment": [[0, 0], [1, 2]], "speed": 3, "fluid": 0, "start": 1, "end": 2, "limit": 7}],
          "drains": [{"region": [0, 0, 1, 2]}]})"};
  return kDocuments;
}

void expect_agreement(const Json& document) {
  const std::string violation = schema().violation(document);
  const std::string error = refusal(document.dump());
  if (violation.empty()) {
    EXPECT_TRUE(error.empty() || beyond_the_schema(error)) << "fits the schema, yet: " << error << "\n"
                                                           << document.dump();
  } else {
    EXPECT_FALSE(error.empty()) << "against the schema at " << violation << ", yet it was read\n" << document.dump();
  }
}

TEST(SceneSchema, GoodDocumentsFitBoth) {
  for (const std::string& text : good_documents()) {
    EXPECT_EQ(schema().violation(Json::parse(text)), "") << text;
    EXPECT_EQ(refusal(text), "") << text;
  }
}

TEST(SceneSchema, ScenesOfTheRepositoryFitBoth) {
  for (const auto& entry : std::filesystem::directory_iterator(PSIM_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    std::ifstream file(entry.path());
    EXPECT_EQ(schema().violation(Json::parse(file)), "") << entry.path();
    std::string error;
    EXPECT_TRUE(load_scene(entry.path().string(), error)) << error;
  }
}

TEST(SceneSchema, TheExampleOfTheDocumentationFitsBoth) {
  std::ifstream file(PSIM_SOURCE_DIR "/docs/scenes.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  const std::size_t begin = page.find("```json\n") + 8;
  const std::string text = page.substr(begin, page.find("```", begin) - begin);
  EXPECT_EQ(schema().violation(Json::parse(text)), "");
  EXPECT_EQ(refusal(text), "");
}

TEST(SceneSchema, WrittenScenesFitIt) {
  for (const std::string& text : good_documents()) {
    std::string error;
    const std::optional<Scene> scene = parse_scene(text, "f", error);
    ASSERT_TRUE(scene) << error;
    EXPECT_EQ(schema().violation(Json::parse(scene_to_json(*scene))), "");
  }
}

// Every value replaced by values of every kind and size, every key dropped, renamed and joined by an
// unknown one: the two must judge each of these documents alike.
TEST(SceneSchema, BothJudgeDamagedDocumentsAlike) {
  const std::vector<Json> values = {nullptr,
                                    true,
                                    "x",
                                    "",
                                    0,
                                    -1,
                                    1.5,
                                    1,
                                    65,
                                    1e-7,
                                    2e6,
                                    -2e6,
                                    1e10,
                                    -1e10,
                                    1e13,
                                    1e22,
                                    101,
                                    10.5,
                                    1e300,
                                    20000000,
                                    Json::array(),
                                    Json::array({1}),
                                    Json::array({1, 2}),
                                    Json::array({1, "x"}),
                                    Json::array({1, 2, 3}),
                                    Json::array({1e10, 1}),
                                    Json::array({0, 0, 1, 1}),
                                    Json::object(),
                                    Json::object({{"disc", 1}}),
                                    "static",
                                    "hex",
                                    "explicit",
                                    "drag",
                                    "well"};
  std::size_t judged = 0, turn = 0;
  for (const std::string& text : good_documents()) {
    const Json document = Json::parse(text);
    const Json leaves = document.flatten();
    for (const auto& [place, unused] : leaves.items()) {
      // The leaf and everything around it.
      for (Json::json_pointer at(place); !at.empty(); at = at.parent_pointer()) {
        for (const Json& value : values) {
          if (test::kSanitized && ++turn % 5 != 0) continue;
          Json damaged = document;
          damaged[at] = value;
          expect_agreement(damaged);
          ++judged;
        }
        if (!document.at(at.parent_pointer()).is_object()) continue;
        Json damaged = document;
        Json& parent = damaged[at.parent_pointer()];
        parent.erase(at.back());
        expect_agreement(damaged);
        parent[at.back() + "x"] = document.at(at);
        expect_agreement(damaged);
        parent[at.back()] = document.at(at);
        expect_agreement(damaged);
      }
    }
  }
  EXPECT_GT(judged, 1000u);
}

// What a schema calls the default of a key is what the parser takes where the key is missing.
TEST(SceneSchema, DefaultsAreTheParsers) {
  const std::string world = R"({"psim": 1, "name": "n", "world": {"bounds": [0, 0, 9, 9]})";
  const std::string pair = R"(, "bodies": [{"shape": {"disc": {"radius": 1}}, "position": [2, 2]},
      {"shape": {"disc": {"radius": 1}}, "position": [6, 6]}])";
  const auto body = [&](const std::string& shape) {
    return world + R"(, "bodies": [{"type": "static", "shape": {)" + shape + R"(}, "position": [5, 5]}]})";
  };
  const auto joint = [&](const std::string& keys) {
    return world + pair + R"(, "joints": [{"a": 0, "b": 1, )" + keys + "}]}";
  };
  const auto group = [&](const std::string& keys) { return world + R"(, "groups": [{)" + keys + "}]}"; };
  const std::string placed = R"("layout": "lattice", "count": 4, "region": [1, 1, 8, 8], "radius": 0.5)";
  struct Section {
    const char* keys;      // where the schema has them
    const char* at;        // where a document has them
    std::string document;  // with none of them
  };
  const Section sections[] = {
      {"/properties", "", world + "}"},
      {"/$defs/world/properties", "/world", world + "}"},
      {"/$defs/step/properties", "/step", world + R"(, "step": {}})"},
      {"/$defs/material/properties", "/materials/a", world + R"(, "materials": {"a": {}, "wall": {"friction": 1}}})"},
      {"/$defs/body/properties", "/bodies/0", world + pair + "}"},
      {"/$defs/box_keys/properties", "/bodies/0/shape/box", body(R"("box": {"size": [1, 1]})")},
      {"/$defs/polygon_keys/properties", "/bodies/0/shape/polygon",
       body(R"("polygon": {"vertices": [[0, 0], [1, 0], [0, 1]]})")},
      {"/$defs/outline_keys/properties", "/bodies/0/shape/outline",
       body(R"("outline": {"vertices": [[0, 0], [2, 0], [0.5, 0.5], [0, 2]]})")},
      {"/$defs/chain_keys/properties", "/bodies/0/shape/chain",
       body(R"("chain": {"vertices": [[0, 0], [1, 0], [0, 1]]})")},
      {"/$defs/shape_part/properties", "/bodies/0/shapes/0",
       world + R"(, "bodies": [{"position": [5, 5], "shapes": [{"disc": {"radius": 1}}]}]})"},
      {"/$defs/placed_group/properties", "/groups/0", group(placed)},
      {"/$defs/listed_group/properties", "/groups/0",
       group(R"("layout": "explicit", "x": [1], "y": [1], "radius": 1)")},
      {"/$defs/rod_links/properties", "/groups/0/links", group(placed + R"(, "links": {})")},
      {"/$defs/spring_links/properties", "/groups/0/links",
       group(placed + R"(, "links": {"type": "spring", "stiffness": 1})")},
      {"/$defs/rod/properties", "/joints/0", joint(R"("type": "distance")")},
      {"/$defs/rope/properties", "/joints/0", joint(R"("type": "rope")")},
      {"/$defs/spring/properties", "/joints/0", joint(R"("type": "spring", "stiffness": 1)")},
      {"/$defs/revolute/properties", "/joints/0", joint(R"("type": "revolute")")},
      {"/$defs/prismatic/properties", "/joints/0", joint(R"("type": "prismatic")")},
      {"/$defs/weld/properties", "/joints/0", joint(R"("type": "weld")")},
      {"/$defs/wheel/properties", "/joints/0", joint(R"("type": "wheel")")},
      {"/$defs/motor/properties", "/joints/0", joint(R"("type": "motor")")},
      {"/$defs/target/properties", "/joints/0",
       world + pair + R"(, "joints": [{"type": "target", "b": 1, "target": [1, 1], "stiffness": 1}]})"},
      {"/$defs/pulley/properties", "/joints/0", joint(R"("type": "pulley", "ground_a": [2, 8], "ground_b": [6, 8])")},
      {"/$defs/gear/properties", "/joints/2",
       world + pair +
           R"(, "joints": [{"type": "revolute", "a": "world", "b": 0}, {"type": "revolute", "a": "world", "b": 1},
           {"type": "gear", "joint_a": 0, "joint_b": 1}]})"},
      {"/$defs/well/properties", "/fields/0",
       world + R"(, "fields": [{"type": "well", "position": [1, 1], "strength": 1}]})"},
      {"/$defs/drag/properties", "/fields/0", world + R"(, "fields": [{"type": "drag"}]})"},
      {"/$defs/fluid/properties", "/fluids/0", world + R"(, "fluids": [{"region": [1, 1, 2, 2], "spacing": 0.5}]})"},
      {"/$defs/listed_fluid/properties", "/fluids/0",
       world + R"(, "fluids": [{"layout": "explicit", "x": [1], "y": [1], "spacing": 0.5}]})"},
      {"/$defs/fed_fluid/properties", "/fluids/0",
       world + R"(, "fluids": [{"spacing": 0.5}], "emitters": [{"segment": [[1, 1], [2, 2]], "speed": 1}]})"},
      {"/$defs/emitter/properties", "/emitters/0",
       world + R"(, "fluids": [{"spacing": 0.5}], "emitters": [{"segment": [[1, 1], [2, 2]], "speed": 1}]})"}};
  const auto read = [](const Json& document) {
    std::string error;
    const auto scene = parse_scene(document.dump(), "f", error);
    EXPECT_TRUE(scene) << error << "\n" << document;
    return scene ? scene_to_json(*scene) : std::string();
  };
  std::ifstream file(PSIM_SOURCE_DIR "/docs/scene.schema.json");
  const Json root = Json::parse(file);
  std::size_t held = 0;
  for (const Section& section : sections) {
    const Json plain = Json::parse(section.document);
    const std::string expected = read(plain);
    for (const auto& [key, rule] : root.at(Json::json_pointer(section.keys)).items()) {
      if (!rule.contains("default")) continue;
      Json said = plain;
      Json& object = said.at(Json::json_pointer(section.at));
      if (object.contains(key)) continue;
      object[key] = rule["default"];
      EXPECT_EQ(read(said), expected) << section.keys << '/' << key << " is " << rule["default"];
      ++held;
    }
  }
  EXPECT_GT(held, 80u);
}

}  // namespace
}  // namespace psim
