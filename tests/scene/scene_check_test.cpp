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

BodyDesc peg(double x, double y) {
  BodyDesc body = disc(x, y, 0.1);
  body.type = BodyType::static_body;
  return body;
}

SceneJoint rod(std::uint64_t a, std::uint64_t b, std::optional<double> length = {}) {
  SceneJoint j;
  j.a = a;
  j.b = b;
  j.joint.length = length;
  return j;
}

// Others may say that the anchors are elsewhere at the start.
void expect_last_line(const Scene& scene, const std::string& begin) {
  const auto lines = check_scene(scene);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back().substr(0, begin.size()), begin);
}

TEST(SceneCheck, SupportsWithoutSlackAndOutOfReach) {
  Scene scene = scene_of({peg(10, 50), disc(12, 50), disc(14, 50), peg(16, 50)});
  scene.joints = {rod(0, 1), rod(1, 2), rod(2, 3)};
  expect_one_line(scene, {"joints 0 and 2", "no slack over 6 m", "longer"});
  for (const std::uint64_t k : {1u, 2u}) scene.bodies[k].position.y = 49;
  EXPECT_TRUE(check_scene(scene).empty());  // it hangs
  scene.bodies = {peg(10, 56), disc(10, 54), disc(10, 52), peg(10, 50)};
  EXPECT_TRUE(check_scene(scene).empty());  // no load is across
  scene.bodies = {peg(10, 50), disc(12, 50), disc(14, 50), peg(16, 50)};
  scene.world.gravity = {0, 0};
  EXPECT_TRUE(check_scene(scene).empty());
  for (SceneJoint& j : scene.joints) j.joint.length = 1.95;
  expect_last_line(scene,
                   "joints 0 and 2: the way through joints from one support to the other is 5.85 m long, and they "
                   "are 6 m apart: joints will stretch");
}

TEST(SceneCheck, LoopThatCannotClose) {
  Scene scene = scene_of({disc(10, 50), disc(12, 50), disc(11, 51.5)});
  scene.joints = {rod(0, 1, 2), rod(1, 2), rod(2, 0)};
  EXPECT_TRUE(check_scene(scene).empty());
  for (const std::size_t k : {1u, 2u}) scene.joints[k].joint.length = 1.803;
  scene.joints[0].joint.length = 4;
  expect_last_line(scene,
                   "joints[0]: its length is 4 m, but other joints keep its anchors within 3.606 m: the loop cannot");
}

TEST(SceneCheck, RodsShorterThanBodiesAndWallsAllow) {
  Scene scene = scene_of({disc(10, 50), disc(11.02, 50), peg(0, 20), disc(0.6, 20)});
  scene.joints = {rod(0, 1, 1.02)};
  EXPECT_TRUE(check_scene(scene).empty());
  scene.joints[0].joint.collide = true;
  scene.joints[0].joint.length = 0.99;
  scene.bodies[1].position.x = 11;
  expect_last_line(scene, "joints[0]: its length is 0.99 m, but its bodies touch at 1 m and collide");
  scene.joints = {rod(2, 3, 0.49)};
  expect_last_line(scene, "joints[0]: its length is 0.49 m, but a disc of radius 0.5 m between the walls stays 0.5 m");
}

}  // namespace
}  // namespace psim::test
