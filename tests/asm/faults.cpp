// Code with every fault that tools/asm-inspect must find; compiled three times by check_faults.py
// as if it were the kernels. Never linked.
#ifdef __aarch64__
#include <arm_neon.h>
#else
#include <immintrin.h>
#endif

#include <cstddef>

inline float shared_by_all_units(float a) { return a * a; }  // emitted weak when not inlined
float (*take_address)(float) = shared_by_all_units;

float outside(float);

void call_in_loop(float* x, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) x[i] = outside(x[i]);
}

[[gnu::cold, gnu::noinline]] static float rare(float a) { return outside(a); }

void cold_call_is_fine(float* x, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    if (x[i] < 0) x[i] = rare(x[i]);
  }
}

#ifdef __aarch64__
void estimate(float* x) { vst1q_f32(x, vrecpeq_f32(vld1q_f32(x))); }
void other_minimum(float* x) { vst1q_f32(x, vminq_f32(vld1q_f32(x), vdupq_n_f32(0))); }
void fused(float* x) {
  const float32x4_t a = vld1q_f32(x);
  vst1q_f32(x, vfmaq_f32(a, a, a));
}
void above_base(int* x) { __atomic_fetch_add(x, 1, __ATOMIC_SEQ_CST); }
#else
void estimate(float* x) { _mm_storeu_ps(x, _mm_rcp_ps(_mm_loadu_ps(x))); }

#ifdef WITH_AVX
void fused(float* x) {
  const __m256 a = _mm256_loadu_ps(x);
  _mm256_storeu_ps(x, _mm256_fmadd_ps(a, a, a));
}
#endif
#ifdef WITH_SSE3
void above_sse2(float* x) {
  const __m128 a = _mm_loadu_ps(x);
  _mm_storeu_ps(x, _mm_hadd_ps(a, a));
}
#endif
#endif
