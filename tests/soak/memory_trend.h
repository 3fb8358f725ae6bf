// Whether the memory of a soak grows: samples once a minute of game time, the middle one of the last third against that
// of the third before. The first third is for arrays that come to their size.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace psim::soak {

struct MemoryTrend {
  std::size_t before = 0, after = 0;  ///< bytes
  bool grows = false;
};

/// `share` of what there was and `bytes` more are flat. At least 3 samples.
inline MemoryTrend memory_trend(const std::vector<std::size_t>& samples, double share, std::size_t bytes) {
  const auto middle = [&](std::size_t third) {
    const std::size_t n = samples.size();
    std::vector<std::size_t> part(samples.begin() + static_cast<std::ptrdiff_t>(n * third / 3),
                                  samples.begin() + static_cast<std::ptrdiff_t>(n * (third + 1) / 3));
    std::sort(part.begin(), part.end());
    return part[part.size() / 2];
  };
  MemoryTrend out{middle(1), middle(2)};
  out.grows =
      static_cast<double>(out.after) > (1 + share) * static_cast<double>(out.before) + static_cast<double>(bytes);
  return out;
}

/// Of what is in use and no array of the world: it has no reason to grow. A leak of b bytes a step is 1,200 b bytes in
/// each minute of the soak between the two middles.
inline MemoryTrend uncounted_trend(const std::vector<std::size_t>& samples) {
  return memory_trend(samples, 0, 48 << 10);
}

/// Of memory_bytes: arrays grow by half when they meet a new most, ever more seldom.
inline MemoryTrend counted_trend(const std::vector<std::size_t>& samples) {
  return memory_trend(samples, 0.25, 32 << 10);
}

/// Of what comes again season by season.
inline MemoryTrend seasons_trend(const std::vector<std::size_t>& samples) { return memory_trend(samples, 0.01, 0); }

}  // namespace psim::soak
