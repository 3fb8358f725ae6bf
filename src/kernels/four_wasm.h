// Four floats that belong together, in a register of SIMD128. four_scalar.h defines what each operation means in bits.
#pragma once

#include <wasm_simd128.h>

namespace psim::kernels {
namespace {

struct WasmFour {
  v128_t v;

  WasmFour() = default;
  WasmFour(float all) : v(wasm_f32x4_splat(all)) {}
  WasmFour(v128_t a) : v(a) {}
  WasmFour(float a, float b, float c, float d) : v(wasm_f32x4_make(a, b, c, d)) {}
  static WasmFour load(const float* p) { return wasm_v128_load(p); }
  friend void store(float* p, WasmFour a) { wasm_v128_store(p, a.v); }
  friend WasmFour operator+(WasmFour a, WasmFour b) { return wasm_f32x4_add(a.v, b.v); }
  friend WasmFour operator-(WasmFour a, WasmFour b) { return wasm_f32x4_sub(a.v, b.v); }
  friend WasmFour floor(WasmFour a) { return wasm_f32x4_floor(a.v); }
  friend void transpose(WasmFour& a, WasmFour& b, WasmFour& c, WasmFour& d) {
    const v128_t ab = wasm_i32x4_shuffle(a.v, b.v, 0, 4, 1, 5), ab2 = wasm_i32x4_shuffle(a.v, b.v, 2, 6, 3, 7);
    const v128_t cd = wasm_i32x4_shuffle(c.v, d.v, 0, 4, 1, 5), cd2 = wasm_i32x4_shuffle(c.v, d.v, 2, 6, 3, 7);
    a = wasm_i32x4_shuffle(ab, cd, 0, 1, 4, 5);
    b = wasm_i32x4_shuffle(ab, cd, 2, 3, 6, 7);
    c = wasm_i32x4_shuffle(ab2, cd2, 0, 1, 4, 5);
    d = wasm_i32x4_shuffle(ab2, cd2, 2, 3, 6, 7);
  }
  friend WasmFour operator*(WasmFour a, WasmFour b) { return wasm_f32x4_mul(a.v, b.v); }
  friend WasmFour sums(WasmFour a, WasmFour b, WasmFour c, WasmFour d) { return pairs(pairs(a, b), pairs(c, d)); }

 private:
  // a0 + a1, a2 + a3, b0 + b1, b2 + b3.
  static WasmFour pairs(WasmFour a, WasmFour b) {
    return wasm_f32x4_add(wasm_i32x4_shuffle(a.v, b.v, 0, 2, 4, 6), wasm_i32x4_shuffle(a.v, b.v, 1, 3, 5, 7));
  }
};

}  // namespace
}  // namespace psim::kernels
