// What is called wrong with a state, on states whose errors are known.
#include <gtest/gtest.h>

#include <cmath>

#include "errors.h"
#include "outlines.h"

namespace psim::peers::test {
namespace {

using namespace accuracy;
using Watched = accuracy::Run;  // GoogleTest has a Run, too

/// A state that stands still.
class Still : public Simulation {
 public:
  explicit Still(std::vector<BodyState> bodies) : bodies_(std::move(bodies)) {}
  void advance() override {}
  void read(std::vector<BodyState>& bodies) override { bodies = bodies_; }
  void set_velocity(std::size_t, Vec2, double) override {}
  double row_visits() const override { return 0; }

 private:
  std::vector<BodyState> bodies_;
};

/// The scene's bodies where they are, the last one moved.
Run still(const Model& model, Vec2 shift = {}, double turn = 0) {
  std::vector<BodyState> states;
  for (const BodyDesc& b : model.bodies) {
    BodyState s;
    s.x = b.position.x;
    s.y = b.position.y;
    s.angle = b.angle;
    s.type = b.type;
    states.push_back(s);
  }
  states.back().x += shift.x;
  states.back().y += shift.y;
  states.back().angle += turn;
  return Run(model, std::make_unique<Still>(std::move(states)));
}

double deepest_of(const Scene& scene, Vec2 shift = {}, double turn = 0) {
  const Model model = make_model(scene);
  Watched run = still(model, shift, turn);
  const auto depths = overlaps(run);
  return depths.empty() ? 0 : depths.back();
}

Scene two(const BodyDesc& a, const BodyDesc& b) {
  Scene scene = open_scene(100);
  scene.bodies = {a, b};
  return scene;
}

TEST(PeerErrors, OverlapIsTheShortestWayOut) {
  const Material m = material(0);
  const Scene discs = two(disc({0, 0}, {0, 0}, m), disc({1, 0}, {0, 0}, m));
  EXPECT_EQ(deepest_of(discs, {0.01, 0}), 0);
  EXPECT_NEAR(deepest_of(discs, {-0.1, 0}), 0.1, 1e-12);
  const Scene boxes = two(box({0, 0}, {2, 1}, m), box({1.5, 1}, {2, 1}, m));
  EXPECT_NEAR(deepest_of(boxes, {0, -0.05}), 0.05, 1e-12);
  EXPECT_EQ(deepest_of(boxes, {0, 0.05}), 0);
  // A corner down, by 45 degrees.
  EXPECT_NEAR(deepest_of(two(box({0, 0}, {4, 1}, m), box({0, 1.2}, {1, 1}, m)), {}, std::atan(1)),
              0.5 + std::sqrt(0.5) - 1.2, 1e-12);
  const Scene mixed = two(box({0, 0}, {2, 1}, m), disc({0, 1}, {0, 0}, m));
  EXPECT_NEAR(deepest_of(mixed, {0, -0.2}), 0.2, 1e-12);
  EXPECT_NEAR(deepest_of(mixed, {0, -0.75}), 0.75, 1e-12);  // the centre inside
  EXPECT_NEAR(deepest_of(mixed, {1.3, -0.1}), 0.5 - std::hypot(0.3, 0.4), 1e-12);
}

TEST(PeerErrors, OverlapLeavesOutWhatMayNotTouch) {
  const Material m = material(0);
  Scene scene = two(disc({0, 0}, {0, 0}, m), disc({1, 0}, {0, 0}, m));
  join(scene, JointType::distance, 0, 1);
  EXPECT_EQ(deepest_of(scene, {-0.5, 0}), 0);
  scene.joints[0].joint.collide = true;
  EXPECT_NEAR(deepest_of(scene, {-0.5, 0}), 0.5, 1e-12);
  for (BodyDesc& body : scene.bodies) body.filter.group = -1;
  EXPECT_EQ(deepest_of(scene, {-0.5, 0}), 0);
}

TEST(PeerErrors, WallsCount) {
  Scene scene = walled_scene(10, 10, material(0));
  scene.bodies = {box({5, 0.5}, {1, 1}, material(0))};
  EXPECT_NEAR(deepest_of(scene, {0, -0.25}), 0.25, 1e-12);
  EXPECT_NEAR(deepest_of(scene, {4.75, 1}), 0.25, 1e-12);
}

TEST(PeerErrors, BodiesBeyondWallsAreCountedAndNotDeep) {
  Scene scene = walled_scene(10, 10, material(0));
  scene.bodies = {box({5, 0.5}, {1, 1}, material(0)), disc({5, 5}, {0, 0}, material(0))};
  const Model model = make_model(scene);
  Watched inside = still(model), outside = still(model, {0, -6});
  EXPECT_EQ(passed_walls(inside), 0);
  EXPECT_EQ(passed_walls(outside), 1);
  EXPECT_TRUE(overlaps(outside).empty());
}

TEST(PeerErrors, JointGapIsOfTheWorstJoint) {
  Scene scene = two(disc({0, 0}, {0, 0}, material(0)), disc({3, 4}, {0, 0}, material(0)));
  const auto gap = [&](Vec2 shift) {
    const Model model = make_model(scene);
    Watched run = still(model, shift);
    return joint_gap(run);
  };
  join(scene, JointType::distance, 0, 1).joint.length = 5;
  EXPECT_NEAR(gap({0, 0}), 0, 1e-12);
  EXPECT_NEAR(gap({3, 4}), 5, 1e-12);
  EXPECT_NEAR(gap({-1.5, -2}), 2.5, 1e-12);
  scene.joints[0].joint.type = JointType::rope;
  EXPECT_NEAR(gap({-1.5, -2}), 0, 1e-12);
  EXPECT_NEAR(gap({3, 4}), 5, 1e-12);
  scene.joints.clear();
  join(scene, JointType::revolute, 0, 1, {3, 0}, {0, -4});
  EXPECT_NEAR(gap({0.3, 0.4}), 0.5, 1e-12);
}

TEST(PeerErrors, DisplacementIsOfTheBodyThatMovedMost) {
  const Model model = make_model(two(disc({0, 0}, {0, 0}, material(0)), disc({3, 4}, {0, 0}, material(0))));
  Watched run = still(model, {-0.5, -0.25});
  EXPECT_NEAR(displacement(run).sideways, 0.5, 1e-12);
  EXPECT_NEAR(displacement(run).down, 0.25, 1e-12);
}

TEST(PeerErrors, LinksOfGroupsAreJointsForAll) {
  std::string error;
  const auto cloth = make_builtin("cloth", 16, 1, error);
  ASSERT_TRUE(cloth) << error;
  const Model model = make_model(*cloth);
  EXPECT_EQ(model.scene.joints.size(), 24u);
  EXPECT_EQ(model.bodies.size(), 17u);
  int pinned = 0;
  for (const BodyDesc& body : model.bodies) pinned += body.type == BodyType::static_body ? 1 : 0;
  EXPECT_EQ(pinned, 2);
}

TEST(PeerErrors, MassesOfPolygonsAreThoseOfTheirArea) {
  BodyDesc body;
  body.shape = PolygonShape{{{1, 1}, {4, 1}, {4, 2}, {1, 2}}, 0};
  const BodyDesc same = box({0, 0}, {3, 1}, material(0));
  EXPECT_NEAR(mass_of(body), mass_of(same), 1e-12);
  EXPECT_NEAR(inertia_of(body), inertia_of(same), 1e-12);
  EXPECT_NEAR(centre_of(body).x, 2.5, 1e-12);
  EXPECT_NEAR(centre_of(body).y, 1.5, 1e-12);
}

}  // namespace
}  // namespace psim::peers::test
