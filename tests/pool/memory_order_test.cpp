// What a job wrote is seen by the caller and by the jobs of later runs: many short runs over plain numbers, which no
// atomic guards. On x86-64 the processor keeps most of the order by itself, whatever the code says; the thread sanitizer
// goes by the code and finds a missing order on any processor.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/worker_pool.h"

namespace psim {
namespace {

constexpr int kThreads = 4;
constexpr std::uint32_t kRuns = 20'000;

/// Jobs that write one cache line each, or all into the same few.
template <std::size_t Bytes>
struct alignas(Bytes) Cell {
  std::uint32_t value = 0;
};

/// In run k each job looks for what another job wrote in run k - 1 and what the caller wrote before run k, and writes k.
/// The caller looks for what all wrote. Returns how often one of them saw something else.
template <std::size_t Bytes>
std::uint32_t wrong_sights(std::size_t jobs) {
  WorkerPool pool(kThreads);
  const WorkerPool::Awake awake(pool, WorkerPool::Work::other);
  std::array<std::vector<Cell<Bytes>>, 2> cells{std::vector<Cell<Bytes>>(jobs), std::vector<Cell<Bytes>>(jobs)};
  std::uint32_t from_caller = 0, seen_by_caller = 0;
  std::atomic<std::uint32_t> seen_by_jobs{0};
  for (std::uint32_t run = 1; run <= kRuns; ++run) {
    from_caller = 3 * run;
    const std::vector<Cell<Bytes>>& before = cells[(run + 1) % 2];
    std::vector<Cell<Bytes>>& now = cells[run % 2];
    pool.run(jobs, [&](std::size_t i) {
      if (before[(i + 1 + run % (jobs - 1)) % jobs].value != run - 1 || from_caller != 3 * run) {
        seen_by_jobs.fetch_add(1, std::memory_order_relaxed);
      }
      now[i].value = run;
    });
    for (const Cell<Bytes>& cell : now) seen_by_caller += cell.value != run;
  }
  return seen_by_jobs.load(std::memory_order_relaxed) + seen_by_caller;
}

TEST(WorkerPoolOrder, JobsSeeWhatEarlierRunsWroteInLinesOfTheirOwn) {
  for (const std::size_t jobs : {2, 4, 9}) EXPECT_EQ(wrong_sights<64>(jobs), 0u) << jobs << " jobs";
}

TEST(WorkerPoolOrder, JobsSeeWhatEarlierRunsWroteInSharedLines) {
  for (const std::size_t jobs : {3, 8, 64}) EXPECT_EQ(wrong_sights<4>(jobs), 0u) << jobs << " jobs";
}

/// Relaxed additions of jobs are complete when the run has returned, and a relaxed flag that a job set is set.
TEST(WorkerPoolOrder, RelaxedCountersAreCompleteAfterTheRun) {
  WorkerPool pool(kThreads);
  const WorkerPool::Awake awake(pool, WorkerPool::Work::other);
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    std::atomic<std::uint32_t> sum{0};
    std::atomic<bool> fine{true};
    pool.run(8, [&](std::size_t i) {
      sum.fetch_add(static_cast<std::uint32_t>(i) + run, std::memory_order_relaxed);
      if (i == run % 8) fine.store(false, std::memory_order_relaxed);
    });
    ASSERT_EQ(sum.load(std::memory_order_relaxed), 28 + 8 * run);
    ASSERT_FALSE(fine.load(std::memory_order_relaxed));
  }
}

/// Workers that go to sleep and wake between two runs see the caller's writes, too.
TEST(WorkerPoolOrder, JobsSeeWhatWasWrittenWhileTheWorkersSlept) {
  WorkerPool pool(kThreads);
  std::vector<std::uint32_t> before(8, 0), now(8, 0);
  std::atomic<std::uint32_t> wrong{0};
  for (std::uint32_t run = 1; run <= kRuns / 20; ++run) {
    const WorkerPool::Awake awake(pool, WorkerPool::Work::other);
    for (std::uint32_t& value : before) value = run;
    pool.run(before.size(), [&](std::size_t i) {
      if (before[(i + run) % 8] != run || now[i] != run - 1) wrong.fetch_add(1, std::memory_order_relaxed);
      now[i] = run;
    });
  }
  EXPECT_EQ(wrong.load(std::memory_order_relaxed), 0u);
}

}  // namespace
}  // namespace psim
