// Nets and ropes that tear: a link goes once it bears more than `break_force`, and what is left moves on as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "joint_support.h"
#include "psim/scene.h"

namespace psim::test {
namespace {

constexpr double kNode = 0.05;  // kg

// A net of columns x rows nodes, 0.2 m apart, whose top row is held.
psim::Scene hanging(std::uint64_t columns, std::uint64_t rows, JointType type, double break_force) {
  psim::Scene scene;
  scene.world.gravity = {0, -kG};
  scene.world.sleeping = false;
  GroupDesc net;
  net.count = columns * rows;
  net.region = {0, 0, 0.2 * static_cast<double>(columns), 0.2 * static_cast<double>(rows)};
  net.radius_min = net.radius_max = 0.06;
  net.body.mass = kNode;
  net.links = LinkDesc{.type = type, .pin = Pin::top, .break_force = break_force};
  scene.groups.push_back(net);
  return scene;
}

std::unique_ptr<World> made(const psim::Scene& scene, const RunOptions& options = {}) {
  std::string error;
  std::unique_ptr<World> world = build_world(scene, options, error);
  EXPECT_NE(world, nullptr) << error;
  return world;
}

std::size_t broken_in(World& world, int frames) {
  std::size_t broken = 0;
  for (int frame = 0; frame < frames; ++frame) {
    world.step();
    broken += world.events().breaks.size();
  }
  return broken;
}

// The top link of a column bears what hangs on it.
TEST(Tearing, ALinkHoldsALessLoadThanItsBreakForceAndGoesUnderAGreaterOne) {
  for (const JointType type : {JointType::distance, JointType::rope}) {
    for (const std::uint64_t columns : {1u, 20u}) {
      const double load = 24 * kNode * kG;
      const auto whole = made(hanging(columns, 25, type, load / 0.95));
      EXPECT_EQ(broken_in(*whole, 240), 0u) << columns << " columns";
      const auto torn = made(hanging(columns, 25, type, load / 1.05));
      EXPECT_GE(broken_in(*torn, 240), columns) << columns << " columns";
    }
  }
}

psim::Scene shot_at() {
  psim::Scene scene = hanging(20, 40, JointType::distance, 60);
  BodyDesc ball;
  ball.shape = DiscShape{0.5};
  ball.mass = 20;
  ball.position = {-2, 4};
  ball.velocity = {25, 0};
  scene.bodies.push_back(ball);
  return scene;
}

// All of its links bear the same load. All of them went at once before, and the rope was shattered.
TEST(Tearing, ARopeThatIsPulledBreaksInOnePlace) {
  constexpr int kLinks = 20;
  JointScene s = free_scene(4, {0, 0});
  std::vector<BodyId> nodes;
  for (int k = 0; k <= kLinks; ++k) nodes.push_back(ghost(s, {0.2 * k, 0}, kNode));
  for (int k = 0; k < kLinks; ++k) {
    JointDesc link =
        between(JointType::distance, nodes[static_cast<std::size_t>(k)], nodes[static_cast<std::size_t>(k) + 1]);
    link.break_force = 100;
    s.join(link);
  }
  std::vector<JointBreak> told;
  for (int frame = 0; frame < 30; ++frame) {
    s.world->apply_force(nodes.front(), {-113.5, 0});
    s.world->apply_force(nodes.back(), {113.5, 0});
    s.run(1);
    const auto breaks = s.world->events().breaks;
    told.insert(told.end(), breaks.begin(), breaks.end());
    if (!told.empty()) break;
  }
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NEAR(std::fabs(told[0].force.x), 113.5, 1);
  EXPECT_EQ(s.world->joint_count(), kLinks - 1u);
}

TEST(Tearing, ABallTearsAHoleIntoANet) {
  const auto world = made(shot_at());
  const auto energy = [&] {
    const Diagnostics d = world->diagnostics();
    return d.kinetic + d.potential;
  };
  const std::size_t links = world->joint_count();
  const double start = energy();
  std::size_t broken = 0;
  for (int second = 0; second < 4; ++second) {
    broken += broken_in(*world, 60);
    EXPECT_LT(energy() - start, 1e-3 * start) << "second " << second;
  }
  EXPECT_EQ(world->joint_count(), links - broken);
  EXPECT_GT(broken, 10u);
  EXPECT_LT(broken, links / 2);
  EXPECT_GT(world->body(world->id_of(0))->x, 8);  // the ball went through
}

TEST(Tearing, GivesTheSameBitsOnAllThreadsAndAfterASave) {
  const auto one = made(shot_at(), {.threads = 1}), four = made(shot_at(), {.threads = 4});
  std::unique_ptr<World> resumed;
  std::size_t broken = 0;
  for (int frame = 0; frame < 90; ++frame) {
    one->step(), four->step();
    broken += one->events().breaks.size();
    ASSERT_EQ(one->state_hash(), four->state_hash()) << "frame " << frame;
    if (resumed) {
      resumed->step();
      ASSERT_EQ(one->state_hash(), resumed->state_hash()) << "frame " << frame;
    }
    if (resumed || broken == 0) continue;
    std::vector<std::byte> saved;
    std::string error;
    four->save(saved);
    resumed = made(shot_at(), {.threads = 2});
    ASSERT_TRUE(resumed->restore(saved, error)) << error;
  }
  EXPECT_TRUE(resumed);
}

// A ring of n rods that turns at omega: two rods, each at an angle of pi/n to the tangent, hold m omega^2 R of a body.
TEST(Tearing, ARingThatTurnsBurstsWhereItsLoadIsTooLarge) {
  constexpr int kCount = 24;
  const double mass = kNode, omega = 5, radius = 2;
  const double tension = mass * omega * omega * radius / (2 * std::sin(std::acos(-1) / kCount));
  for (const double share : {0.95, 1.05}) {
    psim::Scene scene;
    scene.world.gravity = {0, 0};
    scene.world.sleeping = false;
    GroupDesc ring;
    ring.layout = Layout::ring;
    ring.count = kCount;
    ring.region = {-radius, -radius, radius, radius};
    ring.radius_min = ring.radius_max = 0.05;
    ring.body.mass = mass;
    ring.links = LinkDesc{.break_force = tension / share};
    scene.groups.push_back(ring);
    const auto world = made(scene);
    for (std::uint32_t k = 0; k < kCount; ++k) {
      const BodyId id = world->id_of(k);
      const BodyState at = world->body(id).value();
      world->set_velocity(id, {-omega * at.y, omega * at.x}, 0);
    }
    EXPECT_EQ(broken_in(*world, 120) > 0, share > 1) << share;
  }
}

}  // namespace
}  // namespace psim::test
