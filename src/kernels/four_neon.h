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
  NeonFour(float a, float b, float c, float d) {
    const float all[4] = {a, b, c, d};
    v = vld1q_f32(all);
  }
  static NeonFour load(const float* p) { return vld1q_f32(p); }
  friend void store(float* p, NeonFour a) { vst1q_f32(p, a.v); }
  friend NeonFour operator+(NeonFour a, NeonFour b) { return vaddq_f32(a.v, b.v); }
  friend NeonFour operator-(NeonFour a, NeonFour b) { return vsubq_f32(a.v, b.v); }
  friend NeonFour floor(NeonFour a) { return vrndmq_f32(a.v); }
  friend void transpose(NeonFour& a, NeonFour& b, NeonFour& c, NeonFour& d) {
    const float32x4x2_t ab = vtrnq_f32(a.v, b.v), cd = vtrnq_f32(c.v, d.v);
    a = vcombine_f32(vget_low_f32(ab.val[0]), vget_low_f32(cd.val[0]));
    b = vcombine_f32(vget_low_f32(ab.val[1]), vget_low_f32(cd.val[1]));
    c = vcombine_f32(vget_high_f32(ab.val[0]), vget_high_f32(cd.val[0]));
    d = vcombine_f32(vget_high_f32(ab.val[1]), vget_high_f32(cd.val[1]));
  }
  friend NeonFour operator*(NeonFour a, NeonFour b) { return vmulq_f32(a.v, b.v); }
  friend NeonFour sums(NeonFour a, NeonFour b, NeonFour c, NeonFour d) {
    return vpaddq_f32(vpaddq_f32(a.v, b.v), vpaddq_f32(c.v, d.v));
  }
};

}  // namespace
}  // namespace psim::kernels
