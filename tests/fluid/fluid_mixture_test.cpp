// Fluids of several densities against closed forms: layers at rest, layers that turn over, a drop that sinks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/lattice.h"
#include "fluid/fluids.h"
#include "support.h"

namespace psim::test {
namespace {

constexpr double kWaveNumber = 2 * std::numbers::pi, kMixtureFrame = 1.0 / 60;

// Two fluids in a tank that begins at (0, 0): number 0 has 1000 kg/m^2, number 1 `ratio` times as much.
struct Tank {
  Tank(double wide, double high, double spacing, double ratio, Isa isa = Isa::avx2, int threads = 1)
      : table(kernels_of(isa)), pool(threads) {
    fluids.begin(fluid_space({0, 0, wide, high}, Boundary::walls, 2 * spacing, {}));
    fluids.add_kind({spacing, 1000, 0});
    fluids.add_kind({spacing, 1000 * ratio, 0});
  }
  void run(int frames) {
    for (int k = 0; k < frames; ++k) {
      fluids.step(kMixtureFrame, {0, -9.81}, nullptr);
      most_iterations = std::max(most_iterations, fluids.counts().iterations);
    }
  }
  std::vector<FluidParticleState> look() const {
    std::vector<FluidParticleState> seen;
    fluids.look(seen);
    std::ranges::sort(seen, {}, &FluidParticleState::id);
    return seen;
  }
  // J, by the particles' heights and speeds.
  double energy(double spacing, double ratio) const {
    double sum = fluids.counts().kinetic;
    for (const FluidParticleState& p : look()) {
      sum += (p.fluid == 1 ? ratio : 1) * 1000 * spacing * spacing * 9.81 * p.position.y;
    }
    return sum;
  }

  MemoryMeter meter;
  kernels::KernelTable table;
  WorkerPool pool;
  Fluids fluids{meter, table, pool};
  std::uint32_t most_iterations = 0;
};

// Fills a tank of 1 x 2 m, fluid 1 above. Where the fluids meet is moved by `amplitude` cos(k x), and what is around as
// in a wave without curl.
void add_layers(Tank& tank, double spacing, double amplitude) {
  const int n = static_cast<int>(std::lround(1 / spacing));
  for (int j = 0; j < 2 * n; ++j) {
    for (int i = 0; i < n; ++i) {
      const double x = (i + 0.5) * spacing, y = (j + 0.5) * spacing, above = y - 1, k = kWaveNumber;
      const double scale = amplitude / std::sinh(k), depth = k * (1 - std::fabs(above));
      const double up = scale * std::cos(k * x) * std::sinh(depth), side = scale * std::sin(k * x) * std::cosh(depth);
      tank.fluids.add(above > 0 ? 1 : 0, {above > 0 ? x + side : x - side, y + up}, {});
    }
  }
}

// By how much of cos(k x) the lower edge of fluid 1, which reaches up to the lid, is moved.
double amplitude_of(const Tank& tank, double spacing) {
  double sum = 0;
  for (const FluidParticleState& p : tank.look()) {
    if (p.fluid == 1) sum -= 2 * spacing * spacing * std::cos(kWaveNumber * p.position.x);
  }
  return sum;
}

std::vector<FluidParticleState> turned_over(Isa isa, int threads) {
  Tank tank(1, 2, 0.04, 3, isa, threads);
  add_layers(tank, 0.04, 0.02);
  tank.run(60);
  return tank.look();
}

TEST(FluidMixture, SameBitsOnEveryIsaAndAnyThreads) {
  const auto reference = turned_over(Isa::scalar, 1);
  ASSERT_EQ(reference.size(), 1250u);
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(isa) << " " << threads);
      const auto seen = turned_over(isa, threads);
      ASSERT_EQ(seen.size(), reference.size());
      for (std::size_t k = 0; k < seen.size(); ++k) {
        ASSERT_EQ(seen[k].position, reference[k].position) << k;
        ASSERT_EQ(seen[k].velocity, reference[k].velocity) << k;
        ASSERT_EQ(seen[k].pressure, reference[k].pressure) << k;
      }
    }
  }
}

// Oil over water: the pressure is the weight of what lies above.
TEST(FluidMixture, TwoLayersAtRestCarryTheirWeight) {
  constexpr double kSpacing = 0.02, kOil = 0.8, kBottom = 9810 * 0.5 * (1 + kOil);
  Tank tank(1, 2, kSpacing, kOil);
  for (int j = 0; j < 50; ++j) {
    for (int i = 0; i < 50; ++i) tank.fluids.add(j < 25 ? 0 : 1, {(i + 0.5) * kSpacing, (j + 0.5) * kSpacing}, {});
  }
  tank.run(600);
  double error = 0, highest = 0, lowest = 1;
  for (const FluidParticleState& p : tank.look()) {
    const double y = p.position.y;
    const double weight = 9810 * (y < 0.5 ? 0.5 - y + kOil * 0.5 : kOil * std::max(0.0, 1 - y));
    error += (p.pressure - weight) * (p.pressure - weight);
    if (p.fluid == 0) highest = std::max(highest, y);
    if (p.fluid == 1) lowest = std::min(lowest, y);
  }
  EXPECT_LT(std::sqrt(error / 2500) / kBottom, 2e-3);
  EXPECT_LT(highest, lowest);
  const double mass = 500 * (1 + kOil);
  EXPECT_LT(std::sqrt(2 * tank.fluids.counts().kinetic / mass), 1e-3 * std::sqrt(9.81));
}

// A layer of three times the density above a lighter one, in a tank that is full to its lid: what moves the edge between
// them grows as cosh(sqrt(A g k) t), A = 1/2 (Rayleigh, Taylor).
TEST(FluidMixture, AHeavyLayerTurnsOverALightOne) {
  constexpr double kSpacing = 0.01, kRate = 5.55149;
  Tank tank(1, 2, kSpacing, 3);
  add_layers(tank, kSpacing, 0.001);
  const double energy = tank.energy(kSpacing, 3);
  tank.run(30);
  const double first = amplitude_of(tank, kSpacing);
  tank.run(12);
  const double second = amplitude_of(tank, kSpacing);
  EXPECT_NEAR(std::log(second / first) / 0.2, kRate, 0.05 * kRate);
  EXPECT_LT(second, 0.05);  // small beside the wave's length
  EXPECT_LT(tank.energy(kSpacing, 3), energy);
  EXPECT_LT(tank.most_iterations, 20u);
}

// A disc of twice the density falls by g (2 - 1) / (2 + 1): it moves as much water as itself.
TEST(FluidMixture, AHeavyDropSinks) {
  constexpr double kSpacing = 0.01;
  Tank tank(2, 2, kSpacing, 2);
  for (int j = 0; j < 200; ++j) {
    for (int i = 0; i < 200; ++i) {
      const double x = (i + 0.5) * kSpacing, y = (j + 0.5) * kSpacing;
      tank.fluids.add((x - 1) * (x - 1) + (y - 1) * (y - 1) < 0.04 ? 1 : 0, {x, y}, {});
    }
  }
  tank.run(6);
  double speed = 0, count = 0;
  for (const FluidParticleState& p : tank.look()) {
    if (p.fluid != 1) continue;
    speed += p.velocity.y;
    ++count;
  }
  EXPECT_NEAR(speed / count, -9.81 / 3 * 0.1, 0.1 * 9.81 / 3 * 0.1);
}

TEST(FluidMixture, EveryDensityStaysFinite) {
  for (const double ratio : {100.0, 0.01, 1e6, 1e-12}) {
    Tank tank(1, 2, 0.02, ratio);
    add_layers(tank, 0.02, 0.005);
    const double before = tank.energy(0.02, ratio);
    tank.run(90);
    for (const FluidParticleState& p : tank.look()) {
      ASSERT_TRUE(std::isfinite(p.pressure) && std::isfinite(p.velocity.x) && std::isfinite(p.velocity.y));
      // A displacement may take a particle beyond a wall, from where the next step brings it back.
      ASSERT_TRUE(p.position.x > -0.04 && p.position.x < 1.04 && p.position.y > -0.04 && p.position.y < 2.04);
    }
    if (ratio < 1e3) {
      EXPECT_LT(tank.energy(0.02, ratio), before * 1.001) << ratio;
    }
    EXPECT_LT(tank.most_iterations, 60u) << ratio;
  }
}

// Without a surface nothing can be brought closer together: what the density is off by on the mean has to be left.
TEST(FluidMixture, ATankFullToItsLidStaysAtRest) {
  Tank tank(1, 1, 0.02, 1);
  for (int j = 0; j < 50; ++j) {
    for (int i = 0; i < 50; ++i) tank.fluids.add(0, {(i + 0.5) * 0.02, (j + 0.5) * 0.02}, {});
  }
  tank.run(240);
  EXPECT_LT(std::sqrt(2 * tank.fluids.counts().kinetic / 1000), 1e-3 * std::sqrt(9.81));
  for (const FluidParticleState& p : tank.look()) {
    EXPECT_NEAR(p.position.x, (p.id % 50 + 0.5) * 0.02, 0.01);
    EXPECT_NEAR(p.position.y, (p.id / 50 + 0.5) * 0.02, 0.01);
  }
}

}  // namespace
}  // namespace psim::test
