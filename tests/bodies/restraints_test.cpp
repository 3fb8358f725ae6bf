// What single bodies have against moving: damping and locks; and how materials in contact mix.
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

BodyDesc damped(BodyDesc body, double linear, double angular = 0) {
  body.linear_damping = linear;
  body.angular_damping = angular;
  return body;
}

BodyDesc locked(BodyDesc body, Locks locks) {
  body.locks = locks;
  return body;
}

TEST(Restraints, DampingIsExact) {
  for (const double c : {0.02, 0.5, 4.0, 60.0, 900.0}) {
    for (const int substeps : {1, 4, 16}) {
      WorldDesc desc = unbounded(1000, {0, 0});
      desc.substeps = substeps;
      desc.sleeping = false;
      auto world = make(desc);
      std::vector<BodyId> ids;
      for (const BodyDesc& body : {disc({0, 0}), box({0, 20}), disc({0, 40})}) {
        ids.push_back(add(*world, moving(damped(body, c, 2 * c), {7, -3}, 5)));
      }
      add(*world, disc({0.2, 40.9}));  // beside the last one, so that they share a list
      run(*world, 30);
      const double t = 0.5, kept = std::exp(-c * t), way = (1 - kept) / c, kept2 = kept * kept,
                   turn = (1 - kept2) / (2 * c);
      for (std::size_t k = 0; k < 2; ++k) {
        const BodyState s = state(*world, ids[k]);
        EXPECT_NEAR(s.vx, 7 * kept, 1e-5 * 7 * (kept + 1e-3)) << c << " " << substeps;
        EXPECT_NEAR(s.vy, -3 * kept, 1e-5 * 7 * (kept + 1e-3)) << c << " " << substeps;
        EXPECT_NEAR(s.omega, 5 * kept2, 1e-5 * 5 * (kept2 + 1e-3)) << c << " " << substeps;
        if (2 * c / 60 / substeps > 0.5) continue;  // the way is not, where so much fades in a substep
        EXPECT_NEAR(s.x, 7 * way, 1e-5 * 7 * way) << c << " " << substeps;
        EXPECT_NEAR(s.angle, 5 * turn, 1e-5 * 5 * turn) << c << " " << substeps;
      }
    }
  }
}

TEST(Restraints, WhatFallsHasItsTerminalSpeed) {
  for (const double c : {0.5, 4.0, 60.0, 900.0}) {
    WorldDesc desc = unbounded(10000);
    desc.sleeping = false;
    auto world = make(desc);
    const BodyId free = add(*world, damped(disc({0, 0}), c)), other = add(*world, damped(box({50, 0}), c));
    run(*world, 600);
    const double t = 10, speed = kG / c * (1 - std::exp(-c * t));
    for (const BodyId id : {free, other}) {
      EXPECT_NEAR(state(*world, id).vy, -speed, 1e-4 * speed) << c;
      if (c > 50) continue;
      const double fall = kG / c * (t - (1 - std::exp(-c * t)) / c);
      EXPECT_NEAR(state(*world, id).y, -fall, 1e-4 * fall) << c;
    }
  }
}

TEST(Restraints, DampedBodiesRestAndSleepAsOthersDo) {
  auto world = make(unbounded(50));
  add(*world, ground(material(0, 0.5)));
  std::vector<BodyId> ids;
  for (int k = 0; k < 6; ++k) {
    ids.push_back(add(*world, damped(box({0, 0.5 + k}, 1, 1, material(0, 0.5)), 0.3 * k, 1)));
    ids.push_back(add(*world, damped(disc({5, 0.5 + k}, {}, 0.5, material(0, 0.5)), 0.3 * k, 1)));
  }
  run(*world, 400);
  for (std::size_t k = 0; k < ids.size(); ++k) {
    EXPECT_NEAR(state(*world, ids[k]).y, 0.5 + static_cast<double>(k / 2), 5e-3);
    EXPECT_FALSE(world->is_awake(ids[k])) << k;
  }
}

// A heap of locked and other bodies, hit by fast ones: nobody leaves their lines.
TEST(Restraints, LockedBodiesStayOnTheirLines) {
  for (const double bounce : {0.0, 0.9}) {
    for (const double g : {0.0, kG}) {
      WorldDesc desc = walled({-10, 0, 10, 20}, {0, -g});
      desc.sleeping = g != 0;
      auto world = make(desc);
      Random r(5);
      std::vector<std::pair<BodyId, BodyDesc>> bodies;
      for (int k = 0; k < 60; ++k) {
        BodyDesc body = k % 2 == 0 ? disc({}, {}, 0.4) : box({}, 0.9, 0.6);
        if (k % 6 == 1) body.shape = CompoundShape{{{BoxShape{1, 0.2}}, {DiscShape{0.3}, {0.5, 0}}}};
        body.material = material(bounce, 0.4);
        body.position = {r.uniform(-9, 9), r.uniform(1, 19)};
        body.angle = r.uniform(-3, 3);
        body.velocity = {r.uniform(-40, 40), r.uniform(-40, 40)};
        body.angular_velocity = r.uniform(-9, 9);
        body.locks = {r.chance(0.4), r.chance(0.4), r.chance(0.4)};
        if (r.chance(0.3)) body.linear_damping = r.uniform(0, 3);
        body.bullet = r.chance(0.2);
        bodies.emplace_back(add(*world, body), body);
      }
      for (int frame = 0; frame < 200; ++frame) {
        run(*world, 1);
        for (const auto& [id, body] : bodies) {
          const BodyState s = state(*world, id);
          const bool centred = !std::holds_alternative<CompoundShape>(body.shape) || body.locks.angle;
          if (body.locks.x && centred) {
            ASSERT_NEAR(s.x, body.position.x, 1e-9) << frame << " " << id.index;
          }
          if (body.locks.y && centred) {
            ASSERT_NEAR(s.y, body.position.y, 1e-9) << frame << " " << id.index;
          }
          if (body.locks.angle) {
            ASSERT_EQ(s.angle, body.angle) << frame << " " << id.index;
          }
        }
      }
    }
  }
}

// However light it is, it yields to nothing that comes along the axis along which it is locked, and to all that comes
// along the other one.
// Also where accelerations differ by place, and joints pull.
TEST(Restraints, LockedBodiesStayInFieldsAndInJoints) {
  for (const Integrator integrator : kAllIntegrators) {
    for (int locks = 1; locks < 8; ++locks) {
      WorldDesc desc = unbounded(50, {1, -2});
      desc.fields = {WellField{{1, 2}, 30, 0.5, 2, 0}};
      desc.integrator = integrator;
      auto world = make(desc);
      const Locks of{(locks & 1) != 0, (locks & 2) != 0, (locks & 4) != 0};
      const BodyId lone = add(*world, locked(moving(box({-3, 4}), {3, 2}, 4), of));
      const BodyId tied = add(*world, locked(moving(disc({5, 4}), {3, 2}, 4), of));
      JointDesc joint;
      joint.type = JointType::weld;
      joint.a = tied;
      joint.b = add(*world, fixed(disc({8, 8})));
      std::string error;
      // Nobody could move where it holds two bodies that stand still.
      EXPECT_EQ(world->add_joint(joint, error) == kNoJoint, locks == 7) << error;
      run(*world, 60);
      for (const auto& [id, x] : {std::pair(lone, -3.0), std::pair(tied, 5.0)}) {
        const BodyState s = state(*world, id);
        EXPECT_TRUE(std::isfinite(s.x + s.y + s.angle)) << locks;
        if (of.x) {
          EXPECT_NEAR(s.x, x, 1e-9) << locks;
        }
        if (of.y) {
          EXPECT_NEAR(s.y, 4, 1e-9) << locks;
        }
        if (of.angle) {
          EXPECT_EQ(s.angle, 0) << locks;
        }
      }
    }
  }
}

TEST(Restraints, ALockHoldsAgainstAPush) {
  for (const bool boxes : {false, true}) {
    for (const double e : {0.0, 0.5, 1.0}) {
      for (const double density : {0.01, 1.0, 50.0}) {
        auto world = make(unbounded(50, {0, 0}));
        const auto body = [&](Vec2 at, double of) {
          return boxes ? box(at, 1, 1, material(e, 0, of)) : disc(at, {}, 0.5, material(e, 0, of));
        };
        const BodyId post = add(*world, locked(body({0, 0}, density), {.x = true, .angle = true}));
        const BodyId ball = add(*world, moving(body({-4, 0}, 1), {5, 0}));
        const BodyId second = add(*world, moving(body({0, 14}, 1), {0, -5}));
        run(*world, 60);
        EXPECT_EQ(state(*world, post).x, 0);
        EXPECT_NEAR(state(*world, post).vy, 0, 1e-3);
        EXPECT_NEAR(state(*world, ball).vx, -5 * e, 0.02) << boxes << e << density;
        world->remove_body(ball);
        run(*world, 240);                                            // the second one has come
        const double together = 5 / (1 + density), parting = 5 * e;  // momentum; restitution
        EXPECT_NEAR(state(*world, post).vy, -(together + parting / (1 + density)), 0.03) << boxes << e << density;
        EXPECT_NEAR(state(*world, second).vy, -(together - density * parting / (1 + density)), 0.03);
        EXPECT_EQ(state(*world, post).x, 0);
      }
    }
  }
}

// Saved, replayed, removed, and the same on every instruction set and any number of threads.
TEST(Restraints, GoOnWithTheSameBits) {
  std::vector<std::uint64_t> first;
  for (const Isa isa : available_isas()) {
    for (const int threads : {1, 3}) {
      WorldDesc desc = unbounded(50);
      desc.mixing = {Mixing::min, Mixing::mean};
      auto world = make(desc, isa, threads);
      Recorder recorder(*world);
      std::string error;
      recorder.add_body(ground(material(0.6, 0.5)), error);
      std::vector<BodyId> ids;
      for (int k = 0; k < 60; ++k) {
        BodyDesc body =
            k % 3 == 0 ? box({k % 10 - 5.0, 2.0 + k / 10}, 0.8, 0.5) : disc({k % 10 - 5.0, 2.0 + k / 10}, {}, 0.3);
        body.material = material(0.1 * (k % 10), 0.3);
        if (k % 2 == 0) body.linear_damping = 0.1 * k, body.angular_damping = 0.2;
        body.locks = {k % 7 == 3, k % 11 == 5, k % 5 == 4};
        ids.push_back(recorder.add_body(body, error));
      }
      for (int k = 0; k < 40; ++k) recorder.step();
      EXPECT_TRUE(recorder.remove_body(ids[4]));
      EXPECT_TRUE(recorder.remove_body(ids[33]));
      for (int k = 0; k < 20; ++k) recorder.step();
      std::vector<std::byte> state;
      world->save(state);
      auto other = World::from_state(state, {isa, threads}, error);
      ASSERT_TRUE(other) << error;
      for (int k = 0; k < 300; ++k) {
        recorder.step();
        other->step();
      }
      EXPECT_EQ(world->state_hash(), other->state_hash());
      first.push_back(world->state_hash());
      EXPECT_EQ(first.front(), first.back()) << isa_name(isa) << threads;
    }
  }
}

TEST(Restraints, BadNumbersAreRefused) {
  auto world = make(unbounded(50));
  for (const double bad : {-1.0, kNan, kInf, 2e6}) {
    std::string error;
    EXPECT_EQ(world->add_body(damped(disc({0, 0}), bad), error), kNoBody);
    EXPECT_NE(error.find("linear damping"), std::string::npos) << error;
    EXPECT_EQ(world->add_body(damped(disc({0, 0}), 0, bad), error), kNoBody);
    EXPECT_NE(error.find("angular damping"), std::string::npos) << error;
  }
}

// ---- mixing -----------------------------------------------------------------------------------

double mix(Mixing rule, double a, double b) {
  const std::array<double, 5> all{std::max(a, b), std::min(a, b), (a + b) / 2, a * b, std::sqrt(a * b)};
  return all[static_cast<std::size_t>(rule)];
}
constexpr std::array<Mixing, 5> kRules = {Mixing::max, Mixing::min, Mixing::mean, Mixing::product, Mixing::geometric};

TEST(Mixing, ContactsBounceByTheRuleOfTheWorld) {
  for (const Mixing rule : kRules) {
    for (const bool walls : {false, true}) {
      for (const bool boxes : {false, true}) {
        WorldDesc desc = walls ? walled({-20, 0, 20, 40}) : unbounded(50);
        desc.mixing.restitution = rule;
        desc.wall = material(0.3);
        auto world = make(desc);
        if (!walls) add(*world, ground(material(0.3)));
        const double half = 0.5;
        const BodyDesc body = boxes ? box({0, 5.5}, 1, 1, material(0.9)) : disc({0, 5.5}, {}, 0.5, material(0.9));
        const BodyId id = add(*world, body);
        double fastest = 0;
        for (int k = 0; k < 150; ++k) {
          run(*world, 1);
          fastest = std::max(fastest, state(*world, id).vy);
        }
        const double e = mix(rule, 0.3, 0.9);
        EXPECT_NEAR(fastest / std::sqrt(2 * kG * (5.5 - half)), e, 0.02) << static_cast<int>(rule) << walls << boxes;
      }
    }
  }
}

TEST(Mixing, ContactsRubByTheRuleOfTheWorld) {
  for (const Mixing rule : kRules) {
    for (const auto& [low, high] : {std::pair(0.2, 0.6), std::pair(0.0, 0.5)}) {
      for (const bool swapped : {false, true}) {
        WorldDesc desc = unbounded(50);
        desc.mixing.friction = rule;
        auto world = make(desc);
        add(*world, ground(material(0, swapped ? high : low)));
        const BodyId id = add(*world, moving(box({0, 0.25}, 2, 0.5, material(0, swapped ? low : high)), {6, 0}));
        run(*world, 48);
        const double mu = mix(rule, low, high);
        EXPECT_NEAR(state(*world, id).vx, std::max(0.0, 6 - mu * kG * 0.8), 0.03) << static_cast<int>(rule) << low;
      }
    }
  }
}

// A rough disc on a smooth one turns it where one rough side is enough.
TEST(Mixing, RoughDiscsRubSmoothOnes) {
  for (const Mixing rule : kRules) {
    WorldDesc desc = unbounded(50, {0, 0});
    desc.mixing.friction = rule;
    auto world = make(desc);
    const BodyId smooth = add(*world, disc({0, 0}));
    add(*world, moving(disc({0, 2}, {}, 0.5, material(0, 0.8)), {0, -5}, 20));
    run(*world, 60);
    const bool rubs = rule == Mixing::max || rule == Mixing::mean;
    EXPECT_EQ(state(*world, smooth).omega != 0, rubs) << static_cast<int>(rule);
  }
}

// ---- worlds without bounds --------------------------------------------------------------------

TEST(OpenBounds, AreAsExactFarAwayAsHere) {
  WorldDesc desc = unbounded();
  desc.bounds = kOpenBounds;
  std::vector<double> heights;
  for (const double x : {0.0, 1000000.0}) {
    auto world = make(desc);
    BodyDesc floor = ground(material(0, 0.5));
    floor.position.x = x;
    add(*world, floor);
    for (int k = 0; k < 5; ++k) add(*world, box({x, 0.5 + k}, 1, 1, material(0, 0.5)));
    const BodyId ball = add(*world, disc({x + 3, 4}, {1, 0}, 0.5, material(0.5, 0.5)));
    run(*world, 300);
    heights.push_back(state(*world, ball).x - x);
    heights.push_back(state(*world, ball).y);
    EXPECT_EQ(world->body_count(), 7u);
  }
  EXPECT_EQ(heights[0], heights[2]);
  EXPECT_EQ(heights[1], heights[3]);
}

}  // namespace
}  // namespace psim::test
