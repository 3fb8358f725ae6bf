// What stands: stacks, pyramids, heavy on light, overhangs, and what a load does that lands or goes.
// Bounds are of docs/solver.md; where the statics have an answer, that is the truth.
#include "rigid_support.h"

namespace psim::test {
namespace {

struct Standing {
  double sinking = 0;   // of the top, worst on the way
  double sideways = 0;  // worst at the end
  double speed = 0;     // fastest at the end
};

Standing stand(int boxes, int frames, Isa isa = best_isa()) {
  Placed p = stack(boxes, isa);
  Standing result;
  for (int k = 0; k < frames; ++k) {
    p.world->step();
    result.sinking = std::max(result.sinking, std::abs(p.top().y - (boxes - 0.5)));
  }
  result.sideways = p.sideways();
  result.speed = p.fastest();
  return result;
}

TEST(RigidStack, OfTenAndTwentyStands) {
  for (const int boxes : {1, 2, 3, 10, 20}) {
    const Standing s = stand(boxes, 1000);
    EXPECT_LT(s.sinking, 0.002) << boxes;
    EXPECT_LT(s.sideways, 1e-5) << boxes;
    EXPECT_LT(s.speed, 1e-4) << boxes;
  }
}

TEST(RigidStack, OfAHundredStands) {
  const Standing s = stand(100, 1000);
  EXPECT_LT(s.sinking, 0.05);
  EXPECT_LT(s.sideways, 1e-4);
  EXPECT_LT(s.speed, 1e-3);
}

TEST(SlowRigidStack, OfAHundredStandsForAMinuteOnEveryIsa) {
  for (const Isa isa : available_isas()) {
    const Standing s = stand(100, 3600, isa);
    EXPECT_LT(s.sinking, 0.05) << isa_name(isa);
    EXPECT_LT(s.sideways, 1e-4) << isa_name(isa);
    EXPECT_LT(s.speed, 1e-3) << isa_name(isa);
  }
}

TEST(SlowRigidStack, OfTwoHundredStands) {
  Placed p = stack(200);
  run(*p.world, 1000);
  EXPECT_LT(std::abs(p.top().y - 199.5), 0.2);
  EXPECT_LT(p.sideways(), 1e-3);
}

/// Takes the boxes above `keep` away after two seconds; how far and fast the rest rises.
void expect_quiet_unloading(Placed& p, std::size_t keep, double rise) {
  run(*p.world, 120);
  const double before = p.now(keep - 1).y;
  for (std::size_t k = keep; k < p.ids.size(); ++k) ASSERT_TRUE(p.world->remove_body(p.ids[k]));
  double highest = before, fastest = 0;
  for (int k = 0; k < 120; ++k) {
    p.world->step();
    highest = std::max(highest, p.now(keep - 1).y);
    fastest = std::max(fastest, p.now(keep - 1).vy);
  }
  EXPECT_LT(highest - before, rise) << keep;
  EXPECT_LT(fastest, 0.1) << keep;
  EXPECT_LT(p.fastest(), 1e-3) << keep;
  EXPECT_LT(p.sideways(), 1e-3) << keep;
}

TEST(RigidStack, RisesLittleWhenTheUpperHalfIsTakenAway) {
  Placed p = stack(100);
  expect_quiet_unloading(p, 50, 0.02);
}

TEST(RigidStack, RisesLittleWhenAHeavyBoxIsTakenAway) {
  for (const double mass : {10.0, 100.0, 1000.0}) {
    Placed p = stack(5);
    p.put(box({0, 5.5}, 1, 1, kGrip, mass));
    expect_quiet_unloading(p, 5, 5e-5 * mass);
  }
}

TEST(RigidStack, FallsWhenItsLowestBoxIsTakenAway) {
  Placed p = stack(20);
  run(*p.world, 120);
  ASSERT_TRUE(p.world->remove_body(p.ids[0]));
  p.world->step();
  for (std::size_t k = 1; k < p.ids.size(); ++k) EXPECT_NEAR(p.now(k).vy, -kG / 60, 0.02) << k;
  run(*p.world, 600);
  EXPECT_LT(std::abs(p.top().y - 18.5), 0.05);
  EXPECT_LT(p.sideways(), 0.3);  // of a tower that was dropped by a metre
}

// Nobody puts boxes down to the micrometre: tilted, apart, let fall.
TEST(RigidStack, OfNineteenStandsHoweverRoughlyItIsPutDown) {
  struct Rough {
    double fall, gap, tilt;  // m, m, rad
  };
  for (const Rough& rough : {Rough{0, 0.001, 0.001}, Rough{0, 0.01, 0.0001}, Rough{0.05, 0, 0.001},
                             Rough{0.05, 0.001, 0.0001}, Rough{1, 0.01, 0.0001}}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      Random random(seed);
      Placed p{make(unbounded(200)), {}, {}};
      add(*p.world, ground(kGrip));
      double y = rough.fall;
      for (int k = 0; k < 19; ++k, y += 1) {
        y += random.uniform(0, rough.gap);
        const double tilt = random.uniform(-rough.tilt, rough.tilt);
        p.put(turned(box({random.uniform(-1e-4, 1e-4), y + 0.5}, 1, 1, kGrip, 1), tilt));
      }
      run(*p.world, 600);
      EXPECT_NEAR(p.top().y, 18.5, 0.05) << rough.fall << " " << rough.gap << " " << rough.tilt << " " << seed;
      EXPECT_LT(p.sideways(), 0.3) << rough.fall << " " << rough.gap << " " << rough.tilt << " " << seed;
    }
  }
}

TEST(RigidStack, OfFiveCarriesTenToAThousandTimesItsBoxes) {
  const std::pair<double, double> cases[] = {{10, 0.001}, {100, 0.005}, {1000, 0.040}};
  for (const auto& [mass, sinking] : cases) {
    Placed p = stack(5);
    p.put(box({0, 5.5}, 1, 1, kGrip, mass));
    double worst = 0;
    for (int k = 0; k < 600; ++k) {
      p.world->step();
      worst = std::max(worst, 5.5 - p.top().y);
    }
    EXPECT_LT(worst, sinking) << mass;
    EXPECT_LT(p.sideways(), 1e-3) << mass;
    EXPECT_LT(p.fastest(), 1e-3) << mass;
  }
}

// What sleeps is not compressed by what is put on it: two millimetres in thirty metres.
TEST(RigidStack, GrowsBoxByBoxOnWhatSleeps) {
  Placed p = stack(1);
  for (int k = 1; k < 30; ++k) {
    p.put(box({0, k + 0.5}, 1, 1, kGrip, 1));
    run(*p.world, 60);
  }
  EXPECT_LT(std::abs(p.top().y - 29.5), 0.008);
  EXPECT_LT(p.sideways(), 1e-5);
}

TEST(RigidStack, GrowsBoxByBox) {
  Placed p = stack(1);
  p.world->set_sleeping(false);
  double shaken = 0;
  for (int k = 1; k < 30; ++k) {
    p.put(box({0, k + 0.5}, 1, 1, kGrip, 1));
    run(*p.world, 60);
    shaken = std::max(shaken, p.fastest());
  }
  EXPECT_LT(std::abs(p.top().y - 29.5), 0.005);
  EXPECT_LT(shaken, 1e-3);
  EXPECT_LT(p.sideways(), 1e-5);
}

TEST(RigidStack, OnABoxedFloorOfTheWorldStands) {
  auto world = make(walled({-20, 0, 20, 60}, {0, -kG}, kGrip));
  std::vector<BodyId> ids;
  for (int k = 0; k < 20; ++k) ids.push_back(add(*world, box({0, k + 0.5}, 1, 1, kGrip)));
  run(*world, 600);
  EXPECT_NEAR(state(*world, ids.back()).y, 19.5, 0.005);
  EXPECT_LT(std::abs(state(*world, ids.back()).x), 1e-5);
}

TEST(RigidStack, OnAStaticBoxOrAKinematicOneStands) {
  for (const bool still : {true, false}) {
    auto world = make(unbounded());
    const BodyDesc floor = box({0, -0.5}, 10, 1, kGrip);
    add(*world, still ? fixed(floor) : kinematic(floor));
    std::vector<BodyId> ids;
    for (int k = 0; k < 20; ++k) ids.push_back(add(*world, box({0, k + 0.5}, 1, 1, kGrip)));
    run(*world, 600);
    EXPECT_NEAR(state(*world, ids.back()).y, 19.5, 0.005) << still;
    EXPECT_LT(std::abs(state(*world, ids.back()).x), 1e-5) << still;
  }
}

TEST(RigidStack, OnALiftRidesUpAndDown) {
  auto world = make(unbounded());
  const BodyId lift = add(*world, kinematic(box({0, -0.5}, 10, 1, kGrip)));
  std::vector<BodyId> ids;
  for (int k = 0; k < 10; ++k) ids.push_back(add(*world, box({0, k + 0.5}, 1, 1, kGrip)));
  for (int k = 0; k < 600; ++k) {
    world->set_velocity(lift, {0, 0.5 * std::sin(2 * kPi * k / 300)}, 0);
    world->step();
  }
  const double floor = state(*world, lift).y + 0.5;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    EXPECT_NEAR(state(*world, ids[k]).y - floor, static_cast<double>(k) + 0.5, 0.005) << k;
    EXPECT_LT(std::abs(state(*world, ids[k]).x), 1e-4) << k;
  }
}

// ---- pyramids ---------------------------------------------------------------------------------

TEST(RigidPyramid, OfTenStands) {
  Placed p = pyramid(10);
  run_seconds(*p.world, 10);
  EXPECT_LT(p.moved(), 0.004);
  EXPECT_LT(p.fastest(), 1e-3);
}

TEST(RigidPyramid, OfTwentyStands) {
  Placed p = pyramid(20);
  run_seconds(*p.world, 10);
  EXPECT_LT(p.moved(), 0.010);
  EXPECT_LT(p.fastest(), 1e-3);
}

TEST(SlowRigidPyramid, OfFortyStands) {
  Placed p = pyramid(40);
  run_seconds(*p.world, 10);
  EXPECT_LT(p.moved(), 0.04);
  EXPECT_LT(p.fastest(), 1e-2);
}

// But for the order of the sweeps, which the settling of the first frames keeps a trace of.
TEST(RigidPyramid, MirroredGivesTheMirroredResult) {
  Placed left = pyramid(10), right = pyramid(10, -1);
  run(*left.world, 300);
  run(*right.world, 300);
  double apart = 0, turned = 0;
  for (std::size_t k = 0; k < left.ids.size(); ++k) {
    apart = std::max(apart, std::hypot(left.now(k).x + right.now(k).x, left.now(k).y - right.now(k).y));
    turned = std::max(turned, std::abs(left.now(k).angle + right.now(k).angle));
  }
  EXPECT_LT(apart, 1e-3);
  EXPECT_LT(turned, 3e-4);
}

// ---- few supports -----------------------------------------------------------------------------

TEST(RigidSupport, TwoSmallBoxesCarryAThousandTimesTheirMass) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  const BodyId left = add(*world, box({-9, 0.5}, 1, 1, kGrip, 1));
  const BodyId right = add(*world, box({9, 0.5}, 1, 1, kGrip, 1));
  const BodyId heavy = add(*world, box({0, 11}, 20, 20, kGrip, 1000));
  double lowest = 11;
  for (int k = 0; k < 600; ++k) {
    world->step();
    lowest = std::min(lowest, state(*world, heavy).y);
  }
  EXPECT_LT(11 - lowest, 0.05);
  EXPECT_LT(std::abs(state(*world, heavy).x), 1e-3);
  EXPECT_LT(std::abs(state(*world, heavy).angle), 1e-3);
  EXPECT_NEAR(state(*world, left).y, state(*world, right).y, 1e-4);
}

/// n boxes, each moved by `shift` against the one below: stand iff shift <= 1 / n.
bool overhang_stands(int n, double shift, double mirror) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  BodyId top;
  for (int k = 0; k < n; ++k) top = add(*world, box({mirror * k * shift, k + 0.5}, 1, 1, kGrip));
  run_seconds(*world, 10);
  return state(*world, top).y > n - 0.5 - 0.1;
}

TEST(RigidSupport, OverhangStandsUpToItsLimit) {
  for (const double mirror : {1.0, -1.0}) {
    for (const int n : {2, 3, 4, 5, 10}) {
      EXPECT_TRUE(overhang_stands(n, 0.97 / n, mirror)) << n << " to side " << mirror;
      EXPECT_FALSE(overhang_stands(n, 1.03 / n, mirror)) << n << " to side " << mirror;
    }
  }
}

TEST(RigidSupport, MirroredOverhangFallsTheMirroredWay) {
  Placed p[2];
  for (int side = 0; side < 2; ++side) {
    p[side].world = make(unbounded());
    add(*p[side].world, ground(kGrip));
    for (int k = 0; k < 6; ++k) p[side].put(box({(side ? -1 : 1) * k * 0.2, k + 0.5}, 1, 1, kGrip));
    run(*p[side].world, 60);
  }
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(p[0].now(k).x, -p[1].now(k).x, 1e-4) << k;
    EXPECT_NEAR(p[0].now(k).y, p[1].now(k).y, 1e-4) << k;
    EXPECT_NEAR(p[0].now(k).angle, -p[1].now(k).angle, 1e-4) << k;
  }
}

TEST(RigidSupport, APlankOnTwoPostsStaysLevel) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  add(*world, box({-4, 1}, 0.5, 2, kGrip));
  add(*world, box({4, 1}, 0.5, 2, kGrip));
  const BodyId plank = add(*world, box({0, 2.1}, 10, 0.2, kGrip));
  const BodyId load = add(*world, box({2, 2.7}, 1, 1, kGrip, 20));
  run_seconds(*world, 10);
  EXPECT_NEAR(state(*world, plank).y, 2.1, 0.005);
  EXPECT_NEAR(state(*world, plank).angle, 0, 2e-3);
  EXPECT_NEAR(state(*world, load).x, 2, 1e-3);
}

// ---- impacts ----------------------------------------------------------------------------------

TEST(RigidImpact, AHeavyBoxThatFallsOnAStackIsCaught) {
  Placed p = stack(10);
  run(*p.world, 60);
  const BodyId heavy = p.put(box({0, 15.5}, 1, 1, kGrip, 10));
  double lowest = 100, rebound = 0;
  bool landed = false;
  for (int k = 0; k < 600; ++k) {
    p.world->step();
    const BodyState s = state(*p.world, heavy);
    landed |= s.y < 10.6;
    lowest = std::min(lowest, s.y);
    if (landed) rebound = std::max(rebound, s.vy);
  }
  EXPECT_GT(lowest, 10.40);
  EXPECT_LT(rebound, 0.1);
  EXPECT_NEAR(p.top().y, 10.5, 0.01);
  p.at.back() = {0, 10.5};
  EXPECT_LT(p.sideways(), 0.01);
  EXPECT_LT(p.fastest(), 1e-3);
}

TEST(RigidImpact, ABoxLandsFlatWithoutSinkingIn) {
  for (const double height : {0.5, 5.0, 50.0}) {
    auto world = make(unbounded());
    add(*world, ground(kGrip));
    const BodyId id = add(*world, box({0, 0.5 + height}, 1, 1, kGrip));
    double lowest = 100, rebound = 0;
    for (int k = 0; k < 400; ++k) {
      world->step();
      lowest = std::min(lowest, state(*world, id).y);
      rebound = std::max(rebound, state(*world, id).vy);
    }
    EXPECT_GT(lowest, 0.5 - 0.005) << height;
    EXPECT_LT(rebound, 0.02) << height;
    EXPECT_LT(std::abs(state(*world, id).angle), 1e-4) << height;
  }
}

TEST(RigidImpact, OnEdgeComesToRestOnASide) {
  for (const double angle : {0.3, 0.7, 1.2}) {
    auto world = make(unbounded());
    add(*world, ground(kGrip));
    const BodyId id = add(*world, turned(box({0, 3}, 1, 1, kGrip), angle));
    run_seconds(*world, 5);
    const BodyState s = state(*world, id);
    EXPECT_NEAR(std::remainder(s.angle, 0.5 * kPi), 0, 1e-4) << angle;
    EXPECT_NEAR(s.y, 0.5, 1e-3) << angle;
    EXPECT_LT(speed_of(s), 1e-5) << angle;
  }
}

// ---- two points of one contact that say the same -----------------------------------------------------

/// What the ground bears after `frames`, in weights of the bodies: the least and the most of the next `looks`.
std::pair<double, double> borne(World& world, double mass, int frames, int looks) {
  run(world, frames);
  double least = 1e9, most = 0;
  for (int k = 0; k < looks; ++k) {
    world.step();
    double impulse = 0;
    for (const Contact& c : world.contacts()) {
      if (c.b == kNoBody) impulse += c.impulse * c.normal.y * -60;
    }
    least = std::min(least, impulse / (mass * kG));
    most = std::max(most, impulse / (mass * kG));
  }
  return {least, most};
}

TEST(RigidTwins, BoxesThatDoNotTurnStandStill) {
  for (const double mass : {0.3, 1.0, 2.7, 13.1}) {
    auto world = make(walled({0, 0, 10, 20}, {0, -kG}, kGrip));
    world->set_sleeping(false);
    for (int k = 0; k < 3; ++k) {
      BodyDesc body = box({5.013, 0.5 + k}, 1, 1, kGrip, mass);
      body.fixed_rotation = true;
      add(*world, body);
    }
    const auto [least, most] = borne(*world, 3 * mass, 200, 100);
    EXPECT_NEAR(least, 1, 1e-3) << mass;
    EXPECT_NEAR(most, 1, 1e-3) << mass;
    for (const double vy : world->published().vy) EXPECT_LT(std::abs(vy), 1e-5) << mass;
  }
}

TEST(RigidTwins, AFootOfTwoMillimetresBearsItsBody) {
  for (const double mass : {0.3, 1.0, 2.7, 13.1}) {
    auto world = make(walled({0, 0, 10, 20}, {0, -kG}, kGrip));
    world->set_sleeping(false);
    BodyDesc body = polygon({{-0.001, -0.5}, {0.001, -0.5}, {0.4, 0}, {0, 0.5}, {-0.4, 0}}, {5.013, 0.5}, kGrip);
    body.mass = mass;
    const BodyId id = add(*world, body);
    const auto [least, most] = borne(*world, mass, 5, 10);
    EXPECT_NEAR(least, 1, 1e-2) << mass;
    EXPECT_NEAR(most, 1, 1e-2) << mass;
    EXPECT_LT(std::abs(state(*world, id).vy), 1e-3) << mass;
  }
}

}  // namespace
}  // namespace psim::test
