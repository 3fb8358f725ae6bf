// Lane types of the AVX2 variant: 8 floats, 4 doubles or 4 records a register. lanes_scalar.h defines
// what each operation means in bits. A gather is movq, movhps and vinsertf128: measured four times as
// fast as vgatherdps (docs/kernels.md).
#pragma once

#include <immintrin.h>

#include <cstdint>
#include <cstring>

#include "block_layout.h"
#include "compact_table.h"
#include "compiler.h"
#include "four_sse.h"

namespace psim::kernels {
namespace {

struct AvxLanes {
  static constexpr std::uint32_t width = 8;
  static constexpr std::uint32_t records = 4;
  static constexpr std::uint32_t doubles = 4;
  using Four = SseFour;

  struct F {
    __m256 v;
    F() = default;
    F(float a) : v(_mm256_set1_ps(a)) {}
    F(__m256 a) : v(a) {}
  };
  struct D {
    __m256d v;
    D() = default;
    D(double a) : v(_mm256_set1_pd(a)) {}
    D(__m256d a) : v(a) {}
  };
  struct I {
    __m256i v;
    I() = default;
    explicit I(std::int32_t a) : v(_mm256_set1_epi32(a)) {}
    I(__m256i a) : v(a) {}
  };
  struct Rec {  // x0 y0 x1 y1 x2 y2 x3 y3
    __m256 v;
    Rec() = default;
    Rec(float x, float y) : v(_mm256_setr_ps(x, y, x, y, x, y, x, y)) {}
    Rec(__m256 a) : v(a) {}
  };
  struct RecI {
    __m256i v;
    RecI() = default;
    RecI(std::int32_t x, std::int32_t y) : v(_mm256_setr_epi32(x, y, x, y, x, y, x, y)) {}
    RecI(__m256i a) : v(a) {}
  };
  // All bits of a lane are set, or none.
  struct M {
    __m256 v;
  };
  struct MD {
    __m256d v;
  };
  struct MRec {
    __m256 v;
  };
  // Only the sign bit of a lane counts.
  struct Signs {
    __m256 v;
  };

  // ---- floats ----
  static F load(const float* p) { return _mm256_loadu_ps(p); }
  static void store(float* p, F a) { _mm256_storeu_ps(p, a.v); }
  friend F operator+(F a, F b) { return _mm256_add_ps(a.v, b.v); }
  friend F operator-(F a, F b) { return _mm256_sub_ps(a.v, b.v); }
  friend F operator*(F a, F b) { return _mm256_mul_ps(a.v, b.v); }
  friend F operator/(F a, F b) { return _mm256_div_ps(a.v, b.v); }
  friend F operator-(F a) { return _mm256_xor_ps(_mm256_set1_ps(-0.0f), a.v); }
  friend F& operator+=(F& a, F b) { return a = a + b; }
  friend F& operator-=(F& a, F b) { return a = a - b; }
  friend F sqrt(F a) { return _mm256_sqrt_ps(a.v); }
  friend F abs(F a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v); }
  friend F floor(F a) { return _mm256_floor_ps(a.v); }
  friend F min(F a, F b) { return _mm256_min_ps(a.v, b.v); }
  friend F max(F a, F b) { return _mm256_max_ps(a.v, b.v); }
  friend M operator<(F a, F b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OS)}; }
  friend M operator<=(F a, F b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OS)}; }
  friend M operator!=(F a, F b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_NEQ_UQ)}; }
  friend Signs negative(F a) { return {a.v}; }

  // ---- masks ----
  static M none() { return {_mm256_setzero_ps()}; }
  static M every() { return {_mm256_castsi256_ps(_mm256_set1_epi32(-1))}; }
  friend M operator&(M a, M b) { return {_mm256_and_ps(a.v, b.v)}; }
  friend M operator|(M a, M b) { return {_mm256_or_ps(a.v, b.v)}; }
  friend M but_not(M a, M b) { return {_mm256_andnot_ps(b.v, a.v)}; }
  friend F keep(M m, F a) { return _mm256_and_ps(m.v, a.v); }
  friend F drop(M m, F a) { return _mm256_andnot_ps(m.v, a.v); }
  friend F select(M m, F yes, F no) { return _mm256_blendv_ps(no.v, yes.v, m.v); }
  friend M select(M m, M yes, M no) { return {_mm256_blendv_ps(no.v, yes.v, m.v)}; }
  friend std::uint32_t bits(M m) { return static_cast<std::uint32_t>(_mm256_movemask_ps(m.v)); }
  friend bool any(M m) { return bits(m) != 0; }
  friend bool all(M m) { return bits(m) == 0xFF; }
  friend Signs operator&(Signs a, Signs b) { return {_mm256_and_ps(a.v, b.v)}; }
  friend F select(Signs m, F yes, F no) { return _mm256_blendv_ps(no.v, yes.v, m.v); }
  friend M select(Signs m, M yes, M no) { return {_mm256_blendv_ps(no.v, yes.v, m.v)}; }
  friend bool all(Signs m) { return _mm256_movemask_ps(m.v) == 0xFF; }

  // ---- whole numbers ----
  static I load_int(const std::int32_t* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }
  static void store_int(std::int32_t* p, I a) { _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), a.v); }
  friend I operator-(I a, I b) { return _mm256_sub_epi32(a.v, b.v); }
  friend F to_float(I a) { return _mm256_cvtepi32_ps(a.v); }

  // ---- gathers and scatters ----
  template <int Step>
  PSIM_INLINE static void gather(const float* rec, const std::uint32_t* slots, F& x, F& y) {
    gather_raw<Step>(rec, slots, x.v, y.v);
  }
  template <int Step>
  PSIM_INLINE static void gather_int(const std::int32_t* rec, const std::uint32_t* slots, I& x, I& y) {
    __m256 fx, fy;
    gather_raw<Step>(rec, slots, fx, fy);
    x = _mm256_castps_si256(fx);
    y = _mm256_castps_si256(fy);
  }
  PSIM_INLINE static void gather4(const float* const* at, std::size_t offset, F& a, F& b, F& c, F& d) {
    const __m256 p = two_halves(at[0] + offset, at[4] + offset), q = two_halves(at[1] + offset, at[5] + offset);
    const __m256 r = two_halves(at[2] + offset, at[6] + offset), s = two_halves(at[3] + offset, at[7] + offset);
    const __m256 pq_low = _mm256_unpacklo_ps(p, q), pq_high = _mm256_unpackhi_ps(p, q);
    const __m256 rs_low = _mm256_unpacklo_ps(r, s), rs_high = _mm256_unpackhi_ps(r, s);
    a = _mm256_shuffle_ps(pq_low, rs_low, 0x44);
    b = _mm256_shuffle_ps(pq_low, rs_low, 0xEE);
    c = _mm256_shuffle_ps(pq_high, rs_high, 0x44);
    d = _mm256_shuffle_ps(pq_high, rs_high, 0xEE);
  }
  PSIM_INLINE static void scatter4(float* const* at, std::size_t offset, F a, F b, F c, F d) {
    const __m256 ab_low = _mm256_unpacklo_ps(a.v, b.v), ab_high = _mm256_unpackhi_ps(a.v, b.v);
    const __m256 cd_low = _mm256_unpacklo_ps(c.v, d.v), cd_high = _mm256_unpackhi_ps(c.v, d.v);
    const __m256 lanes[4] = {_mm256_shuffle_ps(ab_low, cd_low, 0x44), _mm256_shuffle_ps(ab_low, cd_low, 0xEE),
                             _mm256_shuffle_ps(ab_high, cd_high, 0x44), _mm256_shuffle_ps(ab_high, cd_high, 0xEE)};
    for (int k = 0; k < 4; ++k) {  // lanes k and k + 4
      _mm_storeu_ps(at[k] + offset, _mm256_castps256_ps128(lanes[k]));
      _mm_storeu_ps(at[k + 4] + offset, _mm256_extractf128_ps(lanes[k], 1));
    }
  }
  template <int Step>
  PSIM_INLINE static void scatter(float* rec, const std::uint32_t* slots, F x, F y) {
    const auto at = [&](int lane) {
      return reinterpret_cast<__m64*>(rec + 2 * static_cast<std::size_t>(slots[Step * lane]));
    };
    const __m256 low = _mm256_unpacklo_ps(x.v, y.v);   // lanes 0 1 | 4 5
    const __m256 high = _mm256_unpackhi_ps(x.v, y.v);  // lanes 2 3 | 6 7
    const __m128 low0 = _mm256_castps256_ps128(low), low1 = _mm256_extractf128_ps(low, 1);
    const __m128 high0 = _mm256_castps256_ps128(high), high1 = _mm256_extractf128_ps(high, 1);
    _mm_storel_pi(at(0), low0);
    _mm_storeh_pi(at(1), low0);
    _mm_storel_pi(at(2), high0);
    _mm_storeh_pi(at(3), high0);
    _mm_storel_pi(at(4), low1);
    _mm_storeh_pi(at(5), low1);
    _mm_storel_pi(at(6), high1);
    _mm_storeh_pi(at(7), high1);
  }
  template <int Step>
  PSIM_INLINE static F gather1(const float* col, const std::uint32_t* slots) {
    const auto at = [&](int lane) { return _mm_load_ss(col + slots[Step * lane]); };
    const __m128 a = _mm_movelh_ps(_mm_unpacklo_ps(at(0), at(1)), _mm_unpacklo_ps(at(2), at(3)));
    const __m128 b = _mm_movelh_ps(_mm_unpacklo_ps(at(4), at(5)), _mm_unpacklo_ps(at(6), at(7)));
    return _mm256_insertf128_ps(_mm256_castps128_ps256(a), b, 1);
  }
  template <int Step>
  PSIM_INLINE static void scatter1(float* col, const std::uint32_t* slots, F a) {
    const __m128 low = _mm256_castps256_ps128(a.v), high = _mm256_extractf128_ps(a.v, 1);
    _mm_store_ss(col + slots[0], low);
    _mm_store_ss(col + slots[Step], _mm_shuffle_ps(low, low, 1));
    _mm_store_ss(col + slots[2 * Step], _mm_movehl_ps(low, low));
    _mm_store_ss(col + slots[3 * Step], _mm_shuffle_ps(low, low, 3));
    _mm_store_ss(col + slots[4 * Step], high);
    _mm_store_ss(col + slots[5 * Step], _mm_shuffle_ps(high, high, 1));
    _mm_store_ss(col + slots[6 * Step], _mm_movehl_ps(high, high));
    _mm_store_ss(col + slots[7 * Step], _mm_shuffle_ps(high, high, 3));
  }

  // ---- records ----
  static Rec load_rec(const float* p) { return _mm256_loadu_ps(p); }
  static void store_rec(float* p, Rec a) { _mm256_storeu_ps(p, a.v); }
  static void store_records(float* p, F x, F y) {
    const __m256 low = _mm256_unpacklo_ps(x.v, y.v);   // bodies 0 1 | 4 5
    const __m256 high = _mm256_unpackhi_ps(x.v, y.v);  // bodies 2 3 | 6 7
    _mm256_storeu_ps(p, _mm256_permute2f128_ps(low, high, 0x20));
    _mm256_storeu_ps(p + 8, _mm256_permute2f128_ps(low, high, 0x31));
  }
  static Rec spread(const float* p) {
    const __m128 a = _mm_loadu_ps(p);
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_unpacklo_ps(a, a)), _mm_unpackhi_ps(a, a), 1);
  }
  static MRec mask_rec(const std::uint8_t* p) {
    std::int32_t four;
    std::memcpy(&four, p, 4);
    return {_mm256_castsi256_ps(_mm256_cvtepi8_epi64(_mm_cvtsi32_si128(four)))};
  }
  friend Rec operator+(Rec a, Rec b) { return _mm256_add_ps(a.v, b.v); }
  friend Rec operator-(Rec a, Rec b) { return _mm256_sub_ps(a.v, b.v); }
  friend Rec operator*(Rec a, Rec b) { return _mm256_mul_ps(a.v, b.v); }
  friend Rec sqrt(Rec a) { return _mm256_sqrt_ps(a.v); }
  friend Rec abs(Rec a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v); }
  friend Rec min(Rec a, Rec b) { return _mm256_min_ps(a.v, b.v); }
  friend Rec max(Rec a, Rec b) { return _mm256_max_ps(a.v, b.v); }
  friend Rec norm2(Rec a) {
    const __m256 s = _mm256_mul_ps(a.v, a.v);
    return _mm256_add_ps(s, _mm256_permute_ps(s, 0xB1));
  }
  friend MRec operator<=(Rec a, Rec b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OS)}; }
  friend MRec operator&(MRec a, MRec b) { return {_mm256_and_ps(a.v, b.v)}; }
  friend Rec keep(MRec m, Rec a) { return _mm256_and_ps(m.v, a.v); }
  friend Rec drop(MRec m, Rec a) { return _mm256_andnot_ps(m.v, a.v); }
  friend Rec select(MRec m, Rec yes, Rec no) { return _mm256_blendv_ps(no.v, yes.v, m.v); }
  friend bool all(MRec m) { return _mm256_movemask_ps(m.v) == 0xFF; }
  static MRec every_rec() { return {every().v}; }
  static float largest(Rec a) {
    const __m128 m = _mm_max_ps(_mm256_castps256_ps128(a.v), _mm256_extractf128_ps(a.v, 1));
    return _mm_cvtss_f32(_mm_max_ss(m, _mm_movehl_ps(m, m)));
  }

  static RecI load_rec_int(const std::int32_t* p) { return load_int(p).v; }
  static void store_rec_int(std::int32_t* p, RecI a) { store_int(p, I{a.v}); }
  friend RecI operator+(RecI a, RecI b) { return _mm256_add_epi32(a.v, b.v); }
  friend RecI operator-(RecI a, RecI b) { return _mm256_sub_epi32(a.v, b.v); }
  friend RecI min(RecI a, RecI b) { return _mm256_min_epi32(a.v, b.v); }
  friend RecI max(RecI a, RecI b) { return _mm256_max_epi32(a.v, b.v); }
  friend RecI nearest(Rec a) { return _mm256_cvtps_epi32(a.v); }
  friend RecI truncate(Rec a) { return _mm256_cvttps_epi32(a.v); }
  friend Rec to_float(RecI a) { return _mm256_cvtepi32_ps(a.v); }
  static void store_keys(std::uint32_t* keys, RecI c, std::uint32_t stride) {
    const int s = static_cast<int>(stride);
    const __m256i p = _mm256_mullo_epi32(c.v, _mm256_setr_epi32(1, s, 1, s, 1, s, 1, s));
    const __m256i k = _mm256_add_epi32(p, _mm256_shuffle_epi32(p, 0xB1));
    const __m256i packed = _mm256_permutevar8x32_epi32(k, _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(keys), _mm256_castsi256_si128(packed));
  }

  // ---- doubles ----
  friend D operator+(D a, D b) { return _mm256_add_pd(a.v, b.v); }
  friend D operator-(D a, D b) { return _mm256_sub_pd(a.v, b.v); }
  friend D operator*(D a, D b) { return _mm256_mul_pd(a.v, b.v); }
  friend D operator/(D a, D b) { return _mm256_div_pd(a.v, b.v); }
  friend D sqrt(D a) { return _mm256_sqrt_pd(a.v); }
  friend MD operator<(D a, D b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OS)}; }
  friend MD operator<=(D a, D b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OS)}; }
  friend MD but_not(MD a, MD b) { return {_mm256_andnot_pd(b.v, a.v)}; }
  friend D select(MD m, D yes, D no) { return _mm256_blendv_pd(no.v, yes.v, m.v); }
  friend D round_to_float(D a) { return _mm256_cvtps_pd(_mm256_cvtpd_ps(a.v)); }
  static MD mask_d(const std::uint8_t* p) { return {_mm256_castps_pd(mask_rec(p).v)}; }
  static D load_d(const float* p) { return _mm256_cvtps_pd(_mm_loadu_ps(p)); }
  static void load_rec_d(const float* p, D& x, D& y) {
    const __m256i apart = _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7);
    const __m256 a = _mm256_permutevar8x32_ps(_mm256_loadu_ps(p), apart);
    x = _mm256_cvtps_pd(_mm256_castps256_ps128(a));
    y = _mm256_cvtps_pd(_mm256_extractf128_ps(a, 1));
  }
  static void load_rec_int_d(const std::int32_t* p, D& x, D& y) {
    const __m256i apart = _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7);
    const __m256i a = _mm256_permutevar8x32_epi32(load_int(p).v, apart);
    x = _mm256_cvtepi32_pd(_mm256_castsi256_si128(a));
    y = _mm256_cvtepi32_pd(_mm256_extracti128_si256(a, 1));
  }
  static void store_rec_d(float* p, D x, D y) {
    const __m128 a = _mm256_cvtpd_ps(x.v), b = _mm256_cvtpd_ps(y.v);
    _mm_storeu_ps(p, _mm_unpacklo_ps(a, b));
    _mm_storeu_ps(p + 4, _mm_unpackhi_ps(a, b));
  }

  // ---- pair search ----
  /// One register holds all eight candidates: 4 from j0 on in lanes 0 to 3, 4 from j1 on in lanes 4 to 7.
  template <class Near>
  PSIM_INLINE static std::uint32_t four_and_four(const std::int32_t* pos, const float* reach, std::uint32_t j0,
                                                 std::uint32_t end0, std::uint32_t j1, std::uint32_t end1,
                                                 std::uint32_t i, std::uint32_t* owner, std::uint32_t* other,
                                                 const Near& near) {
    const float* p0 = reinterpret_cast<const float*>(pos + 2 * std::size_t{j0});
    const float* p1 = reinterpret_cast<const float*>(pos + 2 * std::size_t{j1});
    const __m256 a = two_halves(p0, p1);
    const __m256 b = two_halves(p0 + 4, p1 + 4);
    const I x = _mm256_castps_si256(_mm256_shuffle_ps(a, b, 0x88));
    const I y = _mm256_castps_si256(_mm256_shuffle_ps(a, b, 0xDD));
    const F r = two_halves(reach + j0, reach + j1);
    const std::uint32_t valid = below(j0, end0, j1, end1);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(owner), _mm256_set1_epi32(static_cast<int>(i)));
    return append(other, j0, j1, bits(near(x, y, r)) & valid);
  }
  static std::uint32_t pack(std::uint32_t* out, const std::uint32_t* in, std::uint32_t mask) {
    const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(in));
    const __m128i control = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompact8.lane[mask]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                        _mm256_permutevar8x32_epi32(all, _mm256_cvtepu8_epi32(control)));
    return kCompact8.count[mask];
  }

 private:
  static constexpr auto kCompact8 = make_compact8();

  static __m256 two_halves(const float* low, const float* high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high), 1);
  }
  PSIM_INLINE static __m128 join(const void* p, const void* q) {
    const __m128 low = _mm_castsi128_ps(_mm_loadl_epi64(static_cast<const __m128i*>(p)));
    return _mm_loadh_pi(low, static_cast<const __m64*>(q));
  }
  template <int Step, class T>
  PSIM_INLINE static void gather_raw(const T* rec, const std::uint32_t* slots, __m256& x, __m256& y) {
    const auto at = [&](int lane) { return rec + 2 * static_cast<std::size_t>(slots[Step * lane]); };
    const __m256 a = _mm256_insertf128_ps(_mm256_castps128_ps256(join(at(0), at(1))), join(at(4), at(5)), 1);
    const __m256 b = _mm256_insertf128_ps(_mm256_castps128_ps256(join(at(2), at(3))), join(at(6), at(7)), 1);
    x = _mm256_shuffle_ps(a, b, 0x88);
    y = _mm256_shuffle_ps(a, b, 0xDD);
  }
  /// Bits of the lanes whose body number, j0 + lane or j1 + lane, is below its end.
  static std::uint32_t below(std::uint32_t j0, std::uint32_t end0, std::uint32_t j1, std::uint32_t end1) {
    const __m128i lanes = _mm_setr_epi32(0, 1, 2, 3);
    const __m128i n0 = _mm_set1_epi32(static_cast<int>(end0 - j0));
    const __m128i n1 = _mm_set1_epi32(static_cast<int>(end1 - j1));
    const __m256i n =
        _mm256_insertf128_si256(_mm256_castsi128_si256(_mm_cmpgt_epi32(n0, lanes)), _mm_cmpgt_epi32(n1, lanes), 1);
    return static_cast<std::uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(n)));
  }
  /// Writes the body numbers of the lanes in mask, packed, and returns how many; writes 8 in any case.
  static std::uint32_t append(std::uint32_t* out, std::uint32_t j0, std::uint32_t j1, std::uint32_t mask) {
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3);
    const __m256i base = _mm256_insertf128_si256(_mm256_castsi128_si256(_mm_set1_epi32(static_cast<int>(j0))),
                                                 _mm_set1_epi32(static_cast<int>(j1)), 1);
    const __m128i control = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompact8.lane[mask]));
    const __m256i packed = _mm256_permutevar8x32_epi32(_mm256_add_epi32(base, lanes), _mm256_cvtepu8_epi32(control));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), packed);
    return kCompact8.count[mask];
  }
};

using Lanes = AvxLanes;

}  // namespace
}  // namespace psim::kernels
