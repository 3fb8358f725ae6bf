// Sorts integers. std::sort leaves open in which order equal elements come out, so that bits could depend on the
// standard library; equal integers are alike. Other sorts in the engine say by what their order is total (tools/rooms).
#pragma once

#include <algorithm>
#include <concepts>
#include <iterator>

namespace psim {

template <std::random_access_iterator Iterator>
requires std::integral<std::iter_value_t<Iterator>>
void sort_keys(Iterator begin, Iterator end) { std::sort(begin, end); }

}  // namespace psim
