// Helpers for code that may find no memory: they undo what was half done, and make room before anything changes.
#pragma once

#include <cstddef>
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

/// A size to reserve that has room for one more, and for as many again, when there is none.
template <class T>
std::size_t roomier(const std::vector<T>& list) {
  return list.size() < list.capacity() ? list.capacity() : 2 * list.size() + 1;
}

}  // namespace psim
