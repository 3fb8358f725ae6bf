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
  static WasmFour load(const float* p) { return wasm_v128_load(p); }
  friend void store(float* p, WasmFour a) { wasm_v128_store(p, a.v); }
  friend WasmFour operator+(WasmFour a, WasmFour b) { return wasm_f32x4_add(a.v, b.v); }
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
