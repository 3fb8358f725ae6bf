// Independent jobs of a picture on several threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace psim::cli {

/// job(number, worker) for every number below `jobs`, worker 0 being the caller. Threads are started for it, about 30
/// microseconds each, and have ended when it returns; none with one thread. Which worker gets which number is left to
/// chance.
template <class Job>
void share_out(std::size_t jobs, int threads, const Job& job) {
  std::atomic<std::size_t> next{0};
  const auto work = [&](std::size_t worker) {
    for (std::size_t number; (number = next.fetch_add(1, std::memory_order_relaxed)) < jobs;) job(number, worker);
  };
  std::vector<std::jthread> helpers;
  for (std::size_t worker = 1; worker < static_cast<std::size_t>(threads) && worker < jobs; ++worker) {
    helpers.emplace_back(work, worker);
  }
  work(0);
}

}  // namespace psim::cli
