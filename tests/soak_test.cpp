// A short run of the soak; the long one is the program `soak` (docs/hardening.md).
#include "soak/soak_world.h"

#include "support.h"

namespace psim::test {
namespace {

TEST(Soak, AChangingWorldKeepsItsPromises) {
  soak::SoakWorld soak(80, 2);
  std::uint64_t most_asleep = 0;
  for (int frame = 0; frame < 2700; ++frame) {
    ASSERT_TRUE(soak.step()) << soak.fault();
    most_asleep = std::max(most_asleep, soak.asleep());
  }
  EXPECT_GT(most_asleep, 5u);
  EXPECT_GT(soak.removed(), 100u);
  EXPECT_GT(soak.events(), 1000u);
}

TEST(Soak, HasTheSameBitsOnAnyNumberOfThreads) {
  soak::SoakWorld one(60, 1), three(60, 3);
  for (int frame = 0; frame < 1000; ++frame) {
    ASSERT_TRUE(one.step() && three.step()) << one.fault();
    ASSERT_EQ(one.world().state_hash(), three.world().state_hash()) << frame;
  }
}

}  // namespace
}  // namespace psim::test
