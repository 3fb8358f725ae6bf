// `--check`: each fault is named with its body and the setting that mends it; a sound scene says
// nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "psim/scene.h"

namespace psim::test {
namespace {

BodyDesc disc(double x, double y, double radius = 0.5) {
  BodyDesc body;
  body.shape = DiscShape{radius};
  body.position = {x, y};
  return body;
}

Scene scene_of(std::vector<BodyDesc> bodies) {
  Scene scene;
  scene.world.bounds = {0, 0, 100, 100};
  scene.bodies = std::move(bodies);
  scene.body_names.resize(scene.bodies.size());
  scene.body_names[0] = "first";
  return scene;
}

void expect_one_line(const Scene& scene, std::initializer_list<const char*> words) {
  const auto lines = check_scene(scene);
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  ASSERT_EQ(lines.size(), 1u) << all;
  EXPECT_EQ(lines[0].find('\n'), std::string::npos);
  for (const char* word : words) EXPECT_NE(lines[0].find(word), std::string::npos) << all;
}

TEST(SceneCheck, SoundSceneSaysNothing) {
  EXPECT_TRUE(check_scene(scene_of({disc(5, 5), disc(6, 5), disc(5, 0.5)})).empty());
}

TEST(SceneCheck, MassRatio) {
  Scene scene = scene_of({disc(5, 5), disc(9, 9)});
  scene.bodies[1].mass = 200;
  expect_one_line(scene, {"first", "bodies[1]", "200 kg", "density or mass"});
}

TEST(SceneCheck, SpeedAgainstSize) {
  Scene scene = scene_of({disc(5, 5), disc(9, 9)});
  scene.bodies[0].velocity = {30, 40};
  expect_one_line(scene, {"first", "50 m/s", "step.dt at most 0.01 s"});
  BodyDesc floor;
  floor.type = BodyType::static_body;
  floor.shape = SegmentShape{{0, 1}, {100, 1}};
  scene.bodies.push_back(floor);
  expect_one_line(scene, {"segments have no thickness"});
}

TEST(SceneCheck, RadiiOfVeryDifferentScale) {
  Scene scene = scene_of({disc(50, 50, 20), disc(9, 9, 0.01)});
  scene.world.gravity = {0, 0};
  for (BodyDesc& body : scene.bodies) body.mass = 1;
  expect_one_line(scene, {"very different scale", "first", "bodies[1]", "radius"});
}

TEST(SceneCheck, RadiusNearTheResolutionOfPositions) {
  Scene scene = scene_of({disc(5, 5, 1e-6)});
  scene.world.gravity = {0, 0};
  expect_one_line(scene, {"first", "world.bounds at most"});
}

TEST(SceneCheck, OverlapAtTheStart) {
  expect_one_line(scene_of({disc(5, 5), disc(5.75, 5)}), {"first", "bodies[1]", "overlap by 0.25 m", "position"});
  // Sizes far apart are met, too.
  expect_one_line(scene_of({disc(50, 50, 2), disc(50, 52.2, 0.25)}), {"overlap by 0.05 m"});
  Scene scene = scene_of({disc(5, 5), disc(50, 50)});
  BodyDesc floor;
  floor.type = BodyType::static_body;
  floor.shape = ChainShape{{{0, 1}, {10, 1}, {20, 1}}, false};
  floor.position = {0, 3.75};
  scene.bodies.push_back(floor);
  expect_one_line(scene, {"first", "bodies[2]", "overlap by 0.25 m"});
  scene.bodies[2].position = {0, 3.5};  // touching is no overlap
  EXPECT_TRUE(check_scene(scene).empty());
}

TEST(SceneCheck, StaticBodiesMayOverlap) {
  Scene scene = scene_of({disc(5, 5), disc(5.5, 5)});
  for (BodyDesc& body : scene.bodies) body.type = BodyType::static_body;
  EXPECT_TRUE(check_scene(scene).empty());
}

TEST(SceneCheck, BodyThatReachesOutOfTheWalls) {
  expect_one_line(scene_of({disc(0.25, 5)}), {"first", "out of the walls", "world.bounds"});
  Scene scene = scene_of({disc(0.25, 5)});
  scene.world.boundary = Boundary::open;
  EXPECT_TRUE(check_scene(scene).empty());
}

TEST(SceneCheck, GravityAgainstSize) {
  Scene scene = scene_of({disc(5, 5)});
  scene.world.gravity = {0, -3600};
  expect_one_line(scene, {"first", "gravity moves a body 1 m", "step.dt at most 0.00833 s"});
}

TEST(SceneCheck, RestitutionWithFewSubsteps) {
  Scene scene = scene_of({disc(5, 5)});
  scene.bodies[0].material.restitution = 1;
  EXPECT_TRUE(check_scene(scene).empty());
  scene.world.substeps = 1;
  expect_one_line(scene, {"first", "restitution 1", "step.substeps at least 4"});
}

TEST(SceneCheck, LongFrames) {
  Scene scene = scene_of({disc(5, 5)});
  scene.world.dt = 0.05;
  expect_one_line(scene, {"step.dt is 0.05", "1/60"});
}

TEST(SceneCheck, GroupThatDoesNotFit) {
  Scene scene = scene_of({disc(5, 5)});
  GroupDesc group;
  group.count = 100;
  group.region = {10, 10, 15, 15};
  scene.groups.push_back(group);
  expect_one_line(scene, {"groups[0]: a cell of the lattice"});
}

}  // namespace
}  // namespace psim::test
