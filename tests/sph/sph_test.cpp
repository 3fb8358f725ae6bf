// The reference solver of smoothed particles (bench/fluids): its sums against pairs one by one, and closed forms.
#include "sph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace psim::fluids {
namespace {

constexpr double kPi = std::numbers::pi, kGravity = 9.81;

// A disc of particles from places that are a little uneven, drawn out as by the flow (-x, y).
Flow drop(Boundary boundary, int layers) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  flow.bounds = {-3, -3, 3, 3};
  flow.boundary = boundary;
  std::mt19937 random(3);
  const auto jitter = [&] { return 0.3 * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
  for (int j = -layers; j < layers; ++j) {
    for (int i = -layers; i < layers; ++i) {
      const Vec2 p{(i + 0.5 + jitter()) / layers, (j + 0.5 + jitter()) / layers};
      if (p.x * p.x + p.y * p.y >= 1) continue;
      flow.places.push_back(p);
      flow.velocities.push_back({-p.x, p.y});
    }
  }
  return flow;
}

Flow tank(int layers) {
  Flow flow;
  flow.spacing = 1.0 / layers;
  flow.bounds = {0, 0, 1, 1.2};
  flow.gravity = {0, -kGravity};
  flow.speed = std::sqrt(kGravity);
  flow.pressure = [](Vec2 p) { return kDensity * kGravity * (1 - p.y); };
  fill(flow, {0, 0}, layers, layers);
  return flow;
}

// Density over kDensity at each particle of a box of `period`, 0 if it is none, by all pairs in doubles.
std::vector<double> densities_by_pairs(const Flow& flow, double reach, double period) {
  const double h = reach * flow.spacing / 2, scale = 7 / (4 * kPi * h * h) * flow.spacing * flow.spacing;
  std::vector<double> out;
  for (const Vec2& a : flow.places) {
    double sum = 0;
    for (const Vec2& b : flow.places) {
      double dx = a.x - b.x, dy = a.y - b.y;
      if (period > 0) dx -= period * std::round(dx / period), dy -= period * std::round(dy / period);
      const double q = std::hypot(dx, dy) / h, t = std::max(0.0, 1 - q / 2);
      sum += scale * t * t * t * t * (2 * q + 1);
    }
    out.push_back(sum);
  }
  return out;
}

TEST(Sph, SumsFindEveryNeighbour) {
  for (const double reach : {2.6, 4.0}) {
    const Flow flow = drop(Boundary::open, 12);
    const Sph sph(flow, {.reach = reach});
    std::vector<float> strains;
    sph.sum_densities(strains);
    // The solver sorts its particles: the sums of both and of their squares must be the same.
    double off = 0, square = 0;
    for (const double d : densities_by_pairs(flow, reach, 0)) off += d, square += d * d;
    for (const float s : strains)
      off -= 1.0 + static_cast<double>(s), square -= std::pow(1.0 + static_cast<double>(s), 2);
    EXPECT_NEAR(off, 0, 1e-3);
    EXPECT_NEAR(square, 0, 1e-3);
  }
}

TEST(Sph, PeriodicCopiesAreNeighbours) {
  Flow flow;
  flow.spacing = 0.05;
  flow.bounds = {0, 0, 1, 1};
  flow.boundary = Boundary::periodic;
  fill(flow, {0, 0}, 20, 20);
  for (std::size_t k = 0; k < flow.places.size(); ++k) flow.places[k].x += 0.01 * std::sin(static_cast<double>(k));
  const Sph sph(flow, {.reach = 4});
  std::vector<float> strains;
  sph.sum_densities(strains);
  double off = 0, square = 0;
  for (const double d : densities_by_pairs(flow, 4, 1)) off += d, square += d * d;
  for (const float s : strains)
    off -= 1.0 + static_cast<double>(s), square -= std::pow(1.0 + static_cast<double>(s), 2);
  EXPECT_NEAR(off, 0, 1e-3);
  EXPECT_NEAR(square, 0, 1e-3);
}

// Forces between two particles are equal and opposite, and along the line between them.
TEST(Sph, MomentumIsKept) {
  Sph sph(drop(Boundary::open, 15), {});
  const auto momentum = [&] {
    std::vector<Particle> particles;
    sph.look(particles);
    double x = 0, y = 0, spin = 0;
    for (const Particle& p : particles) {
      x += p.velocity.x, y += p.velocity.y;
      spin += p.place.x * p.velocity.y - p.place.y * p.velocity.x;
    }
    return std::vector{x, y, spin};
  };
  const auto before = momentum();
  for (int k = 0; k < 200; ++k) sph.step(sph.longest_step());
  const auto after = momentum();
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(after[k], before[k], 1e-2) << k;  // of 700 particles at 0.7 m/s
}

// p = rho g (H - y), and nothing moves.
TEST(Sph, WaterAtRestCarriesItsWeight) {
  for (const double reach : {2.6, 3.0, 4.0}) {
    Sph sph(tank(25), {.reach = reach});
    for (double t = 0; t < 1; t += sph.longest_step()) sph.step(sph.longest_step());
    std::vector<Particle> particles;
    sph.look(particles);
    double off = 0, speed = 0;
    for (const Particle& p : particles) {
      off += std::pow(p.pressure - kDensity * kGravity * (1 - p.place.y), 2);
      speed += p.velocity.x * p.velocity.x + p.velocity.y * p.velocity.y;
      EXPECT_TRUE(p.place.x > 0 && p.place.x < 1 && p.place.y > 0) << p.place.x << " " << p.place.y;
    }
    const auto count = static_cast<double>(particles.size());
    EXPECT_LT(std::sqrt(off / count) / (kDensity * kGravity), 0.04) << reach;
    EXPECT_LT(std::sqrt(speed / count / kGravity), 0.02) << reach;
  }
}

// A shear wave u = sin(2 pi y) decays as exp(-4 pi^2 nu t) (Morris, Fox and Zhu 1997 for the terms of viscosity).
TEST(Sph, ShearDecaysByViscosity) {
  Flow flow;
  flow.spacing = 1.0 / 40;
  flow.bounds = {0, 0, 1, 1};
  flow.boundary = Boundary::periodic;
  flow.viscosity = 0.05;
  fill(flow, {0, 0}, 40, 40);
  for (const Vec2& p : flow.places) flow.velocities.push_back({std::sin(2 * kPi * p.y), 0});
  Sph sph(flow, {});
  const int steps = static_cast<int>(std::ceil(0.25 / sph.longest_step()));
  for (int k = 0; k < steps; ++k) sph.step(0.25 / steps);
  std::vector<Particle> particles;
  sph.look(particles);
  double left = 0;
  for (const Particle& p : particles) left += 2 * p.velocity.x * std::sin(2 * kPi * p.place.y) / 1600;
  EXPECT_NEAR(left / std::exp(-4 * kPi * kPi * 0.05 * 0.25), 1, 0.02);
}

}  // namespace
}  // namespace psim::fluids
