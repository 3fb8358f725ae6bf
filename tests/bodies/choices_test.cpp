// Values of enums that a host casts from other numbers, and speeds beyond their range: refused, and nothing changes.
#include <psim/scene.h>

#include "support/rigid_support.h"

namespace psim::test {
namespace {

TEST(Choices, OfABodyAreRefusedIfThereIsNoSuch) {
  auto world = make(walled({0, 0, 20, 20}));
  const BodyId there = add(*world, disc({3, 3}));
  const std::uint64_t hash = world->state_hash();
  std::string error;
  BodyDesc body = disc({5, 5});
  body.type = static_cast<BodyType>(3);
  EXPECT_EQ(world->add_body(body, error), kNoBody);
  EXPECT_EQ(error, "type must be from 0 to 2, not 3");
  EXPECT_FALSE(world->set_body(there, body, error));
  EXPECT_EQ(error, "type must be from 0 to 2, not 3");
  EXPECT_EQ(world->state_hash(), hash);
}

TEST(Choices, OfAJointAreRefusedIfThereIsNoSuch) {
  auto world = make(walled({0, 0, 20, 20}));
  JointDesc joint;
  joint.a = add(*world, disc({3, 3}));
  joint.b = add(*world, disc({5, 5}));
  joint.type = static_cast<JointType>(12);
  std::string error;
  EXPECT_EQ(world->add_joint(joint, error), kNoJoint);
  EXPECT_EQ(error, "type must be from 0 to 11, not 12");
  EXPECT_EQ(world->joint_count(), 0u);
}

TEST(Choices, OfAWorldAreRefusedIfThereIsNoSuch) {
  const auto refused = [](const auto& change) {
    WorldDesc desc = walled({0, 0, 20, 20});
    change(desc);
    std::string error;
    EXPECT_EQ(World::create(desc, {}, error), nullptr);
    return error;
  };
  EXPECT_EQ(refused([](WorldDesc& d) { d.boundary = static_cast<Boundary>(9); }),
            "boundary must be from 0 to 2, not 9");
  EXPECT_EQ(refused([](WorldDesc& d) { d.integrator = static_cast<Integrator>(4); }),
            "integrator must be from 0 to 3, not 4");
  EXPECT_EQ(refused([](WorldDesc& d) { d.mixing.friction = static_cast<Mixing>(200); }),
            "mixing of friction must be from 0 to 4, not 200");
}

TEST(Choices, SpeedsBeyondTheirRangeAreRefused) {
  auto world = make(walled({0, 0, 20, 20}));
  const BodyId id = add(*world, disc({3, 3}, {1, 2}));
  const std::uint64_t hash = world->state_hash();
  EXPECT_FALSE(world->set_velocity(id, {1.1e6, 0}, 0));
  EXPECT_FALSE(world->set_velocity(id, {0, 0}, 1e9));
  EXPECT_EQ(world->state_hash(), hash);
  world->step();
  EXPECT_EQ(world->body_count(), 1u);
  EXPECT_TRUE(world->set_velocity(id, {3, 0}, 0));
}

}  // namespace
}  // namespace psim::test
