#include "model/sim_thread.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <exception>
#include <utility>

namespace psim::view {

SimThread::SimThread(std::unique_ptr<Simulation> simulation, bool lockstep)
    : simulation_(std::move(simulation)), lockstep_(lockstep) {
  simulation_->tell(status_);
  thread_ = std::thread([this] { run(); });
}

SimThread::~SimThread() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void SimThread::post(Command command) {
  {
    const std::lock_guard lock(mutex_);
    commands_.push_back(std::move(command));
  }
  wake_.notify_one();
}

Status SimThread::status() {
  const std::lock_guard lock(mutex_);
  Status copy = status_;
  status_.steps.clear();
  return copy;
}

void SimThread::advance() {
  std::unique_lock lock(mutex_);
  const std::uint64_t ticket = ++asked_;
  wake_.notify_one();
  done_.wait(lock, [&] { return answered_ >= ticket; });
}

// Whether a step is due, `seconds` after the last question. What the simulation is behind by more
// than kMostBehind is forgotten: it then runs slower than the clock, and the view stays smooth.
bool SimThread::due(double seconds) {
  constexpr double kMostBehind = 0.05;
  const double dt = simulation_->dt();
  accumulator_ = std::min(accumulator_ + seconds * simulation_->speed, dt + kMostBehind);
  if (accumulator_ < dt) return false;
  accumulator_ -= dt;
  return true;
}

void SimThread::run() {
  using Clock = std::chrono::steady_clock;
  constexpr auto kTick = std::chrono::microseconds(500);
  Clock::time_point last = Clock::now();
  std::vector<Command> commands;
  for (;;) {
    std::uint64_t asked = 0;
    {
      std::unique_lock lock(mutex_);
      const auto ready = [&] { return quit_ || !commands_.empty() || asked_ > answered_; };
      if (lockstep_) {
        wake_.wait(lock, [&] { return quit_ || asked_ > answered_; });
      } else if (simulation_->wants_step()) {
        wake_.wait_for(lock, kTick, ready);
      } else {
        wake_.wait(lock, ready);
        last = Clock::now();  // time stood still
      }
      if (quit_) return;
      commands.swap(commands_);
      asked = asked_;
    }
    const bool changed = !commands.empty();
    for (Command& command : commands) {
      try {
        command(*simulation_);
      } catch (const std::exception& error) {
        simulation_->say(error.what());
      }
    }
    commands.clear();

    bool stepped = lockstep_;
    if (!lockstep_) {
      const Clock::time_point now = Clock::now();
      stepped = due(std::chrono::duration<double>(now - last).count()) || simulation_->paused;
      last = now;
    }
    stepped = stepped && simulation_->wants_step();
    if (stepped) simulation_->step();
    if (!stepped && !changed && asked == answered_) continue;

    // Told into a copy, so that the view never waits for a hash or a list of touches.
    Status fresh;
    {
      const std::lock_guard lock(mutex_);
      fresh = status_;
    }
    fresh.steps.clear();
    simulation_->tell(fresh);
    const std::lock_guard lock(mutex_);
    constexpr std::size_t kMostUnread = 1024;  // of a window that nobody looks at
    if (status_.run_serial == fresh.run_serial && status_.steps.size() < kMostUnread) {
      fresh.steps.insert(fresh.steps.begin(), status_.steps.begin(), status_.steps.end());
    }
    status_ = std::move(fresh);
    answered_ = asked;
    done_.notify_all();
  }
}

}  // namespace psim::view
