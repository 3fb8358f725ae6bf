// What wakes bodies: at once, and no more than it must.
#include "sleep_support.h"

namespace psim::test {
namespace {

/// Discs that lie in a hexagonal lattice in a bin, asleep.
std::unique_ptr<World> sleeping_heap(int columns, int rows) {
  auto world = make(walled({0, 0, columns + 0.5, 3.0 * rows}, {0, -kG}, kGrip));
  Discs discs;
  discs.m = kGrip;
  for (int row = 0; row < rows; ++row) {
    for (int k = 0; k < columns; ++k) discs.push(0.5 + k + 0.5 * (row % 2), 0.5 + 0.8661 * row, 0.4999);
  }
  add(*world, discs);
  wait_for_rest(*world);
  return world;
}

// ---- the host -----------------------------------------------------------------------------------

struct Touch {
  const char* name;
  void (*apply)(World&, BodyId box);
};

const Touch kTouches[] = {
    {"Wake", [](World& w, BodyId id) { EXPECT_TRUE(w.wake(id)); }},
    {"Impulse",
     [](World& w, BodyId id) {
       EXPECT_TRUE(w.apply_impulse(id, {0.1, 0}));
     }},
    {"ImpulseAt",
     [](World& w, BodyId id) {
       EXPECT_TRUE(w.apply_impulse_at(id, {0.1, 0}, {0, 0.7}));
     }},
    {"AngularImpulse", [](World& w, BodyId id) { EXPECT_TRUE(w.apply_angular_impulse(id, 0.1)); }},
    {"SetVelocity",
     [](World& w, BodyId id) {
       EXPECT_TRUE(w.set_velocity(id, {0, 0.2}, 0));
     }},
    {"SetTransform",
     [](World& w, BodyId id) {
       EXPECT_TRUE(w.set_transform(id, {3, 0.6}, 0.1));
     }},
    {"SetGravity",
     [](World& w, BodyId) {
       EXPECT_TRUE(w.set_gravity({0.1, -9}));
     }},
    {"SetSleeping", [](World& w, BodyId) { w.set_sleeping(false); }},
    {"StaticBodyInIt",
     [](World& w, BodyId id) {
       const BodyState s = state(w, id);
       add(w, static_disc({s.x + 0.6, s.y}, 0.2));
     }},
    {"JointAdded",
     [](World& w, BodyId id) {
       JointDesc rope;
       rope.a = w.id_of(0);
       rope.b = id;
       std::string error;
       EXPECT_NE(w.add_joint(rope, error), kNoJoint) << error;
     }},
};

TEST(SleepWake, WhateverTheHostDoesToABodyWakesIt) {
  for (const Touch& touch : kTouches) {
    Placed p = sleeping_stack(1);
    touch.apply(*p.world, p.ids[0]);
    EXPECT_TRUE(p.world->is_awake(p.ids[0])) << touch.name;
    const StepReport report = p.world->step();
    EXPECT_EQ(report.awake, 1u) << touch.name;
  }
}

TEST(SleepWake, AnImpulseMovesAsMuchAsWithoutSleep) {
  Placed p = stack(1), q = stack(1);
  q.world->set_sleeping(false);
  run(*p.world, 120);
  run(*q.world, 120);
  EXPECT_EQ(awake(*p.world), 0u);
  for (Placed* s : {&p, &q}) s->world->apply_impulse(s->ids[0], {3, 0});
  run(*p.world, 120);
  run(*q.world, 120);
  EXPECT_GT(p.sideways(), 0.7);
  EXPECT_NEAR(p.sideways(), q.sideways(), 1e-3);
}

TEST(SleepWake, StaleIdsWakeNobody) {
  Placed p = sleeping_stack(3);
  const BodyId gone = p.ids[2];
  p.world->remove_body(gone);
  wait_for_rest(*p.world);
  EXPECT_FALSE(p.world->wake(gone));
  EXPECT_FALSE(p.world->apply_impulse(gone, {1, 0}));
  EXPECT_FALSE(p.world->is_awake(gone));
  const BodyId next = add(*p.world, box({20, 0.5}, 1, 1, kGrip, 1));
  EXPECT_EQ(next.index, gone.index);
  EXPECT_NE(next.generation, gone.generation);
  wait_for_rest(*p.world);
  EXPECT_FALSE(p.world->wake(gone));
  EXPECT_EQ(awake(*p.world), 0u);
  EXPECT_NEAR(state(*p.world, next).y, 0.5, 1e-3);
}

// ---- supports -----------------------------------------------------------------------------------

TEST(SleepWake, AllOfAStackFallsInTheFrameInWhichItsSupportGoes) {
  for (const int kind : {0, 1, 2}) {  // static, dynamic, kinematic
    auto world = make(unbounded());
    add(*world, segment({-50, -20}, {50, -20}, kGrip));
    BodyDesc table = box({0, -0.5}, 6, 1, kGrip);
    if (kind == 0) table.type = BodyType::static_body;
    if (kind == 2) table.type = BodyType::kinematic_body;
    const BodyId legs = kind == 1 ? add(*world, fixed(box({0, -1.5}, 6, 1, kGrip))) : kNoBody;
    const BodyId support = add(*world, table);
    std::vector<BodyId> ids;
    for (int k = 0; k < 6; ++k) ids.push_back(add(*world, box({0, k + 0.5}, 1, 1, kGrip, 1)));
    wait_for_rest(*world, kind == 2 ? 1 : 0);
    if (kind == 1) world->remove_body(legs);
    world->remove_body(support);
    world->step();
    for (const BodyId id : ids) {
      EXPECT_TRUE(world->is_awake(id)) << kind;
      EXPECT_NEAR(state(*world, id).vy, -kG / 60, 0.01) << kind;
    }
    wait_for_rest(*world);
    EXPECT_NEAR(state(*world, ids[0]).y, -19.5, 0.01);
  }
}

TEST(SleepWake, AKinematicFloorThatStartsToMoveTakesAlongWhatLiesOnIt) {
  auto world = make(unbounded());
  const BodyId lift = add(*world, kinematic(box({0, -0.5}, 10, 1, kGrip)));
  std::vector<BodyId> ids;
  for (int k = 0; k < 4; ++k) ids.push_back(add(*world, box({-3.0 + 2 * k, 0.5}, 1, 1, kGrip, 1)));
  wait_for_rest(*world, 1);
  EXPECT_EQ(awake(*world), 1u);
  world->set_velocity(lift, {0.5, 0.2}, 0);
  run(*world, 120);
  for (std::size_t k = 0; k < ids.size(); ++k) {
    const BodyState s = state(*world, ids[k]);
    EXPECT_NEAR(s.y, 0.5 + 0.4, 0.01);
    EXPECT_NEAR(s.x, -3.0 + 2 * static_cast<double>(k) + 1, 0.05);
  }
}

TEST(SleepWake, JointsSleepAndWakeTogether) {
  for (const bool cut : {false, true}) {
    auto world = make(unbounded());
    const BodyId peg = add(*world, static_disc({0, 0}, 0.1));
    std::vector<BodyId> ids{peg};
    std::vector<JointId> joints;
    std::string error;
    for (int k = 0; k < 6; ++k) {
      const BodyId next = add(*world, disc({0, -0.5 * (k + 1)}, {}, 0.1));
      JointDesc rod;
      rod.a = ids.back();
      rod.b = next;
      joints.push_back(world->add_joint(rod, error));
      ids.push_back(next);
    }
    wait_for_rest(*world);
    EXPECT_EQ(awake(*world), 0u);
    if (cut) {
      EXPECT_TRUE(world->remove_joint(joints[2]));
      run(*world, 30);
      EXPECT_LT(state(*world, ids[4]).y, -3);
      EXPECT_NEAR(state(*world, ids[2]).y, -1, 1e-3);
    } else {
      EXPECT_TRUE(world->wake(ids[3]));
      EXPECT_EQ(awake(*world), 6u);
      EXPECT_TRUE(world->remove_body(ids[6]));
      wait_for_rest(*world);
      EXPECT_EQ(world->joint_count(), 5u);
    }
  }
}

TEST(SleepWake, AMotorStartsWhatItTurns) {
  auto world = make(unbounded());
  const BodyId frame = add(*world, static_disc({0, 0}, 0.1));
  const BodyId wheel = add(*world, box({0, 0}, 2, 0.2, kGrip, 1));
  JointDesc pin;
  pin.type = JointType::revolute;
  pin.a = frame;
  pin.b = wheel;
  pin.motor_limit = 10;
  std::string error;
  const JointId motor = world->add_joint(pin, error);
  wait_for_rest(*world);
  EXPECT_TRUE(world->set_motor(motor, 1, 10));
  run(*world, 60);
  EXPECT_NEAR(state(*world, wheel).angle, 1, 0.1);
}

// ---- bodies that meet sleepers ------------------------------------------------------------------

TEST(SleepWake, ABulletKnocksASleeperOver) {
  for (const bool bullet : {false, true}) {
    Placed p = sleeping_stack(3);
    BodyDesc ball = disc({-20.3, 2.5}, {bullet ? 240.0 : 60.0, 0}, 0.2, kGrip);
    ball.bullet = bullet;
    ball.mass = 1;
    add(*p.world, ball);
    run(*p.world, 30);
    const double momentum = p.now(0).vx + p.now(1).vx + p.now(2).vx;  // of boxes of 1 kg
    EXPECT_GT(momentum, bullet ? 60 : 15);
    EXPECT_GT(p.sideways(), 1) << bullet;
  }
}

TEST(SleepWake, DominoesFallAsFastWhenTheySleep) {
  const auto last_falls = [](bool sleeping) {
    Placed p{make(unbounded(200)), {}, {}};
    add(*p.world, ground(kGrip));
    for (int k = 0; k < 40; ++k) p.put(box({0.4 * k, 0.5}, 0.1, 1, kGrip));
    p.world->set_sleeping(sleeping);
    run(*p.world, 120);
    EXPECT_EQ(awake(*p.world), sleeping ? 0u : 40u);
    p.world->apply_impulse_at(p.ids[0], {0.15, 0}, {0, 1});
    for (int frame = 0; frame < 1200; ++frame) {
      p.world->step();
      if (std::abs(p.top().angle) > 0.5) return frame;
    }
    return 0;
  };
  const int with = last_falls(true), without = last_falls(false);
  EXPECT_GT(without, 60);
  EXPECT_NEAR(with, without, 0.03 * without);
}

TEST(SleepWake, ADiscThatFallsOnAPileWakesFewAndThePileSleepsAgain) {
  auto world = sleeping_heap(40, 25);
  const Diagnostics before = world->diagnostics();
  const BodyId ball = add(*world, disc({20, 25}, {}, 0.4999, kGrip));
  std::uint64_t most = 0;
  int frames = 0;
  while (world->step().awake != 0 && frames < 3600) {
    most = std::max(most, awake(*world));
    ++frames;
  }
  EXPECT_LT(frames, 1200);
  EXPECT_GT(most, 1u);
  EXPECT_LT(most, 300u);
  EXPECT_GT(state(*world, ball).y, 20);
  EXPECT_LT(deepest(*world), 0.02);
  EXPECT_NEAR(world->diagnostics().potential, before.potential, 0.01 * before.potential);
}

TEST(SleepWake, TheCoreOfAPileSleepsWhileItsSurfaceIsStirred) {
  auto world = sleeping_heap(30, 20);
  const BodyId paddle = add(*world, kinematic(box({15, 17.5}, 4, 0.5, kGrip)));
  std::uint64_t asleep = 0;
  for (int frame = 0; frame < 900; ++frame) {
    world->set_velocity(paddle, {3 * std::cos(0.05 * frame), frame < 30 ? -1.0 : 0.0}, 0);
    asleep = world->step().asleep;
  }
  EXPECT_GT(asleep, 150u);
  EXPECT_LT(asleep, 600u);
  EXPECT_FALSE(world->is_awake(world->id_of(15)));  // in the middle of the lowest row
  EXPECT_LT(rms_speed(*world), 2);
  world->remove_body(paddle);
  wait_for_rest(*world);
  EXPECT_EQ(awake(*world), 0u);
}

// While all discs have one mass impulses are kept per mass; what sleepers keep is right all the same once one of
// another mass comes, or goes.
TEST(SleepWake, AnotherMassFarAwayLeavesAPileWhatItCarries) {
  constexpr int kDiscs = 8;
  for (const double mass : {1e-3, 1e3}) {
    for (const bool comes : {true, false}) {
      auto world = make(walled({0, 0, 1, 60}));
      BodyDesc stone = disc({0.5, 0}, {}, 0.5), other = disc({0.5, 50}, {}, 0.4);
      stone.mass = mass;
      other.mass = 3 * mass;
      other.gravity_scale = 0;
      for (int k = 0; k < kDiscs; ++k) {
        stone.position.y = 0.5 + k;
        add(*world, stone);
      }
      BodyId odd;
      if (!comes) odd = add(*world, other);
      wait_for_rest(*world);
      if (comes) add(*world, other);
      if (!comes) world->remove_body(odd);
      world->step();
      for (std::uint32_t id = 0; id < kDiscs; ++id) world->wake(world->id_of(id));
      for (int frame = 0; frame < 3; ++frame) {
        world->step();
        for (std::uint32_t id = 0; id < kDiscs; ++id) {
          ASSERT_LT(std::fabs(state(*world, world->id_of(id)).vy), 0.02)
              << mass << ", " << comes << ", frame " << frame << ", disc " << id;
        }
        double ground = 0;
        for (const Contact& c : world->contacts())
          ground += c.b == kNoBody && std::fabs(c.normal.y) > 0.5 ? c.impulse : 0;
        EXPECT_NEAR(ground / (kDiscs * mass * kG * world->desc().dt), 1, 0.1)
            << mass << ", " << comes << ", frame " << frame;
      }
    }
  }
}

// A heap that fell asleep, with holes made in it, stands: a sleeper wakes when what lies on it presses otherwise than
// before. In one heap of eight a body still leans over slowly, asleep or not. In some heaps, round ends roll on each
// other to and fro for minutes, as they should without rolling resistance: those do not fall asleep.
TEST(SleepWake, NobodySleepsInTheAir) {
  const auto rests = [](World& world) {
    for (int frame = 0; frame < 3600; ++frame) {
      if (world.step().awake == 0) return true;
    }
    return false;
  };
  int slept = 0, leans = 0, falls = 0;
  for (unsigned seed = 11; seed < 43; ++seed) {
    Random random(seed);
    Placed p{make(walled({0, 0, 12, 60}, {0, -kG}, kGrip)), {}, {}};
    for (int k = 0; k < 150; ++k) {
      const Vec2 at{1.0 + 1.1 * (k % 10) + random.uniform(-0.1, 0.1), 1.0 + 1.1 * (k / 10)};
      const double angle = random.uniform(0, 3);
      p.put(k % 3 == 0 ? turned(box(at, 0.7, 0.5, kGrip), angle) : turned(capsule(at, 0.3, 0.2, kGrip), angle));
    }
    bool all = rests(*p.world);
    for (int k = 0; k < 60; k += 7) {  // holes
      p.world->remove_body(p.ids[static_cast<std::size_t>(k)]);
      all = rests(*p.world);
    }
    if (!all) continue;
    ++slept;
    for (std::size_t k = 0; k < p.ids.size(); ++k) {
      if (p.world->is_valid(p.ids[k])) p.at[k] = {p.now(k).x, p.now(k).y};
    }
    p.world->set_sleeping(false);
    double fastest = 0;
    for (int frame = 0; frame < 90; ++frame) {
      p.world->step();
      fastest = std::max(fastest, p.fastest());
    }
    leans += p.moved() > 2e-3;
    falls += p.moved() > 0.1 || fastest > 0.4;
  }
  EXPECT_GE(slept, 28);
  EXPECT_LE(leans, 4);
  EXPECT_LE(falls, 1);  // of 129 heaps one or two have a body that slept while it leaned, and falls when it wakes
}

// A heap that falls asleep part by part comes to rest as fast as one that does not: contacts of those that
// stay awake keep their impulses when the other side becomes fixed. They took those of other contacts.
TEST(SleepWake, HeapsOfShapesComeToRestWhileTheyFallAsleepPartByPart) {
  for (const bool boxes : {true, false}) {
    Random random(11);
    Placed p{make(walled({0, 0, 12, 60}, {0, -kG}, kGrip)), {}, {}};
    for (int k = 0; k < 150; ++k) {
      const Vec2 at{1.0 + 1.1 * (k % 10) + random.uniform(-0.1, 0.1), 1.0 + 1.1 * (k / 10)};
      const double angle = random.uniform(0, 3);
      p.put(turned(boxes ? box(at, 0.7, 0.5, kGrip) : capsule(at, 0.3, 0.2, kGrip), angle));
    }
    run_seconds(*p.world, 20);
    EXPECT_EQ(p.world->step().awake, 0u) << boxes;
  }
}

// The column of radii stays behind when bodies move to other slots, as long as all are alike. A slot of one
// of another size that was gone kept its radius for the next body in it: the pile never rested again.
TEST(SleepWake, APileRestsAfterTheOnlyLargeBodyIsRemoved) {
  for (const bool sleeping : {false, true}) {
    auto world = sleeping_heap(20, 10);
    world->set_sleeping(sleeping);
    const BodyId large = add(*world, disc({10, 9.4}, {0, -2}, 0.6, kGrip));
    run(*world, 30);
    world->remove_body(large);
    run_seconds(*world, 3);
    EXPECT_LT(rms_speed(*world), 1e-4) << sleeping;
    EXPECT_LT(deepest(*world), 0.005) << sleeping;
  }
}

// A shape that was once found to be apart from a sleeper, and turns and drifts away beside it, does not wake it, whatever
// the lists of others look like: a fast body far off makes them longer.
TEST(SleepWake, NothingThatPassesAtADistanceWakes) {
  for (const double fast : {0.0, 20.0, 60.0}) {
    for (const double drift : {0.6, 2.0}) {
      auto world = make({}, best_isa());
      add(*world, fixed(box({0, -0.5}, 200, 1, kGrip)));
      const BodyId crate = add(*world, box({0, 0.5}, 1, 1, kGrip));
      BodyDesc debris = box({1.3, 1.8}, 0.6, 0.6, kGrip);
      debris.velocity = {drift, 0.4};
      debris.angular_velocity = -0.8;
      debris.gravity_scale = 0;
      add(*world, debris);
      BodyDesc far = disc({150, 400}, {0, -fast}, 0.2, kGrip);
      far.gravity_scale = 0;
      add(*world, far);
      int changes = 0;
      bool awake = true;
      for (int frame = 0; frame < 500; ++frame) {
        world->step();
        changes += world->is_awake(crate) != awake;
        awake = world->is_awake(crate);
      }
      EXPECT_FALSE(awake) << fast << ' ' << drift;
      EXPECT_EQ(changes, 1) << fast << ' ' << drift;
    }
  }
}

}  // namespace
}  // namespace psim::test
