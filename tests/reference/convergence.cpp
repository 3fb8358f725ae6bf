#include "convergence.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace reference {

double fit_order(std::span<const double> h, std::span<const double> error) {
  const std::size_t n = std::min(h.size(), error.size());
  double mean_x = 0, mean_y = 0;
  for (std::size_t k = 0; k < n; ++k) {
    mean_x += std::log(h[k]) / static_cast<double>(n);
    mean_y += std::log(error[k]) / static_cast<double>(n);
  }
  double xy = 0, xx = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double x = std::log(h[k]) - mean_x;
    xy += x * (std::log(error[k]) - mean_y);
    xx += x * x;
  }
  return xy / xx;
}

Extrapolation richardson(const std::array<double, 3>& results, double known_order) {
  const double coarse = results[1] - results[0], fine = results[2] - results[1];
  return {results[2] + fine / (std::pow(2.0, known_order) - 1), std::log2(coarse / fine)};
}

}  // namespace reference
