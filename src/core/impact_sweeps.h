// Which strips a sweep over impacts must look at.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace psim {

/// In which sweep over impacts a strip last had an event. Where none was about since a strip was looked at, it would
/// say the same again and is passed over.
struct SweepMemory {
  static constexpr int kNever = -2;
  std::vector<int> pairs, single;  ///< by strip

  void start(std::size_t strips) {
    pairs.assign(strips, kNever);
    single.assign(strips, kNever);
  }
  std::size_t bytes() const { return (pairs.capacity() + single.capacity()) * sizeof(int); }

  /// A pair's bodies lie in its strip and the next one; the last strip's anywhere.
  bool asks_pairs(std::size_t strip, int sweep) const {
    const std::size_t large = pairs.size() - 1;
    if (sweep == 0 || strip == large) return true;
    const std::size_t next = neighbour(strip, strip + 1 == large, 1);
    return std::max({pairs[strip], pairs[next], pairs[before(strip)], pairs[large], single[strip], single[next]}) + 1 >= sweep;
  }
  bool asks_single(std::size_t strip, int sweep) const {
    const std::size_t large = pairs.size() - 1;
    if (sweep == 0 || strip == large) return true;
    return std::max({pairs[strip], pairs[before(strip)], pairs[large], single[strip]}) + 1 >= sweep;
  }

 private:
  std::size_t before(std::size_t strip) const { return neighbour(strip, strip == 0, pairs.size() - 2); }
  // Across a seam the last strip meets the first. There are seams only where the number of strips is even: an odd
  // one's ends are of one phase, and may not look at each other.
  std::size_t neighbour(std::size_t strip, bool at_end, std::size_t by) const {
    const std::size_t strips = pairs.size() - 1;
    return at_end && strips % 2 == 1 ? strip : (strip + by) % strips;
  }
};

}  // namespace psim
