// The sorts that the engine writes itself, against those of the standard library.
#include "base/sort_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace psim {
namespace {

TEST(SortKeys, ByTheUpperHalfKeepsTheOrderOfEqualOnes) {
  std::uint64_t seed = 1;
  const auto drawn = [&seed] { return mixed(seed += 0x9E3779B97F4A7C15u); };
  for (const std::uint64_t most : {std::uint64_t{1}, std::uint64_t{5}, std::uint64_t{3000}, std::uint64_t{1} << 32}) {
    for (const std::size_t count : {0u, 1u, 2u, 7u, 5000u}) {
      std::vector<std::uint64_t> keys;
      for (std::size_t k = 0; k < count; ++k) keys.push_back((drawn() % most) << 32 | (drawn() & 0xFFFFFFFFu));
      std::vector<std::uint64_t> want = keys;
      std::stable_sort(want.begin(), want.end(),
                       [](std::uint64_t a, std::uint64_t b) { return (a >> 32) < (b >> 32); });
      sort_by_upper_half(keys);
      EXPECT_EQ(keys, want) << most << ", " << count;
    }
  }
}

}  // namespace
}  // namespace psim
