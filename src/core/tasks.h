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

}  // namespace psim
