// A disc that bounces: energy for ever at e = 1, times and apexes below, rest in the end.
#include "reference/closed_forms.h"
#include "support.h"

namespace psim::test {
namespace {

/// A disc of radius 0.5 let go 1 m above a floor: a segment, a wall or the top of a static disc.
enum class Floor { segment, wall, disc };

std::unique_ptr<World> bouncing(Floor floor, double restitution, BodyId& id, Isa isa = best_isa()) {
  const Material m = material(restitution);
  auto world = floor == Floor::wall ? make(walled({-50, 0, 50, 100}, {0, -kG}, m), isa) : make(unbounded(), isa);
  if (floor == Floor::segment) add(*world, ground(m));
  if (floor == Floor::disc) add(*world, static_disc({0, -2}, 2, m));
  id = add(*world, disc({0, 1.5}, {}, 0.5, m));
  return world;
}

TEST(Bounce, ElasticKeepsItsEnergyForThirtySeconds) {
  for (const Isa isa : available_isas()) {
    for (const Floor floor : {Floor::segment, Floor::wall}) {
      BodyId id;
      auto world = bouncing(floor, 1, id, isa);
      const double start = energy(*world);
      const double drop = kPi * 0.25 * kG;
      double worst = 0;
      for (int k = 0; k < 1800; ++k) {
        world->step();
        worst = std::max(worst, std::abs(energy(*world) - start) / drop);
      }
      EXPECT_LT(worst, 1e-3) << isa_name(isa);
    }
  }
}

TEST(Bounce, ElasticComesBackToItsHeight) {
  BodyId id;
  auto world = bouncing(Floor::segment, 1, id);
  double apex = 0;
  const reference::Bounces truth{1, 1, kG};
  while (world->frame() < static_cast<std::uint64_t>(60 * truth.time(9))) world->step();
  for (int k = 0; k < 60; ++k) {
    world->step();
    const BodyState s = state(*world, id);
    if (s.vy * s.vy < 4) apex = std::max(apex, s.y - 0.5 + s.vy * s.vy / (2 * kG));
  }
  EXPECT_NEAR(apex, 1, 1e-3);
}

TEST(Bounce, HasTheClosedFormsTimesAndApexes) {
  for (const double e : {0.8, 0.5}) {
    for (const Floor floor : {Floor::segment, Floor::wall, Floor::disc}) {
      BodyId id;
      auto world = bouncing(floor, e, id);
      const reference::Bounces truth{1, e, kG};
      for (int bounce = 0; bounce < 5; ++bounce) {
        // Look in mid flight: the apex and the time of the last bounce follow from one state.
        const double middle = 0.5 * (truth.time(bounce) + truth.time(bounce + 1));
        while (static_cast<double>(world->frame()) < 60 * middle) world->step();
        const double t = static_cast<double>(world->frame()) / 60;
        if (t > truth.time(bounce + 1)) break;  // shorter than a frame
        const BodyState s = state(*world, id);
        const double apex = s.y - 0.5 + s.vy * s.vy / (2 * kG);
        const double began = t - (std::sqrt(2 * kG * apex) - s.vy) / kG;
        EXPECT_NEAR(apex, truth.apex(bounce), 1e-3) << "e " << e << " bounce " << bounce;
        EXPECT_NEAR(began, truth.time(bounce), 1e-3) << "e " << e << " bounce " << bounce;
      }
    }
  }
}

TEST(Bounce, EndsAtRest) {
  for (const double e : {0.8, 0.5, 0.0}) {
    BodyId id;
    auto world = bouncing(Floor::segment, e, id);
    run_seconds(*world, reference::Bounces{1, e, kG}.rest_time() + 2);
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.y, 0.5, 1e-3) << e;
    EXPECT_NEAR(s.vy, 0, 1e-3) << e;
    EXPECT_EQ(s.x, 0) << e;
  }
}

TEST(Bounce, NeverGainsEnergy) {
  for (const double e : {0.2, 0.5, 0.8, 0.95}) {
    BodyId id;
    auto world = bouncing(Floor::segment, e, id);
    double lowest = energy(*world);
    const double drop = kPi * 0.25 * kG;
    for (int k = 0; k < 600; ++k) {
      world->step();
      EXPECT_LT(energy(*world), lowest + 1e-3 * drop) << e << " frame " << k;
      lowest = std::min(lowest, energy(*world));
    }
  }
}

TEST(Bounce, BelowTheThresholdThereIsNone) {
  for (const double speed : {0.9, 1.1}) {
    WorldDesc desc = walled({-5, 0, 5, 10}, {0, 0}, material(1));
    desc.restitution_threshold = 1;
    auto world = make(desc);
    const BodyId id = add(*world, disc({0, 1}, {0, -speed}, 0.5, material(1)));
    run(*world, 120);
    EXPECT_NEAR(state(*world, id).vy, speed < 1 ? 0 : speed, 1e-4) << speed;
  }
}

TEST(Bounce, OfStepsOfAnyLengthKeepsItsEnergy) {
  BodyId id;
  auto world = bouncing(Floor::segment, 1, id);
  const double start = energy(*world);
  Random random(5);
  for (int k = 0; k < 1000; ++k) world->step(random.uniform(1.0 / 240, 1.0 / 30));
  EXPECT_NEAR(energy(*world) / start, 1, 2e-3);
}

}  // namespace
}  // namespace psim::test
