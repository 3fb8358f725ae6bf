// Brute-force pair finder in double precision: every pair of discs, O(n^2), no grid. The oracle
// for the broad phase; it sees no engine code.
#pragma once

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
double nearest_image(double d, double period);

double gap_between(std::span<const double> x, std::span<const double> y, std::span<const double> radius, std::size_t a,
                   std::size_t b, Periods periods = {});

/// Every pair whose surfaces are closer than `margin`, ordered by a, then b.
std::vector<Pair> pairs_closer_than(std::span<const double> x, std::span<const double> y,
                                    std::span<const double> radius, double margin, Periods periods = {});

}  // namespace reference
