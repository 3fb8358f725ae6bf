// Numbers, their ranges, and what is said of a number that is not in its range.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "psim/limits.h"
#include "psim/types.h"

namespace psim {

/// The shortest text that reads back to the same number.
std::string exact_text(double value);

/// "from 0 to 1", or "above 0 and up to 10".
std::string range_text(Range range);

/// Checks numbers one after the other; `error` is one line about the first that is not in its range, as "friction must
/// be from 0 to 1000, not 2000", or empty.
class RangeCheck {
 public:
  std::string error;

  RangeCheck& operator()(std::string_view name, double value, Range range) {
    if (!range.contains(value)) say(name, value, range);
    return *this;
  }
  RangeCheck& operator()(std::string_view name, Vec2 value, Range range) {
    return (*this)(name, value.x, range)(name, value.y, range);
  }
  /// A number that is not given passes.
  RangeCheck& operator()(std::string_view name, std::optional<double> value, Range range) {
    return value ? (*this)(name, *value, range) : *this;
  }
  /// A value of an enum whose last one is given; a host may cast any number to it.
  template <class Choice>
  requires std::is_enum_v<Choice> RangeCheck& operator()(std::string_view name, Choice value, Choice last) {
    return (*this)(name, static_cast<double>(value), Range{0, static_cast<double>(last)});
  }

 private:
  void say(std::string_view name, double value, Range range);
};

}  // namespace psim
