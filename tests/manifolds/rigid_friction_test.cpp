// Friction of shapes with corners: thresholds of sliding and tipping, ways, rolling.
#include "reference/closed_forms.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

/// Level ground under gravity that leans by `angle` to the right: an incline.
std::unique_ptr<World> incline(double angle, double friction, Isa isa = best_isa()) {
  auto world = make(unbounded(500, {kG * std::sin(angle), -kG * std::cos(angle)}), isa);
  add(*world, ground(material(0, friction), 500));
  return world;
}

double degrees(double d) { return d * kPi / 180; }

double slide_of(double angle, double friction, double seconds) {
  return 0.5 * kG * (std::sin(angle) - friction * std::cos(angle)) * seconds * seconds;
}

// ---- thresholds -------------------------------------------------------------------------------

TEST(RigidIncline, BoxSlidesFromTheAngleOfFriction) {
  for (const double friction : {0.1, 0.3, 0.5}) {
    const double limit = std::atan(friction);
    for (const double side : {1.0, -1.0}) {
      for (const Vec2 size : {Vec2{1, 1}, Vec2{3, 0.5}}) {
        const Material m = material(0, friction);
        auto held = incline(side * (limit - degrees(0.5)), friction);
        const BodyId a = add(*held, box({0, 0.5 * size.y}, size.x, size.y, m));
        run(*held, 30);  // a cold start slips by a millimetre
        const double from = state(*held, a).x;
        run_seconds(*held, 10);
        EXPECT_LT(std::abs(state(*held, a).x - from), 1e-4) << friction << " to side " << side;

        const double angle = limit + degrees(0.5);
        auto slides = incline(side * angle, friction);
        const BodyId b = add(*slides, box({0, 0.5 * size.y}, size.x, size.y, m));
        run_seconds(*slides, 10);
        EXPECT_NEAR(side * state(*slides, b).x / slide_of(angle, friction, 10), 1, 0.03)
            << friction << " to side " << side;
      }
    }
  }
}

TEST(RigidIncline, BoxOnATiltedSegmentOrBoxHoldsAndSlidesAlike) {
  for (const double offset : {-0.5, 0.5}) {
    for (const bool segment_floor : {true, false}) {
      const double angle = std::atan(0.5) + degrees(offset), c = std::cos(angle), s = std::sin(angle);
      const Material m = material(0, 0.5);
      auto world = make(unbounded(500));
      if (segment_floor) {
        add(*world, segment({-300 * c, -300 * s}, {300 * c, 300 * s}, m));
      } else {
        add(*world, fixed(turned(box({s, -c}, 600, 2, m), angle)));
      }
      const BodyId id = add(*world, turned(box({-0.5 * s, 0.5 * c}, 1, 1, m), angle));
      run(*world, 30);
      const BodyState from = state(*world, id);
      const double v = std::hypot(from.vx, from.vy);
      run_seconds(*world, 5);
      const BodyState now = state(*world, id);
      const double way = std::hypot(now.x - from.x, now.y - from.y);
      if (offset < 0) {
        EXPECT_LT(way, 1e-4) << segment_floor;
      } else {
        EXPECT_NEAR((way - 5 * v) / slide_of(angle, 0.5, 5), 1, 0.02) << segment_floor;
      }
      EXPECT_NEAR(now.angle, angle, 1e-3) << segment_floor;
    }
  }
}

TEST(RigidIncline, TallBoxTipsFromItsDiagonal) {
  for (const Vec2 size : {Vec2{1, 3}, Vec2{1, 1.5}, Vec2{0.5, 2}}) {
    const double limit = std::atan(size.x / size.y);
    for (const double side : {1.0, -1.0}) {
      for (const double offset : {-0.5, 0.5}) {
        auto world = incline(side * (limit + degrees(offset)), 2);
        const BodyId id = add(*world, box({0, 0.5 * size.y}, size.x, size.y, material(0, 2)));
        run_seconds(*world, 10);
        const bool stands = std::abs(state(*world, id).angle) < 0.05;
        EXPECT_EQ(stands, offset < 0) << size.x << " x " << size.y << " to side " << side;
        if (offset < 0) {
          EXPECT_LT(std::abs(state(*world, id).x), 1e-3) << size.y;
        }
      }
    }
  }
}

TEST(RigidIncline, OctagonRollsFromHalfItsCorner) {
  for (const double offset : {-0.5, 0.5}) {
    auto world = incline(degrees(22.5 + offset), 2);
    const double radius = 0.5;
    const BodyId id = add(*world, polygon(regular(8, radius), {0, radius * std::cos(kPi / 8)}, material(0, 2)));
    run_seconds(*world, 10);
    EXPECT_EQ(std::abs(state(*world, id).angle) < 0.05, offset < 0);
    if (offset > 0) {
      EXPECT_LT(state(*world, id).angle, -2 * kPi);
    }
  }
}

/// Two cards that lean on each other, `angle` from vertical, for 10 s. Corner on corner, friction of
/// tan(angle) between them keeps either from sliding down the other's face.
bool cards_stand(double angle, double friction, double thick) {
  const double between = 0.6;
  const Material m = material(0, between);
  auto world = make(unbounded());
  add(*world, ground(material(0, friction * friction / between)));  // mixes to `friction`
  const double length = 1, c = std::cos(angle), s = std::sin(angle);
  // The right one touches x = 0 with its upper left corner and y = 0 with its lower left one.
  const Vec2 middle{0.5 * length * s + 0.5 * thick * c, 0.5 * length * c + 0.5 * thick * s};
  const BodyId right = add(*world, turned(box(middle, thick, length, m), angle));
  add(*world, turned(box({-middle.x, middle.y}, thick, length, m), -angle));
  run_seconds(*world, 10);
  return state(*world, right).y > 0.8 * middle.y;
}

TEST(RigidCards, StandIffTheFrictionOfTheGroundSuffices) {
  for (const double thick : {0.002, 0.01, 0.05}) {
    // 0.233154 for cards without thickness; the lever of the weight is shorter by half of it.
    const double angle = degrees(25), limit = 0.5 * std::tan(angle) - 0.5 * thick;
    EXPECT_TRUE(cards_stand(angle, 1.03 * limit, thick)) << thick;
    EXPECT_FALSE(cards_stand(angle, 0.97 * limit, thick)) << thick;
  }
}

// ---- ways -------------------------------------------------------------------------------------

TEST(RigidSlide, BlockStopsWhereItShould) {
  const reference::Slide truth{5, 0.5, kG};
  EXPECT_NEAR(truth.distance(), 2.548420, 1e-6);
  const Material m = material(0, 0.5);
  const BodyDesc bodies[] = {box({0, 0.5}, 1, 1, m), box({0, 0.1}, 2, 0.2, m), capsule({0, 0.25}, 1.5, 0.25, m),
                             polygon({{-1, -0.5}, {1, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}, {0, 0.5}, m)};
  for (const Isa isa : available_isas()) {
    for (const double side : {1.0, -1.0}) {
      for (const BodyDesc& body : bodies) {
        auto world = make(unbounded(), isa);
        add(*world, ground(m));
        const BodyId id = add(*world, moving(body, {side * 5, 0}));
        run(*world, 120);
        const BodyState s = state(*world, id);
        EXPECT_NEAR(side * s.x, truth.distance(), 3e-3) << body.shape.index();
        EXPECT_LT(std::abs(s.angle), 1e-3) << body.shape.index();
        run_seconds(*world, 10);
        EXPECT_LT(std::abs(state(*world, id).x - s.x) / 10, 1e-6) << body.shape.index();
      }
    }
  }
}

TEST(RigidSlide, BlockOnAMovingBoxDragsItAlong) {
  // 1 kg at 4 m/s on 3 kg, which slides on ice: both end at 1 m/s.
  auto world = make(unbounded());
  add(*world, ground(material(0, 0)));
  const Material m = material(0, 0.5);
  const BodyId cart = add(*world, box({0, 0.25}, 20, 0.5, m, 3));
  const BodyId block = add(*world, moving(box({-5, 1}, 1, 1, m, 1), {4, 0}));
  run_seconds(*world, 4);
  EXPECT_NEAR(state(*world, cart).vx, 1, 1e-3);
  EXPECT_NEAR(state(*world, block).vx, 1, 1e-3);
  // It slid v^2 / (2 mu g (1 + m / M)) on the cart.
  const double slid = state(*world, block).x - state(*world, cart).x + 5;
  EXPECT_NEAR(slid, 16 / (2 * 0.5 * kG * (1 + 1.0 / 3)), 5e-3);
}

TEST(RigidSlide, BeltCarriesABoxUpToItsSpeed) {
  auto world = make(unbounded(500));
  const Material m = material(0, 0.4);
  add(*world, moving(kinematic(box({0, -0.5}, 400, 1, m)), {2, 0}));
  const BodyId id = add(*world, box({0, 0.5}, 1, 1, m));
  run_seconds(*world, 5);
  EXPECT_NEAR(state(*world, id).vx, 2, 1e-4);
  const double gaining = 2 / (0.4 * kG);
  EXPECT_NEAR(state(*world, id).x, 2 * 5 - 0.5 * 2 * gaining, 5e-3);
}

// ---- rolling ----------------------------------------------------------------------------------

TEST(RigidRoll, DiscOnABoxRests) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  const BodyId under = add(*world, box({0, 0.5}, 1, 1, kGrip));
  const BodyId id = add(*world, disc({0, 1.5}, {}, 0.5, kGrip));
  run_seconds(*world, 10);
  EXPECT_NEAR(state(*world, id).y, 1.5, 1e-3);
  EXPECT_LT(std::abs(state(*world, id).x), 1e-4);
  EXPECT_LT(std::abs(state(*world, under).x), 1e-4);
  EXPECT_LT(speed_of(state(*world, id)), 1e-4);
}

TEST(RigidRoll, SlidingDiscComesToRollOnEveryKindOfFloor) {
  const Material m = material(0, 0.2);
  const reference::SlideToRoll truth{5, 0.2, kG};
  BodyDesc thick = capsule({0, -1}, 200, 1, m);
  const BodyDesc floors[] = {fixed(box({0, -0.5}, 200, 1, m)), kinematic(box({0, -0.5}, 200, 1, m)), fixed(thick),
                             kinematic(thick)};
  for (const BodyDesc& floor : floors) {
    auto world = make(unbounded(200));
    add(*world, floor);
    const BodyId id = add(*world, disc({-50, 0.5}, {5, 0}, 0.5, m));
    run(*world, 240);
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.vx / truth.rolling_speed(), 1, 5e-3) << floor.shape.index();
    EXPECT_NEAR(s.omega / (-truth.rolling_speed() / 0.5), 1, 5e-3) << floor.shape.index();
    EXPECT_NEAR((s.x + 50) / truth.position(4), 1, 5e-3) << floor.shape.index();
  }
}

TEST(RigidRoll, DiscRollsDownAnInclineOfABox) {
  const reference::Incline truth{degrees(20), 0.3, 0.5, kG};
  auto world = make(unbounded(200, {kG * std::sin(truth.angle), -kG * std::cos(truth.angle)}));
  add(*world, fixed(box({0, -0.5}, 200, 1, material(0, 0.3))));
  const BodyId id = add(*world, disc({-20, 0.5}, {}, 0.5, material(0, 0.3)));
  run_seconds(*world, 2);
  EXPECT_NEAR(state(*world, id).vx / (2 * truth.acceleration()), 1, 5e-3);
  EXPECT_NEAR(state(*world, id).omega / (-2 * truth.angular_acceleration()), 1, 5e-3);
}

TEST(RigidRoll, EndOfACapsuleRollsAsADiscOfItsInertia) {
  // Upright and turning about its lower end without slip: theta'' = (g / l) sin(theta) m l^2 / I.
  const Material m = material(0, 10);
  auto world = make(unbounded());
  add(*world, ground(m));
  const double radius = 0.25;
  const BodyId id = add(*world, turned(capsule({0, 0.75 + radius}, 1.5, radius, m), 0.5 * kPi - 0.2));
  run_seconds(*world, 5);
  const BodyState s = state(*world, id);  // lies
  EXPECT_NEAR(s.y, radius, 1e-3);
  EXPECT_NEAR(std::remainder(s.angle, kPi), 0, 1e-3);
  EXPECT_LT(speed_of(s), 1e-4);
}

TEST(RigidFriction, WithoutAnyABoxThatSlidesKeepsItsSpeed) {
  auto world = make(unbounded(500));
  add(*world, ground(material(0, 0), 500));
  const BodyId id = add(*world, moving(box({-400, 0.5}), {10, 0}));
  run_seconds(*world, 60);
  EXPECT_NEAR(state(*world, id).vx, 10, 1e-5);
  EXPECT_LT(std::abs(state(*world, id).angle), 1e-5);
}

}  // namespace
}  // namespace psim::test
