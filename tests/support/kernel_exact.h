// Every kernel on every instruction set against the scalar one, bit by bit over whole columns: what a kernel must not
// touch is compared like what it computes. One thing may differ: which NaN a NaN is, because the compiler may swap the
// operands of a sum. Two NaNs count as equal.
//
// A test in which a variant of this CPU did not run fails. On a CPU that has no wide variant all of them fail, unless
// the environment says by PSIM_SCALAR_CPU=1 that such a CPU is meant.
#pragma once

#include <array>
#include <cstdlib>
#include <iterator>

#include "kernel_support.h"

namespace psim::test::exact {

/// The wide variants that this CPU must run. The compiler's run-time library is asked, not psim, so that a fault in
/// psim's detection cannot leave a test empty.
inline std::vector<Isa> wide_isas() {
  std::vector<Isa> isas;
#if defined(__aarch64__)
  if (isa_lanes(Isa::neon) != 0) isas.push_back(Isa::neon);  // every aarch64 CPU has it
#elif defined(__x86_64__)
  if (isa_lanes(Isa::sse) != 0 && __builtin_cpu_supports("sse4.1")) isas.push_back(Isa::sse);
  if (isa_lanes(Isa::avx2) != 0 && __builtin_cpu_supports("avx2")) isas.push_back(Isa::avx2);
#endif
  if (isa_lanes(Isa::simd128) != 0) isas.push_back(Isa::simd128);  // without it the module would not have started
  return isas;
}

/// How often the present test asked for the kernels of each variant.
inline std::array<int, std::size(kAllIsas)> runs_of_variants{};

/// The kernels of a variant, to be run at once.
inline const KernelTable& wide_kernels(Isa isa) {
  ++runs_of_variants[static_cast<std::size_t>(isa)];
  return kernels_of(isa);
}

inline bool same_float(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (std::isnan(a) && std::isnan(b));
}

/// Index of the first difference, or the size.
inline std::size_t difference(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0) return a.size();
  std::size_t i = 0;
  while (i < a.size() && same_float(a[i], b[i])) ++i;
  return i;
}

/// All that a kernel can read or write, and what it returned.
struct State {
  Bodies b;
  Contacts c;
  std::vector<std::uint32_t> key;
  std::vector<std::int32_t> low_high;
  bool flag = false;
  float value = 0;
  double virial = 0;
};

template <class Columns>
bool same_columns(const Columns& a, const Columns& b, const char* isa) {
  const auto fa = a.floats(), fb = b.floats();
  for (std::size_t f = 0; f < fa.size(); ++f) {
    const std::size_t at = difference(*fa[f].second, *fb[f].second);
    if (at == fa[f].second->size()) continue;
    ADD_FAILURE() << isa << ": " << fa[f].first << "[" << at << "] = " << (*fb[f].second)[at] << ", scalar "
                  << (*fa[f].second)[at];
    return false;
  }
  return true;
}

inline bool same_state(const State& scalar, const State& wide, const char* isa) {
  EXPECT_EQ(scalar.b.pos, wide.b.pos) << isa;
  EXPECT_EQ(scalar.b.built, wide.b.built) << isa;
  EXPECT_EQ(scalar.b.linked, wide.b.linked) << isa;
  EXPECT_EQ(scalar.c.body, wide.c.body) << isa;
  EXPECT_EQ(scalar.key, wide.key) << isa;
  EXPECT_EQ(scalar.low_high, wide.low_high) << isa;
  EXPECT_EQ(scalar.flag, wide.flag) << isa;
  // Of a maximum, the sign of a zero may depend on the order.
  EXPECT_TRUE(scalar.value == wide.value || same_float(scalar.value, wide.value))
      << isa << ": returned " << wide.value << ", scalar " << scalar.value;
  EXPECT_TRUE(scalar.virial == wide.virial || (std::isnan(scalar.virial) && std::isnan(wide.virial)))
      << isa << ": virial " << wide.virial << ", scalar " << scalar.virial;
  return same_columns(scalar.b, wide.b, isa) && same_columns(scalar.c, wide.c, isa) && !::testing::Test::HasFailure();
}

/// Runs a kernel on copies of the state, one for each instruction set. Returns what scalar made.
template <class Run>
State compare(const State& initial, const Run& run) {
  State scalar = initial;
  run(kernels_of(Isa::scalar), scalar);
  for (const Isa isa : wide_isas()) {
    State wide = initial;
    run(wide_kernels(isa), wide);
    if (!same_state(scalar, wide, isa_name(isa).data())) break;
  }
  return scalar;
}

class KernelExact : public ::testing::Test {
 protected:
  void SetUp() override {
    runs_of_variants = {};
    if (!wide_isas().empty()) return;
    if (std::getenv("PSIM_SCALAR_CPU") != nullptr)
      GTEST_SKIP() << "this CPU has no wide variant, as PSIM_SCALAR_CPU says";
    FAIL() << "no wide variant is here to be compared; set PSIM_SCALAR_CPU=1 if that is intended";
  }
  void TearDown() override {
    if (IsSkipped() || HasFailure()) return;
    for (const Isa isa : wide_isas()) {
      EXPECT_GT(runs_of_variants[static_cast<std::size_t>(isa)], 0) << isa_name(isa) << " was not run";
    }
  }
};

}  // namespace psim::test::exact
