#include "base/range_text.h"

#include <array>
#include <charconv>
#include <cstddef>

namespace psim {

std::string exact_text(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  std::string shortest(text.data(), end.ptr);
  const std::size_t e = shortest.find('e');  // 1e+06: neither the plus nor the zero is needed
  if (e != shortest.npos) {
    if (shortest[e + 1] == '+') shortest.erase(e + 1, 1);
    const std::size_t digits = e + (shortest[e + 1] == '-' ? 2 : 1);
    while (digits + 1 < shortest.size() && shortest[digits] == '0') shortest.erase(digits, 1);
  }
  return shortest;
}

std::string range_text(Range range) {
  return range.above ? "above " + exact_text(range.min) + " and up to " + exact_text(range.max)
                     : "from " + exact_text(range.min) + " to " + exact_text(range.max);
}

void RangeCheck::say(std::string_view name, double value, Range range) {
  if (error.empty()) error = std::string(name) + " must be " + range_text(range) + ", not " + exact_text(value);
}

}  // namespace psim
