// How body columns are cut into jobs: by the number of bodies alone, never by the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace psim {

struct BlockRange {
  std::uint32_t begin = 0, end = 0;
};

inline constexpr std::uint32_t kTaskBlocks = 256;  // 2048 bodies, which take some microseconds

inline std::size_t jobs_for(std::size_t n, std::size_t size) { return (n + size - 1) / size; }

/// Runs each(range) over the ranges of `blocks` blocks.
template <class Pool, class Each>
void run_stream(std::uint32_t blocks, Pool& pool, const Each& each) {
  pool.run(jobs_for(blocks, kTaskBlocks), [&](std::size_t task) {
    const auto begin = static_cast<std::uint32_t>(task) * kTaskBlocks;
    each(BlockRange{begin, std::min(blocks, begin + kTaskBlocks)});
  });
}

/// Runs each(k, job) for every k below n, in jobs of `size`.
template <class Pool, class Each>
void run_each(std::size_t n, std::size_t size, Pool& pool, const Each& each) {
  pool.run(jobs_for(n, size), [&](std::size_t job) {
    for (std::size_t k = job * size, end = std::min(n, k + size); k < end; ++k) each(k, job);
  });
}

/// Runs each(strip) over strips in three phases: even strips, odd strips, then the last strip, the group of large
/// bodies. No two strips of a phase share a body. `begin` and `end` count strips in that order.
template <class Pool, class Each>
void run_phases(std::size_t strips, std::size_t begin, std::size_t end, Pool& pool, const Each& each) {
  const std::size_t grid = strips - 1, even = (grid + 1) / 2;
  const std::size_t mid = std::clamp(even, begin, end), last = std::clamp(grid, mid, end);
  pool.run(mid - begin, [&](std::size_t n) { each(2 * (begin + n)); });
  pool.run(last - mid, [&](std::size_t n) { each(2 * (mid + n - even) + 1); });
  if (last < end) each(grid);
}
/// The same for all strips.
template <class Pool, class Each>
void run_phases(std::size_t strips, Pool& pool, const Each& each) {
  run_phases(strips, 0, strips, pool, each);
}

}  // namespace psim
