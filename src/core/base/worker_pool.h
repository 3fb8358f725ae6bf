// Worker threads that take numbered jobs. run(count, job) returns when job(0..count-1) are done, in any order,
// on any thread, the caller's among them. Each job writes its own places, so results do not depend on which
// thread ran it.
//
// Each thread starts on its own share of the numbers, so that a range meets the same cache again, then helps the
// others. Between the runs of a step workers spin; between steps they sleep, if the next one does not follow at once. A
// late worker never delays a run, because run() waits for claimed jobs only. A worker that the system puts aside within
// a job does, and a small step is done sooner by one thread: thread_choice.h decides how many threads a step has.
//
// A job that throws does not keep the others from running. When all are done, run() throws what the first one threw.
//
// What a job wrote is seen after run() and by the jobs of all later runs, on processors with a weak memory order, too:
// the worker adds to done_ (release), the caller reads it (acquire) and opens the next run by Share::next (release),
// which a worker reads (acquire) before it takes a job. Flags and counters that jobs of one run share can therefore be
// relaxed if nothing but their own value is read from them during the run.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/machine.h"
#include "base/thread_choice.h"
#include "base/trace.h"
#include "psim/jobs.h"

namespace psim {

class WorkerPool {
  using Call = void (*)(const void* context, std::size_t i);

 public:
  /// Starts threads - 1 workers; fewer, if the system starts no more (threads() says how many there are).
  explicit WorkerPool(int threads, Tracer* tracer = nullptr);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(threads_); }
  /// Threads that the next step begins with.
  int active() const { return static_cast<int>(choice_.active()); }
  void set_job_system(JobSystem jobs) { host_ = std::move(jobs); }

  /// Says what the workers are awake for. How long steps take decides how many threads the next ones have; other work has
  /// all threads.
  enum class Work : std::uint8_t { step, other };

  /// Keeps the workers awake for its lifetime, however the work ends. One within another changes nothing.
  class Awake {
   public:
    Awake(WorkerPool& pool, Work work);
    ~Awake();
    Awake(const Awake&) = delete;
    Awake& operator=(const Awake&) = delete;

   private:
    WorkerPool& pool_;
    Work work_;
  };

  template <class Job>
  void run(std::size_t count, const Job& job) {
    if (count == 0) return;
    if (host_.parallel_for) {
      host_.parallel_for(count, [this, &job](std::size_t i) {
        const FloatSettings settings;
        attempt([&] { job(i); });
      });
      throw_what_was_thrown();
    } else if (count == 1 || threads_ == 1 || (present_ != threads_ && !is_shared())) {
      for (std::size_t i = 0; i < count; ++i) job(i);
    } else {
      const auto call = [](const void* context, std::size_t i) { (*static_cast<const Job*>(context))(i); };
      run_here(count, call, &job);
    }
  }

 private:
  // One thread's share of a run: the next number to claim, with the ticket of the run above it. The caller writes `next`
  // by release after `end`, the call and the context, and a worker reads it by acquire before them: under the ticket of a
  // run it finds those of this run, or of a later one, and then its claim fails.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> next{0};  // ticket << 32 | number
    std::atomic<std::uint32_t> end{0};
  };

  // Runs a job and keeps the first thing that one throws.
  template <class Job>
  void attempt(const Job& job) noexcept {
    try {
      job();
    } catch (...) {
      if (!failed_.exchange(true, std::memory_order_relaxed)) thrown_ = std::current_exception();
    }
  }
  void throw_what_was_thrown();
  void run_here(std::size_t count, Call call, const void* context);
  std::size_t work(std::size_t home, std::uint32_t ticket) noexcept;
  void worker(std::size_t index);
  void keep_workers(std::size_t kept);
  void call_workers();
  bool is_shared();
  void wait_a_moment(int spins) const;
  void stay_up(std::size_t index) const;
  bool steps(std::size_t index) const { return index < stepping_.load(std::memory_order_acquire); }

  std::size_t threads_;  // the caller's among them; written before the first run
  Tracer* tracer_;
  const bool crowded_;  // there are more threads than cores, so waiting yields the core
  int awake_ = 0;       // how many Awake there are
  ThreadChoice choice_;
  std::size_t present_;                           // threads of the present work, the caller's among them
  unsigned looked_ = 0;                           // runs of a step on fewer threads than there are
  std::chrono::steady_clock::time_point begin_;   // of the outermost Awake
  std::chrono::steady_clock::duration waited_{};  // of this step, the caller for others
  JobSystem host_;
  std::unique_ptr<Share[]> shares_;
  // The call of the open run. Relaxed: Share::next orders both.
  std::atomic<Call> call_{nullptr};
  std::atomic<const void*> context_{nullptr};
  // Even: open run; odd: none open. Only the caller writes it, by release, so that a worker that reads a run's ticket by
  // acquire finds its shares open or closed, and never as an earlier run left them.
  alignas(64) std::atomic<std::uint32_t> ticket_{1};
  // Finished jobs. Each worker adds by release and every addition continues the chain, so the caller that reads the full
  // count by acquire sees what all workers wrote.
  alignas(64) std::atomic<std::size_t> done_{0};
  // The first thing that a job of the open run threw. Relaxed: done_ orders both for the caller, who reads them last.
  std::atomic<bool> failed_{false};
  std::exception_ptr thrown_;
  // Threads of the present step, the caller's among them; 0 between steps. Says who spins and carries no data. It is set
  // under the lock, so that no worker sleeps through it.
  std::atomic<std::size_t> stepping_{0};
  std::size_t kept_ = SIZE_MAX;  // workers of a higher index end; under the lock
  std::size_t asleep_ = 0;       // under the lock
  std::mutex sleep_mutex_;
  std::condition_variable wake_;
  std::vector<std::thread> workers_;
};

}  // namespace psim
