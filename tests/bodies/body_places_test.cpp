// Where the parts of bodies are, how fast their points move, what joints they have; bodies that go in bulk.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "joint_support.h"
#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// A world of bodies of all types and shapes that move.
std::unique_ptr<World> crowd(Random& r) {
  auto world = make(walled({-20, 0, 20, 40}, {0, -kG}, kGrip));
  for (int k = 0; k < 80; ++k) {
    BodyDesc body = body_of_any_shape(r, {-18 + 2.4 * (k % 16), 2 + 2.4 * (k / 16)});
    if (k % 7 == 0) body.type = BodyType::static_body;
    if (k % 7 == 1) body.type = BodyType::kinematic_body;
    if (k % 11 == 0) body.enabled = false;
    if (k % 7 == 0 && k % 2 == 0) body.shape = ChainShape{{{-0.5, 0}, {0, 0.4}, {0.5, -0.1}}};
    if (body.type != BodyType::static_body) {
      body.velocity = {r.uniform(-2, 2), r.uniform(-2, 2)};
      body.angular_velocity = r.uniform(-3, 3);
    }
    add(*world, body);
  }
  return world;
}

// The box touches the body on all four sides and nothing of the body lies beyond: thin strips along its sides tell.
TEST(BodyPlaces, BoundsAreTight) {
  Random r(2);
  auto world = crowd(r);
  for (int frame = 0; frame < 60; frame += 20) {
    for (std::uint32_t k = 0; k < 80; ++k) {
      const BodyId id = world->id_of(k);
      const Bounds b = world->bounds_of(id).value();
      const BodyState s = state(*world, id);
      EXPECT_LT(b.xmin, b.xmax);
      if (s.type == BodyType::dynamic_body) {
        const Vec2 c = world->centre_of_mass(id).value();
        EXPECT_LE(b.xmax - b.xmin, 2 * s.radius * (1 + 1e-6));
        EXPECT_TRUE(c.x > b.xmin && c.x < b.xmax && c.y > b.ymin && c.y < b.ymax);
      }
      if (!world->is_enabled(id)) continue;
      const auto finds = [&](const Bounds& strip) {
        const auto found = world->in_region(strip);
        return std::ranges::find(found, id) != found.end();
      };
      constexpr double kIn = 1e-5, kOut = 1e-5;
      EXPECT_TRUE(finds({b.xmin - 1, b.ymin - 1, b.xmin + kIn, b.ymax + 1})) << k;
      EXPECT_TRUE(finds({b.xmax - kIn, b.ymin - 1, b.xmax + 1, b.ymax + 1})) << k;
      EXPECT_TRUE(finds({b.xmin - 1, b.ymin - 1, b.xmax + 1, b.ymin + kIn})) << k;
      EXPECT_TRUE(finds({b.xmin - 1, b.ymax - kIn, b.xmax + 1, b.ymax + 1})) << k;
      EXPECT_FALSE(finds({b.xmin - 1, b.ymin - 1, b.xmin - kOut, b.ymax + 1})) << k;
      EXPECT_FALSE(finds({b.xmax + kOut, b.ymin - 1, b.xmax + 1, b.ymax + 1})) << k;
      EXPECT_FALSE(finds({b.xmin - 1, b.ymin - 1, b.xmax + 1, b.ymin - kOut})) << k;
      EXPECT_FALSE(finds({b.xmin - 1, b.ymax + kOut, b.xmax + 1, b.ymax + 1})) << k;
    }
    for (int k = 0; k < 20; ++k) world->step();
  }
}

// A free body's points go where their velocities lead, and its centre of mass falls as gravity wills.
TEST(BodyPlaces, VelocitiesAreWaysOverTime) {
  Random r(9);
  auto world = make(unbounded(500, {0, 0}));
  for (int k = 0; k < 40; ++k) {
    BodyDesc body = body_of_any_shape(r, {-100 + 5.0 * k, 0});
    if (k % 4 == 3) body.type = BodyType::kinematic_body;
    body.velocity = {r.uniform(-2, 2), r.uniform(-2, 2)};
    body.angular_velocity = r.uniform(-3, 3);
    add(*world, body);
  }
  const double dt = 1e-5;
  for (std::uint32_t k = 0; k < 40; ++k) {
    const BodyId id = world->id_of(k);
    const Vec2 arm{r.uniform(-1, 1), r.uniform(-1, 1)};
    const auto point = [&] {
      const BodyState s = state(*world, id);
      const double c = std::cos(s.angle), n = std::sin(s.angle);
      return Vec2{s.x + c * arm.x - n * arm.y, s.y + n * arm.x + c * arm.y};
    };
    const Vec2 before = point(), centre = world->centre_of_mass(id).value();
    const Vec2 v = world->velocity_at(id, before).value(), vc = world->velocity_at(id, centre).value();
    world->step(dt);
    const Vec2 after = point(), moved = world->centre_of_mass(id).value();
    EXPECT_NEAR((after.x - before.x) / dt, v.x, 0.02) << k;
    EXPECT_NEAR((after.y - before.y) / dt, v.y, 0.02) << k;
    EXPECT_NEAR((moved.x - centre.x) / dt, vc.x, 0.02) << k;
    EXPECT_NEAR((moved.y - centre.y) / dt, vc.y, 0.02) << k;
  }
}

TEST(BodyPlaces, AreNothingForWhoIsGone) {
  auto world = make(unbounded(100));
  const BodyId id = add(*world, disc({}));
  ASSERT_TRUE(world->remove_body(id));
  EXPECT_FALSE(world->bounds_of(id).has_value());
  EXPECT_FALSE(world->centre_of_mass(id).has_value());
  EXPECT_FALSE(world->velocity_at(id, {}).has_value());
  EXPECT_TRUE(world->joints_of(id).empty());
}

TEST(BodyPlaces, JointsAreThoseThatNameTheBody) {
  Random r(5);
  auto world = make(unbounded(100));
  std::vector<BodyId> ids;
  for (int k = 0; k < 10; ++k) ids.push_back(add(*world, disc({3.0 * k, 0})));
  std::vector<JointId> all;
  std::string error;
  for (int k = 0; k < 40; ++k) {
    JointDesc d;
    d.a = r.chance(0.2) ? kWorldBody : ids[r.below(10)];
    d.b = ids[r.below(10)];
    if (d.a == d.b) continue;
    const JointId id = world->add_joint(d, error);
    ASSERT_NE(id, kNoJoint) << error;
    all.push_back(id);
    if (k % 5 == 4) world->remove_joint(all[r.below(all.size())]);
  }
  for (const BodyId id : ids) {
    std::vector<JointId> want;
    for (const JointId joint : all) {
      const auto s = world->joint(joint);
      if (s && (s->a == id || s->b == id)) want.push_back(joint);
    }
    std::ranges::sort(want, {}, &JointId::index);
    EXPECT_EQ(world->joints_of(id), want);
  }
}

// Bodies that go at once leave the world as those do that go one by one. Only those that sleep do not wake each other, and
// what leans on those.
TEST(RemoveBodies, IsAsOneByOne) {
  for (const bool asleep : {false, true}) {
    Random first(4), second(4);
    auto one = crowd(first), bulk = crowd(second);
    for (int k = 0; k < (asleep ? 900 : 40); ++k) {
      one->step();
      bulk->step();
    }
    Random r(6);
    std::vector<BodyId> ids;
    for (int k = 0; k < 60; ++k) ids.push_back(one->id_of(static_cast<std::uint32_t>(r.below(80))));
    ids.push_back({500, 0});
    std::size_t removed = 0;
    for (const BodyId id : ids) removed += one->remove_body(id);
    EXPECT_EQ(bulk->remove_bodies(ids), removed);
    EXPECT_EQ(one->body_count(), bulk->body_count());
    int woke = 0;
    for (std::uint32_t k = 0; k < 80; ++k) {
      const BodyId id = bulk->id_of(k);
      EXPECT_EQ(id, one->id_of(k));
      woke += bulk->is_awake(id);
      EXPECT_TRUE(one->is_awake(id) || !bulk->is_awake(id)) << k;
    }
    EXPECT_GT(woke, 0);
    for (int k = 0; k < 60; ++k) {
      one->step();
      bulk->step();
      ASSERT_TRUE(asleep || one->state_hash() == bulk->state_hash()) << k;
    }
    EXPECT_EQ(bulk->remove_bodies(ids), 0u) << "they are gone";
  }
}

TEST(RemoveBodies, IsReplayed) {
  Random r(4);
  auto world = crowd(r);
  Recorder recorder(*world, 1);
  std::vector<BodyId> ids;
  for (std::uint32_t k = 0; k < 40; ++k) ids.push_back(world->id_of(2 * k));
  for (int k = 0; k < 10; ++k) recorder.step();
  EXPECT_EQ(recorder.remove_bodies(ids), 40u);
  for (int k = 0; k < 10; ++k) recorder.step();
  std::string error;
  auto replay = Replay::open(recorder.recording(), RunOptions{}, error);
  ASSERT_TRUE(replay) << error;
  while (replay->next()) {
  }
  EXPECT_TRUE(replay->complete());
  EXPECT_EQ(replay->differs_at(), 0u);
}

}  // namespace
}  // namespace psim::test
