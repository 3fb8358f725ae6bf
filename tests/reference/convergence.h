// What a sequence of runs with ever shorter steps says: the order at which errors fall, and the
// limit that the results go to. Nothing here includes engine code.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace reference {

/// Slope of log error over log h by least squares: error ~ h^order. Same lengths, two at least,
/// all positive.
inline double fit_order(std::span<const double> h, std::span<const double> error) {
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

struct Extrapolation {
  double limit = 0;
  double order = 0;  ///< that the three results show; NaN if they do not fall in line
};

/// Richardson's extrapolation of results at h, h/2, h/4. The limit uses the order that the method
/// is known to have, from the two finer results; the order seen is for checking that.
inline Extrapolation richardson(const std::array<double, 3>& results, double known_order) {
  const double coarse = results[1] - results[0], fine = results[2] - results[1];
  return {results[2] + fine / (std::pow(2.0, known_order) - 1), std::log2(coarse / fine)};
}

}  // namespace reference
