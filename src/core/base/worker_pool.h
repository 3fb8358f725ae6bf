// Worker threads that take numbered jobs. run(count, job) returns when job(0..count-1) are done, in any order,
// on any thread, the caller's among them. Each job writes its own places, so results do not depend on which
// thread ran it.
//
// Each thread starts on its own share of the numbers, so that a range meets the same cache again, then helps the
// others. Between the runs of a step workers spin; between steps they sleep. A late worker never delays a run,
// because run() waits for claimed jobs only.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/machine.h"
#include "base/trace.h"
#include "psim/jobs.h"

namespace psim {

class WorkerPool {
  using Call = void (*)(const void* context, std::size_t i);

 public:
  explicit WorkerPool(int threads, Tracer* tracer = nullptr);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(threads_); }
  void set_job_system(JobSystem jobs) { host_ = std::move(jobs); }

  /// Keeps the workers awake for its lifetime, however the step ends. One within another changes nothing.
  class Awake {
   public:
    explicit Awake(WorkerPool& pool);
    ~Awake();
    Awake(const Awake&) = delete;
    Awake& operator=(const Awake&) = delete;

   private:
    WorkerPool& pool_;
  };

  template <class Job>
  void run(std::size_t count, const Job& job) {
    if (count == 0) return;
    if (host_.parallel_for) {
      host_.parallel_for(count, [&job](std::size_t i) {
        const FloatSettings settings;
        job(i);
      });
    } else if (threads_ == 1 || count == 1) {
      for (std::size_t i = 0; i < count; ++i) job(i);
    } else {
      const auto call = [](const void* context, std::size_t i) { (*static_cast<const Job*>(context))(i); };
      run_here(count, call, &job);
    }
  }

 private:
  // One thread's share of a run: the next number to claim, with the ticket of the run above it.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> next{0};  // ticket << 32 | number
    std::atomic<std::uint32_t> end{0};
  };

  void run_here(std::size_t count, Call call, const void* context);
  // noexcept: an exception in a job ends the program, because jobs of other threads still run.
  std::size_t work(std::size_t home, std::uint32_t ticket) noexcept;
  void worker(std::size_t index);
  void wait_a_moment(int spins) const;

  std::size_t threads_;
  Tracer* tracer_;
  bool crowded_;   // there are more threads than cores, so waiting yields the core
  int awake_ = 0;  // how many Awake there are
  JobSystem host_;
  std::unique_ptr<Share[]> shares_;
  std::atomic<Call> call_{nullptr};
  std::atomic<const void*> context_{nullptr};
  alignas(64) std::atomic<std::uint32_t> ticket_{1};  // even: open run; odd: none open
  alignas(64) std::atomic<std::size_t> done_{0};
  std::atomic<bool> stepping_{false};
  std::atomic<bool> quit_{false};
  std::mutex sleep_mutex_;
  std::condition_variable wake_;
  std::vector<std::thread> workers_;
};

}  // namespace psim
