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

/// Three digits, not below (above) the value. value > 0.
inline std::string round_up_text(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return number_text(std::ceil(value / unit - 1e-9) * unit);
}
inline std::string round_down_text(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2);
  return number_text(std::floor(value / unit + 1e-9) * unit);
}

}  // namespace psim
