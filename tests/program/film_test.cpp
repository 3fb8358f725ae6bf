// Films: which moments are drawn, and what of the world they show.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "picture/film_clock.h"
#include "picture/picture_view.h"

namespace psim::cli {
namespace {

// The times of the pictures of a run, in frames.
std::vector<double> times(FilmClock clock, std::uint64_t frames) {
  std::vector<double> at;
  for (std::uint64_t frame = 0; frame <= frames; ++frame) {
    const bool announced = frame > 0 && clock.is_between(frame - 1);
    while (const auto share = clock.due(frame)) {
      at.push_back(static_cast<double>(frame) - 1 + *share);
      EXPECT_TRUE(*share == 1 || announced) << frame;
    }
  }
  return at;
}

using Times = std::vector<double>;

TEST(FilmClock, PicturesOfTheTimesOfFramesAreThoseFrames) {
  EXPECT_EQ(times({1.0 / 60, 60, {}}, 3), (Times{0, 1, 2, 3}));
  EXPECT_EQ(times({0.016666667, 60, {}}, 3), (Times{0, 1, 2, 3}));
  EXPECT_EQ(times({1.0 / 60, 30, {}}, 5), (Times{0, 2, 4}));
  EXPECT_EQ(times({1.0 / 60, 60, {}}, 36000).size(), 36001u);
}

TEST(FilmClock, OthersLieBetweenFrames) {
  EXPECT_EQ(times({1.0 / 30, 60, {}}, 2), (Times{0, 0.5, 1, 1.5, 2}));
  const Times at = times({1.0 / 60, 25, {}}, 10);
  ASSERT_EQ(at.size(), 5u);
  for (std::size_t k = 0; k < at.size(); ++k) EXPECT_NEAR(at[k], 2.4 * static_cast<double>(k), 1e-9);
  EXPECT_EQ(times({1.0, 10, {}}, 1).size(), 11u);
}

TEST(FilmClock, EveryGoesByFrames) {
  EXPECT_EQ(times({1.0 / 60, 25, 3}, 10), (Times{0, 3, 6, 9}));
  EXPECT_EQ(times({0.123, 60, 1}, 2), (Times{0, 1, 2}));
}

Moment one_body(double x, double angle, std::uint32_t id = 0) {
  return {{id}, {x}, {0}, {angle}, {0}, {0}, {0}, {0.5}, {BodyType::dynamic_body}, {0}, {}, {}, {}, {}, {}};
}

TEST(Film, BodiesBetweenFramesTakeTheShortWay) {
  WorldDesc world;
  world.bounds = {0, 0, 10, 10};
  Moment between;
  place_between(one_body(1, 0), one_body(3, 1), 0.25, world, between);
  EXPECT_DOUBLE_EQ(between.x[0], 1.5);
  EXPECT_DOUBLE_EQ(between.angle[0], 0.25);
  world.boundary = Boundary::periodic;
  place_between(one_body(9.5, 0), one_body(0.5, 0), 0.25, world, between);  // over the seam
  EXPECT_NEAR(between.x[0], -0.25, 1e-12);
  place_between(one_body(9, 0, 7), one_body(2, 0, 8), 0.25, world, between);  // another body
  EXPECT_DOUBLE_EQ(between.x[0], 2);
}

TEST(Film, ParticlesBetweenFramesTakeTheShortWay) {
  WorldDesc world;
  world.bounds = {0, 0, 10, 10};
  world.boundary = Boundary::periodic;
  Moment before, after, between;
  before.particles = {{1, 0, {1, 2}, {}, 0, 0}, {4, 0, {9.5, 5}, {}, 0, 0}, {5, 0, {3, 3}, {}, 0, 0}};
  after.particles = {{0, 0, {7, 7}, {}, 0, 0}, {1, 0, {2, 4}, {}, 0, 0}, {4, 0, {0.5, 5}, {}, 0, 0}};
  place_between(before, after, 0.25, world, between);
  ASSERT_EQ(between.particles.size(), 3u);
  EXPECT_DOUBLE_EQ(between.particles[0].position.x, 7);  // it was not there before
  EXPECT_DOUBLE_EQ(between.particles[1].position.x, 1.25);
  EXPECT_DOUBLE_EQ(between.particles[1].position.y, 2.5);
  EXPECT_NEAR(between.particles[2].position.x, -0.25, 1e-12);  // over the seam
}

TEST(Film, TheViewWidensAsTheSceneSpreads) {
  Scene scene;
  scene.world.bounds = {-100, -100, 100, 100};
  scene.world.boundary = Boundary::open;
  scene.bodies.resize(1);
  scene.bodies[0].shape = DiscShape{0.5};
  const SceneShapes shapes(scene);
  FilmView film(scene, shapes);
  Bounds before = film.follow(one_body(0, 0));
  EXPECT_LT(before.xmax, 2);
  for (int k = 0; k < 200; ++k) {
    const Bounds view = film.follow(one_body(std::min(0.1 * k, 10.0), 0));
    EXPECT_LE(view.xmin, before.xmin);
    EXPECT_GE(view.xmax, before.xmax);
    before = view;
  }
  EXPECT_GT(before.xmax, 10.5);
  EXPECT_LT(before.xmax, 12);
}

TEST(Film, TheCameraKeepsTheShapeOfThings) {
  const PictureCamera camera({-1, 0, 3, 1}, 800, 600);
  const Point low = camera.at({-1, 0}), high = camera.at({3, 1});
  EXPECT_DOUBLE_EQ(low.x, 0);
  EXPECT_DOUBLE_EQ(high.x, 800);
  EXPECT_DOUBLE_EQ(low.y - high.y, 200);        // a quarter of the width, as in the world
  EXPECT_DOUBLE_EQ((low.y + high.y) / 2, 300);  // in the middle
}

}  // namespace
}  // namespace psim::cli
