// Which joints a cut goes through, and what becomes of a net from which they are taken.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "joint_support.h"
#include "psim/debug_draw.h"
#include "psim/scene.h"

namespace psim::test {
namespace {

// A net of 20 x 20 nodes, 0.2 m apart, whose top row is held.
std::unique_ptr<World> curtain(JointType type, Isa isa = best_isa()) {
  psim::Scene scene;
  scene.world.gravity = {0, -kG};
  scene.world.sleeping = false;
  GroupDesc net;
  net.count = 400;
  net.region = {0, 0, 4, 4};
  net.radius_min = net.radius_max = 0.06;
  net.body.mass = 0.05;
  net.links = LinkDesc{.type = type, .stiffness = type == JointType::spring ? 5e3 : 0, .pin = Pin::top};
  scene.groups.push_back(net);
  std::string error;
  RunOptions options;
  options.isa = isa;
  std::unique_ptr<World> world = build_world(scene, options, error);
  EXPECT_NE(world, nullptr) << error;
  return world;
}

// The lines that debug_draw draws of joints.
struct JointLines : DebugDraw {
  void circle(Vec2, double, double, DrawKind, BodyId) override {}
  void polygon(std::span<const Vec2>, double, DrawKind, BodyId) override {}
  void point(Vec2, DrawKind) override {}
  void line(Vec2 from, Vec2 to, DrawKind kind) override {
    if (kind == DrawKind::joint) all.emplace_back(from, to);
  }
  std::vector<std::pair<Vec2, Vec2>> all;
};

// Whether two lines meet, and not closely: by solving for the point.
bool lines_meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d, bool& close) {
  const Vec2 u{b.x - a.x, b.y - a.y}, v{d.x - c.x, d.y - c.y}, w{c.x - a.x, c.y - a.y};
  const double area = u.x * v.y - u.y * v.x;
  const double s = (w.x * v.y - w.y * v.x) / area, t = (w.x * u.y - w.y * u.x) / area;
  const double edge = std::min({std::fabs(s), std::fabs(1 - s), std::fabs(t), std::fabs(1 - t)});
  close = !(edge > 1e-9) || !(std::fabs(area) > 1e-9);
  return s >= 0 && s <= 1 && t >= 0 && t <= 1;
}

TEST(Cutting, GoesThroughTheJointsWhoseLinesItCrosses) {
  Random r(3);
  std::size_t cut = 0, missed = 0;
  for (int round = 0; round < 40; ++round) {
    WorldDesc desc;
    desc.bounds = {-20, -20, 20, 20};
    std::string error;
    const auto world = World::create(desc, {}, error);
    ASSERT_NE(world, nullptr) << error;
    std::vector<BodyId> bodies;
    for (int k = 0; k < 12; ++k) {
      BodyDesc body;
      body.shape = DiscShape{0.1};
      body.position = {r.uniform(-8, 8), r.uniform(-8, 8)};
      bodies.push_back(world->add_body(body, error));
      ASSERT_NE(bodies.back(), kNoBody) << error;
    }
    for (int k = 0; k < 10; ++k) {
      JointDesc joint;
      const JointType types[] = {JointType::distance, JointType::spring, JointType::rope,   JointType::revolute,
                                 JointType::weld,     JointType::wheel,  JointType::pulley, JointType::filter};
      joint.type = types[r.below(8)];
      joint.a = bodies[r.below(12)];
      joint.b = r.chance(0.2) && joint.type != JointType::filter && joint.type != JointType::pulley
                    ? kWorldBody
                    : bodies[r.below(12)];
      joint.anchor_a = {r.uniform(-1, 1), r.uniform(-1, 1)};
      joint.anchor_b = {r.uniform(-1, 1), r.uniform(-1, 1)};
      joint.stiffness = joint.type == JointType::spring ? 10 : 0;
      joint.ground_a = {-5, 9};
      joint.ground_b = {5, 9};
      world->add_joint(joint, error);  // some of them join a body to itself and are refused
    }
    for (int k = 0; k < 20; ++k) {
      const Vec2 from{r.uniform(-9, 9), r.uniform(-9, 9)}, to{r.uniform(-9, 9), r.uniform(-9, 9)};
      const std::vector<JointId> found = world->joints_across(from, to);
      std::size_t lines = 0, close_ones = 0;
      for (const JointId id : found) {
        ASSERT_TRUE(world->is_valid_joint(id));
        ASSERT_NE(world->joint(id)->type, JointType::filter);
      }
      JointLines all, rest;
      ASSERT_TRUE(world->debug_draw(all, {}));
      for (const auto& [a, b] : all.all) {
        bool close = false;
        lines += lines_meet(a, b, from, to, close);
        close_ones += close;
      }
      if (close_ones != 0) continue;
      EXPECT_EQ(lines != 0, !found.empty());
      cut += found.size();
      missed += found.empty();
      if (k != 19) continue;
      for (const JointId id : found) ASSERT_TRUE(world->remove_joint(id));
      EXPECT_TRUE(world->joints_across(from, to).empty());
      ASSERT_TRUE(world->debug_draw(rest, {}));
      for (const auto& [a, b] : rest.all) {
        bool close = false;
        EXPECT_FALSE(lines_meet(a, b, from, to, close)) << "a joint was not found";
      }
    }
  }
  EXPECT_GT(cut, 500u);
  EXPECT_GT(missed, 50u);
}

TEST(Cutting, FindsNothingForNumbersThatAreNone) {
  const auto world = curtain(JointType::distance);
  const double none = std::numeric_limits<double>::quiet_NaN(), end = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(world->joints_across({-1, 2.05}, {5, 2.05}).empty());
  EXPECT_TRUE(world->joints_across({none, 2.05}, {5, 2.05}).empty());
  EXPECT_TRUE(world->joints_across({-1, 2.05}, {5, end}).empty());
  EXPECT_TRUE(world->joints_across({-1, 8}, {5, 8}).empty());
  EXPECT_TRUE(world->joints_across({2, 2.05}, {2, 2.05}).empty()) << "a point beside all lines";
}

// What is cut off falls freely, and what is left bears no more than itself.
TEST(Cutting, TheLowerHalfOfACurtainFallsAndTheUpperOneStays) {
  for (const JointType type : {JointType::distance, JointType::rope, JointType::spring}) {
    const auto world = curtain(type);
    for (int frame = 0; frame < 120; ++frame) world->step();
    const double split = (world->body(world->id_of(9 * 20))->y + world->body(world->id_of(10 * 20))->y) / 2;
    const std::vector<JointId> cut = world->joints_across({-1, split}, {5, split});
    EXPECT_EQ(cut.size(), 20u);
    for (const JointId id : cut) ASSERT_TRUE(world->remove_joint(id));
    std::vector<double> height, speed;
    for (std::uint32_t k = 0; k < 400; ++k) {
      height.push_back(world->body(world->id_of(k))->y);
      speed.push_back(world->body(world->id_of(k))->vy);
    }
    double fallen = 0, at_first = 0, lowered = 0;
    for (int frame = 0; frame < 30; ++frame) world->step();
    for (std::uint32_t k = 0; k < 400; ++k) {
      const double down = height[k] - world->body(world->id_of(k))->y;
      if (height[k] < split) {
        fallen += down / 200;
        at_first += speed[k] / 200;
      } else {
        lowered = std::max(lowered, down);
      }
    }
    EXPECT_NEAR(fallen, kG * 0.25 / 2 - at_first * 0.5, 1e-3) << "its centre of mass falls freely";
    EXPECT_LT(lowered, 0.02);
  }
}

TEST(Cutting, GivesTheSameBitsEverywhere) {
  std::vector<std::uint64_t> hashes;
  for (const Isa isa : available_isas()) {
    const auto world = curtain(JointType::rope, isa);
    for (int frame = 0; frame < 60; ++frame) {
      world->step();
      if (frame != 20) continue;
      for (const JointId id : world->joints_across({-1, 1}, {5, 3.3})) ASSERT_TRUE(world->remove_joint(id));
    }
    EXPECT_LT(world->joint_count(), 740u);
    hashes.push_back(world->state_hash());
  }
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

}  // namespace
}  // namespace psim::test
