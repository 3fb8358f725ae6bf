// Orders of convergence: how fast errors fall with the substep, fitted over a range in which
// neither rounding nor chaos shows; and the tools that fit them.
#include <array>
#include <ostream>
#include <string>
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

/// A disc of negligible size under smooth forces.
struct Flight {
  std::vector<Field> fields;
  Vec2 x, v;
  double seconds = 0;
  Vec2 gravity{0, 0};
  double damping = 0;
};

constexpr double kFrame = 1.0 / 30;

int frames_of(const Flight& f) { return static_cast<int>(std::lround(f.seconds / kFrame)); }

/// Places after every frame.
std::vector<Vec2> course(const Flight& f, Integrator integrator, int substeps) {
  WorldDesc desc = unbounded(100, f.gravity);
  desc.dt = kFrame;
  desc.substeps = substeps;
  desc.fields = f.fields;
  desc.linear_damping = f.damping;
  desc.integrator = integrator;
  auto world = make(desc);
  const BodyId id = add(*world, disc(f.x, f.v, 0.01));
  std::vector<Vec2> places;
  for (int k = 0; k < frames_of(f); ++k) {
    world->step();
    places.push_back({state(*world, id).x, state(*world, id).y});
  }
  return places;
}

/// The same by RK4 in double precision, 200 steps a frame.
std::vector<Vec2> exact_course(const Flight& f) {
  using reference::Vec;
  const auto a = [&](Vec at, Vec u) {
    Vec sum{f.gravity.x, f.gravity.y};
    double rate = f.damping;
    for (const Field& field : f.fields) {
      if (const auto* drag = std::get_if<DragField>(&field)) {
        rate += drag->linear + drag->quadratic * std::sqrt(dot(u, u));
        continue;
      }
      const auto& well = std::get<WellField>(field);
      const Vec d = Vec{well.position.x, well.position.y} - at;
      const double r2 = dot(d, d) + well.softening * well.softening;
      sum = sum + (well.strength / std::pow(r2, 0.5 * (well.exponent + 1))) * d;
    }
    return sum - rate * u;
  };
  const int steps = 200;
  const double h = kFrame / steps;
  Vec x{f.x.x, f.x.y}, v{f.v.x, f.v.y};
  std::vector<Vec2> places;
  for (int k = 1; k <= steps * frames_of(f); ++k) {
    const Vec a1 = a(x, v), v2 = v + (h / 2) * a1;
    const Vec a2 = a(x + (h / 2) * v, v2), v3 = v + (h / 2) * a2;
    const Vec a3 = a(x + (h / 2) * v2, v3), v4 = v + h * a3;
    const Vec a4 = a(x + h * v3, v4);
    x = x + (h / 6) * (v + 2 * v2 + 2 * v3 + v4);
    v = v + (h / 6) * (a1 + 2 * a2 + 2 * a3 + a4);
    if (k % steps == 0) places.push_back({x.x, x.y});
  }
  return places;
}

/// Largest distance between two courses, m.
double apart(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    worst = std::max(worst, std::hypot(a[k].x - b[k].x, a[k].y - b[k].y));
  }
  return worst;
}

const std::vector<Field> kTwoWells = {WellField{{-3, 0}, 60, 0.5, 2, 0}, WellField{{3, 0}, 40, 0.5, 2, 0}};
const std::vector<Field> kTwoWellsAndDrag = {kTwoWells[0], kTwoWells[1], DragField{0.2, 0.05}};

struct NamedFlight {
  const char* name;
  Flight flight;
};
const NamedFlight kFlights[] = {
    // Not a whole number of turns: over one, errors of symplectic Euler cancel.
    {"KeplerOrbit", {{WellField{{0, 0}, 1000, 0, 2, 0}}, {5, 0}, {0, 17.25}, 4.2}},
    {"TwoWells", {kTwoWells, {6, 5}, {-3, 1}, 4}},
    {"TwoWellsAndDrag", {kTwoWellsAndDrag, {0, 5}, {4, 1}, 3, {1, -1}, 0.1}},
    {"ThrowWithDrag", {{DragField{0.3, 0.2}}, {0, 0}, {10, 10}, 2, {0, -kG}, 0.1}},
};

struct Method {
  Integrator integrator;
  double order;
};
constexpr Method kMethods[] = {
    {Integrator::euler, 1}, {Integrator::verlet, 2}, {Integrator::rk4, 4}, {Integrator::symplectic4, 4}};

class Order : public testing::TestWithParam<NamedFlight> {};
INSTANTIATE_TEST_SUITE_P(, Order, testing::ValuesIn(kFlights),
                         [](const auto& info) { return std::string(info.param.name); });
void PrintTo(const NamedFlight& f, std::ostream* out) { *out << f.name; }

TEST_P(Order, OfEveryIntegrator) {
  const Flight& flight = GetParam().flight;
  const auto truth = exact_course(flight);
  for (const auto& [integrator, order] : kMethods) {
    std::vector<double> h, error;
    for (const int substeps : {2, 3, 4, 6, 8}) {
      h.push_back(kFrame / substeps);
      error.push_back(apart(course(flight, integrator, substeps), truth));
    }
    // RK4 between wells is still on its way to order 4: its fifth-order loss of energy shows.
    const double slack = integrator == Integrator::rk4 ? 0.4 : 0.2;
    EXPECT_NEAR(reference::fit_order(h, error), order, slack)
        << integrator_name(integrator) << " from " << error.front() << " to " << error.back();
  }
}

TEST(OrderTools, RichardsonOfOwnRunsMeetsAnIndependentIntegrator) {
  const Flight flight{kTwoWells, {0, 4}, {2, 0}, 3};
  const Vec2 truth = exact_course(flight).back();
  std::array<double, 3> x{}, y{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 end = course(flight, Integrator::verlet, 8 << k).back();
    x[k] = end.x;
    y[k] = end.y;
  }
  EXPECT_NEAR(reference::richardson(x, 2).limit, truth.x, 1e-5);
  EXPECT_NEAR(reference::richardson(y, 2).limit, truth.y, 1e-5);
}

// ---- contacts ---------------------------------------------------------------------------------

TEST(OrderOfContacts, TheSagOfALoadedContactIsOfSecondOrder) {
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
