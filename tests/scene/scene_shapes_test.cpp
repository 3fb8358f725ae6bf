// Scene files with boxes, polygons, capsules, segments and chains: what good ones become, what is
// said of bad ones and where, and what `--check` says of those that are put right.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <variant>

#include "place/placement.h"
#include "place/shape_size.h"
#include "psim/scene.h"
#include "scene_text.h"

namespace psim::test {
namespace {

std::string body_with(std::string_view keys) {
  return scene_text("\"bodies\": [{\"position\": [1, 2], " + std::string(keys) + "}]");
}

std::string shape_text(std::string_view shape) { return body_with("\"shape\": {" + std::string(shape) + "}"); }

std::string polygon_text(std::string_view vertices) {
  return shape_text("\"polygon\": {\"vertices\": [" + std::string(vertices) + "]}");
}

Shape shape_of(const std::string& text) {
  const Scene scene = parsed_scene(text);
  return scene.bodies.empty() ? Shape{} : scene.bodies[0].shape;
}

TEST(SceneShapes, AreRead) {
  const auto box = std::get<BoxShape>(shape_of(shape_text(R"("box": {"size": [2, 3]})")));
  EXPECT_EQ(box.width, 2);
  EXPECT_EQ(box.height, 3);
  EXPECT_EQ(box.radius, 0);
  EXPECT_EQ(std::get<BoxShape>(shape_of(shape_text(R"("box": {"size": [2, 3], "radius": 0.25})"))).radius, 0.25);
  const auto polygon = std::get<PolygonShape>(
      shape_of(shape_text(R"("polygon": {"vertices": [[0, 0], [1, 0], [0, 2]], "radius": 0.5})")));
  ASSERT_EQ(polygon.vertices.size(), 3u);
  EXPECT_EQ(polygon.vertices[2].y, 2);
  EXPECT_EQ(polygon.radius, 0.5);
  const auto capsule =
      std::get<CapsuleShape>(shape_of(shape_text(R"("capsule": {"p1": [0, -1], "p2": [0, 1], "radius": 0.5})")));
  EXPECT_EQ(capsule.p1.y, -1);
  EXPECT_EQ(capsule.radius, 0.5);
  EXPECT_EQ(std::get<SegmentShape>(shape_of(shape_text(R"("segment": {"p1": [0, 0], "p2": [3, 0]})"))).p2.x, 3);
}

TEST(SceneShapes, ChainsMayBeKinematicAndSegmentsAnything) {
  for (const std::string_view type : {"static", "kinematic"}) {
    const Scene scene = parsed_scene(
        body_with("\"type\": \"" + std::string(type) + R"(", "shape": {"chain": {"vertices": [[0, 0], [1, 0]]}})"));
    EXPECT_TRUE(std::holds_alternative<ChainShape>(scene.bodies.at(0).shape));
  }
  expect_refused(shape_text(R"("chain": {"vertices": [[0, 0], [1, 0]]})"), "bodies[0].shape.chain",
                 "a chain is \"static\" or \"kinematic\" only");
}

TEST(SceneShapes, FiltersAndSensorsAreRead) {
  const Scene scene = parsed_scene(body_with(
      R"("shape": {"box": {"size": [1, 1]}}, "type": "static", "category": 4294967295, "mask": 0,
         "group": -2147483647, "sensor": true)"));
  const BodyDesc& body = scene.bodies.at(0);
  EXPECT_EQ(body.filter, (Filter{0xFFFFFFFFu, 0, -2147483647}));
  EXPECT_TRUE(body.sensor);
  EXPECT_EQ(parsed_scene(shape_text(R"("disc": {"radius": 1})")).bodies.at(0).filter, Filter{});
}

TEST(SceneShapes, BadOnesAreRefusedAtTheirPlace) {
  struct Bad {
    std::string_view shape, path, words;
  };
  const Bad all[] = {
      {R"("box": {})", "bodies[0].shape.box", "\"size\" is missing"},
      {R"("box": {"size": 1})", "bodies[0].shape.box.size", "array of 2 numbers"},
      {R"("box": {"size": [1]})", "bodies[0].shape.box.size", "has 1 element"},
      {R"("box": {"size": [0, 1]})", "bodies[0].shape.box.size[0]", "from 1e-9 to 1e6"},
      {R"("box": {"size": [1, -2]})", "bodies[0].shape.box.size[1]", "-2 is out of range"},
      {R"("box": {"size": [1, 2e6]})", "bodies[0].shape.box.size[1]", "from 1e-9 to 1e6"},
      {R"("box": {"size": [1, 1e-12]})", "bodies[0].shape.box.size[1]", "from 1e-9 to 1e6"},
      {R"("box": {"size": [1, 1], "radius": -1})", "bodies[0].shape.box.radius", "out of range"},
      {R"("box": {"width": 1})", "bodies[0].shape.box.width", "unknown key"},
      {R"("polygon": {})", "bodies[0].shape.polygon", "\"vertices\" is missing"},
      {R"("polygon": {"vertices": [[0, 0], [1, 0]]})", "bodies[0].shape.polygon.vertices", "has 2 elements"},
      {R"("polygon": {"vertices": [[0, 0], [1, 0], [0]]})", "bodies[0].shape.polygon.vertices[2]", "has 1 element"},
      {R"("polygon": {"vertices": [[0, 0], [1, 0], [0, "1"]]})", "bodies[0].shape.polygon.vertices[2][1]",
       "must be a number"},
      {R"("polygon": {"vertices": [[0, 0], [1, 0], [0, 1]], "radius": 1e7})", "bodies[0].shape.polygon.radius",
       "out of range"},
      {R"("capsule": {"p1": [0, 0], "p2": [1, 0]})", "bodies[0].shape.capsule", "\"radius\" is missing"},
      {R"("capsule": {"p1": [1, 0], "p2": [1, 0], "radius": 1})", "bodies[0].shape.capsule.p2", "is p1"},
      {R"("capsule": {"p1": [0, 0], "p2": [1, 0], "radius": 0})", "bodies[0].shape.capsule.radius", "from 1e-9 to 1e6"},
      {R"("capsule": {"p1": [0, 0], "p2": [1, 0], "radius": 101})", "bodies[0].shape.capsule.radius",
       "larger than the world"},
      {R"("segment": {"p1": [0, 0]})", "bodies[0].shape.segment", "\"p2\" is missing"},
      {R"("segment": {"p1": [0, 0], "p2": [1e-12, 0]})", "bodies[0].shape.segment", "from 1e-9 to 1e9"},
      {R"("boxx": {"size": [1, 1]})", "bodies[0].shape.boxx", "did you mean \"box\""},
      {R"("box": {"size": [1, 1]}, "disc": {"radius": 1})", "bodies[0].shape", "has 2 kinds of shape"}};
  for (const Bad& bad : all) expect_refused(shape_text(bad.shape), bad.path, bad.words);
}

TEST(SceneShapes, SeveralMakeOneBody) {
  const Scene scene = parsed_scene(scene_text(R"("bodies": [{"position": [1, 2], "shapes": [
      {"box": {"size": [2, 0.2]}},
      {"disc": {"radius": 0.25}, "position": [1, 0.5], "angle": 0.5, "density": 3, "restitution": 0.4, "friction": 0.1}]}],
    "groups": [{"layout": "explicit", "x": [1], "y": [2], "shapes": [{"capsule": {"p1": [0, 0], "p2": [1, 0.1],
      "radius": 0.3}, "position": [0.5, 0]}]}])"));
  const auto& parts = std::get<CompoundShape>(scene.bodies[0].shape).parts;
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(std::get<BoxShape>(parts[0].shape).width, 2);
  EXPECT_FALSE(parts[0].density || parts[0].restitution || parts[0].friction);
  EXPECT_EQ(std::get<DiscShape>(parts[1].shape).radius, 0.25);
  EXPECT_EQ(parts[1].position.y, 0.5);
  EXPECT_EQ(parts[1].angle, 0.5);
  EXPECT_EQ(parts[1].density, 3);
  EXPECT_EQ(parts[1].restitution, 0.4);
  EXPECT_EQ(parts[1].friction, 0.1);
  EXPECT_NEAR(scene.groups[0].radius_max, std::hypot(1.5, 0.1) + 0.3, 1e-12);
  const std::string text = scene_to_json(scene);
  EXPECT_EQ(scene_to_json(parsed_scene(text)), text);
  EXPECT_NE(text.find("\"position\": [1, 0.5]"), std::string::npos);
}

TEST(SceneShapes, PartsAreRefusedAtTheirPlace) {
  const auto shapes = [](std::string_view list) { return body_with("\"shapes\": [" + std::string(list) + "]"); };
  expect_refused(shapes(""), "bodies[0].shapes", "at least 1");
  expect_refused(shapes("{}"), "bodies[0].shapes[0]", "has 0 kinds of shape");
  expect_refused(shapes(R"({"disc": {"radius": 1}}, {"disc": {"radius": 0}})"), "bodies[0].shapes[1].disc.radius",
                 "from 1e-9");
  expect_refused(shapes(R"({"disc": {"radius": 1}, "box": {"size": [1, 1]}})"), "bodies[0].shapes[0]",
                 "has 2 kinds of shape");
  expect_refused(shapes(R"({"disc": {"radius": 1}, "density": 0})"), "bodies[0].shapes[0].density", "from 1e-9");
  expect_refused(shapes(R"({"disc": {"radius": 1}, "friction": -1})"), "bodies[0].shapes[0].friction", "0 to 1000");
  expect_refused(shapes(R"({"disc": {"radius": 1}, "mass": 1})"), "bodies[0].shapes[0].mass", "unknown key");
  expect_refused(shapes(R"({"chain": {"vertices": [[0, 0], [1, 0]]}})"), "bodies[0].shapes[0].chain", "dynamic body");
  expect_refused(shapes(R"({"shapes": []})"), "bodies[0].shapes[0].shapes", "unknown key");
  expect_refused(body_with(R"("shape": {"disc": {"radius": 1}}, "shapes": [{"disc": {"radius": 1}}])"),
                 "bodies[0].shapes", "one of the two");
  expect_refused(scene_text(R"("groups": [{"layout": "explicit", "x": [1], "y": [2], "radius": 1,
      "shapes": [{"disc": {"radius": 1}}]}])"),
                 "groups[0].radius", "one of the two");
}

TEST(SceneShapes, OutlinesAreCutWhenTheyAreRead) {
  const std::string l = R"("outline": {"vertices": [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], "radius": 0.1})";
  for (const std::string_view type : {"static", "kinematic", "dynamic"}) {
    const std::string keys = "\"type\": \"" + std::string(type) + "\", \"shape\": {" + l + "}";
    const Shape shape = shape_of(body_with(keys));
    const auto& parts = std::get<CompoundShape>(shape).parts;
    ASSERT_EQ(parts.size(), 2u);
    for (const ShapePart& part : parts) EXPECT_EQ(std::get<PolygonShape>(part.shape).radius, 0.1);
  }
  const auto convex = std::get<PolygonShape>(
      shape_of(shape_text(R"("outline": {"vertices": [[0, 0], [0, 2], [2, 2], [1, 0], [0, 0]]})")));
  EXPECT_EQ(convex.vertices.size(), 4u);
  const Scene scene = parsed_scene(scene_text(R"("groups": [{"layout": "explicit", "x": [1], "y": [2], "shape": {)" +
                                              l +
                                              R"(}}], "bodies": [{"position": [1, 2], "shapes": [
      {"disc": {"radius": 0.25}}, {)" + l + R"(, "position": [5, 0], "angle": 1.5, "density": 3, "friction": 0.2},
      {"box": {"size": [1, 1]}}]}])"));
  EXPECT_NEAR(scene.groups[0].radius_max, std::hypot(3, 1) + 0.1, 1e-12);
  const auto& parts = std::get<CompoundShape>(scene.bodies[0].shape).parts;
  ASSERT_EQ(parts.size(), 4u);
  double farthest = 0;
  for (const ShapePart& part : {parts[1], parts[2]}) {
    EXPECT_EQ(part.angle, 1.5);
    EXPECT_EQ(part.density, 3);
    EXPECT_EQ(part.friction, 0.2);
    for (const Vec2 v : std::get<PolygonShape>(part.shape).vertices) {
      const Vec2 at = to_world(v, part.position, part.angle);
      farthest = std::max(farthest, std::hypot(at.x - 5, at.y));
    }
  }
  EXPECT_NEAR(farthest, std::hypot(3, 1), 1e-12);
  EXPECT_TRUE(std::holds_alternative<BoxShape>(parts[3].shape));
  const std::string text = scene_to_json(scene);
  EXPECT_EQ(scene_to_json(parsed_scene(text)), text);
}

TEST(SceneShapes, OutlinesThatAreNoneAreRefused) {
  const std::string path = "bodies[0].shape.outline";
  expect_refused(shape_text(R"("outline": {"vertices": [[0, 0], [1, 1], [1, 0], [0, 1]]})"), path,
                 "an outline must not cross or touch itself; its edges from vertex 0 to vertex 1 and from vertex 2 to "
                 "vertex 3 do");
  expect_refused(shape_text(R"("outline": {"vertices": [[0, 0], [1, 1], [2, 2]]})"), path, "must have an area");
  expect_refused(shape_text(R"("outline": {"vertices": [[0, 0], [1, 1]]})"), path + ".vertices", "has 2 elements");
  expect_refused(shape_text(R"("outline": {})"), path, "\"vertices\" is missing");
  expect_refused(shape_text(R"("outline": {"vertices": [[0, 0], [1, 0], [0, 1]], "radius": -1})"), path + ".radius",
                 "0 to 1e6");
  expect_refused(shape_text(R"("outline": {"vertices": [[0, 0], [1, 0], [0, 1]], "loop": true})"), path + ".loop",
                 "unknown key");
  expect_refused(body_with(R"("shapes": [{"disc": {"radius": 1}},
                              {"outline": {"vertices": [[0, 0], [1, 1], [1, 0], [0, 1]]}}])"),
                 "bodies[0].shapes[1].outline", "cross or touch");
}

TEST(SceneShapes, PolygonsThatAreNoneAreRefused) {
  const std::string path = "bodies[0].shape.polygon";
  // Concave; a bow tie; a five-pointed star; on a line; all in one point; more than eight.
  expect_refused(polygon_text("[0, 0], [2, 0], [2, 2], [1, 0.5], [0, 2]"), path, "convex");
  expect_refused(polygon_text("[0, 0], [1, 1], [1, 0], [0, 1]"), path, "convex");
  expect_refused(polygon_text("[0, 3], [1.76, -2.43], [-2.85, 0.93], [2.85, 0.93], [-1.76, -2.43]"), path, "cross");
  expect_refused(polygon_text("[0, 0], [1, 1], [2, 2]"), path, "area");
  expect_refused(polygon_text("[1, 1], [1, 1], [1, 1]"), path, "1e-9");
  expect_refused(polygon_text("[0, 0], [1, 0], [2, 1], [2, 2], [1, 3], [0, 3], [-1, 2], [-1, 1], "
                              "[-0.5, 0.4]"),
                 path + ".vertices", "at most 8");
}

TEST(SceneShapes, BodyKeysThatDoNotFitAreRefused) {
  const std::string box = R"("shape": {"box": {"size": [1, 1]}}, )";
  expect_refused(body_with(box + R"("sensor": 1)"), "bodies[0].sensor", "true or false");
  expect_refused(body_with(box + R"("category": -1)"), "bodies[0].category", "0 to 4294967295");
  expect_refused(body_with(box + R"("mask": 4294967296)"), "bodies[0].mask", "0 to 4294967295");
  expect_refused(body_with(box + R"("mask": "all")"), "bodies[0].mask", "whole number");
  expect_refused(body_with(box + R"("group": 1.5)"), "bodies[0].group", "not whole");
  expect_refused(body_with(box + R"("group": 3e9)"), "bodies[0].group", "-2147483647 to 2147483647");
}

TEST(SceneShapes, GroupsAreOfAnyShapeButChains) {
  const auto group = [](std::string_view keys) {
    return scene_text(R"("groups": [{"layout": "lattice", "count": 4, "region": [0, 0, 4, 4], )" + std::string(keys) +
                      "}]");
  };
  const Scene scene = parsed_scene(group(R"("shape": {"box": {"size": [0.6, 0.8]}}, "angle": 1)"));
  EXPECT_EQ(std::get<BoxShape>(scene.groups.at(0).body.shape).height, 0.8);
  EXPECT_EQ(scene.groups[0].radius_max, 0.5);
  EXPECT_EQ(scene.groups[0].body.angle, 1);
  EXPECT_EQ(scene.body_count(), 4u);
  std::string error;
  const auto placed = place_group(scene.groups[0], error);
  ASSERT_TRUE(placed) << error;
  EXPECT_EQ(placed->x, (std::vector<double>{1, 3, 1, 3}));
  // A cell holds the circle around the shape.
  EXPECT_TRUE(place_group(parsed_scene(group(R"("shape": {"box": {"size": [1.2, 1.6]}})")).groups[0], error));
  EXPECT_FALSE(place_group(parsed_scene(group(R"("shape": {"box": {"size": [1.5, 1.5]}})")).groups[0], error));
  EXPECT_NE(error.find("smaller than a body of 2.1213"), std::string::npos) << error;
  // A disc is a radius, however it is said.
  EXPECT_EQ(parsed_scene(group(R"("shape": {"disc": {"radius": 0.25}})")).groups[0].radius_min, 0.25);
  expect_refused(group(R"("type": "static", "shape": {"chain": {"vertices": [[0, 0], [1, 0]]}})"), "groups[0].shape",
                 "chains stand in \"bodies\"");
  const Scene listed = parsed_scene(scene_text(R"("groups": [{"layout": "explicit", "x": [1, 2],
      "y": [3, 4], "shape": {"capsule": {"p1": [-1, 0], "p2": [1, 0], "radius": 0.25}}}])"));
  EXPECT_EQ(listed.groups[0].radius_max, 1.25);
  EXPECT_EQ(listed.body_count(), 2u);
}

TEST(SceneShapes, ReadBackFromTheirText) {
  const Scene scene = parsed_scene(scene_text(R"("bodies": [
      {"position": [0, 0], "shape": {"box": {"size": [1, 0.1], "radius": 0.3}}, "category": 3},
      {"position": [0, 0], "shape": {"polygon": {"vertices": [[0, 0], [0, 1], [1, 0]]}}, "mask": 5},
      {"position": [0, 0], "shape": {"polygon": {"vertices": [[0, 0], [1, 0], [0, 1]],
                                                 "radius": 0.7}}, "group": -3},
      {"position": [0, 0], "shape": {"capsule": {"p1": [0, 0], "p2": [1, 0.1], "radius": 0.3}}},
      {"position": [0, 0], "shape": {"segment": {"p1": [0, 0], "p2": [1, 0.1]}},
       "type": "kinematic", "sensor": true}],
    "groups": [{"layout": "explicit", "x": [1], "y": [2], "shape": {"box": {"size": [1, 2]}}},
               {"layout": "hex", "count": 2, "region": [0, 0, 9, 9],
                "shape": {"segment": {"p1": [0, 0], "p2": [1, 0.1]}}}])"));
  const std::string text = scene_to_json(scene);
  const Scene again = parsed_scene(text);
  EXPECT_EQ(scene_to_json(again), text);
  EXPECT_EQ(std::get<BoxShape>(again.bodies.at(0).shape).radius, 0.3);
  EXPECT_EQ(std::get<PolygonShape>(again.bodies.at(1).shape).vertices[1].y, 1);
  EXPECT_EQ(std::get<PolygonShape>(again.bodies.at(2).shape).radius, 0.7);
  EXPECT_EQ(std::get<CapsuleShape>(again.bodies.at(3).shape).p2.y, 0.1);
  EXPECT_EQ(again.bodies.at(1).filter.mask, 5u);
  EXPECT_EQ(again.bodies.at(2).filter.group, -3);
  EXPECT_TRUE(again.bodies.at(4).sensor);
  EXPECT_EQ(std::get<BoxShape>(again.groups.at(0).body.shape).height, 2);
  EXPECT_TRUE(std::holds_alternative<SegmentShape>(again.groups.at(1).body.shape));
}

TEST(SceneShapes, ExtentFollowsTheAngle) {
  const double quarter = std::acos(0.0);
  const Bounds box = extent(BoxShape{4, 2, 0.5}, {10, 20}, quarter);
  EXPECT_NEAR(box.xmin, 8.5, 1e-12);
  EXPECT_NEAR(box.ymax, 22.5, 1e-12);
  EXPECT_EQ(bounding_radius(BoxShape{6, 8, 1}), 6);
  EXPECT_EQ(bounding_radius(CapsuleShape{{0, 3}, {4, 0}, 1}), 5);
}

// ---- --check --------------------------------------------------------------------------------------

TEST(SceneShapesCheck, SaysWhatOfAPolygonIsPutRight) {
  EXPECT_EQ(check_lines(polygon_text("[0, 0], [1, 0], [0, 1]")), "");
  EXPECT_NE(check_lines(polygon_text("[0, 0], [0, 1], [1, 0]")).find("clockwise"), std::string::npos);
  const std::string straight = check_lines(polygon_text("[0, 0], [0.5, 0], [1, 0], [1, 0], [0, 1]"));
  EXPECT_NE(straight.find("2 of the polygon's 5 vertices"), std::string::npos) << straight;
}

TEST(SceneShapesCheck, BoxOnTheFloorIsInsideAndStandsFree) {
  const std::string stack = R"("bodies": [
    {"position": [0, -49.5], "shape": {"box": {"size": [2, 1]}}},
    {"position": [0, -48.5], "shape": {"box": {"size": [2, 1]}}},
    {"position": [2, -49.5], "shape": {"box": {"size": [2, 1]}}, "angle": 0}])";
  EXPECT_EQ(check_lines(scene_text(stack)), "");
  const std::string low =
      check_lines(scene_text(R"("bodies": [{"position": [0, -49.75], "shape": {"box": {"size": [2, 1]}}}])"));
  EXPECT_NE(low.find("out of the walls"), std::string::npos) << low;
}

TEST(SceneShapesCheck, ShapesThatOverlapAreFound) {
  const auto two = [](std::string_view more) {
    return scene_text(R"("bodies": [{"position": [0, 0], "shape": {"box": {"size": [2, 2]}}},
      {"position": [1.875, 0], "shape": {"box": {"size": [2, 2]}})" +
                      std::string(more) + "}]");
  };
  EXPECT_NE(check_lines(two("")).find("overlap by 0.125 m"), std::string::npos) << check_lines(two(""));
  EXPECT_EQ(check_lines(two(R"(, "mask": 0)")), "");
  EXPECT_EQ(check_lines(two(R"(, "type": "static", "sensor": true)")), "");
}

TEST(SceneShapesCheck, PartsThatOverlapOthersAreFound) {
  // A gate of two posts, and a box between them or in one of them.
  const auto gate = [](std::string_view type, std::string_view x) {
    return scene_text(R"("bodies": [{"position": )" + std::string(x) + R"(, "shape": {"box": {"size": [1, 1]}}},
      {"position": [5, 5], "angle": 1.5707963267948966, "type": )" +
                      std::string(type) +
                      R"(, "shapes": [{"box": {"size": [4, 1]}, "position": [0, 2]},
                        {"box": {"size": [4, 1]}, "position": [0, -2]}, {"segment": {"p1": [3, 0], "p2": [4, 0]}}]}])");
  };
  for (const std::string_view type : {"\"static\"", "\"kinematic\""}) {
    EXPECT_EQ(check_lines(gate(type, "[5, 5]")), "") << type;
    EXPECT_NE(check_lines(gate(type, "[6.25, 5]")).find("overlap by 0.25 m"), std::string::npos) << type;
  }
  EXPECT_NE(check_lines(gate("\"static\"", "[5.25, 8.5]")).find("overlap"), std::string::npos) << "its line";
}

}  // namespace
}  // namespace psim::test
