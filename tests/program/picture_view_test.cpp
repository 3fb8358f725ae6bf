// Which part of a scene a picture shows.
#include "picture/picture_view.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <variant>

namespace psim::cli {
namespace {

/// A scene and its bodies where they are put.
struct Stage {
  Scene scene;
  Moment moment;

  explicit Stage(Bounds bounds = {-1e6, -1e6, 1e6, 1e6}, Boundary boundary = Boundary::open) {
    scene.world.bounds = bounds;
    scene.world.boundary = boundary;
  }
  void put(Shape shape, Vec2 at, BodyType type = BodyType::dynamic_body) {
    const auto* disc = std::get_if<DiscShape>(&shape);
    moment.radius.push_back(disc != nullptr ? disc->radius : 0);
    moment.id.push_back(static_cast<std::uint32_t>(moment.id.size()));
    moment.x.push_back(at.x);
    moment.y.push_back(at.y);
    moment.type.push_back(type);
    moment.asleep.push_back(0);
    for (auto* column : {&moment.angle, &moment.vx, &moment.vy, &moment.omega}) column->push_back(0);
    BodyDesc& body = scene.bodies.emplace_back();
    body.shape = std::move(shape);
    body.type = type;
  }
  Bounds view() const { return view_of_all(scene, moment, SceneShapes(scene)); }
  Bounds film_view() const {
    const SceneShapes shapes(scene);
    return FilmView(scene, shapes).follow(moment);
  }
};

void expect_shows(const Bounds& view, const Bounds& part) {
  EXPECT_LE(view.xmin, part.xmin);
  EXPECT_LE(view.ymin, part.ymin);
  EXPECT_GE(view.xmax, part.xmax);
  EXPECT_GE(view.ymax, part.ymax);
}

double width(const Bounds& b) { return b.xmax - b.xmin; }
double height(const Bounds& b) { return b.ymax - b.ymin; }

// A wall of 20 x 20 boxes, (0, 0) to (20, 20).
Stage wall(Bounds bounds = {-1e6, -1e6, 1e6, 1e6}, Boundary boundary = Boundary::open) {
  Stage stage(bounds, boundary);
  for (int k = 0; k < 400; ++k) stage.put(BoxShape{1, 1}, {k % 20 + 0.5, k / 20 + 0.5});
  return stage;
}

TEST(PictureView, AWorldWithoutBoundsIsAsLargeAsWhatIsInIt) {
  const Bounds view = wall().view();
  expect_shows(view, {0, 0, 20, 20});
  EXPECT_LT(width(view), 22);
  EXPECT_LT(height(view), 22);
}

TEST(PictureView, ABodyThatWasFlungFarIsLetGo) {
  for (const Vec2 far : {Vec2{5000, 3}, {-900, 3}, {3, 1e5}, {400, -400}}) {
    Stage stage = wall();
    stage.put(DiscShape{0.5}, far);
    for (const Bounds& view : {stage.view(), stage.film_view()}) {
      expect_shows(view, {0, 0, 20, 20});
      EXPECT_LT(width(view) + height(view), 44) << far.x << " " << far.y;
    }
  }
}

// One body of thousands that flies at the others, as in the scene smash.
TEST(PictureView, ABodyBesideManyIsShown) {
  Stage stage;
  for (int k = 0; k < 9600; ++k) stage.put(BoxShape{1, 1}, {k % 120 + 0.5, k / 120 + 0.5});
  stage.put(BoxShape{8, 8}, {-60, 40});
  for (const Bounds& view : {stage.view(), stage.film_view()}) expect_shows(view, {-64, 0, 120, 80});
}

TEST(PictureView, AFewBodiesAreShownHoweverFarApart) {
  Stage stage;
  for (const double x : {0.0, 1.0, 7000.0}) stage.put(DiscShape{0.5}, {x, 0});
  expect_shows(stage.view(), {-0.5, -0.5, 7000.5, 0.5});
}

TEST(PictureView, ABodyAloneHasRoomAroundIt) {
  for (const double radius : {1e-6, 0.5, 1e4}) {
    Stage stage;
    stage.put(DiscShape{radius}, {3, 4});
    const Bounds view = stage.view();
    EXPECT_GT(width(view), 5 * radius);
    EXPECT_GT(height(view), 5 * radius);
    EXPECT_LT(width(view), 10 * radius);
    EXPECT_NEAR((view.xmin + view.xmax) / 2, 3, 1e-9 * radius);
    EXPECT_NEAR((view.ymin + view.ymax) / 2, 4, 1e-9 * radius);
  }
}

TEST(PictureView, GroundThatReachesFarIsShownNearTheBodiesAlone) {
  Stage stage = wall();
  stage.put(SegmentShape{{-5e5, 0}, {5e5, 0}}, {0, 0}, BodyType::static_body);
  stage.put(BoxShape{1000, 1000}, {0, -500}, BodyType::static_body);
  stage.put(DiscShape{1}, {500, 500}, BodyType::static_body);
  const Bounds view = stage.view();
  expect_shows(view, {-3, -3, 23, 20});
  EXPECT_LT(width(view), 34);
  EXPECT_LT(height(view), 28);
}

TEST(PictureView, GroundOfTheSizeOfTheBodiesIsShownWhole) {
  Stage stage = wall();
  stage.put(BoxShape{36, 2}, {10, -1}, BodyType::static_body);
  expect_shows(stage.view(), {-8, -2, 28, 20});
}

TEST(PictureView, WhatHoldsABodyIsShown) {
  Stage pendulum;
  pendulum.put(DiscShape{0.5}, {0, 0});
  SceneJoint rod;
  rod.a = kWorldSide;
  rod.b = 0;
  rod.joint.type = JointType::distance;
  rod.joint.anchor_a = {0, 9};
  pendulum.scene.joints.push_back(rod);
  expect_shows(pendulum.view(), {-0.5, -0.5, 0.5, 9});

  Stage planet;
  planet.put(DiscShape{0.01}, {5, 0});
  planet.scene.world.fields.push_back(WellField{{0, 0}});
  expect_shows(planet.view(), {0, -0.01, 5.01, 0.01});
}

// There the sides show where bodies may go.
TEST(PictureView, WallsAreShownWhereBodiesUseMostOfTheWorld) {
  const Bounds filled = wall({-5, 0, 25, 22}, Boundary::walls).view();
  expect_shows(filled, {-5, 0, 25, 22});
  const Bounds wide = wall({-200, 0, 200, 22}, Boundary::walls).view();
  expect_shows(wide, {0, 0, 20, 22});
  EXPECT_LT(width(wide), 23);
  EXPECT_LT(width(wall({-5, -5, 25, 25}, Boundary::open).view()), 22);
}

TEST(PictureView, FluidsCountAsBodiesDo) {
  Stage stage;
  stage.scene.fluids.resize(1);
  stage.scene.fluids[0].fluid.spacing = 0.1;
  for (int k = 0; k < 400; ++k) {
    stage.moment.particles.push_back(
        {static_cast<std::uint32_t>(k), 0, {5 + 0.1 * (k % 20), 0.1 * (k / 20)}, {}, 0, 0});
  }
  expect_shows(stage.view(), {5, 0, 6.9, 1.9});
  EXPECT_LT(width(stage.view()), 2.2);
  expect_shows(stage.film_view(), {5, 0, 6.9, 1.9});
  stage.moment.particles.push_back({400, 0, {900, 0}, {}, 0, 0});  // a drop that was flung far
  EXPECT_LT(width(stage.view()), 2.2);
  stage.moment.particles.push_back({401, 7, {5, 0}, {}, 0, 0});  // of no fluid of the scene
  EXPECT_LT(width(stage.view()), 2.2);
}

TEST(PictureView, NothingInAWorldIsAllOfIt) { expect_shows(Stage({-3, -2, 3, 2}).view(), {-3, -2, 3, 2}); }

}  // namespace
}  // namespace psim::cli
