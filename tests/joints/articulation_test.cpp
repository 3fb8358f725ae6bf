// Joints that are solved together: they give no energy, open under no load, and are as rigid as they say.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "joint_support.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

class Articulation : public testing::TestWithParam<int> {
 protected:
  static JointScene scene(Vec2 gravity = {0, -kG}) {
    WorldDesc desc;
    desc.gravity = gravity;
    desc.substeps = GetParam();
    desc.sleeping = false;
    return JointScene(desc);
  }
};
INSTANTIATE_TEST_SUITE_P(Substeps, Articulation, testing::Values(1, 4, 16));

BodyId plank(JointScene& s, Vec2 at, double width, double height, double mass, Vec2 velocity = {}, double omega = 0) {
  BodyDesc d = moving(box(at, width, height, {}, mass), velocity, omega);
  d.filter.mask = 0;
  return s.add(d);
}

double energy(const JointScene& s) {
  const Diagnostics d = s.world->diagnostics();
  return d.kinetic + d.potential;
}

// Before articulations three planks on rods of 0.1 m gained a million times m g L.
TEST_P(Articulation, PlanksOnShortRodsAndRopesGainNoEnergy) {
  for (const JointType type : {JointType::distance, JointType::rope}) {
    for (const double length : {0.1, 0.5}) {
      for (const int planks : {1, 3}) {
        JointScene s = scene();
        BodyId last = s.peg({0, 0});
        double scale = 0;
        for (int k = 0; k < planks; ++k) {
          const double x = 0.5 + length + (1 + length) * k;
          const BodyId next = plank(s, {x, 0}, 1, 0.3, 2);
          JointDesc d = between(type, last, next, {k == 0 ? 0.0 : 0.5, 0}, {-0.5, 0});
          d.length = length;
          s.join(d);
          last = next;
          scale += 2 * kG * x;
        }
        const double start = energy(s);
        for (int frame = 0; frame < 600; ++frame) {
          s.run(1);
          ASSERT_LT(energy(s) - start, 1e-4 * scale)
              << "length " << length << ", planks " << planks << ", frame " << frame;
        }
      }
    }
  }
}

TEST_P(Articulation, APinPendulumKeepsItsEnergy) {
  JointScene s = scene();
  const BodyId peg = s.peg({0, 0}), bob = plank(s, {1, 0}, 0.2, 0.2, 1);
  s.join(between(JointType::revolute, peg, bob, {}, {-1, 0}));
  const double start = energy(s);
  for (int frame = 0; frame < 1200; ++frame) {
    s.run(1);
    ASSERT_NEAR(energy(s), start, (GetParam() == 1 ? 2e-3 : 2e-4) * kG) << "frame " << frame;
  }
}

// The light body whips round within milliseconds whenever both rods lie in a line. In whole substeps this lost 0.99 of the
// energy at one substep, 0.11 at 4 and 0.62 at 16.
TEST_P(Articulation, ADoublePendulumOfOneToAThousandKeepsItsEnergy) {
  for (const double mass : {1000.0, 0.001}) {
    JointScene s = scene();
    const BodyId peg = s.peg({0, 0}), inner = plank(s, {1, 0}, 0.1, 0.1, 1), outer = plank(s, {2, 0}, 0.1, 0.1, mass);
    s.join(between(JointType::revolute, peg, inner, {}, {-1, 0}));
    s.join(between(JointType::revolute, inner, outer, {}, {-1, 0}));
    const double start = energy(s), scale = kG * (1 + 2 * mass);
    for (int frame = 0; frame < 1200; ++frame) {
      s.run(1);
      ASSERT_NEAR(energy(s), start, 3e-3 * scale) << "mass " << mass << ", frame " << frame;
    }
  }
}

// A thousand times the mass of a link at the end of twenty.
TEST_P(Articulation, ChainsUnderHeavyLoadsStayClosed) {
  for (const JointType type : {JointType::revolute, JointType::weld}) {
    JointScene s = scene();
    std::vector<JointId> joints;
    BodyId last = s.peg({0, 0});
    for (int k = 0; k < 21; ++k) {
      const BodyId next = k < 20 ? plank(s, {0, -0.5 - k}, 0.1, 0.9, 1) : plank(s, {0, -20.5}, 1, 1, 1000, {3, 0});
      joints.push_back(s.join(between(type, last, next, {0, k == 0 ? 0.0 : -0.5}, {0, 0.5})));
      last = next;
    }
    double gap = 0;
    for (int frame = 0; frame < 300; ++frame) {
      s.run(1);
      for (const JointId id : joints) {
        const JointState j = s.joint(id);
        gap = std::max(gap, std::hypot(j.anchor_b.x - j.anchor_a.x, j.anchor_b.y - j.anchor_a.y));
      }
    }
    EXPECT_LT(gap, 1e-3) << (type == JointType::weld ? "weld" : "pin");
  }
}

// A crank of 0.5 m at 10 rad/s, a rod of 1.5 m, a slider on the x axis.
TEST_P(Articulation, CrankAndSliderFollowTheClosedForm) {
  constexpr double kCrank = 0.5, kRod = 1.5, kOmega = 10;
  JointScene s = scene();
  BodyDesc turning;
  turning.type = BodyType::kinematic_body;
  turning.shape = DiscShape{0.1};
  turning.angular_velocity = kOmega;
  turning.filter.mask = 0;
  const BodyId crank = s.add(turning), guide = s.peg({0, 5});
  const BodyId rod = plank(s, {kCrank + kRod / 2, 0}, kRod, 0.1, 1), slider = plank(s, {kCrank + kRod, 0}, 0.2, 0.2, 1);
  s.join(between(JointType::revolute, crank, rod, {kCrank, 0}, {-kRod / 2, 0}));
  s.join(between(JointType::revolute, rod, slider, {kRod / 2, 0}));
  s.join(between(JointType::prismatic, guide, slider, {0, -5}));
  for (int frame = 1; frame <= 300; ++frame) {
    s.run(1);
    const double angle = kOmega * frame / 60, up = kCrank * std::sin(angle);
    ASSERT_NEAR(s.at(slider).x, kCrank * std::cos(angle) + std::sqrt(kRod * kRod - up * up), 1e-4 * kCrank);
  }
}

TEST_P(Articulation, WeldedCantileversAndTrussesDoNotSag) {
  JointScene s = scene();
  BodyId last = s.peg({0, 0});
  for (int k = 0; k < 10; ++k) {
    const BodyId next = plank(s, {0.5 + k, 0}, 1, 0.1, 1);
    s.join(between(JointType::weld, last, next, {k == 0 ? 0.0 : 0.5, 0}, {-0.5, 0}));
    last = next;
  }
  constexpr int kBays = 12;
  BodyId node[kBays + 1][2];
  for (int k = 0; k <= kBays; ++k) {
    node[k][0] = k == 0 || k == kBays ? s.peg({double(k), -5}) : plank(s, {double(k), -5}, 0.1, 0.1, 1);
    node[k][1] = plank(s, {double(k), -4}, 0.1, 0.1, 1);
    s.join(between(JointType::distance, node[k][0], node[k][1]));
    if (k == 0) continue;
    s.join(between(JointType::distance, node[k - 1][1], node[k][1]));
    s.join(between(JointType::distance, node[k - 1][0], node[k][0]));
    const bool left = 2 * k <= kBays;
    s.join(between(JointType::distance, node[k - 1][left ? 0 : 1], node[k][left ? 1 : 0]));
  }
  s.run(300);
  EXPECT_NEAR(s.at(last).y, 0, 1e-4);
  EXPECT_NEAR(s.at(node[kBays / 2][0]).y, -5, 1e-4);
}

// A tree that nothing holds.
TEST_P(Articulation, ATreeInSpaceKeepsMomentumAndEnergy) {
  JointScene s = scene({0, 0});
  std::vector<BodyId> bodies{plank(s, {0, 0}, 1, 0.2, 1, {1, 0.5}, 3)};
  for (int k = 1; k < 7; ++k) {
    const BodyId next = plank(s, {1.2 * (k % 3), 1.1 * (k / 3)}, 0.8, 0.2, 0.5 + 0.3 * k, {0.2 * k, -0.3}, 1 - k);
    s.join(between(k % 2 == 0 ? JointType::revolute : JointType::distance, bodies[(k - 1) / 2], next, {0.4, 0},
                   {-0.4, 0.05}));
    bodies.push_back(next);
  }
  s.run(60);  // joints pull together what was put apart
  const auto sums = [&] {
    std::array<double, 3> sum{};
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const BodyState b = s.at(bodies[k]);
      const double width = k == 0 ? 1 : 0.8, m = k == 0 ? 1 : 0.5 + 0.3 * static_cast<double>(k);
      sum[0] += m * b.vx;
      sum[1] += m * b.vy;
      sum[2] += m * (b.x * b.vy - b.y * b.vx) + m * (width * width + 0.04) / 12 * b.omega;
    }
    return sum;
  };
  const auto start = sums();
  double least = energy(s);
  for (int frame = 0; frame < 600; ++frame) {
    s.run(1);
    const double now = energy(s);
    ASSERT_LT(now, least * (GetParam() == 1 ? 1.02 : 1.002)) << "frame " << frame;
    least = std::min(least, now);
  }
  const auto end = sums();
  for (const int k : {0, 1, 2}) EXPECT_NEAR(end[k], start[k], 2e-4 * (1 + std::abs(start[2]))) << k;
}

}  // namespace
}  // namespace psim::test
