// What tests leave out under sanitizers, where everything takes ten times as long or more: they look for
// faults of memory and undefined behaviour there, and the release build has compared all bits. And what they leave out
// unless they are asked for all.
#pragma once

#include <cstdlib>
#include <vector>

namespace psim::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

/// The numbers of threads that bits are compared on.
inline std::vector<int> thread_counts() {
  if (kSanitized) return {3};
  return {1, 2, 3};
}

/// Whether tests with very many seeds run all of them, for some ten minutes, and not a quarter: PSIM_ALL_SEEDS=1.
inline bool all_seeds() { return std::getenv("PSIM_ALL_SEEDS") != nullptr; }

}  // namespace psim::test
