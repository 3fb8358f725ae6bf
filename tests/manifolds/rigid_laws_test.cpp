// Laws of contacts of shapes: momentum of what falls together, energy of what is elastic, mirror images.
#include "rigid_support.h"

namespace psim::test {
namespace {

// A cloud of shapes that meet each other in the air.
std::vector<BodyId> cloud(World& world, const Material& m, double speed) {
  Random random(3);
  std::vector<BodyId> ids;
  for (int k = 0; k < 144; ++k) {
    const Vec2 at{1.1 * (k % 12), 0.9 * (k / 12)};
    BodyDesc body = k % 3 == 0   ? capsule(at, 0.6, 0.15, m)
                    : k % 3 == 1 ? box(at, 0.6, 0.4, m)
                                 : polygon({{-0.4, -0.3}, {0.4, -0.3}, {0.1, 0.4}}, at, m);
    const Vec2 v{random.uniform(-speed, speed), random.uniform(-speed, speed)};
    body.mass = 1;
    ids.push_back(add(world, moving(turned(body, random.uniform(0, 3)), v)));
  }
  return ids;
}

// All bodies of the cloud have the same mass.
Vec2 mean_velocity(const World& world, const std::vector<BodyId>& ids) {
  Vec2 sum;
  for (const BodyId id : ids) sum = {sum.x + state(world, id).vx, sum.y + state(world, id).vy};
  const auto n = static_cast<double>(ids.size());
  return {sum.x / n, sum.y / n};
}

WorldDesc with_substeps(WorldDesc desc, int substeps) {
  desc.substeps = substeps;
  desc.sleeping = false;
  return desc;
}

TEST(RigidLaws, BoxesThatMeetInTheAirStayTogether) {
  for (const int substeps : {1, 4, 16}) {
    auto world = make(with_substeps(unbounded(1000), substeps));
    const BodyId low = add(*world, box({0, 0}, 1, 1, kGrip));
    const BodyId high = add(*world, moving(box({0, 2}, 1, 1, kGrip), {0, -4}));
    run(*world, 60);
    EXPECT_NEAR(state(*world, high).vy, state(*world, low).vy, 1e-3) << substeps;
    EXPECT_NEAR(state(*world, high).vy + state(*world, low).vy, -4 - 2 * kG, 1e-3) << substeps;
  }
}

TEST(RigidLaws, ACloudThatFallsKeepsItsMomentum) {
  for (const double e : {0.0, 0.5}) {
    for (const int substeps : {1, 4, 16}) {
      auto world = make(with_substeps(unbounded(1000), substeps));
      const std::vector<BodyId> ids = cloud(*world, material(e, 0.5), 3);
      const Vec2 before = mean_velocity(*world, ids);
      run(*world, 90);
      const Vec2 after = mean_velocity(*world, ids);
      EXPECT_NEAR(after.x - before.x, 0, 1e-5) << e << " " << substeps;
      EXPECT_NEAR(after.y - before.y, -kG * 1.5, 3e-4) << e << " " << substeps;
    }
  }
}

TEST(RigidLaws, AnElasticGasKeepsItsEnergy) {
  for (const double gravity : {0.0, kG}) {
    for (const int substeps : {1, 4}) {
      const Material m = material(1, 0);
      auto world = make(with_substeps(walled({-4, -4, 18, 18}, {0, -gravity}, m), substeps));
      cloud(*world, m, 6);
      const double before = energy(*world);
      run_seconds(*world, 10);
      EXPECT_NEAR(energy(*world) / before, 1, 5e-3) << gravity << " " << substeps;
    }
  }
}

}  // namespace
}  // namespace psim::test
