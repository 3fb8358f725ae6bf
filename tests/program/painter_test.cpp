// What colours say of bodies.
#include "picture/painter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace psim::cli {
namespace {

using Rgb = std::array<int, 3>;

PictureOptions coloured_by(Colouring colouring) {
  PictureOptions options;
  options.colouring = colouring;
  return options;
}

// Two discs of radius 1 m, 10 pixels, side by side; the pixel right of the middle of each.
class Painting : public ::testing::Test {
 protected:
  Painting() {
    scene_.world.bounds = {-10, -10, 10, 10};
    scene_.bodies.resize(2);
    for (BodyDesc& body : scene_.bodies) body.shape = DiscShape{1};
    const std::vector<double> zero(2);
    moment_ = {
        {0, 1}, {-1.5, 1.5}, zero, zero, zero, zero, zero, {1, 1}, {BodyType::dynamic_body, BodyType::dynamic_body},
        {0, 0}, {},          {},   {},   {},   {}};
  }
  std::array<Rgb, 2> paint(Colouring colouring) {
    constexpr int kWidth = 60, kHeight = 40;
    Canvas canvas(kWidth, kHeight);
    const Painter painter(scene_, coloured_by(colouring));
    painter.paint(canvas, PictureCamera({-3, -2, 3, 2}, kWidth, kHeight), moment_, {10, 10, 10});
    std::vector<std::uint8_t> bytes;
    canvas.to_srgb(bytes);
    std::array<Rgb, 2> at{};
    for (std::size_t body = 0; body < 2; ++body) {
      const std::size_t pixel = 3 * (kWidth * (kHeight / 2 - 3) + 15 + 30 * body);
      for (std::size_t k = 0; k < 3; ++k) at[body][k] = bytes[pixel + k];
    }
    return at;
  }
  static int colourfulness(const Rgb& rgb) { return *std::ranges::max_element(rgb) - *std::ranges::min_element(rgb); }
  Scene scene_;
  Moment moment_;
};

TEST_F(Painting, ForceIsSeenAsleepOrAwake) {
  moment_.force = {0, 10};
  const auto awake = paint(Colouring::force);
  EXPECT_NE(awake[0], awake[1]);
  moment_.asleep = {1, 1};
  EXPECT_EQ(paint(Colouring::force), awake);
  moment_.force = {10, 10};
  EXPECT_EQ(paint(Colouring::force)[0], awake[1]);
}

TEST_F(Painting, StripsAndColoursHaveHuesAndWhoHasNoneIsGrey) {
  moment_.group = {0, 1};
  const auto strips = paint(Colouring::strip);
  EXPECT_GT(colourfulness(strips[0]), 100);
  EXPECT_GT(colourfulness(strips[1]), 20);
  const auto light = [](const Rgb& rgb) { return *std::ranges::max_element(rgb); };
  EXPECT_GT(light(strips[0]), light(strips[1]) + 40);  // odd ones are dark
  moment_.group = {2, 3};
  const auto others = paint(Colouring::strip);
  EXPECT_NE(others[0], strips[0]);
  EXPECT_NE(others[1], strips[1]);
  moment_.group = {0, 3};
  EXPECT_EQ(paint(Colouring::strip)[0], strips[0]);  // whatever the others have
  const auto solver = paint(Colouring::solver);
  EXPECT_GT(colourfulness(solver[0]), 20);
  EXPECT_NE(solver[0], solver[1]);
  moment_.group = {kNoStrip, kNoColour};
  moment_.asleep = {0, 1};
  for (const Colouring colouring : {Colouring::strip, Colouring::solver}) {
    const auto none = paint(colouring);
    EXPECT_LT(colourfulness(none[0]), 20);
    EXPECT_LT(colourfulness(none[1]), 40);
    EXPECT_NE(none[0], none[1]);
  }
}

// From the middle of a body to where it touches.
// Where bodies pass from one side of a periodic world to the other, there is no speck outside of it.
TEST_F(Painting, OverTheSeamOfAPeriodicWorldABodyIsSeenAtBothSides) {
  scene_.world.bounds = {-2, -1.5, 2, 1.5};
  scene_.world.boundary = Boundary::periodic;
  moment_.x = {-1.9, 0};
  moment_.y = {1.4, 0};
  constexpr int kWidth = 60, kHeight = 40;  // 10 pixels a metre; the world is 40 x 30 in the middle
  Canvas canvas(kWidth, kHeight);
  const Painter painter(scene_, coloured_by(Colouring::type));
  const auto picture = [&] {
    painter.paint(canvas, PictureCamera({-3, -2, 3, 2}, kWidth, kHeight), moment_, {10, 10, 10});
    std::vector<std::uint8_t> bytes;
    canvas.to_srgb(bytes);
    return bytes;
  };
  const std::vector<std::uint8_t> bytes = picture();
  const auto blue = [&](int x, int y) { return bytes[3 * static_cast<std::size_t>(y * kWidth + x) + 2] > 100; };
  EXPECT_TRUE(blue(12, 7));  // the corner at which it is
  EXPECT_TRUE(blue(48, 7));  // and the three others
  EXPECT_TRUE(blue(12, 33));
  EXPECT_TRUE(blue(48, 33));
  EXPECT_TRUE(blue(30, 23));  // the other body
  EXPECT_FALSE(blue(15, 20));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool outside = x < 10 || x >= 50 || y < 5 || y >= 35;
      EXPECT_FALSE(outside && blue(x, y)) << x << " " << y;
    }
  }
  moment_.x[0] += 4;  // between two frames a body may be past the side
  EXPECT_EQ(picture(), bytes);
}

// A square of water, 1 m a side, in the middle of 60 x 40 pixels, and a drop.
class FluidPainting : public ::testing::Test {
 protected:
  FluidPainting() {
    scene_.world.bounds = {-3, -2, 3, 2};
    scene_.world.gravity = {};
    scene_.fluids.resize(2);
    scene_.fluids[0].fluid.spacing = scene_.fluids[1].fluid.spacing = 0.25;
    for (std::uint32_t k = 0; k < 64; ++k) add({-0.875 + 0.25 * (k % 8), -0.875 + 0.25 * (k / 8)}, {0, 1.0 * (k % 8)});
    add({-2, 1.5}, {});
  }
  void add(Vec2 at, Vec2 velocity) {
    const auto id = static_cast<std::uint32_t>(moment_.particles.size());
    moment_.particles.push_back({id, 0, at, velocity, 1000, 100 * (1 - at.y)});
  }
  std::vector<std::uint8_t> paint(FluidStyle style, FluidColouring colouring) const {
    PictureOptions options;
    options.fluid_style = style;
    options.fluid_colouring = colouring;
    Canvas canvas(kWidth, kHeight);
    const Painter painter(scene_, options);
    painter.paint(canvas, PictureCamera({-3, -2, 3, 2}, kWidth, kHeight), moment_,
                  brightest(scene_, moment_, painter.shapes()));
    std::vector<std::uint8_t> bytes;
    canvas.to_srgb(bytes);
    return bytes;
  }
  static Rgb at(const std::vector<std::uint8_t>& bytes, int x, int y) {
    const auto first = 3 * static_cast<std::size_t>(y * kWidth + x);
    return {bytes[first], bytes[first + 1], bytes[first + 2]};
  }
  static constexpr int kWidth = 60, kHeight = 40;
  const Rgb kWaterRgb{0x2f, 0x7f, 0xd0}, kEmpty{0x12, 0x16, 0x1d};
  Scene scene_;
  Moment moment_;
};

TEST_F(FluidPainting, ASurfaceIsFilledAndEndsWhereTheFluidEnds) {
  const auto bytes = paint(FluidStyle::surface, FluidColouring::fluid);
  for (int y = 12; y < 28; ++y) {
    for (int x = 22; x < 38; ++x) EXPECT_EQ(at(bytes, x, y), kWaterRgb) << x << " " << y;
  }
  for (const int x : {17, 42}) EXPECT_EQ(at(bytes, x, 20), kEmpty);
  for (const int y : {7, 32}) EXPECT_EQ(at(bytes, 30, y), kEmpty);
  EXPECT_GT(at(bytes, 10, 5)[2], 100);  // the drop
  EXPECT_EQ(at(bytes, 14, 5), kEmpty);
}

TEST_F(FluidPainting, FluidsHaveColoursOfTheirOwn) {
  for (FluidParticleState& p : moment_.particles) p.fluid = p.position.x > 0 ? 1 : 0;
  for (const FluidStyle style : {FluidStyle::surface, FluidStyle::particles}) {
    const auto bytes = paint(style, FluidColouring::fluid);
    EXPECT_GT(at(bytes, 26, 16)[2], at(bytes, 26, 16)[0] + 50);
    EXPECT_LT(at(bytes, 36, 16)[2], at(bytes, 36, 16)[0] - 50);
  }
}

TEST_F(FluidPainting, ColoursShowSpeedAndPressure) {
  for (const FluidStyle style : {FluidStyle::surface, FluidStyle::particles}) {
    const auto speed = paint(style, FluidColouring::speed), pressure = paint(style, FluidColouring::pressure);
    EXPECT_GT(at(speed, 38, 19)[0], at(speed, 21, 19)[0] + 80);        // faster to the right, yellow
    EXPECT_GT(at(pressure, 28, 28)[1], at(pressure, 28, 11)[1] + 40);  // more below
  }
}

TEST_F(FluidPainting, ParticlesAreDiscsWithGapsBetween) {
  const auto bytes = paint(FluidStyle::particles, FluidColouring::fluid);
  EXPECT_GT(at(bytes, 10, 5)[2], 200);
  const auto surface = paint(FluidStyle::surface, FluidColouring::fluid);
  const auto light = [](const std::vector<std::uint8_t>& picture) {
    int sum = 0;
    for (int y = 12; y < 28; ++y) {
      for (int x = 22; x < 38; ++x) sum += at(picture, x, y)[2];
    }
    return sum;
  };
  EXPECT_LT(light(bytes), 0.95 * light(surface));
}

TEST_F(FluidPainting, ParticlesOfNoFluidOfTheSceneAreLeftOut) {
  for (FluidParticleState& p : moment_.particles) p.fluid = 9;
  const auto none = paint(FluidStyle::surface, FluidColouring::fluid);
  moment_.particles.clear();
  EXPECT_EQ(none, paint(FluidStyle::surface, FluidColouring::fluid));
}

TEST_F(Painting, ContactsHaveTheirColour) {
  moment_.group = {kNoColour, kNoColour};
  const auto without = paint(Colouring::solver);
  moment_.links = {{0, kNoBody.index, {-1.4, 1}, 0}, {1, kNoBody.index, {1.6, 1}, 5}};
  const auto with = paint(Colouring::solver);
  for (std::size_t body = 0; body < 2; ++body) {
    EXPECT_EQ(colourfulness(without[body]), 0);
    EXPECT_GT(colourfulness(with[body]), 50);
  }
  EXPECT_NE(with[0], with[1]);
  moment_.links[1].colour = 0;
  EXPECT_EQ(paint(Colouring::solver)[0], with[0]);
  moment_.links[0].point = {9, 9};  // far from it: across the seam
  EXPECT_EQ(paint(Colouring::solver)[0], without[0]);
}

// Three links of a row, of which the second one broke.
TEST(Joints, ThatBrokeAreNotDrawn) {
  Scene scene;
  GroupDesc row;
  row.count = 4;
  row.region = {0, 0, 4, 1};
  row.radius_min = row.radius_max = 0.25;
  row.links = LinkDesc{};
  scene.groups.push_back(row);
  std::string error;
  const auto world = build_world(scene, {}, error);
  ASSERT_NE(world, nullptr) << error;
  ASSERT_TRUE(world->remove_joint({1, 0}));
  const SceneShapes shapes(scene);
  Moment moment;
  take_moment(*world, moment, Colouring::speed, joints_of(scene));
  ASSERT_EQ(shapes.joints().size(), 3u);
  for (const DrawnJoint& joint : shapes.joints()) {
    EXPECT_EQ(SceneShapes::ends_of(joint, moment).has_value(), joint.a != 1) << joint.a;
  }
}

TEST_F(Painting, AsleepIsGrey) {
  for (const Colouring colouring :
       {Colouring::speed, Colouring::spin, Colouring::body, Colouring::type, Colouring::sleep}) {
    moment_.asleep = {0, 0};
    const auto awake = paint(colouring);
    moment_.asleep = {1, 0};
    const auto now = paint(colouring);
    EXPECT_LT(colourfulness(now[0]), 0.75 * colourfulness(awake[0]));
    EXPECT_EQ(now[1], awake[1]);
  }
}

TEST_F(Painting, FastIsBright) {
  moment_.vx = {0, -10};
  const auto at = paint(Colouring::speed);
  EXPECT_EQ(at[0], (Rgb{0x41, 0x44, 0x87}));
  EXPECT_EQ(at[1], (Rgb{0xfd, 0xe7, 0x25}));
  EXPECT_EQ(paint(Colouring::spin)[1], at[0]);
  moment_.omega = {0, -10};
  EXPECT_EQ(paint(Colouring::spin)[1], at[1]);
}

TEST_F(Painting, DirectionsHaveHuesAndStillnessNone) {
  moment_.vx = {0, 5};
  const auto right = paint(Colouring::direction);
  EXPECT_EQ(colourfulness(right[0]), 0);
  EXPECT_GT(right[1][0], right[1][1] + 100);  // red
  moment_.vx = {0, -5};
  const auto left = paint(Colouring::direction);
  EXPECT_GT(left[1][2], left[1][0] + 100);  // cyan
}

// Of a frozen body, or of a state that somebody forged.
TEST_F(Painting, NumbersThatAreNotFiniteHaveAColour) {
  moment_.group = {1, 1};
  for (const Colouring colouring : {Colouring::speed, Colouring::direction, Colouring::spin, Colouring::force}) {
    for (const double broken : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      moment_.vx = moment_.omega = moment_.force = {broken, broken};
      const auto at = paint(colouring);
      EXPECT_NE(at[0], (Rgb{0x16, 0x1b, 0x22})) << "nothing but the ground";
      EXPECT_EQ(at[0], at[1]);
    }
  }
}

TEST_F(Painting, StaticIsGreyAndSensorsAreFaint) {
  const Rgb dynamic = paint(Colouring::type)[0];
  scene_.bodies[0].sensor = true;
  const Rgb faint = paint(Colouring::type)[0];
  EXPECT_LT(faint[2], dynamic[2] - 60);
  scene_.bodies[0].sensor = false;
  moment_.type[0] = BodyType::static_body;
  EXPECT_EQ(paint(Colouring::type)[0], (Rgb{0x7d, 0x87, 0x94}));
  moment_.type[0] = BodyType::dynamic_body;
  scene_.bodies[0].type = BodyType::kinematic_body;
  EXPECT_EQ(paint(Colouring::type)[0], (Rgb{0xe6, 0x80, 0x73}));
}

}  // namespace
}  // namespace psim::cli
