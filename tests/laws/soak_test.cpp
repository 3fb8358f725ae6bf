// A short run of the soak; the long one is the program `soak` (docs/hardening.md).
#include "soak/memory_trend.h"
#include "soak/soak_calls.h"
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

// Two seasons make all that comes and goes come and go: the second one leaves nothing behind.
TEST(Soak, CallsOfAllKindsLeaveNothingBehind) {
  soak::SoakCalls soak(100, 2);
  std::vector<std::size_t> bare;
  for (int season = 0; season < 3; ++season) {
    ASSERT_TRUE(soak.season()) << soak.fault();
    bare.push_back(soak.bare_bytes());
  }
  EXPECT_LE(static_cast<double>(bare[2]), 1.1 * static_cast<double>(bare[1])) << bare[1];  // arrays come to their size
  EXPECT_GE(soak.calls(), 30'000u);
  EXPECT_GT(soak.escaped(), 1u);
  EXPECT_GT(soak.events(), 1000u);
}

// In use beside memory_bytes, kB, as a soak shows it: up and down, and where it leaks so many bytes a step, up.
std::vector<std::size_t> uncounted(std::size_t minutes, std::size_t bytes_a_step) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < minutes; ++k) out.push_back(400'000 + 9000 * (k * 7 % 5) + 3600 * k * bytes_a_step);
  return out;
}

TEST(SoakMemory, ALeakOfAFewBytesAStepIsFound) {
  for (const std::size_t minutes : {24u, 60u, 480u}) {
    EXPECT_FALSE(soak::uncounted_trend(uncounted(minutes, 0)).grows) << minutes;
    EXPECT_TRUE(soak::uncounted_trend(uncounted(minutes, minutes < 60 ? 3 : 1)).grows) << minutes;
  }
}

TEST(SoakMemory, ListsThatGrowOnAreFoundAndRoomThatIsTakenOnceIsNot) {
  std::vector<std::size_t> steady, once, grows;
  for (std::size_t k = 0; k < 60; ++k) {
    steady.push_back(1'454'000 + (k > 40 ? 247'000 : 0));
    once.push_back(k < 10 ? 685'000 : 1'115'000);
    grows.push_back(300'000 + 25'000 * k);  // 7 bytes a step
  }
  EXPECT_FALSE(soak::counted_trend(steady).grows);
  EXPECT_FALSE(soak::counted_trend(once).grows);
  EXPECT_TRUE(soak::counted_trend(grows).grows);
}

}  // namespace
}  // namespace psim::test
