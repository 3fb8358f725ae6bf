// The worker pool alone (src/core/base/worker_pool.h): every job runs once, whatever the number of jobs, threads and
// pools, and whatever the operating system does to a worker. A small program, so that the thread sanitizer builds it in
// seconds.
#include "base/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/machine.h"
#include "pool_support.h"

namespace psim {
namespace {

constexpr int kMostThreads = 16;

// ---- jobs ---------------------------------------------------------------------------------------

TEST(WorkerPool, EveryJobRunsOnceForAnyNumberOfJobsAndThreads) {
  for (int threads = 1; threads <= kMostThreads; ++threads) {
    WorkerPool pool(threads);
    const Awake awake(pool);
    for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 8u, 15u, 16u, 17u, 100u, 5000u}) {
      EXPECT_EQ(wrong_jobs(pool, count), 0u) << count << " jobs on " << threads << " threads";
    }
  }
}

TEST(WorkerPool, NoJobsAreNoCall) {
  WorkerPool pool(3);
  const Awake awake(pool);
  for (int k = 0; k < 1000; ++k) pool.run(0, [](std::size_t) { ADD_FAILURE() << "there is no job"; });
}

TEST(WorkerPool, ARunThatHasReturnedLeavesNoJobBehind) {
  WorkerPool pool(4);
  const Awake awake(pool);
  for (int k = 0; k < 2000; ++k) {
    std::vector<int> written(16, 0);  // plain numbers that end with the round: a late job would be a data race
    pool.run(written.size(), [&](std::size_t i) { written[i] = k; });
    for (const int w : written) ASSERT_EQ(w, k);
  }
}

// A step of two jobs: that of the worker takes `late` longer than the caller's. Returns whether a worker took part.
bool step_of_two(WorkerPool& pool, std::chrono::microseconds late) {
  const WorkerPool::Awake awake(pool, WorkerPool::Work::step);
  std::atomic<bool> helped{false};
  const auto caller = std::this_thread::get_id();
  pool.run(2, [&](std::size_t) {
    if (std::this_thread::get_id() == caller) {
      wait_until([&, end = std::chrono::steady_clock::now() + 20ms] {
        return helped || pool.active() == 1 || std::chrono::steady_clock::now() > end;
      });
    } else {
      helped = true;
      std::this_thread::sleep_for(late);
    }
  });
  return helped;
}

TEST(WorkerPool, AStepThatAWorkerHeldUpIsFollowedByStepsOfFewerThreads) {
  WorkerPool pool(2);
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "two threads are more than there are cores";
  for (int k = 0; k < 100 && pool.active() == 2; ++k) step_of_two(pool, 5ms);
  EXPECT_EQ(pool.active(), 1);
  int alone = 0;
  for (; alone < 1000 && pool.active() == 1; ++alone) EXPECT_FALSE(step_of_two(pool, 0us));
  EXPECT_GE(alone, 4);
  ASSERT_EQ(pool.active(), 2);
  // Held up again: for twice as long.
  for (int k = 0; k < 100 && pool.active() == 2; ++k) step_of_two(pool, 5ms);
  int longer = 0;
  for (; longer < 1000 && pool.active() == 1; ++longer) EXPECT_FALSE(step_of_two(pool, 0us));
  EXPECT_EQ(longer, 2 * alone);
  EXPECT_EQ(wrong_jobs(pool, 100), 0u);
}

// Steps of `time` with runs of two jobs; returns in how many steps both threads had one.
int shared_steps(WorkerPool& pool, int steps, std::chrono::microseconds time) {
  int shared = 0;
  for (int k = 0; k < steps; ++k) {
    const WorkerPool::Awake awake(pool, WorkerPool::Work::step);
    std::atomic<bool> helped{false};
    const auto caller = std::this_thread::get_id();
    const auto begin = std::chrono::steady_clock::now();
    for (int run = 0; run < 8 && !helped; ++run) {
      while (std::chrono::steady_clock::now() - begin < (run + 1) * time / 8) {
      }
      pool.run(2, [&](std::size_t) {
        if (std::this_thread::get_id() != caller) helped = true;
        if (time > 1ms)
          wait_until([&, end = std::chrono::steady_clock::now() + 200ms] {
            return helped || std::chrono::steady_clock::now() > end;
          });
      });
    }
    shared += helped ? 1 : 0;
  }
  return shared;
}

// Lets short steps run until they have one thread. False: the machine is too busy to see that they are sooner.
bool steps_have_one_thread(WorkerPool& pool) {
  for (int k = 0; k < 100 && pool.active() != 1; ++k) shared_steps(pool, 24, 40us);
  return pool.active() == 1;
}

TEST(WorkerPool, AStepThatTurnsOutToBeLongHasAllThreads) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "two threads are more than there are cores";
  WorkerPool pool(2);
  if (!steps_have_one_thread(pool)) GTEST_SKIP() << "too busy";
  EXPECT_EQ(shared_steps(pool, 1, 4ms), 1);
}

// Questions between the steps have all threads, and say nothing of the steps.
TEST(WorkerPool, WhatIsNoStepHasAllThreads) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "two threads are more than there are cores";
  WorkerPool pool(2);
  if (!steps_have_one_thread(pool)) GTEST_SKIP() << "too busy";
  for (int k = 0; k < 20; ++k) {
    const Awake awake(pool);
    ASSERT_EQ(all_threads(pool, std::this_thread::get_id).size(), 2u);
  }
  EXPECT_EQ(pool.active(), 1);
}

TEST(WorkerPool, AllThreadsTakePart) {
  for (const int threads : {2, 3, 8, kMostThreads}) {
    WorkerPool pool(threads);
    const Awake awake(pool);
    const auto ids = all_threads(pool, [] { return std::this_thread::get_id(); });
    EXPECT_EQ(std::set<std::thread::id>(ids.begin(), ids.end()).size(), static_cast<std::size_t>(threads));
  }
}

TEST(WorkerPool, ResultsDoNotDependOnTheNumberOfThreads) {
  constexpr std::size_t kSize = 4096, kJobs = 37;
  const auto computed_by = [](int threads) {
    WorkerPool pool(threads);
    const Awake awake(pool);
    std::vector<float> value(kSize, 1), next(kSize);
    for (int pass = 0; pass < 50; ++pass) {
      pool.run(kJobs, [&](std::size_t job) {
        for (std::size_t i = job * kSize / kJobs; i < (job + 1) * kSize / kJobs; ++i) {
          next[i] = 0.3f * value[i] + 0.7f * value[(i * 7 + 1) % kSize] + 1 / static_cast<float>(i + 1);
        }
      });
      value.swap(next);
    }
    return value;
  };
  const std::vector<float> alone = computed_by(1);
  for (int threads = 2; threads <= kMostThreads; ++threads) {
    const std::vector<float> shared = computed_by(threads);
    EXPECT_EQ(std::memcmp(alone.data(), shared.data(), kSize * sizeof(float)), 0) << threads << " threads";
  }
}

// ---- awake and asleep ---------------------------------------------------------------------------

TEST(WorkerPool, PoolsStartAndStop) {
  for (int threads = 1; threads <= kMostThreads; ++threads) {
    for (int k = 0; k < 5; ++k) WorkerPool pool(threads);  // never awake
    for (int k = 0; k < 5; ++k) {
      WorkerPool pool(threads);
      const Awake awake(pool);  // awake without a run
    }
    for (int k = 0; k < 5; ++k) {
      WorkerPool pool(threads);
      const Awake awake(pool);
      EXPECT_EQ(wrong_jobs(pool, 10), 0u);
    }
  }
}

TEST(WorkerPool, JobsRunWhileTheWorkersSleep) {
  WorkerPool pool(4);
  EXPECT_EQ(wrong_jobs(pool, 100), 0u);
  { const Awake awake(pool); }
  EXPECT_EQ(wrong_jobs(pool, 100), 0u);
}

TEST(WorkerPool, WorkersWakeForEveryStep) {
  WorkerPool pool(3);
  for (int step = 0; step < 500; ++step) {
    const Awake awake(pool);
    ASSERT_EQ(wrong_jobs(pool, static_cast<std::size_t>(step % 20)), 0u);
    if (step % 50 != 0) continue;
    ASSERT_EQ(all_threads(pool, std::this_thread::get_id).size(), 3u);
  }
}

TEST(WorkerPool, WorkersStayAwakeUntilTheOutermostEnds) {
  WorkerPool pool(3);
  const Awake outer(pool);
  for (int k = 0; k < 20; ++k) {
    {
      const Awake inner(pool);
      EXPECT_EQ(wrong_jobs(pool, 50), 0u);
    }
    ASSERT_EQ(all_threads(pool, std::this_thread::get_id).size(), 3u) << "after the inner one ended";
  }
}

TEST(WorkerPool, ManyPoolsRunAtOnce) {
  constexpr int kHosts = 8;
  std::atomic<std::size_t> wrong{0};
  std::vector<std::thread> hosts;
  for (int h = 0; h < kHosts; ++h) {
    hosts.emplace_back([&wrong, h] {
      for (int world = 0; world < 3; ++world) {
        WorkerPool pool(1 + (h + world) % 4);
        for (int step = 0; step < 20; ++step) {
          const Awake awake(pool);
          for (const std::size_t count : {1u, 5u, 40u}) wrong += wrong_jobs(pool, count);
        }
      }
    });
  }
  for (std::thread& t : hosts) t.join();
  EXPECT_EQ(wrong, 0u);
}

// ---- what jobs throw ----------------------------------------------------------------------------

TEST(WorkerPool, WhatAJobThrowsOnOneThreadReachesTheCaller) {
  WorkerPool pool(1);
  const Awake awake(pool);
  int done = 0;
  EXPECT_THROW(pool.run(5,
                        [&](std::size_t i) {
                          if (i == 3) throw std::bad_alloc();
                          ++done;
                        }),
               std::bad_alloc);
  EXPECT_EQ(done, 3);
  EXPECT_EQ(wrong_jobs(pool, 10), 0u);
}

TEST(WorkerPool, WhatTheOnlyJobThrowsReachesTheCaller) {
  WorkerPool pool(3);
  const Awake awake(pool);
  EXPECT_THROW(pool.run(1, [](std::size_t) { throw std::runtime_error("job"); }), std::runtime_error);
  EXPECT_EQ(wrong_jobs(pool, 10), 0u);
}

TEST(WorkerPool, WhatJobsThrowReachesTheCallerWhenAllAreDone) {
  WorkerPool pool(3);
  const Awake awake(pool);
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> begun{0};
    const auto job = [&](std::size_t i) {
      ++begun;
      if (i % 3 == 1) throw std::runtime_error("thrown in a job");
    };
    EXPECT_THROW(pool.run(64, job), std::runtime_error);
    EXPECT_EQ(begun, 64);
    EXPECT_EQ(wrong_jobs(pool, 10), 0u);
  }
}

// ---- a host's job system ------------------------------------------------------------------------

/// Jobs backwards, on a thread of the host.
JobSystem backwards(std::atomic<int>& calls) {
  return {[&calls](std::size_t count, const std::function<void(std::size_t)>& job) {
            ++calls;
            std::thread([&] {
              for (std::size_t i = count; i-- > 0;) job(i);
            }).join();
          },
          2};
}

TEST(WorkerPool, AHostRunsTheJobsUntilItIsTakenAway) {
  for (const int threads : {1, 3}) {
    WorkerPool pool(threads);
    std::atomic<int> calls{0};
    pool.set_job_system(backwards(calls));
    {
      const Awake awake(pool);
      EXPECT_EQ(wrong_jobs(pool, 0), 0u);
      EXPECT_EQ(calls, 0) << "no jobs are no call";
      EXPECT_EQ(wrong_jobs(pool, 1), 0u);
      EXPECT_EQ(wrong_jobs(pool, 100), 0u);
      EXPECT_EQ(calls, 2);
    }
    pool.set_job_system({});
    const Awake awake(pool);
    EXPECT_EQ(wrong_jobs(pool, 100), 0u);
    EXPECT_EQ(calls, 2);
  }
}

// ---- floating-point settings --------------------------------------------------------------------

/// The bits of the smallest normal number over 16, which is 0 where denormal results are flushed. Bits, because
/// settings that read denormals as zero call the two equal. The compiler may not move the division to where other
/// settings hold.
[[gnu::noinline]] std::uint32_t sixteenth_of_the_smallest() {
  volatile float least = std::numeric_limits<float>::min(), sixteen = 16, result = least / sixteen;
  return std::bit_cast<std::uint32_t>(float{result});
}

TEST(WorkerPool, JobsSeeTheFloatSettingsOfTheStepOnEveryThread) {
  WorkerPool pool(3);  // its threads begin with the settings of the host
  const FloatSettings settings;
  const std::uint32_t expected = sixteenth_of_the_smallest();
  const Awake awake(pool);
  std::atomic<int> arrived{0};
  std::vector<std::uint32_t> seen(3, 1);
  pool.run(3, [&](std::size_t i) {  // one job on each thread
    ++arrived;
    EXPECT_TRUE(wait_until([&] { return arrived == 3; }));
    seen[i] = sixteenth_of_the_smallest();
  });
  for (const std::uint32_t s : seen) EXPECT_EQ(s, expected);
}

TEST(WorkerPool, AHostsThreadGetsItsOwnFloatSettingsBack) {
  const std::uint32_t expected = [] {
    const FloatSettings settings;
    return sixteenth_of_the_smallest();
  }();
  WorkerPool pool(1);
  std::uint32_t inside = 1, before = 1, after = 1;
  pool.set_job_system({[&](std::size_t count, const std::function<void(std::size_t)>& job) {
                         before = sixteenth_of_the_smallest();
                         for (std::size_t i = 0; i < count; ++i) job(i);
                         after = sixteenth_of_the_smallest();
                       },
                       1});
  pool.run(2, [&](std::size_t) { inside = sixteenth_of_the_smallest(); });
  EXPECT_EQ(inside, expected);
  EXPECT_EQ(after, before);
  EXPECT_NE(before, 0u) << "this test is for hosts that flush nothing";
}

}  // namespace
}  // namespace psim
