// Lane types of the scalar variant, one lane a register, in plain C++: the definition of what each
// operation means in bits, and the build for processors that have no lane types of their own.
//
// A lane type has registers F (floats), D (doubles), I (whole numbers), Rec (float records {x, y}) and
// RecI (records of whole numbers), and masks M of F, MD of D and MRec of Rec. A mask only comes from a
// comparison or a byte column and only goes into the operations below, so that a processor may hold it
// as it likes. Signs is what `negative` gives: the sign bit of each lane, which -0 has too.
#pragma once

#include <math.h>  // <cmath> would add inline functions, whose code linkers share between instruction sets

#include <cstdint>
#include <cstring>

#include "block_layout.h"
#include "compiler.h"
#include "four_scalar.h"

namespace psim::kernels {
namespace {

struct ScalarLanes {
  static constexpr std::uint32_t width = 1;    // floats a register
  static constexpr std::uint32_t records = 1;  // records {x, y} a register
  static constexpr std::uint32_t doubles = 1;  // doubles a register
  using Four = ScalarFour;

  struct F {
    float v;
    F() = default;
    F(float a) : v(a) {}
  };
  struct D {
    double v;
    D() = default;
    D(double a) : v(a) {}
  };
  struct I {
    std::int32_t v;
    I() = default;
    explicit I(std::int32_t a) : v(a) {}
  };
  struct Rec {
    float x, y;
    Rec() = default;
    Rec(float x_value, float y_value) : x(x_value), y(y_value) {}
  };
  struct RecI {
    std::int32_t x, y;
    RecI() = default;
    RecI(std::int32_t x_value, std::int32_t y_value) : x(x_value), y(y_value) {}
  };
  struct M {
    bool v;
    explicit operator bool() const { return v; }
  };
  struct MD {
    bool v;
  };
  struct MRec {
    bool x, y;
  };
  struct Signs {
    bool v;
  };

  // ---- floats: one lane a contact or body ----
  static F load(const float* p) { return *p; }
  static void store(float* p, F a) { *p = a.v; }
  friend F operator+(F a, F b) { return a.v + b.v; }
  friend F operator-(F a, F b) { return a.v - b.v; }
  friend F operator*(F a, F b) { return a.v * b.v; }
  friend F operator/(F a, F b) { return a.v / b.v; }
  friend F operator-(F a) { return -a.v; }  // turns the sign of a zero or a NaN, too
  friend F& operator+=(F& a, F b) { return a = a + b; }
  friend F& operator-=(F& a, F b) { return a = a - b; }
  friend F sqrt(F a) { return ::sqrtf(a.v); }
  friend F abs(F a) { return ::fabsf(a.v); }
  friend F floor(F a) { return ::floorf(a.v); }
  friend F min(F a, F b) { return a.v < b.v ? a.v : b.v; }  // b where one is a NaN
  friend F max(F a, F b) { return a.v > b.v ? a.v : b.v; }
  friend M operator<(F a, F b) { return {a.v < b.v}; }
  friend M operator<=(F a, F b) { return {a.v <= b.v}; }
  friend M operator!=(F a, F b) { return {a.v != b.v}; }  // also where one is a NaN
  friend Signs negative(F a) { return {sign_bit(a.v)}; }

  // ---- masks ----
  static M none() { return {false}; }
  static M every() { return {true}; }
  friend M operator&(M a, M b) { return {(a.v & b.v) != 0}; }
  friend M operator|(M a, M b) { return {(a.v | b.v) != 0}; }
  friend M but_not(M a, M b) { return {(a.v & !b.v) != 0}; }
  /// The value where the mask is set, +0 elsewhere.
  friend F keep(M m, F a) { return m.v ? a.v : 0.0f; }
  friend F drop(M m, F a) { return m.v ? 0.0f : a.v; }
  friend F select(M m, F yes, F no) { return m.v ? yes.v : no.v; }
  friend M select(M m, M yes, M no) { return {m.v ? yes.v : no.v}; }
  /// Bit k for lane k.
  friend std::uint32_t bits(M m) { return m.v ? 1 : 0; }
  friend bool any(M m) { return m.v; }
  friend bool all(M m) { return m.v; }
  friend Signs operator&(Signs a, Signs b) { return {(a.v & b.v) != 0}; }
  friend F select(Signs m, F yes, F no) { return m.v ? yes.v : no.v; }
  friend M select(Signs m, M yes, M no) { return {m.v ? yes.v : no.v}; }
  friend bool all(Signs m) { return m.v; }

  // ---- whole numbers: differences wrap around ----
  static I load_int(const std::int32_t* p) { return I{*p}; }
  static void store_int(std::int32_t* p, I a) { *p = a.v; }
  friend I operator-(I a, I b) { return I{wrapped_sub(a.v, b.v)}; }
  friend F to_float(I a) { return static_cast<float>(a.v); }

  // ---- gathers and scatters: lane k is at slots[Step * k] ----
  template <int Step>
  PSIM_INLINE static void gather(const float* rec, const std::uint32_t* slots, F& x, F& y) {
    const float* p = rec + 2 * static_cast<std::size_t>(slots[0]);
    x = p[0];
    y = p[1];
  }
  template <int Step>
  PSIM_INLINE static void gather_int(const std::int32_t* rec, const std::uint32_t* slots, I& x, I& y) {
    const std::int32_t* p = rec + 2 * static_cast<std::size_t>(slots[0]);
    x = I{p[0]};
    y = I{p[1]};
  }
  /// Four floats in a row of every lane, from at[lane] + offset, into four different registers.
  PSIM_INLINE static void gather4(const float* const* at, std::size_t offset, F& a, F& b, F& c, F& d) {
    const float* p = at[0] + offset;
    a = p[0], b = p[1], c = p[2], d = p[3];
  }
  /// The reverse of gather4.
  PSIM_INLINE static void scatter4(float* const* at, std::size_t offset, F a, F b, F c, F d) {
    float* p = at[0] + offset;
    p[0] = a.v, p[1] = b.v, p[2] = c.v, p[3] = d.v;
  }
  template <int Step>
  PSIM_INLINE static void scatter(float* rec, const std::uint32_t* slots, F x, F y) {
    float* p = rec + 2 * static_cast<std::size_t>(slots[0]);
    p[0] = x.v;
    p[1] = y.v;
  }
  template <int Step>
  PSIM_INLINE static F gather1(const float* col, const std::uint32_t* slots) {
    return col[slots[0]];
  }
  template <int Step>
  PSIM_INLINE static void scatter1(float* col, const std::uint32_t* slots, F a) {
    col[slots[0]] = a.v;
  }

  // ---- records: one a body ----
  static Rec load_rec(const float* p) { return {p[0], p[1]}; }
  static void store_rec(float* p, Rec a) {
    p[0] = a.x;
    p[1] = a.y;
  }
  /// x and y of a register's bodies as records, side by side.
  static void store_records(float* p, F x, F y) {
    p[0] = x.v;
    p[1] = y.v;
  }
  /// One float a record, as {a, a}.
  static Rec spread(const float* p) { return {*p, *p}; }
  /// From one byte a record, 0 or 0xFF.
  static MRec mask_rec(const std::uint8_t* p) { return {*p != 0, *p != 0}; }
  friend Rec operator+(Rec a, Rec b) { return {a.x + b.x, a.y + b.y}; }
  friend Rec operator-(Rec a, Rec b) { return {a.x - b.x, a.y - b.y}; }
  friend Rec operator*(Rec a, Rec b) { return {a.x * b.x, a.y * b.y}; }
  friend Rec sqrt(Rec a) { return {::sqrtf(a.x), ::sqrtf(a.y)}; }
  friend Rec abs(Rec a) { return {::fabsf(a.x), ::fabsf(a.y)}; }
  friend Rec min(Rec a, Rec b) { return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y}; }
  friend Rec max(Rec a, Rec b) { return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y}; }
  /// x^2 + y^2 of each record, in both of its places.
  friend Rec norm2(Rec a) {
    const float s = a.x * a.x + a.y * a.y;
    return {s, s};
  }
  friend MRec operator<=(Rec a, Rec b) { return {a.x <= b.x, a.y <= b.y}; }
  friend MRec operator&(MRec a, MRec b) { return {(a.x & b.x) != 0, (a.y & b.y) != 0}; }
  friend Rec keep(MRec m, Rec a) { return {m.x ? a.x : 0.0f, m.y ? a.y : 0.0f}; }
  friend Rec drop(MRec m, Rec a) { return {m.x ? 0.0f : a.x, m.y ? 0.0f : a.y}; }
  friend Rec select(MRec m, Rec yes, Rec no) { return {m.x ? yes.x : no.x, m.y ? yes.y : no.y}; }
  friend bool all(MRec m) { return m.x && m.y; }
  static MRec every_rec() { return {true, true}; }
  /// The largest x of the records, where both places of each hold the same.
  static float largest(Rec a) { return a.x; }

  static RecI load_rec_int(const std::int32_t* p) { return {p[0], p[1]}; }
  static void store_rec_int(std::int32_t* p, RecI a) {
    p[0] = a.x;
    p[1] = a.y;
  }
  friend RecI operator+(RecI a, RecI b) { return {wrapped_add(a.x, b.x), wrapped_add(a.y, b.y)}; }
  friend RecI operator-(RecI a, RecI b) { return {wrapped_sub(a.x, b.x), wrapped_sub(a.y, b.y)}; }
  friend RecI min(RecI a, RecI b) { return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y}; }
  friend RecI max(RecI a, RecI b) { return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y}; }
  /// The nearest whole number, of two the even one; -2^31 where there is none that fits.
  friend RecI nearest(Rec a) { return {nearest_int(a.x), nearest_int(a.y)}; }
  /// The whole number towards zero; -2^31 where there is none that fits.
  friend RecI truncate(Rec a) { return {truncated_int(a.x), truncated_int(a.y)}; }
  friend Rec to_float(RecI a) { return {static_cast<float>(a.x), static_cast<float>(a.y)}; }
  /// keys[r] = y stride + x, for coordinates that are clamped to the grid.
  static void store_keys(std::uint32_t* keys, RecI c, std::uint32_t stride) {
    keys[0] = static_cast<std::uint32_t>(c.y) * stride + static_cast<std::uint32_t>(c.x);
  }

  // ---- doubles: one lane a body, from and to float columns ----
  friend D operator+(D a, D b) { return a.v + b.v; }
  friend D operator-(D a, D b) { return a.v - b.v; }
  friend D operator*(D a, D b) { return a.v * b.v; }
  friend D operator/(D a, D b) { return a.v / b.v; }
  friend D sqrt(D a) { return ::sqrt(a.v); }
  friend MD operator<(D a, D b) { return {a.v < b.v}; }
  friend MD operator<=(D a, D b) { return {a.v <= b.v}; }
  friend MD but_not(MD a, MD b) { return {(a.v & !b.v) != 0}; }
  friend D select(MD m, D yes, D no) { return m.v ? yes.v : no.v; }
  friend D round_to_float(D a) { return static_cast<double>(static_cast<float>(a.v)); }
  static MD mask_d(const std::uint8_t* p) { return {*p != 0}; }
  static D load_d(const float* p) { return static_cast<double>(*p); }
  static void load_rec_d(const float* p, D& x, D& y) {
    x = static_cast<double>(p[0]);
    y = static_cast<double>(p[1]);
  }
  static void load_rec_int_d(const std::int32_t* p, D& x, D& y) {
    x = static_cast<double>(p[0]);
    y = static_cast<double>(p[1]);
  }
  static void store_rec_d(float* p, D x, D y) {
    p[0] = static_cast<float>(x.v);
    p[1] = static_cast<float>(y.v);
  }

  // ---- pair search ----
  /// Asks near(x, y, reach) of up to 8 bodies: those from j0 on that lie below end0, at most 4, and those from
  /// j1 on that lie below end1, at most 4. Writes i to owner and the number of each near body to other, packed
  /// and in order, and returns how many. May write 8 numbers in any case, and may read 4 bodies from either place.
  template <class Near>
  PSIM_INLINE static std::uint32_t four_and_four(const std::int32_t* pos, const float* reach, std::uint32_t j0,
                                                 std::uint32_t end0, std::uint32_t j1, std::uint32_t end1,
                                                 std::uint32_t i, std::uint32_t* owner, std::uint32_t* other,
                                                 const Near& near) {
    std::uint32_t count = 0;
    const auto ask = [&](std::uint32_t j) PSIM_INLINE_LAMBDA {
      owner[count] = i;
      other[count] = j;
      count += bits(near(I{pos[2 * std::size_t{j}]}, I{pos[2 * std::size_t{j} + 1]}, F{reach[j]}));
    };
    for (std::uint32_t j = j0; j < end0 && j < j0 + 4; ++j) ask(j);
    for (std::uint32_t j = j1; j < end1 && j < j1 + 4; ++j) ask(j);
    return count;
  }
  /// Packs the values of the lanes in mask to out and returns how many; writes a whole register in any case.
  static std::uint32_t pack(std::uint32_t* out, const std::uint32_t* in, std::uint32_t mask) {
    *out = *in;
    return mask;
  }

 private:
  static constexpr std::int32_t kNoInt = -2147483647 - 1;

  static bool sign_bit(float a) {
    std::uint32_t b;
    std::memcpy(&b, &a, sizeof b);
    return (b >> 31) != 0;
  }
  static std::int32_t wrapped_add(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
  }
  static std::int32_t wrapped_sub(std::int32_t a, std::int32_t b) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) - static_cast<std::uint32_t>(b));
  }
  static bool fits_int(float a) { return a >= -2147483648.0f && a < 2147483648.0f; }
  static std::int32_t truncated_int(float a) { return fits_int(a) ? static_cast<std::int32_t>(a) : kNoInt; }
  /// 1.5 x 2^52 + a rounds a to a whole number, which the sum's low 32 bits hold.
  static std::int32_t nearest_int(float a) {
    const double sum = static_cast<double>(a) + 6755399441055744.0;
    std::uint64_t b;
    std::memcpy(&b, &sum, sizeof b);
    return fits_int(a) ? static_cast<std::int32_t>(static_cast<std::uint32_t>(b)) : kNoInt;
  }
};

using Lanes = ScalarLanes;

}  // namespace
}  // namespace psim::kernels
