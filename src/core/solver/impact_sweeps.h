// Tells which strips a sweep over impacts must look at.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace psim {

/// Notes in which sweep over impacts each strip last had an event. If there was no event around a strip since it was
/// looked at, a second look would find the same, and the strip is left out.
struct SweepMemory {
  static constexpr int kNever = -2;
  std::vector<int> pairs, static_pair;  ///< by strip

  void start(std::size_t strips) {
    pairs.assign(strips, kNever);
    static_pair.assign(strips, kNever);
  }
  std::size_t bytes() const { return (pairs.capacity() + static_pair.capacity()) * sizeof(int); }

  /// The bodies of a pair lie in its strip and in the next one; those of the last strip lie anywhere.
  bool asks_pairs(std::size_t strip, int sweep) const {
    const std::size_t large = pairs.size() - 1;
    if (sweep == 0 || strip == large) return true;
    const std::size_t next = neighbour(strip, strip + 1 == large, 1);
    return std::max(
               {pairs[strip], pairs[next], pairs[before(strip)], pairs[large], static_pair[strip], static_pair[next]}) +
               1 >=
           sweep;
  }
  bool asks_static(std::size_t strip, int sweep) const {
    const std::size_t large = pairs.size() - 1;
    if (sweep == 0 || strip == large) return true;
    return std::max({pairs[strip], pairs[before(strip)], pairs[large], static_pair[strip]}) + 1 >= sweep;
  }

 private:
  std::size_t before(std::size_t strip) const { return neighbour(strip, strip == 0, pairs.size() - 2); }
  // Across a seam the last strip meets the first. There are seams only if the number of strips is even: with an odd
  // number both ends belong to the same phase and may not look at each other.
  std::size_t neighbour(std::size_t strip, bool at_end, std::size_t by) const {
    const std::size_t strips = pairs.size() - 1;
    return at_end && strips % 2 == 1 ? strip : (strip + by) % strips;
  }
};

}  // namespace psim
