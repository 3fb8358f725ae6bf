#include "pairs.h"

#include <cmath>

namespace reference {

double nearest_image(double d, double period) { return period > 0 ? std::remainder(d, period) : d; }

double gap_between(std::span<const double> x, std::span<const double> y, std::span<const double> radius, std::size_t a,
                   std::size_t b, Periods periods) {
  const double dx = nearest_image(x[b] - x[a], periods.x);
  const double dy = nearest_image(y[b] - y[a], periods.y);
  return std::sqrt(dx * dx + dy * dy) - radius[a] - radius[b];
}

std::vector<Pair> pairs_closer_than(std::span<const double> x, std::span<const double> y,
                                    std::span<const double> radius, double margin, Periods periods) {
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
