// A periodic world has no places: what happens across the seam is what happens in the middle.
#include "support.h"

namespace psim::test {
namespace {

constexpr double kSide = 32;

double wrapped(double v) { return v - kSide * std::floor(v / kSide); }

struct Outcome {
  double vx_a, vy_a, omega_a, vx_b, vy_b, omega_b;
  double dx, dy;
};

/// Two discs that hit, with everything moved by (sx, sy).
Outcome hit(double sx, double sy, Material m, Isa isa) {
  auto world = make(periodic(kSide, kSide), isa);
  const BodyId a = add(*world, disc({wrapped(15 + sx), wrapped(16 + sy)}, {3, 0.5}, 0.5, m));
  const BodyId b = add(*world, disc({wrapped(17 + sx), wrapped(16.25 + sy)}, {-2, 0.25}, 0.75, m));
  run(*world, 60);
  const BodyState sa = state(*world, a), sb = state(*world, b);
  return {sa.vx,
          sa.vy,
          sa.omega,
          sb.vx,
          sb.vy,
          sb.omega,
          reference::nearest_image(sb.x - sa.x, kSide),
          reference::nearest_image(sb.y - sa.y, kSide)};
}

TEST(Periodic, APairAcrossTheSeamIsAPairInTheMiddle) {
  for (const Isa isa : available_isas()) {
    for (const Material m : {material(1), material(0.5, 0.3), material(0)}) {
      const Outcome middle = hit(0, 0, m, isa);
      EXPECT_NE(middle.vx_a, 3);
      for (const Vec2 shift : {Vec2{16, 0}, Vec2{0, 16}, Vec2{16, 16}, Vec2{15.5, -15.75}}) {
        const Outcome seam = hit(shift.x, shift.y, m, isa);
        SCOPED_TRACE(testing::Message() << isa_name(isa) << " e " << m.restitution << " shift " << shift.x << " "
                                        << shift.y);
        EXPECT_NEAR(seam.vx_a, middle.vx_a, 1e-5);
        EXPECT_NEAR(seam.vy_a, middle.vy_a, 1e-5);
        EXPECT_NEAR(seam.omega_a, middle.omega_a, 1e-5);
        EXPECT_NEAR(seam.vx_b, middle.vx_b, 1e-5);
        EXPECT_NEAR(seam.vy_b, middle.vy_b, 1e-5);
        EXPECT_NEAR(seam.omega_b, middle.omega_b, 1e-5);
        EXPECT_NEAR(seam.dx, middle.dx, 1e-5);
        EXPECT_NEAR(seam.dy, middle.dy, 1e-5);
      }
    }
  }
}

TEST(Periodic, AShiftedGasStaysTheShiftedGas) {
  // Half a second, before chaos makes visible in which order contacts were taken.
  const Discs discs = lattice(200, {0, 0, kSide, kSide}, 0.5, 3, material(1), 0.5, 5);
  for (const Vec2 shift : {Vec2{16, 16}, Vec2{0.5, 7.25}}) {
    Discs moved = discs;
    for (double& v : moved.x) v = wrapped(v + shift.x);
    for (double& v : moved.y) v = wrapped(v + shift.y);
    auto world = make(periodic(kSide, kSide));
    add(*world, moved);
    auto fresh = make(periodic(kSide, kSide));
    add(*fresh, discs);
    run(*world, 20);
    run(*fresh, 20);
    const PublishedState a = fresh->published(), b = world->published();
    for (std::size_t k = 0; k < discs.size(); ++k) {
      ASSERT_NEAR(reference::nearest_image(b.x[k] - a.x[k] - shift.x, kSide), 0, 1e-3) << k;
      ASSERT_NEAR(reference::nearest_image(b.y[k] - a.y[k] - shift.y, kSide), 0, 1e-3) << k;
    }
  }
}

TEST(Periodic, PositionsStayInsideTheBounds) {
  WorldDesc desc = periodic(20, 10);
  desc.bounds = {-30, 5, -10, 15};
  auto world = make(desc);
  add(*world, disc({-20, 10}, {7, -11}));
  add(*world, disc({-15, 8}, {-3, 4}));
  for (int k = 0; k < 600; ++k) {
    world->step();
    ASSERT_TRUE(all_inside(*world)) << "frame " << k;
  }
  EXPECT_EQ(world->body_count(), 2u);
}

TEST(Periodic, FlightRoundTheWorldIsExact) {
  WorldDesc desc = periodic(32, 32);
  desc.dt = 1.0 / 64;
  auto world = make(desc);
  const BodyId id = add(*world, disc({1, 2}, {4, -3}));
  run(*world, 64 * 32);  // 128 and 96 m: whole laps
  EXPECT_EQ(reference::nearest_image(state(*world, id).x - 1, 32), 0);
  EXPECT_EQ(reference::nearest_image(state(*world, id).y - 2, 32), 0);
}

TEST(Periodic, ALatticeOnTheSeamIsAtRest) {
  // Touching discs that fill the world, rows on both seams: nobody may be pushed by a copy.
  auto world = make(periodic(16, 16));
  Discs discs;
  for (int j = 0; j < 16; ++j) {
    for (int i = 0; i < 16; ++i) discs.push(i, j, 0.5);
  }
  add(*world, discs);
  run(*world, 120);
  EXPECT_LT(rms_speed(*world), 1e-4);
  EXPECT_LT(deepest(*world), 1e-3);
}

TEST(Periodic, ADiscDoesNotCollideWithItself) {
  auto world = make(periodic(4, 4));
  const BodyId id = add(*world, disc({0.1, 0.1}, {1, 0}, 1.5));
  run(*world, 300);
  EXPECT_NEAR(state(*world, id).vx, 1, 1e-6);
  EXPECT_NEAR(state(*world, id).vy, 0, 1e-6);
}

TEST(Periodic, SmallWorldsSeeEveryNeighbourOnce) {
  // Two discs in a world barely wider than both: each is the other's neighbour on both sides.
  auto world = make(periodic(4, 4));
  const BodyId a = add(*world, disc({1, 2}, {1, 0}, 0.8, material(1)));
  const BodyId b = add(*world, disc({3, 2}, {-1, 0}, 0.8, material(1)));
  const double start = world->diagnostics().kinetic;
  run(*world, 600);
  EXPECT_NEAR(world->diagnostics().kinetic / start, 1, 1e-4);
  EXPECT_NEAR(state(*world, a).vx + state(*world, b).vx, 0, 1e-5);
  EXPECT_LT(deepest(*world), 0.01);
}

}  // namespace
}  // namespace psim::test
