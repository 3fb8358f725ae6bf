// Emitters and drains of fluids: how much flows, where it is, levels, saved states, recordings, and what is refused.
#include <cmath>

#include "fluid_tank.h"

namespace psim::test {
namespace {

// Twice the mean height of the particles is the level where they are even and at rest.
double level(const World& world) {
  const std::vector<FluidParticleState> all = drops(world);
  double sum = 0;
  for (const FluidParticleState& p : all) sum += p.position.y;
  return 2 * sum / static_cast<double>(all.size());
}

struct Steps {
  const char* name;
  std::vector<double> dt;  // in turn
};

TEST(FluidTaps, TheFlowIsLengthTimesSpeedWhateverTheStepsAre) {
  constexpr double kFine = 0.02, kLength = 0.23, kFlow = 1.37;
  for (const Steps& steps : {Steps{"60 Hz", {1.0 / 60}}, Steps{"240 Hz", {1.0 / 240}}, Steps{"long steps", {0.5}},
                             Steps{"any steps", {0.001, 0.04, 0.0137, 0.3, 0.007}}}) {
    auto world = tank(kFine, 0);
    open_tap(*world, tap({0.1, 1}, {0.1, 1 - kLength}, kFlow));
    open_drain(*world, {0.4, 0, 2, 3});
    double time = 0;
    for (std::size_t k = 0; time < 10; ++k) {
      const double dt = std::min(steps.dt[k % steps.dt.size()], 10 - time);
      if (dt < 1e-9) break;
      world->step(dt);
      time += dt;
      const double flowed = kLength * kFlow * time, row = kFine * kFine * 12;
      const double out = static_cast<double>(world->fluid_report().emitted) * kFine * kFine;
      ASSERT_NEAR(out, flowed, 0.501 * row) << steps.name << ", " << time << " s";
    }
    const FluidReport report = world->fluid_report();
    EXPECT_NEAR(static_cast<double>(report.emitted) * kFine * kFine, kLength * kFlow * 10, 1e-3 * kLength * kFlow * 10);
    EXPECT_EQ(report.emitted, report.particles + report.drained) << steps.name;
    EXPECT_EQ(report.withheld, 0u);
  }
}

TEST(FluidTaps, RowsLieAPitchApartAndFallAsTheyWould) {
  auto world = tank();
  // Ten columns of 0.05 m in 0.48 m: a row takes 10 * 0.05^2 / 0.48 m of the way. It flows to the left of the segment.
  open_tap(*world, tap({0.2, 2.5}, {0.2, 2.02}, 2));
  world->step(0.2);
  const double pitch = 10 * kPitch * kPitch / 0.48;
  const std::vector<FluidParticleState> all = drops(*world);
  ASSERT_EQ(all.size(), 80u);  // 0.4 m of the way and half a row, in rows of 0.052 m
  const double rest = 0.4 / pitch + 0.5 - std::floor(0.4 / pitch + 0.5);
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double way = (rest + 7 - static_cast<double>(k / 10)) * pitch, since = way / 2;
    EXPECT_EQ(all[k].id, k);
    EXPECT_NEAR(all[k].position.x, 0.2 + way, 1e-5);
    EXPECT_NEAR(all[k].position.y, 2.5 - (static_cast<double>(k % 10) + 0.5) * 0.048 - kG * since * since / 2, 1e-5);
    EXPECT_NEAR(all[k].velocity.x, 2, 1e-6);
    EXPECT_NEAR(all[k].velocity.y, -kG * since, 1e-6);
  }
}

TEST(FluidTaps, ANegativeSpeedFlowsToTheRight) {
  auto world = tank(kPitch, 0);
  open_tap(*world, tap({0.8, 1}, {1.2, 1}, 1));
  open_tap(*world, tap({0.8, 2}, {1.2, 2}, -1));
  world->step(0.2);
  for (const FluidParticleState& p : drops(*world)) {
    EXPECT_NEAR(p.velocity.y, p.id < 32 ? 1 : -1, 1e-6);
    EXPECT_GT(p.position.y, p.id < 32 ? 1 : 1.7);
    EXPECT_LT(p.position.y, p.id < 32 ? 1.3 : 2);
  }
  EXPECT_EQ(world->fluid_report().emitted, 64u);
}

// What a jet that falls freely does, its rows do.
TEST(FluidTaps, AJetIsAParabola) {
  auto world = tank(0.02);
  open_tap(*world, tap({0.1, 2.6}, {0.1, 2.4}, 2));
  for (int k = 0; k < 30; ++k) world->step();
  double worst = 0, sum = 0;
  int seen = 0;
  for (const FluidParticleState& p : drops(*world)) {
    const double t = (p.position.x - 0.1) / 2, column = static_cast<double>(p.id % 10) + 0.5;
    const double error = std::fabs(p.position.y - (2.6 - 0.02 * column - kG * t * t / 2));
    worst = std::max(worst, error);
    sum += error;
    ++seen;
  }
  EXPECT_EQ(seen, 500);
  EXPECT_LT(sum / seen, 0.005);  // a quarter of a spacing
  EXPECT_LT(worst, 0.03);
}

TEST(FluidTaps, ATapUnderTheSurfaceRaisesTheLevel) {
  auto world = tank(0.025);
  fill_up_to(*world, 0.8, 0.025);
  open_tap(*world, tap({1.1, 0.3}, {0.9, 0.3}, 0.5));
  for (int k = 0; k < 240; ++k) world->step();
  const FluidReport report = world->fluid_report();
  EXPECT_EQ(report.emitted, 640u);  // 0.4 m^2
  EXPECT_NEAR(level(*world), 1.0, 0.01);
  EXPECT_LT(report.density_error_mean, 0.01);
}

TEST(FluidTaps, ADrainAtAHeightHoldsTheLevel) {
  auto world = tank();
  fill_up_to(*world, 1);
  open_tap(*world, tap({0, 0.4}, {0, 0.2}, 0.5));
  open_drain(*world, {0, 1.25, 2, 3});
  for (int k = 0; k < 1200; ++k) world->step();
  const FluidReport report = world->fluid_report();
  EXPECT_EQ(report.emitted, 800u);
  EXPECT_EQ(report.particles + report.drained, 800u + 800u);
  // Water reaches up to half a spacing above the highest middle of a particle.
  EXPECT_NEAR(static_cast<double>(report.particles) * kPitch * kPitch / 2, 1.25 + kPitch / 4, 0.0125);
}

TEST(FluidTaps, OpenAndCloseInTime) {
  auto world = tank(kPitch, 0);
  EmitterDesc d = tap({0.1, 1}, {0.1, 0.8}, 1);  // 80 particles a second
  d.start = 0.5;
  d.end = 1.5;
  open_tap(*world, d);
  d.from.y = 2, d.to.y = 1.8;
  d.start = 0, d.end = kInf, d.limit = 50;
  open_tap(*world, d);
  for (int k = 0; k < 7; ++k) world->step(0.07);
  EXPECT_EQ(world->fluid_report().emitted, 40u);  // those of the second
  for (int k = 0; k < 20; ++k) world->step(0.1);
  EXPECT_EQ(world->fluid_report().emitted, 80u + 50u);
  EXPECT_EQ(world->fluid_report().withheld, 0u);
}

TEST(FluidTaps, SpeedsChangeAndTapsAndDrainsGo) {
  auto world = tank(kPitch, 0);
  const EmitterId first = open_tap(*world, tap({0.1, 1}, {0.1, 0.8}, 1));
  std::string error;
  const DrainId drain = world->add_drain({0.3, 0, 2, 3}, error);
  world->step(0.2);
  EXPECT_EQ(world->fluid_report().particles, 16u);
  EXPECT_TRUE(world->set_emitter_speed(first, 0));
  for (int k = 0; k < 10; ++k) world->step(0.1);
  EXPECT_EQ(world->fluid_report().particles, 0u);
  EXPECT_EQ(world->fluid_report().drained, 16u);
  EXPECT_TRUE(world->remove_drain(drain));
  EXPECT_FALSE(world->remove_drain(drain));
  EXPECT_TRUE(world->set_emitter_speed(first, 2));
  for (int k = 0; k < 10; ++k) world->step(0.02);
  EXPECT_EQ(world->fluid_report().particles, 32u);
  EXPECT_EQ(drops(*world)[0].id, 16u);
  EXPECT_TRUE(world->remove_emitter(first));
  EXPECT_FALSE(world->remove_emitter(first));
  EXPECT_FALSE(world->set_emitter_speed(first, 1));
  for (int k = 0; k < 10; ++k) world->step(0.1);
  EXPECT_EQ(world->fluid_report().emitted, 48u);
  EXPECT_EQ(world->fluid_report().particles, 32u);
  EXPECT_EQ(open_tap(*world, tap({0.1, 1}, {0.1, 0.8}, 1)), first + 1);
  EXPECT_EQ(world->add_drain({0, 0, 1, 1}, error), drain + 1);
}

// What a plate in front of a tap stops does not pass it.
TEST(FluidTaps, ABodyInFrontTurnsTheJet) {
  auto world = tank(0.025);
  BodyDesc plate = body_of(BodyType::static_body, {0.8, 1}, BoxShape{0.1, 2, 0});
  std::string error;
  world->add_body(plate, error);
  open_tap(*world, tap({0.1, 1.5}, {0.1, 1.3}, 2));
  for (int k = 0; k < 120; ++k) world->step();
  const std::vector<FluidParticleState> all = drops(*world);
  EXPECT_EQ(all.size(), 1280u);
  for (const FluidParticleState& p : all) EXPECT_LT(p.position.x, 0.76) << p.id;
}

// Two taps of two fluids above a basin with a drain in its floor and a body that floats.
std::unique_ptr<World> fountain(Isa isa, int threads, bool record = false) {
  auto world = tank(kPitch, kG, isa, threads);
  std::string error;
  EXPECT_EQ(world->add_fluid({0.04, 900, 0}, error), 1u) << error;
  fill_up_to(*world, 0.5);
  world->add_body(body_of(BodyType::dynamic_body, {1, 0.8}, BoxShape{0.4, 0.2, 0}), error);
  if (record) return world;
  open_tap(*world, tap({0, 2.1}, {0, 1.9}, 2));
  EmitterDesc oil = tap({2, 1.7}, {2, 1.9}, 1.5);
  oil.fluid = 1;
  open_tap(*world, oil);
  open_drain(*world, {0.9, 0, 1.1, 0.05});
  return world;
}

TEST(FluidTaps, TheBitsAreTheSameOnAllThreadsAndInstructionSets) {
  const std::vector<std::uint64_t> first = hashes(*fountain(best_isa(), 1), 60);
  for (const Isa isa : available_isas()) {
    EXPECT_EQ(hashes(*fountain(isa, 1), 60), first);
    EXPECT_EQ(hashes(*fountain(isa, 3), 60), first);
  }
}

TEST(FluidTaps, ParticlesOfTwoTapsGetTheirIdsInTurn) {
  auto world = fountain(best_isa(), 1);
  const std::size_t before = world->fluid_report().particles;
  world->step(0.1);
  std::size_t changes = 0;
  FluidId last = 0;
  for (const FluidParticleState& p : drops(*world)) {
    if (p.id < before) continue;
    changes += p.fluid != last ? 1 : 0;
    last = p.fluid;
  }
  EXPECT_EQ(changes, 1u);
  EXPECT_EQ(last, 1u);
}

TEST(FluidTaps, ASavedStateGoesOnWithTheSameBits) {
  auto world = fountain(best_isa(), 1);
  for (int k = 0; k < 37; ++k) world->step(k % 2 == 0 ? 1.0 / 60 : 1.0 / 77);
  std::vector<std::byte> state;
  world->save(state);
  std::string error;
  auto other = World::from_state(state, {.threads = 2}, error);
  ASSERT_NE(other, nullptr) << error;
  EXPECT_EQ(hashes(*other, 60), hashes(*world, 60));
  EXPECT_EQ(other->fluid_report().emitted, world->fluid_report().emitted);
  EXPECT_EQ(other->fluid_report().drained, world->fluid_report().drained);
  EXPECT_GT(other->fluid_report().drained, 0u);
  EXPECT_EQ(other->remove_emitter(1), world->remove_emitter(1));
  EXPECT_EQ(hashes(*other, 20), hashes(*world, 20));
}

TEST(FluidTaps, TheHashTellsHowFarATapIs) {
  auto world = tank(), other = tank();
  open_tap(*world, tap({0, 2.1}, {0, 1.9}, 1));
  open_tap(*other, tap({0, 2.1}, {0, 1.9}, 1));
  world->step(0.01);
  other->step(0.02);
  EXPECT_EQ(world->fluid_report().particles, 0u);
  EXPECT_NE(world->state_hash(), other->state_hash());
}

TEST(FluidTaps, RecordingsReplayThem) {
  auto world = fountain(best_isa(), 1, true);
  Recorder recorder(*world, 5);
  std::string error;
  EXPECT_EQ(recorder.add_emitter({}, error), kNoEmitter);
  const EmitterId id = recorder.add_emitter(tap({0, 2.1}, {0, 1.9}, 2), error);
  EXPECT_EQ(id, 0u) << error;
  EXPECT_EQ(recorder.add_drain({1, 0, 0, 1}, error), kNoDrain);
  const DrainId drain = recorder.add_drain({0, 0, 2, 0.1}, error);
  for (int k = 0; k < 20; ++k) recorder.step();
  EXPECT_TRUE(recorder.set_emitter_speed(id, 3));
  EXPECT_TRUE(recorder.remove_drain(drain));
  for (int k = 0; k < 20; ++k) recorder.step();
  EXPECT_TRUE(recorder.remove_emitter(id));
  for (int k = 0; k < 7; ++k) recorder.step();
  const auto replay = Replay::open(recorder.recording(), {best_isa(), 2}, error);
  ASSERT_NE(replay, nullptr) << error;
  while (replay->next()) {
  }
  EXPECT_TRUE(replay->complete());
  EXPECT_EQ(replay->differs_at(), 0u);
  EXPECT_EQ(replay->world().state_hash(), world->state_hash());
  EXPECT_GT(replay->world().fluid_report().drained, 0u);
}

TEST(FluidTaps, InAnOpenWorldTheGridBeginsAtTheFirstDrop) {
  std::vector<std::vector<FluidParticleState>> seen;
  for (const double x : {0.0, 0.75}) {
    WorldDesc desc = walled({-8, -8, 8, 8}, {0, -kG});
    desc.boundary = Boundary::open;
    auto world = make(desc);
    std::string error;
    world->add_fluid({0.0625, 1000, 0}, error);
    open_tap(*world, tap({x, 0.25}, {x, 0}, 2));
    for (int k = 0; k < 20; ++k) world->step();
    seen.push_back(drops(*world));
  }
  ASSERT_EQ(seen[0].size(), seen[1].size());
  ASSERT_GT(seen[0].size(), 20u);
  for (std::size_t k = 0; k < seen[0].size(); ++k) {
    EXPECT_NEAR(seen[1][k].position.x - seen[0][k].position.x, 0.75, 1e-6);
    EXPECT_EQ(seen[1][k].position.y, seen[0][k].position.y);
  }
}

// What finds no memory is withheld and counted, and the world goes on.
TEST(FluidTaps, WithoutMemoryATapWithholds) {
  auto world = tank();
  fill_up_to(*world, 1);
  for (int k = 0; k < 5; ++k) world->step();
  const EmitterId id = open_tap(*world, tap({0, 2.9}, {0, 2.1}, 1e6));
  world->set_max_bytes(world->memory_bytes() + 100'000);
  out_of_memory();
  const StepReport report = world->step();
  EXPECT_STREQ(report.no_room_for, "emitters");
  EXPECT_TRUE(out_of_memory());
  EXPECT_EQ(world->fluid_report().emitted, 0u);
  EXPECT_NEAR(static_cast<double>(world->fluid_report().withheld), 0.8 * 1e6 / 60 / (kPitch * kPitch), 16);
  EXPECT_EQ(world->fluid_report().particles, 800u);
  world->set_emitter_speed(id, 1);
  for (int k = 0; k < 20; ++k) EXPECT_EQ(world->step().no_room_for, nullptr);
  EXPECT_FALSE(out_of_memory());
  EXPECT_GT(world->fluid_report().emitted, 90u);
}

TEST(FluidTaps, RefuseWhatIsWrongInOneLine) {
  auto world = tank();
  std::string error;
  const auto refused = [&](const EmitterDesc& d, const char* what) {
    EXPECT_EQ(world->add_emitter(d, error), kNoEmitter);
    EXPECT_NE(error.find(what), error.npos) << error;
    EXPECT_EQ(error.find('\n'), error.npos);
  };
  const EmitterDesc good = tap({0, 1}, {0, 2}, 1);
  EmitterDesc d = good;
  d.fluid = 1;
  refused(d, "there is no such fluid");
  refused(tap({0, 1}, {0, 1}, 1), "an emitter's length");
  refused(tap({-0.1, 1}, {0, 1}, 1), "an emitter's x must be from 0 to 2, not -0.1");
  refused(tap({0, 1}, {0, 3.5}, 1), "an emitter's y must be from 0 to 3, not 3.5");
  refused(tap({0, kNan}, {0, 2}, 1), "an emitter's y");
  refused(tap({0, 1}, {0, 2}, 2e6), "an emitter's speed");
  refused(tap({0, 1}, {0, 2}, kNan), "an emitter's speed");
  d = good;
  d.start = -1;
  refused(d, "an emitter's start must be 0 or more, not -1");
  d.start = 3, d.end = 2;
  refused(d, "an emitter's end must not be before its start, 3, not 2");
  for (const Bounds& wrong : {Bounds{0, 0, 0, 1}, Bounds{0, 1, 1, 0}, Bounds{kNan, 0, 1, 1}, Bounds{0, 0, 2e9, 1}}) {
    EXPECT_EQ(world->add_drain(wrong, error), kNoDrain);
    EXPECT_EQ(error.find("a drain's"), 0u) << error;
  }
  for (std::size_t k = 0; k < kMostEmitters; ++k) EXPECT_EQ(world->add_emitter(good, error), k);
  refused(good, "a world has at most 1000 emitters");
  for (std::size_t k = 0; k < kMostDrains; ++k) EXPECT_EQ(world->add_drain({0, 0, 1, 1}, error), k);
  EXPECT_EQ(world->add_drain({0, 0, 1, 1}, error), kNoDrain);
  EXPECT_FALSE(world->set_emitter_speed(0, kNan));
  EXPECT_FALSE(world->set_emitter_speed(5000, 1));
  EXPECT_FALSE(world->remove_drain(5000));
}

}  // namespace
}  // namespace psim::test
