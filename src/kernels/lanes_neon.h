// Lane types of the NEON variant for aarch64: 4 floats, 2 doubles or 2 records a register. lanes_scalar.h
// defines what each operation means in bits. Neither vfma nor vmla stands here: they may round a multiply
// and an add once.
#pragma once

#include <arm_neon.h>

#include <cstdint>

#include "block_layout.h"
#include "compact_table.h"
#include "compiler.h"
#include "four_neon.h"

namespace psim::kernels {
namespace {

struct NeonLanes {
  static constexpr std::uint32_t width = 4;
  static constexpr std::uint32_t records = 2;
  static constexpr std::uint32_t doubles = 2;
  using Four = NeonFour;

  struct F {
    float32x4_t v;
    F() = default;
    F(float a) : v(vdupq_n_f32(a)) {}
    F(float32x4_t a) : v(a) {}
  };
  struct D {
    float64x2_t v;
    D() = default;
    D(double a) : v(vdupq_n_f64(a)) {}
    D(float64x2_t a) : v(a) {}
  };
  struct I {
    int32x4_t v;
    I() = default;
    explicit I(std::int32_t a) : v(vdupq_n_s32(a)) {}
    I(int32x4_t a) : v(a) {}
  };
  struct Rec {  // x0 y0 x1 y1
    float32x4_t v;
    Rec() = default;
    Rec(float x, float y) : v(float32x4_t{x, y, x, y}) {}
    Rec(float32x4_t a) : v(a) {}
  };
  struct RecI {
    int32x4_t v;
    RecI() = default;
    RecI(std::int32_t x, std::int32_t y) : v(int32x4_t{x, y, x, y}) {}
    RecI(int32x4_t a) : v(a) {}
  };
  // All bits of a lane are set, or none.
  struct M {
    uint32x4_t v;
  };
  struct MD {
    uint64x2_t v;
  };
  struct MRec {
    uint32x4_t v;
  };
  struct Signs {
    uint32x4_t v;
  };

  // ---- floats ----
  static F load(const float* p) { return vld1q_f32(p); }
  static void store(float* p, F a) { vst1q_f32(p, a.v); }
  friend F operator+(F a, F b) { return vaddq_f32(a.v, b.v); }
  friend F operator-(F a, F b) { return vsubq_f32(a.v, b.v); }
  friend F operator*(F a, F b) { return vmulq_f32(a.v, b.v); }
  friend F operator/(F a, F b) { return vdivq_f32(a.v, b.v); }
  friend F operator-(F a) { return vnegq_f32(a.v); }
  friend F& operator+=(F& a, F b) { return a = a + b; }
  friend F& operator-=(F& a, F b) { return a = a - b; }
  friend F sqrt(F a) { return vsqrtq_f32(a.v); }
  friend F abs(F a) { return vabsq_f32(a.v); }
  friend F floor(F a) { return vrndmq_f32(a.v); }
  // vminq and vmaxq give a NaN where one of two is one, and -0 for the lesser of two zeros.
  friend F min(F a, F b) { return vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v); }
  friend F max(F a, F b) { return vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v); }
  friend M operator<(F a, F b) { return {vcltq_f32(a.v, b.v)}; }
  friend M operator<=(F a, F b) { return {vcleq_f32(a.v, b.v)}; }
  friend M operator!=(F a, F b) { return {vmvnq_u32(vceqq_f32(a.v, b.v))}; }
  friend Signs negative(F a) { return {vcltzq_s32(vreinterpretq_s32_f32(a.v))}; }

  // ---- masks ----
  static M none() { return {vdupq_n_u32(0)}; }
  static M every() { return {vdupq_n_u32(0xFFFFFFFFu)}; }
  friend M operator&(M a, M b) { return {vandq_u32(a.v, b.v)}; }
  friend M operator|(M a, M b) { return {vorrq_u32(a.v, b.v)}; }
  friend M but_not(M a, M b) { return {vbicq_u32(a.v, b.v)}; }
  friend F keep(M m, F a) { return kept(m.v, a.v); }
  friend F drop(M m, F a) { return dropped(m.v, a.v); }
  friend F select(M m, F yes, F no) { return vbslq_f32(m.v, yes.v, no.v); }
  friend M select(M m, M yes, M no) { return {vbslq_u32(m.v, yes.v, no.v)}; }
  friend std::uint32_t bits(M m) { return vaddvq_u32(vandq_u32(m.v, uint32x4_t{1, 2, 4, 8})); }
  friend bool any(M m) { return vmaxvq_u32(m.v) != 0; }
  friend bool all(M m) { return vminvq_u32(m.v) != 0; }
  friend Signs operator&(Signs a, Signs b) { return {vandq_u32(a.v, b.v)}; }
  friend F select(Signs m, F yes, F no) { return vbslq_f32(m.v, yes.v, no.v); }
  friend M select(Signs m, M yes, M no) { return {vbslq_u32(m.v, yes.v, no.v)}; }
  friend bool all(Signs m) { return vminvq_u32(m.v) != 0; }

  // ---- whole numbers ----
  static I load_int(const std::int32_t* p) { return vld1q_s32(p); }
  static void store_int(std::int32_t* p, I a) { vst1q_s32(p, a.v); }
  friend I operator-(I a, I b) { return vsubq_s32(a.v, b.v); }
  friend F to_float(I a) { return vcvtq_f32_s32(a.v); }

  // ---- gathers and scatters ----
  template <int Step>
  PSIM_INLINE static void gather(const float* rec, const std::uint32_t* slots, F& x, F& y) {
    const auto at = [&](int lane) { return vld1_f32(rec + 2 * static_cast<std::size_t>(slots[Step * lane])); };
    const float32x4_t a = vcombine_f32(at(0), at(1)), b = vcombine_f32(at(2), at(3));
    x = vuzp1q_f32(a, b);
    y = vuzp2q_f32(a, b);
  }
  template <int Step>
  PSIM_INLINE static void gather_int(const std::int32_t* rec, const std::uint32_t* slots, I& x, I& y) {
    const auto at = [&](int lane) { return vld1_s32(rec + 2 * static_cast<std::size_t>(slots[Step * lane])); };
    const int32x4_t a = vcombine_s32(at(0), at(1)), b = vcombine_s32(at(2), at(3));
    x = vuzp1q_s32(a, b);
    y = vuzp2q_s32(a, b);
  }
  PSIM_INLINE static void gather4(const float* const* at, std::size_t offset, F& a, F& b, F& c, F& d) {
    const float32x4_t p = vld1q_f32(at[0] + offset), q = vld1q_f32(at[1] + offset);
    const float32x4_t r = vld1q_f32(at[2] + offset), s = vld1q_f32(at[3] + offset);
    const float32x4_t pr_low = vzip1q_f32(p, r), pr_high = vzip2q_f32(p, r);  // p0 r0 p1 r1 | p2 r2 p3 r3
    const float32x4_t qs_low = vzip1q_f32(q, s), qs_high = vzip2q_f32(q, s);
    a = vzip1q_f32(pr_low, qs_low);
    b = vzip2q_f32(pr_low, qs_low);
    c = vzip1q_f32(pr_high, qs_high);
    d = vzip2q_f32(pr_high, qs_high);
  }
  PSIM_INLINE static void scatter4(float* const* at, std::size_t offset, F a, F b, F c, F d) {
    const float32x4_t ac_low = vzip1q_f32(a.v, c.v), ac_high = vzip2q_f32(a.v, c.v);  // a0 c0 a1 c1 | a2 c2 a3 c3
    const float32x4_t bd_low = vzip1q_f32(b.v, d.v), bd_high = vzip2q_f32(b.v, d.v);
    vst1q_f32(at[0] + offset, vzip1q_f32(ac_low, bd_low));
    vst1q_f32(at[1] + offset, vzip2q_f32(ac_low, bd_low));
    vst1q_f32(at[2] + offset, vzip1q_f32(ac_high, bd_high));
    vst1q_f32(at[3] + offset, vzip2q_f32(ac_high, bd_high));
  }
  template <int Step>
  PSIM_INLINE static void scatter(float* rec, const std::uint32_t* slots, F x, F y) {
    const auto at = [&](int lane) { return rec + 2 * static_cast<std::size_t>(slots[Step * lane]); };
    const float32x4_t low = vzip1q_f32(x.v, y.v), high = vzip2q_f32(x.v, y.v);
    vst1_f32(at(0), vget_low_f32(low));
    vst1_f32(at(1), vget_high_f32(low));
    vst1_f32(at(2), vget_low_f32(high));
    vst1_f32(at(3), vget_high_f32(high));
  }
  template <int Step>
  PSIM_INLINE static F gather1(const float* col, const std::uint32_t* slots) {
    float32x4_t a = vld1q_dup_f32(col + slots[0]);
    a = vld1q_lane_f32(col + slots[Step], a, 1);
    a = vld1q_lane_f32(col + slots[2 * Step], a, 2);
    return vld1q_lane_f32(col + slots[3 * Step], a, 3);
  }
  template <int Step>
  PSIM_INLINE static void scatter1(float* col, const std::uint32_t* slots, F a) {
    vst1q_lane_f32(col + slots[0], a.v, 0);
    vst1q_lane_f32(col + slots[Step], a.v, 1);
    vst1q_lane_f32(col + slots[2 * Step], a.v, 2);
    vst1q_lane_f32(col + slots[3 * Step], a.v, 3);
  }

  // ---- records ----
  static Rec load_rec(const float* p) { return vld1q_f32(p); }
  static void store_rec(float* p, Rec a) { vst1q_f32(p, a.v); }
  static void store_records(float* p, F x, F y) {
    vst1q_f32(p, vzip1q_f32(x.v, y.v));
    vst1q_f32(p + 4, vzip2q_f32(x.v, y.v));
  }
  static Rec spread(const float* p) { return vcombine_f32(vld1_dup_f32(p), vld1_dup_f32(p + 1)); }
  static MRec mask_rec(const std::uint8_t* p) {
    return {vcombine_u32(vdup_n_u32(p[0] * 0x01010101u), vdup_n_u32(p[1] * 0x01010101u))};
  }
  friend Rec operator+(Rec a, Rec b) { return vaddq_f32(a.v, b.v); }
  friend Rec operator-(Rec a, Rec b) { return vsubq_f32(a.v, b.v); }
  friend Rec operator*(Rec a, Rec b) { return vmulq_f32(a.v, b.v); }
  friend Rec sqrt(Rec a) { return vsqrtq_f32(a.v); }
  friend Rec abs(Rec a) { return vabsq_f32(a.v); }
  friend Rec min(Rec a, Rec b) { return vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v); }
  friend Rec max(Rec a, Rec b) { return vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v); }
  friend Rec norm2(Rec a) {
    const float32x4_t s = vmulq_f32(a.v, a.v);
    return vaddq_f32(s, vrev64q_f32(s));
  }
  friend MRec operator<=(Rec a, Rec b) { return {vcleq_f32(a.v, b.v)}; }
  friend MRec operator&(MRec a, MRec b) { return {vandq_u32(a.v, b.v)}; }
  friend Rec keep(MRec m, Rec a) { return kept(m.v, a.v); }
  friend Rec drop(MRec m, Rec a) { return dropped(m.v, a.v); }
  friend Rec select(MRec m, Rec yes, Rec no) { return vbslq_f32(m.v, yes.v, no.v); }
  friend bool all(MRec m) { return vminvq_u32(m.v) != 0; }
  static MRec every_rec() { return {every().v}; }
  static float largest(Rec a) {
    const float first = vgetq_lane_f32(a.v, 0), second = vgetq_lane_f32(a.v, 2);
    return first > second ? first : second;
  }

  static RecI load_rec_int(const std::int32_t* p) { return vld1q_s32(p); }
  static void store_rec_int(std::int32_t* p, RecI a) { vst1q_s32(p, a.v); }
  friend RecI operator+(RecI a, RecI b) { return vaddq_s32(a.v, b.v); }
  friend RecI operator-(RecI a, RecI b) { return vsubq_s32(a.v, b.v); }
  friend RecI min(RecI a, RecI b) { return vminq_s32(a.v, b.v); }
  friend RecI max(RecI a, RecI b) { return vmaxq_s32(a.v, b.v); }
  friend RecI nearest(Rec a) { return fitting(a.v, vcvtnq_s32_f32(a.v)); }
  friend RecI truncate(Rec a) { return fitting(a.v, vcvtq_s32_f32(a.v)); }
  friend Rec to_float(RecI a) { return vcvtq_f32_s32(a.v); }
  static void store_keys(std::uint32_t* keys, RecI c, std::uint32_t stride) {
    const uint32x4_t p = vmulq_u32(vreinterpretq_u32_s32(c.v), uint32x4_t{1, stride, 1, stride});
    vst1_u32(keys, vpadd_u32(vget_low_u32(p), vget_high_u32(p)));
  }

  // ---- doubles ----
  friend D operator+(D a, D b) { return vaddq_f64(a.v, b.v); }
  friend D operator-(D a, D b) { return vsubq_f64(a.v, b.v); }
  friend D operator*(D a, D b) { return vmulq_f64(a.v, b.v); }
  friend D operator/(D a, D b) { return vdivq_f64(a.v, b.v); }
  friend D sqrt(D a) { return vsqrtq_f64(a.v); }
  friend MD operator<(D a, D b) { return {vcltq_f64(a.v, b.v)}; }
  friend MD operator<=(D a, D b) { return {vcleq_f64(a.v, b.v)}; }
  friend MD but_not(MD a, MD b) { return {vbicq_u64(a.v, b.v)}; }
  friend D select(MD m, D yes, D no) { return vbslq_f64(m.v, yes.v, no.v); }
  friend D round_to_float(D a) { return vcvt_f64_f32(vcvt_f32_f64(a.v)); }
  static MD mask_d(const std::uint8_t* p) { return {vreinterpretq_u64_u32(mask_rec(p).v)}; }
  static D load_d(const float* p) { return vcvt_f64_f32(vld1_f32(p)); }
  static void load_rec_d(const float* p, D& x, D& y) {
    const float32x2x2_t a = vld2_f32(p);
    x = vcvt_f64_f32(a.val[0]);
    y = vcvt_f64_f32(a.val[1]);
  }
  static void load_rec_int_d(const std::int32_t* p, D& x, D& y) {
    const int32x2x2_t a = vld2_s32(p);
    x = vcvtq_f64_s64(vmovl_s32(a.val[0]));
    y = vcvtq_f64_s64(vmovl_s32(a.val[1]));
  }
  static void store_rec_d(float* p, D x, D y) { vst2_f32(p, float32x2x2_t{{vcvt_f32_f64(x.v), vcvt_f32_f64(y.v)}}); }

  // ---- pair search ----
  /// Two registers of four candidates, one after the other.
  template <class Near>
  PSIM_INLINE static std::uint32_t four_and_four(const std::int32_t* pos, const float* reach, std::uint32_t j0,
                                                 std::uint32_t end0, std::uint32_t j1, std::uint32_t end1,
                                                 std::uint32_t i, std::uint32_t* owner, std::uint32_t* other,
                                                 const Near& near) {
    const std::uint32_t first = four(pos, reach, j0, end0, i, owner, other, near);
    return first + four(pos, reach, j1, end1, i, owner + first, other + first, near);
  }
  static std::uint32_t pack(std::uint32_t* out, const std::uint32_t* in, std::uint32_t mask) {
    return pack(out, vld1q_u32(in), mask);
  }

 private:
  static constexpr auto kCompact4 = make_compact4();

  static float32x4_t dropped(uint32x4_t mask, float32x4_t a) {
    return vreinterpretq_f32_u32(vbicq_u32(vreinterpretq_u32_f32(a), mask));
  }
  static float32x4_t kept(uint32x4_t mask, float32x4_t a) {
    return vreinterpretq_f32_u32(vandq_u32(mask, vreinterpretq_u32_f32(a)));
  }
  /// -2^31 where a is a NaN or 2^31 and more. Below -2^31 the conversion gives that by itself.
  static int32x4_t fitting(float32x4_t a, int32x4_t converted) {
    return vbslq_s32(vcltq_f32(a, vdupq_n_f32(2147483648.0f)), converted, vdupq_n_s32(-2147483647 - 1));
  }
  template <class Near>
  PSIM_INLINE static std::uint32_t four(const std::int32_t* pos, const float* reach, std::uint32_t j, std::uint32_t end,
                                        std::uint32_t i, std::uint32_t* owner, std::uint32_t* other, const Near& near) {
    const int32x4x2_t at = vld2q_s32(pos + 2 * std::size_t{j});
    vst1q_u32(owner, vdupq_n_u32(i));
    const uint32x4_t number = vaddq_u32(vdupq_n_u32(j), uint32x4_t{0, 1, 2, 3});
    return pack(other, number, bits(near(I{at.val[0]}, I{at.val[1]}, load(reach + j))) & below(j, end));
  }
  /// Bits of the lanes whose body number, j + lane, is below the end.
  static std::uint32_t below(std::uint32_t j, std::uint32_t end) {
    return bits(M{vcgtq_s32(vdupq_n_s32(static_cast<std::int32_t>(end - j)), int32x4_t{0, 1, 2, 3})});
  }
  /// Writes the values of the lanes in mask, packed, and returns how many; writes 4 in any case.
  static std::uint32_t pack(std::uint32_t* out, uint32x4_t all, std::uint32_t mask) {
    const uint8x16_t control = vld1q_u8(kCompact4.byte[mask]);
    vst1q_u32(out, vreinterpretq_u32_u8(vqtbl1q_u8(vreinterpretq_u8_u32(all), control)));
    return kCompact4.count[mask];
  }
};

using Lanes = NeonLanes;

}  // namespace
}  // namespace psim::kernels
