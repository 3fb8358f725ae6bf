// What a sequence of runs with ever shorter steps says: the order at which errors fall, and the
// limit that the results go to. It sees no engine code.
#pragma once

#include <array>
#include <span>

namespace reference {

/// Slope of log error over log h by least squares: error ~ h^order. Same lengths, two at least,
/// all positive.
double fit_order(std::span<const double> h, std::span<const double> error);

struct Extrapolation {
  double limit = 0;
  double order = 0;  ///< that the three results show; NaN if they do not fall in line
};

/// Richardson's extrapolation of results at h, h/2, h/4. The limit uses the order that the method
/// is known to have, from the two finer results; the order seen is for checking that.
Extrapolation richardson(const std::array<double, 3>& results, double known_order);

}  // namespace reference
