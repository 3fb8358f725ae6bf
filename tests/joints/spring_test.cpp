// Springs: what hangs on them rests where forces balance, at any number of substeps; they keep their period and energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "joint_support.h"
#include "rigid_support.h"
#include "structures.h"

namespace psim::test {
namespace {

class Springs : public testing::TestWithParam<int> {
 protected:
  static JointScene scene(double damping, Vec2 gravity = {0, -kG}) {
    WorldDesc desc;
    desc.gravity = gravity;
    desc.substeps = GetParam();
    desc.linear_damping = damping;
    desc.sleeping = false;
    return JointScene(desc);
  }
};
INSTANTIATE_TEST_SUITE_P(Substeps, Springs, testing::Values(1, 4, 16));

JointDesc spring(BodyId a, BodyId b, double length, double stiffness, Vec2 anchor_a = {}, Vec2 anchor_b = {}) {
  JointDesc d = between(JointType::spring, a, b, anchor_a, anchor_b);
  d.length = length;
  d.stiffness = stiffness;
  return d;
}

// What a spring carries is the weight below it.
TEST_P(Springs, ChainsOfAnyMassesRestWhereForcesBalance) {
  Random random(7);
  for (int round = 0; round < 10; ++round) {
    JointScene s = scene(2);
    const int links = 1 + static_cast<int>(random.uniform(0, 8));
    std::vector<double> mass, stiffness;
    std::vector<BodyId> bodies;
    double all = 0;
    for (int k = 0; k < links; ++k) all += mass.emplace_back(std::pow(10, random.uniform(-1, 1)));
    BodyId last = s.peg({0, 0});
    double below = all, y = 0;
    std::vector<double> rest;
    for (int k = 0; k < links; ++k) {
      // Under its load a spring gets 0.1 to 2 m longer.
      const double longer = std::pow(10, random.uniform(-1, 0.3)), length = random.uniform(0.2, 1);
      y -= length;
      bodies.push_back(s.disc({0, y}, 0.05, mass[static_cast<std::size_t>(k)], true));
      JointDesc d = spring(last, bodies.back(), length, below * kG / longer);
      d.damping = 0.2 * d.stiffness;
      s.join(d);
      rest.push_back((rest.empty() ? 0 : rest.back()) - length - longer);
      below -= mass[static_cast<std::size_t>(k)];
      last = bodies.back();
    }
    s.run(60 * 60);
    for (std::size_t k = 0; k < bodies.size(); ++k) EXPECT_NEAR(s.at(bodies[k]).y, rest[k], 5e-6) << round << " " << k;
  }
}

// The truth: angles of ten links under a weight, by bisection.
TEST_P(Springs, SoftWeldsBendAsFarAsMomentsBalance) {
  for (const double bending : {1.0, 10.0}) {
    JointScene s = scene(2);
    const reference::Cantilever truth{10, 0.1, kG / bending / 0.1, 0.1 * kG, kG};
    BodyId last = s.peg({0, 0});
    for (int k = 0; k < 10; ++k) {
      const BodyId next = board(s, {0.1 * k + 0.05, 0}, 0.1, 0.04, 0.1);
      JointDesc d = between(JointType::weld, last, next, {k > 0 ? 0.05 : 0.0, 0}, {-0.05, 0});
      d.stiffness = truth.stiffness;
      d.damping = 0.02 * d.stiffness;
      s.join(d);
      last = next;
    }
    const BodyId tip = s.disc({1, 0}, 0.01, 1, true);
    s.join(between(JointType::revolute, last, tip, {0.05, 0}));
    s.run(60 * 40);
    EXPECT_NEAR(-s.at(tip).y, truth.drop(), 5e-6) << bending;
  }
}

// Sweeps: a net is too much to be solved at once. It hangs straight down, so each column is a chain.
TEST_P(Springs, NetsRestWhereForcesBalance) {
  constexpr int kSide = 24;
  const double mass = 0.1, stiffness = 2000.0 / 16 * std::min(GetParam() * GetParam(), 16);
  JointScene s = scene(1);
  std::vector<BodyId> nodes;
  for (int k = 0; k < kSide * kSide; ++k) {
    const int row = k / kSide, column = k % kSide;
    const Vec2 at{0.5 * column, -0.5 * row};
    nodes.push_back(row == 0 ? s.peg(at) : s.disc(at, 0.05, mass, true));
    if (row > 0 && column > 0) s.join(spring(nodes[static_cast<std::size_t>(k - 1)], nodes.back(), 0.5, stiffness));
    if (row > 0) s.join(spring(nodes[static_cast<std::size_t>(k - kSide)], nodes.back(), 0.5, stiffness));
  }
  s.run(60 * 60);
  double y = 0;
  for (int row = 1; row < kSide; ++row) {
    y -= 0.5 + (kSide - row) * mass * kG / stiffness;
    for (const int column : {0, kSide / 2}) {
      EXPECT_NEAR(s.at(nodes[static_cast<std::size_t>(row * kSide + column)]).y, y, 1e-4 * (1 - y)) << row;
    }
  }
}

// Without damping, hung up and let go: where it is after ten periods, and the energy on the way.
TEST_P(Springs, OscillatorsKeepPeriodAndEnergy) {
  for (const double turn : {0.03, 0.3, 0.9}) {
    JointScene s = scene(0);
    const double w = turn * 60 * GetParam(), amplitude = kG / (w * w);
    const BodyId peg = s.peg({0, 0}), bob = s.disc({0, -1}, 0.01, 2, true);
    s.join(spring(peg, bob, 1, 2 * w * w));
    for (int frame = 1; frame <= 600; ++frame) {
      s.run(1);
      const BodyState b = s.at(bob);
      const double down = -1 - b.y;
      ASSERT_NEAR(down / amplitude, 1 - std::cos(w * frame / 60), 0.02 + 2e-7 / amplitude) << turn;
      ASSERT_NEAR((b.vy * b.vy + w * w * down * down) / 2 - kG * down, 0, 2e-4 * kG * amplitude + 1e-6 * kG) << turn;
    }
  }
}

// Of what three planks weigh an arm's length lower; the springs pull at their ends.
TEST_P(Springs, PlanksOnSpringsKeepTheirEnergy) {
  for (const double stiffness : {100.0, 1000.0}) {
    JointScene s = scene(0);
    std::vector<BodyId> bodies{s.peg({0, 0})};
    std::vector<JointId> springs;
    double scale = 0;
    for (int k = 0; k < 3; ++k) {
      bodies.push_back(board(s, {0.6 + 1.1 * k, 0}, 1, 0.3, 2));
      springs.push_back(
          s.join(spring(bodies[bodies.size() - 2], bodies.back(), 0.1, stiffness, {k > 0 ? 0.5 : 0.0, 0}, {-0.5, 0})));
      scale += 2 * kG * (0.6 + 1.1 * k);
    }
    const auto energy = [&] {
      const Diagnostics d = s.world->diagnostics();
      double sum = d.kinetic + d.potential;
      for (const JointId id : springs) sum += stiffness * std::pow(s.joint(id).value - 0.1, 2) / 2;
      return sum;
    };
    double least = energy();
    const double start = least;
    for (int frame = 0; frame < 1200; ++frame) {
      s.run(1);
      ASSERT_LT(energy() - least, 3e-4 * scale) << "frame " << frame;
      least = std::min(least, energy());
    }
    EXPECT_GT(least, start - (GetParam() == 1 ? 1e-2 : 3e-4) * scale);
  }
}

}  // namespace
}  // namespace psim::test
