// Lane types of the SSE4.1 variant: 4 floats, 2 doubles or 2 records a register. lanes_scalar.h defines
// what each operation means in bits.
#pragma once

#include <smmintrin.h>

#include <cstdint>
#include <cstring>

#include "block_layout.h"
#include "compact_table.h"
#include "compiler.h"
#include "four_sse.h"

namespace psim::kernels {
namespace {

struct SseLanes {
  static constexpr std::uint32_t width = 4;
  static constexpr std::uint32_t records = 2;
  static constexpr std::uint32_t doubles = 2;
  using Four = SseFour;

  struct F {
    __m128 v;
    F() = default;
    F(float a) : v(_mm_set1_ps(a)) {}
    F(__m128 a) : v(a) {}
  };
  struct D {
    __m128d v;
    D() = default;
    D(double a) : v(_mm_set1_pd(a)) {}
    D(__m128d a) : v(a) {}
  };
  struct I {
    __m128i v;
    I() = default;
    explicit I(std::int32_t a) : v(_mm_set1_epi32(a)) {}
    I(__m128i a) : v(a) {}
  };
  struct Rec {  // x0 y0 x1 y1
    __m128 v;
    Rec() = default;
    Rec(float x, float y) : v(_mm_setr_ps(x, y, x, y)) {}
    Rec(__m128 a) : v(a) {}
  };
  struct RecI {
    __m128i v;
    RecI() = default;
    RecI(std::int32_t x, std::int32_t y) : v(_mm_setr_epi32(x, y, x, y)) {}
    RecI(__m128i a) : v(a) {}
  };
  // All bits of a lane are set, or none.
  struct M {
    __m128 v;
  };
  struct MD {
    __m128d v;
  };
  struct MRec {
    __m128 v;
  };
  // Only the sign bit of a lane counts.
  struct Signs {
    __m128 v;
  };

  // ---- floats ----
  static F load(const float* p) { return _mm_loadu_ps(p); }
  static void store(float* p, F a) { _mm_storeu_ps(p, a.v); }
  friend F operator+(F a, F b) { return _mm_add_ps(a.v, b.v); }
  friend F operator-(F a, F b) { return _mm_sub_ps(a.v, b.v); }
  friend F operator*(F a, F b) { return _mm_mul_ps(a.v, b.v); }
  friend F operator/(F a, F b) { return _mm_div_ps(a.v, b.v); }
  friend F operator-(F a) { return _mm_xor_ps(_mm_set1_ps(-0.0f), a.v); }
  friend F& operator+=(F& a, F b) { return a = a + b; }
  friend F& operator-=(F& a, F b) { return a = a - b; }
  friend F sqrt(F a) { return _mm_sqrt_ps(a.v); }
  friend F abs(F a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v); }
  friend F floor(F a) { return _mm_floor_ps(a.v); }
  friend F min(F a, F b) { return _mm_min_ps(a.v, b.v); }
  friend F max(F a, F b) { return _mm_max_ps(a.v, b.v); }
  friend M operator<(F a, F b) { return {_mm_cmplt_ps(a.v, b.v)}; }
  friend M operator<=(F a, F b) { return {_mm_cmple_ps(a.v, b.v)}; }
  friend M operator!=(F a, F b) { return {_mm_cmpneq_ps(a.v, b.v)}; }
  friend Signs negative(F a) { return {a.v}; }

  // ---- masks ----
  static M none() { return {_mm_setzero_ps()}; }
  static M every() { return {_mm_castsi128_ps(_mm_set1_epi32(-1))}; }
  friend M operator&(M a, M b) { return {_mm_and_ps(a.v, b.v)}; }
  friend M operator|(M a, M b) { return {_mm_or_ps(a.v, b.v)}; }
  friend M but_not(M a, M b) { return {_mm_andnot_ps(b.v, a.v)}; }
  friend F keep(M m, F a) { return _mm_and_ps(m.v, a.v); }
  friend F drop(M m, F a) { return _mm_andnot_ps(m.v, a.v); }
  friend F select(M m, F yes, F no) { return _mm_blendv_ps(no.v, yes.v, m.v); }
  friend M select(M m, M yes, M no) { return {_mm_blendv_ps(no.v, yes.v, m.v)}; }
  friend std::uint32_t bits(M m) { return static_cast<std::uint32_t>(_mm_movemask_ps(m.v)); }
  friend bool any(M m) { return bits(m) != 0; }
  friend bool all(M m) { return bits(m) == 0xF; }
  friend Signs operator&(Signs a, Signs b) { return {_mm_and_ps(a.v, b.v)}; }
  friend F select(Signs m, F yes, F no) { return _mm_blendv_ps(no.v, yes.v, m.v); }
  friend M select(Signs m, M yes, M no) { return {_mm_blendv_ps(no.v, yes.v, m.v)}; }
  friend bool all(Signs m) { return _mm_movemask_ps(m.v) == 0xF; }

  // ---- whole numbers ----
  static I load_int(const std::int32_t* p) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)); }
  static void store_int(std::int32_t* p, I a) { _mm_storeu_si128(reinterpret_cast<__m128i*>(p), a.v); }
  friend I operator-(I a, I b) { return _mm_sub_epi32(a.v, b.v); }
  friend F to_float(I a) { return _mm_cvtepi32_ps(a.v); }

  // ---- gathers and scatters ----
  template <int Step>
  PSIM_INLINE static void gather(const float* rec, const std::uint32_t* slots, F& x, F& y) {
    const __m128 a =
        join(rec + 2 * static_cast<std::size_t>(slots[0]), rec + 2 * static_cast<std::size_t>(slots[Step]));
    const __m128 b =
        join(rec + 2 * static_cast<std::size_t>(slots[2 * Step]), rec + 2 * static_cast<std::size_t>(slots[3 * Step]));
    x = _mm_shuffle_ps(a, b, 0x88);
    y = _mm_shuffle_ps(a, b, 0xDD);
  }
  PSIM_INLINE static void gather4(const float* const* at, std::size_t offset, F& a, F& b, F& c, F& d) {
    a = load(at[0] + offset), b = load(at[1] + offset), c = load(at[2] + offset), d = load(at[3] + offset);
    _MM_TRANSPOSE4_PS(a.v, b.v, c.v, d.v);
  }
  PSIM_INLINE static void scatter4(float* const* at, std::size_t offset, F a, F b, F c, F d) {
    _MM_TRANSPOSE4_PS(a.v, b.v, c.v, d.v);
    store(at[0] + offset, a), store(at[1] + offset, b), store(at[2] + offset, c), store(at[3] + offset, d);
  }
  template <int Step>
  PSIM_INLINE static void gather_int(const std::int32_t* rec, const std::uint32_t* slots, I& x, I& y) {
    const __m128 a =
        join(rec + 2 * static_cast<std::size_t>(slots[0]), rec + 2 * static_cast<std::size_t>(slots[Step]));
    const __m128 b =
        join(rec + 2 * static_cast<std::size_t>(slots[2 * Step]), rec + 2 * static_cast<std::size_t>(slots[3 * Step]));
    x = _mm_castps_si128(_mm_shuffle_ps(a, b, 0x88));
    y = _mm_castps_si128(_mm_shuffle_ps(a, b, 0xDD));
  }
  template <int Step>
  PSIM_INLINE static void scatter(float* rec, const std::uint32_t* slots, F x, F y) {
    const __m128 low = _mm_unpacklo_ps(x.v, y.v);
    const __m128 high = _mm_unpackhi_ps(x.v, y.v);
    _mm_storel_pi(reinterpret_cast<__m64*>(rec + 2 * static_cast<std::size_t>(slots[0])), low);
    _mm_storeh_pi(reinterpret_cast<__m64*>(rec + 2 * static_cast<std::size_t>(slots[Step])), low);
    _mm_storel_pi(reinterpret_cast<__m64*>(rec + 2 * static_cast<std::size_t>(slots[2 * Step])), high);
    _mm_storeh_pi(reinterpret_cast<__m64*>(rec + 2 * static_cast<std::size_t>(slots[3 * Step])), high);
  }
  template <int Step>
  PSIM_INLINE static F gather1(const float* col, const std::uint32_t* slots) {
    const __m128 a = _mm_unpacklo_ps(_mm_load_ss(col + slots[0]), _mm_load_ss(col + slots[Step]));
    const __m128 b = _mm_unpacklo_ps(_mm_load_ss(col + slots[2 * Step]), _mm_load_ss(col + slots[3 * Step]));
    return _mm_movelh_ps(a, b);
  }
  template <int Step>
  PSIM_INLINE static void scatter1(float* col, const std::uint32_t* slots, F a) {
    _mm_store_ss(col + slots[0], a.v);
    _mm_store_ss(col + slots[Step], _mm_shuffle_ps(a.v, a.v, 1));
    _mm_store_ss(col + slots[2 * Step], _mm_movehl_ps(a.v, a.v));
    _mm_store_ss(col + slots[3 * Step], _mm_shuffle_ps(a.v, a.v, 3));
  }

  // ---- records ----
  static Rec load_rec(const float* p) { return _mm_loadu_ps(p); }
  static void store_rec(float* p, Rec a) { _mm_storeu_ps(p, a.v); }
  static void store_records(float* p, F x, F y) {
    _mm_storeu_ps(p, _mm_unpacklo_ps(x.v, y.v));
    _mm_storeu_ps(p + 4, _mm_unpackhi_ps(x.v, y.v));
  }
  static Rec spread(const float* p) {
    const __m128 a = _mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)));
    return _mm_unpacklo_ps(a, a);
  }
  static MRec mask_rec(const std::uint8_t* p) {
    std::uint16_t two;
    std::memcpy(&two, p, 2);
    return {_mm_castsi128_ps(_mm_cvtepi8_epi64(_mm_cvtsi32_si128(two)))};
  }
  friend Rec operator+(Rec a, Rec b) { return _mm_add_ps(a.v, b.v); }
  friend Rec operator-(Rec a, Rec b) { return _mm_sub_ps(a.v, b.v); }
  friend Rec operator*(Rec a, Rec b) { return _mm_mul_ps(a.v, b.v); }
  friend Rec sqrt(Rec a) { return _mm_sqrt_ps(a.v); }
  friend Rec abs(Rec a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v); }
  friend Rec min(Rec a, Rec b) { return _mm_min_ps(a.v, b.v); }
  friend Rec max(Rec a, Rec b) { return _mm_max_ps(a.v, b.v); }
  friend Rec norm2(Rec a) {
    const __m128 s = _mm_mul_ps(a.v, a.v);
    return _mm_add_ps(s, _mm_shuffle_ps(s, s, 0xB1));
  }
  friend MRec operator<=(Rec a, Rec b) { return {_mm_cmple_ps(a.v, b.v)}; }
  friend MRec operator&(MRec a, MRec b) { return {_mm_and_ps(a.v, b.v)}; }
  friend Rec keep(MRec m, Rec a) { return _mm_and_ps(m.v, a.v); }
  friend Rec drop(MRec m, Rec a) { return _mm_andnot_ps(m.v, a.v); }
  friend Rec select(MRec m, Rec yes, Rec no) { return _mm_blendv_ps(no.v, yes.v, m.v); }
  friend bool all(MRec m) { return _mm_movemask_ps(m.v) == 0xF; }
  static MRec every_rec() { return {every().v}; }
  static float largest(Rec a) { return _mm_cvtss_f32(_mm_max_ss(a.v, _mm_movehl_ps(a.v, a.v))); }

  static RecI load_rec_int(const std::int32_t* p) { return load_int(p).v; }
  static void store_rec_int(std::int32_t* p, RecI a) { store_int(p, I{a.v}); }
  friend RecI operator+(RecI a, RecI b) { return _mm_add_epi32(a.v, b.v); }
  friend RecI operator-(RecI a, RecI b) { return _mm_sub_epi32(a.v, b.v); }
  friend RecI min(RecI a, RecI b) { return _mm_min_epi32(a.v, b.v); }
  friend RecI max(RecI a, RecI b) { return _mm_max_epi32(a.v, b.v); }
  friend RecI nearest(Rec a) { return _mm_cvtps_epi32(a.v); }
  friend RecI truncate(Rec a) { return _mm_cvttps_epi32(a.v); }
  friend Rec to_float(RecI a) { return _mm_cvtepi32_ps(a.v); }
  static void store_keys(std::uint32_t* keys, RecI c, std::uint32_t stride) {
    const __m128i s = _mm_setr_epi32(1, static_cast<int>(stride), 1, static_cast<int>(stride));
    const __m128i p = _mm_mullo_epi32(c.v, s);
    const __m128i k = _mm_add_epi32(p, _mm_shuffle_epi32(p, 0xB1));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(keys), _mm_shuffle_epi32(k, 0x08));
  }

  // ---- doubles ----
  friend D operator+(D a, D b) { return _mm_add_pd(a.v, b.v); }
  friend D operator-(D a, D b) { return _mm_sub_pd(a.v, b.v); }
  friend D operator*(D a, D b) { return _mm_mul_pd(a.v, b.v); }
  friend D operator/(D a, D b) { return _mm_div_pd(a.v, b.v); }
  friend D sqrt(D a) { return _mm_sqrt_pd(a.v); }
  friend MD operator<(D a, D b) { return {_mm_cmplt_pd(a.v, b.v)}; }
  friend MD operator<=(D a, D b) { return {_mm_cmple_pd(a.v, b.v)}; }
  friend MD but_not(MD a, MD b) { return {_mm_andnot_pd(b.v, a.v)}; }
  friend D select(MD m, D yes, D no) { return _mm_blendv_pd(no.v, yes.v, m.v); }
  friend D round_to_float(D a) { return _mm_cvtps_pd(_mm_cvtpd_ps(a.v)); }
  static MD mask_d(const std::uint8_t* p) { return {_mm_castps_pd(mask_rec(p).v)}; }
  static D load_d(const float* p) {
    return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
  }
  static void load_rec_d(const float* p, D& x, D& y) {
    const __m128 a = _mm_loadu_ps(p);
    x = _mm_cvtps_pd(_mm_shuffle_ps(a, a, 0x88));
    y = _mm_cvtps_pd(_mm_shuffle_ps(a, a, 0xDD));
  }
  static void load_rec_int_d(const std::int32_t* p, D& x, D& y) {
    const __m128i a = load_int(p).v;
    x = _mm_cvtepi32_pd(_mm_shuffle_epi32(a, 0x88));
    y = _mm_cvtepi32_pd(_mm_shuffle_epi32(a, 0xDD));
  }
  static void store_rec_d(float* p, D x, D y) {
    _mm_storeu_ps(p, _mm_unpacklo_ps(_mm_cvtpd_ps(x.v), _mm_cvtpd_ps(y.v)));
  }

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
    const __m128i all = _mm_loadu_si128(reinterpret_cast<const __m128i*>(in));
    const __m128i control = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kCompact4.byte[mask]));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_shuffle_epi8(all, control));
    return kCompact4.count[mask];
  }

 private:
  static constexpr auto kCompact4 = make_compact4();

  // Two records at p and q: p.x p.y q.x q.y, by movq and movhps.
  PSIM_INLINE static __m128 join(const void* p, const void* q) {
    const __m128 low = _mm_castsi128_ps(_mm_loadl_epi64(static_cast<const __m128i*>(p)));
    return _mm_loadh_pi(low, static_cast<const __m64*>(q));
  }
  template <class Near>
  PSIM_INLINE static std::uint32_t four(const std::int32_t* pos, const float* reach, std::uint32_t j, std::uint32_t end,
                                        std::uint32_t i, std::uint32_t* owner, std::uint32_t* other, const Near& near) {
    const __m128 a = _mm_loadu_ps(reinterpret_cast<const float*>(pos + 2 * std::size_t{j}));
    const __m128 b = _mm_loadu_ps(reinterpret_cast<const float*>(pos + 2 * std::size_t{j} + 4));
    const I x = _mm_castps_si128(_mm_shuffle_ps(a, b, 0x88));
    const I y = _mm_castps_si128(_mm_shuffle_ps(a, b, 0xDD));
    const F r = load(reach + j);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(owner), _mm_set1_epi32(static_cast<int>(i)));
    return append(other, j, bits(near(x, y, r)) & below(j, end));
  }
  /// Bits of the lanes whose body number, j + lane, is below the end.
  static std::uint32_t below(std::uint32_t j, std::uint32_t end) {
    const __m128i n = _mm_set1_epi32(static_cast<int>(end - j));
    return static_cast<std::uint32_t>(
        _mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(n, _mm_setr_epi32(0, 1, 2, 3)))));
  }
  /// Writes j + lane for the lanes in mask, packed, and returns how many; writes 4 in any case.
  static std::uint32_t append(std::uint32_t* out, std::uint32_t j, std::uint32_t mask) {
    const __m128i all = _mm_add_epi32(_mm_set1_epi32(static_cast<int>(j)), _mm_setr_epi32(0, 1, 2, 3));
    const __m128i control = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kCompact4.byte[mask]));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out), _mm_shuffle_epi8(all, control));
    return kCompact4.count[mask];
  }
};

using Lanes = SseLanes;

}  // namespace
}  // namespace psim::kernels
