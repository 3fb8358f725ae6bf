// Four floats that belong together, in a register of NEON. four_scalar.h defines what each operation means in bits.
#pragma once

#include <arm_neon.h>

namespace psim::kernels {
namespace {

struct NeonFour {
  float32x4_t v;

  NeonFour() = default;
  NeonFour(float all) : v(vdupq_n_f32(all)) {}
  NeonFour(float32x4_t a) : v(a) {}
  static NeonFour load(const float* p) { return vld1q_f32(p); }
  friend void store(float* p, NeonFour a) { vst1q_f32(p, a.v); }
  friend NeonFour operator+(NeonFour a, NeonFour b) { return vaddq_f32(a.v, b.v); }
  friend NeonFour operator*(NeonFour a, NeonFour b) { return vmulq_f32(a.v, b.v); }
  friend NeonFour sums(NeonFour a, NeonFour b, NeonFour c, NeonFour d) {
    return vpaddq_f32(vpaddq_f32(a.v, b.v), vpaddq_f32(c.v, d.v));
  }
};

}  // namespace
}  // namespace psim::kernels
