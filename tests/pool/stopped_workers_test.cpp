// The worker pool while the operating system stops its workers, as it does when there are more threads than cores.
#include <pthread.h>

#include <atomic>
#include <csignal>
#include <optional>

#include "pool_support.h"

namespace psim {
namespace {

// A signal stops a worker wherever it is, as the operating system does.
std::atomic<int> stopped_workers{0}, stops{0};
std::atomic<bool> hold_workers{false};

void stop_here(int) {
  ++stopped_workers;
  ++stops;
  const timespec a_while{0, 100'000};
  do nanosleep(&a_while, nullptr);
  while (hold_workers);
  --stopped_workers;
}

class StoppedWorkers : public ::testing::Test {
 protected:
  void SetUp() override {
    struct sigaction action {};
    action.sa_handler = stop_here;
    ASSERT_EQ(sigaction(SIGUSR1, &action, &before_), 0);
  }
  void TearDown() override { sigaction(SIGUSR1, &before_, nullptr); }

  /// The workers of a pool, without the thread that calls.
  static std::vector<pthread_t> workers_of(WorkerPool& pool) {
    std::vector<pthread_t> handles = all_threads(pool, pthread_self);
    std::erase_if(handles, [](pthread_t t) { return pthread_equal(t, pthread_self()); });
    return handles;
  }

 private:
  struct sigaction before_ {};
};

TEST_F(StoppedWorkers, NeverHoldARunUp) {
  WorkerPool pool(4);
  const Awake awake(pool);
  const std::vector<pthread_t> workers = workers_of(pool);
  ASSERT_EQ(workers.size(), 3u);
  hold_workers = true;
  for (const pthread_t t : workers) pthread_kill(t, SIGUSR1);
  const bool all_stopped = wait_until([] { return stopped_workers == 3; });
  // The caller alone does all jobs: if a run waited for a worker, this would hang.
  std::size_t wrong = 0;
  for (int k = 0; all_stopped && k < 100; ++k) wrong += wrong_jobs(pool, 200);
  hold_workers = false;
  EXPECT_TRUE(all_stopped);
  EXPECT_EQ(wrong, 0u);
  EXPECT_TRUE(wait_until([] { return stopped_workers == 0; }));
  // They come back with what they knew of an old run, find it closed, and take part in the next one.
  EXPECT_EQ(all_threads(pool, pthread_self).size(), 4u);
}

TEST_F(StoppedWorkers, LoseNoJobWhereverTheyStop) {
  WorkerPool pool(4);
  std::optional<Awake> awake(pool);
  const std::vector<pthread_t> workers = workers_of(pool);
  ASSERT_EQ(workers.size(), 3u);
  std::atomic<bool> done{false};
  std::thread disturber([&] {
    for (std::size_t k = 0; !done; ++k) {
      pthread_kill(workers[k % workers.size()], SIGUSR1);
      std::this_thread::sleep_for(20us);
    }
  });
  std::size_t wrong = 0;
  const int before = stops;
  for (int step = 0; step < 200 || stops - before < 2000; ++step) {
    if (step % 10 == 9) {  // stopped on the way to sleep or out of it, too
      awake.reset();
      awake.emplace(pool);
    }
    for (const std::size_t count : {1u, 2u, 9u, 64u}) wrong += wrong_jobs(pool, count);
  }
  done = true;
  disturber.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_TRUE(wait_until([] { return stopped_workers == 0; }));
}

}  // namespace
}  // namespace psim
