// Surface tension against closed forms: Laplace's pressure in drops, and how they swing (Rayleigh 1879, in two dimensions).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "fluid/fluids.h"
#include "support.h"

namespace psim::test {
namespace {

constexpr double kDropFrame = 1.0 / 60, kDropDensity = 1000;

// Drops in a tank of 4 x 4 m without gravity.
struct DropTank {
  explicit DropTank(double spacing, double tension, Isa isa = Isa::avx2, int threads = 1)
      : pitch(spacing), table(kernels_of(isa)), pool(threads) {
    fluids.begin(fluid_space({0, 0, 4, 4}, Boundary::walls, 2 * spacing, {}));
    fluids.add_kind({spacing, kDropDensity, 0, tension});
  }
  // Fills what lies where `inside(x, y)`, with particles of this fluid.
  template <class Inside>
  void fill(const Inside& inside, std::uint32_t fluid = 0) {
    const int n = static_cast<int>(std::lround(4 / pitch));
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const double x = (i + 0.5) * pitch, y = (j + 0.5) * pitch;
        if (inside(x, y)) fluids.add(fluid, {x, y}, {});
      }
    }
  }
  // A drop whose radius is r (1 + share cos 2 phi).
  void add_drop(double x0, double y0, double r, double share = 0, std::uint32_t fluid = 0) {
    fill(
        [&](double x, double y) {
          const double dx = x - x0, dy = y - y0, square = dx * dx + dy * dy;
          const double edge = square > 0 ? r * (1 + share * (dx * dx - dy * dy) / square) : r;
          return square < edge * edge;
        },
        fluid);
  }
  void run(int frames) {
    for (int k = 0; k < frames; ++k) fluids.step(kDropFrame, {}, nullptr);
  }
  std::vector<FluidParticleState> look() const {
    std::vector<FluidParticleState> seen;
    fluids.look(seen);
    return seen;
  }
  // Mean pressure within `r` of a place.
  double pressure(Vec2 at, double r) const {
    double sum = 0;
    int n = 0;
    for (const FluidParticleState& p : look()) {
      const Vec2 d = p.position - at;
      if (d.x * d.x + d.y * d.y > r * r) continue;
      sum += p.pressure;
      ++n;
    }
    return sum / n;
  }
  Vec2 middle() const {
    Vec2 sum;
    const std::vector<FluidParticleState> seen = look();
    for (const FluidParticleState& p : seen) sum = sum + p.position;
    return (1.0 / static_cast<double>(seen.size())) * sum;
  }
  // By how much all is wider than it is high: the ratio of the second moments' roots, less 1.
  double wider() const {
    const Vec2 m = middle();
    double xx = 0, yy = 0;
    for (const FluidParticleState& p : look()) {
      xx += (p.position.x - m.x) * (p.position.x - m.x);
      yy += (p.position.y - m.y) * (p.position.y - m.y);
    }
    return std::sqrt(xx / yy) - 1;
  }
  double away_from(Vec2 place) const {
    const Vec2 d = middle() - place;
    return std::sqrt(d.x * d.x + d.y * d.y);
  }
  double rms_speed() const {
    return std::sqrt(2 * fluids.counts().kinetic / (kDropDensity * pitch * pitch * static_cast<double>(fluids.size())));
  }

  double pitch;
  MemoryMeter meter;
  kernels::KernelTable table;
  WorkerPool pool;
  Fluids fluids{meter, table, pool};
};

TEST(FluidTension, PressureInADropIsTensionByRadius) {
  for (const double radius : {0.25, 0.5, 1.0}) {
    DropTank tank(0.02, 100);
    tank.add_drop(2, 2, radius);
    double sum = 0;
    for (int k = 0; k < 8; ++k) {
      tank.run(20);
      sum += tank.pressure({2, 2}, 0.5 * radius) / 8;
    }
    EXPECT_NEAR(sum, 100 / radius, 0.04 * 100 / radius) << radius;
    // Surfaces of particles are rough, so that a drop is never quite at rest.
    EXPECT_LT(tank.rms_speed(), 0.1 * std::sqrt(100 / (kDropDensity * radius))) << radius;
    EXPECT_LT(tank.away_from({2, 2}), 0.02) << radius;
  }
}

// T sqrt(tension / (density r^3)) = 2 pi / sqrt(6).
TEST(FluidTension, ADropSwingsWithItsPeriod) {
  constexpr double kRadius = 0.5, kTension = 100;
  DropTank tank(0.02, kTension);
  tank.add_drop(2, 2, kRadius, 0.05);
  std::vector<double> zeros;
  double before = tank.wider(), largest = 0;
  EXPECT_NEAR(before, 0.1, 0.01);
  for (int k = 1; k <= 320; ++k) {
    tank.run(1);
    const double now = tank.wider();
    if ((before > 0) != (now > 0)) zeros.push_back(k - now / (now - before));
    if (k > 130) largest = std::max(largest, std::fabs(now));
    before = now;
  }
  ASSERT_EQ(zeros.size(), 4u);
  const double period = (zeros[3] - zeros[0]) / 1.5 * kDropFrame;
  const double exact =
      2 * std::numbers::pi / std::sqrt(6.0) * std::sqrt(kDropDensity * kRadius * kRadius * kRadius / kTension);
  EXPECT_NEAR(period, exact, 0.02 * exact);
  EXPECT_NEAR(largest, 0.1, 0.015);
}

TEST(FluidTension, ASquareBecomesRound) {
  DropTank tank(0.02, 100);
  tank.fill([](double x, double y) { return std::fabs(x - 2) < 0.4 && std::fabs(y - 2) < 0.2; });
  EXPECT_GT(tank.wider(), 0.9);
  double sum = 0;
  for (int k = 0; k < 600; ++k) {
    tank.run(1);
    sum += tank.wider() / 600;
  }
  EXPECT_LT(std::fabs(sum), 0.15);  // it swings about a circle
}

// At a wall the surface stands at a right angle: half a drop on the floor stays one.
TEST(FluidTension, HalfADropOnAWallStays) {
  DropTank tank(0.02, 100);
  tank.add_drop(2, 0, 0.5);
  double sum = 0;
  for (int k = 0; k < 240; ++k) {
    tank.run(1);
    sum += tank.wider() / 240;
  }
  EXPECT_NEAR(sum, std::sqrt(0.25 / (0.25 - 16 / (9 * std::numbers::pi * std::numbers::pi))) - 1, 0.1);
  EXPECT_NEAR(tank.pressure({2, 0}, 0.25), 200, 12);
}

TEST(FluidTension, EachFluidHasItsOwn) {
  DropTank tank(0.02, 100);
  tank.fluids.add_kind({0.02, kDropDensity, 0, 25});
  tank.add_drop(1, 2, 0.5, 0, 0);
  tank.add_drop(3, 2, 0.5, 0, 1);
  tank.run(60);
  EXPECT_NEAR(tank.pressure({1, 2}, 0.25), 200, 12);
  EXPECT_NEAR(tank.pressure({3, 2}, 0.25), 50, 5);
}

TEST(FluidTension, NoneIsTooStrong) {
  for (const double tension : {1e4, 1e6}) {
    for (const Vec2 middle : {Vec2{2, 2}, Vec2{2.01, 2}, Vec2{2.02, 2.03}}) {
      DropTank tank(0.02, tension);
      tank.add_drop(middle.x, middle.y, 0.3, 0.1);
      tank.run(240);
      EXPECT_LT(tank.away_from(middle), 0.3) << tension << " at " << middle.x << ", " << middle.y;
      EXPECT_LT(tank.rms_speed(), 1) << tension << " at " << middle.x << ", " << middle.y;
    }
  }
}

TEST(FluidTension, SameBits) {
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      DropTank tank(0.02, 100, isa, threads);
      tank.fluids.add_kind({0.02, 500, 0.01, 25});
      tank.add_drop(1.7, 2, 0.4, 0.1, 0);
      tank.add_drop(2.6, 2, 0.3, 0.1, 1);
      tank.run(20);
      hashes.push_back(tank.fluids.hash(0));
    }
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

}  // namespace
}  // namespace psim::test
