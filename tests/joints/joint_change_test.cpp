// Joints that get another description while the world runs do what it says.
#include <cmath>
#include <string>

#include "joint_support.h"
#include "rigid_support.h"
#include "saved_support.h"

namespace psim::test {
namespace {

// Two bodies without gravity, joined; the second one may go where the joint leads it.
struct Pair {
  std::unique_ptr<World> world;
  JointId joint;
  JointDesc desc;
};

Pair pair_of(JointType type, int substeps) {
  WorldDesc desc = unbounded(50, {0, 0});
  desc.substeps = substeps;
  desc.linear_damping = 3;
  Pair p{make(desc), {}, {}};
  const BodyId a = add(*p.world, fixed(box({0, 0}))), b = add(*p.world, box({2, 0}));
  p.desc.type = type;
  p.desc.a = a, p.desc.b = b;
  p.desc.anchor_b = {-2, 0};
  if (type == JointType::distance || type == JointType::rope) p.desc.anchor_b = {-0.5, 0}, p.desc.length = 1.5;
  std::string error;
  p.joint = p.world->add_joint(p.desc, error);
  EXPECT_NE(p.joint, kNoJoint) << error;
  return p;
}

// Other anchors draw the bodies together there.
TEST(JointChange, AnchorsCount) {
  for (const JointType type : {JointType::distance, JointType::revolute, JointType::weld, JointType::prismatic}) {
    for (const int substeps : {1, 4}) {
      Pair p = pair_of(type, substeps);
      for (int k = 0; k < 30; ++k) p.world->step();
      p.desc = p.world->joint_desc(p.joint).value();
      p.desc.anchor_a = {0, 0.4};
      p.desc.anchor_b.y = -0.3;
      std::string error;
      ASSERT_TRUE(p.world->set_joint(p.joint, p.desc, error)) << error;
      for (int k = 0; k < 300; ++k) p.world->step();
      const JointState s = p.world->joint(p.joint).value();
      const double x = s.anchor_b.x - s.anchor_a.x, y = s.anchor_b.y - s.anchor_a.y;
      if (type == JointType::distance) {
        EXPECT_NEAR(std::hypot(x, y), 1.5, 1e-3) << substeps;
      } else {
        EXPECT_NEAR(y, 0, 1e-3) << static_cast<int>(type) << " " << substeps;
      }
      const Vec2 anchor = s.anchor_a;
      EXPECT_NEAR(anchor.y, 0.4, 1e-9);
    }
  }
}

TEST(JointChange, LengthsCount) {
  for (const JointType type : {JointType::distance, JointType::rope}) {
    Pair p = pair_of(type, 4);
    for (int k = 0; k < 30; ++k) p.world->step();
    p.desc = p.world->joint_desc(p.joint).value();
    p.desc.length = 1;
    std::string error;
    ASSERT_TRUE(p.world->set_joint(p.joint, p.desc, error)) << error;
    for (int k = 0; k < 200; ++k) p.world->step();
    EXPECT_NEAR(p.world->joint(p.joint)->value, 1, 1e-3);
  }
}

// A state that is saved after any change is restored: its blocks are those that the descriptions ask for.
TEST(JointChange, IsSavedAsLaidOut) {
  Random r(3);
  auto world = make(unbounded(100));
  std::vector<BodyId> ids;
  for (int k = 0; k < 20; ++k) ids.push_back(add(*world, disc({1.2 * k, 0}, {}, 0.4)));
  std::vector<JointId> joints;
  std::string error;
  for (int k = 0; k < 19; ++k) {
    JointDesc d;
    d.type = k % 3 == 0 ? JointType::revolute : k % 3 == 1 ? JointType::prismatic : JointType::distance;
    d.a = ids[static_cast<std::size_t>(k)], d.b = ids[static_cast<std::size_t>(k) + 1];
    d.anchor_a = {0.6, 0}, d.anchor_b = {-0.6, 0};
    if (k % 3 == 2) d.anchor_b = {0, 0};
    joints.push_back(world->add_joint(d, error));
    ASSERT_NE(joints.back(), kNoJoint) << error;
  }
  for (int frame = 0; frame < 60; ++frame) {
    world->step();
    const JointId id = joints[r.below(joints.size())];
    JointDesc d = world->joint_desc(id).value();
    d.lower = r.chance(0.5) ? std::optional<double>(-0.2) : std::nullopt;
    d.upper = r.chance(0.5) ? std::optional<double>(0.2) : std::nullopt;
    if (d.type == JointType::distance) d.lower = d.upper = std::nullopt;
    d.motor_limit = d.type == JointType::revolute && r.chance(0.3) ? 5 : 0;
    ASSERT_TRUE(world->set_joint(id, d, error)) << error;
    std::vector<std::byte> state;
    world->save(state);
    auto copy = World::from_state(state, RunOptions{}, error);
    ASSERT_TRUE(copy) << frame << ": " << error;
    if (frame % 10 == 0) expect_resumes(*copy, 3, "with changed joints");
  }
}

}  // namespace
}  // namespace psim::test
