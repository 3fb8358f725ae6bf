// How body columns are cut into jobs: by number of bodies alone, never by threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace psim {

struct BlockRange {
  std::uint32_t begin = 0, end = 0;
};

/// Floating-point settings of every thread during a step: round to nearest, denormals flushed and
/// read as zero, no traps. A host may have others.
inline constexpr unsigned kMxcsr = 0x9FC0;

inline constexpr std::uint32_t kTaskBlocks = 256;  // 2048 bodies: a job of some microseconds

inline std::size_t stream_tasks(std::uint32_t blocks) {
  return (blocks + kTaskBlocks - 1) / kTaskBlocks;
}

inline BlockRange stream_range(std::size_t task, std::uint32_t blocks) {
  const auto begin = static_cast<std::uint32_t>(task) * kTaskBlocks;
  return {begin, std::min(blocks, begin + kTaskBlocks)};
}

/// Phases of strips, in order: even ones, odd ones, the large bodies' group, which is the last. Runs those
/// from the `begin`-th to before the `end`-th in that order, each(strip); no two of a phase share a body.
template <class Pool, class Each>
void run_phases(std::size_t strips, std::size_t begin, std::size_t end, Pool& pool, const Each& each) {
  const std::size_t grid = strips - 1, even = (grid + 1) / 2;
  const std::size_t mid = std::clamp(even, begin, end), last = std::clamp(grid, mid, end);
  pool.run(mid - begin, [&](std::size_t n) { each(2 * (begin + n)); });
  pool.run(last - mid, [&](std::size_t n) { each(2 * (mid + n - even) + 1); });
  if (last < end) each(grid);
}

}  // namespace psim
