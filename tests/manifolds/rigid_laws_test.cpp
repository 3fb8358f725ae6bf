// Laws of contacts of shapes: momentum of what falls together, energy of what is elastic, mirror images.
#include <algorithm>
#include <cmath>
#include <vector>

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

// Within walls or a pen of static segments, which bodies meet several times in a frame.
TEST(RigidLaws, AnElasticGasKeepsItsEnergy) {
  const Vec2 corners[] = {{-4, -4}, {18, -4}, {18, 18}, {-4, 18}};
  const Material m = material(1, 0);
  for (const double gravity : {0.0, kG}) {
    for (const bool pen : {false, true}) {
      for (const int substeps : {1, 4, 16}) {
        const Vec2 down{0, -gravity};
        auto world = make(with_substeps(pen ? unbounded(100, down) : walled({-4, -4, 18, 18}, down, m), substeps));
        for (int k = 0; k < 4 && pen; ++k) {
          BodyDesc side = segment(corners[k], corners[(k + 1) % 4]);
          side.material = m;
          add(*world, side);
        }
        cloud(*world, m, 6);
        const double before = energy(*world);
        run_seconds(*world, 10);
        EXPECT_NEAR(energy(*world) / before, 1, 1e-3) << gravity << " " << pen << " " << substeps;
      }
    }
  }
}

// A box in free flight towards a plane at y = 0.
struct Flying {
  double w = 1, h = 1, y = 0, angle = 0, vy = 0, omega = 0;

  Vec2 lowest(double t) const {  // its lowest corner, from the centre
    const double c = std::cos(angle + t * omega), s = std::sin(angle + t * omega);
    Vec2 best{0, 1};
    for (const Vec2 p : {Vec2{w, h}, Vec2{-w, h}, Vec2{-w, -h}, Vec2{w, -h}}) {
      const Vec2 at{0.5 * (c * p.x - s * p.y), 0.5 * (s * p.x + c * p.y)};
      if (at.y < best.y) best = at;
    }
    return best;
  }
  double height(double t) const { return y + t * vy + lowest(t).y; }
  void meet(double t, double e) {  // J = -(1 + e) v / (1/m + x^2/I)
    const double x = lowest(t).x, v = vy + omega * x, inertia = (w * w + h * h) / 12;
    const double impulse = -(1 + e) * v / (1 + x * x / inertia);
    y += t * vy, angle += t * omega;
    vy += impulse, omega += impulse * x / inertia;
    y -= t * vy, angle -= t * omega;
  }
};

// Whatever the substeps, a box that turns fast meets the ground with the corner that is lowest then.
TEST(RigidLaws, ATurningBoxMeetsTheGroundAsItStandsThen) {
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const int substeps : {4, 16}) {
      Random random(11);
      std::vector<double> errors;
      while (errors.size() < 40) {
        Flying f{random.uniform(0.4, 1.2), random.uniform(0.3, 1), 0,
                 random.uniform(0, 6),     random.uniform(-8, -2), random.uniform(-12, 12)};
        f.y = -f.lowest(0).y + 0.6;
        double t = 0;
        while (f.height(t) > 0) t += 1e-4;
        for (double step = 5e-5; step > 1e-9; step /= 2) t += f.height(t) > 0 ? step : -step;
        const Flying before = f;
        f.meet(t, e);
        const int frames = static_cast<int>(std::ceil(60 * t)) + 1;
        double least = 1;
        for (double later = t + 1e-4; later < frames / 60.0 + 0.02; later += 1e-3)
          least = std::min(least, f.height(later));
        if (least < 0) continue;  // another corner follows
        auto world = make(with_substeps(unbounded(100, {0, 0}), substeps));
        BodyDesc ground = segment({-20, 0}, {20, 0});
        ground.material = material(e, 0);
        add(*world, ground);
        BodyDesc body = turned(box({0, before.y}, f.w, f.h, material(e, 0)), before.angle);
        const BodyId id = add(*world, moving(body, {0, before.vy}, before.omega));
        run(*world, frames);
        const double arm = std::sqrt((f.w * f.w + f.h * f.h) / 12);
        const BodyState s = state(*world, id);
        errors.push_back(std::hypot(s.vy - f.vy, arm * (s.omega - f.omega)) /
                         std::hypot(f.vy - before.vy, arm * (f.omega - before.omega)));
      }
      std::ranges::sort(errors);
      EXPECT_LT(errors[20], 0.01) << e << " " << substeps;
      EXPECT_LT(errors[38], 0.02) << e << " " << substeps;
    }
  }
}

}  // namespace
}  // namespace psim::test
