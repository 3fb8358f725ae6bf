// Bodies at rest fall asleep, and nobody can tell from what the world says: places, queries, events.
#include <psim/scene.h>

#include <set>

#include "allocation_counter.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

std::unique_ptr<World> built_in(const char* name, std::uint64_t n = 0) {
  std::string error;
  const auto scene = make_builtin(name, n, 1, error);
  if (!scene) throw std::runtime_error(error);
  auto world = build_world(*scene, {}, error);
  if (!world) throw std::runtime_error(error);
  return world;
}

std::size_t sleepers(World& world) {
  const PublishedState s = world.published();
  std::size_t n = 0;
  for (std::size_t k = 0; k < s.id.size(); ++k) {
    n += s.type[k] == BodyType::dynamic_body && !world.is_awake(world.id_of(s.id[k]));
  }
  return n;
}

/// Frames until nobody is awake, at most `most`.
int settle(World& world, int most = 3600) {
  int frames = 0;
  while (frames < most && world.step().awake != 0) ++frames;
  return frames;
}

/// Discs in a hexagonal lattice, pressed a little: close to how they come to rest.
std::unique_ptr<World> heap_of_discs(int columns, int rows, Material m, Isa isa = best_isa(), int threads = 1) {
  auto world = make(walled({0, 0, columns + 0.5, 3.0 * rows}, {0, -kG}, m), isa, threads);
  Discs discs;
  discs.m = m;
  for (int row = 0; row < rows; ++row) {
    for (int k = 0; k < columns; ++k) discs.push(0.5 + k + 0.5 * (row % 2), 0.5 + 0.8661 * row, 0.4999);
  }
  add(*world, discs);
  return world;
}

// ---- the same places with and without -----------------------------------------------------------

struct Case {
  const char* name;
  double seconds;
  std::unique_ptr<World> (*build)();
  double moved = 1e-3, fastest = 0.05;  // m, m/s: when all wake
};

const Case kCases[] = {
    {"Stack", 8, [] { return stack(10).world; }},
    {"Pyramid", 8, [] { return pyramid(8).world; }},
    {"Arch", 20, [] { return built_in("arch"); }},
    {"RoughDiscs", 12, [] { return heap_of_discs(12, 10, material(0, 0.5)); }},
    {"Incline", 6,
     [] {
       auto world = make(unbounded());
       add(*world, segment({-20, -6}, {20, 6}, kGrip));
       for (int k = 0; k < 6; ++k) {
         const double a = std::atan(0.3), x = 2.5 * k - 6;
         add(*world, turned(box({x - 0.5 * std::sin(a), 0.3 * x + 0.5 * std::cos(a)}, 1, 1, kGrip), a));
       }
       return world;
     }},
    {"Capsules", 8,
     [] {
       auto world = make(walled({0, 0, 8, 20}, {0, -kG}, kGrip));
       for (int k = 0; k < 12; ++k) {
         add(*world, capsule({2.0 + 4 * (k % 2), 0.25 + 0.5 * (k / 2)}, 2.6, 0.25, kGrip));
       }
       return world;
     }},
    {"Polygons", 12,
     [] {
       auto world = make(walled({0, 0, 9, 20}, {0, -kG}, kGrip));
       for (int k = 0; k < 40; ++k) {
         add(*world, polygon(regular(6, 0.5), {0.6 + k % 8 + 0.4 * (k / 8 % 2), 0.44 + 0.868 * (k / 8)}, kGrip));
       }
       return world;
     },
     2.5e-3, 0.1},  // some hexagons stand as they would not by themselves (docs/sleeping.md)
    {"OverlapRecovery", 8, [] { return built_in("overlap_recovery"); }},
    {"HighMassRatio", 8, [] { return built_in("high_mass_ratio_3"); }},
    {"Bridge", 50,
     [] {
       WorldDesc desc = unbounded();
       desc.linear_damping = 4;
       auto world = make(desc);
       BodyId last = add(*world, static_disc({0, 0}, 0.1));
       const BodyId end = add(*world, static_disc({9.5, 0}, 0.1));
       std::string error;
       for (int k = 0; k < 11; ++k) {
         JointDesc pin;
         pin.type = JointType::revolute;
         pin.a = last;
         pin.anchor_a = {k == 0 ? 0.0 : 0.5, 0};
         pin.anchor_b = {-0.5, 0};
         pin.b = last = k == 10 ? end : add(*world, box({0.5 + 0.95 * k, 0}, 1, 0.2, kGrip));
         if (k == 10) pin.anchor_b = {};
         EXPECT_NE(world->add_joint(pin, error), kNoJoint) << error;
       }
       return world;
     }},
};

std::string name_of(const testing::TestParamInfo<Case>& info) { return info.param.name; }
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Sleep : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Sleep, testing::ValuesIn(kCases), name_of);

TEST_P(Sleep, ChangesNoPlaceAndNoEnergyOfAScene) {
  auto with = GetParam().build(), without = GetParam().build();
  with->set_sleeping(true);
  without->set_sleeping(false);
  run_seconds(*with, GetParam().seconds);
  run_seconds(*without, GetParam().seconds);
  EXPECT_EQ(with->step().awake, 0u);
  EXPECT_GT(without->step().awake, 0u);
  const PublishedState a = with->published(), b = without->published();
  ASSERT_EQ(a.id.size(), b.id.size());
  double most = 0;
  for (std::size_t k = 0; k < a.id.size(); ++k) {
    most = std::max(most, std::hypot(a.x[k] - b.x[k], a.y[k] - b.y[k]));
  }
  EXPECT_LT(most, 1e-3);
  EXPECT_NEAR(energy(*with), energy(*without), 0.01 * std::abs(energy(*without)));
}

TEST_P(Sleep, StaysWhereItIsWhenAllWake) {
  auto world = GetParam().build();
  world->set_sleeping(true);
  run_seconds(*world, GetParam().seconds);
  const PublishedState s = world->published();
  const std::vector<double> x(s.x.begin(), s.x.end()), y(s.y.begin(), s.y.end());
  world->set_sleeping(false);
  EXPECT_EQ(sleepers(*world), 0u);
  double moved = 0, fastest = 0;
  for (int frame = 0; frame < 120; ++frame) {
    world->step();
    const PublishedState now = world->published();
    for (std::size_t k = 0; k < x.size(); ++k) {
      moved = std::max(moved, std::hypot(now.x[k] - x[k], now.y[k] - y[k]));
      fastest = std::max(fastest, std::hypot(now.vx[k], now.vy[k]));
    }
  }
  EXPECT_LT(moved, GetParam().moved);
  EXPECT_LT(fastest, GetParam().fastest);
}

TEST_P(Sleep, CostsNothingOnceAllSleep) {
  auto world = GetParam().build();
  world->set_sleeping(true);
  run_seconds(*world, GetParam().seconds);
  const std::uint64_t hash = world->state_hash();
  for (int k = 0; k < 60; ++k) {
    const StepReport report = world->step();
    EXPECT_EQ(report.awake, 0u);
    EXPECT_EQ(report.asleep, world->dynamic_count());
    EXPECT_EQ(report.contacts, 0u);
    EXPECT_EQ(report.pairs, 0u);
    EXPECT_EQ(report.arena_growths, 0u);
    EXPECT_FALSE(report.rebuilt);
  }
  EXPECT_EQ(world->state_hash(), hash);
}

// ---- who must not -------------------------------------------------------------------------------

TEST(SleepNever, TakesTheMomentumOfASlowGas) {
  auto world = gas_in_period(200, 0.3, material(1), 1e-4);
  const Diagnostics before = world->diagnostics();
  for (int k = 0; k < 1200; ++k) ASSERT_EQ(world->step().asleep, 0u) << "frame " << k;
  const Diagnostics after = world->diagnostics();
  const double scale = 200 * 0.785 * 1e-4;
  EXPECT_NEAR(after.momentum_x, before.momentum_x, 1e-4 * scale);
  EXPECT_NEAR(after.momentum_y, before.momentum_y, 1e-4 * scale);
  EXPECT_NEAR(after.kinetic, before.kinetic, 0.01 * before.kinetic);
}

TEST(SleepNever, StopsABallAtTheApexOfItsFlight) {
  auto world = make(unbounded(100, {0, -0.01}));
  const BodyId ball = add(*world, disc({0, 0}, {0, 0.05}));
  while (state(*world, ball).vy > -0.05) {
    world->step();
    ASSERT_TRUE(world->is_awake(ball)) << world->why_awake(ball);
  }
}

TEST(SleepNever, StopsAPendulumAtItsApex) {
  for (const double angle : {0.02, 0.3, 1.5}) {
    auto world = make(unbounded());
    const BodyId peg = add(*world, static_disc({0, 0}, 0.1));
    const BodyId bob = add(*world, disc({5 * std::sin(angle), -5 * std::cos(angle)}));
    JointDesc rod;
    rod.a = peg;
    rod.b = bob;
    std::string error;
    ASSERT_NE(world->add_joint(rod, error), kNoJoint) << error;
    for (int k = 0; k < 1200; ++k) {
      world->step();
      ASSERT_TRUE(world->is_awake(bob)) << angle << ", frame " << k;
    }
  }
}

TEST(SleepNever, StopsADiscThatRollsSlowly) {
  for (const double mu : {0.0, 0.5}) {
    auto world = make(unbounded(100));
    add(*world, ground(material(0, mu)));
    BodyDesc body = disc({0, 0.5}, {0.002, 0}, 0.5, material(0, mu));
    body.angular_velocity = -0.004;
    const BodyId ball = add(*world, body);
    run_seconds(*world, 60);
    EXPECT_TRUE(world->is_awake(ball));
    EXPECT_NEAR(state(*world, ball).x, 0.12, 0.002) << mu;
  }
}

TEST(SleepNever, TakesABodyThatIsPushedBeforeItRestsLongEnough) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  const BodyId one = add(*world, box({0, 0.5}, 1, 1, kGrip));
  for (int k = 0; k < 600; ++k) {
    if (k % 20 == 0) world->apply_impulse(one, {k % 40 == 0 ? 0.2 : -0.2, 0});
    world->step();
    ASSERT_TRUE(world->is_awake(one));
  }
}

// ---- what the world says ------------------------------------------------------------------------

TEST(SleepSays, WhyABodyIsAwake) {
  const auto says = [](const World& world, BodyId id, const char* what) {
    EXPECT_NE(world.why_awake(id).find(what), std::string::npos) << world.why_awake(id) << " / " << what;
  };
  auto world = make(unbounded());
  const BodyId floor = add(*world, ground(kGrip));
  const BodyId rests = add(*world, box({0, 0.5}, 1, 1, kGrip));
  const BodyId falls = add(*world, disc({10, 80}));
  const BodyId held = add(*world, kinematic(box({20, 5}, 1, 1, kGrip)));
  const BodyId under = add(*world, moving(disc({30, 0.5}, {}, 0.5), {0.5, 0}));
  world->step();
  says(*world, floor, "static");
  says(*world, held, "kinematic");
  world->set_sleeping(false);
  says(*world, rests, "off");
  world->set_sleeping(true);
  run(*world, 24);
  says(*world, rests, "has rested for");
  says(*world, falls, "it moves");
  run(*world, 60);
  says(*world, rests, "it sleeps");
  EXPECT_FALSE(world->is_awake(rests));
  says(*world, under, "it moves");
  says(*world, BodyId{77, 0}, "no such");
  world->set_velocity(falls, {kNan, 0}, 0);
  world->step();
  says(*world, falls, "frozen");
}

TEST(SleepSays, WhoKeepsABodyAwake) {
  auto world = make(unbounded());
  add(*world, ground(kGrip));
  const BodyId box_1 = add(*world, box({0, 0.5}, 4, 1, kGrip, 100));
  const BodyId top = add(*world, disc({0, 1.3}, {}, 0.3));
  std::string said;
  for (int k = 0; k < 120; ++k) {
    world->set_velocity(top, {0.05 * std::cos(0.2 * k), 0},
                        0);  // it slides to and fro without friction
    world->step();
    said = world->why_awake(box_1);
    ASSERT_TRUE(world->is_awake(box_1));
  }
  EXPECT_NE(said.find("touches body " + std::to_string(top.index)), std::string::npos) << said;
}

TEST(SleepSays, TheSamePlacesInEveryWay) {
  auto world = heap_of_discs(8, 6, material(0, 0.5));
  world->enable_snapshots(true);
  EXPECT_LT(settle(*world), 3600);
  world->step();
  const BodyId id = world->id_of(20);
  const BodyState s = state(*world, id);
  EXPECT_EQ(s.vx, 0);
  EXPECT_EQ(s.omega, 0);
  EXPECT_EQ(s.radius, double{float(0.4999)});
  const PublishedState p = world->published();
  ASSERT_EQ(p.id.size(), 48u);
  EXPECT_EQ(p.x[20], s.x);
  EXPECT_EQ(p.y[20], s.y);
  EXPECT_EQ(p.angle[20], s.angle);
  const Snapshot* shot = world->latest_snapshot();
  ASSERT_NE(shot, nullptr);
  ASSERT_EQ(shot->id.size(), 48u);
  EXPECT_EQ(shot->asleep[20], 1);
  EXPECT_NEAR(static_cast<double>(shot->x[20]) + shot->origin.x, s.x, 1e-5);
  EXPECT_EQ(shot->x[20], shot->x_prev[20]);
  const auto ray = world->ray_cast({s.x, s.y}, {s.x + 0.1, s.y});
  ASSERT_TRUE(ray.has_value());
  EXPECT_EQ(ray->body, id);
  EXPECT_EQ(world->ray_cast_all({0.01, s.y}, {8.4, s.y}).size(), 8u);
  const auto near = world->closest({s.x, s.y}, 1);
  ASSERT_TRUE(near.has_value());
  EXPECT_EQ(near->body, id);
  EXPECT_EQ(world->overlap(DiscShape{0.1}, {s.x, s.y}, 0), std::vector<BodyId>{id});
  EXPECT_EQ(world->in_region({-1, -1, 100, 100}).size(), 48u);
}

TEST(SleepSays, NothingNewAboutContactsAndSensors) {
  for (const bool shapes : {false, true}) {
    auto world = make(unbounded());
    add(*world, ground(kGrip));
    std::vector<BodyId> ids;
    for (int k = 0; k < 4; ++k) {
      BodyDesc body = shapes ? box({0, k + 0.5}, 1, 1, kGrip, 1) : disc({0, 0.999 * k + 0.5}, {}, 0.5, kGrip);
      body.fixed_rotation = true;
      ids.push_back(add(*world, body));
    }
    BodyDesc eye = static_disc({0, 0}, 1);
    eye.sensor = true;
    const BodyId sensor = add(*world, eye);
    world->set_event_options({true, false, 1, true});
    std::set<std::pair<std::uint32_t, std::uint32_t>> touching;
    std::size_t told = 0;
    const auto follow = [&](int frames) {
      for (int f = 0; f < frames; ++f) {
        world->step();
        const Events e = world->events();
        told += e.begin.size() + e.end.size() + e.sensor_begin.size() + e.sensor_end.size();
        for (const TouchEvent& t : e.begin) EXPECT_TRUE(touching.insert({t.a.index, t.b.index}).second);
        for (const TouchEvent& t : e.end) EXPECT_EQ(touching.erase({t.a.index, t.b.index}), 1u);
      }
    };
    follow(60);
    EXPECT_GE(touching.size(), 4u);
    EXPECT_GE(told, 5u);
    told = 0;
    follow(200);
    EXPECT_EQ(sleepers(*world), 4u) << world->why_awake(ids[0]);
    world->wake(ids[1]);
    follow(200);
    EXPECT_EQ(told, 0u);
    EXPECT_EQ(sleepers(*world), 4u);
    world->remove_body(ids[0]);
    world->step();
    std::size_t ended = 0;
    for (const TouchEvent& t : world->events().end) ended += t.a == ids[0] || t.b == ids[0];
    EXPECT_EQ(ended, 2u);
    ASSERT_EQ(world->events().sensor_end.size(), 1u);
    EXPECT_EQ(world->events().sensor_end[0].a, sensor);
  }
}

// ---- memory -------------------------------------------------------------------------------------

TEST(SleepMemory, IsAskedForOnce) {
  auto world = heap_of_discs(30, 20, material(0, 0.5));
  for (int k = 0; k < 20; ++k) add(*world, box({0.8 + 1.3 * k, 20.5}, 1, 1, kGrip));
  std::size_t bytes = 0;
  for (int cycle = 0; cycle < 50; ++cycle) {
    const std::uint64_t before = allocations();
    world->set_gravity({cycle % 2 == 0 ? 1e-3 : 0, -kG});
    EXPECT_LT(settle(*world), 3600) << cycle;
    if (cycle == 9) bytes = world->memory_bytes();
    if (cycle > 9) {
      EXPECT_EQ(allocations() - before, 0u) << cycle;
    }
  }
  EXPECT_EQ(world->memory_bytes(), bytes);
}

}  // namespace
}  // namespace psim::test
