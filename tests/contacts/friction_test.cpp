// Friction with and without rotation: sliding to rolling, inclines, stopping, three discs.
#include "reference/closed_forms.h"
#include "support.h"

namespace psim::test {
namespace {

TEST(Friction, SlidingDiscComesToRoll) {
  for (const Isa isa : available_isas()) {
    auto world = make(unbounded(), isa);
    add(*world, ground(material(0, 0.2)));
    const BodyId id = add(*world, disc({-50, 0.5}, {5, 0}, 0.5, material(0, 0.2)));
    run(*world, 240);
    const reference::SlideToRoll truth{5, 0.2, kG};
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.vx / truth.rolling_speed(), 1, 5e-3) << isa_name(isa);
    EXPECT_NEAR(s.omega / (-truth.rolling_speed() / 0.5), 1, 5e-3) << isa_name(isa);
    EXPECT_NEAR((s.x + 50) / truth.position(4), 1, 5e-3) << isa_name(isa);
  }
}

TEST(Friction, RollingGoesOnForEver) {
  auto world = make(unbounded());
  add(*world, ground(material(0, 0.5)));
  BodyDesc body = disc({-50, 0.5}, {3, 0}, 0.5, material(0, 0.5));
  body.angular_velocity = -6;
  const BodyId id = add(*world, body);
  run_seconds(*world, 20);
  EXPECT_NEAR(state(*world, id).vx, 3, 1e-3);
  EXPECT_NEAR(state(*world, id).omega, -6, 2e-3);
  EXPECT_NEAR(state(*world, id).x, 10, 1e-2);
}

TEST(Friction, DiscRollsOrSlidesDownAnIncline) {
  for (const double degrees : {10.0, 30.0, 41.0, 44.0, 60.0}) {  // rolls up to atan(0.9) = 41.99
    const reference::Incline truth{degrees * kPi / 180, 0.3, 0.5, kG};
    auto world = make(unbounded(100, {kG * std::sin(truth.angle), -kG * std::cos(truth.angle)}));
    add(*world, ground(material(0, 0.3)));
    const BodyId id = add(*world, disc({-20, 0.5}, {}, 0.5, material(0, 0.3)));
    run(*world, 60);
    const BodyState s = state(*world, id);
    EXPECT_NEAR((s.x + 20) / (0.5 * truth.acceleration()), 1, 5e-3) << degrees;
    EXPECT_NEAR(s.vx / truth.acceleration(), 1, 5e-3) << degrees;
    EXPECT_NEAR(s.omega / -truth.angular_acceleration(), 1, 5e-3) << degrees;
  }
}

TEST(Friction, StopsWhatCannotTurn) {
  const reference::Slide truth{5, 0.5, kG};
  auto world = make(unbounded());
  add(*world, ground(material(0, 0.5)));
  BodyDesc body = disc({-50, 0.5}, {5, 0}, 0.5, material(0, 0.5));
  body.fixed_rotation = true;
  const BodyId id = add(*world, body);
  run(*world, 120);
  const BodyState stopped = state(*world, id);
  EXPECT_NEAR(stopped.x + 50, truth.distance(), 5e-3);
  run(*world, 600);
  EXPECT_LT(std::abs(state(*world, id).x - stopped.x) / 10, 1e-6);  // m/s of creep
}

TEST(Friction, HoldsOrLetsGoOfWhatCannotTurnOnAnIncline) {
  for (const double factor : {0.98, 1.02}) {  // of the friction needed
    const double angle = 20 * kPi / 180;
    const double mu = factor * std::tan(angle);
    auto world = make(unbounded(100, {kG * std::sin(angle), -kG * std::cos(angle)}));
    add(*world, ground(material(0, mu)));
    BodyDesc body = disc({0, 0.5}, {}, 0.5, material(0, mu));
    body.fixed_rotation = true;
    const BodyId id = add(*world, body);
    run_seconds(*world, 5);
    const double slide = 0.5 * kG * (std::sin(angle) - mu * std::cos(angle)) * 25;
    if (factor > 1) {
      EXPECT_LT(std::abs(state(*world, id).x), 1e-4);
    } else {
      EXPECT_NEAR(state(*world, id).x / slide, 1, 0.05);
    }
  }
}

/// Height of the upper disc of three after the time.
double top_of_three(double mu_discs, double mu_ground, double seconds) {
  // Friction mixes by geometric mean: a ground of mu_g^2 / mu_d makes mu_g with the discs.
  auto world = make(unbounded());
  add(*world, ground(material(0, mu_ground * mu_ground / mu_discs)));
  const Material m = material(0, mu_discs);
  add(*world, disc({-0.5, 0.5}, {}, 0.5, m));
  add(*world, disc({0.5, 0.5}, {}, 0.5, m));
  const BodyId top = add(*world, disc({0, 0.5 + std::sqrt(3) / 2}, {}, 0.5, m));
  run_seconds(*world, seconds);
  return state(*world, top).y;
}

TEST(Friction, ThreeDiscsStandIffTheFrictionSuffices) {
  const double height = 0.5 + std::sqrt(3) / 2;
  EXPECT_NEAR(top_of_three(0.28, 0.28, 10), height, 0.02);
  EXPECT_LT(top_of_three(0.25, 0.25, 10), height - 0.1);
  EXPECT_NEAR(top_of_three(0.5, 0.095, 10), height, 0.02);  // the ground needs a third of it
  EXPECT_LT(top_of_three(0.5, 0.080, 10), height - 0.1);
}

TEST(Friction, ThreeDiscsStandForAMinute) { EXPECT_NEAR(top_of_three(0.28, 0.28, 60), 0.5 + std::sqrt(3) / 2, 0.02); }

TEST(Friction, WithoutAnyNothingTurns) {
  auto world = pile(200);
  run(*world, 300);
  const PublishedState s = world->published();
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    ASSERT_EQ(s.omega[k], 0);
    ASSERT_EQ(s.angle[k], 0);
  }
}

TEST(Friction, LosesEnergyOnly) {
  auto world = make(walled({0, 0, 30, 30}, {0, 0}, material(1, 0.8)));
  add(*world, lattice(200, {0, 0, 30, 30}, 0.5, 10, material(1, 0.8)));
  double lowest = world->diagnostics().kinetic;
  for (int k = 0; k < 600; ++k) {
    world->step();
    const double now = world->diagnostics().kinetic;
    ASSERT_LT(now, lowest * (1 + 1e-5)) << "frame " << k;
    lowest = std::min(lowest, now);
  }
}

}  // namespace
}  // namespace psim::test
