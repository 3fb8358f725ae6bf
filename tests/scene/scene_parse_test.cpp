// Scene files: what a good one becomes, and what is said of a bad one and where.
#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "psim/scene.h"

namespace psim {
namespace {

std::string error_of(std::string_view text) {
  std::string error;
  const std::optional<Scene> scene = parse_scene(text, "f.json", error);
  EXPECT_EQ(scene.has_value(), error.empty());
  EXPECT_EQ(error.find('\n'), error.npos) << error;
  return error;
}

Scene parsed(std::string_view text) {
  std::string error;
  std::optional<Scene> scene = parse_scene(text, "f.json", error);
  EXPECT_TRUE(scene) << error;
  return scene ? *scene : Scene();
}

void expect_starts(std::string_view text, std::string_view beginning) {
  const std::string error = error_of(text);
  EXPECT_TRUE(error.starts_with(beginning)) << "expected: " << beginning << "\nsaid:     " << error;
}

// The scene of the error tests; line 5 holds what a test replaces.
constexpr std::string_view kScene = R"({
  "psim": 1,
  "world": { "bounds": [-100, -100, 100, 100], "boundary": "open", "gravity": [0, -9.81] },
  "bodies": [
    { "name": "a", "type": "dynamic", "shape": {"disc": {"radius": 0.5}}, "position": [0, 5] }
  ]
})";

std::string with(std::string_view old_text, std::string_view new_text) {
  std::string text(kScene);
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, text.npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

// A whole scene with these top-level members beside psim and world.
std::string scene_with(std::string_view members) {
  return "{\"psim\": 1, \"world\": {\"bounds\": [0, 0, 10, 10]},\n" + std::string(members) + "}";
}

TEST(SceneParse, ReadsEveryKeyOfABody) {
  const Scene scene = parsed(R"({
    "psim": 1, "name": "n", "description": "d",
    "world": {"bounds": [-1, -2, 3, 4], "boundary": "periodic", "gravity": [1, -2],
              "linear_damping": 0.25, "material": "m"},
    "step": {"dt": 0.01, "substeps": 8, "sleeping": false, "integrator": "rk4",
             "restitution_threshold": 0.125, "skin": 0.5},
    "materials": {"m": {"density": 2, "restitution": 0.5, "friction": 0.75},
                  "wall": {"density": 9}},
    "bodies": [
      {"name": "a", "type": "kinematic", "shape": {"disc": {"radius": 0.25}}, "position": [1, 2],
       "angle": 0.5, "velocity": [3, 4], "angular_velocity": 5, "material": "m", "friction": 0.1,
       "mass": 7, "gravity_scale": 0.5, "fixed_rotation": true, "bullet": true},
      {"type": "static", "shape": {"segment": {"p1": [-1, 0], "p2": [1, 0]}}, "position": [0, 0]},
      {"type": "static", "position": [0, 1],
       "shape": {"chain": {"vertices": [[0, 0], [1, 0], [1, 1]], "loop": true}}}],
    "fields": [{"type": "well", "position": [1, 1], "strength": 10, "softening": 0.1,
                "exponent": 1, "range": 20},
               {"type": "drag", "linear": 0.5, "quadratic": 0.25}]})");
  EXPECT_EQ(scene.name, "n");
  EXPECT_EQ(scene.description, "d");
  EXPECT_EQ(scene.world.bounds.ymin, -2);
  EXPECT_EQ(scene.world.boundary, Boundary::periodic);
  EXPECT_EQ(scene.world.gravity.y, -2);
  EXPECT_EQ(scene.world.linear_damping, 0.25);
  EXPECT_EQ(scene.world.wall.density, 2);
  EXPECT_EQ(scene.world.dt, 0.01);
  EXPECT_EQ(scene.world.substeps, 8);
  EXPECT_EQ(scene.world.integrator, Integrator::rk4);
  EXPECT_FALSE(scene.world.sleeping);
  EXPECT_EQ(scene.world.restitution_threshold, 0.125);
  EXPECT_EQ(scene.world.skin, 0.5);
  ASSERT_EQ(scene.bodies.size(), 3u);
  const BodyDesc& a = scene.bodies[0];
  EXPECT_EQ(scene.body_names[0], "a");
  EXPECT_EQ(a.type, BodyType::kinematic_body);
  EXPECT_EQ(std::get<DiscShape>(a.shape).radius, 0.25);
  EXPECT_EQ(a.position.y, 2);
  EXPECT_EQ(a.angle, 0.5);
  EXPECT_EQ(a.velocity.x, 3);
  EXPECT_EQ(a.angular_velocity, 5);
  EXPECT_EQ(a.material.density, 2);
  EXPECT_EQ(a.material.restitution, 0.5);
  EXPECT_EQ(a.material.friction, 0.1);  // the body's key over the material's
  EXPECT_EQ(a.mass, 7);
  EXPECT_EQ(a.gravity_scale, 0.5);
  EXPECT_TRUE(a.fixed_rotation);
  EXPECT_TRUE(a.bullet);
  EXPECT_EQ(scene.body_names[1], "");
  EXPECT_EQ(std::get<SegmentShape>(scene.bodies[1].shape).p2.x, 1);
  EXPECT_EQ(std::get<ChainShape>(scene.bodies[2].shape).vertices.size(), 3u);
  EXPECT_TRUE(std::get<ChainShape>(scene.bodies[2].shape).loop);
  ASSERT_EQ(scene.world.fields.size(), 2u);
  EXPECT_EQ(std::get<WellField>(scene.world.fields[0]).range, 20);
  EXPECT_EQ(std::get<DragField>(scene.world.fields[1]).quadratic, 0.25);
}

TEST(SceneParse, ReadsEveryIntegratorAndNoOther) {
  for (const Integrator integrator : kAllIntegrators) {
    const std::string step = "\"step\": {\"integrator\": \"" + std::string(integrator_name(integrator)) + "\"}";
    EXPECT_EQ(parsed(scene_with(step)).world.integrator, integrator) << step;
  }
  expect_starts(scene_with(R"("step": {"integrator": "leapfrog"})"), "f.json:2:24: step.integrator: ");
}

TEST(SceneParse, FillsInDefaults) {
  const Scene scene = parsed(R"({"psim": 1, "world": {"bounds": [0, 0, 1, 1]},
    "bodies": [{"shape": {"disc": {"radius": 0.5}}, "position": [0, 0]}]})");
  EXPECT_EQ(scene.world.boundary, Boundary::walls);
  EXPECT_EQ(scene.world.gravity.y, -9.81);
  EXPECT_EQ(scene.world.dt, 1.0 / 60);
  EXPECT_EQ(scene.world.substeps, 4);
  EXPECT_EQ(scene.world.integrator, Integrator::verlet);
  EXPECT_TRUE(scene.world.sleeping);
  EXPECT_EQ(scene.world.restitution_threshold, 0);
  EXPECT_EQ(scene.world.skin, 1);
  EXPECT_EQ(scene.bodies[0].type, BodyType::dynamic_body);
  EXPECT_EQ(scene.bodies[0].material.density, 1);
  EXPECT_EQ(scene.bodies[0].mass, 0);
}

TEST(SceneParse, AMaterialNamedWallIsTheWalls) {
  EXPECT_EQ(parsed(scene_with(R"("materials": {"wall": {"friction": 3}})")).world.wall.friction, 3);
}

TEST(SceneParse, ReadsGroups) {
  const Scene scene = parsed(scene_with(R"("groups": [
    {"layout": "hex", "count": 1e2, "region": [1, 2, 3, 4], "radius": [0.1, 0.2], "jitter": 0.5,
     "velocity": [1, 2], "velocity_spread": 3, "seed": 18446744073709551615, "density": 4},
    {"layout": "random", "count": 0, "region": [1, 2, 3, 4], "shape": {"disc": {"radius": 0.3}},
     "type": "static"},
    {"layout": "explicit", "x": [1, 2, 3], "y": [4, 5, 6], "radius": 0.5, "vx": [7, 8, 9]},
    {"layout": "explicit", "x": [1, 2], "y": [4, 5], "radius": [0.5, 0.25]}])"));
  ASSERT_EQ(scene.groups.size(), 4u);
  EXPECT_EQ(scene.groups[0].layout, Layout::hex);
  EXPECT_EQ(scene.groups[0].count, 100u);
  EXPECT_EQ(scene.groups[0].region.xmax, 3);
  EXPECT_EQ(scene.groups[0].radius_min, 0.1);
  EXPECT_EQ(scene.groups[0].radius_max, 0.2);
  EXPECT_EQ(scene.groups[0].jitter, 0.5);
  EXPECT_EQ(scene.groups[0].velocity.y, 2);
  EXPECT_EQ(scene.groups[0].velocity_spread, 3);
  EXPECT_EQ(scene.groups[0].seed, 18446744073709551615u);
  EXPECT_EQ(scene.groups[0].body.material.density, 4);
  EXPECT_EQ(scene.groups[1].radius_max, 0.3);
  EXPECT_EQ(scene.groups[1].body.type, BodyType::static_body);
  EXPECT_EQ(scene.groups[2].y[2], 6);
  EXPECT_EQ(scene.groups[2].radius, std::vector<double>{0.5});
  EXPECT_EQ(scene.groups[2].vx[1], 8);
  EXPECT_TRUE(scene.groups[2].vy.empty());
  EXPECT_EQ(scene.groups[3].radius_min, 0.25);
  EXPECT_EQ(scene.body_count(), 105u);
}

TEST(SceneParse, SaysWhereTextIsNotJson) {
  expect_starts("", "f.json:1:1: scene: the file is empty");
  expect_starts(" \n ", "f.json:2:2: scene: the file is empty");
  expect_starts("{", "f.json:1:2: scene: not valid JSON: unexpected end of input");
  expect_starts(kScene.substr(0, kScene.size() - 1), "f.json:7:1: scene: not valid JSON");
  expect_starts(std::string(kScene) + "x", "f.json:7:2: scene: not valid JSON");
  expect_starts(std::string(100, '\0'), "f.json:1:1: scene: a NUL byte");
  expect_starts(std::string(kScene) + '\0', "f.json:7:2: scene: a NUL byte");
  expect_starts("{\"psim\": 1,\n \"name\": nan}", "f.json:2:10: name: NaN and infinity");
  expect_starts(with("[0, 5]", "[NaN, 5]"), "f.json:5:88: bodies[0].position[0]: NaN and infinity");
  expect_starts(with("[0, 5]", "[0, -Infinity]"), "f.json:5:91: bodies[0].position[1]: NaN");
  expect_starts(with("0.5", "1e999"), "f.json:5:68: bodies[0].shape.disc.radius: 1e999 is too large");
  expect_starts(with("\"a\"", "\"\xFF\""), "f.json:5:16: bodies[0].name: not valid JSON");
  expect_starts(with("\"a\"", "'a'"), "f.json:5:15: bodies[0].name: not valid JSON");
  expect_starts(with("[0, 5]", "[0 5]"), "f.json:5:90: bodies[0].position[1]: not valid JSON");
  expect_starts(with("[0, 5] }", "[0, 5], }"), "f.json:5:95: bodies[0]: not valid JSON");
}

TEST(SceneParse, EveryBeginningOfASceneIsRefused) {
  for (std::size_t size = 0; size < kScene.size(); ++size) {
    EXPECT_NE(error_of(kScene.substr(0, size)), "") << size;
  }
}

TEST(SceneParse, DeepNestingIsAnErrorNotACrash) {
  constexpr std::size_t kDeep = 100000;
  expect_starts(std::string(kDeep, '['), "f.json:1:33: scene: is nested too deeply");
  expect_starts(std::string(kDeep, '[') + std::string(kDeep, ']'), "f.json:1:33: scene: is nested too deeply");
  std::string objects;
  for (std::size_t k = 0; k < kDeep; ++k) objects += "{\"[\":";
  expect_starts(objects, "f.json:1:161: scene: is nested too deeply");
}

TEST(SceneParse, AKeyThatStandsTwiceIsRefusedAtTheSecond) {
  expect_starts(with("\"name\": \"a\"", "\"name\": \"a\", \"name\": \"b\""),
                "f.json:5:20: bodies[0].name: the key stands twice");
  expect_starts(with("\"name\": \"a\"", "\"name\": \"a\", \"n\\u0061me\": \"b\""),
                "f.json:5:20: bodies[0].name: the key stands twice");
}

TEST(SceneParse, NamesUnknownKeysAndTheNearest) {
  EXPECT_EQ(error_of(with("\"gravity\"", "\"gravitty\"")),
            "f.json:3:68: world.gravitty: unknown key (did you mean \"gravity\"?); allowed: "
            "\"bounds\", \"boundary\", \"gravity\", \"linear_damping\", \"material\" or \"mixing\"");
  expect_starts(with("\"world\"", "\"my wrld\": 0, \"world\""), "f.json:3:3: [\"my wrld\"]: unknown key; allowed");
  expect_starts(with("\"name\"", "\"na\\nme\""),
                "f.json:5:7: bodies[0][\"na\\x0ame\"]: unknown key (did you mean \"name\"?)");
}

TEST(SceneParse, NamesMissingKeysAtTheirObject) {
  expect_starts("{}", "f.json:1:1: scene: the key \"psim\" is missing");
  expect_starts("{\"psim\": 1}", "f.json:1:1: scene: the key \"world\" is missing");
  expect_starts(with(", \"position\": [0, 5]", ""), "f.json:5:5: bodies[0]: the key \"position\" is missing");
  expect_starts(with("{\"radius\": 0.5}", "{}"), "f.json:5:57: bodies[0].shape.disc: the key \"radius\" is missing");
  expect_starts(with("{\"disc\": {\"radius\": 0.5}}", "{}"),
                "f.json:5:48: bodies[0].shape: has 0 kinds of shape: exactly one of \"disc\"");
}

TEST(SceneParse, NamesWrongTypes) {
  expect_starts("[]", "f.json:1:1: scene: must be an object, not an array");
  expect_starts("null", "f.json:1:1: scene: must be an object, not null");
  expect_starts(with("0.5", "\"a\""), "f.json:5:68: bodies[0].shape.disc.radius: must be a number from 1e-9 to 1e6");
  expect_starts(with("\"a\"", "7"), "f.json:5:15: bodies[0].name: must be a string, not a number");
  expect_starts(with("[0, 5]", "{}"), "f.json:5:87: bodies[0].position: must be an array of 2");
  expect_starts(with("[0, -9.81]", "[0]"), "f.json:3:79: world.gravity: has 1 element: 2 numbers");
  expect_starts(with("\"open\"", "\"oopen\""),
                "f.json:3:60: world.boundary: \"oopen\" is not known (did you mean \"open\"?)");
  expect_starts(with("\"dynamic\"", "\"dinamic\""), "f.json:5:28: bodies[0].type: \"dinamic\"");
  expect_starts(with("\"psim\": 1", "\"psim\": 9"), "f.json:2:11: psim: is not a format");
  expect_starts(with("\"psim\": 1", "\"psim\": \"1\""), "f.json:2:11: psim: is not a format");
}

TEST(SceneParse, NamesNumbersOutOfRange) {
  const auto radius = [](std::string_view text) { return with("0.5", text); };
  const std::string at = "f.json:5:68: bodies[0].shape.disc.radius: ";
  for (const std::string_view bad : {"-1", "0", "-0.0", "1e-400", "1000001", "1e300"}) {
    expect_starts(radius(bad), at);
  }
  EXPECT_EQ(error_of(radius("-1")), at + "-1 is out of range: a number from 1e-9 to 1e6");
  EXPECT_EQ(error_of(radius("1e-10")), at + "1e-10 is out of range: a number from 1e-9 to 1e6");
  EXPECT_EQ(error_of(radius("300")), at + "300 is larger than the world: at most 200, the longer side of world.bounds");
  expect_starts(with("[-100, -100, 100, 100]", "[100, 100, -100, -100]"),
                "f.json:3:24: world.bounds: [100, 100, -100, -100] is no area");
  expect_starts(with("[-100, -100, 100, 100]", "[-1e9, -1, 1e9, 1]"),
                "f.json:3:24: world.bounds: [-1e9, -1, 1e9, 1]: width and height from 1e-9 to 1e9 m");
  expect_starts(with("[0, 5]", "[0, 101]"), "f.json:5:87: bodies[0].position: [0, 101] is outside the world");
  for (const std::string_view bad :
       {"\"density\": 0", "\"density\": 2e9", "\"mass\": 0", "\"mass\": 2e12", "\"restitution\": 1.5",
        "\"friction\": -1", "\"gravity_scale\": 1e7", "\"angle\": 1e10"}) {
    expect_starts(with("\"name\": \"a\"", bad), "f.json:5:");
  }
  for (const std::string_view bad : {"\"dt\": 0", "\"dt\": 11", "\"substeps\": 0", "\"substeps\": 65",
                                     "\"substeps\": 1.5", "\"substeps\": -1", "\"sleeping\": 1"}) {
    expect_starts(scene_with("\"step\": {" + std::string(bad) + "}"), "f.json:2:");
  }
}

TEST(SceneParse, ColumnsCountCharacters) {
  expect_starts("{\"psim\": 1, \"name\": \"\xC3\xA4\xE2\x82\xAC\", \"x\": 1}", "f.json:1:27: x: unknown key");
  expect_starts("\xEF\xBB\xBF{\"psim\": 2}", "f.json:1:10: psim: is not a format");
  expect_starts("{\r\n\t\"psim\": 2}", "f.json:2:10: psim: is not a format");
}

TEST(SceneParse, ChecksMaterialsAndNames) {
  expect_starts(scene_with(R"("materials": {"steel": {}},
"bodies": [{"shape": {"disc": {"radius": 1}}, "position": [1, 1], "material": "steal"}])"),
                "f.json:3:79: bodies[0].material: no material \"steal\" (did you mean \"steel\"?)");
  expect_starts(scene_with(R"("bodies": [
{"name": "a", "shape": {"disc": {"radius": 1}}, "position": [1, 1]},
{"name": "a", "shape": {"disc": {"radius": 1}}, "position": [2, 2]}])"),
                "f.json:4:10: bodies[1].name: another body has the name \"a\"");
}

TEST(SceneParse, ChecksSegmentsAndChains) {
  const auto shape = [](std::string_view text) { return with("{\"disc\": {\"radius\": 0.5}}", text); };
  expect_starts(shape(R"({"segment": {"p1": [1, 1], "p2": [1, 1]}})"),
                "f.json:5:81: bodies[0].shape.segment.p2: is p1");
  expect_starts(shape(R"({"chain": {"vertices": [[1, 1]]}})"),
                "f.json:5:71: bodies[0].shape.chain.vertices: has 1 element: at least 2");
  expect_starts(shape(R"({"chain": {"vertices": [[0, 0], [1, 1]], "loop": true}})"),
                "f.json:5:71: bodies[0].shape.chain.vertices: has 2 elements: at least 3");
  expect_starts(shape(R"({"chain": {"vertices": [[0, 0], [1, 1], [1, 1]]}})"),
                "f.json:5:88: bodies[0].shape.chain.vertices[2]: is the vertex before it");
  expect_starts(shape(R"({"chain": {"vertices": [[0, 0], [1, 1], [0, 0]], "loop": true}})"),
                "f.json:5:88: bodies[0].shape.chain.vertices[2]: is the first vertex");
}

TEST(SceneParse, ChecksGroups) {
  const auto group = [](std::string_view keys) { return scene_with("\"groups\": [{" + std::string(keys) + "}]"); };
  const std::string placed = R"("layout": "lattice", "count": 4, "region": [1, 1, 9, 9])";
  expect_starts(group(R"("count": 4)"), "f.json:2:12: groups[0]: the key \"layout\" is missing");
  expect_starts(group(placed), "f.json:2:12: groups[0]: the key \"radius\" is missing");
  expect_starts(group(placed + R"(, "radius": 1, "shape": {"disc": {"radius": 1}})"),
                "f.json:2:70: groups[0].radius: stands beside \"shape\"");
  expect_starts(group(placed + R"(, "radius": [2, 1])"), "f.json:2:84: groups[0].radius[1]: is less");
  expect_starts(group(placed + R"(, "radius": 1, "x": [1])"), "f.json:2:83: groups[0].x: unknown");
  expect_starts(group(placed + R"(, "radius": 1, "name": "a")"), "f.json:2:83: groups[0].name: unkn");
  expect_starts(group(R"("layout": "hex", "count": 10000001, "region": [1, 1, 9, 9], "radius": 1)"),
                "f.json:2:39: groups[0].count: 10000001 is out of range: a whole number from 0 to");
  expect_starts(group(R"("layout": "hex", "count": 4, "region": [1, 1, 11, 9], "radius": 1)"),
                "f.json:2:52: groups[0].region: [1, 1, 11, 9] reaches out of the world");
  expect_starts(group(placed + R"(, "type": "static", "shape": {"chain": {"vertices": [[0, 0], [1, 0]]}})"),
                "f.json:2:97: groups[0].shape: is no shape of a group");
  const std::string listed = R"("layout": "explicit", "x": [1, 2], "radius": 1, "y": )";
  expect_starts(group(listed + "[1]"), "f.json:2:66: groups[0].y: has 1 element, \"x\" has 2");
  expect_starts(group(listed + "[1, 11]"), "f.json:2:70: groups[0].y[1]: 11 is outside the world");
  expect_starts(group(listed + R"([1, 2], "vx": [1, 2], "velocity": [1, 2])"),
                "f.json:2:88: groups[0].velocity: stands beside");
  expect_starts(group(listed + R"([1, 2], "seed": 1)"), "f.json:2:74: groups[0].seed: unknown key");
}

// Equal scenes have equal texts; that text keeps everything is the next test's.
TEST(SceneToJson, ReadsBackToTheSameText) {
  const Scene scene = parsed(R"({"psim": 1, "name": "q\"\\\u00e4", "description": "two\nlines",
    "world": {"bounds": [-1.1, -2e-7, 3e8, 4]},
    "materials": {"m": {"density": 0.1, "restitution": 1e-300}},
    "bodies": [{"type": "static", "position": [0.30000000000000004, 0],
                "shape": {"chain": {"vertices": [[0, 0], [1, -0.0]]}}},
               {"name": "b", "shape": {"disc": {"radius": 1}}, "position": [1, 1], "mass": 3,
                "material": "m"}],
    "groups": [{"layout": "random", "count": 3, "region": [0, 0, 1, 1], "radius": [0.1, 0.2],
                "seed": 18446744073709551615},
               {"layout": "explicit", "x": [], "y": [], "radius": []},
               {"layout": "explicit", "x": [1, 2], "y": [1, 2], "radius": [1, 2], "vy": [1, 0]},
               {"layout": "explicit", "x": [1], "y": [1], "radius": [0.5], "velocity": [1, 2]}],
    "fields": [{"type": "well", "position": [0, 0], "strength": -1e-9}, {"type": "drag"}]})");
  const std::string text = scene_to_json(scene);
  const Scene again = parsed(text);
  EXPECT_EQ(scene_to_json(again), text);
  EXPECT_EQ(again.name, scene.name);
  EXPECT_EQ(again.description, "two\nlines");
  EXPECT_EQ(again.bodies[0].position.x, 0.30000000000000004);
  EXPECT_EQ(again.bodies[1].material.density, 0.1);
  EXPECT_EQ(again.bodies[1].mass, 3);
  EXPECT_EQ(again.groups[0].seed, 18446744073709551615u);
  EXPECT_EQ(again.groups[2].radius, scene.groups[2].radius);
  EXPECT_EQ(again.groups[2].vy, scene.groups[2].vy);
  EXPECT_EQ(again.groups[3].velocity.y, 2);
  EXPECT_EQ(again.body_names, scene.body_names);
}

TEST(SceneToJson, EveryFieldChangesTheText) {
  Scene base = parsed(kScene);
  base.groups.emplace_back();
  const std::string text = scene_to_json(base);
  const auto differs = [&](auto change) {
    Scene other = base;
    change(other);
    return scene_to_json(other) != text;
  };
  EXPECT_TRUE(differs([](Scene& s) { s.world.boundary = Boundary::walls; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.linear_damping = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.wall.friction = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.dt = 0.01; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.substeps = 5; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.integrator = Integrator::euler; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.restitution_threshold = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.skin = 2; }));
  EXPECT_TRUE(differs([](Scene& s) { s.world.sleeping = false; }));
  EXPECT_TRUE(differs([](Scene& s) { s.seed = 2; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].angle = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].angular_velocity = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].velocity.x = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].material.restitution = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].gravity_scale = 2; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].fixed_rotation = true; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].bullet = true; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].sensor = true; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].filter.category = 2; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].filter.mask = 2; }));
  EXPECT_TRUE(differs([](Scene& s) { s.bodies[0].filter.group = -2; }));
  EXPECT_TRUE(differs([](Scene& s) { s.joints.emplace_back(); }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].links.emplace(); }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].body.shape = BoxShape{}; }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].jitter = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].velocity.y = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].velocity_spread = 1; }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].layout = Layout::hex; }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].body.type = BodyType::static_body; }));
  EXPECT_TRUE(differs([](Scene& s) { s.groups[0].body.mass = 1; }));
}

TEST(SceneToJson, EveryBuiltinSceneReadsBack) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    std::string error;
    const std::optional<Scene> scene = make_builtin(builtin.name, 0, 1, error);
    ASSERT_TRUE(scene) << error;
    const std::string text = scene_to_json(*scene);
    EXPECT_EQ(scene_to_json(parsed(text)), text) << builtin.name;
  }
}

TEST(LoadScene, ReadsAFileAndNamesOneThatItCannot) {
  std::string error;
  EXPECT_FALSE(load_scene("/nonexistent/scene.json", error));
  EXPECT_EQ(error, "/nonexistent/scene.json: cannot be read: No such file or directory");
  EXPECT_FALSE(load_scene("/", error));
  EXPECT_EQ(error, "/: cannot be read: Is a directory");

  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "psim_scene.json";
  std::ofstream(path) << kScene;
  EXPECT_TRUE(load_scene(path.string(), error)) << error;
  std::ofstream(path) << "{";
  EXPECT_FALSE(load_scene(path.string(), error));
  EXPECT_TRUE(error.starts_with(path.string() + ":1:2: ")) << error;
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace psim
