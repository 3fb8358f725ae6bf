#include "base/machine.h"

#include <thread>

#include "isa_list.h"

#if defined(__x86_64__) && !defined(PSIM_PORTABLE)
#include <cpuinfo_x86.h>
#include <immintrin.h>
#define PSIM_X86_64 1
#endif

namespace psim {

#ifdef PSIM_X86_64

namespace {

const cpu_features::X86Features& cpu() {
  static const cpu_features::X86Features features = cpu_features::GetX86Info().features;
  return features;
}

constexpr std::uint32_t kStepFloatSettings = 0x9FC0;  // a value of MXCSR

}  // namespace

bool cpu_has(kernels::CpuNeed need) {
  if (need == kernels::CpuNeed::nothing) return true;
  return (need == kernels::CpuNeed::avx2 ? cpu().avx2 : cpu().sse4_1) != 0;
}

void pause_briefly() { _mm_pause(); }

FloatSettings::FloatSettings() : before_(_mm_getcsr()) { _mm_setcsr(kStepFloatSettings); }
FloatSettings::~FloatSettings() { _mm_setcsr(before_); }

#else

/// A WebAssembly module with SIMD instructions only starts where they are there.
bool cpu_has(kernels::CpuNeed need) {
  const bool on_wasm = need == kernels::CpuNeed::simd128 && kernels::kIsWasm;
  return need == kernels::CpuNeed::nothing || on_wasm;
}

void pause_briefly() { std::this_thread::yield(); }

FloatSettings::FloatSettings() : before_(0) {}
FloatSettings::~FloatSettings() { (void)before_; }

#endif

}  // namespace psim
