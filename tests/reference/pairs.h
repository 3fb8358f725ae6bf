// Brute-force pair finder in double precision: every pair of discs, O(n^2), no grid. The oracle
// for the broad phase; nothing here includes engine code.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace reference {

struct Pair {
  std::size_t a = 0;  ///< a < b
  std::size_t b = 0;
  double gap = 0;  ///< distance of the surfaces, negative where they overlap
};

/// Periods of the two axes; 0 = that axis does not wrap.
struct Periods {
  double x = 0;
  double y = 0;
};

/// The shortest of d and its periodic images.
inline double nearest_image(double d, double period) {
  return period > 0 ? std::remainder(d, period) : d;
}

inline double gap_between(std::span<const double> x, std::span<const double> y,
                          std::span<const double> radius, std::size_t a, std::size_t b,
                          Periods periods = {}) {
  const double dx = nearest_image(x[b] - x[a], periods.x);
  const double dy = nearest_image(y[b] - y[a], periods.y);
  return std::sqrt(dx * dx + dy * dy) - radius[a] - radius[b];
}

/// Every pair whose surfaces are closer than `margin`, ordered by a, then b.
inline std::vector<Pair> pairs_closer_than(std::span<const double> x, std::span<const double> y,
                                           std::span<const double> radius, double margin,
                                           Periods periods = {}) {
  std::vector<Pair> found;
  for (std::size_t a = 0; a < x.size(); ++a) {
    for (std::size_t b = a + 1; b < x.size(); ++b) {
      const double gap = gap_between(x, y, radius, a, b, periods);
      if (gap < margin) found.push_back({a, b, gap});
    }
  }
  return found;
}

}  // namespace reference
