// Chooses how many threads the next step has, by how long the last steps took. Results do not depend on it.
//
// Where the caller waited for most of a step, a worker lost its core: the next steps have half of the threads. And a step
// of some ten microseconds is over sooner on one thread than others can be told of it: small steps are tried both ways.
// docs/decisions/006-worker-pool.md
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace psim {

class ThreadChoice {
 public:
  using Duration = std::chrono::steady_clock::duration;

  /// `crowded`: there are more threads than cores, so that workers lose theirs all the time.
  ThreadChoice(std::size_t threads, bool crowded) : threads_(threads), active_(threads), crowded_(crowded) {}

  /// Threads of the next step.
  std::size_t active() const { return active_; }
  /// After a step that took so long, of which the caller waited so long for other threads.
  void note(Duration step, Duration waited);

 private:
  enum class Trial { together, alone, settled };

  void weigh(Duration step);
  void go_on(Trial trial);

  static constexpr std::chrono::microseconds kStall{100};  // shorter waits are no reason to do without workers
  // Steps up to kSmall are tried both ways, kTried steps each; so are those on one thread that grew to kGrown. The choice
  // stands for kSettled steps.
  static constexpr std::chrono::microseconds kSmall{150}, kGrown{200};
  static constexpr int kTried = 8, kSettled = 1024;
  static constexpr int kShortPause = 4, kLongPause = 64;

  std::size_t threads_, active_;
  bool crowded_;
  int fewer_ = 0, good_ = 0;  // steps with fewer threads that are to come; good ones in a row
  int pause_ = kShortPause;   // as many after the next that is held up
  // Small steps in a row: of the present part of a trial, and the shortest of those together and of those alone.
  Trial trial_ = Trial::together;
  int small_ = 0;
  Duration together_ = Duration::max(), alone_ = Duration::max();
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
  go_on(Trial::together);
  active_ = std::max<std::size_t>(1, threads_ / 2);
  fewer_ = pause_;
  pause_ = std::min(2 * pause_, kLongPause);
}

inline void ThreadChoice::weigh(Duration step) {
  if (threads_ == 1) return;
  const bool alone = active_ == 1;
  if (step > (alone ? kGrown : kSmall)) return go_on(Trial::together);
  Duration& best = alone ? alone_ : together_;
  if (trial_ != Trial::settled) best = std::min(best, step);
  if (++small_ < (trial_ == Trial::settled ? kSettled : kTried)) return;
  go_on(trial_ == Trial::together ? Trial::alone : trial_ == Trial::alone ? Trial::settled : Trial::together);
}

inline void ThreadChoice::go_on(Trial trial) {
  trial_ = trial;
  small_ = 0;
  if (trial == Trial::together) together_ = alone_ = Duration::max();
  active_ = trial == Trial::alone || (trial == Trial::settled && alone_ < together_) ? 1 : threads_;
}

}  // namespace psim
