// Runs a Simulation on its own thread, at its fixed step and in real time as far as it keeps up.
// The view posts what shall be done and reads how it stands; neither waits for a step.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "model/simulation.h"

namespace psim::view {

class SimThread {
 public:
  using Command = std::function<void(Simulation&)>;

  /// `lockstep`: steps only in advance(), one a call, whatever the clock says.
  SimThread(std::unique_ptr<Simulation> simulation, bool lockstep);
  ~SimThread();
  SimThread(const SimThread&) = delete;
  SimThread& operator=(const SimThread&) = delete;

  /// Runs between two steps, in the order of the calls.
  void post(Command command);
  /// The newest status. `steps` are those since the last call.
  Status status();
  /// Lockstep: what was posted is done, and one step unless paused, when it returns.
  void advance();

 private:
  void run();
  bool due(double seconds);

  std::unique_ptr<Simulation> simulation_;  // of the thread
  const bool lockstep_;
  double accumulator_ = 0;  // of the thread: seconds not yet simulated

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::vector<Command> commands_;
  Status status_;
  std::uint64_t asked_ = 0, answered_ = 0;  // calls of advance()
  bool quit_ = false;
  std::thread thread_;
};

}  // namespace psim::view
