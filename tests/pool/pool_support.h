// What the tests of the worker pool share.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <thread>
#include <vector>

#include "base/worker_pool.h"

namespace psim {

using namespace std::chrono_literals;
/// Awake for work that is no step: it has all threads, however long it takes.
struct Awake : WorkerPool::Awake {
  explicit Awake(WorkerPool& pool) : WorkerPool::Awake(pool, WorkerPool::Work::other) {}
};

/// Waits until `true_now()` holds; false after ten seconds, so that a fault is a failed test and no hanging one.
template <class Condition>
bool wait_until(const Condition& true_now) {
  const auto end = std::chrono::steady_clock::now() + 10s;
  while (!true_now()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(50us);
  }
  return true;
}

/// Runs `count` jobs; the number of those that did not run exactly once.
inline std::size_t wrong_jobs(WorkerPool& pool, std::size_t count) {
  std::vector<std::atomic<int>> runs(count);
  pool.run(count, [&](std::size_t i) { runs[i].fetch_add(1, std::memory_order_relaxed); });
  std::size_t wrong = 0;
  for (const auto& r : runs) wrong += r.load(std::memory_order_relaxed) != 1;
  return wrong;
}

/// One job a thread, each of which waits for all the others: every thread of the pool runs one. Returns what `self()`
/// gives on each, on the caller's too; nothing if a thread did not come.
template <class Self>
auto all_threads(WorkerPool& pool, const Self& self) {
  const auto threads = static_cast<std::size_t>(pool.threads());
  std::vector<decltype(self())> handles(threads);
  std::atomic<std::size_t> arrived{0};
  std::atomic<bool> complete{true};
  pool.run(threads, [&](std::size_t i) {
    handles[i] = self();
    ++arrived;
    if (!wait_until([&] { return arrived == threads; })) complete = false;
  });
  if (!complete) handles.clear();
  return handles;
}

}  // namespace psim
