// Nothing passes through anything, at any speed, angle and spin; and what misses is left alone.
#include "rigid_support.h"

namespace psim::test {
namespace {

/// Flyers about a quarter of a metre in size, and a plank of 2 cm.
std::vector<std::pair<const char*, BodyDesc>> flyers(Material m) {
  return {{"box", box({0, 0}, 0.5, 0.5, m)},
          {"plank", box({0, 0}, 1, 0.02, m)},
          {"capsule", capsule({0, 0}, 0.6, 0.1, m)},
          {"triangle", polygon({{-0.3, -0.2}, {0.4, -0.2}, {0, 0.4}}, {0, 0}, m)},
          {"disc", disc({0, 0}, {}, 0.2, m)}};
}

constexpr double kPen = 5;  // half the side of a pen around (0, 0)

enum class Wall { segments, chain, boxes, capsules, kinematic_boxes, sides };
constexpr std::pair<const char*, Wall> kWalls[] = {
    {"segments", Wall::segments},         {"chain", Wall::chain}, {"boxes", Wall::boxes}, {"capsules", Wall::capsules},
    {"kinematic", Wall::kinematic_boxes}, {"sides", Wall::sides}};

std::unique_ptr<World> pen(Wall wall, Material m) {
  if (wall == Wall::sides) return make(walled({-kPen, -kPen, kPen, kPen}, {0, 0}, m));
  auto world = make(unbounded(4000, {0, 0}));
  const Vec2 corners[] = {{-kPen, -kPen}, {kPen, -kPen}, {kPen, kPen}, {-kPen, kPen}};
  if (wall == Wall::chain) {
    add(*world, chain({std::begin(corners), std::end(corners)}, true, m));
    return world;
  }
  for (int k = 0; k < 4; ++k) {
    const Vec2 p = corners[k], q = corners[(k + 1) % 4];
    const Vec2 middle{0.5 * (p.x + q.x), 0.5 * (p.y + q.y)};
    const double angle = 0.5 * kPi * k, thick = 0.02;
    switch (wall) {
      case Wall::segments:
        add(*world, segment(p, q, m));
        break;
      case Wall::boxes:
        add(*world, fixed(turned(box(middle, 2 * kPen + thick, thick, m), angle)));
        break;
      case Wall::kinematic_boxes:
        add(*world, kinematic(turned(box(middle, 2 * kPen + thick, thick, m), angle)));
        break;
      case Wall::capsules:
        add(*world, fixed(turned(capsule(middle, 2 * kPen, 0.5 * thick, m), angle)));
        break;
      default:
        break;
    }
  }
  return world;
}

class RigidSpeed : public testing::TestWithParam<std::pair<const char*, Wall>> {};

TEST_P(RigidSpeed, NobodyLeavesThePen) {
  for (const double e : {0.0, 0.5, 1.0}) {
    const Material m = material(e, 0.3);
    for (const auto& [name, flyer] : flyers(m)) {
      for (const double speed : {10.0, 1e2, 1e3, 1e4, 1e5}) {
        Random random(7);
        int lost = 0;
        for (int round = 0; round < 12; ++round) {
          auto world = pen(GetParam().second, m);
          const double heading = round < 2 ? 0.5 * kPi * round : random.uniform(0, 2 * kPi);
          const double spin = round % 3 == 0 ? 0 : random.uniform(-1, 1) * std::min(speed, 500.0);
          BodyDesc body = moving(flyer, {speed * std::cos(heading), speed * std::sin(heading)}, spin);
          body.position = {random.uniform(-3, 3), random.uniform(-3, 3)};
          body.angle = round < 2 ? 0 : random.uniform(0, 6);
          const BodyId id = add(*world, body);
          bool inside = true;
          for (int k = 0; k < 30 && inside; ++k) {
            world->step();
            const BodyState s = state(*world, id);
            inside = std::abs(s.x) < kPen && std::abs(s.y) < kPen;
          }
          lost += inside ? 0 : 1;
        }
        EXPECT_EQ(lost, 0) << name << " at " << speed << " m/s, e " << e;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, RigidSpeed, testing::ValuesIn(kWalls),
                         [](const auto& info) { return std::string(info.param.first); });

// An off-centre bounce may turn a body by radians in a frame, and its corners strike again and again.
TEST(RigidSpeedGains, NoEnergyFromWalls) {
  for (const auto& [wall_name, wall] : kWalls) {
    for (const auto& [name, flyer] : flyers(material(1, 0))) {
      for (const double speed : {10.0, 50.0, 1e3, 1e5}) {
        auto world = pen(wall, material(1, 0));
        add(*world, turned(moving(flyer, {0.8 * speed, 0.6 * speed}, 3), 0.4));
        const double before = world->diagnostics().kinetic;
        double most = 0;
        for (int k = 0; k < 60; ++k) {
          world->step();
          most = std::max(most, world->diagnostics().kinetic);
        }
        EXPECT_LE(most / before, 1.02) << name << " at " << speed << " in " << wall_name;
      }
    }
  }
}

TEST(RigidSpeedOfDiscs, NeverTakesThemThroughAThinBar) {
  const Material m = material(0, 0);
  const std::pair<const char*, BodyDesc> bars[] = {
      {"box", fixed(box({0, 0}, 0.02, 400, m))},
      {"turned box", fixed(turned(box({0, 0}, 400, 0.02, m), 0.5 * kPi))},
      {"triangle", fixed(polygon({{0, -200}, {0.05, 0}, {0, 200}}, {0, 0}, m))},
      {"capsule", fixed(turned(capsule({0, 0}, 400, 0.01, m), 0.5 * kPi))}};
  for (const auto& [what, bar] : bars) {
    for (const double speed : {1e2, 1e3, 1e4, 1e5}) {
      for (const double e : {0.0, 0.5, 1.0}) {
        for (const double heading : {0.0, 0.5, -1.2}) {
          auto world = make(unbounded(4000, {0, 0}));
          BodyDesc own = bar;
          own.material.restitution = e;
          add(*world, own);
          const BodyId id =
              add(*world, disc({-7, 0.3}, {speed * std::cos(heading), speed * std::sin(heading)}, 0.1, material(e)));
          for (int k = 0; k < 60 && std::abs(state(*world, id).y) < 190; ++k) {
            world->step();
            if (!world->is_valid(id) || world->escaped_total() != 0) break;
            ASSERT_LT(state(*world, id).x, 0.05) << what << " at " << speed << " e " << e;
          }
        }
      }
    }
  }
}

// The host moves them. Another body looks at their ways at the same time, so they must not change.
// An elastic disc that bounces several times in a step and comes back to where it was moves little from step to step, and
// a little deeper into a wall each time.
TEST(RigidSpeedOfDiscs, WhoComesBackInEveryStepDoesNotCreepThroughAWall) {
  constexpr double kHalf = 6;
  const Material m = material(1);
  Random random(20261126);
  for (int k = 0; k < 200; ++k) {
    WorldDesc desc = unbounded(2e5, {0, 0});
    desc.substeps = random.chance(0.8) ? 1 : 4;
    auto world = make(desc);
    for (const double side : {-kHalf - 0.5, kHalf + 0.5}) {
      add(*world, fixed(box({0, side}, 2 * kHalf + 2, 1, m)));
      add(*world, fixed(box({side, 0}, 1, 2 * kHalf + 2, m)));
    }
    const double r = random.uniform(0.5, 1), speed = random.uniform(1e3, 1e4), angle = random.uniform(0, 2 * kPi);
    const Vec2 at{random.uniform(-1, 1) * (kHalf - r), random.uniform(-1, 1) * (kHalf - r)};
    const BodyId id = add(*world, disc(at, {speed * std::cos(angle), speed * std::sin(angle)}, r, m));
    for (int frame = 0; frame < 120; ++frame) {
      world->step();
      const BodyState s = state(*world, id);
      ASSERT_LT(std::max(std::abs(s.x), std::abs(s.y)), kHalf) << k << " in frame " << frame;
    }
  }
}

TEST(RigidSpeedOfDiscs, KinematicOnesGoThroughFixedGeometryAsTheHostSays) {
  for (const bool slanted : {false, true}) {
    for (const double speed : {1.0, 10.0, 40.0, 300.0}) {
      auto world = make(unbounded(4000, {0, 0}));
      add(*world, segment({-3, slanted ? -0.7 : 0}, {3, 0}));
      add(*world, disc({0.3, 0.5}, {}, 0.2));
      const double start = 0.5 + 2.5 * speed / 60;
      const BodyId id = add(*world, kinematic(disc({-0.5, start}, {0, -speed}, 0.5)));
      for (int k = 1; k <= 60; ++k) {
        world->step();
        ASSERT_NEAR(state(*world, id).y, start - k * speed / 60, 1e-4 * (1 + speed)) << speed << " frame " << k;
        ASSERT_NEAR(state(*world, id).x, -0.5, 1e-5) << speed << " frame " << k;
      }
    }
  }
}

TEST(RigidFall, AThinPlankTipsOverOntoTheGround) {
  for (const double thick : {0.1, 0.05, 0.02, 0.01, 0.005}) {
    for (const double friction : {0.0, 0.3, 0.6}) {
      for (const double lean : {0.3, 0.8}) {
        const Material m = material(0, friction);
        auto world = make(unbounded());
        add(*world, ground(m));
        const double angle = 0.5 * kPi - lean;
        const double height = 0.5 * std::sin(angle) + 0.5 * thick * std::cos(angle);
        const BodyId id = add(*world, turned(box({0, height}, 1, thick, m), angle));
        const double before = energy(*world);
        double most = before;
        for (int k = 0; k < 180; ++k) {
          world->step();
          most = std::max(most, energy(*world));
        }
        EXPECT_NEAR(state(*world, id).y, 0.5 * thick, 1e-3) << thick << " friction " << friction;
        EXPECT_LT(speed_of(state(*world, id)), 1e-3) << thick << " friction " << friction;
        EXPECT_LT(most / before, 1.1) << thick << " friction " << friction << " lean " << lean;
      }
    }
  }
}

TEST(RigidFall, AThinPlankSlidesOnTheGroundAtAnySpeed) {
  for (const double thick : {0.2, 0.02}) {
    for (const double speed : {5.0, 50.0}) {
      auto world = make(unbounded(500));
      add(*world, ground({}, 500));
      const BodyId id = add(*world, moving(box({-400, 0.5 * thick}, 1, thick), {speed, 0}));
      run_seconds(*world, 5);
      EXPECT_NEAR(state(*world, id).vx, speed, 1e-3 * speed) << thick;
      EXPECT_NEAR(state(*world, id).x, -400 + 5 * speed, 5e-3 * speed) << thick;
    }
  }
}

// ---- bullets ----------------------------------------------------------------------------------

TEST(RigidBullet, DoesNotPassAThinPlate) {
  const Material m = material(0, 0);
  for (const auto& [name, flyer] : flyers(m)) {
    for (const double speed : {1e2, 1e3, 1e4}) {
      for (const double plate_spin : {0.0, 5.0}) {
        Random random(3);
        int passed = 0;
        double change = 0;
        for (int round = 0; round < 10; ++round) {
          auto world = make(unbounded(4000, {0, 0}));
          BodyDesc body = moving(flyer, {speed, 0}, random.uniform(-5, 5));
          body.position = {random.uniform(-8, -3), random.uniform(-0.7, 0.7)};
          body.angle = random.uniform(0, 6);
          body.bullet = true;
          body.mass = 0.1;
          const BodyId bullet = add(*world, body);
          const BodyId plate = add(*world, moving(box({0, 0}, 0.02, 3, m, 1), {0, 0}, plate_spin));
          const double before = world->diagnostics().momentum_x;
          for (int k = 0; k < 20; ++k) {
            world->step();
            const BodyState b = state(*world, bullet), p = state(*world, plate);
            // Ahead of the plate's plane while beside it:
            const double ahead = std::cos(p.angle) * (b.x - p.x) + std::sin(p.angle) * (b.y - p.y);
            const double beside = -std::sin(p.angle) * (b.x - p.x) + std::cos(p.angle) * (b.y - p.y);
            if (ahead > 0.05 && std::abs(beside) < 1.2 && std::abs(p.angle) < 1.2) {
              ++passed;
              break;
            }
          }
          change = std::max(change, std::abs(world->diagnostics().momentum_x - before) / before);
        }
        EXPECT_EQ(passed, 0) << name << " at " << speed << ", plate spins " << plate_spin;
        EXPECT_LT(change, 1e-5) << name << " at " << speed;
      }
    }
  }
}

TEST(RigidBullet, TwoOfThemMeetHeadOn) {
  for (const auto& [name, flyer] : flyers({})) {
    if (std::holds_alternative<PolygonShape>(flyer.shape)) continue;  // it slides off the other
    for (const double speed : {1e2, 1e3, 1e4}) {
      auto world = make(unbounded(4000, {0, 0}));
      BodyDesc a = moving(flyer, {speed, 0}), b = moving(flyer, {-speed, 0});
      a.position = {-3.3, 0};
      b.position = {4.1, 0};
      a.bullet = b.bullet = true;
      const BodyId left = add(*world, a), right = add(*world, b);
      run(*world, 20);
      EXPECT_LT(state(*world, left).x, state(*world, right).x) << name << " at " << speed;
    }
  }
}

// ---- what misses ------------------------------------------------------------------------------

/// Flies along x past `obstacle` with `clear` metres between; whether not a bit of it changed.
void expect_untouched(const BodyDesc& obstacle, const BodyDesc& flyer, double low, double clear, double speed,
                      const char* what) {
  for (const double start : {-20.0, -20.37, -19.81}) {
    auto world = make(unbounded(4000, {0, 0}));
    add(*world, obstacle);
    BodyDesc body = moving(flyer, {speed, 0});
    body.position = {start, clear + low};
    const BodyId id = add(*world, body);
    for (int k = 0; k < 400 && state(*world, id).x < 20; ++k) world->step();
    const BodyState s = state(*world, id);
    EXPECT_EQ(s.vx, static_cast<double>(static_cast<float>(speed))) << what << " at " << speed << " clear by " << clear;
    EXPECT_EQ(s.vy, 0) << what << " at " << speed << " clear by " << clear;
    EXPECT_EQ(s.omega, 0) << what << " at " << speed << " clear by " << clear;
  }
}

TEST(RigidGraze, PastTheEndOfAWallNothingChanges) {
  const std::pair<const char*, BodyDesc> ends[] = {
      {"segment", segment({0, -3}, {0, 0})}, {"chain", chain({{0, -6}, {0, -3}, {0, 0}})},
      {"box", fixed(box({0, -1}, 0.5, 2))},  {"capsule", fixed(turned(capsule({0, -1.2}, 2, 0.2), 0.5 * kPi))},
      {"resting box", box({0, -1}, 0.5, 2)}, {"resting disc", disc({0, -0.5}, {}, 0.5)}};
  for (const auto& [what, obstacle] : ends) {
    for (const double speed : {5.0, 50.0, 1e3, 1e4}) {
      for (const double clear : {0.2, 0.01}) {
        expect_untouched(obstacle, box({0, 0}), 0.5, clear, speed, what);
        expect_untouched(obstacle, box({0, 0}, 2, 0.1), 0.05, clear, speed, what);
        expect_untouched(obstacle, capsule({0, 0}, 1, 0.25), 0.25, clear, speed, what);
      }
    }
  }
}

TEST(RigidGraze, AlongALongWallNothingChanges) {
  const std::pair<const char*, BodyDesc> floors[] = {{"segment", segment({-100, 0}, {100, 0})},
                                                     {"box", fixed(box({0, -1}, 200, 2))}};
  for (const auto& [what, floor] : floors) {
    for (const double speed : {5.0, 50.0, 1e3}) {
      for (const double clear : {0.2, 0.01}) {
        expect_untouched(floor, box({0, 0}), 0.5, clear, speed, what);
        expect_untouched(floor, capsule({0, 0}, 1, 0.25), 0.25, clear, speed, what);
      }
    }
  }
}

TEST(RigidGraze, ASpinningBoxThatMissesGoesOn) {
  for (const double speed : {20.0, 300.0}) {
    auto world = make(unbounded(4000, {0, 0}));
    add(*world, segment({0, -3}, {0, 0}));
    const BodyId id = add(*world, moving(box({-20, 0.75}), {speed, 0}, 30));  // reach 0.7071
    for (int k = 0; k < 400 && state(*world, id).x < 20; ++k) world->step();
    EXPECT_EQ(state(*world, id).vy, 0) << speed;
    EXPECT_NEAR(state(*world, id).vx, speed, 1e-5 * speed);
    EXPECT_NEAR(state(*world, id).omega, 30, 1e-4);
  }
}

}  // namespace
}  // namespace psim::test
