// Counts every operator new of the test program, on any thread, and lets one of them fail.
#pragma once

#include <cstdint>

namespace psim::test {

/// Allocations since the program began.
std::uint64_t allocations();
/// The allocation of this number since the program began fails, and `all` that come after it; 0: none does.
void fail_allocation(std::uint64_t number, bool all = false);

}  // namespace psim::test
