// Reports count each body once, awake or asleep, whatever falls asleep, wakes, comes and goes.
#include <algorithm>
#include <vector>

#include "sleep_support.h"

namespace psim::test {
namespace {

/// An open world in which bodies of every kind come to rest while the host disturbs them.
class Restless {
 public:
  explicit Restless(std::uint64_t seed) : random_(seed) {
    WorldDesc desc = unbounded(60);
    desc.boundary = Boundary::open;
    world_ = make(desc);
    add(*world_, segment({-20, 0}, {20, 0}, kGrip));  // bodies that roll off its ends leave the world
    add(*world_, moving(kinematic(box({0, -3}, 2, 1, kGrip)), {0.1, 0}));
    for (int k = 0; k < 40; ++k) put(0.6 + 0.4 * k);
  }

  void disturb() {
    const std::size_t k = random_.below(ids_.size());
    const BodyId id = ids_[k];
    switch (random_.below(6)) {
      case 0:
        return put(10);
      case 1:
        world_->remove_body(id);
        ids_[k] = ids_.back();
        return ids_.pop_back();
      case 2:
        world_->set_enabled(id, random_.chance(0.5));
        return;
      case 3:
        world_->set_velocity(id, {random_.uniform(-30, 30), 3}, 0);
        return;
      case 4:
        world_->set_sleeping(random_.chance(0.9));
        return;
      default:
        world_->wake(id);
    }
  }

  StepReport step() {
    const StepReport report = world_->step();
    std::erase_if(ids_, [this](BodyId id) { return !world_->is_valid(id); });
    return report;
  }

  World& world() { return *world_; }

 private:
  void put(double y) {
    const Vec2 at{random_.uniform(-15, 15), y};
    BodyDesc body =
        random_.chance(0.5) ? disc(at, {}, random_.uniform(0.1, 0.4), kGrip) : body_of_any_shape(random_, at);
    body.fixed_rotation = true;  // nothing rolls for long
    ids_.push_back(add(*world_, body));
  }

  Random random_;
  std::unique_ptr<World> world_;
  std::vector<BodyId> ids_;
};

TEST(SleepCounts, EachBodyIsAwakeOrAsleepAfterEveryStep) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Restless scene(seed);
    std::uint64_t before = 0, fell = 0, woke = 0;
    for (int frame = 0; frame < 900; ++frame) {
      if (frame > 400 && frame % 25 == 0) scene.disturb();
      const StepReport report = scene.step();
      ASSERT_EQ(report.awake, awake(scene.world())) << "seed " << seed << ", frame " << frame;
      ASSERT_EQ(report.awake + report.asleep, scene.world().dynamic_count()) << "seed " << seed << ", frame " << frame;
      fell += report.asleep > before;
      woke += report.asleep < before;
      before = report.asleep;
    }
    EXPECT_GT(fell, 5u) << seed;
    EXPECT_GT(woke, 2u) << seed;
  }
}

}  // namespace
}  // namespace psim::test
