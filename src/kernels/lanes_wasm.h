// Lane types of WebAssembly's SIMD128: 4 floats, 2 doubles or 2 records a register. lanes_scalar.h defines
// what each operation means in bits.
#pragma once

#include <wasm_simd128.h>

#include <cstdint>

#include "block_layout.h"
#include "compact_table.h"
#include "four_wasm.h"

namespace psim::kernels {
namespace {

struct WasmLanes {
  static constexpr std::uint32_t width = 4;
  static constexpr std::uint32_t records = 2;
  static constexpr std::uint32_t doubles = 2;
  using Four = WasmFour;

  struct F {
    v128_t v;
    F() = default;
    F(float a) : v(wasm_f32x4_splat(a)) {}
    F(v128_t a) : v(a) {}
  };
  struct D {
    v128_t v;
    D() = default;
    D(double a) : v(wasm_f64x2_splat(a)) {}
    D(v128_t a) : v(a) {}
  };
  struct I {
    v128_t v;
    I() = default;
    explicit I(std::int32_t a) : v(wasm_i32x4_splat(a)) {}
    I(v128_t a) : v(a) {}
  };
  struct Rec {  // x0 y0 x1 y1
    v128_t v;
    Rec() = default;
    Rec(float x, float y) : v(wasm_f32x4_make(x, y, x, y)) {}
    Rec(v128_t a) : v(a) {}
  };
  struct RecI {
    v128_t v;
    RecI() = default;
    RecI(std::int32_t x, std::int32_t y) : v(wasm_i32x4_make(x, y, x, y)) {}
    RecI(v128_t a) : v(a) {}
  };
  // All bits of a lane are set, or none.
  struct M {
    v128_t v;
  };
  struct MD {
    v128_t v;
  };
  struct MRec {
    v128_t v;
  };
  struct Signs {
    v128_t v;
  };

  // ---- floats ----
  // WebAssembly's pmin(a, b) is b < a ? b : a, and its pmax(a, b) is a < b ? b : a: the operands change places.
  static F load(const float* p) { return wasm_v128_load(p); }
  static void store(float* p, F a) { wasm_v128_store(p, a.v); }
  friend F operator+(F a, F b) { return wasm_f32x4_add(a.v, b.v); }
  friend F operator-(F a, F b) { return wasm_f32x4_sub(a.v, b.v); }
  friend F operator*(F a, F b) { return wasm_f32x4_mul(a.v, b.v); }
  friend F operator/(F a, F b) { return wasm_f32x4_div(a.v, b.v); }
  friend F operator-(F a) { return wasm_f32x4_neg(a.v); }
  friend F& operator+=(F& a, F b) { return a = a + b; }
  friend F& operator-=(F& a, F b) { return a = a - b; }
  friend F sqrt(F a) { return wasm_f32x4_sqrt(a.v); }
  friend F abs(F a) { return wasm_f32x4_abs(a.v); }
  friend F floor(F a) { return wasm_f32x4_floor(a.v); }
  friend F min(F a, F b) { return wasm_f32x4_pmin(b.v, a.v); }
  friend F max(F a, F b) { return wasm_f32x4_pmax(b.v, a.v); }
  friend M operator<(F a, F b) { return {wasm_f32x4_lt(a.v, b.v)}; }
  friend M operator<=(F a, F b) { return {wasm_f32x4_le(a.v, b.v)}; }
  friend M operator!=(F a, F b) { return {wasm_f32x4_ne(a.v, b.v)}; }
  friend Signs negative(F a) { return {wasm_i32x4_shr(a.v, 31)}; }

  // ---- masks ----
  static M none() { return {wasm_i32x4_const(0, 0, 0, 0)}; }
  static M every() { return {wasm_i32x4_const(-1, -1, -1, -1)}; }
  friend M operator&(M a, M b) { return {wasm_v128_and(a.v, b.v)}; }
  friend M operator|(M a, M b) { return {wasm_v128_or(a.v, b.v)}; }
  friend M but_not(M a, M b) { return {wasm_v128_andnot(a.v, b.v)}; }
  friend F keep(M m, F a) { return wasm_v128_and(m.v, a.v); }
  friend F drop(M m, F a) { return wasm_v128_andnot(a.v, m.v); }
  friend F select(M m, F yes, F no) { return wasm_v128_bitselect(yes.v, no.v, m.v); }
  friend M select(M m, M yes, M no) { return {wasm_v128_bitselect(yes.v, no.v, m.v)}; }
  friend std::uint32_t bits(M m) { return static_cast<std::uint32_t>(wasm_i32x4_bitmask(m.v)); }
  friend bool any(M m) { return wasm_v128_any_true(m.v); }
  friend bool all(M m) { return wasm_i32x4_all_true(m.v); }
  friend Signs operator&(Signs a, Signs b) { return {wasm_v128_and(a.v, b.v)}; }
  friend F select(Signs m, F yes, F no) { return wasm_v128_bitselect(yes.v, no.v, m.v); }
  friend M select(Signs m, M yes, M no) { return {wasm_v128_bitselect(yes.v, no.v, m.v)}; }
  friend bool all(Signs m) { return wasm_i32x4_all_true(m.v); }

  // ---- whole numbers ----
  static I load_int(const std::int32_t* p) { return wasm_v128_load(p); }
  static void store_int(std::int32_t* p, I a) { wasm_v128_store(p, a.v); }
  friend I operator-(I a, I b) { return wasm_i32x4_sub(a.v, b.v); }
  friend F to_float(I a) { return wasm_f32x4_convert_i32x4(a.v); }

  // ---- gathers and scatters ----
  template <int Step>
  [[gnu::always_inline]] static void gather(const float* rec, const std::uint32_t* slots, F& x, F& y) {
    columns<Step>(rec, slots, x.v, y.v);
  }
  template <int Step>
  [[gnu::always_inline]] static void gather_int(const std::int32_t* rec, const std::uint32_t* slots, I& x, I& y) {
    columns<Step>(rec, slots, x.v, y.v);
  }
  [[gnu::always_inline]] static void gather4(const float* const* at, std::size_t offset, F& a, F& b, F& c, F& d) {
    const F p = load(at[0] + offset), q = load(at[1] + offset), r = load(at[2] + offset), s = load(at[3] + offset);
    const v128_t pq_low = low(p.v, q.v), pq_high = high(p.v, q.v), rs_low = low(r.v, s.v), rs_high = high(r.v, s.v);
    a = wasm_i64x2_shuffle(pq_low, rs_low, 0, 2), b = wasm_i64x2_shuffle(pq_low, rs_low, 1, 3);
    c = wasm_i64x2_shuffle(pq_high, rs_high, 0, 2), d = wasm_i64x2_shuffle(pq_high, rs_high, 1, 3);
  }
  [[gnu::always_inline]] static void scatter4(float* const* at, std::size_t offset, F a, F b, F c, F d) {
    const v128_t ab_low = low(a.v, b.v), ab_high = high(a.v, b.v), cd_low = low(c.v, d.v), cd_high = high(c.v, d.v);
    wasm_v128_store(at[0] + offset, wasm_i64x2_shuffle(ab_low, cd_low, 0, 2));
    wasm_v128_store(at[1] + offset, wasm_i64x2_shuffle(ab_low, cd_low, 1, 3));
    wasm_v128_store(at[2] + offset, wasm_i64x2_shuffle(ab_high, cd_high, 0, 2));
    wasm_v128_store(at[3] + offset, wasm_i64x2_shuffle(ab_high, cd_high, 1, 3));
  }
  template <int Step>
  [[gnu::always_inline]] static void scatter(float* rec, const std::uint32_t* slots, F x, F y) {
    const v128_t first = low(x.v, y.v), last = high(x.v, y.v);
    wasm_v128_store64_lane(rec + 2 * static_cast<std::size_t>(slots[0]), first, 0);
    wasm_v128_store64_lane(rec + 2 * static_cast<std::size_t>(slots[Step]), first, 1);
    wasm_v128_store64_lane(rec + 2 * static_cast<std::size_t>(slots[2 * Step]), last, 0);
    wasm_v128_store64_lane(rec + 2 * static_cast<std::size_t>(slots[3 * Step]), last, 1);
  }
  template <int Step>
  [[gnu::always_inline]] static F gather1(const float* col, const std::uint32_t* slots) {
    v128_t a = wasm_v128_load32_zero(col + slots[0]);
    a = wasm_v128_load32_lane(col + slots[Step], a, 1);
    a = wasm_v128_load32_lane(col + slots[2 * Step], a, 2);
    return wasm_v128_load32_lane(col + slots[3 * Step], a, 3);
  }
  template <int Step>
  [[gnu::always_inline]] static void scatter1(float* col, const std::uint32_t* slots, F a) {
    wasm_v128_store32_lane(col + slots[0], a.v, 0);
    wasm_v128_store32_lane(col + slots[Step], a.v, 1);
    wasm_v128_store32_lane(col + slots[2 * Step], a.v, 2);
    wasm_v128_store32_lane(col + slots[3 * Step], a.v, 3);
  }

  // ---- records ----
  static Rec load_rec(const float* p) { return wasm_v128_load(p); }
  static void store_rec(float* p, Rec a) { wasm_v128_store(p, a.v); }
  static void store_records(float* p, F x, F y) {
    wasm_v128_store(p, low(x.v, y.v));
    wasm_v128_store(p + 4, high(x.v, y.v));
  }
  static Rec spread(const float* p) {
    const v128_t a = wasm_v128_load64_zero(p);
    return low(a, a);
  }
  static MRec mask_rec(const std::uint8_t* p) {
    const v128_t two = wasm_v128_load16_splat(p);
    return {wasm_i8x16_shuffle(two, two, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1)};
  }
  friend Rec operator+(Rec a, Rec b) { return wasm_f32x4_add(a.v, b.v); }
  friend Rec operator-(Rec a, Rec b) { return wasm_f32x4_sub(a.v, b.v); }
  friend Rec operator*(Rec a, Rec b) { return wasm_f32x4_mul(a.v, b.v); }
  friend Rec sqrt(Rec a) { return wasm_f32x4_sqrt(a.v); }
  friend Rec abs(Rec a) { return wasm_f32x4_abs(a.v); }
  friend Rec min(Rec a, Rec b) { return wasm_f32x4_pmin(b.v, a.v); }
  friend Rec max(Rec a, Rec b) { return wasm_f32x4_pmax(b.v, a.v); }
  friend Rec norm2(Rec a) {
    const v128_t s = wasm_f32x4_mul(a.v, a.v);
    return wasm_f32x4_add(s, wasm_i32x4_shuffle(s, s, 1, 0, 3, 2));
  }
  friend MRec operator<=(Rec a, Rec b) { return {wasm_f32x4_le(a.v, b.v)}; }
  friend MRec operator&(MRec a, MRec b) { return {wasm_v128_and(a.v, b.v)}; }
  friend Rec keep(MRec m, Rec a) { return wasm_v128_and(m.v, a.v); }
  friend Rec drop(MRec m, Rec a) { return wasm_v128_andnot(a.v, m.v); }
  friend Rec select(MRec m, Rec yes, Rec no) { return wasm_v128_bitselect(yes.v, no.v, m.v); }
  friend bool all(MRec m) { return wasm_i32x4_all_true(m.v); }
  static MRec every_rec() { return {every().v}; }
  static float largest(Rec a) {
    const float first = wasm_f32x4_extract_lane(a.v, 0), second = wasm_f32x4_extract_lane(a.v, 2);
    return first > second ? first : second;
  }

  static RecI load_rec_int(const std::int32_t* p) { return wasm_v128_load(p); }
  static void store_rec_int(std::int32_t* p, RecI a) { wasm_v128_store(p, a.v); }
  friend RecI operator+(RecI a, RecI b) { return wasm_i32x4_add(a.v, b.v); }
  friend RecI operator-(RecI a, RecI b) { return wasm_i32x4_sub(a.v, b.v); }
  friend RecI min(RecI a, RecI b) { return wasm_i32x4_min(a.v, b.v); }
  friend RecI max(RecI a, RecI b) { return wasm_i32x4_max(a.v, b.v); }
  friend RecI nearest(Rec a) { return whole(wasm_f32x4_nearest(a.v)); }
  friend RecI truncate(Rec a) { return whole(a.v); }
  friend Rec to_float(RecI a) { return wasm_f32x4_convert_i32x4(a.v); }
  static void store_keys(std::uint32_t* keys, RecI c, std::uint32_t stride) {
    const int s = static_cast<int>(stride);
    const v128_t p = wasm_i32x4_mul(c.v, wasm_i32x4_make(1, s, 1, s));
    const v128_t k = wasm_i32x4_add(p, wasm_i32x4_shuffle(p, p, 1, 0, 3, 2));
    wasm_v128_store64_lane(keys, wasm_i32x4_shuffle(k, k, 0, 2, 0, 2), 0);
  }

  // ---- doubles ----
  friend D operator+(D a, D b) { return wasm_f64x2_add(a.v, b.v); }
  friend D operator-(D a, D b) { return wasm_f64x2_sub(a.v, b.v); }
  friend D operator*(D a, D b) { return wasm_f64x2_mul(a.v, b.v); }
  friend D operator/(D a, D b) { return wasm_f64x2_div(a.v, b.v); }
  friend D sqrt(D a) { return wasm_f64x2_sqrt(a.v); }
  friend MD operator<(D a, D b) { return {wasm_f64x2_lt(a.v, b.v)}; }
  friend MD operator<=(D a, D b) { return {wasm_f64x2_le(a.v, b.v)}; }
  friend MD but_not(MD a, MD b) { return {wasm_v128_andnot(a.v, b.v)}; }
  friend D select(MD m, D yes, D no) { return wasm_v128_bitselect(yes.v, no.v, m.v); }
  friend D round_to_float(D a) { return wasm_f64x2_promote_low_f32x4(wasm_f32x4_demote_f64x2_zero(a.v)); }
  static MD mask_d(const std::uint8_t* p) { return {mask_rec(p).v}; }
  static D load_d(const float* p) { return wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(p)); }
  static void load_rec_d(const float* p, D& x, D& y) {
    const v128_t a = wasm_v128_load(p);
    x = wasm_f64x2_promote_low_f32x4(wasm_i32x4_shuffle(a, a, 0, 2, 0, 2));
    y = wasm_f64x2_promote_low_f32x4(wasm_i32x4_shuffle(a, a, 1, 3, 1, 3));
  }
  static void load_rec_int_d(const std::int32_t* p, D& x, D& y) {
    const v128_t a = wasm_v128_load(p);
    x = wasm_f64x2_convert_low_i32x4(wasm_i32x4_shuffle(a, a, 0, 2, 0, 2));
    y = wasm_f64x2_convert_low_i32x4(wasm_i32x4_shuffle(a, a, 1, 3, 1, 3));
  }
  static void store_rec_d(float* p, D x, D y) {
    wasm_v128_store(p, low(wasm_f32x4_demote_f64x2_zero(x.v), wasm_f32x4_demote_f64x2_zero(y.v)));
  }

  // ---- pair search ----
  /// Two registers of four candidates, one after the other.
  template <class Near>
  [[gnu::always_inline]] static std::uint32_t four_and_four(const std::int32_t* pos, const float* reach,
                                                            std::uint32_t j0, std::uint32_t end0, std::uint32_t j1,
                                                            std::uint32_t end1, std::uint32_t i, std::uint32_t* owner,
                                                            std::uint32_t* other, const Near& near) {
    const std::uint32_t first = four(pos, reach, j0, end0, i, owner, other, near);
    return first + four(pos, reach, j1, end1, i, owner + first, other + first, near);
  }
  static std::uint32_t pack(std::uint32_t* out, const std::uint32_t* in, std::uint32_t mask) {
    return append(out, wasm_v128_load(in), mask);
  }

 private:
  static constexpr auto kCompact4 = make_compact4();

  [[gnu::always_inline]] static v128_t low(v128_t a, v128_t b) { return wasm_i32x4_shuffle(a, b, 0, 4, 1, 5); }
  [[gnu::always_inline]] static v128_t high(v128_t a, v128_t b) { return wasm_i32x4_shuffle(a, b, 2, 6, 3, 7); }
  // Two records at p and q: p.x p.y q.x q.y.
  [[gnu::always_inline]] static v128_t join(const void* p, const void* q) {
    return wasm_v128_load64_lane(q, wasm_v128_load64_zero(p), 1);
  }
  // Of the four records at the slots: every x, every y.
  template <int Step, class Number>
  [[gnu::always_inline]] static void columns(const Number* rec, const std::uint32_t* slots, v128_t& x, v128_t& y) {
    const auto at = [&](int k) { return rec + 2 * static_cast<std::size_t>(slots[k * Step]); };
    const v128_t a = join(at(0), at(1)), b = join(at(2), at(3));
    x = wasm_i32x4_shuffle(a, b, 0, 2, 4, 6);
    y = wasm_i32x4_shuffle(a, b, 1, 3, 5, 7);
  }
  // Towards zero. WebAssembly gives 2^31 - 1 above and 0 for a NaN; here both are -2^31.
  [[gnu::always_inline]] static v128_t whole(v128_t a) {
    const v128_t fits = wasm_f32x4_lt(a, wasm_f32x4_splat(2147483648.0f));
    return wasm_v128_bitselect(wasm_i32x4_trunc_sat_f32x4(a), wasm_i32x4_splat(-2147483647 - 1), fits);
  }
  template <class Near>
  [[gnu::always_inline]] static std::uint32_t four(const std::int32_t* pos, const float* reach, std::uint32_t j,
                                                   std::uint32_t end, std::uint32_t i, std::uint32_t* owner,
                                                   std::uint32_t* other, const Near& near) {
    const v128_t a = wasm_v128_load(pos + 2 * std::size_t{j});
    const v128_t b = wasm_v128_load(pos + 2 * std::size_t{j} + 4);
    const I x = wasm_i32x4_shuffle(a, b, 0, 2, 4, 6);
    const I y = wasm_i32x4_shuffle(a, b, 1, 3, 5, 7);
    const F r = load(reach + j);
    wasm_v128_store(owner, wasm_i32x4_splat(static_cast<int>(i)));
    const v128_t lane = wasm_i32x4_const(0, 1, 2, 3);
    const M below{wasm_i32x4_gt(wasm_i32x4_splat(static_cast<int>(end - j)), lane)};
    const v128_t bodies = wasm_i32x4_add(wasm_i32x4_splat(static_cast<int>(j)), lane);
    return append(other, bodies, bits(near(x, y, r)) & bits(below));
  }
  /// Writes the lanes in mask, packed, and returns how many; writes 4 in any case.
  static std::uint32_t append(std::uint32_t* out, v128_t lanes, std::uint32_t mask) {
    wasm_v128_store(out, wasm_i8x16_swizzle(lanes, wasm_v128_load(kCompact4.byte[mask])));
    return kCompact4.count[mask];
  }
};

using Lanes = WasmLanes;

}  // namespace
}  // namespace psim::kernels
