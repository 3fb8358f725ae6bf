// Lane types of the scalar variant, width 1: the definition of what each operation means in bits.
// Values live in the low lane of an SSE2 register (the x86-64 base line), so that min, max and
// select are single instructions without branches.
#pragma once

#include <emmintrin.h>

#include <cstdint>

#include "block_layout.h"

namespace psim::kernels {
namespace {

struct ScalarLanes {
  static constexpr std::uint32_t width = 1;
  static constexpr std::uint32_t records = 1;  // {x, y} records a Rec register holds

  static constexpr std::uint32_t doubles = 1;  // lanes of a D register

  struct F { __m128 v; };
  struct D { __m128d v; };
  struct I { std::int32_t v; };
  struct Rec { __m128 x, y; };
  struct RecI { std::int32_t x, y; };

  // Floats, one lane a contact or body.
  static F load(const float* p) { return {_mm_load_ss(p)}; }
  static void store(float* p, F a) { _mm_store_ss(p, a.v); }
  static F set1(float a) { return {_mm_set_ss(a)}; }
  static F add(F a, F b) { return {_mm_add_ss(a.v, b.v)}; }
  static F sub(F a, F b) { return {_mm_sub_ss(a.v, b.v)}; }
  static F mul(F a, F b) { return {_mm_mul_ss(a.v, b.v)}; }
  static F div(F a, F b) { return {_mm_div_ss(a.v, b.v)}; }
  static F sqrt(F a) { return {_mm_sqrt_ss(a.v)}; }
  static F min(F a, F b) { return {_mm_min_ss(a.v, b.v)}; }  // a < b ? a : b
  static F max(F a, F b) { return {_mm_max_ss(a.v, b.v)}; }  // a > b ? a : b
  static F less(F a, F b) { return {_mm_cmplt_ss(a.v, b.v)}; }
  static F differ(F a, F b) { return {_mm_cmpneq_ss(a.v, b.v)}; }  // also where one is a NaN
  static F less_equal(F a, F b) { return {_mm_cmple_ss(a.v, b.v)}; }
  static F both(F a, F b) { return {_mm_and_ps(a.v, b.v)}; }
  static F either(F a, F b) { return {_mm_or_ps(a.v, b.v)}; }
  static F but_not(F a, F b) { return {_mm_andnot_ps(b.v, a.v)}; }  // a & ~b
  static F abs(F a) { return {_mm_andnot_ps(_mm_set_ss(-0.0f), a.v)}; }
  static F negate(F a) { return {_mm_xor_ps(_mm_set_ss(-0.0f), a.v)}; }
  static F select(F mask, F yes, F no) {
    return {_mm_or_ps(_mm_and_ps(mask.v, yes.v), _mm_andnot_ps(mask.v, no.v))};
  }
  static F select_sign(F mask, F set, F clear) {  // by the sign bit of mask alone
    const F full{_mm_castsi128_ps(_mm_srai_epi32(_mm_castps_si128(mask.v), 31))};
    return select(full, set, clear);
  }
  static std::uint32_t bits(F mask) {
    return static_cast<std::uint32_t>(_mm_movemask_ps(mask.v)) & 1u;
  }
  static I load_int(const std::int32_t* p) { return {*p}; }
  static void store_int(std::int32_t* p, I a) { *p = a.v; }
  static I sub(I a, I b) {
    return {static_cast<std::int32_t>(static_cast<std::uint32_t>(a.v) -
                                      static_cast<std::uint32_t>(b.v))};
  }
  static F to_float(I a) { return {_mm_cvtsi32_ss(_mm_setzero_ps(), a.v)}; }

  // Records picked by slot: slots[step * lane].
  template <int Step>
  [[gnu::always_inline]] static void gather(const float* rec, const std::uint32_t* slots, F& x, F& y) {
    const float* p = rec + 2 * static_cast<std::size_t>(slots[0]);
    x = {_mm_load_ss(p)};
    y = {_mm_load_ss(p + 1)};
  }
  /// Four floats in a row of every lane, from at[lane] + offset.
  [[gnu::always_inline]] static void gather4(const float* const* at, std::size_t offset, F& a, F& b, F& c, F& d) {
    const float* p = at[0] + offset;
    a = load(p), b = load(p + 1), c = load(p + 2), d = load(p + 3);
  }
  template <int Step>
  [[gnu::always_inline]] static void gather_int(const std::int32_t* rec, const std::uint32_t* slots, I& x, I& y) {
    const std::int32_t* p = rec + 2 * static_cast<std::size_t>(slots[0]);
    x = {p[0]};
    y = {p[1]};
  }
  template <int Step>
  [[gnu::always_inline]] static void scatter(float* rec, const std::uint32_t* slots, F x, F y) {
    float* p = rec + 2 * static_cast<std::size_t>(slots[0]);
    _mm_store_ss(p, x.v);
    _mm_store_ss(p + 1, y.v);
  }
  template <int Step>
  [[gnu::always_inline]] static F gather1(const float* col, const std::uint32_t* slots) {
    return {_mm_load_ss(col + slots[0])};
  }
  template <int Step>
  [[gnu::always_inline]] static void scatter1(float* col, const std::uint32_t* slots, F a) {
    _mm_store_ss(col + slots[0], a.v);
  }

  // Streams of records.
  static Rec load_rec(const float* p) { return {_mm_load_ss(p), _mm_load_ss(p + 1)}; }
  static void store_rec(float* p, Rec a) {
    _mm_store_ss(p, a.x);
    _mm_store_ss(p + 1, a.y);
  }
  /// x and y of a register's bodies as records, side by side.
  static void store_records(float* p, F x, F y) {
    _mm_store_ss(p, x.v);
    _mm_store_ss(p + 1, y.v);
  }
  static Rec set_rec(float x, float y) { return {_mm_set_ss(x), _mm_set_ss(y)}; }
  static Rec add(Rec a, Rec b) { return {_mm_add_ss(a.x, b.x), _mm_add_ss(a.y, b.y)}; }
  static Rec sub(Rec a, Rec b) { return {_mm_sub_ss(a.x, b.x), _mm_sub_ss(a.y, b.y)}; }
  static Rec mul(Rec a, Rec b) { return {_mm_mul_ss(a.x, b.x), _mm_mul_ss(a.y, b.y)}; }
  static Rec div(Rec a, Rec b) { return {_mm_div_ss(a.x, b.x), _mm_div_ss(a.y, b.y)}; }
  static Rec sqrt(Rec a) { return {_mm_sqrt_ss(a.x), _mm_sqrt_ss(a.y)}; }
  static Rec min(Rec a, Rec b) { return {_mm_min_ss(a.x, b.x), _mm_min_ss(a.y, b.y)}; }
  static Rec max(Rec a, Rec b) { return {_mm_max_ss(a.x, b.x), _mm_max_ss(a.y, b.y)}; }
  /// x^2 + y^2 of each record, in both of its lanes.
  static Rec norm2(Rec a) {
    const __m128 s = _mm_add_ss(_mm_mul_ss(a.x, a.x), _mm_mul_ss(a.y, a.y));
    return {s, s};
  }
  static Rec less_equal(Rec a, Rec b) {
    return {_mm_cmple_ss(a.x, b.x), _mm_cmple_ss(a.y, b.y)};
  }
  static Rec both(Rec a, Rec b) { return {_mm_and_ps(a.x, b.x), _mm_and_ps(a.y, b.y)}; }
  static Rec select(Rec mask, Rec yes, Rec no) {
    return {select(F{mask.x}, F{yes.x}, F{no.x}).v, select(F{mask.y}, F{yes.y}, F{no.y}).v};
  }
  static bool all(Rec mask) {
    return (_mm_movemask_ps(mask.x) & _mm_movemask_ps(mask.y) & 1) != 0;
  }
  /// Mask from one byte a record (0 or 0xFF).
  static Rec mask_rec(const std::uint8_t* p) {
    const __m128 m = _mm_castsi128_ps(_mm_cvtsi32_si128(static_cast<std::int8_t>(*p)));
    return {m, m};
  }
  static RecI load_rec_int(const std::int32_t* p) { return {p[0], p[1]}; }
  static void store_rec_int(std::int32_t* p, RecI a) {
    p[0] = a.x;
    p[1] = a.y;
  }
  static RecI add(RecI a, RecI b) {
    return {static_cast<std::int32_t>(static_cast<std::uint32_t>(a.x) +
                                      static_cast<std::uint32_t>(b.x)),
            static_cast<std::int32_t>(static_cast<std::uint32_t>(a.y) +
                                      static_cast<std::uint32_t>(b.y))};
  }
  static RecI sub(RecI a, RecI b) {
    return {static_cast<std::int32_t>(static_cast<std::uint32_t>(a.x) -
                                      static_cast<std::uint32_t>(b.x)),
            static_cast<std::int32_t>(static_cast<std::uint32_t>(a.y) -
                                      static_cast<std::uint32_t>(b.y))};
  }
  static RecI nearest(Rec a) { return {_mm_cvtss_si32(a.x), _mm_cvtss_si32(a.y)}; }
  static RecI truncate(Rec a) { return {_mm_cvttss_si32(a.x), _mm_cvttss_si32(a.y)}; }
  static Rec to_float(RecI a) {
    return {_mm_cvtsi32_ss(_mm_setzero_ps(), a.x), _mm_cvtsi32_ss(_mm_setzero_ps(), a.y)};
  }
  static RecI min(RecI a, RecI b) { return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y}; }
  static RecI max(RecI a, RecI b) { return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y}; }
  static RecI set_rec_int(std::int32_t x, std::int32_t y) { return {x, y}; }

  // Doubles, one lane a body, from and to float columns.
  static D set1_d(double a) { return {_mm_set_sd(a)}; }
  static D add(D a, D b) { return {_mm_add_sd(a.v, b.v)}; }
  static D sub(D a, D b) { return {_mm_sub_sd(a.v, b.v)}; }
  static D mul(D a, D b) { return {_mm_mul_sd(a.v, b.v)}; }
  static D div(D a, D b) { return {_mm_div_sd(a.v, b.v)}; }
  static D sqrt(D a) { return {_mm_sqrt_sd(a.v, a.v)}; }
  static D less(D a, D b) { return {_mm_cmplt_sd(a.v, b.v)}; }
  static D less_equal(D a, D b) { return {_mm_cmple_sd(a.v, b.v)}; }
  static D but_not(D a, D b) { return {_mm_andnot_pd(b.v, a.v)}; }  // a & ~b
  static D select(D mask, D yes, D no) {
    return {_mm_or_pd(_mm_and_pd(mask.v, yes.v), _mm_andnot_pd(mask.v, no.v))};
  }
  static D mask_d(const std::uint8_t* p) {
    return {_mm_castsi128_pd(_mm_cvtsi64_si128(static_cast<std::int8_t>(*p)))};
  }
  static D load_d(const float* p) { return {_mm_cvtss_sd(_mm_setzero_pd(), _mm_load_ss(p))}; }
  static void load_rec_d(const float* p, D& x, D& y) {
    x = load_d(p);
    y = load_d(p + 1);
  }
  static void load_rec_int_d(const std::int32_t* p, D& x, D& y) {
    x = {_mm_cvtsi32_sd(_mm_setzero_pd(), p[0])};
    y = {_mm_cvtsi32_sd(_mm_setzero_pd(), p[1])};
  }
  static void store_rec_d(float* p, D x, D y) {
    _mm_store_ss(p, _mm_cvtsd_ss(_mm_setzero_ps(), x.v));
    _mm_store_ss(p + 1, _mm_cvtsd_ss(_mm_setzero_ps(), y.v));
  }
  static D round_to_float(D a) {
    return {_mm_cvtss_sd(_mm_setzero_pd(), _mm_cvtsd_ss(_mm_setzero_ps(), a.v))};
  }

  /// Two floats, one a record, spread to {a, a} records.
  static Rec spread(const float* p) {
    const __m128 a = _mm_load_ss(p);
    return {a, a};
  }
  /// Largest x lane of the records (callers hold the same value in both lanes).
  static float largest(Rec a) { return _mm_cvtss_f32(a.x); }
  /// keys[r] = y stride + x, for coordinates already clamped to the grid.
  static void store_keys(std::uint32_t* keys, RecI c, std::uint32_t stride) {
    keys[0] = static_cast<std::uint32_t>(c.y) * stride + static_cast<std::uint32_t>(c.x);
  }

  static void candidates(const std::int32_t* pos, const float* reach, std::uint32_t j, I& x, I& y,
                         F& r) {
    x = {pos[2 * std::size_t{j}]};
    y = {pos[2 * std::size_t{j} + 1]};
    r = load(reach + j);
  }
  /// Packs the values of the lanes in mask to out; writes a whole register in any case.
  static std::uint32_t pack(std::uint32_t* out, const std::uint32_t* in, std::uint32_t mask) {
    *out = *in;
    return mask;
  }
  static void fill(std::uint32_t* out, std::uint32_t value) { *out = value; }
  static I set1_int(std::int32_t a) { return {a}; }
  static void append(std::uint32_t* out, std::uint32_t j) { *out = j; }
};

using Lanes = ScalarLanes;

}  // namespace
}  // namespace psim::kernels
