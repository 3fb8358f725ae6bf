// Helpers for code that may find no memory: they undo what was half done, and make room before anything changes.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace psim {

/// Whether a call of this thread found no memory: what out_of_memory() tells and clears.
bool& ran_out_of_memory() noexcept;

/// make(), or what it throws after undo().
template <class Undo, class Make>
auto or_else(const Undo& undo, const Make& make) {
  try {
    return make();
  } catch (...) {
    undo();
    throw;
  }
}

/// Calls does(each[k], values[k]...) for one k after the other until it finds no memory. Returns how often it was true; 0
/// if the spans differ in length, and then nothing is called.
template <class Does, class Each, class... Values>
std::size_t count_done(const Does& does, std::span<const Each> each, std::span<const Values>... values) {
  if (((values.size() != each.size()) || ...)) return 0;
  const bool told = std::exchange(ran_out_of_memory(), false);
  std::size_t done = 0;
  for (std::size_t k = 0; k < each.size() && !ran_out_of_memory(); ++k) done += does(each[k], values[k]...) ? 1 : 0;
  ran_out_of_memory() = told || ran_out_of_memory();
  return done;
}

/// A size to reserve that has room for one more, and for as many again, when there is none.
template <class T>
std::size_t roomier(const std::vector<T>& list) {
  return list.size() < list.capacity() ? list.capacity() : 2 * list.size() + 1;
}

}  // namespace psim
