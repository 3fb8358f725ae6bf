// Built-in scenes of bodies of several shapes: nobody leaves a drum, which is one kinematic body, or a basin.
#include <cmath>

#include "psim/scene.h"
#include "support.h"

namespace psim::test {
namespace {

// Runs a drum of `bodies` boxes about (0, 10). `inside` is told where each box is in the frame of the drum, body 0.
template <class Inside>
void expect_all_inside(const char* name, std::uint64_t bodies, int frames, const Inside& inside) {
  std::string error;
  const auto scene = make_builtin(name, bodies, 1, error);
  ASSERT_TRUE(scene) << error;
  const auto world = build_world(*scene, {}, error);
  ASSERT_TRUE(world) << error;
  ASSERT_EQ(world->body_count(), bodies + 1);
  for (int frame = 0; frame < frames; ++frame) {
    world->step();
    ASSERT_EQ(world->body_count(), bodies + 1) << "frame " << frame;
    const BodyState drum = state(*world, world->id_of(0));
    const double c = std::cos(drum.angle), s = std::sin(drum.angle);
    for (std::uint32_t k = 1; k <= bodies; ++k) {
      const BodyState box = state(*world, world->id_of(k));
      const double x = box.x - drum.x, y = box.y - drum.y;
      ASSERT_TRUE(inside(c * x + s * y, c * y - s * x)) << "body " << k << ", frame " << frame;
    }
  }
}

TEST(SceneDrums, NobodyLeavesTheTumbler) {
  const auto inside = [](double x, double y) { return std::fmax(std::fabs(x), std::fabs(y)) < 9.5; };
  for (const std::uint64_t bodies : {200u, 900u}) expect_all_inside("tumbler", bodies, 400, inside);
}

TEST(SceneDrums, NobodyLeavesTheWasher) {
  const auto inside = [](double x, double y) { return std::hypot(x, y) < 16; };
  for (const std::uint64_t bodies : {200u, 900u}) expect_all_inside("washer", bodies, 400, inside);
}

// Nothing falls through the ground of many boxes, and the blade swings as a sine does.
TEST(SceneBasins, TheBladeOfTheJunkyardSwings) {
  std::string error;
  const auto scene = make_builtin("junkyard", 400, 1, error);
  ASSERT_TRUE(scene) << error;
  const auto world = build_world(*scene, {}, error);
  ASSERT_TRUE(world) << error;
  for (int frame = 1; frame <= 900; ++frame) {
    world->step();
    const BodyState blade = state(*world, world->id_of(1));
    ASSERT_NEAR(blade.x, 60 * std::sin(0.2 * frame / 60), 0.3) << "frame " << frame;
    ASSERT_NEAR(blade.y, 4, 0.01) << "frame " << frame;
    ASSERT_NEAR(blade.angle, 0, 1e-3) << "frame " << frame;
  }
  for (std::uint32_t k = 2; k < 402; ++k) {
    const BodyState piece = state(*world, world->id_of(k));
    EXPECT_TRUE(std::fabs(piece.x) < 79.5 && piece.y > 0.5) << k << ": " << piece.x << ", " << piece.y;
  }
}

TEST(SceneBasins, CompoundsStayInTheirBasin) {
  std::string error;
  const auto scene = make_builtin("compounds", 200, 1, error);
  ASSERT_TRUE(scene) << error;
  const auto world = build_world(*scene, {}, error);
  ASSERT_TRUE(world) << error;
  for (int frame = 0; frame < 400; ++frame) world->step();
  for (std::uint32_t k = 1; k <= 200; ++k) {
    const BodyState body = state(*world, world->id_of(k));
    EXPECT_TRUE(std::fabs(body.x) < 39.5 && body.y > 0.45) << k << ": " << body.x << ", " << body.y;
  }
}

}  // namespace
}  // namespace psim::test
