// Things of many numbers, in long lists (archive.h): how many bytes one may take is found once, and then it is known of
// each that they are there, so that its numbers are read and written without a look at every one.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

namespace psim {

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// The last value of an enum in the bytes (image.h).
template <class E>
inline constexpr std::uint64_t kLastOf = ~std::uint64_t{0};

/// Counts the bytes that a thing takes at most.
struct RecordSize {
  static constexpr bool kLoading = false;
  std::size_t bytes = 0;
  template <Number T>
  void value(const T&) {
    bytes += sizeof(T);
  }
};

struct RecordWriter {
  static constexpr bool kLoading = false;
  std::byte* at = nullptr;
  template <Number T>
  void value(const T& v) {
    std::memcpy(at, &v, sizeof v);
    at += sizeof v;
  }
};

template <bool kRefusesNan>
struct RecordReader {
  static constexpr bool kLoading = true;
  const std::byte* at = nullptr;
  bool sound = true;
  template <Number T>
  void value(T& v) {
    if constexpr (std::is_same_v<T, bool>) {
      v = *at++ != std::byte{0};
      return;
    }
    std::memcpy(&v, at, sizeof v);
    at += sizeof v;
    if constexpr (kRefusesNan && std::is_floating_point_v<T>) sound &= !std::isnan(v);
    if constexpr (std::is_enum_v<T>) {
      if constexpr (kLastOf<T> != ~std::uint64_t{0}) sound &= static_cast<std::uint64_t>(v) <= kLastOf<T>;
    }
  }
};

static_assert(sizeof(bool) == 1);

template <class A, class T>
void maybe(A& a, std::optional<T>& v) {
  bool any = v.has_value() || std::is_same_v<A, RecordSize>;
  a.value(any);
  if constexpr (A::kLoading || std::is_same_v<A, RecordSize>) v = any ? std::optional<T>(T{}) : std::nullopt;
  if (any) a.value(*v);
}

}  // namespace psim
