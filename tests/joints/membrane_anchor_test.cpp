// Rings of boards that are linked end to end: what is inside is bounded by links and boards in turn.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "joint_support.h"

namespace psim::test {
namespace {

constexpr int kBoards = 12;

// The area within the anchors, and the angular momentum about the origin.
struct Inside {
  double area = 0, spin = 0;
  Vec2 momentum;
};
Inside inside_of(const JointScene& s, const std::vector<BodyId>& boards, double inertia) {
  std::vector<Vec2> corners;
  Inside out;
  for (const BodyId id : boards) {
    const BodyState b = s.at(id);
    const Vec2 along{0.2 * std::cos(b.angle), 0.2 * std::sin(b.angle)};
    corners.push_back({b.x - along.x, b.y - along.y});
    corners.push_back({b.x + along.x, b.y + along.y});
    out.momentum = {out.momentum.x + b.vx, out.momentum.y + b.vy};
    out.spin += b.x * b.vy - b.y * b.vx + inertia * b.omega;
  }
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec2 p = corners[k], q = corners[(k + 1) % corners.size()];
    out.area += 0.5 * (p.x * q.y - p.y * q.x);
  }
  return out;
}

TEST(MembraneAnchors, ARingOfBoardsGrowsToItsAreaAndKeepsItsMomentum) {
  JointScene s = free_scene(4, {0, 0});
  std::vector<BodyId> boards;
  for (int k = 0; k < kBoards; ++k) {
    const double angle = 2 * std::acos(-1) * k / kBoards;
    BodyDesc d;
    d.shape = BoxShape{0.4, 0.1, 0};
    d.position = {std::cos(angle), 0.8 * std::sin(angle)};
    d.angle = angle + std::acos(-1) / 2;
    d.mass = 1;
    d.filter.mask = 0;
    boards.push_back(s.add(d));
  }
  const double inertia = (0.4 * 0.4 + 0.1 * 0.1) / 12;
  const double wanted = 1.1 * inside_of(s, boards, inertia).area;
  for (int k = 0; k < kBoards; ++k) {
    JointDesc d = between(JointType::spring, boards[static_cast<std::size_t>(k)],
                          boards[static_cast<std::size_t>((k + 1) % kBoards)], {0.2, 0}, {-0.2, 0});
    d.stiffness = 20, d.damping = 1;
    d.area = wanted / kBoards;
    s.join(d);
  }
  for (int frame = 0; frame < 600; ++frame) {
    s.world->step();
    const Inside now = inside_of(s, boards, inertia);
    ASSERT_NEAR(now.momentum.x, 0, 1e-4) << frame;
    ASSERT_NEAR(now.momentum.y, 0, 1e-4) << frame;
    ASSERT_NEAR(now.spin, 0, 5e-3) << frame;
  }
  EXPECT_NEAR(inside_of(s, boards, inertia).area / wanted, 1, 5e-3);
}

}  // namespace
}  // namespace psim::test
