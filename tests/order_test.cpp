// Orders of convergence: how fast errors fall with the substep, fitted over a range in which
// neither rounding nor chaos shows; and the tools that fit them.
#include <array>
#include <vector>

#include "reference/closed_forms.h"
#include "reference/convergence.h"
#include "support.h"

namespace psim::test {
namespace {

// ---- the tools --------------------------------------------------------------------------------

TEST(Convergence, FitsTheOrderOfAPowerLaw) {
  const std::array<double, 4> h = {0.1, 0.05, 0.02, 0.01};
  for (const double order : {1.0, 2.0, 4.0}) {
    std::array<double, 4> error{};
    for (std::size_t k = 0; k < 4; ++k) error[k] = 7 * std::pow(h[k], order);
    EXPECT_NEAR(reference::fit_order(h, error), order, 1e-12);
  }
}

TEST(Convergence, RichardsonFindsLimitAndOrder) {
  const auto result = [](double h) { return 3 + 0.5 * h * h; };
  const auto seen = reference::richardson({result(0.4), result(0.2), result(0.1)}, 2);
  EXPECT_NEAR(seen.limit, 3, 1e-12);
  EXPECT_NEAR(seen.order, 2, 1e-12);
}

// ---- smooth forces ----------------------------------------------------------------------------

/// Place of a disc of negligible size after the time in the wells.
Vec2 end_in_wells(const std::vector<Field>& wells, Vec2 x, Vec2 v, int substeps, double seconds) {
  WorldDesc desc = unbounded(100, {0, 0});
  desc.substeps = substeps;
  desc.fields = wells;
  auto world = make(desc);
  const BodyId id = add(*world, disc(x, v, 0.01));
  run_seconds(*world, seconds);
  return {state(*world, id).x, state(*world, id).y};
}

/// The same by RK4 in double precision.
Vec2 exact_end_in_wells(const std::vector<Field>& wells, reference::Vec x, reference::Vec v,
                        double seconds) {
  using reference::Vec;
  const auto a = [&](Vec at) {
    Vec sum;
    for (const Field& field : wells) {
      const auto& well = std::get<WellField>(field);
      const Vec d = Vec{well.position.x, well.position.y} - at;
      const double r2 = dot(d, d) + well.softening * well.softening;
      sum = sum + (well.strength / std::pow(r2, 0.5 * (well.exponent + 1))) * d;
    }
    return sum;
  };
  const int steps = 20000;
  const double h = seconds / steps;
  for (int k = 0; k < steps; ++k) {
    const Vec a1 = a(x), v2 = v + (h / 2) * a1;
    const Vec a2 = a(x + (h / 2) * v), v3 = v + (h / 2) * a2;
    const Vec a3 = a(x + (h / 2) * v2), v4 = v + h * a3;
    const Vec a4 = a(x + h * v3);
    x = x + (h / 6) * (v + 2 * v2 + 2 * v3 + v4);
    v = v + (h / 6) * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {x.x, x.y};
}

const std::vector<Field> kTwoWells = {WellField{{-3, 0}, 60, 0.5, 2, 0},
                                      WellField{{3, 0}, 40, 0.5, 2, 0}};

TEST(Order, VerletIsOfSecondOrderOnAKeplerOrbit) {
  const reference::Orbit orbit;
  const auto v = orbit.start_velocity();
  const double seconds = std::floor(60 * orbit.period()) / 60;
  const auto truth = orbit.position(seconds);
  std::vector<double> h, error;
  for (const int substeps : {1, 2, 4, 8}) {
    const Vec2 end = end_in_wells({WellField{{0, 0}, orbit.gm, 0, 2, 0}}, {orbit.start().x, 0},
                                  {v.x, v.y}, substeps, seconds);
    h.push_back(1.0 / 60 / substeps);
    error.push_back(std::hypot(end.x - truth.x, end.y - truth.y));
  }
  EXPECT_NEAR(reference::fit_order(h, error), 2, 0.1);
}

TEST(Order, VerletIsOfSecondOrderBetweenTwoWells) {
  const Vec2 truth = exact_end_in_wells(kTwoWells, {0, 4}, {2, 0}, 3);
  std::vector<double> h, error;
  for (const int substeps : {1, 2, 4, 8}) {
    const Vec2 end = end_in_wells(kTwoWells, {0, 4}, {2, 0}, substeps, 3);
    h.push_back(1.0 / 60 / substeps);
    error.push_back(std::hypot(end.x - truth.x, end.y - truth.y));
  }
  EXPECT_NEAR(reference::fit_order(h, error), 2, 0.1);
}

TEST(Order, RichardsonOfOwnRunsMeetsAnIndependentIntegrator) {
  const Vec2 truth = exact_end_in_wells(kTwoWells, {0, 4}, {2, 0}, 3);
  std::array<double, 3> x{}, y{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 end = end_in_wells(kTwoWells, {0, 4}, {2, 0}, 4 << k, 3);
    x[k] = end.x;
    y[k] = end.y;
  }
  EXPECT_NEAR(reference::richardson(x, 2).limit, truth.x, 1e-5);
  EXPECT_NEAR(reference::richardson(y, 2).limit, truth.y, 1e-5);
}

// ---- contacts ---------------------------------------------------------------------------------

TEST(Order, TheSagOfALoadedContactIsOfSecondOrder) {
  // Its stiffness goes with 1/h^2 (docs/solver.md).
  std::vector<double> h, error;
  for (const int substeps : {2, 4, 8, 16}) {
    WorldDesc desc = unbounded();
    desc.substeps = substeps;
    auto world = make(desc);
    add(*world, static_disc({0, 0}, 0.5));
    for (int k = 1; k <= 10; ++k) add(*world, disc({0, 1.0 * k}));
    run_seconds(*world, 10);
    h.push_back(1.0 / 60 / substeps);
    error.push_back(deepest(*world));
  }
  EXPECT_NEAR(reference::fit_order(h, error), 2, 0.1);
}

}  // namespace
}  // namespace psim::test
