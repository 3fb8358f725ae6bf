// Fluids in worlds: what the host adds and is told, steps, hashes, saved states and recordings.
#include <limits>

#include "base/rotor.h"
#include "saved_support.h"

namespace psim::test {
namespace {

constexpr double kSpacing = 0.05;

std::vector<Vec2> block(Vec2 corner, int columns, int rows, double spacing = kSpacing) {
  std::vector<Vec2> places;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) places.push_back(corner + Vec2{(i + 0.5) * spacing, (j + 0.5) * spacing});
  }
  return places;
}

FluidId add_fluid(World& world, double spacing = kSpacing, double density = 1000) {
  std::string error;
  const FluidId id = world.add_fluid({spacing, density, 0}, error);
  EXPECT_EQ(error, "");
  return id;
}

void fill(World& world, FluidId fluid, const std::vector<Vec2>& places, const std::vector<Vec2>& velocities = {}) {
  std::string error;
  EXPECT_TRUE(world.add_particles(fluid, places, velocities, error)) << error;
}

std::vector<FluidParticleState> particles(const World& world) {
  std::vector<FluidParticleState> all;
  world.fluid_particles(all);
  return all;
}

// A dam that breaks beside a disc that falls.
std::unique_ptr<World> dam(Isa isa = best_isa(), int threads = 1) {
  auto world = make(walled({0, 0, 4, 3}), isa, threads);
  add(*world, disc({3, 2}, {}, 0.2));
  fill(*world, add_fluid(*world), block({0, 0}, 20, 40));
  return world;
}

std::unique_ptr<World> drop(Vec2 at) {
  auto world = make(unbounded(64, {0, 0}));
  std::vector<Vec2> velocities;
  const std::vector<Vec2> places = block(at, 16, 16, 0.0625);
  for (const Vec2& p : places) velocities.push_back({at.x - p.x, p.y - at.y});
  fill(*world, add_fluid(*world, 0.0625), places, velocities);
  return world;
}

TEST(WorldFluids, TellWhatWasAddedBeforeTheFirstStep) {
  auto world = make(walled({0, 0, 4, 3}));
  EXPECT_EQ(world->fluid_report().particles, 0u);
  EXPECT_TRUE(particles(*world).empty());
  const FluidId water = add_fluid(*world), oil = add_fluid(*world, 0.04, 800);
  EXPECT_EQ(water, 0u);
  EXPECT_EQ(oil, 1u);
  fill(*world, water, {{1, 1}, {2, 1}}, {{0.5, 0}, {0, -0.25}});
  fill(*world, oil, {{3, 2}});
  const auto all = particles(*world);
  ASSERT_EQ(all.size(), 3u);
  for (std::uint32_t k = 0; k < 3; ++k) EXPECT_EQ(all[k].id, k);
  EXPECT_NEAR(all[1].position.x, 2, 1e-6);
  EXPECT_EQ(all[1].velocity, (Vec2{0, -0.25}));
  EXPECT_EQ(all[2].fluid, oil);
  EXPECT_EQ(all[2].density, 800);
  EXPECT_EQ(all[0].pressure, 0);
  const double mass = 1000 * kSpacing * kSpacing;
  EXPECT_NEAR(world->fluid_report().kinetic, 0.5 * mass * (0.25 + 0.0625), 1e-12);
}

TEST(WorldFluids, MoveInAWorldWithoutBodies) {
  auto world = make(walled({0, 0, 4, 3}));
  fill(*world, add_fluid(*world), block({1, 1}, 10, 10));
  const double before = particles(*world)[0].position.y;
  run(*world, 10);
  EXPECT_EQ(world->frame(), 10u);
  EXPECT_NEAR(before - particles(*world)[0].position.y, 0.5 * kG / 36, 0.02);
  EXPECT_EQ(world->fluid_report().particles, 100u);
  EXPECT_GT(world->step().stage_ms[static_cast<std::size_t>(Stage::fluid)], 0);
}

TEST(WorldFluids, RestWithThePressureOfTheirWeight) {
  auto world = make(walled({0, 0, 1, 2}));
  world->set_sleeping(false);
  fill(*world, add_fluid(*world), block({0, 0}, 20, 20));
  run(*world, 60);
  for (const FluidParticleState& p : particles(*world)) {
    EXPECT_NEAR(p.pressure, 1000 * kG * (1 - p.position.y), 100);
    EXPECT_NEAR(p.density, 1000, 10);
  }
  const FluidReport report = world->fluid_report();
  EXPECT_LT(report.density_error_mean, 1e-3);
  EXPECT_GT(report.iterations, 0u);
}

TEST(WorldFluids, HaveTheSameBitsOnEveryIsaAndAnyNumberOfThreads) {
  auto first = dam(Isa::scalar, 1);
  const std::vector<std::uint64_t> expected = hashes(*first, 40);
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = dam(isa, threads);
      EXPECT_EQ(hashes(*world, 40), expected) << isa_name(isa) << " " << threads;
    }
  }
}

TEST(WorldFluids, TheHashCoversPlaceAndVelocityOfEachParticle) {
  const auto hash = [](const std::vector<Vec2>& places, const std::vector<Vec2>& velocities) {
    auto world = make(walled({0, 0, 4, 3}));
    fill(*world, add_fluid(*world), places, velocities);
    return world->state_hash();
  };
  const std::uint64_t plain = hash({{1, 1}, {2, 1}}, {});
  EXPECT_EQ(hash({{1, 1}, {2, 1}}, {{-0.0, 0}, {0, 0}}), plain);
  EXPECT_NE(hash({{1, 1}, {2, 1.0001}}, {}), plain);
  EXPECT_NE(hash({{2, 1}, {1, 1}}, {}), plain);
  EXPECT_NE(hash({{1, 1}, {2, 1}}, {{0, 0}, {0, 1e-6}}), plain);
  auto empty = make(walled({0, 0, 4, 3}));
  const std::uint64_t none = empty->state_hash();
  add_fluid(*empty);
  EXPECT_EQ(empty->state_hash(), none);
}

TEST(WorldFluids, AnOpenWorldMovedByItsGridKeepsItsBits) {
  auto here = drop({0, 0}), there = drop({-16, 8});
  run(*here, 20);
  run(*there, 20);
  const auto a = particles(*here), b = particles(*there);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].velocity, b[k].velocity);
    EXPECT_EQ(a[k].pressure, b[k].pressure);
  }
}

TEST(WorldFluids, ParticlesThatLeaveAnOpenWorldAreGone) {
  auto world = make(unbounded(8));
  fill(*world, add_fluid(*world), block({-1, -7.5}, 8, 8));
  fill(*world, 0, block({-1, 7}, 8, 8), std::vector<Vec2>(64, {0, 3}));
  run(*world, 45);
  EXPECT_EQ(world->fluid_report().particles, 64u);
  for (const FluidParticleState& p : particles(*world)) EXPECT_GE(p.id, 64u);
  expect_resumes(*world, 10, "some are gone");
  run(*world, 200);
  EXPECT_EQ(world->fluid_report().particles, 0u);
  expect_resumes(*world, 10, "all are gone");
}

TEST(WorldFluids, ResumeFromASavedState) {
  auto world = dam();
  expect_resumes(*world, 10, "before the first step");
  run(*world, 30);
  expect_resumes(*world, 10, "in the midst of it");
  fill(*world, add_fluid(*world, 0.04, 800), block({1, 2}, 10, 10, 0.04));
  expect_resumes(*world, 10, "with particles since the last step");
  auto free = drop({1, 2});
  run(*free, 5);
  expect_resumes(*free, 10, "in an open world");
  WorldDesc desc = periodic(2, 2);
  auto flow = make(desc);
  fill(*flow, add_fluid(*flow), block({0, 0}, 40, 40), std::vector<Vec2>(1600, {1, 0.5}));
  run(*flow, 5);
  expect_resumes(*flow, 10, "in a periodic world");
}

TEST(WorldFluids, WhatIsReadOutComesBackWithASavedState) {
  auto world = dam();
  run(*world, 20);
  Bytes state;
  world->save(state);
  const auto before = particles(*world);
  const FluidReport report = world->fluid_report();
  run(*world, 20);
  std::string error;
  ASSERT_TRUE(world->restore(state, error)) << error;
  const auto after = particles(*world);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_EQ(after[k].position, before[k].position);
    EXPECT_EQ(after[k].density, before[k].density);
    EXPECT_EQ(after[k].pressure, before[k].pressure);
  }
  EXPECT_EQ(world->fluid_report().density_error_max, report.density_error_max);
  EXPECT_EQ(world->fluid_report().iterations, report.iterations);
}

TEST(WorldFluids, AStateWithoutFluidsTakesThemAway) {
  auto world = make(walled({0, 0, 4, 3}));
  add(*world, disc({3, 2}, {}, 0.2));
  Bytes state;
  world->save(state);
  fill(*world, add_fluid(*world), block({0, 0}, 10, 10));
  run(*world, 3);
  std::string error;
  ASSERT_TRUE(world->restore(state, error)) << error;
  EXPECT_EQ(world->fluid_report().particles, 0u);
  EXPECT_EQ(add_fluid(*world, 0.1), 0u);
}

TEST(WorldFluids, PrepareChangesNothing) {
  auto world = dam(), prepared = dam();
  prepared->prepare();
  EXPECT_EQ(hashes(*prepared, 10), hashes(*world, 10));
  auto changed = dam(), plain = dam();
  changed->prepare();
  for (World* w : {changed.get(), plain.get()}) fill(*w, 0, block({2, 1}, 5, 5));
  EXPECT_EQ(hashes(*changed, 10), hashes(*plain, 10));
}

TEST(WorldFluids, RecordingsReplayThem) {
  auto world = make(walled({0, 0, 4, 3}));
  Recorder recorder(*world, 5);
  std::string error;
  EXPECT_EQ(recorder.add_fluid({0, 1000, 0}, error), kNoFluid);
  EXPECT_EQ(recorder.add_fluid({kSpacing, 1000, 0}, error), 0u) << error;
  EXPECT_EQ(recorder.add_fluid({kSpacing, 500, 0}, error), 1u) << error;
  EXPECT_TRUE(recorder.add_particles(0, block({0, 0}, 10, 20), {}, error)) << error;
  EXPECT_FALSE(recorder.add_particles(7, block({0, 0}, 10, 20), {}, error));
  for (int k = 0; k < 12; ++k) {
    recorder.step();
    if (k == 6) {
      EXPECT_TRUE(recorder.add_particles(1, block({2, 1}, 4, 4), std::vector<Vec2>(16, {-1, 0}), error)) << error;
    }
  }
  const auto replay = Replay::open(recorder.recording(), {best_isa(), 2}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_TRUE(replay->complete());
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_EQ(replay->world().fluid_report().particles, 216u);
  EXPECT_EQ(replay->world().state_hash(), world->state_hash());
}

TEST(WorldFluids, RefuseWhatIsWrongInOneLine) {
  auto world = make(walled({0, 0, 4, 3}));
  std::string error;
  const auto refused = [&](const FluidDesc& d, const char* what) {
    EXPECT_EQ(world->add_fluid(d, error), kNoFluid);
    EXPECT_NE(error.find(what), error.npos) << error;
    EXPECT_EQ(error.find('\n'), error.npos);
  };
  for (const double wrong : {0.0, -1.0, kNan, kInf, 1e-4, 2e3}) refused({wrong, 1000, 0}, "spacing must be from 0.001");
  refused({1e-3, kNan, 0}, "density");
  refused({0.1, 0, 0}, "density");
  refused({0.1, 1000, -1}, "viscosity");
  refused({5, 1000, 0}, "in a world of these bounds");
  const std::vector<Vec2> one = {{1, 1}}, none;
  EXPECT_FALSE(world->add_particles(0, one, none, error));
  EXPECT_EQ(error, "there is no such fluid");
  add_fluid(*world);
  refused({0.06, 1000, 0}, "at most that of the first fluid, 0.05 m, not 0.06");
  EXPECT_FALSE(world->add_particles(1, one, none, error));
  for (const Vec2 wrong : {Vec2{-0.1, 1}, Vec2{1, 3.1}, Vec2{kNan, 1}, Vec2{1, kInf}}) {
    EXPECT_FALSE(world->add_particles(0, std::vector<Vec2>{{1, 1}, wrong}, none, error));
    EXPECT_EQ(error.find("a particle's"), 0u) << error;
  }
  EXPECT_FALSE(world->add_particles(0, one, std::vector<Vec2>{{kNan, 0}}, error));
  EXPECT_FALSE(world->add_particles(0, one, std::vector<Vec2>{{1, 0}, {1, 0}}, error));
  EXPECT_EQ(error, "there are 2 velocities for 1 particles: one each, or none");
  EXPECT_EQ(world->fluid_report().particles, 0u);
  EXPECT_TRUE(world->add_particles(0, none, none, error)) << error;
  // Nothing is read of places that are too many.
  EXPECT_FALSE(world->add_particles(0, {one.data(), kMostParticles + 1}, none, error));
  EXPECT_EQ(error, "a world has at most 10000000 particles, not 10000001");
}

TEST(WorldFluids, ABudgetOfMemoryLeavesTheWorldAsItWas) {
  auto world = dam();
  run(*world, 3);
  const std::uint64_t hash = world->state_hash();
  world->set_max_bytes(1);
  std::string error;
  out_of_memory();
  EXPECT_FALSE(world->add_particles(0, block({1, 0}, 60, 60), {}, error));
  EXPECT_TRUE(out_of_memory());
  EXPECT_EQ(error.find("no room for the particles"), 0u) << error;
  EXPECT_EQ(world->state_hash(), hash);
  world->set_max_bytes(0);
  fill(*world, 0, block({1, 0}, 60, 60));
  run(*world, 3);
  EXPECT_EQ(world->fluid_report().particles, 4400u);
}

TEST(WorldFluids, ThePlanNamesThem) {
  const auto entry = [](const World& world) {
    for (const PlanEntry& e : world.plan()) {
      if (e.stage == "fluid") return e;
    }
    return PlanEntry{};
  };
  auto world = dam();
  run(*world, 2);
  EXPECT_TRUE(entry(*world).needed);
  EXPECT_GT(entry(*world).bytes, 800 * sizeof(float) * 12);
  EXPECT_FALSE(entry(*make(walled({0, 0, 4, 3}))).needed);
}

}  // namespace
}  // namespace psim::test
