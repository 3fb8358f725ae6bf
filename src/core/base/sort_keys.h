// Sorts and mixes integers. std::sort leaves open in which order equal elements come out, so that bits could depend on the
// standard library; equal integers are alike. Other sorts in the engine say by what their order is total (tools/rooms).
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <vector>

namespace psim {

template <std::random_access_iterator Iterator>
requires std::integral<std::iter_value_t<Iterator>>
void sort_keys(Iterator begin, Iterator end) { std::sort(begin, end); }

/// Sorts keys by their upper 32 bits, by digits from the last to the first. Equal ones keep their order. O(keys).
inline void sort_by_upper_half(std::vector<std::uint64_t>& keys) {
  constexpr unsigned kBits = 11;
  constexpr std::size_t kDigits = std::size_t{1} << kBits;
  std::vector<std::uint64_t> spare(keys.size());
  for (unsigned shift = 32; shift < 64; shift += kBits) {
    std::array<std::size_t, kDigits + 1> at{};
    const auto digit = [shift](std::uint64_t key) { return (key >> shift) % kDigits; };
    for (const std::uint64_t key : keys) ++at[digit(key) + 1];
    if (at[1] == keys.size()) continue;  // all are 0 here
    for (std::size_t d = 1; d <= kDigits; ++d) at[d] += at[d - 1];
    for (const std::uint64_t key : keys) spare[at[digit(key)]++] = key;
    keys.swap(spare);
  }
}

/// Spreads a key over all 64 bits (the last step of SplitMix64; Steele, Lea, Flood 2014).
inline std::uint64_t mixed(std::uint64_t key) {
  key = (key ^ (key >> 30)) * 0xBF58476D1CE4E5B9u;
  key = (key ^ (key >> 27)) * 0x94D049BB133111EBu;
  return key ^ (key >> 31);
}

/// Makes one sorted list of two that stand in it one behind the other, as std::inplace_merge, which allocates. `spare`
/// keeps its memory.
template <class T, class Less = std::less<>>
void merge_parts(std::vector<T>& list, std::size_t first_part, std::vector<T>& spare, const Less& less = {}) {
  const auto middle = list.begin() + static_cast<std::ptrdiff_t>(first_part);
  spare.assign(middle, list.end());
  auto first = middle, out = list.end();
  for (auto second = spare.end(); second != spare.begin();) {
    const bool from_first = first != list.begin() && less(second[-1], first[-1]);
    *--out = from_first ? *--first : *--second;
  }
}

/// Equal elements keep their order, as in std::stable_sort, which allocates.
template <class T, class Less>
void sort_stably(std::vector<T>& list, std::vector<T>& spare, const Less& less) {
  for (std::size_t run = 1; run < list.size(); run *= 2) {
    spare.clear();
    const auto at = [&](std::size_t k) { return list.begin() + static_cast<std::ptrdiff_t>(std::min(k, list.size())); };
    for (std::size_t k = 0; k < list.size(); k += 2 * run) {
      std::merge(at(k), at(k + run), at(k + run), at(k + 2 * run), std::back_inserter(spare), less);
    }
    list.swap(spare);
  }
}

/// Sorts by `less`, which goes by first_of(element) first, a number below `ids`. Where there are many elements, they
/// are counted by their first number. Equal elements keep their order.
template <class T, class FirstOf, class Less>
void sort_by_first(std::vector<T>& list, std::vector<T>& scratch, std::vector<std::uint32_t>& count, std::uint32_t ids,
                   const FirstOf& first_of, const Less& less) {
  if (list.size() < 256 || list.size() < ids / 8) {
    sort_stably(list, scratch, less);
    return;
  }
  count.assign(std::size_t{ids} + 1, 0);
  for (const T& element : list) ++count[std::size_t{first_of(element)} + 1];
  for (std::size_t k = 1; k < count.size(); ++k) count[k] += count[k - 1];
  scratch.resize(list.size());
  for (const T& element : list) scratch[count[first_of(element)]++] = element;
  list.swap(scratch);
  for (std::size_t k = 1; k < list.size(); ++k) {  // insertion sort: few elements have the same first number
    const T element = list[k];
    std::size_t at = k;
    for (; at > 0 && less(element, list[at - 1]); --at) list[at] = list[at - 1];
    list[at] = element;
  }
}

}  // namespace psim
