// Zones of a host's profiler, around the stages and the workers of the pool alone: this program is built with
// PSIM_PROFILE_HEADER. tests/install/subproject looks at those of a whole step.
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "../pool/pool_support.h"
#include "base/trace.h"
#include "base/worker_pool.h"
#include "counting_zone.h"

namespace psim {
namespace {

class ProfileZones : public ::testing::Test {
 protected:
  ProfileZones() {
    zones_seen.begun = 0;
    zones_seen.ended.clear();
  }

  // Zones by name: on the caller's thread, and on workers. `wait_depth`: how many zones hold a wait.
  static std::map<std::string, std::pair<int, int>> seen(std::size_t wait_depth = 1) {
    std::map<std::string, std::pair<int, int>> counts;
    for (const ZoneSeen& zone : zones_seen.ended) {
      const bool caller = zone.thread == std::this_thread::get_id();
      ++(caller ? counts[zone.name].first : counts[zone.name].second);
      EXPECT_EQ(zone.depth, caller && zone.name == kWaitName ? wait_depth : 0) << zone.name;
    }
    EXPECT_TRUE(zones_seen.nested);
    EXPECT_EQ(static_cast<std::size_t>(zones_seen.begun), zones_seen.ended.size());
    return counts;
  }
};

TEST_F(ProfileZones, EachStageIsOne) {
  StepReport report;
  Tracer tracer;
  tracer.begin();
  for (std::size_t stage = 0; stage < kStageCount; ++stage) {
    const StageTimer timer(report, tracer, static_cast<Stage>(stage));
  }
  const auto zones = seen();
  EXPECT_EQ(zones.size(), kStageCount);
  for (const std::string_view name : kStageNames) {
    const auto at = zones.find(std::string(name));
    ASSERT_NE(at, zones.end()) << name;
    EXPECT_EQ(at->second, std::pair(1, 0)) << name;
  }
}

// Each worker has a job of each run, so it has a zone of each stage.
TEST_F(ProfileZones, WorkersAreInTheStageThatTheyWorkFor) {
  constexpr int kThreads = 4, kRounds = 20;
  StepReport report;
  Tracer tracer;
  WorkerPool pool(kThreads, &tracer);
  ASSERT_EQ(pool.threads(), kThreads);
  for (int round = 0; round < kRounds; ++round) {
    const Awake awake(pool);
    tracer.begin();
    for (const Stage stage : {Stage::broad_phase, Stage::solver}) {
      const StageTimer timer(report, tracer, stage);
      ASSERT_FALSE(all_threads(pool, [] { return std::this_thread::get_id(); }).empty());
    }
  }
  auto zones = seen();
  for (const char* name : {"broad_phase", "solver"}) {
    EXPECT_EQ(zones[name], std::pair(kRounds, kRounds * (kThreads - 1))) << name;
    zones.erase(name);
  }
  EXPECT_EQ(zones[kWaitName].second, 0);
  EXPECT_LE(zones[kWaitName].first, 2 * kRounds);
  EXPECT_EQ(zones.size(), 1u);
}

// A pool that belongs to no world has no stages.
TEST_F(ProfileZones, APoolWithoutStagesHasOnlyWaits) {
  WorkerPool pool(3);
  {
    const Awake awake(pool);
    EXPECT_EQ(wrong_jobs(pool, 1000), 0u);
  }
  for (const auto& [name, counts] : seen(0)) EXPECT_EQ(name, kWaitName);
}

}  // namespace
}  // namespace psim
