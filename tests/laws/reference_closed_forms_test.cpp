// The closed forms that the physics tests lean on, against known values, limits and numerical
// integration of the equations they claim to solve.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "reference/closed_forms.h"

namespace reference {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

TEST(ClosedForms, FreeFall) { EXPECT_NEAR(fall_height(0, 0, 9.81, 1), -4.905, 1e-12); }

TEST(ClosedForms, LinearDragHasItsKnownValues) {
  const Vec one = linear_drag_position({10, 10}, 9.81, 0.5, 1);
  EXPECT_NEAR(one.x, 7.869387, 1e-6);
  EXPECT_NEAR(one.y, 3.689124, 1e-6);
  const Vec two = linear_drag_position({10, 10}, 9.81, 0.5, 2);
  EXPECT_NEAR(two.x, 12.642411, 1e-6);
  EXPECT_NEAR(two.y, -1.793178, 1e-6);
  // The velocity is the derivative of the position.
  const double h = 1e-5;
  const Vec slope = (1 / (2 * h)) * (linear_drag_position({10, 10}, 9.81, 0.5, 1 + h) -
                                     linear_drag_position({10, 10}, 9.81, 0.5, 1 - h));
  EXPECT_NEAR(length(slope - linear_drag_velocity({10, 10}, 9.81, 0.5, 1)), 0, 1e-8);
}

TEST(ClosedForms, QuadraticDragSolvesItsEquation) {
  const double q = 0.3, v0 = 12, t = 0.7, h = 1e-5;
  const double v = quadratic_drag_speed(v0, q, t);
  const double dv = (quadratic_drag_speed(v0, q, t + h) - quadratic_drag_speed(v0, q, t - h)) / (2 * h);
  EXPECT_NEAR(dv, -q * v * v, 1e-7);
  const double dx = (quadratic_drag_distance(v0, q, t + h) - quadratic_drag_distance(v0, q, t - h)) / (2 * h);
  EXPECT_NEAR(dx, v, 1e-7);
}

TEST(ClosedForms, BouncesHaveTheirKnownTimesAndApexes) {
  const Bounces b{1, 0.8, 9.81};
  const double times[] = {0.451524, 1.173961, 1.751912, 2.214272, 2.584160};
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(b.time(k), times[k], 1e-6);
  EXPECT_NEAR(b.apex(0), 0.64, 1e-12);
  EXPECT_NEAR(b.apex(1), 0.4096, 1e-12);
  EXPECT_NEAR(b.apex(2), 0.262144, 1e-12);
  EXPECT_NEAR(b.rest_time(), 4.063713, 1e-6);
}

TEST(ClosedForms, ObliquePairHasItsKnownVelocities) {
  const Disc a{{-5, 0.75}, {2, 0}, 0.5, 1, 0};
  const Disc b{{0, 0}, {0, 0}, 1, 3, 0};
  const Impact elastic = collide(a, b, 1, 0);
  ASSERT_TRUE(elastic.hit);
  EXPECT_NEAR(elastic.a.v.x, -0.25, 1e-6);
  EXPECT_NEAR(elastic.a.v.y, 1.299038, 1e-6);
  EXPECT_NEAR(elastic.b.v.x, 0.75, 1e-6);
  EXPECT_NEAR(elastic.b.v.y, -0.433013, 1e-6);
  const Impact rough = collide(a, b, 0.8, 0.1);
  EXPECT_NEAR(rough.a.v.x, -0.141913, 1e-6);
  EXPECT_NEAR(rough.a.v.y, 0.966634, 1e-6);
  EXPECT_NEAR(rough.b.v.x, 0.713971, 1e-6);
  EXPECT_NEAR(rough.b.v.y, -0.322211, 1e-6);
  EXPECT_NEAR(rough.a.omega, -0.935307, 1e-6);
  EXPECT_NEAR(rough.b.omega, -0.155885, 1e-6);
}

TEST(ClosedForms, ImpactKeepsMomentumAndAngularMomentum) {
  const Disc a{{-3, 0.4}, {5, -0.2}, 0.5, 1.5, 7};
  const Disc b{{0.5, -0.1}, {-1, 0.3}, 0.8, 4, -3};
  for (const double friction : {0.0, 0.05, 10.0}) {
    const Impact i = collide(a, b, 0.7, friction);
    ASSERT_TRUE(i.hit);
    const auto angular = [](const Disc& d) {
      return d.mass * cross(d.x, d.v) + 0.5 * d.mass * d.radius * d.radius * d.omega;
    };
    EXPECT_NEAR(length(a.mass * a.v + b.mass * b.v - i.a.mass * i.a.v - i.b.mass * i.b.v), 0, 1e-12);
    EXPECT_NEAR(angular(a) + angular(b), angular(i.a) + angular(i.b), 1e-12);
  }
}

TEST(ClosedForms, StickingImpactLeavesNoSlip) {
  const Impact i = collide({{-3, 0.4}, {5, 0}, 0.5, 1, 0}, {{0, 0}, {0, 0}, 0.5, 2, 0}, 0, 10);
  const Vec n = (1 / length(i.b.x - i.a.x)) * (i.b.x - i.a.x);
  const Vec t{-n.y, n.x};
  const double slip = dot(i.b.v - i.a.v, t) - i.b.omega * i.b.radius - i.a.omega * i.a.radius;
  EXPECT_NEAR(slip, 0, 1e-12);
  EXPECT_NEAR(dot(i.b.v - i.a.v, n), 0, 1e-12);
}

TEST(ClosedForms, WallIsADiscWithoutEnd) {
  // Against a static disc so large that it is flat, both formulas must agree.
  const double angle = 40 * kDegree, speed = 3, radius = 0.5, big = 1e7;
  for (const double friction : {0.05, 0.2, 2.0}) {
    const Disc disc{{0, radius + 1}, {speed * std::sin(angle), -speed * std::cos(angle)}, radius, 1, 0};
    const Disc floor{{0, -big}, {0, 0}, big, std::numeric_limits<double>::infinity(), 0};
    const Impact i = collide(disc, floor, 0.6, friction);
    ASSERT_TRUE(i.hit);
    const double ratio = wall_tangential_ratio(angle, 0.6, friction);
    EXPECT_NEAR(i.a.v.x / disc.v.x, ratio, 1e-5);
    EXPECT_NEAR(i.a.v.y / disc.v.y, -0.6, 1e-5);
    EXPECT_NEAR(-i.a.omega, wall_spin(disc.v.x, ratio, radius), 1e-4);
  }
}

TEST(ClosedForms, FrictionHasItsKnownValues) {
  EXPECT_NEAR((Slide{5, 0.5}.distance()), 2.548420, 1e-6);
  EXPECT_NEAR((Slide{5, 0.5}.time()), 1.019368, 1e-6);
  EXPECT_NEAR((SlideToRoll{5, 0.2}.time()), 0.849473, 1e-6);
  EXPECT_NEAR((SlideToRoll{5, 0.2}.distance()), 3.539472, 1e-5);
  EXPECT_NEAR((SlideToRoll{5, 0.2}.rolling_speed()), 10.0 / 3, 1e-12);
  const Incline rolling{30 * kDegree, 0.3};
  EXPECT_TRUE(rolling.rolls());
  EXPECT_NEAR(rolling.acceleration(), 3.27, 1e-9);
  EXPECT_NEAR(rolling.angular_acceleration(), 6.54, 1e-9);
  EXPECT_FALSE((Incline{60 * kDegree, 0.3}.rolls()));
  EXPECT_NEAR(ThreeDiscs::between_discs(), 0.267949, 1e-6);
  EXPECT_NEAR(ThreeDiscs::on_ground(), 0.089316, 1e-6);
}

TEST(ClosedForms, OrbitHasItsKnownValues) {
  const Orbit o;
  EXPECT_NEAR(o.period(), 2 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(o.energy(), -50, 1e-12);
  EXPECT_NEAR(o.angular_momentum(), 86.602540, 1e-6);
  EXPECT_NEAR(o.start().x, 5, 1e-12);
  EXPECT_NEAR(o.start_velocity().y, 17.320508, 1e-6);
  EXPECT_NEAR(o.energy_of(o.start(), o.start_velocity()), -50, 1e-9);
  EXPECT_NEAR(length(o.position(10 * o.period()) - o.start()), 0, 1e-9);
  EXPECT_NEAR(o.position(o.period() / 2).x, -15, 1e-9);
  // Position and its derivative keep energy and angular momentum anywhere on the way.
  for (const double t : {0.3, 1.7, 4.4}) {
    const double h = 1e-5;
    const Vec v = (1 / (2 * h)) * (o.position(t + h) - o.position(t - h));
    EXPECT_NEAR(o.energy_of(o.position(t), v), -50, 1e-6);
    EXPECT_NEAR(cross(o.position(t), v), o.angular_momentum(), 1e-6);
  }
}

}  // namespace
}  // namespace reference
