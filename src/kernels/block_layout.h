// The one block width that memory, colouring, snapshots and hashes are made of. It is 8 for every
// ISA: registers of 1, 4 or 8 lanes loop over a block, so results never depend on the register.
#pragma once

#include <cstddef>
#include <cstdint>

namespace psim::kernels {

inline constexpr std::uint32_t kBlock = 8;
inline constexpr std::size_t kAlign = 64;  // bytes: every column starts on a cache line

/// Records that a kernel may read beyond the last body of a column (never used, only loaded).
inline constexpr std::size_t kReadPad = 16;

constexpr std::size_t round_up_block(std::size_t n) { return (n + kBlock - 1) / kBlock * kBlock; }

}  // namespace psim::kernels
