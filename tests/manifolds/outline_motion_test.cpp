// Bodies of concave outlines: what falls into a notch stays there, and moves along.
#include "outline_support.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

BodyDesc outline_body(const Points& outline, Vec2 position, BodyType type, Material m = {}) {
  BodyDesc body;
  body.type = type;
  body.shape = CompoundShape{cut(outline)};
  body.position = position;
  body.material = m;
  return body;
}

TEST(OutlineMotion, ABallRestsInTheNotchOfAnL) {
  const Material grip = material(0, 0.6);
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body}) {
    auto world = make(unbounded(50));
    add(*world, ground(grip));
    const BodyId l = add(*world, outline_body(l_shape(), {0, 0}, type, grip));
    const BodyId ball = add(*world, moving(disc({2.2, 3}, {0, 0}, 0.4), {-1, 0}));
    run(*world, 600);
    EXPECT_NEAR(state(*world, ball).y, 1.4, 3e-3);
    EXPECT_GT(state(*world, ball).x, 1.39);
    EXPECT_LT(state(*world, ball).x, 3);
    EXPECT_NEAR(state(*world, l).angle, 0, 2e-3);
    EXPECT_NEAR(state(*world, l).y, 0, 3e-3);
  }
}

TEST(OutlineMotion, ALadleCarriesABall) {
  auto world = make(unbounded(50));
  const Points ladle{{-2, -0.5}, {2, -0.5}, {2, 1}, {1.5, 1}, {1.5, 0}, {-1.5, 0}, {-1.5, 1}, {-2, 1}};
  BodyDesc body = outline_body(ladle, {0, 0}, BodyType::kinematic_body, material(0, 0.5));
  body.velocity = {0.5, 1};
  const BodyId lifted = add(*world, body);
  const BodyId ball = add(*world, disc({0, 0.5}, {0, 0}, 0.4));
  run(*world, 300);
  EXPECT_NEAR(state(*world, ball).y - state(*world, lifted).y, 0.4, 5e-3);
  EXPECT_NEAR(state(*world, ball).x, state(*world, lifted).x, 1.11);
}

// The bits do not depend on threads or instruction sets.
TEST(OutlineMotion, StarsFallAlikeEverywhere) {
  std::vector<Vec2> ends;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      std::mt19937 random(2);
      auto world = make(unbounded(50), isa, threads);
      add(*world, ground(material(0, 0.5)));
      for (int k = 0; k < 12; ++k) {
        add(*world, outline_body(star(12, 0.6, random), {2.5 * (k % 3), 2 + 2.5 * (k / 3)}, BodyType::dynamic_body,
                                 material(0.2, 0.5)));
      }
      run(*world, 200);
      const BodyState last = state(*world, {12, 0});
      EXPECT_GT(last.y, 0);
      ends.push_back({last.x, last.y});
      EXPECT_EQ(ends.back().x, ends.front().x);
      EXPECT_EQ(ends.back().y, ends.front().y);
    }
  }
}

}  // namespace
}  // namespace psim::test
