// Numbers in messages: short, and rounded to the safe side where they are advice.
#pragma once

#include <cmath>
#include <cstdio>
#include <string>

namespace psim {

/// At most six digits.
inline std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// The unit of the third digit of a number above 0.
inline double third_digit(double value) {
  double unit = 1;
  while (unit < 1e300 && value >= 1000 * unit) unit *= 10;
  while (unit > 1e-300 && value < 100 * unit) unit /= 10;
  return unit;
}

/// Three digits, not below (above) the value. value > 0.
inline std::string round_up_text(double value) {
  const double unit = third_digit(value);
  return number_text(std::ceil(value / unit - 1e-9) * unit);
}
inline std::string round_down_text(double value) {
  const double unit = third_digit(value);
  return number_text(std::floor(value / unit + 1e-9) * unit);
}

}  // namespace psim
