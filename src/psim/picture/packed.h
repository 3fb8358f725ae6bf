// Two doubles, or four floats, in one register: vector types of g++ and clang++. Elsewhere a struct with the same
// operators gives the same numbers.
#pragma once

#include <cstdint>

namespace psim::cli {

#if defined(__GNUC__) && !defined(PSIM_NO_VECTOR_TYPES)

using Double2 = double __attribute__((vector_size(16)));
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline bool is_within(Double2 p, Double2 low, Double2 high) {
  const auto good = (p >= low) & (p <= high);
  return (good[0] & good[1]) != 0;
}

/// Towards zero.
inline Int4 to_int(Float4 a) { return __builtin_convertvector(a, Int4); }

#else

template <class T, int kLanes>
struct Packed {
  T lane[kLanes];
  T& operator[](int k) { return lane[k]; }
  T operator[](int k) const { return lane[k]; }

  template <class Operation>
  static Packed each(const Operation& of) {
    Packed r{};
    for (int k = 0; k < kLanes; ++k) r.lane[k] = of(k);
    return r;
  }
  friend Packed operator+(Packed a, Packed b) {
    return each([&](int k) { return a[k] + b[k]; });
  }
  friend Packed operator-(Packed a, Packed b) {
    return each([&](int k) { return a[k] - b[k]; });
  }
  friend Packed operator+(Packed a, T b) {
    return each([&](int k) { return a[k] + b; });
  }
  friend Packed operator*(Packed a, T b) {
    return each([&](int k) { return a[k] * b; });
  }
  friend Packed operator*(T a, Packed b) { return b * a; }
  Packed& operator+=(Packed b) { return *this = *this + b; }
};

using Double2 = Packed<double, 2>;
using Float4 = Packed<float, 4>;
using Int4 = Packed<std::int32_t, 4>;

inline bool is_within(Double2 p, Double2 low, Double2 high) {
  return p[0] >= low[0] && p[1] >= low[1] && p[0] <= high[0] && p[1] <= high[1];
}

inline Int4 to_int(Float4 a) {
  return Int4::each([&](int k) { return static_cast<std::int32_t>(a[k]); });
}

#endif

}  // namespace psim::cli
