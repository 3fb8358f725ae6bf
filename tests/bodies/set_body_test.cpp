// Bodies that get another type, shape or place while the world runs.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "joint_support.h"
#include "psim/recording.h"
#include "rigid_support.h"
#include "saved_support.h"

namespace psim::test {
namespace {

BodyDesc some_body(Random& r, Vec2 at, bool dynamic_only = false) {
  const std::size_t kind = r.below(6);
  BodyDesc body = disc(at, {}, r.uniform(0.2, 0.5));
  if (kind == 1) body.shape = BoxShape{r.uniform(0.3, 0.9), r.uniform(0.3, 0.9)};
  if (kind == 2) body.shape = CompoundShape{{{BoxShape{0.8, 0.2}}, {DiscShape{0.2}, {0.4, 0}}}};
  if (kind == 3) body.shape = CapsuleShape{{-0.3, 0}, {0.3, 0.1}, 0.15};
  body.angle = r.uniform(-3, 3);
  body.material = material(r.chance(0.3) ? 0.5 : 0, r.uniform(0, 1));
  const std::size_t type = dynamic_only ? 9 : r.below(8);
  if (type < 2) {
    body.type = BodyType::static_body;
    if (kind == 4) body.shape = SegmentShape{{-0.4, 0}, {0.4, 0.1}};
    if (kind == 5) body.shape = ChainShape{{{-0.5, 0}, {0, 0.2}, {0.5, 0}}};
    return body;
  }
  if (type == 2) body.type = BodyType::kinematic_body;
  body.velocity = {r.uniform(-2, 2), r.uniform(-2, 2)};
  body.angular_velocity = r.uniform(-3, 3);
  if (type == 2) return body;
  if (r.chance(0.2)) body.linear_damping = r.uniform(0, 3);
  if (r.chance(0.2)) body.locks = {r.chance(0.5), r.chance(0.5), r.chance(0.5)};
  if (r.chance(0.2)) body.bullet = true;
  if (r.chance(0.3)) body.user_data = r.below(1000);
  return body;
}

void expect_same(World& made, World& changed, std::uint32_t bodies, double within) {
  for (std::uint32_t k = 0; k < bodies; ++k) {
    const BodyId id = made.id_of(k);
    ASSERT_EQ(id, changed.id_of(k));
    const BodyState a = state(made, id), b = state(changed, id);
    EXPECT_EQ(a.type, b.type) << k;
    EXPECT_EQ(a.radius, b.radius) << k;
    EXPECT_NEAR(a.x, b.x, within) << k;
    EXPECT_NEAR(a.y, b.y, within) << k;
    EXPECT_NEAR(a.angle, b.angle, within) << k;
    EXPECT_NEAR(a.vx, b.vx, 60 * within) << k;
    EXPECT_EQ(made.user_data(id), changed.user_data(id)) << k;
    EXPECT_EQ(made.traits(id).value(), changed.traits(id).value()) << k;
  }
}

// A body that was changed to another one is as that one, whatever it was before, and whether the world ran before.
TEST(SetBody, ChangedIsAsMade) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    WorldDesc desc = walled({-12, 0, 12, 24}, {0, -kG});
    auto made = make(desc), changed = make(desc);
    std::string error;
    for (std::uint32_t k = 0; k < 60; ++k) {
      Random r(1000 * seed + k), other(7000 * seed + k);
      const Vec2 at{-10.5 + 2.3 * (k % 10), 2 + 2.3 * (k / 10)};
      const BodyDesc wanted = some_body(r, at);
      BodyDesc before = some_body(other, at);
      if (seed % 2 != 0) before.position = {-at.x, 24 - at.y};
      const BodyId id = add(*changed, before);
      if (seed % 3 == 2 && k == 30) changed->step();
      ASSERT_EQ(id, add(*made, wanted));
      const bool later = seed % 3 == 2;
      ASSERT_TRUE(later || changed->set_body(id, wanted, error)) << error;
    }
    for (std::uint32_t k = 0; seed % 3 == 2 && k < 60; ++k) {
      Random r(1000 * seed + k);
      const Vec2 at{-10.5 + 2.3 * (k % 10), 2 + 2.3 * (k / 10)};
      ASSERT_TRUE(changed->set_body(changed->id_of(k), some_body(r, at), error)) << error;
    }
    EXPECT_EQ(made->static_count(), changed->static_count());
    EXPECT_EQ(made->shape_count(), changed->shape_count());
    expect_same(*made, *changed, 60, 1e-9);
    for (int k = 0; k < 10; ++k) {
      made->step();
      changed->step();
    }
    expect_same(*made, *changed, 60, 1e-4);
    expect_resumes(*changed, 5, "with changed bodies");
  }
}

// Changing at random loses nothing: counts, memory and results stay those of a world that was saved and restored.
TEST(SetBody, ManyTimes) {
  for (const bool events : {false, true}) {
    Random r(11);
    auto world = make(walled({-12, 0, 12, 24}, {0, -kG}, kGrip), best_isa(), 2);
    if (events) world->set_event_options({true, true, 1, true, true, true});
    for (int k = 0; k < 80; ++k) add(*world, some_body(r, {-11 + 2.0 * (k % 11), 1 + 2.3 * (k / 11)}));
    std::string error;
    for (int frame = 0; frame < 300; ++frame) {
      for (int n = 0; n < 3; ++n) {
        const BodyId id = world->id_of(static_cast<std::uint32_t>(r.below(80)));
        const BodyState s = state(*world, id);
        BodyDesc to = some_body(r, {std::clamp(s.x, -11.0, 11.0), std::clamp(s.y, 1.0, 23.0)});
        to.enabled = !r.chance(0.1);
        ASSERT_TRUE(world->set_body(id, to, error)) << error;
        EXPECT_EQ(state(*world, id).type, to.type);
        EXPECT_EQ(world->is_enabled(id), to.enabled);
      }
      world->step();
      if (frame % 60 == 30) expect_resumes(*world, 3, "with changed bodies");
    }
    EXPECT_EQ(world->body_count(), 80u);
  }
}

// A floor that goes away lets go what slept on it; a floor that comes wakes what it comes upon.
TEST(SetBody, MovesWhatIsStatic) {
  auto world = make(unbounded(100));
  BodyDesc floor = fixed(box({0, -0.5}, 4, 1, kGrip));
  const BodyId id = add(*world, floor);
  add(*world, fixed(box({20, -0.5}, 4, 1, kGrip)));
  const BodyId on = add(*world, box({0, 0.5}, 1, 1, kGrip)), there = add(*world, box({20, 0.5}, 1, 1, kGrip));
  for (int k = 0; k < 300; ++k) world->step();
  ASSERT_FALSE(world->is_awake(on));
  ASSERT_FALSE(world->is_awake(there));
  floor.position = {20.7, 0.6};
  floor.shape = BoxShape{1, 1};
  std::string error;
  ASSERT_TRUE(world->set_body(id, floor, error)) << error;
  EXPECT_TRUE(world->is_awake(on));
  EXPECT_TRUE(world->is_awake(there));
  EXPECT_FALSE(world->ray_cast({0, -5}, {0, -0.05}).has_value());
  EXPECT_EQ(world->ray_cast({20.7, 5}, {20.7, 1.05})->body, id);
  EXPECT_EQ(state(*world, id).x, 20.7);
  for (int k = 0; k < 120; ++k) world->step();
  EXPECT_LT(state(*world, on).y, -0.5);
  EXPECT_LT(state(*world, there).x, 19.75) << "it was pushed out";
}

TEST(SetBody, ChangesTheType) {
  auto world = make(unbounded(100));
  BodyDesc body = box({0, 5});
  const BodyId id = add(*world, body);
  std::string error;
  for (const BodyType type : {BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body,
                              BodyType::static_body, BodyType::dynamic_body, BodyType::kinematic_body}) {
    body.type = type;
    body.velocity = {type == BodyType::static_body ? 0.0 : 1.0, 0};
    ASSERT_TRUE(world->set_body(id, body, error)) << error;
    for (int k = 0; k < 30; ++k) world->step();
    const BodyState s = state(*world, id);
    EXPECT_NEAR(s.x, type == BodyType::static_body ? 0 : 0.5, 1e-6);
    EXPECT_NEAR(s.y, type == BodyType::dynamic_body ? 5 - kG / 8 : 5, 0.02);
    EXPECT_EQ(world->static_count(), type == BodyType::static_body ? 1u : 0u);
  }
}

// A pendulum whose bob gets another shape goes on about its pin; between two static bodies the joint does nothing, and
// holds again when one of them moves.
TEST(SetBody, KeepsItsJoints) {
  auto world = make(unbounded(100));
  BodyDesc bob = disc({2, 0});
  const BodyId post = add(*world, fixed(box({0, 0}, 0.2, 0.2))), id = add(*world, bob);
  JointDesc pin;
  pin.type = JointType::revolute;
  pin.a = post, pin.b = id, pin.anchor_b = {-2, 0};
  std::string error;
  const JointId joint = world->add_joint(pin, error);
  ASSERT_NE(joint, kNoJoint) << error;
  const auto holds = [&](int frames) {
    double most = 0;
    for (int k = 0; k < frames; ++k) {
      world->step();
      const BodyState s = state(*world, id);
      const Vec2 at{s.x - 2 * std::cos(s.angle), s.y - 2 * std::sin(s.angle)};
      most = std::max(most, std::hypot(at.x, at.y));
    }
    return most;
  };
  EXPECT_LT(holds(30), 1e-3);
  const auto change = [&](const Shape& shape, BodyType type) {
    const BodyState s = state(*world, id);
    bob.shape = shape, bob.type = type;
    bob.position = {s.x, s.y}, bob.angle = s.angle, bob.velocity = {}, bob.angular_velocity = 0;
    ASSERT_TRUE(world->set_body(id, bob, error)) << error;
    EXPECT_TRUE(world->is_valid_joint(joint));
  };
  change(BoxShape{0.3, 0.8}, BodyType::dynamic_body);
  EXPECT_LT(holds(60), 1e-3);
  change(CompoundShape{{{BoxShape{1, 0.2}}, {DiscShape{0.3}, {0.5, 0}}}}, BodyType::dynamic_body);
  EXPECT_LT(holds(60), 1e-3);
  change(BoxShape{0.3, 0.8}, BodyType::static_body);
  const BodyState before = state(*world, id);
  holds(10);
  EXPECT_EQ(state(*world, id).x, before.x);
  change(DiscShape{0.4}, BodyType::dynamic_body);
  EXPECT_LT(holds(60), 1e-3);
  EXPECT_NE(state(*world, id).x, before.x);
}

TEST(SetBody, IsRefusedWhole) {
  auto world = make(walled({-10, 0, 10, 20}, {0, -kG}));
  const BodyId id = add(*world, box({0, 5})), other = add(*world, disc({5, 5}));
  std::string error;
  std::vector<std::byte> before, after;
  world->save(before);
  BodyDesc wrong[6];
  for (BodyDesc& body : wrong) body = box({0, 5});
  wrong[0].position.x = kNan;
  wrong[1].shape = BoxShape{-1, 1};
  wrong[2].shape = PolygonShape{{{0, 0}, {1, 0}}};
  wrong[3].shape = ChainShape{{{0, 0}, {1, 0}, {2, 1}}};  // terrain that moves
  wrong[4].mass = -1;
  wrong[5].angular_velocity = kInf;
  for (const BodyDesc& body : wrong) {
    EXPECT_FALSE(world->set_body(id, body, error));
    EXPECT_FALSE(error.empty());
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(world->set_body({99, 0}, box({0, 5}), error));
  EXPECT_FALSE(world->set_body({id.index, id.generation + 1}, box({0, 5}), error));
  world->save(after);
  EXPECT_EQ(before, after);
  ASSERT_TRUE(world->set_velocity(other, {kNan, 0}, 0));
  world->step();
  EXPECT_FALSE(world->set_body(other, disc({5, 5}), error));
  EXPECT_NE(error.find("frozen"), std::string::npos) << error;
}

TEST(SetBody, IsReplayed) {
  auto world = make(walled({-12, 0, 12, 24}, {0, -kG}, kGrip));
  Random r(5);
  for (int k = 0; k < 40; ++k) add(*world, some_body(r, {-11 + 2.0 * (k % 11), 1 + 2.3 * (k / 11)}));
  Recorder recorder(*world, 1);
  std::string error;
  for (int frame = 0; frame < 60; ++frame) {
    const BodyId id = world->id_of(static_cast<std::uint32_t>(r.below(40)));
    const BodyState s = state(*world, id);
    ASSERT_TRUE(recorder.set_body(id, some_body(r, {std::clamp(s.x, -11.0, 11.0), std::clamp(s.y, 1.0, 23.0)}), error))
        << error;
    recorder.step();
  }
  auto replay = Replay::open(recorder.recording(), RunOptions{Isa::scalar, 2}, error);
  ASSERT_TRUE(replay) << error;
  while (replay->next()) {
  }
  EXPECT_TRUE(replay->complete());
  EXPECT_EQ(replay->differs_at(), 0u);
}

}  // namespace
}  // namespace psim::test
