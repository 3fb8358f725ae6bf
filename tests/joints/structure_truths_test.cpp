// Structures whose joints bear a load, against closed forms: the pull of a chain at its ends, a soft cantilever.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "joint_support.h"

namespace psim::test {
namespace {

constexpr int kChainLinks = 40;
constexpr double kChainSpan = 1, kChainLength = 1.2, kChainMass = 1.2;  // m, m, kg: 1 kg a metre

struct HangingChain {
  double pull = 0;  // level, at its end, by the weight of a metre
  double sag = 0;   // m
};

// Hangs up a chain of masses, half a mass at each peg. `stretch`: EA over the weight of the chain; 0: its links are rods.
HangingChain hang_chain(double stretch) {
  constexpr double kLink = kChainLength / kChainLinks, kHalf = kChainSpan / 2;
  WorldDesc desc;
  desc.sleeping = false;
  JointScene s(desc);
  const double deep = std::sqrt(kChainLength * kChainLength / 4 - kHalf * kHalf);
  std::vector<BodyId> nodes;
  JointId first{};
  for (int k = 0; k <= kChainLinks; ++k) {  // a V, taut
    const double along = 2.0 * k / kChainLinks;
    const Vec2 at{kHalf * (along - 1), -deep * std::min(along, 2 - along)};
    nodes.push_back(k == 0 || k == kChainLinks ? s.peg(at) : ghost(s, at, kChainMass / kChainLinks, 0.005));
    if (k == 0) continue;
    JointDesc link =
        between(stretch > 0 ? JointType::spring : JointType::distance, nodes[nodes.size() - 2], nodes.back());
    link.length = kLink;
    if (stretch > 0) link.stiffness = stretch * kChainMass * kG / kLink;
    const JointId id = s.join(link);
    if (k == 1) first = id;
  }
  for (int frame = 0; frame < 900; ++frame) {
    s.run(1);
    for (std::size_t k = 1; k < kChainLinks; ++k) {
      const BodyState b = s.at(nodes[k]);
      s.world->set_velocity(nodes[k], {0.95 * b.vx, 0.95 * b.vy}, 0);
    }
  }
  HangingChain mean;
  for (int frame = 0; frame < 60; ++frame) {
    s.run(1);
    mean.pull += std::fabs(s.joint(first).force.x) / kG / 60;
    mean.sag -= s.at(nodes[kChainLinks / 2]).y / 60;
  }
  return mean;
}

// Catenaries, stiff and elastic (Irvine 1981). The chain of 40 links itself pulls 0.02 % less.
TEST(JointTruths, AChainPullsAtItsEndsAsACatenary) {
  struct Catenary {
    double stretch, pull, sag;
  };
  for (const Catenary& exact : {Catenary{0, 0.469542, 0.292344}, {10, 0.405121, 0.333842}, {100, 0.461352, 0.297014}}) {
    const HangingChain chain = hang_chain(exact.stretch);
    EXPECT_NEAR(chain.pull / exact.pull, 1, 1e-3) << exact.stretch;
    EXPECT_NEAR(chain.sag / exact.sag, 1, 1e-3) << exact.stretch;
  }
}

// Cantilevers of welds with a weight at the tip are the elastica: how far the tip drops and comes nearer by P L^2 / EI. The weld
// at the wall is that of half a link. Only the tip has a weight.
TEST(JointTruths, ACantileverOfSoftWeldsIsTheElastica) {
  constexpr int kLinks = 20;
  constexpr double kLink = 1.0 / kLinks, kLinkMass = 0.01;
  struct Elastica {
    double load, drop, shortening;
  };
  for (const Elastica& exact :
       {Elastica{1, 0.301721, 0.056433}, {2, 0.493457, 0.160642}, {5, 0.713792, 0.387628}, {10, 0.810609, 0.554996}}) {
    WorldDesc desc;
    desc.sleeping = false;
    desc.linear_damping = 2;
    JointScene s(desc);
    BodyId before = s.peg({0, 0});
    for (int k = 0; k < kLinks; ++k) {
      BodyDesc board;
      board.shape = BoxShape{kLink, 0.02};
      board.position = {(k + 0.5) * kLink, 0};
      board.mass = kLinkMass;
      board.gravity_scale = 0;
      board.filter.mask = 0;
      const BodyId link = s.add(board);
      JointDesc weld = between(JointType::weld, before, link);
      weld.anchor_a = {k > 0 ? kLink / 2 : 0, 0};
      weld.anchor_b = {-kLink / 2, 0};
      weld.stiffness = kG / exact.load / (k > 0 ? kLink : kLink / 2);
      weld.damping = 0.02 * weld.stiffness;
      s.join(weld);
      before = link;
    }
    const BodyId tip = ghost(s, {1, 0}, 1);
    JointDesc pin = between(JointType::revolute, before, tip);
    pin.anchor_a = {kLink / 2, 0};
    s.join(pin);
    s.run(1200);
    EXPECT_NEAR(-s.at(tip).y, exact.drop, 1.5e-3) << exact.load;
    EXPECT_NEAR(1 - s.at(tip).x, exact.shortening, 1e-3) << exact.load;
  }
}

}  // namespace
}  // namespace psim::test
