// Jobs of the passes over joints: ranges of blocks that run side by side.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "base/worker_pool.h"

namespace psim {

/// Some blocks of a list of joints.
struct ListRange {
  std::uint32_t list = 0, begin = 0, end = 0;  ///< blocks of a list
};
/// Jobs that go over some ranges each.
struct JointJobs {
  std::vector<ListRange> ranges;
  std::vector<BlockRange> jobs;  ///< in `ranges`

  std::uint32_t count() const { return static_cast<std::uint32_t>(jobs.size()); }
  void clear() {
    ranges.clear();
    jobs.clear();
  }
  void add(std::span<const ListRange> job) {
    const auto begin = static_cast<std::uint32_t>(ranges.size());
    ranges.insert(ranges.end(), job.begin(), job.end());
    jobs.push_back({begin, static_cast<std::uint32_t>(ranges.size())});
  }
  /// Runs each(range) over the ranges of some jobs, which run side by side; or of all.
  template <class Each>
  void run(BlockRange some, WorkerPool& pool, const Each& each) const {
    pool.run(some.end - some.begin, [&](std::size_t n) {
      const BlockRange& job = jobs[some.begin + n];
      for (std::uint32_t r = job.begin; r < job.end; ++r) each(ranges[r]);
    });
  }
  template <class Each>
  void run(WorkerPool& pool, const Each& each) const {
    run({0, count()}, pool, each);
  }
};

}  // namespace psim
