// Contacts of joined bodies that come about within a step, because a joint turns or stops them.
#include <algorithm>
#include <cmath>
#include <string>

#include "rigid_support.h"

namespace psim::test {
namespace {

// The end of a joint's limit turns an arm into the ground. The pin opens by no more than the bodies go in a substep,
// however many of them a step has.
TEST(JointContacts, ALimitTurnsAnArmIntoTheGround) {
  for (const int substeps : {16, 32, 64}) {
    double worst = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      Random random(seed);
      WorldDesc desc = unbounded(50, {0, 0});
      desc.substeps = substeps;
      auto world = make(desc);
      add(*world, segment({-5, 0}, {5, 0}));
      const double spin = seed == 0 ? 10 : random.uniform(6, 14), fall = seed == 0 ? 5 : random.uniform(3, 8);
      const Vec2 arm{0.3, -0.4};
      const Vec2 at{0, seed == 0 ? 0.481 : 0.45 + fall / 60 * random.uniform(0.1, 0.9)};
      BodyDesc hub = disc(at, {0, -fall}, 0.1);
      hub.mass = 50;
      BodyDesc limb;
      limb.shape = CapsuleShape{{0, 0}, arm, 0.05};
      limb.position = at;
      limb.velocity = {-0.5 * spin * arm.y, -fall + 0.5 * spin * arm.x};
      limb.angular_velocity = spin;
      limb.mass = 5;
      JointDesc pin;
      pin.type = JointType::revolute;
      pin.a = add(*world, hub);
      pin.b = add(*world, limb);
      pin.upper = 0.05;
      std::string error;
      const JointId id = world->add_joint(pin, error);
      ASSERT_NE(id, kNoJoint) << error;
      for (int k = 0; k < 6; ++k) {
        world->step();
        const JointState joint = *world->joint(id);
        const double gap = std::hypot(joint.anchor_b.x - joint.anchor_a.x, joint.anchor_b.y - joint.anchor_a.y);
        worst = std::max(worst, gap / (fall / 60 / substeps));
        ASSERT_GT(state(*world, pin.b).y, -0.3) << seed;
      }
    }
    EXPECT_LT(worst, 1) << substeps << " substeps";
    RecordProperty("worst_" + std::to_string(substeps), std::to_string(worst));
  }
}

}  // namespace
}  // namespace psim::test
