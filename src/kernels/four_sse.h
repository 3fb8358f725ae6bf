// Four floats that belong together, in a register of SSE4.1. four_scalar.h defines what each operation means in bits.
#pragma once

#include <smmintrin.h>

namespace psim::kernels {
namespace {

struct SseFour {
  __m128 v;

  SseFour() = default;
  SseFour(float all) : v(_mm_set1_ps(all)) {}
  SseFour(__m128 a) : v(a) {}
  static SseFour load(const float* p) { return _mm_loadu_ps(p); }
  friend void store(float* p, SseFour a) { _mm_storeu_ps(p, a.v); }
  friend SseFour operator+(SseFour a, SseFour b) { return _mm_add_ps(a.v, b.v); }
  friend SseFour operator*(SseFour a, SseFour b) { return _mm_mul_ps(a.v, b.v); }
  friend SseFour sums(SseFour a, SseFour b, SseFour c, SseFour d) {
    return _mm_hadd_ps(_mm_hadd_ps(a.v, b.v), _mm_hadd_ps(c.v, d.v));
  }
};

}  // namespace
}  // namespace psim::kernels
