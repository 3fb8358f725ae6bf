// Wells: Kepler orbits, their invariants and the order of the integrator; the formula of the field.
#include "reference/closed_forms.h"
#include "support.h"

namespace psim::test {
namespace {

const reference::Orbit kOrbit;

std::unique_ptr<World> orbit_world(int substeps, BodyId& id, Isa isa = best_isa()) {
  WorldDesc desc = unbounded(100, {0, 0});
  desc.substeps = substeps;
  desc.fields.push_back(WellField{{0, 0}, kOrbit.gm, 0, 2, 0});
  auto world = make(desc, isa);
  const auto v = kOrbit.start_velocity();
  id = add(*world, disc({kOrbit.start().x, 0}, {v.x, v.y}, 0.01));
  return world;
}

double energy_of(const BodyState& s) { return kOrbit.energy_of({s.x, s.y}, {s.vx, s.vy}); }

/// Largest relative error of the energy over `frames`.
double energy_ripple(int substeps, int frames) {
  BodyId id;
  auto world = orbit_world(substeps, id);
  double worst = 0;
  for (int k = 0; k < frames; ++k) {
    world->step();
    worst = std::max(worst, std::abs(energy_of(state(*world, id)) / kOrbit.energy() - 1));
  }
  return worst;
}

TEST(Kepler, KeepsEnergyAndAngularMomentumOverTenOrbits) {
  for (const Isa isa : available_isas()) {
    for (const int substeps : {4, 8}) {
      BodyId id;
      auto world = orbit_world(substeps, id, isa);
      run(*world, 3770);
      const BodyState s = state(*world, id);
      const double l = s.x * s.vy - s.y * s.vx;
      EXPECT_LT(std::abs(energy_of(s) / kOrbit.energy() - 1), substeps == 4 ? 4e-4 : 1e-4);
      EXPECT_LT(std::abs(l / kOrbit.angular_momentum() - 1), 1e-4);
    }
  }
}

TEST(Kepler, EnergyErrorIsOfSecondOrderAndDoesNotDrift) {
  const double coarse = energy_ripple(1, 3770);
  const double fine = energy_ripple(2, 3770);
  EXPECT_LT(coarse, 4e-4);
  EXPECT_GT(coarse / fine, 3);
  EXPECT_LT(coarse / fine, 5);
  EXPECT_LT(energy_ripple(8, 3770), 1e-5);
}

TEST(Kepler, StaysOnTheOrbit) {
  BodyId id;
  auto world = orbit_world(8, id);
  double worst = 0;
  for (int k = 1; k <= 3770; ++k) {
    world->step();
    const auto truth = kOrbit.position(k / 60.0);
    const BodyState s = state(*world, id);
    worst = std::max(worst, std::hypot(s.x - truth.x, s.y - truth.y));
  }
  EXPECT_LT(worst, 0.01);  // second order at 1/480 s: 5 mm after ten orbits
}

TEST(Kepler, DiagnosticsHoldTheWellsPotential) {
  BodyId id;
  auto world = orbit_world(8, id);
  const double mass = kPi * 1e-4;
  EXPECT_NEAR(energy(*world) / (mass * kOrbit.energy()), 1, 1e-5);
  run(*world, 500);
  EXPECT_NEAR(energy(*world) / (mass * kOrbit.energy()), 1, 1e-4);
}

/// Acceleration that a body at rest at `at` gets from the fields.
Vec2 acceleration(std::vector<Field> fields, Vec2 at, double gravity_scale = 1) {
  WorldDesc desc = unbounded(100, {0, 0});
  desc.fields = std::move(fields);
  desc.dt = 1e-4;
  auto world = make(desc);
  BodyDesc body = disc(at, {}, 0.01);
  body.gravity_scale = gravity_scale;
  const BodyId id = add(*world, body);
  world->step();
  return {state(*world, id).vx / 1e-4, state(*world, id).vy / 1e-4};
}

TEST(Well, HasItsFormula) {
  for (const double exponent : {0.0, 1.0, 2.0, 3.0}) {
    for (const double softening : {0.0, 0.5}) {
      const Vec2 a = acceleration({WellField{{1, 2}, 7, softening, exponent, 0}}, {4, 6});
      const double f = 7 / std::pow(25 + softening * softening, 0.5 * (exponent + 1));
      EXPECT_NEAR(a.x / (-3 * f), 1, 1e-4) << exponent << " " << softening;
      EXPECT_NEAR(a.y / (-4 * f), 1, 1e-4) << exponent << " " << softening;
    }
  }
}

TEST(Well, EndsAtItsRange) {
  EXPECT_NE(acceleration({WellField{{0, 0}, 7, 0, 2, 5}}, {4.9, 0}).x, 0);
  EXPECT_EQ(acceleration({WellField{{0, 0}, 7, 0, 2, 5}}, {5.1, 0}).x, 0);
}

TEST(Well, RepelsAddsUpAndObeysGravityScale) {
  EXPECT_GT(acceleration({WellField{{0, 0}, -7, 0, 2, 0}}, {3, 0}).x, 0);
  const Vec2 both = acceleration({WellField{{-3, 0}, 9, 0, 2, 0}, WellField{{3, 0}, 9, 0, 2, 0}}, {0, 1});
  EXPECT_NEAR(both.x, 0, 1e-4);
  EXPECT_NEAR(both.y / (-2 * 9 / std::pow(10, 1.5)), 1, 1e-4);
  const Vec2 once = acceleration({WellField{{0, 0}, 7, 0, 2, 0}}, {3, 0});
  const Vec2 half = acceleration({WellField{{0, 0}, 7, 0, 2, 0}}, {3, 0}, 0.5);
  EXPECT_NEAR(half.x / once.x, 0.5, 1e-4);
}

TEST(Well, ABodyAtItsVeryCentreStaysFinite) {
  for (const double softening : {0.0, 0.1}) {
    WorldDesc desc = unbounded(100, {0, 0});
    desc.fields.push_back(WellField{{0, 0}, 1000, softening, 2, 0});
    auto world = make(desc);
    add(*world, disc({0, 0}));
    add(*world, disc({1e-7, 0}, {}, 0.01));
    run(*world, 120);
    EXPECT_TRUE(all_finite(*world)) << softening;
  }
}

}  // namespace
}  // namespace psim::test
