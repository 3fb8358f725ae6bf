// Four floats that belong together, such as nodes beside each other, in plain C++: the definition of each operation.
// four_sse.h, four_neon.h and four_wasm.h have the same in one register.
#pragma once

namespace psim::kernels {
namespace {

struct ScalarFour {
  float v[4];

  ScalarFour() = default;
  ScalarFour(float all) : v{all, all, all, all} {}
  ScalarFour(float a, float b, float c, float d) : v{a, b, c, d} {}
  static ScalarFour load(const float* p) { return {p[0], p[1], p[2], p[3]}; }
  friend void store(float* p, ScalarFour a) {
    for (int k = 0; k < 4; ++k) p[k] = a.v[k];
  }
  friend ScalarFour operator+(ScalarFour a, ScalarFour b) {
    return {a.v[0] + b.v[0], a.v[1] + b.v[1], a.v[2] + b.v[2], a.v[3] + b.v[3]};
  }
  friend ScalarFour operator*(ScalarFour a, ScalarFour b) {
    return {a.v[0] * b.v[0], a.v[1] * b.v[1], a.v[2] * b.v[2], a.v[3] * b.v[3]};
  }
  /// (v0 + v1) + (v2 + v3) of each of four.
  friend ScalarFour sums(ScalarFour a, ScalarFour b, ScalarFour c, ScalarFour d) {
    const auto sum = [](const ScalarFour& f) { return (f.v[0] + f.v[1]) + (f.v[2] + f.v[3]); };
    return {sum(a), sum(b), sum(c), sum(d)};
  }
};

}  // namespace
}  // namespace psim::kernels
