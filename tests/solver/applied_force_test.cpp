// Forces and torques for one step.
#include <cmath>
#include <string>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"
#include "saved_support.h"

namespace psim::test {
namespace {

constexpr int kSecond = 60;

// v = F t / m and x = F t^2 / 2m beside gravity, whether a body is free or takes substeps.
TEST(AppliedForce, AcceleratesByTheMass) {
  for (const int substeps : {1, 4, 8}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      Random r(seed);
      WorldDesc desc = unbounded(1000);
      desc.substeps = substeps;
      desc.gravity = {0, r.chance(0.5) ? -kG : 0};
      desc.linear_damping = 0;
      auto world = make(desc);
      BodyDesc body = body_of_any_shape(r, {0, 0});
      body.shape = r.chance(0.5) ? Shape{DiscShape{0.4}} : Shape{BoxShape{0.5, 0.8}};
      const BodyId id = add(*world, body);
      if (r.chance(0.5)) {  // another body beside it, as fast: it takes substeps
        BodyDesc other = body;
        other.position = {0.85, 0};
        add(*world, other);
      }
      const Vec2 force{r.uniform(-50, 50), r.uniform(-50, 50)};
      const Vec2 a{force.x / body.mass, desc.gravity.y + force.y / body.mass};
      const BodyId all[] = {id, world->id_of(1)};
      for (int k = 0; k < kSecond; ++k) {
        for (const BodyId each : all) {
          if (each == kNoBody) continue;
          ASSERT_TRUE(world->apply_force(each, {force.x / 2, force.y}));
          ASSERT_TRUE(world->apply_force(each, {force.x / 2, 0}));
        }
        world->step();
      }
      const BodyState s = state(*world, id);
      const double size = std::hypot(a.x, a.y) + 1e-3;
      EXPECT_NEAR(s.vx, a.x, 2e-6 * size) << seed << " " << substeps;
      EXPECT_NEAR(s.vy, a.y, 2e-6 * size) << seed << " " << substeps;
      EXPECT_NEAR(s.x, a.x / 2, 1e-5 * size) << seed << " " << substeps;
      EXPECT_NEAR(s.y, a.y / 2, 1e-5 * size) << seed << " " << substeps;
      world->step();
      EXPECT_NEAR(state(*world, id).vx, s.vx, 1e-12) << "the force lasts one step";
    }
  }
}

// With damping c: v = F / (m c) (1 - exp(-c t)).
TEST(AppliedForce, MeetsDamping) {
  WorldDesc desc = unbounded(1000);
  desc.gravity = {};
  desc.linear_damping = 2;
  for (const Integrator integrator : kAllIntegrators) {
    for (const double well : {0.0, 1e-12}) {  // with a well the integrator moves the bodies
      desc.integrator = integrator;
      desc.fields.clear();
      if (well != 0) desc.fields.push_back(WellField{.position = {0, 500}, .strength = well});
      auto world = make(desc);
      const BodyId id = add(*world, disc({}, {}, 0.4));
      const double mass = world->traits(id).value().mass;
      for (int k = 0; k < 2 * kSecond; ++k) {
        ASSERT_TRUE(world->apply_force(id, {6 * mass, 0}));
        world->step();
      }
      const double v = 3 * (1 - std::exp(-4.0)), x = 3 * (2 - (1 - std::exp(-4.0)) / 2);
      // In a field the push and the fade take turns, and Euler's method is of first order.
      const double within = well == 0 ? 1e-5 : integrator == Integrator::euler ? 1e-2 : 5e-3;
      EXPECT_NEAR(state(*world, id).vx, v, within * v) << static_cast<int>(integrator) << " " << well;
      EXPECT_NEAR(state(*world, id).x, x, within * x) << static_cast<int>(integrator) << " " << well;
    }
  }
}

TEST(AppliedForce, TurnsByTheInertia) {
  for (const bool beside : {false, true}) {
    for (const int substeps : {1, 4}) {
      WorldDesc desc = unbounded(1000);
      desc.substeps = substeps;
      auto world = make(desc);
      const BodyId id = add(*world, box({0, 0}, 2, 1, {}, 3));
      if (beside) add(*world, box({0, 1.01}, 2, 1, {}, 3));
      const double inertia = 3.0 * (4 + 1) / 12;
      for (int k = 0; k < kSecond / 2; ++k) {
        ASSERT_TRUE(world->apply_torque(id, 0.05 * inertia));
        if (beside) world->apply_torque(world->id_of(1), 0.05 * inertia);
        world->step();
      }
      EXPECT_NEAR(state(*world, id).omega, 0.025, 1e-6) << beside << substeps;
      EXPECT_NEAR(state(*world, id).angle, 0.05 / 8, 0.05 / 8 * (beside ? 2.0 / (30 * substeps) : 1e-4))
          << beside << substeps;
    }
  }
}

// At a point it is a force at the centre and a torque about it, in periodic worlds at the nearest copy of the point.
TEST(AppliedForce, AtAPointPushesAndTurns) {
  for (const bool wraps : {false, true}) {
    WorldDesc desc = unbounded(100);
    if (wraps) desc.boundary = Boundary::periodic;
    auto at = make(desc), apart = make(desc);
    Random r(3);
    for (int k = 0; k < 12; ++k) {
      const BodyDesc body = body_of_any_shape(r, {-80.0 + 14 * k, r.uniform(-50, 50)});
      const Vec2 arm{r.uniform(-1, 1), r.uniform(-1, 1)}, force{r.uniform(-9, 9), r.uniform(-9, 9)};
      const BodyId id = add(*at, body);
      ASSERT_EQ(id, add(*apart, body));
      const Vec2 origin{body.position.x, body.position.y};
      const bool whole = std::holds_alternative<CompoundShape>(body.shape);
      if (whole) continue;  // its centre of mass lies elsewhere
      const Vec2 point{origin.x + arm.x + (wraps ? 200 : 0), origin.y + arm.y};
      ASSERT_TRUE(at->apply_force_at(id, force, point));
      ASSERT_TRUE(apart->apply_force(id, force));
      ASSERT_TRUE(apart->apply_torque(id, arm.x * force.y - arm.y * force.x));
    }
    at->step();
    apart->step();
    for (std::uint32_t k = 0; k < 12; ++k) {
      const BodyState a = state(*at, at->id_of(k)), b = state(*apart, apart->id_of(k));
      EXPECT_NEAR(a.vx, b.vx, 1e-9) << k;
      EXPECT_NEAR(a.omega, b.omega, 1e-6 * (1 + std::abs(b.omega))) << k;
    }
  }
}

// What floats is held by a force as by a floor; a force below the friction of a block does not move it, one above does.
TEST(AppliedForce, ActsThroughTheWholeStep) {
  for (const int substeps : {1, 4, 8}) {
    WorldDesc desc = unbounded(200);
    desc.substeps = substeps;
    auto world = make(desc);
    add(*world, ground(material(0, 0.5)));
    const BodyId rests = add(*world, box({-20, 0.5}, 1, 1, material(0, 0.5), 2));
    const BodyId slides = add(*world, box({0, 0.5}, 1, 1, material(0, 0.5), 2));
    const BodyId floats = add(*world, box({20, 5}, 1, 1, {}, 2));
    for (int k = 0; k < kSecond; ++k) world->step();  // the blocks come to rest
    const double rested = state(*world, rests).x, slid = state(*world, slides).x;
    const double height = state(*world, floats).y;
    ASSERT_TRUE(world->set_velocity(floats, {0, 0}, 0));
    ASSERT_TRUE(world->set_transform(floats, {20, 5}, 0));
    for (int k = 0; k < kSecond; ++k) {
      ASSERT_TRUE(world->apply_force(rests, {0.9 * 0.5 * 2 * kG, 0}));
      ASSERT_TRUE(world->apply_force(slides, {1.5 * 0.5 * 2 * kG, 0}));
      ASSERT_TRUE(world->apply_force(floats, {0, 2 * kG}));
      world->step();
    }
    EXPECT_LT(height, 5);
    // What a force does before the contact answers it shrinks with the substep.
    EXPECT_NEAR(state(*world, rests).x, rested, 6e-3 / substeps) << substeps;
    EXPECT_NEAR(state(*world, slides).x - slid, 0.25 * kG / 2, (0.01 + 0.03 / substeps) * 0.25 * kG / 2) << substeps;
    EXPECT_NEAR(state(*world, floats).y, 5, 1e-4) << substeps;
  }
}

// A heap under gravity is the same heap if each body is pushed by its weight instead, while it falls and when it lies.
TEST(AppliedForce, ItsWeightIsGravity) {
  WorldDesc with = walled({-6, 0, 6, 40}, {0, -kG}, kGrip), without = with;
  without.gravity = {};
  without.sleeping = with.sleeping = false;
  auto falls = make(with), pushed = make(without);
  Random r(8);
  std::vector<double> masses;
  for (int k = 0; k < 40; ++k) {
    BodyDesc body = disc({-5 + 1.2 * (k % 9), 1.0 + 1.2 * (k / 9)}, {}, 0.4);
    body.mass = r.uniform(0.5, 2);
    masses.push_back(body.mass);
    add(*falls, body);
    add(*pushed, body);
  }
  for (int frame = 0; frame < 300; ++frame) {
    for (std::uint32_t k = 0; k < 40; ++k) {
      ASSERT_TRUE(pushed->apply_force(pushed->id_of(k), {0, -kG * masses[k]}));
    }
    falls->step();
    pushed->step();
    const double within = frame < 20 ? 1e-4 : 1;
    for (std::uint32_t k = 0; frame < 20 && k < 40; ++k) {
      EXPECT_NEAR(state(*falls, falls->id_of(k)).y, state(*pushed, pushed->id_of(k)).y, within) << k;
    }
  }
  double energy[2] = {};
  for (std::uint32_t k = 0; k < 40; ++k) {
    energy[0] += masses[k] * state(*falls, falls->id_of(k)).y;
    energy[1] += masses[k] * state(*pushed, pushed->id_of(k)).y;
  }
  EXPECT_NEAR(energy[0], energy[1], 0.05 * energy[0]);
  EXPECT_LT(pushed->diagnostics().kinetic, 0.05);
}

// However hard a body is pushed, it stays on its side of a wall, and the numbers stay numbers.
TEST(AppliedForce, GreatForcesPassNoWall) {
  for (const double force : {1e3, 1e6, 1e12, 1e30}) {
    for (const bool square : {false, true}) {
      WorldDesc desc = walled({-10, 0, 10, 20}, {0, -kG});
      auto world = make(desc);
      add(*world, segment({5, 0}, {5, 20}));
      const BodyId id = add(*world, square ? box({0, 5}) : disc({0, 5}));
      for (int k = 0; k < kSecond; ++k) {
        ASSERT_TRUE(world->apply_force_at(id, {force, 0}, {0, 5.1}));
        world->step();
        const BodyState s = state(*world, id);
        ASSERT_TRUE(std::isfinite(s.x) && std::isfinite(s.vx) && std::isfinite(s.omega)) << force;
        ASSERT_LT(s.x, 5.5) << force << " " << square << " " << k;
      }
    }
  }
}

// The same bits on every instruction set and any number of threads, in saved states and in recordings.
TEST(AppliedForce, SameBitsEverywhere) {
  std::uint64_t want = 0;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      auto world = make(walled({-10, 0, 10, 40}, {0, -kG}, kGrip), isa, threads);
      Random r(5);
      for (int k = 0; k < 150; ++k) add(*world, body_of_any_shape(r, {-9.0 + 1.5 * (k % 13), 1 + 1.5 * (k / 13)}));
      std::string error;
      Recorder recorder(*world, 1);
      for (int frame = 0; frame < 90; ++frame) {
        for (int k = 0; k < 10; ++k) {
          const BodyId id = world->id_of(static_cast<std::uint32_t>(r.below(150)));
          const Vec2 force{r.uniform(-300, 300), r.uniform(-300, 300)};
          recorder.apply_force(id, force);
          recorder.apply_force_at(id, force, {r.uniform(-9, 9), r.uniform(0, 20)});
          recorder.apply_torque(id, r.uniform(-50, 50));
        }
        if (frame % 30 == 10) {
          ASSERT_TRUE(recorder.explode({{r.uniform(-9, 9), 3}, 1, 4, 3, ~0u}).value_or(0) > 0);
        }
        if (frame == 30) recorder.set_fields({WellField{{3, 9}, 20, 0.5}, DragField{0.1, 0.02}}, error);
        if (frame == 60) recorder.set_fields({}, error);
        EXPECT_EQ(world->desc().fields.size(), frame >= 30 && frame < 60 ? 2u : 0u) << error;
        if (frame % 20 == 13) {
          std::vector<std::byte> waiting;
          world->save(waiting);
          auto copy = World::from_state(waiting, RunOptions{}, error);
          ASSERT_TRUE(copy) << error;
          expect_resumes(*copy, 3, "with forces that wait");
        }
        recorder.step();
      }
      if (want == 0) want = world->state_hash();
      EXPECT_EQ(world->state_hash(), want) << static_cast<int>(isa) << " " << threads;
      auto replay = Replay::open(recorder.recording(), RunOptions{}, error);
      ASSERT_TRUE(replay) << error;
      while (replay->next()) {
      }
      EXPECT_TRUE(replay->complete());
      EXPECT_EQ(replay->differs_at(), 0u);
      EXPECT_EQ(replay->world().state_hash(), want);
    }
  }
}

// A step that takes several frames gives the impulse of the forces of all of them.
TEST(AppliedForce, FramesInWhichTimeStandsStillCount) {
  WorldDesc desc = unbounded(100);
  desc.gravity = {};
  desc.sleeping = false;
  auto world = make(desc);
  const BodyId id = add(*world, box({0, 0}, 1, 1, {}, 2));
  for (int k = 0; k < 30; ++k) add(*world, disc({-50 + 3.0 * k, 20}));
  StepDetail wait;
  wait.solves = false;
  wait.pieces = 1;
  StepDetail all;
  all.frames = 3;
  for (int k = 0; k < 10; ++k) {
    for (const StepDetail& detail : {wait, wait, all}) {
      ASSERT_TRUE(world->apply_force(id, {12, 0}));
      ASSERT_TRUE(world->apply_torque(id, 1));
      world->replay(detail);
    }
  }
  EXPECT_NEAR(state(*world, id).vx, 12.0 / 2 * 30 / 60, 1e-5);
  EXPECT_NEAR(state(*world, id).omega, 1 / (2.0 / 6) * 30 / 60, 1e-5);
}

TEST(AppliedForce, IsRefusedWhereNothingMoves) {
  auto world = make(walled({-10, 0, 10, 20}, {0, -kG}));
  const BodyId id = add(*world, box({0, 5})), still = add(*world, fixed(box({5, 1})));
  const BodyId away = add(*world, box({-5, 5}));
  ASSERT_TRUE(world->set_enabled(away, false));
  std::vector<std::byte> before, after;
  world->save(before);
  for (const double wrong : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e31}) {
    EXPECT_FALSE(world->apply_force(id, {wrong, 0}));
    EXPECT_FALSE(world->apply_force(id, {0, wrong}));
    EXPECT_FALSE(world->apply_force_at(id, {0, wrong}, {}));
    EXPECT_FALSE(world->apply_force_at(id, {1, 0}, {wrong, 0}));
    EXPECT_FALSE(world->apply_torque(id, wrong));
    EXPECT_FALSE(world->explode({{0, wrong}, 1, 1, 1, ~0u}));
    EXPECT_FALSE(world->explode({{0, 5}, wrong, 1, 1, ~0u}));
    EXPECT_FALSE(world->explode({{0, 5}, 1, wrong, 1, ~0u}));
    EXPECT_FALSE(world->explode({{0, 5}, 1, 1, wrong, ~0u}));
    std::string error;
    EXPECT_FALSE(world->set_fields({DragField{wrong, 0}}, error));
    EXPECT_NE(error.find("linear drag"), std::string::npos) << error;
    EXPECT_FALSE(world->set_fields({WellField{{wrong, 0}, 1}}, error));
  }
  EXPECT_FALSE(world->explode({{0, 5}, -1, 1, 1, ~0u}));
  for (const BodyId none : {still, away, BodyId{99, 0}, BodyId{id.index, id.generation + 1}}) {
    EXPECT_FALSE(world->apply_force(none, {1, 0}));
    EXPECT_FALSE(world->apply_force_at(none, {1, 0}, {}));
    EXPECT_FALSE(world->apply_torque(none, 1));
  }
  world->save(after);
  EXPECT_EQ(before, after);
}

TEST(AppliedForce, GoesWithItsBody) {
  auto world = make(unbounded(100));
  const BodyId gone = add(*world, disc({0, 0})), left = add(*world, disc({9, 0}));
  for (const BodyId id : {gone, left}) ASSERT_TRUE(world->apply_force(id, {5, 0}));
  ASSERT_TRUE(world->remove_body(gone));
  const BodyId next = add(*world, disc({0, 0}));
  EXPECT_EQ(next.index, gone.index);
  ASSERT_TRUE(world->set_enabled(left, false));
  ASSERT_TRUE(world->set_enabled(left, true));
  world->step();
  EXPECT_EQ(state(*world, next).vx, 0);
  EXPECT_EQ(state(*world, left).vx, 0);
}

TEST(AppliedForce, WakesItsBody) {
  Placed p = stack(1);
  for (int k = 0; k < 300 && p.world->is_awake(p.ids[0]); ++k) p.world->step();
  ASSERT_FALSE(p.world->is_awake(p.ids[0]));
  ASSERT_TRUE(p.world->apply_torque(p.ids[0], 0.01));
  EXPECT_TRUE(p.world->is_awake(p.ids[0]));
}

}  // namespace
}  // namespace psim::test
