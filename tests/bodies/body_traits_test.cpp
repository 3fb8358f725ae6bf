// What the host changes of bodies while the world runs: traits, and whether they take part in it at all.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "joint_support.h"
#include "psim/recording.h"
#include "rigid_support.h"

namespace psim::test {
namespace {

// A body of any kind, with its traits drawn at random or left out.
BodyDesc some_body(Random& r, bool traits) {
  BodyDesc body = disc({}, {}, 0.4);
  const std::size_t kind = r.below(5);
  if (kind == 1) body.shape = BoxShape{0.9, 0.6};
  if (kind == 2) body.shape = CompoundShape{{{BoxShape{1, 0.2}}, {DiscShape{0.3}, {0.5, 0}}}};
  if (kind == 3) body.shape = CapsuleShape{{-0.3, 0}, {0.3, 0.1}, 0.2};
  body.position = {r.uniform(-9, 9), r.uniform(1, 19)};
  body.angle = r.uniform(-3, 3);
  body.velocity = {r.uniform(-10, 10), r.uniform(-10, 10)};
  body.angular_velocity = r.uniform(-5, 5);
  const std::size_t type = r.below(8);
  if (type == 0) body.type = BodyType::static_body;
  if (type == 1) body.type = BodyType::kinematic_body;
  if (!traits) return body;
  if (r.chance(0.5)) body.material.friction = r.uniform(0, 1);
  if (r.chance(0.3)) body.material.restitution = r.uniform(0, 1);
  if (r.chance(0.2)) body.material.tangent_speed = r.uniform(-3, 3);
  if (r.chance(0.2)) body.material.rolling_resistance = r.uniform(0, 0.3);
  if (r.chance(0.1)) body.one_way = {r.uniform(-1, 1), r.uniform(-1, 1)};
  if (r.chance(0.2)) body.filter = {1u << r.below(3), static_cast<std::uint32_t>(r.below(8)), 0};
  if (body.type == BodyType::static_body) return body;
  body.bullet = r.chance(0.2);
  body.sensor = r.chance(0.1);
  if (body.type != BodyType::dynamic_body) return body;
  body.fixed_rotation = r.chance(0.1);
  if (r.chance(0.2)) body.gravity_scale = r.uniform(-1, 2);
  if (r.chance(0.2)) body.linear_damping = r.uniform(0, 3);
  if (r.chance(0.2)) body.angular_damping = r.uniform(0, 3);
  if (r.chance(0.3)) body.locks = {r.chance(0.5), r.chance(0.5), r.chance(0.5)};
  return body;
}

// A body whose traits were changed to those of another one is as that one, whatever it had before.
TEST(BodyTraits, ChangedIsAsMade) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    WorldDesc desc = walled({-10, 0, 10, 20}, {0, -kG});
    desc.sleeping = seed % 2 == 0;
    auto made = make(desc), changed = make(desc);
    for (std::uint32_t k = 0; k < 60; ++k) {
      Random r(1000 * seed + k), other(5000 * seed + k), place(1000 * seed + k);
      BodyDesc wanted = some_body(r, true), before = some_body(place, false);
      wanted.position = before.position = {-8.8 + 2.2 * (k % 9), 1.5 + 2.2 * (k / 9)};  // apart
      const BodyDesc odd = some_body(other, true);
      if (seed % 3 != 0) {  // with traits of its own
        before.material = odd.material;
        before.filter = odd.filter;
        before.one_way = odd.one_way;
        if (before.type == BodyType::dynamic_body && odd.type == BodyType::dynamic_body) {
          before.bullet = odd.bullet;
          before.gravity_scale = odd.gravity_scale;
          before.locks = odd.locks;
          before.linear_damping = odd.linear_damping;
        }
      }
      before.mass = wanted.type == BodyType::dynamic_body ? 3 : 0;
      const BodyId a = add(*made, wanted), b = add(*changed, before);
      ASSERT_EQ(a, b);
      const auto traits = made->traits(a);
      ASSERT_TRUE(traits.has_value());
      ASSERT_TRUE(changed->set_traits(b, *traits)) << k;
      const BodyTraits now = changed->traits(b).value();
      EXPECT_EQ(now.filter, traits->filter);
      EXPECT_EQ(now.locks, traits->locks);
      EXPECT_NEAR(now.mass, traits->mass, 1e-6 * traits->mass);
      EXPECT_NEAR(now.inertia, traits->inertia, 1e-6 * traits->inertia);
      EXPECT_NEAR(now.one_way.x, traits->one_way.x, 1e-6);
      EXPECT_EQ(now.tangent_speed, traits->tangent_speed);
    }
    for (int frame = 0; frame < 30; ++frame) {
      made->step();
      changed->step();
    }
    double apart = 0;
    for (std::uint32_t k = 0; k < 60; ++k) {
      const BodyState s = state(*made, made->id_of(k)), t = state(*changed, changed->id_of(k));
      apart = std::max(apart, std::hypot(s.x - t.x, s.y - t.y));
    }
    EXPECT_EQ(apart, 0) << seed;
  }
}

TEST(BodyTraits, RefuseWhatIsWrong) {
  auto world = make(unbounded(50));
  const BodyId id = add(*world, box({0, 5})), ground_id = add(*world, ground({}));
  const BodyTraits good = world->traits(id).value();
  EXPECT_NEAR(good.mass, 1, 1e-6);
  EXPECT_NEAR(good.inertia, 1.0 / 6, 1e-6);
  const std::uint64_t hash = world->state_hash();
  const auto refused = [&](const auto& change) {
    BodyTraits t = good;
    change(t);
    EXPECT_FALSE(world->set_traits(id, t));
    EXPECT_EQ(world->traits(id).value(), good);
  };
  refused([](BodyTraits& t) { t.mass = 0; });
  refused([](BodyTraits& t) { t.mass = std::nan(""); });
  refused([](BodyTraits& t) { t.inertia = -1; });
  refused([](BodyTraits& t) { t.friction = -0.1; });
  refused([](BodyTraits& t) { t.restitution = 1.1; });
  refused([](BodyTraits& t) { t.rolling_resistance = 2; });
  refused([](BodyTraits& t) { t.tangent_speed = 1e9; });
  refused([](BodyTraits& t) { t.linear_damping = -1; });
  refused([](BodyTraits& t) { t.one_way = {1e-30, 0}; });
  BodyTraits of_ground = world->traits(ground_id).value();
  of_ground.sensor = true;
  EXPECT_FALSE(world->set_traits(ground_id, of_ground));
  EXPECT_FALSE(world->set_traits(kNoBody, good));
  EXPECT_FALSE(world->traits({id.index, id.generation + 1}).has_value());
  EXPECT_EQ(world->state_hash(), hash);
  BodyTraits heavy = good;
  heavy.mass = 4;
  ASSERT_TRUE(world->set_traits(id, heavy));
  EXPECT_NEAR(world->traits(id)->inertia, 4.0 / 6, 1e-6);  // it goes with the mass
  heavy.locks.angle = true;
  heavy.inertia = world->traits(id)->inertia;
  ASSERT_TRUE(world->set_traits(id, heavy));
  EXPECT_NEAR(world->traits(id)->inertia, 4.0 / 6, 1e-6);  // it comes back with the rotation
  heavy.locks.angle = false;
  ASSERT_TRUE(world->set_traits(id, heavy));
  world->apply_angular_impulse(id, 2);
  EXPECT_NEAR(state(*world, id).omega, 2 / (4.0 / 6), 1e-5);
}

// Also of sensors that have many hulls and no pieces.
TEST(BodyTraits, StaticSensorsChange) {
  auto world = make(unbounded(50));
  world->set_event_options({.sensors = true});
  BodyDesc net;
  net.type = BodyType::static_body;
  net.sensor = true;
  net.shape = ChainShape{{{-4, 3}, {-2, 2}, {0, 3}, {2, 2}, {4, 3}}, false, {}};
  const BodyId id = add(*world, net);
  BodyTraits t = world->traits(id).value();
  t.tangent_speed = 1;
  ASSERT_TRUE(world->set_traits(id, t));
  t.filter.mask = 2;
  ASSERT_TRUE(world->set_traits(id, t));
  EXPECT_EQ(world->traits(id).value(), t);
  BodyDesc seen = disc({3, 2.5}), passed = disc({-3, 2.5});
  seen.filter.category = 2;
  const BodyId other = add(*world, seen);
  add(*world, passed);
  run(*world, 1);
  ASSERT_EQ(world->events().sensor_begin.size(), 1u);
  EXPECT_EQ(world->events().sensor_begin[0].b, other);
}

TEST(BodyTraits, ChangesWakeAndCount) {
  auto world = make(unbounded(50));
  const BodyId floor = add(*world, ground(material(0, 0.8)));
  const double slope = 0.3;
  const BodyId ramp = add(*world, turned(fixed(box({10, 0}, 8, 1, material(0, 1))), slope));
  const BodyId slider = add(*world, turned(box({10 - std::sin(slope), std::cos(slope)}, 1, 1, material(0, 1)), slope));
  const BodyId faller = add(*world, box({0, 0.5}));
  run(*world, 300);
  ASSERT_FALSE(world->is_awake(slider) || world->is_awake(faller));
  BodyTraits t = world->traits(ramp).value();
  t.friction = 0;
  ASSERT_TRUE(world->set_traits(ramp, t));
  EXPECT_TRUE(world->is_awake(slider));
  EXPECT_FALSE(world->is_awake(faller));
  const double x = state(*world, slider).x;
  run(*world, 30);
  EXPECT_NEAR(state(*world, slider).x - x, -kG * std::sin(slope) * std::cos(slope) * 0.125, 0.05);
  t = world->traits(floor).value();
  t.filter.mask = 0;
  ASSERT_TRUE(world->set_traits(floor, t));
  run(*world, 60);
  EXPECT_LT(state(*world, faller).y, -3);
}

// ---- disabled bodies

// A world with bodies that are disabled does what it does without them.
TEST(DisabledBodies, AreAsIfTheyWereNotThere) {
  for (const bool later : {false, true}) {
    WorldDesc desc = walled({-10, 0, 10, 20}, {0, -kG});
    auto without = make(desc), with = make(desc);
    std::vector<std::pair<BodyId, BodyId>> pairs;
    std::vector<BodyId> off;
    for (std::uint32_t k = 0; k < 80; ++k) {
      Random r(k);
      BodyDesc body = some_body(r, true);
      if (k % 3 == 0) {
        body.enabled = later;
        off.push_back(add(*with, body));
        EXPECT_EQ(with->is_enabled(off.back()), later);
      } else {
        pairs.emplace_back(add(*without, body), add(*with, body));
      }
    }
    std::vector<BodyState> before;
    for (const BodyId id : off) {
      if (later) {
        ASSERT_TRUE(with->set_enabled(id, false));
      }
      before.push_back(state(*with, id));
    }
    EXPECT_EQ(with->dynamic_count(), without->dynamic_count());
    EXPECT_EQ(with->static_count(), without->static_count());
    for (int frame = 0; frame < 60; ++frame) {
      without->step();
      with->step();
    }
    for (const auto& [a, b] : pairs) {
      const BodyState s = state(*without, a), t = state(*with, b);
      EXPECT_NEAR(s.x, t.x, 1e-3);
      EXPECT_NEAR(s.y, t.y, 1e-3);
    }
    for (std::size_t k = 0; k < off.size(); ++k) {
      const BodyState s = state(*with, off[k]);
      EXPECT_EQ(s.x, before[k].x);
      EXPECT_EQ(s.y, before[k].y);
      EXPECT_EQ(s.vx, before[k].vx);
      EXPECT_EQ(s.omega, before[k].omega);
      EXPECT_FALSE(with->is_awake(off[k]));
    }
  }
}

TEST(DisabledBodies, LetGoAndComeBack) {
  auto world = make(unbounded(50));
  add(*world, ground(material(0, 0.5)));
  const BodyId table = add(*world, fixed(box({0, 2}, 4, 0.5))), lying = add(*world, box({0, 2.75}));
  const BodyId leg = add(*world, box({10, 0.5})), upper = add(*world, box({10, 1.5}));
  run(*world, 200);
  ASSERT_FALSE(world->is_awake(lying) || world->is_awake(upper));
  EXPECT_EQ(world->ray_cast({-5, 2}, {5, 2})->body, table);
  ASSERT_TRUE(world->set_enabled(table, false));
  ASSERT_TRUE(world->set_enabled(leg, false));
  EXPECT_TRUE(world->is_awake(lying) && world->is_awake(upper));
  EXPECT_FALSE(world->ray_cast({-5, 2}, {5, 2}).has_value());
  QueryFilter movers;
  movers.fixed = false;
  EXPECT_EQ(world->overlap(DiscShape{1}, {10, 0.5}, 0, movers), std::vector<BodyId>{upper});
  run(*world, 200);
  EXPECT_NEAR(state(*world, lying).y, 0.5, 0.01);
  EXPECT_NEAR(state(*world, upper).y, 0.5, 0.01);
  EXPECT_EQ(state(*world, leg).y, state(*world, leg).y);
  // It comes back where the host puts it, as fast as it says.
  EXPECT_FALSE(world->set_transform(table, {0, 9}, 0));
  EXPECT_FALSE(world->set_transform(leg, {std::nan(""), 9}, 0));
  EXPECT_FALSE(world->apply_impulse(leg, {1, 0}));
  ASSERT_TRUE(world->set_transform(leg, {10, 5}, 0.5));
  ASSERT_TRUE(world->set_velocity(leg, {3, 0}, 1));
  ASSERT_TRUE(world->set_enabled(leg, true) && world->set_enabled(table, true));
  EXPECT_TRUE(world->is_enabled(leg) && world->is_awake(leg));
  EXPECT_EQ(world->ray_cast({-5, 2}, {5, 2})->body, table);
  run(*world, 12);
  EXPECT_NEAR(state(*world, leg).x, 10.6, 1e-3);
  EXPECT_NEAR(state(*world, leg).angle, 0.7, 1e-3);
  ASSERT_TRUE(world->set_enabled(table, false) && world->remove_body(table));
  EXPECT_FALSE(world->set_enabled(table, true));
  run(*world, 200);
  EXPECT_EQ(world->body_count(), 4u);
}

TEST(DisabledBodies, TheirJointsDoNothing) {
  auto world = make(unbounded(50));
  const BodyId post = add(*world, fixed(disc({0, 0}))), bob = add(*world, box({2, 0}));
  const BodyId last = add(*world, box({4, 0}));
  std::string error;
  JointDesc joint;
  joint.type = JointType::distance;
  joint.a = post, joint.b = bob;
  const JointId first = world->add_joint(joint, error);
  joint.a = bob, joint.b = last;
  ASSERT_NE(world->add_joint(joint, error), kNoJoint) << error;
  run(*world, 20);
  ASSERT_TRUE(world->set_enabled(bob, false));
  const BodyState held = state(*world, bob), before = state(*world, last);
  run(*world, 30);
  EXPECT_EQ(state(*world, bob).x, held.x);
  EXPECT_NEAR(state(*world, last).vy - before.vy, -kG * 0.5, 1e-3);  // it falls freely
  EXPECT_TRUE(world->is_valid_joint(first));
  EXPECT_NEAR(std::hypot(world->joint(first)->force.x, world->joint(first)->force.y), 0, 1e-6);
  world->set_velocity(last, {0, 0}, 0);
  world->set_transform(last, {held.x + 2, held.y}, 0);
  ASSERT_TRUE(world->set_enabled(bob, true));
  run(*world, 300);
  const BodyState s = state(*world, bob);
  EXPECT_NEAR(std::hypot(s.x, s.y), 2, 0.01);
  ASSERT_TRUE(world->set_enabled(post, false));
  run(*world, 60);
  EXPECT_LT(state(*world, bob).y, -4);
}

TEST(DisabledBodies, AreSavedAndReplayed) {
  auto world = make(unbounded(50));
  Recorder recorder(*world);
  std::string error;
  std::vector<BodyId> ids{recorder.add_body(ground(material(0, 0.5)), error)};
  Random r(9);
  for (std::uint32_t k = 0; k < 60; ++k) {
    BodyDesc body = some_body(r, true);
    body.enabled = r.chance(0.7);
    body.user_data = k;
    ids.push_back(recorder.add_body(body, error));
  }
  std::vector<std::byte> saved;
  std::uint64_t later = 0;
  for (std::uint32_t frame = 0; frame < 200; ++frame) {
    recorder.set_enabled(ids[r.below(ids.size())], r.chance(0.5));
    if (frame % 20 == 0) recorder.set_user_data(ids[r.below(ids.size())], frame);
    if (frame == 100) world->save(saved);
    recorder.step();
    if (frame == 100) later = world->state_hash();
  }
  const auto replay = Replay::open(recorder.recording(), {}, error);
  ASSERT_TRUE(replay) << error;
  while (replay->next()) {
  }
  EXPECT_TRUE(replay->complete() && replay->differs_at() == 0);
  for (const BodyId id : ids) {
    EXPECT_EQ(replay->world().user_data(id), world->user_data(id));
    EXPECT_EQ(replay->world().is_enabled(id), world->is_enabled(id));
    EXPECT_EQ(replay->world().traits(id), world->traits(id));
  }
  auto other = World::from_state(saved, {}, error);
  ASSERT_TRUE(other) << error;
  other->step();
  EXPECT_EQ(other->state_hash(), later);
}

TEST(DisabledBodies, CostNothing) {
  auto world = make(unbounded(500)), empty = make(unbounded(500));
  std::string error;
  for (int k = 0; k < 1000; ++k) {
    BodyDesc body = disc({0.3 * k - 150, 0});
    body.enabled = false;
    add(*world, body);
  }
  run(*world, 3);
  for (const PlanEntry& entry : world->plan()) EXPECT_FALSE(entry.needed) << entry.stage;
  EXPECT_EQ(world->dynamic_count(), 0u);
  EXPECT_EQ(world->body_count(), 1000u);
}

}  // namespace
}  // namespace psim::test
