// The worker threads of a host, for those who do not want the ones that a world starts.
#pragma once

#include <cstddef>
#include <functional>

namespace psim {

/// A host's own job system: psim calls `parallel_for(count, job)`; the host runs job(0..count-1) on
/// any of its threads in any order and returns when all are done.
struct JobSystem {
  /// Called from the thread that steps, several times a step. Empty: the world's own workers.
  std::function<void(std::size_t count, const std::function<void(std::size_t)>& job)> parallel_for;
  int workers = 1;  ///< how many of the host's threads may run jobs at once
};

}  // namespace psim
