// One line on stderr for runs over a second: frames done, ms a frame, time left. Silent when stderr
// is no terminal.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace psim::cli {

class Progress {
 public:
  using Clock = std::chrono::steady_clock;

  /// `what` stands in front of the figures.
  Progress(std::string what, std::uint64_t frames);
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// After every frame; `now` is handed in because the caller has just read the clock.
  void update(std::uint64_t frames_done, Clock::time_point now) {
    if (is_terminal_ && now >= next_) draw(frames_done, now);
  }
  /// Wipes the line.
  void clear();

 private:
  void draw(std::uint64_t frames_done, Clock::time_point now);

  std::string what_;
  std::uint64_t frames_;
  bool is_terminal_;
  bool drawn_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_ + std::chrono::seconds(1);
};

}  // namespace psim::cli
