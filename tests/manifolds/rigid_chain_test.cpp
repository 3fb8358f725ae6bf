// Ground made of many pieces feels like one: chains, rows of boxes, corners of both kinds.
#include "rigid_support.h"

namespace psim::test {
namespace {

constexpr int kPieces = 200;

std::vector<Vec2> level(int pieces, double length, bool backwards) {
  std::vector<Vec2> v;
  for (int k = 0; k <= pieces; ++k) v.push_back({(k - 0.5 * pieces) * length, 0});
  if (backwards) std::reverse(v.begin(), v.end());
  return v;
}

std::vector<std::pair<const char*, BodyDesc>> sliders(Material m) {
  return {{"box", box({0, 0.5}, 1, 1, m)},
          {"plank", box({0, 0.05}, 2, 0.1, m)},
          {"capsule", capsule({0, 0.25}, 1, 0.25, m)},
          {"disc", disc({0, 0.5}, {}, 0.5, m)},
          {"trapezium", polygon({{-0.6, 0}, {0.6, 0}, {0.3, 0.5}, {-0.3, 0.5}}, {0, 0}, m)}};
}

struct Ride {
  double bump = 0;    // fastest up or down, m/s
  double height = 0;  // largest change of height, m
  double turned = 0;  // rad
  double lost = 0;    // of the speed
};

Ride ride(World& world, BodyDesc body, double from, double speed, double seconds) {
  body.position.x = from;
  const BodyId id = add(world, moving(body, {speed, 0}));
  run(world, 30);  // comes to rest on the ground
  const BodyState start = state(world, id);
  Ride result;
  for (int k = 0; k < static_cast<int>(seconds * 60); ++k) {
    world.step();
    const BodyState s = state(world, id);
    result.bump = std::max(result.bump, std::abs(s.vy));
    result.height = std::max(result.height, std::abs(s.y - start.y));
    result.turned = std::max(result.turned, std::abs(s.angle - start.angle));
  }
  result.lost = std::abs(state(world, id).vx / speed - 1);
  return result;
}

TEST(RigidChain, OfCollinearSegmentsHasNoBumps) {
  for (const auto& [name, body] : sliders({})) {
    for (const double piece : {1.0, 0.3}) {
      for (const double speed : {1.0, 7.3, 40.0}) {
        for (const bool backwards : {false, true}) {
          auto world = make(unbounded(200));
          add(*world, chain(level(kPieces, piece, backwards)));
          const double half = 0.5 * kPieces * piece - 4;
          const Ride r = ride(*world, body, -half, speed, std::min(10.0, 2 * half / speed - 1));
          EXPECT_LT(r.bump, 1e-3) << name << " at " << speed << " over " << piece << " m";
          EXPECT_LT(r.turned, 1e-3) << name << " at " << speed << " over " << piece << " m";
          EXPECT_LT(r.lost, 1e-4) << name << " at " << speed << " over " << piece << " m";
        }
      }
    }
  }
}

TEST(RigidChain, OfSeparateSegmentsIsSmoothToo) {
  for (const auto& [name, body] : sliders({})) {
    auto world = make(unbounded(200));
    for (int k = -100; k < 100; ++k) add(*world, segment({1.0 * k, 0}, {k + 1.0, 0}));
    const Ride r = ride(*world, body, -90, 7.3, 10);
    EXPECT_LT(r.bump, 0.1) << name;
    EXPECT_LT(r.lost, 0.01) << name;
  }
}

TEST(RigidChain, OfAdjacentBoxesIsSmoothForASlidingBody) {
  for (const auto& [name, body] : sliders({})) {
    for (const double speed : {1.0, 7.3, 15.0}) {
      auto world = make(unbounded(200));
      for (int k = -100; k < 100; ++k) add(*world, fixed(box({k + 0.5, -0.5}, 1, 1)));
      const Ride r = ride(*world, body, -90, speed, 10);
      EXPECT_LT(r.bump, 0.1) << name << " at " << speed;
      EXPECT_LT(r.height, 0.01) << name << " at " << speed;
      EXPECT_LT(r.lost, 0.01) << name << " at " << speed;
    }
  }
}

TEST(RigidChain, RollingDiscKeepsItsSpeed) {
  const Material m = material(0, 0.5);
  auto world = make(unbounded(200));
  add(*world, chain(level(kPieces, 1, false), false, m));
  BodyDesc body = moving(disc({-90, 0.5}, {}, 0.5, m), {5, 0}, -10);
  const BodyId id = add(*world, body);
  run_seconds(*world, 30);
  EXPECT_NEAR(state(*world, id).vx, 5, 1e-3);
  EXPECT_NEAR(state(*world, id).omega, -10, 2e-3);
}

TEST(RigidChain, FrictionStopsABoxAsOnOneSegment) {
  const Material m = material(0, 0.5);
  for (const double piece : {1.0, 0.17}) {
    auto world = make(unbounded(200));
    add(*world, chain(level(kPieces, piece, false), false, m));
    const BodyId id = add(*world, moving(box({-2, 0.5}, 1, 1, m), {5, 0}));
    run_seconds(*world, 3);
    EXPECT_NEAR(state(*world, id).x + 2, 2.548420, 5e-3) << piece;
    EXPECT_LT(speed_of(state(*world, id)), 1e-5) << piece;
  }
}

TEST(RigidChain, AStackStandsOnItsJoints) {
  auto world = make(unbounded(200));
  add(*world, chain(level(kPieces, 0.3, false), false, kGrip));
  std::vector<BodyId> ids;
  for (int k = 0; k < 10; ++k) ids.push_back(add(*world, box({0.05, k + 0.5}, 1, 1, kGrip)));
  run_seconds(*world, 10);
  EXPECT_NEAR(state(*world, ids.back()).y, 9.5, 0.005);
  EXPECT_NEAR(state(*world, ids.back()).x, 0.05, 2e-3);
}

TEST(RigidChain, AStackStandsOnAdjacentBoxes) {
  auto world = make(unbounded(200));
  for (int k = -20; k < 20; ++k) add(*world, fixed(box({k + 0.5, -0.5}, 1, 1, kGrip)));
  std::vector<BodyId> ids;
  for (int k = 0; k < 10; ++k) ids.push_back(add(*world, box({0.1, k + 0.5}, 1, 1, kGrip)));
  run_seconds(*world, 10);
  EXPECT_NEAR(state(*world, ids.back()).y, 9.5, 0.005);
  EXPECT_NEAR(state(*world, ids.back()).x, 0.1, 2e-3);
}

// ---- corners ----------------------------------------------------------------------------------

TEST(RigidCorner, OverAConvexEdgeABodyFliesOffFreely) {
  // Level, then down at 30 degrees: at 5 m/s it leaves the edge and falls as a free body.
  for (const auto& [name, body] : sliders({})) {
    const std::string_view kind = name;
    if (kind == "plank" || kind == "trapezium") continue;  // tip over the edge
    auto world = make(unbounded(300));
    add(*world, chain({{-50, 0}, {-20, 0}, {0, 0}, {30, -30 * std::tan(kPi / 6)}, {60, -60 * std::tan(kPi / 6)}}));
    BodyDesc b = moving(body, {8, 0});
    b.position.x = -6;
    const BodyId id = add(*world, b);
    double fastest_up = 0;
    for (int k = 0; k < 70; ++k) {
      world->step();
      fastest_up = std::max(fastest_up, state(*world, id).vy);
    }
    EXPECT_NEAR(state(*world, id).vx, 8, 0.3) << name;
    EXPECT_LT(fastest_up, 0.05) << name;
  }
}

TEST(RigidCorner, RoundAConvexBendADiscStaysOnTheWay) {
  // Slowly over a bend of 10 degrees.
  auto world = make(unbounded(300));
  const double slope = std::tan(kPi / 18);
  add(*world, chain({{-20, 0}, {0, 0}, {30, -30 * slope}}));
  const BodyId id = add(*world, disc({-2, 0.5}, {1, 0}, 0.5));
  for (int k = 0; k < 240; ++k) {
    world->step();
    const BodyState s = state(*world, id);
    const double gap = s.x < 0 ? s.y - 0.5 : (s.y + slope * s.x) * std::cos(kPi / 18) - 0.5;
    EXPECT_LT(std::abs(gap), 0.01) << "frame " << k;
  }
}

TEST(RigidCorner, IntoAConcaveBendABodyGoesUpTheSlope) {
  // Frictionless, e = 0: at a bend of phi a point keeps v cos(phi).
  for (const double phi : {0.05, 0.2, 0.5}) {
    for (const auto& [name, body] : sliders({})) {
      const std::string_view kind = name;
      if (kind != "disc" && kind != "capsule" && kind != "box") continue;
      auto world = make(unbounded(300));
      add(*world, chain({{-30, 0}, {0, 0}, {30 * std::cos(phi), 30 * std::sin(phi)}}));
      BodyDesc b = moving(body, {10, 0});
      b.position.x = -5;
      b.fixed_rotation = kind != "disc";
      const BodyId id = add(*world, b);
      const double before = energy(*world);
      double most = 0;
      for (int k = 0; k < 60; ++k) {
        world->step();
        most = std::max(most, energy(*world));
      }
      EXPECT_LT(most / before, 1.001) << name << " into " << phi;
      EXPECT_GT(most / before, 0.9) << name << " into " << phi;
      const BodyState s = state(*world, id);
      EXPECT_GT(s.x, 2) << name << " into " << phi;
      EXPECT_GT(s.y, 0.5 * s.x * std::tan(phi)) << name << " into " << phi;
      const double kept = 0.5 * (s.vx * s.vx + s.vy * s.vy) + kG * (s.y - body.position.y);
      EXPECT_NEAR(kept / (50 * std::cos(phi) * std::cos(phi)), 1, 0.03) << name << " into " << phi;
    }
  }
}

TEST(RigidCorner, ABoxRestsInAValleyAndOnARidge) {
  auto world = make(unbounded(300));
  add(*world, chain({{-20, 20}, {0, 0}, {20, 20}}, false, kGrip));
  const BodyId in = add(*world, turned(box({0, 2}, 1, 1, kGrip), 0.25 * kPi));
  run_seconds(*world, 5);
  EXPECT_NEAR(state(*world, in).y, std::sqrt(0.5), 2e-3);
  EXPECT_LT(speed_of(state(*world, in)), 1e-4);
  EXPECT_NEAR(std::remainder(state(*world, in).angle, 0.5 * kPi),
              0.25 * kPi - 0.5 * kPi * (std::remainder(state(*world, in).angle, 0.5 * kPi) < 0), 1e-3);
}

TEST(RigidCorner, InsideALoopNobodyEscapesAndOutsideNobodyEnters) {
  auto world = make(unbounded(300));
  std::vector<Vec2> loop;
  for (int k = 0; k < 24; ++k) {
    loop.push_back({8 * std::cos(2 * kPi * k / 24), 8 * std::sin(2 * kPi * k / 24)});
  }
  const Material m = material(0.2, 0.4);
  add(*world, chain(loop, true, m));
  Random random(9);
  std::vector<BodyId> inside, outside;
  for (int k = 0; k < 16; ++k) {
    const double x = k % 4 * 2.2 - 3.3, y = k / 4 * 2.2 - 3.3;
    inside.push_back(
        add(*world, turned(k % 2 ? box({x, y}, 1, 1, m) : capsule({x, y}, 0.8, 0.3, m), random.uniform(0, 6))));
    outside.push_back(add(*world, turned(box({x, 14 + y}, 0.8, 0.8, m), random.uniform(0, 6))));
  }
  run_seconds(*world, 4);  // those outside fall on
  for (const BodyId id : inside) EXPECT_LT(std::hypot(state(*world, id).x, state(*world, id).y), 8);
  for (const BodyId id : outside) EXPECT_GT(std::hypot(state(*world, id).x, state(*world, id).y), 7.9);
}

}  // namespace
}  // namespace psim::test
