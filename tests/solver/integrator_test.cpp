// The four integrators of wells and drag: names, plan, invariants over long runs, contacts under
// them. Their orders of convergence: order_test.cpp.
#include <string>
#include <vector>

#include "reference/closed_forms.h"
#include "reference/convergence.h"
#include "sanitized.h"
#include "support.h"

namespace psim::test {
namespace {

/// Almost uniform gravity, but a field: every body takes substeps, and the integrator acts.
const Field kDown = WellField{{0, -1e6}, kG, 0, 0, 0};

std::string name_of(const testing::TestParamInfo<Integrator>& info) { return std::string(integrator_name(info.param)); }

class EveryIntegrator : public testing::TestWithParam<Integrator> {};
INSTANTIATE_TEST_SUITE_P(, EveryIntegrator, testing::ValuesIn(kAllIntegrators), name_of);

TEST(Integrator, NamesReadBack) {
  for (const Integrator i : kAllIntegrators) EXPECT_EQ(parse_integrator(integrator_name(i)), i);
  EXPECT_EQ(parse_integrator("verlet"), WorldDesc{}.integrator);
  EXPECT_FALSE(parse_integrator("leapfrog"));
  EXPECT_FALSE(parse_integrator(""));
}

// ---- the plan -----------------------------------------------------------------------------------

std::vector<std::uint64_t> falling_hashes(Integrator integrator, double damping) {
  WorldDesc desc = walled({0, 0, 30, 30}, {0, -kG}, material(0.3, 0.4));
  desc.linear_damping = damping;
  desc.fields.push_back(DragField{damping, 0});
  desc.integrator = integrator;
  auto world = make(desc);
  add(*world, lattice(200, {1, 1, 29, 29}, 0.5, 3, material(0.3, 0.4)));
  auto all = hashes(*world, 120);
  all.push_back(world->memory_bytes());
  return all;
}

TEST_P(EveryIntegrator, IsTheClosedFormWhereGravityIsUniform) {
  for (const double damping : {0.0, 0.3}) {
    EXPECT_EQ(falling_hashes(GetParam(), damping), falling_hashes(Integrator::verlet, damping));
  }
}

PlanEntry plan_entry(const World& world, std::string_view stage) {
  for (const PlanEntry& entry : world.plan()) {
    if (entry.stage == stage) return entry;
  }
  return {};
}

TEST_P(EveryIntegrator, IsInThePlanOnlyWhereThereAreFields) {
  const Integrator integrator = GetParam();
  WorldDesc desc = unbounded();
  desc.integrator = integrator;
  EXPECT_FALSE(plan_entry(*make(desc), "forces.integrator").needed);
  EXPECT_NE(plan_entry(*make(desc), "forces.integrator").reason.find("uniform"), std::string::npos);
  desc.fields.push_back(DragField{0, 0.1});
  const PlanEntry entry = plan_entry(*make(desc), "forces.integrator");
  EXPECT_EQ(entry.needed, integrator != Integrator::verlet);
  EXPECT_NE(entry.reason.find(integrator_name(integrator)), std::string::npos) << entry.reason;
}

// ---- smooth forces ------------------------------------------------------------------------------

struct OrbitDrift {
  double energy = 0;    // largest, relative to the first frame's
  double trend = 0;     // of the energy, relative, an orbit: slope of a straight line
  double momentum = 0;  // largest, of angular momentum
};

OrbitDrift drift_over(Integrator integrator, int substeps, int orbits) {
  const reference::Orbit orbit;
  WorldDesc desc = unbounded(100, {0, 0});
  desc.substeps = substeps;
  desc.integrator = integrator;
  desc.fields.push_back(WellField{{0, 0}, orbit.gm, 0, 2, 0});
  auto world = make(desc);
  const auto v = orbit.start_velocity();
  const BodyId id = add(*world, disc({orbit.start().x, 0}, {v.x, v.y}, 0.01));
  OrbitDrift drift;
  double first_e = 0, first_l = 0, n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  while (static_cast<double>(world->frame()) < 60 * orbits * orbit.period()) {
    const BodyState s = state(*world, id);
    const double e = orbit.energy_of({s.x, s.y}, {s.vx, s.vy}), l = s.x * s.vy - s.y * s.vx;
    if (world->frame() == 0) first_e = e, first_l = l;
    const double x = static_cast<double>(world->frame()) / 60 / orbit.period(), y = e / first_e - 1;
    drift.energy = std::max(drift.energy, std::abs(y));
    drift.momentum = std::max(drift.momentum, std::abs(l / first_l - 1));
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    world->step();
  }
  drift.trend = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return drift;
}

TEST(Integrator, SymplecticMethodsHaveNoEnergyTrend) {
  // 100 orbits. At one substep RK4 loses 4e-8 an orbit; the symplectic one of the same order has
  // ripples of 1e-7 and no slope to be seen.
  const OrbitDrift rk4 = drift_over(Integrator::rk4, 1, 100);
  const OrbitDrift symplectic4 = drift_over(Integrator::symplectic4, 1, 100);
  EXPECT_GT(rk4.trend, 1e-8);
  EXPECT_LT(std::abs(symplectic4.trend), 1e-10);
  EXPECT_LT(symplectic4.energy, 3e-7);
  EXPECT_LT(rk4.momentum, 1e-5);
  EXPECT_LT(symplectic4.momentum, 1e-9);
  EXPECT_LT(std::abs(drift_over(Integrator::verlet, 4, 100).trend), 1e-8);
}

TEST(Integrator, EnergyErrorsOfAnOrbitAreOfTheirSize) {
  EXPECT_LT(drift_over(Integrator::euler, 4, 10).energy, 1e-2);
  EXPECT_LT(drift_over(Integrator::verlet, 4, 10).energy, 2e-5);
  EXPECT_LT(drift_over(Integrator::rk4, 4, 10).energy, 2e-9);
  EXPECT_LT(drift_over(Integrator::symplectic4, 4, 10).energy, 2e-9);
}

TEST_P(EveryIntegrator, OrbitStaysTheSameAmongOthersThatChangeItsSlot) {
  const auto end = [&](bool crowd) {
    WorldDesc desc = unbounded(100, {0, 0});
    desc.integrator = GetParam();
    desc.fields.push_back(WellField{{0, 0}, 1000, 0, 2, 0});
    auto world = make(desc);
    if (crowd) {
      for (int k = 0; k < 40; ++k) {
        add(*world, disc({-90 + 4.0 * (k % 10), 60 + 5.0 * (k / 10)}, {20.0 - k, 15}, 0.1));
      }
    }
    const BodyId id = add(*world, disc({5, 0}, {0, 17.5}, 0.01));
    for (int k = 0; k < 300; ++k) {
      if (crowd && k % 50 == 10) world->remove_body(world->id_of(static_cast<std::uint32_t>(k / 5)));
      world->step();
    }
    return state(*world, id);
  };
  const BodyState alone = end(false), among = end(true);
  EXPECT_EQ(alone.x, among.x);
  EXPECT_EQ(alone.y, among.y);
  EXPECT_EQ(alone.vx, among.vx);
  EXPECT_EQ(alone.vy, among.vy);
}

TEST_P(EveryIntegrator, StrongDragStopsABodyAndNoMore) {
  for (const DragField drag : {DragField{0, 1e3}, DragField{1e4, 0.01}, DragField{1e3, 1e6}}) {
    WorldDesc desc = unbounded(100, {0, 0});
    desc.integrator = GetParam();
    desc.fields.push_back(drag);
    auto world = make(desc);
    const BodyId id = add(*world, disc({0, 0}, {50, -30}, 0.1));
    double before = std::hypot(50, 30);
    for (int k = 0; k < 60; ++k) {
      world->step();
      const BodyState s = state(*world, id);
      const double speed = std::hypot(s.vx, s.vy);
      ASSERT_LE(speed, before);
      ASSERT_GE(s.vx, -1e-5);
      ASSERT_LE(s.vy, 1e-5);
      before = speed;
    }
    EXPECT_LT(before, 0.1);
    EXPECT_LT(state(*world, id).x, 1.0);
  }
}

TEST_P(EveryIntegrator, GravityScalesAndKinematicBodiesKeepTheirMeaning) {
  WorldDesc desc = unbounded(100, {0, -1});
  desc.integrator = GetParam();
  desc.fields = {WellField{{0, -1e6}, 2, 0, 0, 0}, DragField{0, 1e-9}};
  auto world = make(desc);
  BodyDesc body = disc({0, 50}, {1, 0}, 0.1);
  body.gravity_scale = -0.5;
  const BodyId up = add(*world, body);
  body.gravity_scale = 0;
  body.position = {10, 50};
  const BodyId straight = add(*world, body);
  body.type = BodyType::kinematic_body;
  body.gravity_scale = 1;
  body.position = {20, 50};
  body.velocity = {0.3, 0.7};
  const BodyId held = add(*world, body);
  run(*world, 120);
  EXPECT_NEAR(state(*world, up).vy, 3, 1e-5);
  EXPECT_NEAR(state(*world, up).y, 53, GetParam() == Integrator::euler ? 0.01 : 1e-4);
  EXPECT_NEAR(state(*world, straight).y, 50, 1e-6);
  EXPECT_NEAR(state(*world, straight).x, 12, 1e-5);
  EXPECT_EQ(state(*world, held).vx, double{0.3f});
  EXPECT_EQ(state(*world, held).vy, double{0.7f});
  EXPECT_NEAR(state(*world, held).x, 20.6, 1e-5);
  EXPECT_NEAR(state(*world, held).y, 51.4, 1e-5);
}

TEST_P(EveryIntegrator, BodiesPutOrThrownByTheHostForgetWhatWasLost) {
  // The same place and velocity give the same course, whatever was before.
  WorldDesc desc = unbounded(100, {0, 0});
  desc.integrator = GetParam();
  desc.fields.push_back(WellField{{0, 0}, 1000, 0, 2, 0});
  auto used = make(desc), fresh = make(desc);
  const BodyId a = add(*used, disc({5, 0}, {0, 17.3}, 0.01));
  run(*used, 97);
  ASSERT_TRUE(used->set_transform(a, {6, 1}, 0));
  ASSERT_TRUE(used->set_velocity(a, {1, 12.1}, 0));
  const BodyId b = add(*fresh, disc({6, 1}, {1, 12.1}, 0.01));
  run(*used, 100);
  run(*fresh, 100);
  EXPECT_EQ(state(*used, a).x, state(*fresh, b).x);
  EXPECT_EQ(state(*used, a).vy, state(*fresh, b).vy);
}

TEST_P(EveryIntegrator, ABodyAtTheVeryCentreOfAWellStaysFinite) {
  for (const double softening : {0.0, 0.1}) {
    WorldDesc desc = unbounded(100, {0, 0});
    desc.integrator = GetParam();
    desc.fields.push_back(WellField{{0, 0}, 1000, softening, 2, 0});
    auto world = make(desc);
    add(*world, disc({0, 0}));
    add(*world, disc({1e-7, 0}, {}, 0.01));
    run(*world, 120);
    EXPECT_TRUE(all_finite(*world)) << softening;
  }
}

// ---- contacts -----------------------------------------------------------------------------------

TEST_P(EveryIntegrator, APileComesToRest) {
  for (const Material& m : {material(0), material(0, 0.5), material(0.3, 0.5)}) {
    if (kSanitized && m.restitution == 0) continue;
    WorldDesc desc = walled({0, 0, 33, 100}, {0, 0}, m);
    desc.fields.push_back(kDown);
    desc.integrator = GetParam();
    auto world = make(desc, best_isa(), 2);
    add(*world, lattice(1000, {0.5, 0.5, 32.5, 32.6}, 0.5, 0, m));
    run_seconds(*world, 20);
    const auto depths = penetrations(*world);
    EXPECT_GT(depths.size(), 1000u);
    EXPECT_LT(quantile(depths, 0.99), 0.025);
    EXPECT_LT(depths.back(), 0.05);
    EXPECT_LT(rms_speed(*world), 1e-4);
    EXPECT_TRUE(all_inside(*world));
  }
}

/// Error of the fifth apex above a floor, m; let go 1 m above it.
double apex_error(Integrator integrator, double restitution, int substeps) {
  const Material m = material(restitution);
  WorldDesc desc = unbounded(100, {0, 0});
  desc.substeps = substeps;
  desc.fields.push_back(kDown);
  desc.integrator = integrator;
  auto world = make(desc);
  add(*world, ground(m));
  const BodyId id = add(*world, disc({0, 1.5}, {}, 0.5, m));
  const reference::Bounces truth{1, restitution, kG};
  const double middle = 0.5 * (truth.time(4) + truth.time(5));
  while (static_cast<double>(world->frame()) < 60 * middle) world->step();
  const BodyState s = state(*world, id);
  return std::abs(s.y - 0.5 + s.vy * s.vy / (2 * kG) - std::pow(restitution, 10));
}

TEST_P(EveryIntegrator, ABounceHasItsClosedForm) {
  for (const double e : {1.0, 0.8}) {
    if (GetParam() != Integrator::euler) {
      EXPECT_LT(apex_error(GetParam(), e, 4), 1e-5) << e;
      continue;
    }
    std::vector<double> h, error;  // Euler's path is off by g h: so are its bounces
    for (const int substeps : {4, 8, 16, 32}) {
      h.push_back(1.0 / substeps);
      error.push_back(apex_error(GetParam(), e, substeps));
    }
    EXPECT_LT(error[0], 0.15) << e;
    EXPECT_NEAR(reference::fit_order(h, error), 1, 0.2) << e;
  }
}

TEST_P(EveryIntegrator, ADiscRestsInAWell) {
  WorldDesc desc = unbounded(100, {0, 0});
  desc.integrator = GetParam();
  desc.fields.push_back(WellField{{0, 0}, 60, 0.5, 1, 0});
  auto world = make(desc);
  add(*world, static_disc({0, 0}, 2));
  const BodyId id = add(*world, disc({3, 0}, {}, 0.5));
  run_seconds(*world, 20);
  const BodyState s = state(*world, id);
  EXPECT_NEAR(std::hypot(s.x, s.y), 2.5, 1e-2);
  EXPECT_LT(std::hypot(s.vx, s.vy), 1e-5);
}

}  // namespace
}  // namespace psim::test
