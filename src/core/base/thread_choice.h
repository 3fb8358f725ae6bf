// Chooses how many threads the next step has, by how long the last steps took. Results do not depend on it.
//
// Where the caller waited for most of a step, a worker lost its core: the next steps have half of the threads. And a step
// of some hundred microseconds may be over sooner on fewer threads, since others must be told of each of its runs: short
// steps are tried with all threads, half of them, and so on down to one. One that turns out to be long gets all of them
// while it runs (worker_pool.h). docs/decisions/006-worker-pool.md
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <utility>

namespace psim {

class ThreadChoice {
 public:
  using Duration = std::chrono::steady_clock::duration;

  /// `crowded`: there are more threads than cores, so that workers lose theirs all the time.
  ThreadChoice(std::size_t threads, bool crowded) : threads_(threads), active_(threads), crowded_(crowded) {
    try_all();
  }

  /// Steps up to here may be over sooner on fewer threads.
  static constexpr std::chrono::microseconds kShort{1000};

  /// Threads of the next step.
  std::size_t active() const { return active_; }
  /// Whether a step that turns out to be long should have all threads after all: no worker lost its core.
  bool may_call_all() const { return fewer_ == 0; }
  /// After a step that took so long, of which the caller waited so long for other threads.
  void note(Duration step, Duration waited);

 private:
  void weigh(Duration step);
  void next_number();
  void try_all();
  void settle();
  // Returns how many threads are left after the number was halved so often; halves are rounded up.
  std::size_t halved(int times) const {
    std::size_t n = threads_;
    for (; times > 0; --times) n = (n + 1) / 2;
    return n;
  }

  static constexpr std::chrono::microseconds kStall{100};  // shorter waits are no reason to do without workers
  // Steps up to kShort are tried (kGrown longer ones in a window of kTried end that), kTried of them with each number of
  // threads, and all of that kRounds times, for other programs come and go. A number that is kChanged times worse than the
  // best ends a round. More threads than need be must be worth it: the fewest are taken whose shortest step is within
  // kWorth of the shortest of all. That stands for kSettled steps, or until the shortest of kTried is kChanged times
  // longer or shorter than it was, or kGrown of a window take kGrownBy times as long.
  static constexpr int kTried = 6, kRounds = 2, kSettled = 1024, kGrown = 2, kGrownBy = 4, kMostHalvings = 16;
  static constexpr double kWorth = 1.25, kChanged = 2;
  static constexpr int kShortPause = 4, kLongPause = 64;

  std::size_t threads_, active_;
  bool crowded_;
  int fewer_ = 0, good_ = 0;  // steps with fewer threads that are to come; good ones in a row
  int pause_ = kShortPause;   // as many after the next that is held up
  bool settled_ = false;
  int grown_ = 0;                        // of up to kTried steps: how many took far longer
  int steps_ = 0;                        // with the present number of threads
  int round_ = 0, halvings_ = 0;         // of the trial; and how often the number of threads was halved
  Duration shortest_[kMostHalvings];     // in the trial, by halvings
  Duration recent_ = Duration::max();    // the shortest of up to kTried steps
  Duration expected_ = Duration::max();  // the shortest, where the trial ended
};

inline void ThreadChoice::note(Duration step, Duration waited) {
  if (fewer_ != 0) {
    if (--fewer_ == 0) active_ = threads_;
    return;
  }
  const bool held_up = !crowded_ && waited > kStall && 2 * waited > step;
  good_ = held_up ? 0 : good_ + 1;
  if (good_ == kLongPause) pause_ = kShortPause;
  if (!held_up) return weigh(step);
  try_all();
  active_ = std::max<std::size_t>(1, threads_ / 2);
  fewer_ = pause_;
  pause_ = std::min(2 * pause_, kLongPause);
}

inline void ThreadChoice::weigh(Duration step) {
  if (threads_ == 1) return;
  const bool is_long = settled_ ? step > kGrownBy * expected_ : step > kShort;
  if (is_long) {
    if (++grown_ == kGrown) settled_ || active_ == threads_ ? try_all() : settle();
    return;
  }
  recent_ = std::min(recent_, step);
  if (++steps_ % kTried != 0) return;
  grown_ = 0;
  const Duration recent = std::exchange(recent_, Duration::max());
  if (settled_) {
    const double ratio = std::chrono::duration<double>(recent) / std::chrono::duration<double>(expected_);
    if (steps_ >= kSettled || ratio > kChanged || ratio * kChanged < 1) try_all();
    return;
  }
  shortest_[halvings_] = std::min(shortest_[halvings_], recent);
  next_number();
}

inline void ThreadChoice::next_number() {
  const Duration best = *std::min_element(shortest_, shortest_ + kMostHalvings);
  const bool worse = std::chrono::duration<double>(shortest_[halvings_]) > kChanged * best;
  if (active_ == 1 || worse) {
    if (++round_ == kRounds) return settle();
    halvings_ = 0;
  } else {
    ++halvings_;
  }
  active_ = halved(halvings_);
}

inline void ThreadChoice::try_all() {
  settled_ = false;
  active_ = threads_;
  steps_ = grown_ = round_ = halvings_ = 0;
  recent_ = Duration::max();
  std::fill_n(shortest_, kMostHalvings, Duration::max());
}

inline void ThreadChoice::settle() {
  settled_ = true;
  steps_ = grown_ = 0;
  recent_ = Duration::max();
  const Duration best = *std::min_element(shortest_, shortest_ + kMostHalvings);
  int k = kMostHalvings - 1;
  while (shortest_[k] == Duration::max() || std::chrono::duration<double>(shortest_[k]) > kWorth * best) --k;
  active_ = halved(k);
  expected_ = shortest_[k];
}

}  // namespace psim
