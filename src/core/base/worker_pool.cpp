#include "base/worker_pool.h"

#include <algorithm>
#include <chrono>
#include <exception>

namespace psim {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kLongWait = 64;  // spins; what takes longer is measured

constexpr std::uint64_t pack(std::uint32_t ticket, std::uint32_t number) {
  return static_cast<std::uint64_t>(ticket) << 32 | number;
}

}  // namespace

WorkerPool::WorkerPool(int threads, Tracer* tracer)
    : threads_(kHasThreads ? static_cast<std::size_t>(threads) : 1),
      tracer_(tracer),
      crowded_(threads_ > std::thread::hardware_concurrency()),
      choice_(threads_, crowded_),
      present_(threads_),
      shares_(std::make_unique<Share[]>(threads_)) {
  workers_.reserve(threads_);
  try {
    for (std::size_t i = 1; i < threads_; ++i) {
      workers_.emplace_back([this, i] { worker(i); });
    }
  } catch (const std::exception&) {  // std::system_error, or no memory for what a thread needs
    keep_workers(workers_.size() / 2);
    threads_ = workers_.size() + 1;
    choice_ = {threads_, crowded_};
    present_ = threads_;
  }
}

WorkerPool::~WorkerPool() { keep_workers(0); }

// Ends all workers but the first `kept`. Where the system starts no more threads, it lacks memory: the stacks of half of
// them are more use to the world.
void WorkerPool::keep_workers(std::size_t kept) {
  {
    const std::lock_guard lock(sleep_mutex_);
    kept_ = kept;
  }
  wake_.notify_all();
  for (std::size_t i = kept; i < workers_.size(); ++i) workers_[i].join();
  workers_.resize(kept);
}

WorkerPool::Awake::Awake(WorkerPool& pool, Work work) : pool_(pool), work_(work) {
  if (++pool.awake_ > 1 || pool.threads_ == 1 || pool.host_.parallel_for) return;
  pool.begin_ = Clock::now();
  pool.waited_ = {};
  pool.looked_ = 0;
  pool.present_ = work == Work::step ? pool.choice_.active() : pool.threads_;
  if (pool.present_ != 1) pool.call_workers();
}

WorkerPool::Awake::~Awake() {
  if (--pool_.awake_ != 0) return;
  pool_.stepping_.store(0, std::memory_order_release);
  pool_.present_ = pool_.threads_;
  if (work_ != Work::step || pool_.threads_ == 1 || pool_.host_.parallel_for) return;
  pool_.choice_.note(Clock::now() - pool_.begin_, pool_.waited_);
}

// Wakes as many workers as the present work has.
void WorkerPool::call_workers() {
  bool any_asleep = false;
  {
    const std::lock_guard lock(sleep_mutex_);
    stepping_.store(present_, std::memory_order_release);
    any_asleep = asleep_ != 0;
  }
  if (any_asleep) wake_.notify_all();
}

// Whether a run is shared, in a step that has fewer threads than there are. One that turns out to be long has all of them
// from then on.
bool WorkerPool::is_shared() {
  constexpr unsigned kRuns = 4;  // the clock is read once in so many
  if (++looked_ % kRuns == 0 && choice_.may_call_all() && Clock::now() - begin_ > ThreadChoice::kShort) {
    present_ = threads_;
    call_workers();
  }
  return present_ != 1;
}

void WorkerPool::wait_a_moment(int spins) const {
  if (crowded_ && spins > 64) {
    std::this_thread::yield();
  } else {
    pause_briefly();
  }
}

// Opens a run, works on it and waits for the last claimed job. A worker that reads the call under a
// ticket and then claims under the same ticket is safe: while any job of the run is unfinished the
// call stands. The odd ticket closes the shares while they are rewritten. done_ is reset by a relaxed store:
// whoever adds to it has read a share that was opened after the reset, and nobody adds for an earlier run any more.
void WorkerPool::run_here(std::size_t count, Call call, const void* context) {
  const std::uint32_t closed = ticket_.load(std::memory_order_relaxed);
  const std::uint32_t open = closed + 1;
  call_.store(call, std::memory_order_relaxed);
  context_.store(context, std::memory_order_relaxed);
  done_.store(0, std::memory_order_relaxed);
  const std::size_t threads = present_;
  for (std::size_t t = 0; t < threads; ++t) {
    shares_[t].end.store(static_cast<std::uint32_t>(count * (t + 1) / threads), std::memory_order_relaxed);
    shares_[t].next.store(pack(open, static_cast<std::uint32_t>(count * t / threads)), std::memory_order_release);
  }
  ticket_.store(open, std::memory_order_release);
  done_.fetch_add(work(0, open), std::memory_order_acq_rel);
  const bool traced = tracer_ != nullptr && tracer_->on() && done_.load(std::memory_order_acquire) != count;
  const Tracer::Clock::time_point begin = traced ? Tracer::Clock::now() : Tracer::Clock::time_point{};
  {
    LateZone zone;
    int spins = 0;
    Clock::time_point long_since;
    for (; done_.load(std::memory_order_acquire) != count; ++spins) {
      zone.begin(kWaitName);
      if (spins == kLongWait) long_since = Clock::now();
      wait_a_moment(spins);
    }
    if (spins > kLongWait) waited_ += Clock::now() - long_since;
  }
  if (traced) tracer_->add(0, kWaitName, begin, Tracer::Clock::now());
  for (std::size_t t = 0; t < threads; ++t) {
    shares_[t].next.store(pack(open + 1, 0xFFFFFFFFu), std::memory_order_release);
  }
  ticket_.store(open + 1, std::memory_order_release);
  throw_what_was_thrown();
}

void WorkerPool::throw_what_was_thrown() {
  if (!failed_.load(std::memory_order_relaxed)) return;
  failed_.store(false, std::memory_order_relaxed);
  std::rethrow_exception(std::exchange(thrown_, nullptr));
}

// Claims and runs jobs under the ticket until none is left; returns how many.
std::size_t WorkerPool::work(std::size_t home, std::uint32_t ticket) noexcept {
  std::size_t finished = 0;
  LateZone zone;  // a worker's; the caller is in the zone of the stage
  for (std::size_t step = 0; step < threads_; ++step) {
    Share& share = shares_[(home + step) % threads_];
    std::uint64_t next = share.next.load(std::memory_order_acquire);
    while (static_cast<std::uint32_t>(next >> 32) == ticket) {
      const auto number = static_cast<std::uint32_t>(next);
      const std::uint32_t end = share.end.load(std::memory_order_relaxed);
      const Call call = call_.load(std::memory_order_relaxed);
      const void* context = context_.load(std::memory_order_relaxed);
      if (number >= end) break;
      // An eighth of what is left at a time: small jobs cost less than claiming them would.
      const std::uint32_t claimed = std::max(1u, (end - number) / 8);
      // Acquire and release keep the chain from the caller's opening store through all claims. A failed exchange has
      // read a newer `next`, whose ticket is looked at before `end` and the call are read again: acquire.
      if (!share.next.compare_exchange_weak(next, pack(ticket, number + claimed), std::memory_order_acq_rel,
                                            std::memory_order_acquire)) {
        continue;
      }
      // Read under a claim: the run was opened after the stage was set.
      if (home != 0 && tracer_ != nullptr) zone.begin(tracer_->stage());
      for (std::uint32_t n = number; n < number + claimed; ++n) {
        attempt([=] { call(context, n); });
      }
      finished += claimed;
      next = share.next.load(std::memory_order_acquire);
    }
  }
  return finished;
}

// Where the next step follows at once, to fall asleep and to be woken would take longer than a small step.
void WorkerPool::stay_up(std::size_t index) const {
  if (crowded_) return;
  constexpr std::chrono::microseconds kLong{50};
  const auto begin = Clock::now();
  while (Clock::now() - begin < kLong) {
    for (int k = 0; k < 16; ++k) {
      if (steps(index)) return;
      pause_briefly();
    }
  }
}

void WorkerPool::worker(std::size_t index) {
  const FloatSettings settings;
  std::uint32_t seen = 1;
  for (;;) {
    if (!steps(index)) stay_up(index);
    if (!steps(index)) {
      std::unique_lock lock(sleep_mutex_);
      ++asleep_;
      wake_.wait(lock, [this, index] { return index > kept_ || steps(index); });
      --asleep_;
      if (index > kept_) return;
    }
    int spins = 0;
    std::uint32_t ticket = ticket_.load(std::memory_order_acquire);
    while ((ticket == seen || (ticket & 1u) != 0) && steps(index)) {
      wait_a_moment(++spins);
      ticket = ticket_.load(std::memory_order_acquire);
    }
    if ((ticket & 1u) != 0 || ticket == seen) continue;
    seen = ticket;
    const bool traced = tracer_ != nullptr && tracer_->on();
    const Tracer::Clock::time_point begin = traced ? Tracer::Clock::now() : Tracer::Clock::time_point{};
    const std::size_t finished = work(index, ticket);
    if (finished == 0) continue;
    if (traced) tracer_->add(index, tracer_->stage(), begin, Tracer::Clock::now());
    done_.fetch_add(finished, std::memory_order_acq_rel);
  }
}

}  // namespace psim
