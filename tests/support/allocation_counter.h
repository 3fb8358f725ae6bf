// Counts every operator new of the test program, on any thread.
#pragma once

#include <cstdint>

namespace psim::test {

/// Allocations since the program began.
std::uint64_t allocations();

}  // namespace psim::test
